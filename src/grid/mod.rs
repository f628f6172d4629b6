//! The grid: equal cells, fields with ghost layers, and the conditions at the sides of the box.
//!
//! A field is a plain `Vec<f64>` over the stored box of a rank, x fastest, with layers of ghosts on
//! every side ([`GHOSTS`], or more):
//!
//! ```text
//!            face i     face i+1
//!   --+---------|----------|---------+--
//!     |  i - 1  |    i     |  i + 1  |      cell i lies between its faces i (low) and i + 1 (high)
//!   --+---------|----------|---------+--
//! ```
//! A face field along an axis is stored alike: entry `i` is the low face of cell `i`.

mod boundary;
mod division;
mod ghosts;
mod simd;

pub use boundary::{Boundaries, BoundaryKind};
pub use division::Division;
pub use simd::{largest, simd, total};

use crate::petsc::Layout;
use std::ops::Range;

/// Layers of ghost cells around every rank's box that the fifth-order stencils reach.
pub const GHOSTS: usize = 3;

/// A vector field: one scalar field an axis.
pub type VectorField<const D: usize> = [Vec<f64>; D];

/// The part of a uniform Cartesian grid that one rank stores.
#[derive(Clone, Debug)]
pub struct Grid<const D: usize> {
    /// Cells of the whole grid along each axis.
    pub cells: [usize; D],
    /// Edge lengths of the box (m).
    pub size: [f64; D],
    /// Spacing along each axis (m).
    pub h: [f64; D],
    /// Axes whose two ends are joined.
    pub periodic: [bool; D],
    /// First owned cell along each axis.
    pub start: [usize; D],
    /// Owned cells along each axis.
    pub local: [usize; D],
    /// Stored cells along each axis, ghosts included.
    pub stored: [usize; D],
    /// Layers of ghost cells on every side.
    pub ghosts: usize,
    /// Distance in a field between neighbours along each axis.
    pub stride: [usize; D],
    /// Which rank owns which cells.
    pub division: Division<D>,
}

impl<const D: usize> Grid<D> {
    /// The grid of `cells` over `size` (m), as `layout` splits it.
    pub fn new(cells: [usize; D], size: [f64; D], periodic: [bool; D], layout: &Layout) -> Grid<D> {
        let stored: [usize; D] = std::array::from_fn(|a| layout.stored[a]);
        Grid {
            cells,
            size,
            h: std::array::from_fn(|a| size[a] / cells[a] as f64),
            periodic,
            start: std::array::from_fn(|a| layout.start[a]),
            local: std::array::from_fn(|a| layout.local[a]),
            stored,
            ghosts: layout.ghosts,
            stride: std::array::from_fn(|a| stored[..a].iter().product()),
            division: Division { cells, ranks: std::array::from_fn(|a| layout.ranks[a]) },
        }
    }

    /// A scalar field of zeros.
    pub fn field(&self) -> Vec<f64> {
        vec![0.0; self.stored.iter().product()]
    }

    /// A vector field of zeros.
    pub fn vector_field(&self) -> VectorField<D> {
        std::array::from_fn(|_| self.field())
    }

    /// Cells of the whole grid.
    pub fn total_cells(&self) -> usize {
        self.cells.iter().product()
    }

    /// Volume of a cell (m3; m2 per unit depth in 2D).
    pub fn cell_volume(&self) -> f64 {
        self.h.iter().product()
    }

    /// Whether this rank's box ends at the low (`side` 0) or high (1) face of the domain, and that
    /// face is not periodic.
    pub fn at_boundary(&self, axis: usize, side: usize) -> bool {
        let end = self.start[axis] + self.local[axis];
        !self.periodic[axis]
            && if side == 0 { self.start[axis] == 0 } else { end == self.cells[axis] }
    }

    /// Where a cell or face lies along an axis among the stored ones, by its index in a field.
    pub fn place_of(&self, axis: usize, index: usize) -> usize {
        index / self.stride[axis] % self.stored[axis]
    }

    /// The owned cells, as contiguous runs of a field's indices.
    pub fn rows(&self) -> Rows<D> {
        Rows::new(self, self.local)
    }

    /// The low faces of the owned cells along `axis`, and the high faces of the last ones.
    pub fn face_rows(&self, axis: usize) -> Rows<D> {
        let mut extent = self.local;
        extent[axis] += 1;
        Rows::new(self, extent)
    }

