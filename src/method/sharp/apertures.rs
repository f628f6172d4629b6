//! Apertures of faces where bodies share them or press on a wall: never sealed, and the same for
//! everybody.
//!
//! ```text
//!   T = sum m_k,   M = the largest m_k         what bodies cover of a face, overlaps counted twice
//!   H = max( 1 - T, min(0.1, T - M), 1e-6 )   beside a wall of the box: at least 0.1
//!   m_k -> m_k (1 - H)/T   where T > 1 - H     so that H + sum m = 1
//! ```
//! One H for the prediction, the operator, the modes and the correction: what drives a flux in one
//! of them drives it in all. A pocket that the operator sees and the prediction does not takes up a
//! new pressure in every step and keeps the old ones: it holds bodies together, and then throws
//! them apart. `T - M` is zero where one body is alone, grows with what a second one covers, and
//! treats all alike: nothing jumps as bodies move.

use super::local::LocalBodies;
use crate::domain::Domain;
use crate::grid::{Boundaries, BoundaryKind, Grid};
use crate::kernels::faces::FaceCoefficient;
use crate::numerics::SHARED_APERTURE;

/// Relative difference that counts as none.
const ROUNDING: f64 = 1e-14;

/// No aperture is less: the operator keeps the constants as its only null space.
const LEAST_APERTURE: f64 = 1e-6;

/// Solid fractions of the faces of an axis by all bodies: scratch while apertures are set.
pub struct CoveredTogether {
    /// Solid fraction of each face; zero otherwise.
    total: Vec<f64>,
    /// The faces that several bodies cover, and how far.
    shared: Vec<(u32, f64)>,
}

impl CoveredTogether {
    /// Room for the faces of a grid.
    pub fn new<const D: usize>(grid: &Grid<D>) -> CoveredTogether {
        CoveredTogether { total: grid.field(), shared: Vec::new() }
    }

    /// Makes room for so many faces that bodies share.
    pub fn reserve(&mut self, shared: usize) {
        self.shared.reserve(shared.saturating_sub(self.shared.len()));
    }

    /// Sets `beta = H/rho` on all faces that bodies cover and brings the covered parts into line
    /// with it.
    pub fn set_apertures<const D: usize>(
        &mut self,
        domain: &Domain<D>,
        bodies: &mut LocalBodies<D>,
        beta: &mut FaceCoefficient<D>,
    ) {
        let grid = &domain.grid;
        let boundaries = &domain.boundaries;
        let whole = 1.0 / domain.fluid.density;
        let CoveredTogether { total, shared } = self;
        for (axis, beta) in beta.field(grid).iter_mut().enumerate() {
            let cuts = bodies.iter_mut().flat_map(|body| body.faces.cuts[axis].iter_mut());
            for (cut, centroids) in cuts {
                let face = cut.face as usize;
                cut.solid_fraction = centroids.alone;
                cut.first = total[face] == 0.0;
                // The largest part, until all are known.
                beta[face] =
                    if cut.first { cut.solid_fraction } else { beta[face].max(cut.solid_fraction) };
                total[face] += cut.solid_fraction;
            }
            shared.clear();
            for body in bodies.iter_mut() {
                for (cut, _) in body.faces.cuts[axis].iter_mut() {
                    let face = cut.face as usize;
                    let all = total[cut.face as usize];
                    let alone = all == cut.solid_fraction;
                    let beside =
                        || body.faces.at_boundary && beside_wall(grid, boundaries, axis, face);
                    let covered = covered_part(all, beta[face], beside);
                    // What is in line already is left alone, to the last digit.
                    if all > covered * (1.0 + ROUNDING) {
                        cut.solid_fraction *= covered / all;
                    }
                    if alone {
                        beta[face] = whole * (1.0 - covered);
                        total[face] = 0.0;
                    } else {
                        shared.push((cut.face, covered));
                    }
                }
            }
            for (face, covered) in shared.iter() {
                let face = *face as usize;
                beta[face] = whole * (1.0 - covered);
                total[face] = 0.0;
            }
        }
    }
}

/// Solid fraction of a face of which bodies cover `total` together and one of them `most`; `beside`
/// tells whether it is beside a wall of the box.
fn covered_part(total: f64, most: f64, beside: impl Fn() -> bool) -> f64 {
    let shared = (total - most).min(SHARED_APERTURE);
    let near = || shared < SHARED_APERTURE && total > 1.0 - SHARED_APERTURE && beside();
    let least = if near() { SHARED_APERTURE } else { shared.max(LEAST_APERTURE) };
    1.0 - (1.0 - total).max(least)
}

/// Whether a face along `axis` is one of a cell that lies at a wall of the box.
fn beside_wall<const D: usize>(
    grid: &Grid<D>,
    boundaries: &Boundaries<D>,
    axis: usize,
    face: usize,
) -> bool {
    (0..D).any(|a| {
        let at = (face / grid.stride[a] % grid.stored[a] + grid.start[a]).wrapping_sub(grid.ghosts);
        let closed = |side: usize| {
            matches!(
                boundaries.kinds[a][side],
                Some(BoundaryKind::Velocity(_) | BoundaryKind::Slip)
            )
        };
        // Along its own axis a face has a cell on either side.
        (at <= usize::from(a == axis) && closed(0)) || (at + 1 >= grid.cells[a] && closed(1))
    })
}
