//! The fluid in gaps that a grid does not resolve: what it does to two surfaces that approach or
//! part.
//!
//! ```text
//!   sphere   lambda = 6 pi mu a ( a/g + c ln(a/g) )   a = r_1 r_2/(r_1 + r_2), a wall's r infinite
//!   disc     lambda = 3 pi sqrt(2) mu (a/g)^(3/2)
//!              c = (1 + 7 b + b^2)/(5 b (1 + b))... of both radii, 1/5 at a wall
//!   missing  lambda phi,  phi = (1 - (g/6h)^2)/(1 + (g/(c h))^p)
//!              what the grid's own flow in the gap does not give
//!                         p = 4/3 sphere, 2 disc: 4/3 of the power of 1/g in lambda
//!   force    -lambda v_n,  g >= roughness; where they touch g = 0.02 a, about as deep as contacts
//!            of the usual stiffness go
//!
//!   along the gap, the surfaces at u_1, u_2 beside their line of centres:   s = u_1 - u_2,
//!              r = (u_1 + u_2)/2
//!   sphere   sliding 2 pi mu a ln(G/g) s,                      rolling 12/5 of that
//!              G^2 = g^2 + (c h)^2 sliding
//!   disc     sliding pi mu sqrt(2a) (g^(-1/2) - G^(-1/2)) s,   rolling 4 times that
//!              G^2 = g^2 + (2 c h)^2 rolling
//! ```
//! (Reynolds' equation for h = g + x^2/2a; Goldman, Cox and Brenner 1967, Jeffrey and Onishi 1981
//! for discs, 1984 for spheres.) The part of lambda that the grid resolves tends to a constant as a
//! gap closes; c is fitted to it, for discs and for spheres. The grid shows a narrow gap as if it
//! were G wide to surfaces that slide, with another fitted c; rolling also drives a flow along the
//! gap, and G is wider.
//!
//! A body has such a layer to every image of another one in reach; to its own images across short
//! periods, which only its spin shears; and to its mirror image in a plane of symmetry, where the
//! two approach each other and roll on each other.
//!
//! A step of the fluid is long for this: bodies cross most of a gap in one. The substeps of
//! contacts carry it, each with the mean of lambda over the way that it goes, whose work on a body
//! in free flight is exact however long it is; and each pair by itself, implicitly, so that nothing
//! is too stiff and every pair loses energy.

use crate::numerics::{
    AUTO_OVERLAP, HALF_GAP_2D, HALF_GAP_3D, LUBRICATION_RANGE, SHEAR_GAP_2D, SHEAR_GAP_3D,
};
use std::f64::consts::PI;

/// The fluid that fills the gaps.
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

/// Resistance of the fluid in a gap.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lubrication {
    /// Width of the gap (m); 0 where the two touch.
    pub(super) gap: f64,
    /// Force over speed of approach, of sliding and of rolling (N s/m).
    pub(super) normal: f64,
    pub(super) sliding: f64,
    pub(super) rolling: f64,
}

impl Lubrication {
    /// A resistance that has not been found yet.
    pub(super) const UNKNOWN: Lubrication =
        Lubrication { gap: f64::NAN, normal: 0.0, sliding: 0.0, rolling: 0.0 };
}

impl Medium {
    /// The gap up to which there is a force (m).
    pub(super) fn range(&self) -> f64 {
        if self.viscosity > 0.0 { LUBRICATION_RANGE * self.spacing } else { 0.0 }
    }

    /// Force over speed of approach (N s/m), its mean over gaps from `g0` to `g1` (m), between a
    /// round body of this dimension and radius and one of the radius `other`, infinite for a wall
    /// (m).
    pub(super) fn resistance(
        &self,
        dimension: usize,
        radius: f64,
        other: f64,
        g0: f64,
        g1: f64,
    ) -> f64 {
        let reduced = reduced(radius, other);
        let low = self.width(g0.min(g1), reduced);
        let high = self.width(g0.max(g1), reduced);
        // Asperities that touch are pressed together over a way that a soft contact makes longer
        // than it is: the lubrication layer between them takes on it what it would over one width
        // of its own.
        let lubrication = touching_gap(reduced);
        let (low, high) = if g0 <= 0.0 { (lubrication, lubrication) } else { (low, high) };
        let middle = (low * high).sqrt();
        let x = middle / self.spacing;
        let far = middle / self.range();
        let fades = match dimension {
            2 => (x / HALF_GAP_2D).powi(2),
            _ => (x / HALF_GAP_3D).powf(4.0 / 3.0),
        };
        let phi = (1.0 - far * far) / (1.0 + fades);
        if phi <= 0.0 {
            return 0.0;
        }
        let beta = if other.is_finite() { radius / other } else { 0.0 };
        let a = reduced;
        let narrow = high - low < 1e-3 * low;
        let force = match dimension {
            2 => {
                // Mean of g^(-3/2).
                let mean = if narrow {
                    1.0 / (middle * middle.sqrt())
                } else {
                    2.0 / (middle * (low.sqrt() + high.sqrt()))
                };
                3.0 * PI * 2.0f64.sqrt() * a * a.sqrt() * mean
            }
            _ => {
                let mean = if narrow { 1.0 / middle } else { (high / low).ln() / (high - low) };
                let second = (1.0 + 7.0 * beta + beta * beta) / (5.0 * (1.0 + beta) * (1.0 + beta));
                6.0 * PI * a * (a * mean + second * (1.0 + beta) * (a / middle).max(1.0).ln())
            }
        };
        self.viscosity * force * phi
    }

    /// Force over speed (N s/m) of two surfaces of these radii (m) where they slide along a gap of
    /// `g` (m), and where they roll.
    pub(super) fn shear_resistance(
        &self,
        dimension: usize,
        radius: f64,
        other: f64,
        g: f64,
    ) -> [f64; 2] {
        let a = reduced(radius, other);
        let near = if g > 0.0 { self.width(g, a) } else { touching_gap(a) };
        let beyond = |spacings: f64| {
            let far = near.hypot(spacings * self.spacing);
            match dimension {
                2 => PI * (2.0 * a).sqrt() * (1.0 / near.sqrt() - 1.0 / far.sqrt()),
                _ => 2.0 * PI * a * (far / near).ln(),
            }
        };
        let (shown, more) = match dimension {
            2 => (SHEAR_GAP_2D, 4.0),
            _ => (SHEAR_GAP_3D, 2.4),
        };
        [self.viscosity * beyond(shown), more * self.viscosity * beyond(2.0 * shown)]
    }

    /// Width of a gap (m), no less than the roughness: perfectly smooth bodies never touch.
    fn width(&self, gap: f64, reduced: f64) -> f64 {
        gap.max(self.roughness).max(1e-9 * reduced)
    }
}

/// The radius `r_1 r_2/(r_1 + r_2)` of two (m), the second one's infinite for a wall.
fn reduced(radius: f64, other: f64) -> f64 {
    radius / (1.0 + if other.is_finite() { radius / other } else { 0.0 })
}

/// Width (m) of the lubrication layer of two that touch: contacts of the stiffness "auto" go as
/// deep, by the diameter of their reduced radius.
fn touching_gap(reduced: f64) -> f64 {
    2.0 * AUTO_OVERLAP * reduced
}
