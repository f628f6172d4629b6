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

/// A point where the velocity is asked for, with its share in what is asked.
#[derive(Clone, Copy, Debug)]
pub struct ImagePoint<const D: usize> {
    /// Index in a field of the first cell of the stencil, and the place after its second (in
    /// spacings).
    first: u32,
    place: [f64; D],
    /// Factor of the velocity there in the sum that it is part of.
    pub share: f64,
    /// How far out it is, as a factor of the line that it lies on.
    pub out: f64,
}

impl<const D: usize> ImagePoint<D> {
    /// An image point at `centre + out arm` (m); the point is within the stored cells, two layers
    /// from their end.
    #[inline]
    pub fn new(
        grid: &Grid<D>,
        centre: &Vector3<f64>,
        arm: &Vector3<f64>,
        out: f64,
        share: f64,
    ) -> ImagePoint<D> {
        let (mut first, mut place) = (0, [0.0; D]);
        for a in 0..D {
            let number = |n: usize| f64::from(n as u32);
            let x = (centre[a] + out * arm[a]) / grid.h[a] - 0.5 - number(grid.start[a])
                + number(grid.ghosts);
            // Rounded down without a call of libm.
            let cell = (x as i32 - 1).clamp(0, grid.stored[a] as i32 - 4);
            place[a] = x - f64::from(cell) - 1.0;
            first += cell as u32 * grid.stride[a] as u32;
        }
        ImagePoint { first, place, share, out }
    }

    /// The velocity (m/s) there; ghosts of `u` filled.
    #[inline(always)]
    pub fn velocity(&self, grid: &Grid<D>, u: &VectorField<D>) -> Vector3<f64> {
        // Found anew each time: reading them from memory takes longer.
        let weights = self.place.map(weights);
        let mut sum = Vector3::zeros();
        for (sum, field) in sum.iter_mut().zip(u) {
            let mut columns = [0.0; 4];
            for k in 0..if D == 3 { 4 } else { 1 } {
                let (plane, wk) =
                    if D == 3 { (k * grid.stride[D - 1], weights[D - 1][k]) } else { (0, 1.0) };
                // One range for the whole plane, so that its rows stay in registers.
                let plane = &field[self.first as usize + plane..][..3 * grid.stride[1] + 4];
                for j in 0..4 {
                    let (row, wj) = (&plane[j * grid.stride[1]..][..4], wk * weights[1][j]);
                    for (column, q) in columns.iter_mut().zip(row) {
                        *column += wj * q;
                    }
                }
            }
            *sum = columns.iter().zip(&weights[0]).map(|(c, w)| c * w).sum();
        }
        sum
    }
}

/// The weights of the four cells for the place `t` after the second.
#[inline(always)]
fn weights(t: f64) -> [f64; 4] {
    let (below, next, after) = (t + 1.0, t - 1.0, t - 2.0);
    let (low, high) = (below * t, next * after);
    [-t * high / 6.0, below * high / 2.0, -low * after / 2.0, low * next / 6.0]
}
