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

use super::diffusion::weights;
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
    /// Along a row.
    along: Vec<f64>,
    /// The carriers of the faces along a row and of its high faces across it, if extrapolated.
    carriers: [Vec<f64>; 3],
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
            carriers: std::array::from_fn(|_| vec![0.0; n + 1]),
            rows: vec![0.0; D * n],
            planes: vec![0.0; if D == 3 { D * n * grid.local[1] } else { 0 }],
        }
    }
}

/// Adds `weight (-div(U u) + nu laplacian(u))` to `rate`, U the face velocities of `carrier` and
/// `nu` (m2/s) uniform; with `fresh`, puts it in place of what `rate` has. One pass over the rows,
/// a component of a row in one loop, so that every field is read from memory once.
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
            let terms = Terms::new(grid, nu, weight);
            let Fluxes { along, carriers: [xs, ys, zs], rows, planes } = fluxes;
            for (number, row) in grid.rows().enumerate() {
                let j = number % grid.local[1];
                let k = number / grid.local[1];
                let first = row.start;
                let [_, sy, sz] = strides(grid);
                let low_in_plane = |i: usize| (i * grid.local[1] + j) * n;
                if j == 0 {
                    let carried = carrier.row(1, row.clone(), ys);
                    for (i, q) in u.iter().enumerate() {
                        find_fluxes(&mut rows[i * n..][..n], carried, sixfold(q, first, n, sy));
                    }
                }
                if D == 3 && k == 0 {
                    let carried = carrier.row(D - 1, row.clone(), zs);
                    for (i, q) in u.iter().enumerate() {
                        let low = &mut planes[low_in_plane(i)..][..n];
                        find_fluxes(low, carried, sixfold(q, first, n, sz));
                    }
                }
                let x = carrier.row(0, first..row.end + 1, xs);
                let y = carrier.row(1, first + sy..row.end + sy, ys);
                let z = if D == 3 { carrier.row(D - 1, first + sz..row.end + sz, zs) } else { &[] };
                for (i, (q, rate)) in u.iter().zip(rate.iter_mut()).enumerate() {
                    find_fluxes(&mut along[..n + 1], x, sixfold(q, first, n + 1, 1));
                    let low_z =
                        if D == 3 { &mut planes[low_in_plane(i)..][..n] } else { &mut [][..] };
                    let faces = RowFaces {
                        along: &along[..n + 1],
                        q: &q[first - 1..][..n + 2],
                        across: [
                            HighFaces {
                                carrier: y,
                                low: &mut rows[i * n..][..n],
                                q: sixfold(q, first + sy, n, sy),
                            },
                            HighFaces { carrier: z, low: low_z, q: sixfold(q, first + sz, n, sz) },
                        ],
                    };
                    let rate = &mut rate[row.clone()];
                    if fresh {
                        terms.add::<D, true>(faces, rate);
                    } else {
                        terms.add::<D, false>(faces, rate);
                    }
                }
            }
        },
    );
}

/// Strides along x, y and z; in 2D y's in place of z's.
#[inline(always)]
fn strides<const D: usize>(grid: &Grid<D>) -> [usize; 3] {
    [1, grid.stride[1], grid.stride[D - 1]]
}

/// Values of a component about a row of cells, and fluxes through the faces of these.
struct RowFaces<'a> {
    /// The fluxes through the faces along the row.
    along: &'a [f64],
    /// The row with a cell more at either end.
    q: &'a [f64],
    /// The high faces across the row along y and z.
    across: [HighFaces<'a>; 2],
}

/// The high faces across a row along an axis.
struct HighFaces<'a> {
    /// What carries through them (m/s).
    carrier: &'a [f64],
    /// The fluxes through the low faces, which those through the high ones replace.
    low: &'a mut [f64],
    /// The six rows about them.
    q: [&'a [f64]; 6],
}

