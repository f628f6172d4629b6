//! Sums over the ranks for each body in a step.

use crate::particles::{Body, Impulse, Load, RigidVelocity};
use crate::sums::{BodySums, Messages, Summed};
use nalgebra::Vector3;

/// Sums over the ranks for each body, and the scratch of their messages.
pub struct Sums {
    pub forces: BodySums<SurfaceForces>,
    pub momenta: BodySums<CellMomentum>,
    pub vectors: BodySums<Vector3<f64>>,
    pub responses: BodySums<Response>,
    pub filled: BodySums<Load>,
    pub messages: Messages,
}

impl Sums {
    /// Sums for `n` bodies.
    pub fn with_capacity(n: usize) -> Sums {
        Sums {
            forces: BodySums::with_capacity(n),
            momenta: BodySums::with_capacity(n),
            vectors: BodySums::with_capacity(n),
            responses: BodySums::with_capacity(n),
            filled: BodySums::with_capacity(n),
            messages: Messages::default(),
        }
    }
}

/// Loads on a body at its surface.
#[derive(Clone, Copy, Debug, Default)]
pub struct SurfaceForces {
    /// By pressure; its torque on a body that is not round.
    pub pressure: Load,
    /// By wall shear.
    pub shear: Load,
}

/// Momentum of the cells of a body: linear (kg m/s), angular momentum about its centre (kg m2/s).
#[derive(Clone, Copy, Debug, Default)]
pub struct CellMomentum {
    /// Momentum that ghost cells and cut cells have given to the flow since the exchange was set to
    /// zero.
    pub exchanged: Impulse,
    /// Inside the body, relative to its own motion.
    pub inside: Vector3<f64>,
    pub swirl: Vector3<f64>,
}

impl CellMomentum {
    /// Momentum and angular momentum inside a body in all.
    pub fn whole(&self, fluid_density: f64, body: &Body) -> (Vector3<f64>, Vector3<f64>) {
        (
            self.inside + fluid_density * body.volume() * body.velocity,
            self.swirl + body.inertia().times(fluid_density / body.density).of(&body.spin),
        )
    }
}

impl Summed for SurfaceForces {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        self.pressure.each(take);
        self.shear.each(take);
    }
}

impl Summed for CellMomentum {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        let CellMomentum { exchanged, inside, swirl } = self;
        let all = [&mut exchanged.linear, &mut exchanged.angular, inside, swirl];
        all.into_iter().for_each(|v| v.each(take));
    }
}

/// Velocity and load by pressure that a body has after a solve of the pressure.
#[derive(Clone, Copy, Debug, Default)]
pub struct Response {
    /// Its velocity.
    pub motion: RigidVelocity,
    /// Its load by pressure.
    pub pressure: Load,
}

impl Summed for Response {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        self.motion.each(take);
        self.pressure.each(take);
    }
}
