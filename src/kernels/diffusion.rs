//! Diffusion: `(1/rho) div( mu (grad u + grad u^T) )` of eq. (7), central differences.
//!
//! [`stress`], variable viscosity, component i, flux through the face between cells c - 1 and c
//! along a:
//! ```text
//!   o     o                                tau = mu_f [ (u_i(c) - u_i(c-1))/h_a
//!   |     |    along i                     + mean over both cells of (u_a(+i) - u_a(-i))/(2 h_i) ]
//!   c-1 | c                                mu_f = mean of the two cells
//!   |     |
//!   o     o         stable for dt nu (2/h_i^2 + sum_a 2/h_a^2) <= 1 (Euler): nu dt/h^2 < 1/6 in 2D
//! ```
//! [`laplacian`], uniform viscosity: for a divergence-free velocity the transposed part vanishes,
//! which leaves `nu sum_a (q(c-1) - 2 q(c) + q(c+1))/h_a^2`, stable for `dt nu sum_a 2/h_a^2 <= 1`.

use crate::grid::{Coefficient, Grid, VectorField, simd};

/// Adds `weight (mu/rho) laplacian(q)` to `rate`; `mu` in Pa s, `density` in kg/m3.
pub fn laplacian<const D: usize>(
    grid: &Grid<D>,
    mu: f64,
    density: &Coefficient,
    q: &[f64],
    weight: f64,
    rate: &mut [f64],
) {
    let (inverse_h2, middle) = weights(grid);
    simd(
        #[inline(always)]
        || {
            for row in grid.rows() {
                let value = laplacian_at(grid, &inverse_h2, middle, q, row.start);
                match density {
                    Coefficient::Uniform(rho) => {
                        let factor = weight * mu / rho;
                        for (i, r) in rate[row].iter_mut().enumerate() {
                            *r += factor * value(i);
                        }
                    }
                    Coefficient::Field(rho) => {
                        for ((i, r), rho) in rate[row.clone()].iter_mut().enumerate().zip(&rho[row])
                        {
                            *r += weight * mu / rho * value(i);
                        }
                    }
                }
            }
        },
    );
}

/// One over the square of each spacing, and the factor of a cell itself in the Laplacian (1/m2).
#[inline(always)]
pub(super) fn weights<const D: usize>(grid: &Grid<D>) -> ([f64; D], f64) {
    let inverse_h2: [f64; D] = std::array::from_fn(|a| 1.0 / (grid.h[a] * grid.h[a]));
    (inverse_h2, 2.0 * inverse_h2.iter().sum::<f64>())
}

/// The Laplacian in the `i`-th cell of a row.
#[inline(always)]
fn laplacian_at<const D: usize>(
    grid: &Grid<D>,
    inverse_h2: &[f64; D],
    middle: f64,
    q: &[f64],
    first: usize,
) -> impl Fn(usize) -> f64 {
    let len = grid.local[0];
    let low: [&[f64]; D] = std::array::from_fn(|a| &q[first - grid.stride[a]..][..len]);
    let high: [&[f64]; D] = std::array::from_fn(|a| &q[first + grid.stride[a]..][..len]);
    let here = &q[first..][..len];
    move |i| (0..D).fold(-middle * here[i], |sum, a| sum + inverse_h2[a] * (low[a][i] + high[a][i]))
}

/// Adds `weight (1/rho) div(mu (grad u + grad u^T))`, its component `i`, to `rate`; `mu` (Pa s)
/// with ghosts filled. `flux` is scratch.
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
        let inverse_h = 1.0 / grid.h[a];
        let inverse_4h = 0.25 / grid.h[i];
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

/// One over the largest stable step of explicit Euler diffusion (1/s) with kinematic viscosity `nu`
/// (m2/s), in the full-stress form or the Laplacian's. Where viscosity or density vary, `nu` is the
/// largest viscosity over the smallest density: the face mean of one meets the cell value of the
/// other.
pub fn limit_rate<const D: usize>(h: &[f64; D], nu: f64, full_stress: bool) -> f64 {
    let sum: f64 = h.iter().map(|h| 2.0 / (h * h)).sum();
    let own = h.iter().map(|h| 2.0 / (h * h)).fold(0.0, f64::max);
    nu * (sum + if full_stress { own } else { 0.0 })
}
