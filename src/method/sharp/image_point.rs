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
use nalgebra::Vector3;

/// A point on a line where the velocity is asked for, with its share in what is asked.
#[derive(Clone, Copy, Debug)]
pub struct ImagePoint {
    /// Factor of the velocity there in the sum that it is part of.
    pub share: f64,
    /// How far out it is, as a factor of the line that it lies on.
    pub out: f64,
}

/// A line through the cells, as places from the middle of one of them (spacings). Its points lie
/// within the stored cells, two layers from their end.
#[derive(Clone, Copy, Debug)]
pub struct Ray<const D: usize> {
    /// The index in a field of that cell.
    pub origin: i32,
    /// Where the line begins, and how far it goes.
    pub start: [f64; D],
    pub along: [f64; D],
}

impl<const D: usize> Ray<D> {
    /// The velocity (m/s) so far `out` on the line; ghosts of `u` filled.
    #[inline(always)]
    pub fn velocity(&self, out: f64, grid: &Grid<D>, u: &VectorField<D>) -> Vector3<f64> {
        let (mut first, mut weights) = (f64::from(self.origin), [[0.0; 4]; D]);
        for a in 0..D {
            let x = self.start[a] + out * self.along[a];
            let cell = x.floor();
            weights[a] = weights_at(x - cell);
            first += (cell - 1.0) * f64::from(grid.stride[a] as u32);
        }
        let span: usize = 3 * grid.stride.iter().sum::<usize>() + 1;
        let first = (first as u32 as usize).min(u[0].len().saturating_sub(span));
        let mut sum = Vector3::zeros();
        for (sum, field) in sum.iter_mut().zip(u) {
            let mut columns = [0.0; 4];
            for k in 0..if D == 3 { 4 } else { 1 } {
                // One range for the whole plane, so that its rows stay in registers.
                let first = first + if D == 3 { k * grid.stride[D - 1] } else { 0 };
                let (plane, mut part) = (&field[first..][..3 * grid.stride[1] + 4], [0.0; 4]);
                for j in 0..4 {
                    let (row, weight) = (&plane[j * grid.stride[1]..][..4], weights[1][j]);
                    for (part, q) in part.iter_mut().zip(row) {
                        *part += weight * q;
                    }
                }
                let weight = if D == 3 { weights[D - 1][k] } else { 1.0 };
                for (column, part) in columns.iter_mut().zip(part) {
                    *column += weight * part;
                }
            }
            *sum = columns.iter().zip(&weights[0]).map(|(c, w)| c * w).sum();
        }
        sum
    }
}

/// The weights of the four cells for the place `t` after the second.
#[inline(always)]
fn weights_at(t: f64) -> [f64; 4] {
    const SIXTH: f64 = 1.0 / 6.0;
    let (below, next, after) = (t + 1.0, t - 1.0, t - 2.0);
    let (low, high) = (below * t, next * after);
    [-SIXTH * t * high, 0.5 * below * high, -0.5 * low * after, SIXTH * low * next]
}
