//! How two convex parts touch: one overlap for all of a patch.
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
//! where a corner goes over the edge of a face ([`crate::polytope`]). What forces along several
//! normals leave about x is a couple about n, which the slope of D by turns says too.

use crate::distance::closest_of;
use crate::part::{Core, Part};
use crate::placed::{Closest, Placed, Pose};
use crate::polytope::meet;
use crate::superquadric::Surface;
use nalgebra::Vector3;

/// p: the larger, the nearer D is to the deepest overlap, and the faster a flat contact swings.
pub(crate) const POWER: i32 = 8;
/// Sine of the angle between two edges at which their crossing counts half: the nearest points of
/// parallel ones may be anywhere along them.
const PARALLEL: f64 = 1e-2;
/// Part of the radius by which the gaps of several corners are one.
pub(crate) const SAME: f64 = 1e-6;
/// Sine of the angle between a face and a contact's plane at which the contact is half as flat.
const FLAT: f64 = 0.05;

/// Where two parts touch, or are nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// From the first to the second, of length 1.
    pub normal: Vector3<f64>,
    /// Overlap D (m), negative where they do not touch.
    pub overlap: f64,
    /// S, by how much D grows where the two approach at the place along the normal.
    pub gain: f64,
    /// In the middle of the overlap (m).
    pub place: Vector3<f64>,
    /// How much D grows as the first turns against the second about the normal (m/rad), over S: a
    /// force acts with this couple about the normal (N m, over N).
    pub couple: f64,
    /// Radius of the patch (m): how far its corners lie from the place, by their shares.
    pub spread: f64,
    /// Local radii of curvature of both surfaces (m), infinite of a plane.
    pub radii: [f64; 2],
}

/// The corners of a patch, summed up.
#[derive(Debug, Default)]
pub(crate) struct Patch {
    /// The deepest overlap (m), or another depth, what depths are counted in.
    deepest: f64,
    /// p.
    exponent: f64,
    /// Sum of `(d/deepest)^p`, and those of `(d/deepest)^(p-1)` with 1, n, x, `x x n` and `x.x`
    /// (places from `origin`).
    power: f64,
    weight: f64,
    normal: Vector3<f64>,
    place: Vector3<f64>,
    moment: Vector3<f64>,
    square: f64,
    origin: Vector3<f64>,
}

impl Patch {
    /// One of depths about this one (m), with this exponent p.
    pub(crate) fn about(deepest: f64, origin: Vector3<f64>, exponent: f64) -> Patch {
        Patch { deepest, origin, exponent, ..Patch::default() }
    }

    /// `share^(p-1)`.
    fn weight_of(&self, share: f64) -> f64 {
        if self.exponent == f64::from(POWER) {
            share.powi(POWER - 1)
        } else {
            share.powf(self.exponent - 1.0)
        }
    }

    /// The overlap over the depth that others are counted in.
    fn root(&self) -> f64 {
        if self.exponent == f64::from(POWER) {
            // Of the power 8.
            self.power.sqrt().sqrt().sqrt()
        } else {
            self.power.powf(1.0 / self.exponent)
        }
    }

    /// Whether a corner of it overlaps, and what counts against some leaves a whole.
    pub(crate) fn is_touched(&self) -> bool {
        self.power > 0.0 && self.weight > 0.0 && self.normal != Vector3::zeros()
    }

    /// The normal of all of it.
    pub(crate) fn direction(&self) -> Vector3<f64> {
        self.normal.normalize()
    }

    /// Adds a corner of a depth (m), with its normal and place (m), that counts so many times.
    pub(crate) fn add(
        &mut self,
        depth: f64,
        normal: &Vector3<f64>,
        place: &Vector3<f64>,
        counts: f64,
    ) {
        let share = depth / self.deepest;
        if share <= 0.0 {
            return;
        }
        let (weight, place) = (counts * self.weight_of(share), place - self.origin);
        self.power += share * weight;
        self.weight += weight;
        self.normal += weight * normal;
        self.place += weight * place;
        self.square += weight * place.norm_squared();
        self.moment += weight * place.cross(normal);
    }

    /// The contact of all of them.
    pub(crate) fn whole(&self, radii: [f64; 2]) -> Touch {
        let (overlap, scale) = (self.root(), self.normal.norm());
        let normal = self.normal / scale;
        // On the line of the whole force, as near as can be to the mean of the places.
        let mean = self.place / self.weight;
        let turning = self.moment - mean.cross(&self.normal);
        let place = self.origin + mean + normal.cross(&turning) / scale;
        Touch {
            normal,
            overlap: self.deepest * overlap,
            gain: scale / self.weight_of(overlap),
            place,
            couple: turning.dot(&normal) / scale,
            spread: (self.square / self.weight - mean.norm_squared()).max(0.0).sqrt(),
            radii,
        }
    }
}

/// How two parts of bodies in these poses touch; `guess` is a direction from the first to the
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

impl Touch {
    /// The contact at one point.
    pub(crate) fn single(
        normal: Vector3<f64>,
        overlap: f64,
        place: Vector3<f64>,
        radii: [f64; 2],
    ) -> Touch {
        Touch { normal, overlap, gain: 1.0, place, couple: 0.0, spread: 0.0, radii }
    }
}

/// How a part touches a plane with this normal away from the part's side, its points at
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

/// The mean of places (m), where there are any.
pub(crate) fn mean(places: impl Iterator<Item = Vector3<f64>>) -> Option<Vector3<f64>> {
    let (sum, count) = places.fold((Vector3::zeros(), 0), |(sum, n), x| (sum + x, n + 1));
    (count > 0).then(|| sum / f64::from(count))
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
            let bend = Surface::new(*half, *exponents).radius(&own);
            bend.min(part.radius + part.rounding)
        }
        Core::Polytope(polytope) => {
            let along = polytope.faces.iter().map(|face| face.normal.dot(&own));
            let across = 1.0 - along.fold(0.0f64, f64::max).powi(2);
            part.rounding + part.radius / (1.0 + across.max(0.0) / (FLAT * FLAT))
        }
    }
}

/// How often two edges (by their ends, m) count; `None` of parallel ones, of which the corners do.
pub(crate) fn weight_of_edges(
    one: &[Vector3<f64>; 2],
    other: &[Vector3<f64>; 2],
) -> Option<f64> {
    let (e, f) = (one[1] - one[0], other[1] - other[0]);
    let sine = e.cross(&f).norm_squared() / (e.norm_squared() * f.norm_squared());
    let weight = sine / (sine + PARALLEL * PARALLEL);
    (weight > 0.01).then_some(weight)
}

/// The nearest points of two segments that are not parallel, given by their ends (m).
pub(crate) fn nearest_of_edges(
    one: &[Vector3<f64>; 2],
    other: &[Vector3<f64>; 2],
) -> [Vector3<f64>; 2] {
    let (e, f, way) = (one[1] - one[0], other[1] - other[0], one[0] - other[0]);
    let (ee, ff, ef) = (e.norm_squared(), f.norm_squared(), e.dot(&f));
    let (ew, fw) = (e.dot(&way), f.dot(&way));
    let mut s = ((ef * fw - ew * ff) / (ee * ff - ef * ef)).clamp(0.0, 1.0);
    let t = ((ef * s + fw) / ff).clamp(0.0, 1.0);
    s = ((ef * t - ew) / ee).clamp(0.0, 1.0);
    [one[0] + s * e, other[0] + t * f]
}

#[cfg(test)]
mod tests;
