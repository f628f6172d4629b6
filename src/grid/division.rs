//! Which rank owns which cells: boxes side by side, as PETSc's DMDA cuts them, x fastest.
//!
//! ```text
//!   10 cells on 3 ranks      | 0 1 2 3 | 4 5 6 | 7 8 9 |      the first ones have the cells that
//!                              rank 0    rank 1  rank 2        are left over
//! ```

/// Division of a grid's cells over the ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Division<const D: usize> {
    /// Cells of the whole grid along each axis.
    pub cells: [usize; D],
    /// Ranks along each axis.
    pub ranks: [usize; D],
}

impl<const D: usize> Division<D> {
    /// The rank that owns a cell of the grid.
    pub fn owner(&self, cell: [usize; D]) -> usize {
        self.rank(std::array::from_fn(|a| self.part(a, cell[a])))
    }

    /// Calls `take` with all ranks, ascending, that own cells of the block from `first` to `last`,
    /// both included.
    pub fn owners(&self, first: [usize; D], last: [usize; D], mut take: impl FnMut(usize)) {
        let low: [usize; D] = std::array::from_fn(|a| self.part(a, first[a]));
        let high: [usize; D] = std::array::from_fn(|a| self.part(a, last[a]));
        let mut at = low;
        loop {
            take(self.rank(at));
            let Some(a) = (0..D).find(|&a| at[a] < high[a]) else { return };
            at[a] += 1;
            at[..a].copy_from_slice(&low[..a]);
        }
    }

    /// Which of the ranks along an axis owns a cell.
    fn part(&self, axis: usize, cell: usize) -> usize {
        let each = self.cells[axis] / self.ranks[axis];
        let more = self.cells[axis] % self.ranks[axis];
        let longer = more * (each + 1);
        if cell < longer { cell / (each + 1) } else { more + (cell - longer) / each }
    }

    /// Work of the heaviest rank over the mean of all ranks. A cell is a work of 1, and bodies add
    /// theirs at the cell of their centre.
    pub fn imbalance(&self, bodies: impl Iterator<Item = ([usize; D], f64)>) -> f64 {
        let count: usize = self.ranks.iter().product();
        let mut work: Vec<f64> = (0..count).map(|rank| self.owned(rank) as f64).collect();
        for (cell, more) in bodies {
            work[self.owner(cell)] += more;
        }
        let mean = work.iter().sum::<f64>() / count as f64;
        work.into_iter().fold(0.0, f64::max) / mean
    }

    /// Number of cells that a rank owns.
    fn owned(&self, rank: usize) -> usize {
        let mut left = rank;
        let along = |a: usize| {
            let part = left % self.ranks[a];
            left /= self.ranks[a];
            self.cells[a] / self.ranks[a] + usize::from(part < self.cells[a] % self.ranks[a])
        };
        (0..D).map(along).product()
    }

    fn rank(&self, at: [usize; D]) -> usize {
        (0..D).rev().fold(0, |rank, a| rank * self.ranks[a] + at[a])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_left_over_go_to_first_ranks() {
        let division = Division { cells: [10, 4], ranks: [3, 2] };
        let row: Vec<usize> = (0..10).map(|x| division.owner([x, 0])).collect();
        assert_eq!(row, [0, 0, 0, 0, 1, 1, 1, 2, 2, 2]);
        assert_eq!([division.owner([9, 1]), division.owner([0, 2])], [2, 3]);
        let mut owners = Vec::new();
        division.owners([5, 1], [8, 2], |rank| owners.push(rank));
        assert_eq!(owners, [1, 2, 4, 5]);
    }

    #[test]
    fn imbalance_counts_cells_and_bodies_of_the_heaviest_rank() {
        let division = Division { cells: [10, 4], ranks: [3, 2] };
        // 8, 6, 6 cells below and above.
        assert!((division.imbalance(std::iter::empty()) - 8.0 / (40.0 / 6.0)).abs() < 1e-12);
        let body = std::iter::once(([9, 3], 14.0));
        assert!((division.imbalance(body) - 20.0 / 9.0).abs() < 1e-12);
    }
}
