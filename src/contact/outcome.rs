//! Outcome of the contacts in a step.

use super::Impulse;
use super::arms::PairImpulse;
use super::pair::Pair;
use crate::particles::Body;
use nalgebra::Vector3;

/// Outcome of the contacts in a step, which the correction of their impulses goes on with.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Substeps taken: 0 where no body is in reach of another or of a wall, and all have made one
    /// ballistic move.
    pub substeps: usize,
    /// Per body.
    pub bodies: Vec<BodyOutcome>,
    /// Momentum that bodies gave to walls (N s).
    pub wall_impulse: Vector3<f64>,
    /// Work of moving walls on bodies (J).
    pub wall_work: f64,
    /// Energy that friction took (J): the work of tangential forces and of the resistance to
    /// rolling, less what their springs hold.
    pub friction_loss: f64,
    /// Deepest overlap of two bodies, or of one and a wall (m).
    pub deepest: f64,
}

/// Outcome of the contacts of a body in a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct BodyOutcome {
    /// Impulse that they gave to it.
    pub impulse: Impulse,
    /// Whether it touched another or a wall, or came as near as their asperities are high.
    pub touched: bool,
    /// Damping of its spin by contacts (N m s): without bound where it touches.
    pub damping: f64,
}

impl Outcome {
    /// Nothing yet, for so many bodies.
    pub(super) fn new(bodies: usize) -> Outcome {
        Outcome { bodies: vec![BodyOutcome::default(); bodies], ..Outcome::default() }
    }

    /// Forgets the step before.
    pub(super) fn clear(&mut self) {
        let mut bodies = std::mem::take(&mut self.bodies);
        bodies.fill(BodyOutcome::default());
        *self = Outcome { bodies, ..Outcome::default() };
    }

    /// Impulse that contacts gave to a body.
    pub fn impulse(&self, body: usize) -> Impulse {
        self.bodies[body].impulse
    }

    /// Part of a change of a body's spin, which the substeps did not expect, that contacts leave
    /// over the step `dt` (s): all without any, nothing of a body that touches. `inertia` is the
    /// moment of inertia about an axis (kg m2), the fluid's included.
    pub fn contact_damping(&self, body: usize, inertia: f64, dt: f64) -> f64 {
        1.0 / (1.0 + dt * self.bodies[body].damping / inertia)
    }

    /// Counts corrections of the impulses of the bodies.
    pub(super) fn add(&mut self, corrections: &[Impulse]) {
        for (body, correction) in self.bodies.iter_mut().zip(corrections) {
            body.impulse += *correction;
        }
    }

    /// Takes note that a pair touches.
    pub(super) fn touch(&mut self, pair: &Pair) {
        for body in [pair.first, pair.second] {
            if let Some(body) = self.bodies.get_mut(body) {
                body.touched = true;
            }
        }
    }

    /// Counts the impulse that a pair gave to a wall of this velocity (m/s).
    pub(super) fn strike_wall(&mut self, impulse: &PairImpulse, velocity: &Vector3<f64>) {
        self.wall_impulse -= impulse.linear;
        self.wall_work += impulse.linear.dot(velocity);
    }

    /// Finds how strongly pairs damp the spins of bodies: without bound where they touch, and else
    /// by lubrication.
    pub(super) fn find_damping(&mut self, pairs: &[Pair], bodies: &[Body]) {
        for pair in pairs {
            for k in [pair.first, pair.second] {
                let Some(body) = bodies.get(k) else { continue };
                // The surfaces of a body and of its own image slide with both spins, and both turn
                // the body.
                let sides = if pair.is_own_image() { 2.0 } else { 1.0 };
                let lubrication = &pair.film.lubrication;
                let resistance = sides * lubrication.sliding + lubrication.rolling;
                let lubrication = body.radius().powi(2) * resistance;
                self.bodies[k].damping += if pair.touched() { f64::INFINITY } else { lubrication };
            }
        }
    }
}
