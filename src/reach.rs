//! Ranks that bodies reach. Every rank finds them from the places of the bodies, and all find the
//! same: nobody has to be told.

use crate::geometry::{Block, images};
use crate::grid::Grid;
use crate::particles::Body;
use crate::sharing::Sharing;
use nalgebra::Vector3;
use std::ops::Range;

/// The bodies that reach this rank's cells, whom it shares them with, and who owns each: the rank
/// of its centre.
#[derive(Clone, Debug, Default)]
pub struct BodyRanks {
    rank: u32,
    /// The bodies that reach this rank, ascending.
    here: Vec<u32>,
    /// The ones among these that reach other ranks.
    sharing: Sharing,
    /// Scratch: these with each rank that they reach.
    shared: Vec<(u32, u32)>,
    /// Per body, its owner.
    owner: Vec<u32>,
    /// All bodies by their owners, and where each owner's begin.
    by_owner: Vec<u32>,
    begin: Vec<u32>,
}

impl BodyRanks {
    /// The reach of so many bodies on one of so many ranks: all are here until it is found.
    pub fn new(rank: usize, ranks: usize, bodies: usize) -> BodyRanks {
        let all: Vec<u32> = (0..bodies as u32).collect();
        let begin = (0..=ranks).map(|r| if r > rank { bodies as u32 } else { 0 }).collect();
        let owner = vec![rank as u32; bodies];
        let sharing = Sharing::new(rank);
        let shared = Vec::new();
        let rank = rank as u32;
        let here = all.clone();
        BodyRanks { rank, here, sharing, shared, owner, by_owner: all, begin }
    }

    /// Finds the reach anew; `extent` gives how far from a body's centre, along each axis, a rank
    /// can have something of the body (m). On one rank all stay here.
    pub fn find<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        bodies: &[Body],
        extent: impl Fn(usize) -> Vector3<f64>,
    ) {
        if self.is_alone() {
            return;
        }
        self.take(|k, take| {
            let centre = &bodies[k].centre;
            for image in images(grid, bodies[k].shape(), centre) {
                if let Some((first, last)) = Block::of_all(grid, &image, &extent(k)).ends() {
                    grid.division.owners(first, last, &mut *take);
                }
            }
            let cell = |a: usize| (centre[a] / grid.h[a]).max(0.0) as usize;
            grid.division.owner(std::array::from_fn(|a| cell(a).min(grid.cells[a] - 1)))
        });
    }

    /// `ranks_of` gives the owner of a body, and calls what it gets with each rank that the body
    /// reaches.
    fn take(&mut self, mut ranks_of: impl FnMut(usize, &mut dyn FnMut(usize)) -> usize) {
        let BodyRanks { rank, here, sharing, shared, owner, by_owner, begin } = self;
        here.clear();
        shared.clear();
        begin.fill(0);
        for (k, owner) in owner.iter_mut().enumerate() {
            let at = shared.len();
            let mut reached = false;
            *owner = ranks_of(k, &mut |other| {
                let other = other as u32;
                reached |= other == *rank;
                if other != *rank && !shared[at..].contains(&(other, k as u32)) {
                    shared.push((other, k as u32));
                }
            }) as u32;
            if reached {
                here.push(k as u32);
            } else {
                shared.truncate(at);
            }
            begin[*owner as usize + 1] += 1;
        }
        sharing.set(shared.iter().copied());
        for r in 1..begin.len() {
            begin[r] += begin[r - 1];
        }
        for (k, owner) in owner.iter().enumerate() {
            let place = &mut begin[*owner as usize];
            by_owner[*place as usize] = k as u32;
            *place += 1;
        }
        // Filling has moved each beginning to its end.
        begin.rotate_right(1);
        begin[0] = 0;
    }

    /// Whether there is no other rank.
    pub fn is_alone(&self) -> bool {
        self.begin.len() == 2
    }

    /// Number of bodies on all ranks.
    pub fn bodies(&self) -> usize {
        self.owner.len()
    }

    /// The bodies that reach this rank, ascending.
    pub fn here(&self) -> impl ExactSizeIterator<Item = usize> + Clone + '_ {
        self.here.iter().map(|k| *k as usize)
    }

    /// The bodies that this rank shares with others.
    pub fn sharing(&self) -> &Sharing {
        &self.sharing
    }

    /// The bodies that a rank owns, ascending.
    pub fn owned_by(&self, rank: usize) -> impl ExactSizeIterator<Item = usize> + '_ {
        let Range { start, end } = self.begin[rank]..self.begin[rank + 1];
        self.by_owner[start as usize..end as usize].iter().map(|k| *k as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reach_lists_shared_bodies_by_rank_and_owner() {
        // Ranks 0, 1, 2; this is 1. Body 0 on 0 and 1, 1 on 2 alone, 2 on all, 3 here alone.
        let bodies: [&[usize]; 4] = [&[0, 1], &[2], &[2, 0, 1, 0], &[1]];
        let mut reach = BodyRanks::new(1, 3, 4);
        assert_eq!(reach.here().collect::<Vec<_>>(), [0, 1, 2, 3]);
        reach.take(|k, take| {
            bodies[k].iter().for_each(|rank| take(*rank));
            bodies[k][0]
        });
        assert_eq!(reach.here().collect::<Vec<_>>(), [0, 2, 3]);
        assert_eq!(reach.sharing().pairs(), [(0, 0), (0, 2), (2, 2)]);
        let owned = |rank| reach.owned_by(rank).collect::<Vec<_>>();
        assert_eq!([owned(0), owned(1), owned(2)], [vec![0], vec![3], vec![1, 2]]);
    }
}
