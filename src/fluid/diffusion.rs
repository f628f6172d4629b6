//! Diffusion: `(1/rho) div( mu (grad u + grad u^T) )` of eq. (7), central differences.
//!
//! [`stress`], variable viscosity, component i, flux through the face between cells c - 1 and c along a:
//! ```text
//!   o     o                                tau = mu_f [ (u_i(c) - u_i(c-1))/h_a
//!   |     |    along i                           + mean over both cells of (u_a(+i) - u_a(-i))/(2 h_i) ]
//!   c-1 | c                                mu_f = mean of the two cells
//!   |     |
//!   o     o                                stable for dt nu (2/h_i^2 + sum_a 2/h_a^2) <= 1 (Euler): nu dt/h^2 < 1/6 in 2D
//! ```
//! [`laplacian`], uniform viscosity: for a divergence-free velocity the transposed part vanishes, which leaves
//! `nu sum_a (q(c-1) - 2 q(c) + q(c+1))/h_a^2`, stable for `dt nu sum_a 2/h_a^2 <= 1`.
//!
//! [`add_laplacian`], of fourth order, where no mixture needs the other two: along each axis
//! ```text
//!   c-2   c-1    c    c+1   c+2
//!    o     o     o     o     o              (-1, 16, -30, 16, -1)/(12 h_a^2), stable for dt nu sum_a (8/3)/h_a^2 <= 1
//! ```
//! At N = 8 cells a diameter it halves the error of the lift at Re = 100.

use crate::grid::{Coefficient, Grid, VectorField, wide};

/// Adds `weight (mu/rho) laplacian(q)` of second order to `rate`; `mu` in Pa s, `density` in kg/m3.
pub fn laplacian<const D: usize>(
    grid: &Grid<D>,
    mu: f64,
    density: &Coefficient,
    q: &[f64],
    weight: f64,
    rate: &mut [f64],
) {
    let inverse_h2: [f64; D] = std::array::from_fn(|a| 1.0 / (grid.h[a] * grid.h[a]));
    let middle = 2.0 * inverse_h2.iter().sum::<f64>();
    wide(
        #[inline(always)]
        || {
            for row in grid.rows() {
                let [low, high] = [-1, 1].map(|by| neighbours(grid, q, row.start, by));
                let here = &q[row.clone()];
                for (i, (c, r)) in row.clone().zip(&mut rate[row]).enumerate() {
                    let sum = (0..D).fold(-middle * here[i], |sum, a| sum + inverse_h2[a] * (low[a][i] + high[a][i]));
                    *r += weight * mu / density.at(c) * sum;
                }
            }
        },
    );
}

/// Adds `factor laplacian(q)` of fourth order to the rates of the row whose first cell is `first`; two layers of ghosts
/// filled.
#[inline(always)]
pub(super) fn add_laplacian<const D: usize>(grid: &Grid<D>, factor: f64, q: &[f64], first: usize, rate: &mut [f64]) {
    let of_axis: [f64; D] = std::array::from_fn(|a| factor / (12.0 * grid.h[a] * grid.h[a]));
    let middle = 30.0 * of_axis.iter().sum::<f64>();
    let [far_low, low, high, far_high] = [-2, -1, 1, 2].map(|by| neighbours(grid, q, first, by));
    let here = &q[first..][..grid.local[0]];
    for (i, r) in rate.iter_mut().enumerate() {
        *r += (0..D).fold(-middle * here[i], |sum, a| {
            sum + of_axis[a] * (16.0 * (low[a][i] + high[a][i]) - (far_low[a][i] + far_high[a][i]))
        });
    }
}

/// By axis, the row `by` cells along it from the row whose first cell is `first`.
#[inline(always)]
fn neighbours<'a, const D: usize>(grid: &Grid<D>, q: &'a [f64], first: usize, by: isize) -> [&'a [f64]; D] {
    std::array::from_fn(|a| &q[(first as isize + by * grid.stride[a] as isize) as usize..][..grid.local[0]])
}

/// Adds `weight (1/rho) div(mu (grad u + grad u^T))`, its component `i`, to `rate`; `mu` (Pa s) with ghosts filled.
/// `flux` is scratch.
#[allow(clippy::too_many_arguments)]
pub fn stress<const D: usize>(
    grid: &Grid<D>,
    mu: &[f64],
    density: &Coefficient,
    u: &VectorField<D>,
    i: usize,
    weight: f64,
    rate: &mut [f64],
    flux: &mut [f64],
) {
    let along = grid.stride[i];
    for a in 0..D {
        let s = grid.stride[a];
        let (inverse_h, inverse_4h) = (1.0 / grid.h[a], 0.25 / grid.h[i]);
        for row in grid.face_rows(a) {
            for c in row {
                let normal = (u[i][c] - u[i][c - s]) * inverse_h;
                let transposed = if a == i {
                    normal
                } else {
                    let v = &u[a];
                    (v[c + along] - v[c - along] + v[c - s + along] - v[c - s - along]) * inverse_4h
                };
                flux[c] = 0.5 * (mu[c] + mu[c - s]) * (normal + transposed);
            }
        }
        for row in grid.rows() {
            for c in row {
                rate[c] += weight * inverse_h / density.at(c) * (flux[c + s] - flux[c]);
            }
        }
    }
}

/// How diffusion is formed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// [`stress`].
    Stress,
    /// [`laplacian`].
    Second,
    /// [`add_laplacian`].
    Fourth,
}

/// One over the largest stable step of explicit Euler diffusion (1/s) with kinematic viscosity `nu` (m2/s). Where viscosity
/// or density vary, `nu` is the largest viscosity over the smallest density: the face mean of one meets the cell value of
/// the other.
pub fn limit_rate<const D: usize>(h: &[f64; D], nu: f64, form: Form) -> f64 {
    let sum: f64 = h.iter().map(|h| 2.0 / (h * h)).sum();
    let own = h.iter().map(|h| 2.0 / (h * h)).fold(0.0, f64::max);
    nu * match form {
        Form::Stress => sum + own,
        Form::Second => sum,
        Form::Fourth => sum * 4.0 / 3.0,
    }
}
