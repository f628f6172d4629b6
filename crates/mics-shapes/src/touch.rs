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
//! 4^(1/p) times as stiff. All distances are those of whole faces and edges, which change
//! smoothly where a corner goes over the edge of a face. Two equal faces flush have 16 pairs.

use crate::distance::closest;
use crate::part::{Core, Face, Part, Polytope};
use crate::placed::{Closest, Placed, Pose};
use nalgebra::Vector3;

/// p: the larger, the nearer D is to the deepest overlap, and the faster a flat contact swings.
pub(crate) const POWER: i32 = 8;
/// Sine of the angle between two edges at which their crossing counts half: the nearest points of
/// parallel ones may be anywhere along them.
pub(crate) const PARALLEL: f64 = 1e-2;
/// Part of the deepest overlap by which that of a patch's corners is taken for it, and of the
/// radius by which the gaps of several are one.
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
    /// The deepest of them.
    largest: f64,
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

    /// Whether a corner of it overlaps, and what counts against some leaves a whole.
    pub(crate) fn is_touched(&self) -> bool {
        self.power > 0.0 && self.weight > 0.0 && self.normal != Vector3::zeros()
    }

    /// The normal of all of it.
    pub(crate) fn direction(&self) -> Vector3<f64> {
        self.normal.normalize()
    }

    /// Adds the nearest points of a corner or an edge of both bodies (m) with these roundings (m).
    fn add_points(&mut self, [a, b]: [Vector3<f64>; 2], rounding: [f64; 2], counts: f64) {
        let (way, most) = (b - a, rounding[0] + rounding[1]);
        let square = way.norm_squared();
        if square >= most * most || square == 0.0 {
            return;
        }
        let depth = most - square.sqrt();
        let normal = way / square.sqrt();
        self.add(depth, &normal, &(a + (rounding[0] - 0.5 * depth) * normal), counts);
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
        self.largest = self.largest.max(depth);
    }

    /// The contact of all of them.
    pub(crate) fn whole(&self, radii: [f64; 2]) -> Touch {
        let (overlap, scale) = (self.power.powf(1.0 / self.exponent), self.normal.norm());
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
            spread: (self.square / self.weight - mean.norm_squared()).max(0.0).sqrt(),
            radii,
        }
    }
}

/// How two parts of bodies in these poses touch; `guess` is a direction from the first to the
/// second. `None` where their cores overlap.
pub fn touch(a: &Part, at: &Pose, b: &Part, to: &Pose, guess: &Vector3<f64>) -> Option<Touch> {
    let nearest = closest(a, at, b, to, guess)?;
    let Closest { normal, distance, points } = nearest;
    let sides = [Placed::new(a, at), Placed::new(b, to)];
    let radii = [radius(a, &sides[0], &normal), radius(b, &sides[1], &-normal)];
    let overlap = -distance;
    let place = points[0] + (a.rounding - 0.5 * overlap) * normal;
    let single = Touch { normal, overlap, gain: 1.0, place, spread: 0.0, radii };
    let (Core::Polytope(one), Core::Polytope(other)) = (&a.core, &b.core) else {
        return Some(single);
    };
    if overlap <= 0.0 {
        return Some(single);
    }
    let mut patch = Patch::about(overlap, place, f64::from(POWER));
    let faces = [
        Facet::towards(one, &sides[0], a.rounding, &normal),
        Facet::towards(other, &sides[1], b.rounding, &-normal),
    ];
    if let [Some(face), Some(its)] = faces {
        face.add_corners(&its, true, &mut patch);
        its.add_corners(&face, false, &mut patch);
        face.add_edges(&its, &mut patch);
    }
    if patch.largest < (1.0 - SAME) * overlap {
        patch.add(overlap, &normal, &place, 1.0);
    }
    Some(patch.whole(radii))
}

/// How a part touches a plane with this normal away from the part's side, its points at
/// `x.n = offset` (m).
pub fn touch_plane(part: &Part, pose: &Pose, normal: &Vector3<f64>, offset: f64) -> Touch {
    let side = Placed::new(part, pose);
    let own = side.orientation.inverse_transform_vector(normal);
    let nearest = side.at(&part.core.support(&own));
    let radii = [radius(part, &side, normal), f64::INFINITY];
    let depth = |point: &Vector3<f64>| point.dot(normal) + part.rounding - offset;
    let overlap = depth(&nearest);
    // In the plane.
    let foot = |point: &Vector3<f64>| point + (offset - point.dot(normal)) * normal;
    let place = foot(&nearest);
    let single = Touch { normal: *normal, overlap, gain: 1.0, place, spread: 0.0, radii };
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
        Core::Ellipsoid { half, .. } | Core::Superquadric { half, .. } => {
            let ways = if half.z == 0.0 { 1.0 } else { 2.0 };
            part.rounding + (part.core.bend(&own).trace() / ways).min(part.radius)
        }
        Core::Polytope(polytope) => {
            let along = polytope.faces.iter().map(|face| face.normal.dot(&own));
            let across = 1.0 - along.fold(0.0f64, f64::max).powi(2);
            part.rounding + part.radius / (1.0 + across.max(0.0) / (FLAT * FLAT))
        }
    }
}

