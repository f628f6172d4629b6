//! A body in a step of the contacts.

use super::Impulse;
use super::response::{InverseMass, RIGID};
use crate::particles::{Accelerations, Body, Inertia, Motion};
use mics_shapes::Pose;
use nalgebra::{Matrix3, Vector3};

/// Form of a body as contacts see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// A disc or a sphere.
    Round,
    /// A body of convex parts, which tumbles.
    Parts,
    /// A wall of any shape.
    Obstacle,
}

impl Form {
    /// The form of a body.
    pub(super) fn of(body: &Body) -> Form {
        if body.is_round() {
            Form::Round
        } else if body.is_obstacle() {
            Form::Obstacle
        } else {
            Form::Parts
        }
    }
}

/// A body in a step of the contacts: how it responds, and what acts on it.
#[derive(Clone, Debug)]
pub(super) struct ContactBody {
    pub(super) form: Form,
    pub(super) response: InverseMass,
    /// Where it is not round, its moments of inertia in its own axes, with the fluid that turns
    /// with it (kg m2).
    own_inertia: Matrix3<f64>,
    /// Where it is not round, its pose in the middle of the substep.
    pose: Pose,
    /// Force and torque of its contacts in the substep (N, N m).
    pub(super) load: Impulse,
    /// Rotation in the step, where it is round (rad).
    pub(super) turned: Vector3<f64>,
}

impl ContactBody {
    pub(super) fn new(body: &Body) -> ContactBody {
        ContactBody {
            form: Form::of(body),
            response: RIGID,
            own_inertia: Matrix3::zeros(),
            pose: Pose::default(),
            load: Impulse::default(),
            turned: Vector3::zeros(),
        }
    }

    /// Takes what the body responds with in a step: accelerations by fluid and gravity, its mass
    /// (kg) and its moment of inertia (kg m2) with the fluid's.
    pub(super) fn begin(
        &mut self,
        body: &Body,
        accelerations: &Accelerations,
        mass: f64,
        inertia: &Inertia,
    ) {
        if let Inertia::Tensor(tensor) = inertia {
            let turn = body.orientation();
            self.own_inertia = turn.transpose() * tensor * turn.matrix();
        }
        self.response = InverseMass::of(body, accelerations, mass, inertia);
        self.turned = Vector3::zeros();
    }

    /// Pose of the body in the middle of a substep `h` (s), or now where that is zero.
    pub(super) fn pose(&self, body: &Body, h: f64) -> Pose {
        if h > 0.0 && self.form != Form::Round {
            return self.pose;
        }
        Pose { place: body.centre + 0.5 * h * body.velocity, orientation: body.orientation() }
    }

    /// Finds how the body lies in the middle of a substep `h` (s), and how it responds there, where
    /// it is not round.
    pub(super) fn turn_to_middle(&mut self, body: &Body, h: f64) {
        if self.form == Form::Round {
            return;
        }
        let mut middle = body.clone();
        middle.turn_freely(0.5 * h);
        let orientation = middle.orientation();
        self.pose = Pose { place: body.centre + 0.5 * h * body.velocity, orientation };
        self.response.turn(body, &self.own_inertia, &orientation);
    }

    /// Speed (m/s) at which the body's turning moves its rim: nothing of a round one.
    pub(super) fn rim_speed(&self, body: &Body) -> f64 {
        if self.form == Form::Round { 0.0 } else { body.spin.norm() * body.radius() }
    }

    /// Way (m) that the body, with its rim, may go in `time` (s).
    pub(super) fn way(&self, body: &Body, time: f64) -> f64 {
        let Accelerations { acceleration, angular } = &self.response.accelerations;
        let way = (body.speed() + 0.5 * acceleration.norm() * time) * time;
        if self.form == Form::Round {
            return way;
        }
        let spin = body.spin.norm() + 0.5 * angular.norm() * time;
        way + (spin * time).min(std::f64::consts::TAU) * body.radius()
    }

    /// Moves the body by `h` (s) under constant accelerations; returns the way that it goes (m).
    pub(super) fn travel(
        &mut self,
        body: &mut Body,
        accelerations: &Accelerations,
        h: f64,
        periods: &[Option<f64>; 3],
    ) -> f64 {
        if body.motion == Motion::Fixed {
            return 0.0;
        }
        let rim = self.rim_speed(body);
        let speed = if body.freedom().is_some() {
            (body.velocity + 0.5 * h * accelerations.acceleration).norm()
        } else {
            body.speed()
        };
        self.turned += body.shift(h, accelerations, periods);
        (speed + rim) * h
    }
}
