//! Boundaries of the box that stop bodies.

use nalgebra::Vector3;

/// A boundary of the box, normal to an axis; its inner side faces the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Its normal: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Whether the box lies below it.
    pub high: bool,
    /// Its coordinate (m).
    pub at: f64,
    /// Its velocity (m/s), of which the part along the wall counts.
    pub velocity: Vector3<f64>,
    /// Its material.
    pub material: usize,
    /// Behaviour of the fluid there.
    pub side: WallSide,
}

/// Behaviour of the fluid at a boundary that stops bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WallSide {
    /// It sticks, and a lubrication layer of it is between body and wall.
    Closed,
    /// It slips: a plane of symmetry, beyond which bodies see their own images.
    Slip,
    /// It comes in, as through a grate: no lubrication layer.
    Inflow,
}

impl Wall {
    /// Distance of a point from the wall (m), positive inside the box.
    pub(super) fn distance(&self, point: &Vector3<f64>) -> f64 {
        if self.high { self.at - point[self.axis] } else { point[self.axis] - self.at }
    }

    /// Its velocity along itself (m/s).
    pub(super) fn sliding(&self) -> Vector3<f64> {
        self.velocity - self.velocity.dot(&self.normal()) * self.normal()
    }

    /// Unit normal, out of the box.
    pub(super) fn normal(&self) -> Vector3<f64> {
        let mut normal = Vector3::zeros();
        normal[self.axis] = if self.high { 1.0 } else { -1.0 };
        normal
    }

    pub(super) fn name(&self) -> String {
        let what = if self.side == WallSide::Inflow { "inflow" } else { "wall" };
        format!("the {what} at {} = {} m", ["x", "y", "z"][self.axis], self.at)
    }
}
