//! Advection: `-u.grad u` of eq. (7), two ways.
//!
//! [`upwind5`], conservative: `-(F_{i+1/2} - F_{i-1/2})/h`, `F = U (face value)` with the face
//! velocity U and
//! ```text
//!   i-3   i-2   i-1  |  i    i+1   i+2          U > 0:  (2, -13, 47, 27, -3)/60 on i-3 ... i+1
//!    o     o     o   |  o     o     o           U < 0:  its mirror image
//!              face i-1/2
//! ```
//! Fifth order in what is carried; the face velocity itself is a second-order mean, so that the
//! non-linear term is of second order.
//! [`qsi_sweep`] is the paper's QSI: the value at the foot of the cell's path, from the quintic
//! through the six cells around it,
//! ```text
//!   i-3   i-2   i-1  *  i    i+1   i+2          u > 0, foot * at x_i - u dt
//! ```
//! one axis after the other; sixth-order interpolation, fifth-order transport per unit time, whose
//! damping vanishes with the Courant number.

use super::diffusion::add_laplacian;
use crate::grid::{Grid, VectorField, simd};
use std::ops::Range;

/// The upwind face value times the carrier: the face lies between `q[2]` and `q[3]` of six cells in
/// a row.
#[inline(always)]
pub(super) fn upwind_flux(carrier: f64, q: [f64; 6]) -> f64 {
    let central = q[0] + q[5] - 8.0 * (q[1] + q[4]) + 37.0 * (q[2] + q[3]);
    let damping = q[0] - q[5] - 5.0 * (q[1] - q[4]) + 10.0 * (q[2] - q[3]);
    (carrier * central + carrier.abs() * damping) * (1.0 / 60.0)
}

/// The face velocities that carry (m/s), extrapolated from those of the last two steps, `now +
/// ahead (now - before)`.
pub struct Carrier<'a, const D: usize> {
    /// Present face velocities (m/s).
    pub now: &'a VectorField<D>,
    /// Face velocities of the step before (m/s) and the factor `ahead`, if they are extrapolated.
    pub before: Option<(&'a VectorField<D>, f64)>,
}

impl<const D: usize> Carrier<'_, D> {
    /// Its value on a face normal to `axis` (m/s).
    pub fn at(&self, axis: usize, face: usize) -> f64 {
        let now = self.now[axis][face];
        self.before.map_or(now, |(before, ahead)| now + ahead * (now - before[axis][face]))
    }

    /// Its values on a row of faces normal to `axis`; `to` has room for them.
    #[inline(always)]
    fn row<'b>(&'b self, axis: usize, row: Range<usize>, to: &'b mut [f64]) -> &'b [f64] {
        let now = &self.now[axis][row.clone()];
        let Some((before, ahead)) = self.before else { return now };
        let to = &mut to[..row.len()];
        extrapolate(to, now, &before[axis][row], ahead);
        to
    }
}

/// Scratch of [`upwind5`] from row to row: the fluxes through the low faces of the row at hand.
pub struct Fluxes {
    /// Along a row, and its carrier.
    along: Vec<f64>,
    carrier: Vec<f64>,
    /// Across rows: by component, of one row.
    rows: Vec<f64>,
    /// Across planes: by component, of one plane.
    planes: Vec<f64>,
}

impl Fluxes {
    /// Room for a grid.
    pub fn new<const D: usize>(grid: &Grid<D>) -> Fluxes {
        let n = grid.local[0];
        Fluxes {
            along: vec![0.0; n + 1],
            carrier: vec![0.0; n + 1],
            rows: vec![0.0; D * n],
            planes: vec![0.0; if D == 3 { D * n * grid.local[1] } else { 0 }],
        }
    }
}

