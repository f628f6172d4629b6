//! Where a pair meets, and how.

use super::arms::Arms;
use super::body::ContactBody;
use super::law::{Kinematics, Law};
use super::pair::{Meeting, Met, Pair, Partner};
use super::response::InverseMass;
use super::setup::Setup;
use super::{Wall, obstacle};
use crate::particles::{Accelerations, Body};
use mics_shapes::{Mesh, Obstacle, Part, Pose, Regions, touch_region};
use nalgebra::Vector3;

/// The bodies as they lie now, and how they respond: what a pair's meeting is found from.
#[derive(Clone, Copy)]
pub(super) struct Layout<'a> {
    pub(super) setup: &'a Setup,
    /// The regions of obstacles in reach of parts of bodies.
    pub(super) regions: &'a Regions,
    pub(super) states: &'a [ContactBody],
    pub(super) bodies: &'a [Body],
}

impl<'a> Layout<'a> {
    /// The law of a pair.
    pub(super) fn law(&self, pair: &Pair) -> &'a Law {
        self.setup.law(pair)
    }

    /// The first body of a pair, and the second, where that is a body or an obstacle.
    pub(super) fn two(&self, pair: &Pair) -> (&'a Body, Option<&'a Body>) {
        (&self.bodies[pair.first], self.bodies.get(pair.second))
    }

    /// Response of the first of a pair, and of the second where that is a body or an obstacle.
    pub(super) fn responses(&self, pair: &Pair) -> (&'a InverseMass, Option<&'a InverseMass>) {
        let second = self.states.get(pair.second).map(|its| &its.response);
        (&self.states[pair.first].response, second)
    }

    /// Energy in the springs of a pair (J).
    pub(super) fn stored(&self, pair: &Pair) -> f64 {
        let overlap = self.closest(pair, 0.0).overlap;
        self.law(pair).stored_with(overlap, &pair.springs.tangential.unwrap_or_default())
    }

    /// The faces of the obstacle of a pair, where its second is one.
    pub(super) fn faces(&self, pair: &Pair) -> Option<&'a Mesh> {
        if pair.partner != Partner::Obstacle {
            return None;
        }
        self.bodies[pair.second].shape().obstacle().map(Obstacle::faces)
    }

    /// Where a pair touches in the middle of a substep `h` (s).
    pub(super) fn closest(&self, pair: &Pair, h: f64) -> Meeting {
        if let Some(faces) = self.faces(pair) {
            return self.of_obstacle(pair, faces, h);
        }
        match (self.setup.wall(pair), pair.round) {
            (None, true) => self.of_balls(pair, h),
            (Some(wall), true) => self.of_ball_and_wall(pair, wall, h),
            (None, false) => self.of_parts(pair, h),
            (Some(wall), false) => self.of_part_and_wall(pair, wall, h),
        }
    }

    /// Where two round bodies touch.
    fn of_balls(&self, pair: &Pair, h: f64) -> Meeting {
        let body = &self.bodies[pair.first];
        let other = &self.bodies[pair.second];
        let velocity = body.velocity - other.velocity;
        let apart = pair.apart(self.bodies, &self.setup.periods) - 0.5 * h * velocity;
        let distance = apart.norm();
        let normal = apart / distance;
        let radii = [body.radius(), other.radius()];
        let overlap = body.radius() + other.radius() - distance;
        let to = [(radii[0] - 0.5 * overlap) * normal, (0.5 * overlap - radii[1]) * normal];
        let arms = Arms { to, normal, couple: 0.0 };
        let approach = velocity.dot(&normal);
        Meeting { normal, overlap, gain: 1.0, arms, spread: 0.0, radii, velocity, approach }
    }

    /// Where a round body touches a wall of the box.
    fn of_ball_and_wall(&self, pair: &Pair, wall: &Wall, h: f64) -> Meeting {
        let body = &self.bodies[pair.first];
        let normal = wall.normal();
        let distance = wall.distance(&body.centre) - 0.5 * h * body.velocity.dot(&normal);
        let velocity = body.velocity - wall.sliding();
        Meeting {
            normal,
            overlap: body.radius() - distance,
            gain: 1.0,
            arms: Arms { to: [distance * normal, Vector3::zeros()], normal, couple: 0.0 },
            spread: 0.0,
            radii: [body.radius(), f64::INFINITY],
            velocity,
            approach: velocity.dot(&normal),
        }
    }

    /// Where the part of a body touches a wall of the box.
    fn of_part_and_wall(&self, pair: &Pair, wall: &Wall, h: f64) -> Meeting {
        let body = &self.bodies[pair.first];
        let pose = self.pose(pair.first, h);
        let offset = if wall.high { wall.at } else { -wall.at };
        let touch = obstacle::with_part(body, pair.parts[0], |part| {
            mics_shapes::touch_plane(part, &pose, &wall.normal(), offset)
        });
        let to = [touch.place - pose.place, Vector3::zeros()];
        let velocity = body.velocity - wall.sliding();
        Meeting::of(&touch, to, velocity, [&body.spin, &Vector3::zeros()])
    }

    /// Where the parts of two bodies touch of which one is not round.
    fn of_parts(&self, pair: &Pair, h: f64) -> Meeting {
        let body = &self.bodies[pair.first];
        let other = &self.bodies[pair.second];
        obstacle::with_part(body, pair.parts[0], |part| {
            obstacle::with_part(other, pair.parts[1], |its_part| {
                self.of_two_parts(pair, part, its_part, h)
            })
        })
    }

    /// Where these parts of a pair touch.
    fn of_two_parts(&self, pair: &Pair, part: &Part, its_part: &Part, h: f64) -> Meeting {
        let body = &self.bodies[pair.first];
        let other = &self.bodies[pair.second];
        let velocity = body.velocity - other.velocity;
        let apart = pair.apart(self.bodies, &self.setup.periods) - 0.5 * h * velocity;
        // About the first body's centre.
        let own = Pose { place: Vector3::zeros(), ..self.pose(pair.first, h) };
        let its = Pose { place: apart, ..self.pose(pair.second, h) };
        let guess = apart + its.orientation * its_part.place - own.orientation * part.place;
        let known = pair.seen.normal != Vector3::zeros();
        let way = if known { &pair.seen.normal } else { &guess };
        let spins = [&body.spin, &other.spin];
        mics_shapes::touch(part, &own, its_part, &its, way).map_or_else(
            || Meeting::too_deep([part, its_part], &guess, [0.5 * apart, -0.5 * apart], velocity),
            |touch| Meeting::of(&touch, [touch.place, touch.place - apart], velocity, spins),
        )
    }

    /// Where the part of a body touches an obstacle.
    fn of_obstacle(&self, pair: &Pair, faces: &Mesh, h: f64) -> Meeting {
        let body = &self.bodies[pair.first];
        let other = &self.bodies[pair.second];
        let velocity = body.velocity - other.velocity;
        let apart = pair.apart(self.bodies, &self.setup.periods) - 0.5 * h * velocity;
        let turn = self.pose(pair.first, h).orientation;
        let its = self.pose(pair.second, h).orientation;
        let own = obstacle::seen(&apart, (!pair.round).then_some(&turn), &its);
        let power = self.law(pair).material.exponent + 1.0;
        let region = self.regions.get(pair.region);
        let mut touch = obstacle::with_part(body, pair.parts[0], |part| {
            touch_region(faces, region, part, &own, power)
        });
        // From the centre of the obstacle, along the axes of the box.
        let arm = its * touch.place;
        touch.normal = its * touch.normal;
        Meeting::of(&touch, [arm + apart, arm], velocity, [&body.spin, &other.spin])
    }

    /// Meeting of a pair now, carried on from an earlier one by the velocities now: to second order
    /// half a substep after.
    pub(super) fn at_end(&self, pair: &Pair, met: &Met) -> Meeting {
        let Met { meeting: met, age, .. } = met;
        let (body, other) = self.two(pair);
        let its_velocity = self.setup.wall(pair).map_or_else(Vector3::zeros, Wall::sliding);
        let its_velocity = other.map_or(its_velocity, |other| other.velocity);
        let velocity = body.velocity - its_velocity;
        let spin = other.map_or_else(Vector3::zeros, |other| other.spin);
        let way = *age * velocity;
        let mut arms = met.arms;
        if other.is_some() {
            arms.to = [arms.to[0] - 0.5 * way, arms.to[1] + 0.5 * way];
        } else {
            arms.to[0] -= way.dot(&met.normal) * met.normal;
        }
        let approach = (velocity + arms.turning([&body.spin, &spin])).dot(&met.normal);
        let overlap = met.overlap + age * met.gain * approach;
        Meeting { overlap, arms, velocity, approach, ..*met }
    }

    /// Pose of a body in the middle of a substep `h` (s), or now where that is zero.
    fn pose(&self, k: usize, h: f64) -> Pose {
        self.states[k].pose(&self.bodies[k], h)
    }

    /// Kinematics of a pair in the middle of a substep `h` (s), and the arms of the contact.
    pub(super) fn kinematics(&self, pair: &Pair, h: f64) -> (Kinematics, Arms) {
        let meeting = self.closest(pair, h);
        (self.kinematics_at(pair, h, &meeting), meeting.arms)
    }

    /// Kinematics of a pair in the middle of a substep `h` (s), from its meeting there.
    pub(super) fn kinematics_at(&self, pair: &Pair, h: f64, meeting: &Meeting) -> Kinematics {
        let &Meeting { normal, overlap, gain, arms, velocity, approach, .. } = meeting;
        let (body, other) = self.two(pair);
        let (response, its_response) = self.responses(pair);
        let mut whole = response.whole;
        let mut inverse = response.mass;
        let Accelerations { mut acceleration, angular } = response.accelerations;
        let mut spin = Vector3::zeros();
        let mut its_angular = Vector3::zeros();
        if let (Some(other), Some(its)) = (other, its_response) {
            spin = other.spin;
            its_angular = its.accelerations.angular;
            acceleration -= its.accelerations.acceleration;
            whole += its.whole;
            inverse += its.mass;
        }
        let turning = arms.turning([&body.spin, &spin]);
        let turned = arms.turning([&angular, &its_angular]);
        if pair.is_own_image() {
            // An impulse and its reaction on the same body move it nowhere, and turn it twice.
            inverse = Vector3::zeros();
        }
        let along = |v: Vector3<f64>, turning: Vector3<f64>| {
            let v = v + turning;
            v - v.dot(&normal) * normal
        };
        let inverse_turn = self.turning_response(pair, &arms);
        // Along an axis where neither gives way the damper changes nothing, but has to stay finite.
        let finite = |inverse: f64| if inverse > 1e-6 * whole { inverse } else { whole };
        Kinematics {
            h,
            overlap,
            gain,
            normal,
            approach,
            slip: along(velocity, turning),
            accelerations: acceleration.dot(&normal)
                + if pair.round { 0.0 } else { turned.dot(&normal) },
            push_slip: along(acceleration, turned),
            inverse_normal: finite(normal.component_mul(&normal).dot(&inverse) + inverse_turn[0]),
            inverse_tangential: finite(inverse.max() + inverse_turn[1]),
        }
    }

    /// Response of a pair's surfaces at the contact by turning (1/kg): along the normal, and the
    /// largest across it. That of round ones is the same all across.
    fn turning_response(&self, pair: &Pair, arms: &Arms) -> [f64; 2] {
        let to = &arms.to;
        let normal = &arms.normal;
        let (first, second) = self.responses(pair);
        let first = &first.inertia;
        let second = second.map(|its| &its.inertia);
        if pair.round {
            let sides = match (pair.is_own_image(), second) {
                (true, _) => (to[0] - to[1]).norm_squared() * first.max(),
                (_, Some(its)) => {
                    to[0].norm_squared() * first.max() + to[1].norm_squared() * its.max()
                }
                _ => to[0].norm_squared() * first.max(),
            };
            return [0.0, sides];
        }
        // Velocity along one of a and b, by turning, over an impulse along the other (1/kg).
        let response = |a: &Vector3<f64>, b: &Vector3<f64>| {
            let [one, its_one] = arms.turns(a);
            let [other, its_other] = arms.turns(b);
            match second {
                Some(_) if pair.is_own_image() => {
                    (one + its_one).dot(&first.of(&(other + its_other)))
                }
                Some(its) => one.dot(&first.of(&other)) + its_one.dot(&its.of(&its_other)),
                None => one.dot(&first.of(&other)),
            }
        };
        let about = if normal.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
        let t = about.cross(normal).normalize();
        let s = normal.cross(&t);
        let [tt, ts, ss] = [response(&t, &t), response(&t, &s), response(&s, &s)];
        let across = 0.5 * (tt + ss) + (0.25 * (tt - ss) * (tt - ss) + ts * ts).sqrt();
        [response(normal, normal), across]
    }
}
