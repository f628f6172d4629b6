//! Image points: the velocity at any point, from a cubic through the four cells about it along each
//! axis.
//!
//! ```text
//!     i-1     i   x    i+1     i+2         weights of t = (x - x_i)/h:
//!              -t(t-1)(t-2)/6, (t+1)(t-1)(t-2)/2,
//!      o      o---*-----o       o                                    -(t+1)t(t-2)/2, (t+1)t(t-1)/6
//! ```
//! Near a body some of the cells lie inside it: they hold the profile that was imposed last, which
//! continues the flow smoothly through the surface.

use crate::grid::{Grid, VectorField};
use pulp::Simd;

/// A point on a line where the velocity is read, with its share in the sum that is read.
#[derive(Clone, Copy, Debug)]
pub struct ImagePoint {
    /// Factor of the velocity there in the sum that it is part of.
    pub share: f64,
    /// Place on the line that it lies on, as a factor of that.
    pub out: f64,
}

/// A line through the cells, as places from the middle of one of them (spacings). Its points lie
/// within the stored cells, two layers from their end.
#[derive(Clone, Copy, Debug)]
pub struct Ray<'a, const D: usize> {
    pub lattice: &'a Lattice<D>,
    /// The index in a field of that cell.
    pub origin: i32,
    /// Where the line begins, and how far it goes.
    pub start: [f64; D],
    pub along: [f64; D],
}

/// Numbers of a grid, as image points need them.
#[derive(Clone, Copy, Debug)]
pub struct Lattice<const D: usize> {
    /// Steps along the axes in a field, and the last place from where a point can be read.
    stride: [f64; D],
    last: f64,
    /// Over the spacings (1/m).
    pub inverse_h: [f64; D],
}

impl<const D: usize> Lattice<D> {
    /// The numbers of a grid.
    pub fn new(grid: &Grid<D>) -> Lattice<D> {
        let span = 3 * grid.stride.iter().sum::<usize>() + 1;
        let cells: usize = grid.stored.iter().product();
        Lattice {
            stride: grid.stride.map(|stride| stride as f64),
            last: cells.saturating_sub(span) as f64,
            inverse_h: grid.h.map(|h| 1.0 / h),
        }
    }
}

/// Where a point lies among the cells.
#[derive(Clone, Copy, Debug)]
pub struct Place<const D: usize> {
    /// The index in a field of the first cell of its stencil.
    first: usize,
    /// Distance of the point after the second cell, along each axis (spacings).
    after: [f64; D],
}

impl<const D: usize> Ray<'_, D> {
    /// Place of the point at the factor `out` of the line.
    #[inline(always)]
    pub fn place(&self, out: f64) -> Place<D> {
        let mut first = f64::from(self.origin);
        let mut after = [0.0; D];
        for a in 0..D {
            let x = self.start[a] + out * self.along[a];
            let cell = x.floor();
            after[a] = x - cell;
            first += (cell - 1.0) * self.lattice.stride[a];
        }
        Place { first: first.max(0.0).min(self.lattice.last) as u32 as usize, after }
    }
}

impl<const D: usize> Place<D> {
    /// Place of no point.
    pub const NONE: Place<D> = Place { first: 0, after: [0.0; D] };

    /// The velocity (m/s) there; ghosts of `u` filled. The compiler makes no vectors of rows of
    /// four by itself.
    #[inline(always)]
    pub fn velocity<S: Simd>(&self, simd: S, grid: &Grid<D>, u: &VectorField<D>) -> [f64; D] {
        let weights = self.after.map(weights_at);
        let rows = weights[1].map(|weight| simd.splat_f64s(weight));
        let planes = weights[D - 1].map(|weight| simd.splat_f64s(weight));
        let row = grid.stride[1];
        let whole = 3 * grid.stride[1] + 4;
        let mut sum = [0.0; D];
        for (sum, field) in sum.iter_mut().zip(u) {
            let mut columns = [simd.splat_f64s(0.0); 4];
            for k in 0..if D == 3 { 4 } else { 1 } {
                // One range for the whole plane, so that its rows stay in registers.
                let first = self.first + if D == 3 { k * grid.stride[D - 1] } else { 0 };
                let plane = &field[first..][..whole];
                let mut part = [simd.splat_f64s(0.0); 4];
                for j in 0..4 {
                    let (numbers, _) = S::as_simd_f64s(&plane[j * row..][..4]);
                    for (part, q) in part.iter_mut().zip(numbers) {
                        *part = simd.add_f64s(*part, simd.mul_f64s(rows[j], *q));
                    }
                }
                if D < 3 {
                    columns = part;
                    continue;
                }
                for (column, part) in columns.iter_mut().zip(part).take(4 / S::F64_LANES) {
                    *column = simd.add_f64s(*column, simd.mul_f64s(planes[k], part));
                }
            }
            let columns: &[f64] = pulp::bytemuck::cast_slice(&columns);
            *sum = columns.iter().zip(&weights[0]).map(|(c, w)| c * w).sum();
        }
        sum
    }
}

/// The weights of the four cells for the place `t` after the second.
#[inline(always)]
fn weights_at(t: f64) -> [f64; 4] {
    const SIXTH: f64 = 1.0 / 6.0;
    let below = t + 1.0;
    let next = t - 1.0;
    let after = t - 2.0;
    let low = below * t;
    let high = next * after;
    [-SIXTH * t * high, 0.5 * below * high, -0.5 * low * after, SIXTH * low * next]
}