/// A face of a polytope at its place; in 2D an edge.
struct Facet<'a> {
    polytope: &'a Polytope,
    side: &'a Placed<'a>,
    face: &'a Face,
    rounding: f64,
    /// Outward normal in the axes of the box.
    normal: Vector3<f64>,
}

impl<'a> Facet<'a> {
    /// The face of a polytope that faces `n` most.
    fn towards(
        polytope: &'a Polytope,
        side: &'a Placed<'a>,
        rounding: f64,
        n: &Vector3<f64>,
    ) -> Option<Facet<'a>> {
        let own = side.orientation.inverse_transform_vector(n);
        let along = |face: &&Face| face.normal.dot(&own);
        let face = polytope.faces.iter().max_by(|a, b| along(a).total_cmp(&along(b)))?;
        let normal = side.orientation * face.normal;
        Some(Facet { polytope, side, face, rounding, normal })
    }

    /// Its corners, in the order around it.
    fn corners(&self) -> impl Iterator<Item = Vector3<f64>> {
        (0..self.face.corners.len()).map(|k| self.corner(k))
    }

    fn corner(&self, k: usize) -> Vector3<f64> {
        let corners = &self.face.corners;
        self.side.at(&self.polytope.corners[corners[k % corners.len()] as usize])
    }

    /// Its edges, by their ends; the one of a face in 2D.
    fn edges(&self) -> impl Iterator<Item = [Vector3<f64>; 2]> {
        let n = self.face.corners.len();
        (0..if n == 2 { 1 } else { n }).map(|k| [self.corner(k), self.corner(k + 1)])
    }

    /// The point of it that is nearest to another one (m).
    fn nearest(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let inner = |[from, to]: [Vector3<f64>; 2]| {
            self.normal.cross(&(to - from)).dot(&(point - from)) >= 0.0
        };
        if self.face.corners.len() > 2 && self.edges().all(inner) {
            return point - (point - self.corner(0)).dot(&self.normal) * self.normal;
        }
        let (mut best, mut nearest) = (f64::INFINITY, self.corner(0));
        for [from, to] in self.edges() {
            let edge = to - from;
            let part = (point - from).dot(&edge) / edge.norm_squared();
            let foot = from + part.clamp(0.0, 1.0) * edge;
            let square = (point - foot).norm_squared();
            if square < best {
                (best, nearest) = (square, foot);
            }
        }
        nearest
    }

    /// Adds its corners with the nearest points of another face, whose body is the `second` of the
    /// two, or the first.
    fn add_corners(&self, other: &Facet<'_>, second: bool, patch: &mut Patch) {
        for corner in self.corners() {
            if (corner - other.corner(0)).dot(&other.normal) > self.rounding + other.rounding {
                continue;
            }
            let near = other.nearest(&corner);
            if second {
                patch.add_points([corner, near], [self.rounding, other.rounding], 1.0);
            } else {
                patch.add_points([near, corner], [other.rounding, self.rounding], 1.0);
            }
        }
    }

    /// Adds the nearest points of its edges and those of another face of the second body.
    fn add_edges(&self, other: &Facet<'_>, patch: &mut Patch) {
        if self.face.corners.len() == 2 || other.face.corners.len() == 2 {
            return;
        }
        for one in self.edges() {
            for its in other.edges() {
                let (e, f) = (one[1] - one[0], its[1] - its[0]);
                let sine = e.cross(&f).norm_squared() / (e.norm_squared() * f.norm_squared());
                let weight = sine / (sine + PARALLEL * PARALLEL);
                if weight > 0.01 {
                    let points = nearest_of(&one, &its);
                    patch.add_points(points, [self.rounding, other.rounding], weight);
                }
            }
        }
    }
}

/// The nearest points of two segments that are not parallel, given by their ends (m).
pub(crate) fn nearest_of(one: &[Vector3<f64>; 2], other: &[Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
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
