//! Sums over the ranks of what each has of every body: a struct with names for its numbers, not a
//! row of them by position.
//!
//! ```text
//!              rank 0          rank 1
//!           |   ( 3 )        |           |     body 3 reaches rank 0 alone: no message
//!           |              ( 5 )         |     body 5 reaches both: each sends the other its part,
//!           |                |           |     and both add the parts in the order of the ranks
//! ```
//! [`Reach`] says which bodies reach which ranks. Who needs the sums of all bodies on all ranks
//! gets them from the owners, the ranks of the bodies' centres.

use crate::Result;
use crate::petsc::Session;
use crate::reach::Reach;
use nalgebra::Vector3;

/// Numbers that ranks sum.
pub trait Summed {
    /// Calls `take` with all of them, always in the same order.
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64]));
}

impl Summed for Vector3<f64> {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        take(self.as_mut_slice());
    }
}

/// A value per body, summed over the ranks.
#[derive(Debug)]
pub struct BodySums<T> {
    values: Vec<T>,
}

/// Scratch of the messages, one for all sums.
#[derive(Debug, Default)]
pub struct Messages {
    partners: Vec<(usize, usize)>,
    mine: Vec<f64>,
    theirs: Vec<f64>,
    counts: Vec<i32>,
    starts: Vec<i32>,
}

impl<T: Summed + Clone + Default> BodySums<T> {
    /// Room for so many bodies.
    pub fn with_capacity(n: usize) -> BodySums<T> {
        BodySums { values: Vec::with_capacity(n) }
    }

    /// Sums what `own` gives of each body that reaches this rank, over the ranks that it reaches;
    /// nothing of other bodies. Collective.
    ///
    /// # Errors
    /// When ranks cannot reach each other.
    pub fn sum_here(
        &mut self,
        session: &Session,
        reach: &Reach,
        messages: &mut Messages,
        own: impl FnMut(usize) -> T,
    ) -> Result<&mut [T]> {
        self.take(reach, own);
        if session.size() > 1 {
            self.add_parts(session, reach, messages)?;
        }
        Ok(&mut self.values)
    }

    /// The same; all ranks get the sums of all bodies. Collective.
    ///
    /// # Errors
    /// When ranks cannot reach each other.
    pub fn sum_for_all(
        &mut self,
        session: &Session,
        reach: &Reach,
        messages: &mut Messages,
        own: impl FnMut(usize) -> T,
    ) -> Result<&mut [T]> {
        self.sum_here(session, reach, messages, own)?;
        self.hand_out(session, reach, messages)
    }

    /// Gives all ranks what `own` gives on the owner of each body. Collective.
    ///
    /// # Errors
    /// When ranks cannot reach each other.
    pub fn tell_all(
        &mut self,
        session: &Session,
        reach: &Reach,
        messages: &mut Messages,
        own: impl FnMut(usize) -> T,
    ) -> Result<&mut [T]> {
        self.take(reach, own);
        self.hand_out(session, reach, messages)
    }

    fn take(&mut self, reach: &Reach, mut own: impl FnMut(usize) -> T) {
        self.values.clear();
        self.values.resize(reach.bodies(), T::default());
        for k in reach.here() {
            self.values[k] = own(k);
        }
    }

    /// Adds the parts of the other ranks, in the order of the ranks.
    fn add_parts(
        &mut self,
        session: &Session,
        reach: &Reach,
        messages: &mut Messages,
    ) -> Result<()> {
        let values = &mut self.values;
        let Messages { partners, mine, theirs, .. } = messages;
        let width = width::<T>();
        mine.clear();
        for &(_, k) in reach.shared() {
            values[k as usize].each(&mut |part| mine.extend_from_slice(part));
        }
        theirs.clear();
        theirs.resize(mine.len(), 0.0);
        partners.clear();
        partners.extend(reach.partners().map(|(rank, count)| (rank, width * count)));
        swap_parts(session, partners, mine, theirs)?;
        for &(_, k) in reach.shared() {
            values[k as usize].each(&mut |part| part.fill(0.0));
        }
        let me = session.rank();
        let before = reach.shared().partition_point(|(rank, _)| (*rank as usize) < me);
        let mut add = |place: usize, numbers: &[f64]| {
            let mut numbers = numbers[width * place..].iter();
            values[reach.shared()[place].1 as usize]
                .each(&mut |part| part.iter_mut().zip(&mut numbers).for_each(|(n, m)| *n += m));
        };
        (0..before).for_each(|place| add(place, theirs));
        reach.own_parts().for_each(|place| add(place, mine));
        (before..reach.shared().len()).for_each(|place| add(place, theirs));
        Ok(())
    }

    /// Gives all ranks the owners' values.
    fn hand_out(
        &mut self,
        session: &Session,
        reach: &Reach,
        messages: &mut Messages,
    ) -> Result<&mut [T]> {
        let values = &mut self.values;
        let Messages { mine, theirs, counts, starts, .. } = messages;
        if session.size() > 1 {
            let width = width::<T>();
            mine.clear();
            for k in reach.owned_by(session.rank()) {
                values[k].each(&mut |part| mine.extend_from_slice(part));
            }
            counts.clear();
            starts.clear();
            let mut total = 0;
            for rank in 0..session.size() {
                let count = width * reach.owned_by(rank).len();
                counts.push(count as i32);
                starts.push(total as i32);
                total += count;
            }
            theirs.clear();
            theirs.resize(total, 0.0);
            session.all_gather(mine, theirs, counts, starts)?;
            let mut numbers = theirs.iter();
            for k in (0..session.size()).flat_map(|rank| reach.owned_by(rank)) {
                values[k].each(&mut |part| part.iter_mut().zip(&mut numbers).for_each(set));
            }
        }
        Ok(values)
    }
}

/// Swaps numbers with other ranks: to and from each of the `partners`, by rank, as many as said,
/// one partner's after the other's in `mine` and in `theirs`.
fn swap_parts(
    session: &Session,
    partners: &[(usize, usize)],
    mine: &[f64],
    theirs: &mut [f64],
) -> Result<()> {
    let (me, ranks) = (session.rank(), session.size());
    let part = |rank: usize| {
        let place = partners.iter().position(|(partner, _)| *partner == rank)?;
        let begin: usize = partners[..place].iter().map(|(_, count)| count).sum();
        Some((rank, begin..begin + partners[place].1))
    };
    // In rounds in which each rank sends so many ranks up: no two wait for each other.
    for way in 1..ranks {
        let (to, out) = part((me + way) % ranks).map_or((None, 0..0), |(to, out)| (Some(to), out));
        let (from, into) = part((me + ranks - way) % ranks)
            .map_or((None, 0..0), |(from, into)| (Some(from), into));
        session.swap(&mine[out], to, &mut theirs[into], from)?;
    }
    Ok(())
}

fn set((to, from): (&mut f64, &f64)) {
    *to = *from;
}

/// How many numbers a value has.
fn width<T: Summed + Default>() -> usize {
    let mut width = 0;
    T::default().each(&mut |part| width += part.len());
    width
}