/// Adds `weight (-div(U u) + nu laplacian(u))` to `rate`, U the face velocities of `carrier` and
/// `nu` (m2/s) uniform; with `fresh`, puts it in place of what `rate` has. One pass over the rows,
/// so that every field is read from memory once.
#[allow(clippy::too_many_arguments)]
pub fn upwind5<const D: usize>(
    grid: &Grid<D>,
    carrier: &Carrier<D>,
    u: &VectorField<D>,
    nu: f64,
    weight: f64,
    fresh: bool,
    rate: &mut VectorField<D>,
    fluxes: &mut Fluxes,
) {
    simd(
        #[inline(always)]
        || {
            let n = grid.local[0];
            let factor: [f64; D] = std::array::from_fn(|a| weight / grid.h[a]);
            let Fluxes { along, carrier: values, rows, planes } = fluxes;
            for (number, row) in grid.rows().enumerate() {
                if fresh {
                    rate.iter_mut().for_each(|rate| rate[row.clone()].fill(0.0));
                }
                let carried = carrier.row(0, row.start..row.end + 1, values);
                for (q, rate) in u.iter().zip(rate.iter_mut()) {
                    flux_along(along, carried, &q[row.start - 3..row.end + 3]);
                    subtract_difference(
                        &mut rate[row.clone()],
                        &along[..n],
                        &along[1..],
                        factor[0],
                    );
                }
                let j = number % grid.local[1];
                let k = number / grid.local[1];
                for axis in 1..D {
                    let first = if axis == 1 { j == 0 } else { k == 0 };
                    let low =
                        |i: usize| if axis == 1 { i * n } else { (i * grid.local[1] + j) * n };
                    let fluxes = if axis == 1 { &mut *rows } else { &mut *planes };
                    let lows = LowFluxes { first, at: low, fluxes: &mut fluxes[..] };
                    let high = &mut along[..n];
                    let way = Along { axis, stride: grid.stride[axis], factor: factor[axis] };
                    across(carrier, &way, u, &row, values, lows, high, rate);
                }
                if nu != 0.0 {
                    for (q, rate) in u.iter().zip(rate.iter_mut()) {
                        add_laplacian(grid, weight * nu, q, row.start, &mut rate[row.clone()]);
                    }
                }
            }
        },
    );
}

/// An axis, its stride from cell to cell in a field, and the factor of a difference of fluxes along
/// it in the rate of a cell.
struct Along {
    axis: usize,
    stride: usize,
    factor: f64,
}

/// The fluxes through the low faces of a row, those of a component from `at(component)` on; none
/// yet of the first row.
struct LowFluxes<'a, F: Fn(usize) -> usize> {
    first: bool,
    at: F,
    fluxes: &'a mut [f64],
}

/// Subtracts the differences of a row's fluxes across an axis; the fluxes through its high faces
/// take the place of those through the low ones.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
fn across<const D: usize>(
    carrier: &Carrier<D>,
    way: &Along,
    u: &VectorField<D>,
    row: &Range<usize>,
    values: &mut [f64],
    lows: LowFluxes<impl Fn(usize) -> usize>,
    high: &mut [f64],
    rate: &mut VectorField<D>,
) {
    let n = row.len();
    let Along { axis, stride: s, factor } = *way;
    let LowFluxes { first, at, fluxes } = lows;
    if first {
        let carried = carrier.row(axis, row.clone(), values);
        for (i, q) in u.iter().enumerate() {
            let low = &mut fluxes[at(i)..][..n];
            flux_across(low, carried, sixfold(q, row.start, n, s));
        }
    }
    let carried = carrier.row(axis, row.start + s..row.end + s, values);
    for (i, (q, rate)) in u.iter().zip(rate.iter_mut()).enumerate() {
        flux_across(high, carried, sixfold(q, row.start + s, n, s));
        let low = &mut fluxes[at(i)..][..n];
        subtract_difference(&mut rate[row.clone()], low, high, factor);
        low.copy_from_slice(high);
    }
}

/// The six rows about a row of faces that begins at `first`.
#[inline(always)]
fn sixfold(q: &[f64], first: usize, len: usize, stride: usize) -> [&[f64]; 6] {
    std::array::from_fn(|k| &q[first + k * stride - 3 * stride..][..len])
}

