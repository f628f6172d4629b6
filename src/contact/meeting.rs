//! How a pair meets, and how its two respond to forces.

use super::Contacts;
use super::law::Kinematics;
use super::pair::Pair;
use crate::particles::{Accelerations, Body, Inertia};
use nalgebra::Vector3;

/// How a body responds to forces: zero along the axes where it does not.
#[derive(Clone, Copy, Debug)]
pub(super) struct InverseMass {
    /// Inverse mass of a free body, whatever its axes (1/kg).
    pub(super) whole: f64,
    /// 1/kg.
    pub(super) mass: Vector3<f64>,
    /// 1/(kg m2).
    pub(super) inertia: Vector3<f64>,
    pub(super) accelerations: Accelerations,
}

pub(super) const RIGID: InverseMass = InverseMass {
    whole: 0.0,
    mass: Vector3::new(0.0, 0.0, 0.0),
    inertia: Vector3::new(0.0, 0.0, 0.0),
    accelerations: Accelerations {
        acceleration: Vector3::new(0.0, 0.0, 0.0),
        angular: Vector3::new(0.0, 0.0, 0.0),
    },
};

impl InverseMass {
    pub(super) fn of(
        body: &Body,
        accelerations: &Accelerations,
        mass: f64,
        inertia: &Inertia,
    ) -> InverseMass {
        let Some(freedom) = body.freedom() else { return RIGID };
        let ones = |free: [bool; 3]| Vector3::from(free.map(|f| if f { 1.0 } else { 0.0 }));
        let (along, about) = (ones(freedom.translation), ones(freedom.rotation));
        InverseMass {
            whole: 1.0 / mass,
            mass: along / mass,
            inertia: inertia.inverse_mass(&Vector3::repeat(1.0), &freedom),
            accelerations: Accelerations {
                acceleration: accelerations.acceleration.component_mul(&along),
                angular: accelerations.angular.component_mul(&about),
            },
        }
    }

    /// Multiplies the inverse mass by a factor.
    pub(super) fn scale(&mut self, factor: f64) {
        self.whole *= factor;
        self.mass *= factor;
    }
}

/// Where a pair touches.
pub(super) struct Meeting {
    /// From the first to the second.
    pub(super) normal: Vector3<f64>,
    /// Negative where they do not (m).
    pub(super) overlap: f64,
    /// From the centres to the contact (m).
    pub(super) arms: [f64; 2],
    /// Relative velocity of the centres (m/s).
    pub(super) velocity: Vector3<f64>,
}

impl Meeting {
    /// Whether they touch during a substep `h` (s) in whose middle this is.
    pub(super) fn touches(&self, h: f64) -> bool {
        self.overlap > 0.0 || self.overlap + 0.5 * h * self.velocity.dot(&self.normal).abs() > 0.0
    }
}

impl Contacts {
    /// Where a pair touches in the middle of a substep `h` (s).
    pub(super) fn closest(&self, pair: &Pair, bodies: &[Body], h: f64) -> Meeting {
        let body = &bodies[pair.first];
        match bodies.get(pair.second) {
            Some(other) => {
                let velocity = body.velocity - other.velocity;
                let apart = pair.apart(bodies, &self.periods) - 0.5 * h * velocity;
                let distance = apart.norm();
                let overlap = body.radius() + other.radius() - distance;
                let arms = [body.radius() - 0.5 * overlap, other.radius() - 0.5 * overlap];
                Meeting { normal: apart / distance, overlap, arms, velocity }
            }
            None => {
                let wall = &self.walls[pair.second - bodies.len()];
                let normal = wall.normal();
                let distance = wall.distance(&body.centre) - 0.5 * h * body.velocity.dot(&normal);
                let velocity = body.velocity - wall.sliding();
                Meeting {
                    normal,
                    overlap: body.radius() - distance,
                    arms: [distance, 0.0],
                    velocity,
                }
            }
        }
    }

    /// How a pair meets in the middle of a substep `h` (s), and the arms from the centres to the
    /// contact (m).
    pub(super) fn kinematics(
        &self,
        pair: &Pair,
        bodies: &[Body],
        h: f64,
    ) -> (Kinematics, [f64; 2]) {
        let meeting = self.closest(pair, bodies, h);
        (self.kinematics_at(pair, bodies, h, &meeting), meeting.arms)
    }

    /// The same where it is known where they touch.
    pub(super) fn kinematics_at(
        &self,
        pair: &Pair,
        bodies: &[Body],
        h: f64,
        meeting: &Meeting,
    ) -> Kinematics {
        let (body, inverse_mass) = (&bodies[pair.first], &self.inverse_masses[pair.first]);
        let &Meeting { normal, overlap, arms, velocity } = meeting;
        let (mut turning, mut turned) =
            (arms[0] * body.spin, arms[0] * inverse_mass.accelerations.angular);
        let (mut whole, mut inverse, mut accelerations) =
            (inverse_mass.whole, inverse_mass.mass, inverse_mass.accelerations.acceleration);
        let mut inverse_turn = arms[0] * arms[0] * inverse_mass.inertia.max();
        if let Some(other) = bodies.get(pair.second) {
            let its = &self.inverse_masses[pair.second];
            turning += arms[1] * other.spin;
            turned += arms[1] * its.accelerations.angular;
            accelerations -= its.accelerations.acceleration;
            whole += its.whole;
            inverse += its.mass;
            inverse_turn += arms[1] * arms[1] * its.inertia.max();
        }
        if pair.is_own_image() {
            // An impulse and its reaction on the same body move it nowhere, and turn it twice.
            inverse = Vector3::zeros();
            inverse_turn = (arms[0] + arms[1]).powi(2) * inverse_mass.inertia.max();
        }
        let along = |v: Vector3<f64>, turning: Vector3<f64>| {
            v - v.dot(&normal) * normal + turning.cross(&normal)
        };
        // Along an axis where neither gives way the damper changes nothing, but has to stay finite.
        let finite = |inverse: f64| if inverse > 1e-6 * whole { inverse } else { whole };
        Kinematics {
            h,
            overlap,
            normal,
            approach: velocity.dot(&normal),
            slip: along(velocity, turning),
            accelerations: accelerations.dot(&normal),
            push_slip: along(accelerations, turned),
            inverse_normal: finite(normal.component_mul(&normal).dot(&inverse)),
            inverse_tangential: finite(inverse.max() + inverse_turn),
        }
    }
}
