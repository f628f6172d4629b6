//! Contact of two convex parts: one overlap for all of a patch.
//!
//! ```text
//!      ____________        depths d_k > 0 at the corners of both faces, each by the distance of
//!     |  A         |       a corner from the other face, and of two edges, along its n_k
//!    _|_x________x_|__     overlap  D = (sum d_k^p)^(1/p)     place  x = sum s_k x_k / S
//!         B                s_k = dD/dd_k = (d_k/D)^(p-1)      S = |sum s_k n_k|
//! ```
//! A law with the force Q(D) acts with Q S at x: that is the slope of its potential by the bodies'
//! places, so that a flat contact keeps energy as a corner does, and of four corners at most
//! 4^(1/p) times as stiff. All distances are those of whole bodies and edges, which change smoothly
//! where a corner goes over the edge of a face ([`super::polytope`]). Forces along several normals
//! leave a couple about n at x, which the slope of D by turns gives too.

use crate::contact::depths::{POWER, Patch, Touch, mean};
use crate::contact::distance::closest_of;
use crate::contact::part::{Core, Part};
use crate::contact::polytope::meet;
use crate::contact::pose::{Closest, Placed, Pose};
use crate::surface::superquadric::SuperquadricSurface;
use nalgebra::Vector3;

/// Part of the radius by which the gaps of several corners are one.
pub(crate) const SAME: f64 = 1e-6;
/// Sine of the angle between a face and a contact's plane at which the contact is half as flat.
const FLAT: f64 = 0.05;

/// Contact of two parts of bodies in these poses; `guess` is a direction from the first to the
/// second. `None` as of [`crate::closest`].
pub fn touch(a: &Part, at: &Pose, b: &Part, to: &Pose, guess: &Vector3<f64>) -> Option<Touch> {
    let sides = [Placed::new(a, at), Placed::new(b, to)];
    let radii = |n: &Vector3<f64>| [radius(a, &sides[0], n), radius(b, &sides[1], &-n)];
    let single = |normal: Vector3<f64>, distance: f64, point: Vector3<f64>| {
        let place = point + (a.rounding + 0.5 * distance) * normal;
        Touch::single(normal, -distance, place, radii(&normal))
    };
    let (Core::Polytope(one), Core::Polytope(other)) = (&a.core, &b.core) else {
        let Closest { normal, distance, points } = closest_of([a, b], &sides, guess)?;
        return Some(single(normal, distance, points[0]));
    };
    let rounding = [a.rounding, b.rounding];
    let (nearest, patch) = meet([&sides[0], &sides[1]], [one, other], rounding, guess);
    Some(if patch.is_touched() {
        patch.whole(radii(&patch.direction()))
    } else {
        let distance = nearest.distance - rounding[0] - rounding[1];
        single(nearest.normal, distance, nearest.points[0])
    })
}

/// Contact of a part with a plane with this normal away from the part's side, its points at
/// `x.n = offset` (m).
pub fn touch_plane(part: &Part, pose: &Pose, normal: &Vector3<f64>, offset: f64) -> Touch {
    let side = Placed::new(part, pose);
    let nearest = side.support(normal);
    let radii = [radius(part, &side, normal), f64::INFINITY];
    let depth = |point: &Vector3<f64>| point.dot(normal) + part.rounding - offset;
    let overlap = depth(&nearest);
    // In the plane.
    let foot = |point: &Vector3<f64>| point + (offset - point.dot(normal)) * normal;
    let place = foot(&nearest);
    let single = Touch::single(*normal, overlap, place, radii);
    let Core::Polytope(polytope) = &part.core else { return single };
    if overlap <= 0.0 {
        // One that is about to touch by several at once does not turn.
        let feet = polytope.corners.iter().map(|corner| side.at(corner));
        let feet = feet.filter(|corner| depth(corner) >= overlap - SAME * part.radius);
        return Touch { place: mean(feet.map(|corner| foot(&corner))).unwrap_or(place), ..single };
    }
    let mut patch = Patch::about(overlap, place, f64::from(POWER));
    for corner in polytope.corners.iter().map(|corner| side.at(corner)) {
        patch.add(depth(&corner), normal, &foot(&corner), 1.0);
    }
    patch.whole(radii)
}

/// Local radius of curvature of a part's surface (m) where its normal is `n`: the mean of both of
/// a smooth one in 3D; of a polytope that of its edges, and on a face that of all of it.
pub(crate) fn radius(part: &Part, side: &Placed<'_>, n: &Vector3<f64>) -> f64 {
    let own = side.orientation.inverse_transform_vector(n);
    match &part.core {
        Core::Point => part.rounding,
        // Second derivatives of how far it reaches: (M - x x^T)/h.
        Core::Ellipsoid { half, .. } => {
            let squares = half.component_mul(half);
            let reach = squares.dot(&own.component_mul(&own)).sqrt();
            let ways = if half.z == 0.0 { 1.0 } else { 2.0 };
            let x = squares.component_mul(&own) / reach;
            let bend = (squares.sum() - x.norm_squared()) / (ways * reach);
            bend.min(part.radius + part.rounding)
        }
        Core::Superquadric { half, exponents, .. } => {
            let bend = SuperquadricSurface::new(*half, *exponents).radius(&own);
            bend.min(part.radius + part.rounding)
        }
        Core::Polytope(polytope) => {
            let along = polytope.faces.iter().map(|face| face.normal.dot(&own));
            let across = 1.0 - along.fold(0.0f64, f64::max).powi(2);
            part.rounding + part.radius / (1.0 + across.max(0.0) / (FLAT * FLAT))
        }
    }
}

#[cfg(test)]
mod tests;
