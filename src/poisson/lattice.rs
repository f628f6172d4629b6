//! One box of cells and the faces between them, as every level of the multigrid has one.
//!
//! ```text
//!              g[1][c + s_y]
//!            +-------+               (A x)_c = sum over the faces f of c:  g_f (x_c - x_beyond f)
//!   g[0][c]  |   c   |  g[0][c + 1]
//!            +-------+               closed face: g = 0;
//!              pressure given on the face: x = 0 in the ghost beyond it
//!              g[1][c]
//! ```
//! One layer of ghosts on every side of every axis in use, x fastest. The boundary conditions are
//! in `g` alone.

use crate::Result;
use crate::petsc::{Halo, Layout, Number, Session};
use std::ops::{Add, Mul, Sub};

/// A number of the kernels: in single precision for the multigrid, in double for the operator.
pub(super) trait Real:
    Number + Default + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
}

impl Real for f32 {}

impl Real for f64 {}

/// Layout of a box of cells in memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    /// Cells along each axis (1 along z in 2D).
    pub n: [usize; 3],
    /// Axes in use: two or three.
    pub axes: usize,
    /// Distance in memory from a cell to the next along each axis.
    pub stride: [usize; 3],
    /// The first cell.
    pub first: usize,
    /// Numbers in a field, ghosts included.
    pub len: usize,
}

impl Lattice {
    pub fn new(n: [usize; 3], axes: usize) -> Lattice {
        let stored: [usize; 3] = std::array::from_fn(|a| if a < axes { n[a] + 2 } else { 1 });
        let stride = [1, stored[0], stored[0] * stored[1]];
        Lattice {
            n,
            axes,
            stride,
            first: stride[..axes].iter().sum(),
            len: stored.iter().product(),
        }
    }

    /// The first cell of a row.
    #[inline(always)]
    pub fn row(&self, j: usize, k: usize) -> usize {
        self.first + j * self.stride[1] + k * self.stride[2]
    }

    /// The first cells of all rows, y before z.
    pub fn rows(self) -> impl Iterator<Item = usize> {
        (0..self.n[2]).flat_map(move |k| (0..self.n[1]).map(move |j| self.row(j, k)))
    }

    /// Index of a place along an axis, counted from its layer of ghosts.
    #[inline(always)]
    pub fn along(&self, place: usize, axis: usize) -> usize {
        // Places are numbers of 32 bits, whose quotients are found sooner.
        (place as u32 / self.stride[axis] as u32 % (self.n[axis] as u32 + 2)) as usize
    }

    /// A field of zeros.
    pub fn field<T: Real>(&self) -> Vec<T> {
        vec![T::default(); self.len]
    }

    /// A face field of zeros: one field an axis in use.
    pub fn faces<T: Real>(&self) -> [Vec<T>; 3] {
        std::array::from_fn(|a| if a < self.axes { self.field() } else { Vec::new() })
    }

    /// The exchange of the layer of ghosts with `neighbours`.
    pub fn halo<T: Real>(&self, session: &Session, neighbours: [[Option<usize>; 2]; 3]) -> Halo<T> {
        let stored = std::array::from_fn(|a| if a < self.axes { self.n[a] + 2 } else { 1 });
        let none = Vec::new();
        let whole = Vec::new();
        let layout = Layout {
            start: [0; 3],
            local: self.n,
            stored,
            ghosts: 1,
            ranks: [1; 3],
            neighbours,
            numbers: none,
            whole,
        };
        Halo::new(session, &layout)
    }

    /// Sets `out[i] = finish(i, x_c, -(A x)_c)` for the cells c of the row that begins at `s`, in
    /// the precision of g.
    #[inline(always)]
    pub fn for_row<T: Real>(
        &self,
        g: &[Vec<T>; 3],
        x: &[T],
        s: usize,
        out: &mut [T],
        finish: impl Fn(usize, T, T) -> T,
    ) {
        let n = self.n[0];
        let [_, sy, sz] = self.stride;
        let out = &mut out[..n];
        let middle = &x[s..][..n];
        let west = &x[s - 1..][..n];
        let east = &x[s + 1..][..n];
        let south = &x[s - sy..][..n];
        let north = &x[s + sy..][..n];
        let gw = &g[0][s..][..n];
        let ge = &g[0][s + 1..][..n];
        let gs = &g[1][s..][..n];
        let gn = &g[1][s + sy..][..n];
        if self.axes == 2 {
            for i in 0..n {
                let c = middle[i];
                let flux = gw[i] * (west[i] - c)
                    + ge[i] * (east[i] - c)
                    + gs[i] * (south[i] - c)
                    + gn[i] * (north[i] - c);
                out[i] = finish(i, c, flux);
            }
        } else {
            let below = &x[s - sz..][..n];
            let above = &x[s + sz..][..n];
            let gb = &g[2][s..][..n];
            let ga = &g[2][s + sz..][..n];
            for i in 0..n {
                let c = middle[i];
                let flux = gw[i] * (west[i] - c)
                    + ge[i] * (east[i] - c)
                    + gs[i] * (south[i] - c)
                    + gn[i] * (north[i] - c);
                out[i] = finish(i, c, flux + (gb[i] * (below[i] - c) + ga[i] * (above[i] - c)));
            }
        }
    }
}

/// Fills the ghosts that belong to neighbours, or lie across a period.
pub(super) fn exchange<T: Real>(halo: &mut Halo<T>, axes: usize, x: &mut [T]) -> Result<()> {
    (0..axes).try_for_each(|axis| halo.exchange(axis, 1, x))
}
