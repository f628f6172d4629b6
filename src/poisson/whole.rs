//! The whole grid of a level of the multigrid, and the next coarser one.

use crate::Result;
use crate::grid::Grid;
use crate::petsc::{Layout, Session};

/// Cells wider than the narrowest by this are left as they are until the others are as wide.
const ANISOTROPY: f64 = 1.5;

/// The whole grid of a level: the widths of its cells, in units of the caller's, by axis, rank
/// along it and cell.
#[derive(Clone, Debug)]
pub(super) struct Whole {
    pub widths: [Vec<Vec<f64>>; 3],
    /// This rank's place along each axis.
    pub at: [usize; 3],
    pub periodic: [bool; 3],
    pub neighbours: [[Option<usize>; 2]; 3],
    pub axes: usize,
    /// Ranks along each axis, numbered like cells, x fastest; and the distance in ranks between
    /// those that have boxes of this level.
    ranks: [usize; 3],
    apart: [usize; 3],
}

impl Whole {
    /// Division of the grid into ranks' boxes, cell widths in units of the narrowest. Collective.
    pub fn of_grid<const D: usize>(
        session: &Session,
        layout: &Layout,
        grid: &Grid<D>,
    ) -> Result<Whole> {
        let narrowest = grid.h.iter().copied().fold(f64::INFINITY, f64::min);
        let mut whole = Whole {
            widths: std::array::from_fn(|_| vec![vec![1.0]]),
            at: [0; 3],
            periodic: std::array::from_fn(|a| a < D && grid.periodic[a]),
            neighbours: layout.neighbours,
            axes: D,
            ranks: [1; 3],
            apart: [1; 3],
        };
        for axis in 0..D {
            // A box begins where any rank's does.
            let mut begins = vec![0.0; grid.cells[axis] + 1];
            begins[grid.start[axis]] = 1.0;
            begins[grid.cells[axis]] = 1.0;
            session.sum(&mut begins)?;
            let cuts: Vec<usize> = (0..begins.len()).filter(|i| begins[*i] > 0.0).collect();
            let wide = grid.h[axis] / narrowest;
            whole.widths[axis] = cuts.windows(2).map(|cut| vec![wide; cut[1] - cut[0]]).collect();
            whole.ranks[axis] = whole.widths[axis].len();
            whole.at[axis] = cuts.iter().position(|cut| *cut == grid.start[axis]).unwrap_or(0);
        }
        Ok(whole)
    }

    /// This rank's cells along each axis.
    pub fn local(&self) -> [usize; 3] {
        std::array::from_fn(|a| self.widths[a][self.at[a]].len())
    }

    pub fn cells(&self) -> usize {
        (0..3).map(|a| self.total(a)).product()
    }

    fn total(&self, axis: usize) -> usize {
        self.widths[axis].iter().map(Vec::len).sum()
    }

    /// Distances of cell centres across this rank's faces along an axis; half a cell at a boundary.
    pub fn distances(&self, axis: usize) -> Vec<f64> {
        let all: Vec<f64> = self.widths[axis].concat();
        let start: usize = self.widths[axis][..self.at[axis]].iter().map(Vec::len).sum();
        let wide = |i: Option<usize>, round: usize| match i.filter(|i| *i < all.len()) {
            Some(i) => all[i],
            None if self.periodic[axis] => all[round],
            None => 0.0,
        };
        let distance = |f: usize| 0.5 * (wide(f.checked_sub(1), all.len() - 1) + wide(Some(f), 0));
        (start..=start + self.local()[axis]).map(distance).collect()
    }

    /// Cells that make one of the next level along each axis: 1 or 2.
    pub fn factor(&self) -> [usize; 3] {
        let mean = |a: usize| self.widths[a].iter().flatten().sum::<f64>() / self.total(a) as f64;
        let divided = |a: &usize| *a < self.axes && self.total(*a) > self.widths[*a].len();
        let narrowest = (0..3).filter(divided).map(mean).fold(f64::INFINITY, f64::min);
        std::array::from_fn(|a| if divided(&a) && mean(a) < ANISOTROPY * narrowest { 2 } else { 1 })
    }

    /// The grid with `factor` cells along each axis made one.
    pub fn coarser(&self, factor: [usize; 3]) -> Whole {
        let sums = |part: &Vec<f64>, f: usize| part.chunks(f).map(|c| c.iter().sum()).collect();
        let widths = std::array::from_fn(|a| {
            self.widths[a].iter().map(|part| sums(part, factor[a])).collect()
        });
        Whole { widths, ..self.clone() }
    }

    /// Boxes along each axis.
    pub fn parts(&self) -> [usize; 3] {
        std::array::from_fn(|a| self.widths[a].len())
    }

    /// Cells along an axis.
    pub fn cells_along(&self, axis: usize) -> usize {
        self.total(axis)
    }

    /// The rank that has the box of this place.
    pub fn rank_of(&self, at: [usize; 3]) -> usize {
        let [x, y, z] = std::array::from_fn(|a| at[a] * self.apart[a]);
        x + self.ranks[0] * (y + self.ranks[1] * z)
    }

    /// The grid with `by` boxes along each axis made one, which the first one's rank has.
    pub fn merged(&self, by: [usize; 3]) -> Whole {
        let widths: [Vec<Vec<f64>>; 3] = std::array::from_fn(|a| {
            self.widths[a].chunks(by[a]).map(|parts| parts.concat()).collect()
        });
        let mut merged = Whole {
            at: std::array::from_fn(|a| self.at[a] / by[a]),
            apart: std::array::from_fn(|a| self.apart[a] * by[a]),
            widths,
            ..*self
        };
        merged.neighbours = std::array::from_fn(|a| {
            [-1, 1].map(|side| {
                let n = merged.widths[a].len() as isize;
                let to = merged.at[a] as isize + side;
                let to = if merged.periodic[a] { to.rem_euclid(n) } else { to };
                let mut at = merged.at;
                at[a] = (0..n).contains(&to).then_some(to as usize)?;
                (a < merged.axes).then(|| merged.rank_of(at))
            })
        });
        merged
    }
}
