//! Depths of several corners, edges and faces as one overlap.

use nalgebra::Vector3;

/// p: the larger, the nearer D is to the deepest overlap, and the faster a flat contact swings.
pub(crate) const POWER: i32 = 8;
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
    /// Growth of D as the first turns against the second about the normal (m/rad), over S: a force
    /// acts with this couple about the normal (N m, over N).
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
            // Eighth root, for the power 8.
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
        let weight = counts * self.weight_of(share);
        let place = place - self.origin;
        self.power += share * weight;
        self.weight += weight;
        self.normal += weight * normal;
        self.place += weight * place;
        self.square += weight * place.norm_squared();
        self.moment += weight * place.cross(normal);
    }

    /// The contact of all of them.
    pub(crate) fn whole(&self, radii: [f64; 2]) -> Touch {
        let overlap = self.root();
        let scale = self.normal.norm();
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

/// The mean of places (m), where there are any.
pub(crate) fn mean(places: impl Iterator<Item = Vector3<f64>>) -> Option<Vector3<f64>> {
    let (sum, count) = places.fold((Vector3::zeros(), 0), |(sum, n), x| (sum + x, n + 1));
    (count > 0).then(|| sum / f64::from(count))
}