    /// The owned cells beside the low (`side` 0) or high (1) side of the box along `axis`; none
    /// where that face is periodic, or another rank's.
    pub fn boundary_cells(&self, axis: usize, side: usize) -> impl Iterator<Item = usize> {
        let mut extent = self.local;
        extent[axis] = 1;
        let offset = side * (self.local[axis] - 1) * self.stride[axis];
        let here = self.at_boundary(axis, side);
        here.then(|| Rows::new(self, extent))
            .into_iter()
            .flatten()
            .flatten()
            .map(move |cell| cell + offset)
    }

    /// A field's index of `cell`, in the whole grid's count, if this rank owns it.
    pub fn owned_index(&self, cell: [usize; D]) -> Option<usize> {
        let owned =
            (0..D).all(|a| (self.start[a]..self.start[a] + self.local[a]).contains(&cell[a]));
        owned
            .then(|| (0..D).map(|a| (cell[a] - self.start[a] + self.ghosts) * self.stride[a]).sum())
    }

    /// Whether a point (m) lies in a cell of this rank; points beyond the box belong to its
    /// outermost cells.
    pub fn owns(&self, point: &nalgebra::Vector3<f64>) -> bool {
        (0..D).all(|a| {
            let cell = (point[a] / self.h[a]).floor();
            let cell =
                if self.periodic[a] { cell } else { cell.clamp(0.0, self.cells[a] as f64 - 1.0) };
            cell >= self.start[a] as f64 && cell < (self.start[a] + self.local[a]) as f64
        })
    }

    /// Where the stored position nearest to a point (m) stands among those of a side of the box
    /// normal to `axis`: the first other axis fastest, as [`BoundaryKind::Velocity`] stores them.
    pub fn position_on_boundary(&self, axis: usize, point: &nalgebra::Vector3<f64>) -> usize {
        let mut at = 0;
        let mut stride = 1;
        for a in (0..D).filter(|&a| a != axis) {
            let cell = (point[a] / self.h[a]).floor() - self.start[a] as f64 + self.ghosts as f64;
            at += stride * cell.clamp(0.0, self.stored[a] as f64 - 1.0) as usize;
            stride *= self.stored[a];
        }
        at
    }

    /// The cell, in the whole grid's count, at a field's index of an owned cell.
    pub fn global_cell(&self, index: usize) -> [usize; D] {
        std::array::from_fn(|a| {
            index / self.stride[a] % self.stored[a] - self.ghosts + self.start[a]
        })
    }

    /// Centre of the cell at a field's index (m).
    pub fn centre(&self, index: usize) -> [f64; D] {
        std::array::from_fn(|a| {
            let i = (index / self.stride[a] % self.stored[a]) as f64 - self.ghosts as f64
                + self.start[a] as f64;
            (i + 0.5) * self.h[a]
        })
    }
}

/// Contiguous runs of a field's indices.
pub struct Rows<const D: usize> {
    extent: [usize; D],
    stride: [usize; D],
    ghosts: usize,
    next: usize,
    count: usize,
}

impl<const D: usize> Rows<D> {
    fn new(grid: &Grid<D>, extent: [usize; D]) -> Rows<D> {
        Rows {
            extent,
            stride: grid.stride,
            ghosts: grid.ghosts,
            next: 0,
            count: extent[1..].iter().product(),
        }
    }
}

impl<const D: usize> Iterator for Rows<D> {
    type Item = Range<usize>;

    fn next(&mut self) -> Option<Range<usize>> {
        if self.next == self.count {
            return None;
        }
        let mut rest = self.next;
        let mut at = self.ghosts;
        for a in 1..D {
            at += (rest % self.extent[a] + self.ghosts) * self.stride[a];
            rest /= self.extent[a];
        }
        self.next += 1;
        Some(at..at + self.extent[0])
    }
}

/// A property that is one number, or one number a cell.
#[derive(Clone, Debug)]
pub enum Coefficient {
    /// One value everywhere.
    Uniform(f64),
    /// A field.
    Field(Vec<f64>),
}

impl Coefficient {
    /// The value at a field's index.
    pub fn at(&self, index: usize) -> f64 {
        match self {
            Coefficient::Uniform(value) => *value,
            Coefficient::Field(field) => field[index],
        }
    }
}
