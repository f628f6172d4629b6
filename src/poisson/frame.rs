//! The way from the indices of a field, with its own layers of ghosts, to the cells and faces of a
//! [`Lattice`].

use super::lattice::Lattice;
use crate::grid::Grid;
use crate::petsc::Layout;

/// Map from the fields of a grid to this rank's lattice.
pub(super) struct Frame {
    pub lattice: Lattice,
    /// Strides, stored cells and layers of ghosts of a field.
    pub stride: [usize; 3],
    pub stored: [usize; 3],
    ghosts: usize,
}

impl Frame {
    /// The frame of a grid's fields.
    pub fn new<const D: usize>(lattice: Lattice, layout: &Layout, grid: &Grid<D>) -> Frame {
        Frame {
            lattice,
            stride: std::array::from_fn(|a| grid.stride.get(a).copied().unwrap_or(1)),
            stored: layout.stored,
            ghosts: layout.ghosts,
        }
    }

    /// Where the face at a field's index, across an axis, lies on the lattice, counted along each
    /// axis from its layer of ghosts; `None` beyond the faces of its cells.
    pub fn on_lattice(&self, face: u32, across: usize) -> Option<[usize; 3]> {
        let Lattice { n, axes, .. } = self.lattice;
        let index = |a: usize| (face / self.stride[a] as u32 % self.stored[a] as u32) as usize;
        // -1 and below stand beyond the layer of ghosts.
        let at = std::array::from_fn(|a| match a < axes {
            true => (index(a) + 1).wrapping_sub(self.ghosts),
            false => 0,
        });
        let last = |a: usize| n[a] + usize::from(a == across);
        (0..axes).all(|a| (1..=last(a)).contains(&at[a])).then_some(at)
    }

    /// The number, among this rank's, of the cell at a field's index; `None` of a ghost.
    pub fn number(&self, index: usize) -> Option<u32> {
        let Lattice { n, axes, .. } = self.lattice;
        let mut row = 0;
        for a in (0..axes).rev() {
            let at = (index / self.stride[a] % self.stored[a])
                .checked_sub(self.ghosts)
                .filter(|at| *at < n[a])?;
            row = at + n[a] * row;
        }
        Some(row as u32)
    }
}
