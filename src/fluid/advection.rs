//! Advection: `-u.grad u` of eq. (7), three ways.
//!
//! [`upwind5`], conservative: `-(F_{i+1/2} - F_{i-1/2})/h`, `F = U (face value)` with the face velocity U and
//! ```text
//!   i-3   i-2   i-1  |  i    i+1   i+2          U > 0:  (2, -13, 47, 27, -3)/60 on i-3 ... i+1
//!    o     o     o   |  o     o     o           U < 0:  its mirror image
//!              face i-1/2
//! ```
//! Fifth order in what is carried; the face velocity itself is a second-order mean, so that the non-linear term is of
//! second order. [`upwind5_advective`] multiplies the same differences by the cell's own velocity: fifth order also on
//! the non-linear term, but it conserves no momentum. [`qsi_sweep`] is the paper's QSI: the value at the foot of the
//! cell's path, from the quintic through the six cells around it,
//! ```text
//!   i-3   i-2   i-1  *  i    i+1   i+2          u > 0, foot * at x_i - u dt
//! ```
//! one axis after the other; sixth-order interpolation, fifth-order transport per unit time, whose damping vanishes
//! with the Courant number.

use crate::grid::{Grid, VectorField};

/// The upwind face value times the carrier: the face lies between `q[2]` and `q[3]` of six cells in a row.
#[inline(always)]
fn upwind_flux(carrier: f64, q: [f64; 6]) -> f64 {
    let central = q[0] + q[5] - 8.0 * (q[1] + q[4]) + 37.0 * (q[2] + q[3]);
    let damping = q[0] - q[5] - 5.0 * (q[1] - q[4]) + 10.0 * (q[2] - q[3]);
    (carrier * central + carrier.abs() * damping) * (1.0 / 60.0)
}

/// Adds `-weight div(U q)` to `rate`, U the face velocities `carrier` (m/s). `flux` is scratch.
pub fn upwind5<const D: usize>(
    grid: &Grid<D>,
    carrier: &VectorField<D>,
    q: &[f64],
    weight: f64,
    rate: &mut [f64],
    flux: &mut [f64],
) {
    for axis in 0..D {
        let s = grid.stride[axis];
        for row in grid.face_rows(axis) {
            let (first, len) = (row.start, row.len());
            let cells: [&[f64]; 6] = std::array::from_fn(|k| &q[first + k * s - 3 * s..][..len]);
            let (u, out) = (&carrier[axis][row.clone()], &mut flux[row]);
            for i in 0..len {
                out[i] = upwind_flux(u[i], std::array::from_fn(|k| cells[k][i]));
            }
        }
        let factor = weight / grid.h[axis];
        for row in grid.rows() {
            let (low, high) = (&flux[row.clone()], &flux[row.start + s..row.end + s]);
            for ((r, l), h) in rate[row].iter_mut().zip(low).zip(high) {
                *r -= factor * (h - l);
            }
        }
    }
}

/// Adds `-weight u.grad q` to `rate`, u the cell velocities (m/s).
pub fn upwind5_advective<const D: usize>(grid: &Grid<D>, u: &VectorField<D>, q: &[f64], weight: f64, rate: &mut [f64]) {
    for axis in 0..D {
        let (s, factor) = (grid.stride[axis], weight / grid.h[axis]);
        for row in grid.rows() {
            let (first, len) = (row.start, row.len());
            let cells: [&[f64]; 7] = std::array::from_fn(|k| &q[first + k * s - 3 * s..][..len]);
            let (u, out) = (&u[axis][row.clone()], &mut rate[row]);
            for i in 0..len {
                let low = upwind_flux(u[i], std::array::from_fn(|k| cells[k][i]));
                let high = upwind_flux(u[i], std::array::from_fn(|k| cells[k + 1][i]));
                out[i] -= factor * (high - low);
            }
        }
    }
}

/// Weights of the quintic through nodes 2, 1, 0, -1, -2, -3 (in units of h, upstream negative) at `-c`, `0 <= c <= 1`.
#[inline(always)]
fn quintic_weights(c: f64) -> [f64; 6] {
    let (a, b, d, e, f) = (c + 2.0, c + 1.0, c - 1.0, c - 2.0, c - 3.0);
    [
        b * c * d * e * f / -120.0,
        a * c * d * e * f / 24.0,
        a * b * d * e * f / -12.0,
        a * b * c * e * f / 12.0,
        a * b * c * d * f / -24.0,
        a * b * c * d * e / 120.0,
    ]
}

/// One QSI sweep: `out = q` at the feet of the paths that `u` (m/s, of this axis) draws along `axis` in `dt` (s).
/// Needs `|u| dt <= h`. Ghosts of `q` must be filled along `axis`.
pub fn qsi_sweep<const D: usize>(grid: &Grid<D>, axis: usize, u: &[f64], dt: f64, q: &[f64], out: &mut [f64]) {
    let (s, courant) = (grid.stride[axis] as isize, dt / grid.h[axis]);
    for row in grid.rows() {
        for i in row {
            let c = u[i] * courant;
            let upstream = if c > 0.0 { -s } else { s };
            let weights = quintic_weights(c.abs());
            let mut at = i.wrapping_add_signed(-2 * upstream);
            let mut value = 0.0;
            for w in weights {
                value += w * q[at];
                at = at.wrapping_add_signed(upstream);
            }
            out[i] = value;
        }
    }
}

/// What upwind advection at a Courant number of 1 adds to a wave of phase angle `theta` a cell.
#[cfg(test)]
pub(crate) fn upwind5_symbol(theta: f64) -> nalgebra::Complex<f64> {
    let flux = |part: fn(f64) -> f64| upwind_flux(1.0, std::array::from_fn(|k| part((k as f64 - 2.0) * theta)));
    let high = nalgebra::Complex::new(flux(f64::cos), flux(f64::sin));
    high * (nalgebra::Complex::from_polar(1.0, -theta) - 1.0)
}

/// What a QSI sweep at Courant number `c` multiplies a wave of phase angle `theta` a cell by.
#[cfg(test)]
pub(crate) fn qsi_symbol(c: f64, theta: f64) -> nalgebra::Complex<f64> {
    let nodes = [2.0, 1.0, 0.0, -1.0, -2.0, -3.0].map(|n| nalgebra::Complex::from_polar(1.0, n * theta));
    quintic_weights(c).into_iter().zip(nodes).map(|(w, e)| e * w).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quintic_reproduces_polynomials_of_degree_five() {
        for c in [0.0, 0.3, 0.77, 1.0] {
            for degree in 0..6 {
                let sum: f64 = quintic_weights(c)
                    .iter()
                    .zip([2.0, 1.0, 0.0, -1.0, -2.0, -3.0f64])
                    .map(|(w, x)| w * x.powi(degree))
                    .sum();
                assert!((sum - (-c).powi(degree)).abs() < 1e-13, "degree {degree} at {c}: {sum}");
            }
        }
    }

    #[test]
    fn a_face_value_of_a_constant_is_the_constant_and_leans_upwind() {
        assert!((upwind_flux(2.0, [3.0; 6]) - 6.0).abs() < 1e-14);
        assert!((upwind_flux(1.0, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]) - 47.0 / 60.0).abs() < 1e-15);
        assert!((upwind_flux(-1.0, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]) + 27.0 / 60.0).abs() < 1e-15);
        assert_eq!(upwind_flux(1.0, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), 0.0);
    }
}
