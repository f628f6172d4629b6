//! The fluid in gaps that a grid does not resolve: what it does to two surfaces that approach or part.
//!
//! ```text
//!   sphere   lambda = 6 pi mu a ( a/g + c ln(a/g) )              a = r_1 r_2/(r_1 + r_2), a wall's r infinite
//!   disc     lambda = 3 pi sqrt(2) mu (a/g)^(3/2)                c = (1 + 7 b + b^2)/(5 b (1 + b))... of both radii, 1/5 at a wall
//!   missing  lambda phi,  phi = (1 - (g/6h)^2)/(1 + (g/(c h))^p)  what the grid's own flow in the gap does not give
//!   force    -lambda v_n,  g >= roughness; where they touch g = 0.02 a, about as deep as contacts of the usual stiffness go
//! ```
//! The leading terms of Reynolds' equation (Jeffrey and Onishi 1984, Jeffrey and Onishi 1981 for discs). What the grid gives
//! tends to a constant as a gap closes; phi is what it was measured to miss, discs and spheres at 8 and 16 cells across.
//!
//! A step of the fluid is long for this: bodies cross most of a gap in one. The substeps of contacts carry it, each with the
//! mean of lambda over the way that it goes, whose work on a body in free flight is exact however long it is; and each pair
//! by itself, implicitly, so that nothing is too stiff and every pair loses energy.

use crate::params;
use std::f64::consts::PI;

/// What fills the gaps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Medium {
    /// Density (kg/m3).
    pub density: f64,
    /// Viscosity (Pa s).
    pub viscosity: f64,
    /// Spacing of the grid (m).
    pub spacing: f64,
    /// Height of the surfaces' asperities (m): no gap is narrower.
    pub roughness: f64,
}

impl Medium {
    /// The gap up to which there is a force (m).
    pub(super) fn range(&self) -> f64 {
        if self.viscosity > 0.0 { params::lubrication_range() * self.spacing } else { 0.0 }
    }

    /// Force over speed of approach (N s/m), its mean over gaps from `g0` to `g1` (m), between a round body of this dimension and radius
    /// and one of the radius `other`, infinite for a wall (m).
    pub(super) fn resistance(&self, dimension: usize, radius: f64, other: f64, g0: f64, g1: f64) -> f64 {
        // Perfectly smooth bodies never touch.
        let clip = |g: f64| g.max(self.roughness).max(1e-9 * radius);
        let (low, high) = (clip(g0.min(g1)), clip(g0.max(g1)));
        // Asperities that touch are pressed together over a way that a soft contact makes longer than it is: the film between
        // them takes on it what it would over one width of its own.
        let film = params::film() * radius / (1.0 + if other.is_finite() { radius / other } else { 0.0 });
        let (low, high) = if g0 <= 0.0 { (film, film) } else { (low, high) };
        let middle = (low * high).sqrt();
        let (half, power) = if dimension == 3 {
            (params::half_gap_of_spheres(), params::power_of_spheres())
        } else {
            (params::half_gap_of_discs(), params::power_of_discs())
        };
        let (x, far) = (middle / self.spacing, middle / self.range());
        let phi = (1.0 - far * far) / (1.0 + (x / half).powf(power));
        if phi <= 0.0 {
            return 0.0;
        }
        let beta = if other.is_finite() { radius / other } else { 0.0 };
        let a = radius / (1.0 + beta);
        let narrow = high - low < 1e-3 * low;
        let force = match dimension {
            2 => {
                // Of g^(-3/2).
                let mean = if narrow { middle.powf(-1.5) } else { 2.0 / (middle * (low.sqrt() + high.sqrt())) };
                3.0 * PI * 2.0f64.sqrt() * a.powf(1.5) * mean
            }
            _ => {
                let mean = if narrow { 1.0 / middle } else { (high / low).ln() / (high - low) };
                let second = (1.0 + 7.0 * beta + beta * beta) / (5.0 * (1.0 + beta) * (1.0 + beta));
                6.0 * PI * a * (a * mean + second * (1.0 + beta) * (a / middle).max(1.0).ln())
            }
        };
        self.viscosity * force * phi
    }
}
