//! Items that several ranks share, and the sums of their numbers over these ranks.
//!
//! ```text
//!              rank 0          rank 1
//!           |   ( 3 )        |           |     item 3 is on rank 0 alone: no message
//!           |              ( 5 )         |     item 5 is on both: each sends the other its part,
//!           |                |           |     and both add the parts in the order of the ranks
//! ```
//! Messages go between ranks that share something only, one to each and one back, all at once.

use crate::Result;
use crate::petsc::{Exchange, Session};

/// Items that this rank shares with others: the same pairs on both of any two ranks.
#[derive(Clone, Debug, Default)]
pub struct Sharing {
    rank: u32,
    /// The other ranks, each with an item of both, by rank and then by item.
    shared: Vec<(u32, u32)>,
    /// Where each shared item comes first.
    first: Vec<u32>,
}

/// Scratch of the messages, one for all sums.
#[derive(Debug, Default)]
pub struct Messages {
    mine: Vec<f64>,
    theirs: Vec<f64>,
    exchange: Exchange,
}

impl Messages {
    /// Room for the numbers that are sent, and for those that come.
    pub(crate) fn buffers(&mut self) -> (&mut Vec<f64>, &mut Vec<f64>) {
        (&mut self.mine, &mut self.theirs)
    }
}

impl Sharing {
    /// The sharing of a rank that shares nothing yet.
    pub fn new(rank: usize) -> Sharing {
        Sharing { rank: rank as u32, ..Sharing::default() }
    }

    /// The sharing of so many items, all of them on all ranks.
    pub fn among_all(session: &Session, items: usize) -> Sharing {
        let mut sharing = Sharing::new(session.rank());
        let others = (0..session.size()).filter(|rank| *rank != session.rank());
        sharing.set(others.flat_map(|rank| (0..items).map(move |item| (rank as u32, item as u32))));
        sharing
    }

    /// Takes the other ranks, each with an item of both, in any order.
    pub fn set(&mut self, shared: impl Iterator<Item = (u32, u32)>) {
        let own = &mut self.shared;
        own.clear();
        own.extend(shared);
        own.sort_unstable();
        own.dedup();
        self.first.clear();
        self.first.extend(0..own.len() as u32);
        self.first.sort_unstable_by_key(|place| (own[*place as usize].1, *place));
        self.first.dedup_by_key(|place| own[*place as usize].1);
    }

    /// The other ranks, each with an item of both, by rank and then by item.
    pub fn pairs(&self) -> &[(u32, u32)] {
        &self.shared
    }

    /// The other ranks among these, and how many items are shared with each.
    fn partners(&self) -> impl Iterator<Item = (usize, usize)> + Clone + '_ {
        let partners = self.shared.chunk_by(|a, b| a.0 == b.0);
        partners.map(|shared| (shared[0].0 as usize, shared.len()))
    }

    /// Sums the `width` numbers of each shared item over its ranks: `numbers_of` calls what it gets
    /// with all numbers of an item, always in the same order. Collective.
    ///
    /// # Errors
    /// When ranks cannot reach each other.
    pub fn sum(
        &self,
        session: &Session,
        messages: &mut Messages,
        width: usize,
        mut numbers_of: impl FnMut(usize, &mut dyn FnMut(&mut [f64])),
    ) -> Result<()> {
        if self.shared.is_empty() {
            return Ok(());
        }
        let Messages { mine, theirs, exchange } = messages;
        mine.clear();
        for &(_, item) in &self.shared {
            numbers_of(item as usize, &mut |part| mine.extend_from_slice(part));
        }
        theirs.clear();
        theirs.resize(mine.len(), 0.0);
        let partners = self.partners().map(|(rank, count)| (rank, width * count));
        session.exchange(partners, mine, theirs, exchange)?;
        for &(_, item) in &self.shared {
            numbers_of(item as usize, &mut |part| part.fill(0.0));
        }
        let before = self.shared.partition_point(|(rank, _)| *rank < self.rank);
        let mut add = |place: usize, numbers: &[f64]| {
            let mut numbers = numbers[width * place..].iter();
            numbers_of(self.shared[place].1 as usize, &mut |part| {
                part.iter_mut().zip(&mut numbers).for_each(|(n, m)| *n += m);
            });
        };
        (0..before).for_each(|place| add(place, theirs));
        self.first.iter().for_each(|place| add(*place as usize, mine));
        (before..self.shared.len()).for_each(|place| add(place, theirs));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_items_are_listed_by_rank_and_once_each() {
        let mut sharing = Sharing::new(1);
        sharing.set([(2, 2), (0, 2), (0, 0), (2, 2)].into_iter());
        assert_eq!(sharing.pairs(), [(0, 0), (0, 2), (2, 2)]);
        assert_eq!(sharing.partners().collect::<Vec<_>>(), [(0, 2), (2, 1)]);
        assert_eq!(sharing.first, [0, 1]);
    }
}
