//! A shape as a body has turned it: it is asked in the axes of the box.
//!
//! ```text
//!      ,'  own  `.          s, n = nearest(R^T arm), R n      arm: from the body's centre
//!     |   axes /  |<-- n
//!      `.     /  R
//!        `---o------- x
//! ```

use super::{Lattice, Nearest, Orientation, Shape, Tile};
use nalgebra::Vector3;

/// A shape that is turned by an orientation. Its points are given from the body's centre.
#[derive(Clone, Copy, Debug)]
pub struct Turned<'a> {
    /// The shape.
    pub shape: &'a dyn Shape,
    /// Rotation from its own axes to those of the box.
    pub orientation: &'a Orientation,
}

impl Turned<'_> {
    /// A vector in the shape's own axes.
    #[inline]
    fn own(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.orientation.inverse_transform_vector(x)
    }

    /// That with its normal along the axes of the box.
    #[inline]
    fn back(&self, near: Nearest) -> Nearest {
        Nearest { distance: near.distance, normal: self.orientation * near.normal }
    }

    /// As [`Shape::distance`].
    pub fn distance(&self, arm: &Vector3<f64>) -> f64 {
        self.shape.distance(&self.own(arm))
    }

    /// As [`Shape::nearest`].
    pub fn nearest(&self, arm: &Vector3<f64>) -> Nearest {
        self.back(self.shape.nearest(&self.own(arm)))
    }

    /// As [`Shape::clearance`].
    pub fn clearance(&self, arm: &Vector3<f64>) -> Option<f64> {
        self.shape.clearance(&self.own(arm))
    }

    /// As [`Shape::plane`].
    pub fn plane(&self, arm: &Vector3<f64>) -> Option<Nearest> {
        self.shape.plane(&self.own(arm)).map(|plane| self.back(plane))
    }

    /// As [`Shape::feet`].
    pub fn feet(&self, arm: &Vector3<f64>, within: f64, feet: &mut Vec<Nearest>) {
        self.shape.feet(&self.own(arm), within, feet);
        feet.iter_mut().for_each(|foot| *foot = self.back(*foot));
    }

    /// As [`Shape::owns`].
    pub fn owns(&self, arm: &Vector3<f64>) -> bool {
        self.shape.owns(&self.own(arm))
    }

    /// As [`Shape::meets_itself`].
    pub fn meets_itself(&self, foot: &Vector3<f64>, normal: &Vector3<f64>) -> Option<f64> {
        self.shape.meets_itself(&self.own(foot), &self.own(normal))
    }

    /// Extents from the centre along the axes of the box, to the further side (m).
    pub fn bounds(&self) -> Vector3<f64> {
        let axes = self.orientation.matrix();
        Vector3::from_fn(|a, _| {
            if a >= self.shape.dimension() {
                return 0.0;
            }
            let n = axes.row(a).transpose();
            self.shape.extent(&n).max(self.shape.extent(&-n))
        })
    }

    /// Calls with the boxes between `planes` (m) that it reaches; with `faces`, the axis of those
    /// in whose middles they lie, moments and levers are found as well.
    pub fn tile(&self, planes: &[Vec<f64>; 3], faces: Option<usize>, found: &mut dyn FnMut(&Tile)) {
        self.shape
            .tile(&Lattice { factor: 1.0, orientation: *self.orientation, planes, faces }, found);
    }

    /// Part of the box with its centre at `middle` (m) and the half edges `half` (m; zero along z
    /// in 2D) that it fills.
    pub fn part_of(&self, middle: &Vector3<f64>, half: &Vector3<f64>) -> f64 {
        let planes = [0, 1, 2].map(|a| vec![middle[a] - half[a], middle[a] + half[a]]);
        let mut part = 0.0;
        self.tile(&planes, None, &mut |tile| part = tile.part);
        part
    }

    /// As [`Shape::meets`], from a point with the centre `apart` from it (m).
    pub fn meets(&self, apart: &Vector3<f64>, along: &Vector3<f64>, within: f64) -> Option<f64> {
        if self.shape.is_round() {
            return meets_ball(apart, along, self.shape.radius()).filter(|way| *way <= within);
        }
        self.shape.meets(&self.own(&-apart), &self.own(along), within)
    }
}

/// Distance (m) to the surface of a disc or sphere of this radius (m), the centre `apart` (m), in
/// the direction `along`, of length 1; `None` where it is missed.
pub fn meets_ball(apart: &Vector3<f64>, along: &Vector3<f64>, radius: f64) -> Option<f64> {
    let ahead = apart.dot(along);
    let under = ahead * ahead - apart.norm_squared() + radius * radius;
    (ahead > 0.0 && under > 0.0).then(|| (ahead - under.sqrt()).max(0.0))
}
