//! What happens at the faces of the box.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One condition per face: west/east close x, south/north close y, bottom/top close z (3D only).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// Low x.
    pub west: Side,
    /// High x.
    pub east: Side,
    /// Low y.
    pub south: Side,
    /// High y.
    pub north: Side,
    /// Low z, 3D only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bottom: Option<Side>,
    /// High z, 3D only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub top: Option<Side>,
}

/// What happens at one face of the box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Side {
    /// Joined to the opposite face.
    Periodic,
    /// Zero-gradient velocity at zero pressure.
    Outflow,
    /// No slip, at rest.
    Wall,
    /// No flow through, no shear.
    Slip,
    /// No slip, moving in its own plane with this velocity (m/s).
    MovingWall(Vec<f64>),
    /// This velocity (m/s), uniform over the face. Where the case has `[contact]`, inflows stop free particles as a grate does: they lie on
    /// it, with no film between.
    Inflow(Vec<f64>),
    /// A parabola that vanishes at the face's edges, with this velocity (m/s) at its middle.
    InflowParabola(Vec<f64>),
    /// Velocity along the face's first tangential axis, linear between the points given.
    InflowProfile(Profile),
}

impl Side {
    /// The velocities (m/s) that an inflow is given by: one, or one a point of its profile; none for other sides.
    pub fn inflow(&self) -> &[Vec<f64>] {
        match self {
            Side::Inflow(v) | Side::InflowParabola(v) => std::slice::from_ref(v),
            Side::InflowProfile(profile) => &profile.velocity,
            _ => &[],
        }
    }
}

/// A velocity profile: linear between points, constant beyond the first and last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Coordinates along the face's first tangential axis (m), increasing.
    pub at: Vec<f64>,
    /// One velocity (m/s) for each coordinate.
    pub velocity: Vec<Vec<f64>>,
}

impl Profile {
    /// The velocity (m/s) at coordinate `s` (m) along the face's first tangential axis.
    pub fn velocity_at(&self, s: f64) -> Vec<f64> {
        let next = self.at.partition_point(|at| *at <= s).clamp(1, self.at.len() - 1);
        let (s0, s1) = (self.at[next - 1], self.at[next]);
        let weight = ((s - s0) / (s1 - s0)).clamp(0.0, 1.0);
        let (low, high) = (&self.velocity[next - 1], &self.velocity[next]);
        low.iter().zip(high).map(|(a, b)| a + weight * (b - a)).collect()
    }
}
