//! Loads, impulses and velocities of a rigid body, about its centre.

use super::Body;
use crate::Result;
use crate::archive::{Archive, Checkpointed};
use nalgebra::Vector3;

/// A force and its torque about a body's centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Force (N; per metre of depth in 2D).
    pub force: Vector3<f64>,
    /// Torque (N m).
    pub torque: Vector3<f64>,
}

/// Momentum that something gives to a body, or to the fluid beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse {
    /// Momentum (N s; per metre of depth in 2D).
    pub linear: Vector3<f64>,
    /// Angular momentum about the body's centre (N m s).
    pub angular: Vector3<f64>,
}

impl Impulse {
    /// Adds momentum (N s) at an arm from the centre (m).
    #[inline(always)]
    pub fn add(&mut self, arm: &Vector3<f64>, momentum: &Vector3<f64>) {
        self.linear += momentum;
        self.angular += arm.cross(momentum);
    }
}

impl std::ops::AddAssign for Impulse {
    fn add_assign(&mut self, other: Impulse) {
        self.linear += other.linear;
        self.angular += other.angular;
    }
}

/// The velocity of a rigid body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigidVelocity {
    /// Velocity of the centre (m/s).
    pub velocity: Vector3<f64>,
    /// Angular velocity (rad/s).
    pub spin: Vector3<f64>,
}

impl RigidVelocity {
    /// The velocity of the body's point at `arm` from its centre (m/s): the rigid motion of eq.
    /// (27).
    #[inline(always)]
    pub fn at(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.spin.cross(arm)
    }
}

/// The velocities of bodies, by their numbers.
pub trait Velocities: Fn(usize) -> RigidVelocity + Copy {}

impl<V: Fn(usize) -> RigidVelocity + Copy> Velocities for V {}

/// The velocities of bodies as they are.
pub fn velocities(bodies: &[Body]) -> impl Velocities + '_ {
    |k: usize| bodies[k].rigid_velocity()
}

impl Checkpointed for Load {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        archive.serialize([&mut self.force, &mut self.torque])
    }
}