#[inline(always)]
fn extrapolate(to: &mut [f64], now: &[f64], before: &[f64], ahead: f64) {
    for ((c, n), b) in to.iter_mut().zip(now).zip(before) {
        *c = n + ahead * (n - b);
    }
}

#[inline(always)]
fn flux_along(flux: &mut [f64], carrier: &[f64], q: &[f64]) {
    let n = flux.len();
    let cells: [&[f64]; 6] = std::array::from_fn(|k| &q[k..k + n]);
    flux_across(flux, carrier, cells);
}

#[inline(always)]
fn flux_across(flux: &mut [f64], carrier: &[f64], q: [&[f64]; 6]) {
    let n = flux.len();
    let carrier = &carrier[..n];
    let q = q.map(|q| &q[..n]);
    for i in 0..n {
        flux[i] = upwind_flux(carrier[i], [q[0][i], q[1][i], q[2][i], q[3][i], q[4][i], q[5][i]]);
    }
}

#[inline(always)]
fn subtract_difference(rate: &mut [f64], low: &[f64], high: &[f64], factor: f64) {
    for ((r, l), h) in rate.iter_mut().zip(low).zip(high) {
        *r -= factor * (h - l);
    }
}

/// Weights of the quintic through nodes 2, 1, 0, -1, -2, -3 (in units of h, upstream negative) at
/// `-c`, `0 <= c <= 1`.
#[inline(always)]
fn quintic_weights(c: f64) -> [f64; 6] {
    let a = c + 2.0;
    let b = c + 1.0;
    let d = c - 1.0;
    let e = c - 2.0;
    let f = c - 3.0;
    [
        b * c * d * e * f / -120.0,
        a * c * d * e * f / 24.0,
        a * b * d * e * f / -12.0,
        a * b * c * e * f / 12.0,
        a * b * c * d * f / -24.0,
        a * b * c * d * e / 120.0,
    ]
}

/// One QSI sweep: `out = q` at the feet of the paths that `u` (m/s, of this axis) draws along
/// `axis` in `dt` (s). Needs `|u| dt <= h`. Ghosts of `q` must be filled along `axis`.
pub fn qsi_sweep<const D: usize>(
    grid: &Grid<D>,
    axis: usize,
    u: &[f64],
    dt: f64,
    q: &[f64],
    out: &mut [f64],
) {
    let s = grid.stride[axis] as isize;
    let courant = dt / grid.h[axis];
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

/// Change of a wave of phase angle `theta` a cell by upwind advection at a Courant number of 1.
#[cfg(test)]
pub(crate) fn upwind5_symbol(theta: f64) -> nalgebra::Complex<f64> {
    let flux = |part: fn(f64) -> f64| {
        upwind_flux(1.0, std::array::from_fn(|k| part((k as f64 - 2.0) * theta)))
    };
    let high = nalgebra::Complex::new(flux(f64::cos), flux(f64::sin));
    high * (nalgebra::Complex::from_polar(1.0, -theta) - 1.0)
}

/// Factor of a wave of phase angle `theta` a cell in a QSI sweep at Courant number `c`.
#[cfg(test)]
pub(crate) fn qsi_symbol(c: f64, theta: f64) -> nalgebra::Complex<f64> {
    let nodes =
        [2.0, 1.0, 0.0, -1.0, -2.0, -3.0].map(|n| nalgebra::Complex::from_polar(1.0, n * theta));
    quintic_weights(c).into_iter().zip(nodes).map(|(w, e)| e * w).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn qsi_quintic_exact_for_degree_five() {
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
    fn upwind_face_value_of_constant_and_bias() {
        assert!((upwind_flux(2.0, [3.0; 6]) - 6.0).abs() < 1e-14);
        assert!((upwind_flux(1.0, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]) - 47.0 / 60.0).abs() < 1e-15);
        assert!((upwind_flux(-1.0, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]) + 27.0 / 60.0).abs() < 1e-15);
        assert_eq!(upwind_flux(1.0, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), 0.0);
    }
}
