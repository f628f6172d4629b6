//! Cores of parts at their places, and the nearest points of two of them.

use crate::Orientation;
use crate::contact::part::{Core, Part};
use nalgebra::Vector3;

/// Where a body is and how it is turned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Its centre (m).
    pub place: Vector3<f64>,
    /// Rotation from its own axes to those of the box.
    pub orientation: Orientation,
}

/// The nearest points of two parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// From the first to the second, of length 1.
    pub normal: Vector3<f64>,
    /// Between the surfaces (m), negative where they overlap.
    pub distance: f64,
    /// The nearest points of both cores (m).
    pub points: [Vector3<f64>; 2],
}

impl Closest {
    /// The nearest points of the two parts in the other order.
    pub(crate) fn turned(self) -> Closest {
        Closest { normal: -self.normal, points: [self.points[1], self.points[0]], ..self }
    }
}

/// A core at its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed<'a> {
    pub core: &'a Core,
    pub orientation: &'a Orientation,
    /// Place of the core's origin (m).
    pub place: Vector3<f64>,
}

impl<'a> Placed<'a> {
    /// The core of a part of a body there.
    pub fn new(part: &'a Part, pose: &'a Pose) -> Placed<'a> {
        let place = pose.place + pose.orientation * part.place;
        Placed { core: &part.core, orientation: &pose.orientation, place }
    }

    /// A point of its own axes in those of the box (m).
    pub fn at(&self, own: &Vector3<f64>) -> Vector3<f64> {
        self.place + self.orientation * own
    }

    /// The point that lies furthest along `n` (m).
    pub fn support(&self, n: &Vector3<f64>) -> Vector3<f64> {
        self.at(&self.core.support(&self.orientation.inverse_transform_vector(n)))
    }

    /// Thickness of the skin within the surface of a curved body (m); zero of others.
    pub fn inset(&self) -> f64 {
        match self.core {
            Core::Ellipsoid { inset, .. } | Core::Superquadric { inset, .. } => *inset,
            Core::Point | Core::Polytope(_) => 0.0,
        }
    }
}