/// Factors of the terms of a rate: of differences of fluxes along x, y and z, and in the Laplacian
/// of sums of two neighbours along each and of the cell itself.
struct Terms {
    flux: [f64; 3],
    neighbours: [f64; 3],
    middle: f64,
    /// The weight times the viscosity.
    viscous: f64,
}

impl Terms {
    #[inline(always)]
    fn new<const D: usize>(grid: &Grid<D>, nu: f64, weight: f64) -> Terms {
        let (inverse_h2, middle) = weights(grid);
        let mut terms =
            Terms { flux: [0.0; 3], neighbours: [0.0; 3], middle, viscous: weight * nu };
        for a in 0..D {
            terms.flux[a] = weight / grid.h[a];
            terms.neighbours[a] = inverse_h2[a];
        }
        terms
    }

    /// Adds the rates of the cells of a row, or with `FRESH` puts them in place of what is there.
    #[inline(always)]
    fn add<const D: usize, const FRESH: bool>(&self, faces: RowFaces, rate: &mut [f64]) {
        let n = rate.len();
        let [fx, fy, fz] = self.flux;
        let [nx, ny, nz] = self.neighbours;
        let [west, east] = [&faces.along[..n], &faces.along[1..][..n]];
        let [left, right] = [&faces.q[..n], &faces.q[2..][..n]];
        let [y, z] = faces.across;
        let qy = cut(y.q, n);
        let qz = cut(z.q, n);
        let carried_y = &y.carrier[..n];
        let low_y = &mut y.low[..n];
        let in_space = if D == 3 { n } else { 0 };
        let carried_z = &z.carrier[..in_space];
        let low_z = &mut z.low[..in_space];
        for i in 0..n {
            let high = upwind_flux(carried_y[i], six(&qy, i));
            let mut sum = if FRESH { 0.0 } else { rate[i] };
            sum -= fx * (east[i] - west[i]);
            sum -= fy * (high - low_y[i]);
            low_y[i] = high;
            // The row itself is the third of the six about its high faces.
            let mut bend = -self.middle * qy[2][i];
            bend += nx * (left[i] + right[i]);
            bend += ny * (qy[1][i] + qy[3][i]);
            if D == 3 {
                let high = upwind_flux(carried_z[i], six(&qz, i));
                sum -= fz * (high - low_z[i]);
                bend += nz * (qz[1][i] + qz[3][i]);
                low_z[i] = high;
            }
            rate[i] = sum + self.viscous * bend;
        }
    }
}

/// The values of six rows at a place.
#[inline(always)]
fn six(q: &[&[f64]; 6], i: usize) -> [f64; 6] {
    [q[0][i], q[1][i], q[2][i], q[3][i], q[4][i], q[5][i]]
}

/// The same length of six rows, by which no access of a loop over it is checked.
#[inline(always)]
fn cut(q: [&[f64]; 6], n: usize) -> [&[f64]; 6] {
    [&q[0][..n], &q[1][..n], &q[2][..n], &q[3][..n], &q[4][..n], &q[5][..n]]
}

/// The six rows about a row of faces that begins at `first`.
#[inline(always)]
fn sixfold(q: &[f64], first: usize, len: usize, stride: usize) -> [&[f64]; 6] {
    let row = |k: usize| &q[first + k * stride - 3 * stride..][..len];
    [row(0), row(1), row(2), row(3), row(4), row(5)]
}

#[inline(always)]
fn extrapolate(to: &mut [f64], now: &[f64], before: &[f64], ahead: f64) {
    for ((c, n), b) in to.iter_mut().zip(now).zip(before) {
        *c = n + ahead * (n - b);
    }
}

#[inline(always)]
fn find_fluxes(flux: &mut [f64], carrier: &[f64], q: [&[f64]; 6]) {
    let n = flux.len();
    let carrier = &carrier[..n];
    let q = cut(q, n);
    for i in 0..n {
        flux[i] = upwind_flux(carrier[i], six(&q, i));
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
