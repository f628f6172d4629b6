//! What acts on a rigid body, and how it moves, about its centre.

use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::sums::Summed;
use nalgebra::Vector3;

/// A force and its torque about a body's centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Force (N; per metre of depth in 2D).
    pub force: Vector3<f64>,
    /// Torque (N m).
    pub torque: Vector3<f64>,
}

/// The velocity of a rigid body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigidVelocity {
    /// Of the centre (m/s).
    pub velocity: Vector3<f64>,
    /// Angular velocity (rad/s).
    pub spin: Vector3<f64>,
}

impl Summed for Load {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        self.force.each(take);
        self.torque.each(take);
    }
}

impl Summed for RigidVelocity {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        self.velocity.each(take);
        self.spin.each(take);
    }
}

impl Checkpointed for Load {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        archive.serialize([&mut self.force, &mut self.torque])
    }
}
