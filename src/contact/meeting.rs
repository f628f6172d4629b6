//! Where a pair meets, and how.

use super::Contacts;
use super::law::Kinematics;
use super::pair::Pair;
use crate::particles::Body;
use mics_shapes::{Part, Pose, Touch};
use nalgebra::Vector3;

/// How what acts at a contact turns its two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arms {
    /// From the centres to the contact (m).
    pub(super) to: [Vector3<f64>; 2],
    /// From the first to the second.
    pub(super) normal: Vector3<f64>,
    /// Couple about the normal (N m) of a force along it, over that (N).
    pub(super) couple: f64,
}

impl Arms {
    /// What an impulse (N s) on the first, and its opposite on the second, give both of angular
    /// momentum (N m s).
    #[inline]
    pub(super) fn turns(&self, impulse: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let turns = [self.to[0].cross(impulse), -self.to[1].cross(impulse)];
        if self.couple == 0.0 {
            return turns;
        }
        let couple = self.couple * impulse.dot(&self.normal) * self.normal;
        [turns[0] + couple, turns[1] - couple]
    }

    /// Velocity of the first against the second at the contact by their spins (rad/s), with what
    /// the couple makes of them along the normal (m/s).
    #[inline]
    pub(super) fn turning(&self, spins: [&Vector3<f64>; 2]) -> Vector3<f64> {
        self.coupled(spins[0].cross(&self.to[0]) - spins[1].cross(&self.to[1]), spins)
    }

    /// A velocity (m/s) with what the couple makes of spins.
    #[inline]
    pub(super) fn coupled(
        &self,
        velocity: Vector3<f64>,
        spins: [&Vector3<f64>; 2],
    ) -> Vector3<f64> {
        if self.couple == 0.0 {
            return velocity;
        }
        velocity + self.couple * (spins[0] - spins[1]).dot(&self.normal) * self.normal
    }
}

/// Where a pair touches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    /// From the first to the second.
    pub(super) normal: Vector3<f64>,
    /// Negative where they do not (m).
    pub(super) overlap: f64,
    /// By how much the overlap of a patch grows where the two approach at its place.
    pub(super) gain: f64,
    pub(super) arms: Arms,
    /// Radius of the patch (m).
    pub(super) spread: f64,
    /// Local radii of curvature (m).
    pub(super) radii: [f64; 2],
    /// Relative velocity of the centres (m/s).
    pub(super) velocity: Vector3<f64>,
    /// Speed of approach at the contact (m/s).
    pub(super) approach: f64,
}

/// A meeting as it was found, of a pair of which one is not round.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub(super) meeting: Meeting,
    /// How long ago (s), or in the middle of a substep to come where negative.
    pub(super) age: f64,
    /// What the two had gone since the search, together (m).
    pub(super) gone: f64,
}

impl Meeting {
    /// Whether they touch during a substep `h` (s) in whose middle this is.
    pub(super) fn touches(&self, h: f64) -> bool {
        self.overlap > 0.0 || self.overlap + 0.5 * h * (self.gain * self.approach).abs() > 0.0
    }
}

impl Contacts {
    /// Where a pair touches in the middle of a substep `h` (s).
    pub(super) fn closest(&self, pair: &Pair, bodies: &[Body], h: f64) -> Meeting {
        let body = &bodies[pair.first];
        match bodies.get(pair.second) {
            Some(other) if body.is_round() && other.is_round() => {
                let velocity = body.velocity - other.velocity;
                let apart = pair.apart(bodies, &self.periods) - 0.5 * h * velocity;
                let distance = apart.norm();
                let normal = apart / distance;
                let radii = [body.radius(), other.radius()];
                let overlap = body.radius() + other.radius() - distance;
                let to = [(radii[0] - 0.5 * overlap) * normal, (0.5 * overlap - radii[1]) * normal];
                let arms = Arms { to, normal, couple: 0.0 };
                let approach = velocity.dot(&normal);
                Meeting { normal, overlap, gain: 1.0, arms, spread: 0.0, radii, velocity, approach }
            }
            None if body.is_round() => {
                let wall = &self.walls[pair.second - bodies.len()];
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
            _ => self.touch_of_parts(pair, bodies, h),
        }
    }

    /// The same of a body that is not round.
    fn touch_of_parts(&self, pair: &Pair, bodies: &[Body], h: f64) -> Meeting {
        let body = &bodies[pair.first];
        if let Some(wall) = bodies.get(pair.second).and_then(|other| other.shape().obstacle()) {
            return self.touch_of_obstacle(pair, bodies, wall, h);
        }
        let pose = self.pose(pair.first, bodies, h);
        let (ball, its_ball);
        let part = match body.parts().get(pair.parts[0]) {
            Some(part) => part,
            None => {
                ball = Part::ball(Vector3::zeros(), body.radius());
                &ball
            }
        };
        let Some(other) = bodies.get(pair.second) else {
            let wall = &self.walls[pair.second - bodies.len()];
            let offset = if wall.high { wall.at } else { -wall.at };
            let touch = mics_shapes::touch_plane(part, &pose, &wall.normal(), offset);
            let to = [touch.place - pose.place, Vector3::zeros()];
            let velocity = body.velocity - wall.sliding();
            return Meeting::of(&touch, to, velocity, [&body.spin, &Vector3::zeros()]);
        };
        let its_part = match other.parts().get(pair.parts[1]) {
            Some(part) => part,
            None => {
                its_ball = Part::ball(Vector3::zeros(), other.radius());
                &its_ball
            }
        };
        let velocity = body.velocity - other.velocity;
        let apart = pair.apart(bodies, &self.periods) - 0.5 * h * velocity;
        // About the first body's centre.
        let own = Pose { place: Vector3::zeros(), ..pose };
        let its = Pose { place: apart, ..self.pose(pair.second, bodies, h) };
        let guess = apart + its.orientation * its_part.place - own.orientation * part.place;
        let known = pair.seen != Vector3::zeros();
        let way = if known { &pair.seen } else { &guess };
        let spins = [&body.spin, &other.spin];
        mics_shapes::touch(part, &own, its_part, &its, way).map_or_else(
            || Meeting::too_deep([part, its_part], &guess, [0.5 * apart, -0.5 * apart], velocity),
            |touch| Meeting::of(&touch, [touch.place, touch.place - apart], velocity, spins),
        )
    }

    /// How a pair meets of which it is known how it met a while ago, by its velocities now: to
    /// second order half a substep after.
    pub(super) fn at_end(&self, pair: &Pair, bodies: &[Body], met: &Met) -> Meeting {
        let Met { meeting: met, age, .. } = met;
        let body = &bodies[pair.first];
        let (velocity, spin) = match bodies.get(pair.second) {
            Some(other) => (body.velocity - other.velocity, other.spin),
            None => {
                let wall = &self.walls[pair.second - bodies.len()];
                (body.velocity - wall.sliding(), Vector3::zeros())
            }
        };
        let way = *age * velocity;
        let mut arms = met.arms;
        if bodies.get(pair.second).is_some() {
            arms.to = [arms.to[0] - 0.5 * way, arms.to[1] + 0.5 * way];
        } else {
            arms.to[0] -= way.dot(&met.normal) * met.normal;
        }
        let approach = (velocity + arms.turning([&body.spin, &spin])).dot(&met.normal);
        let overlap = met.overlap + age * met.gain * approach;
        Meeting { overlap, arms, velocity, approach, ..*met }
    }

    /// How a body lies in the middle of a substep `h` (s), or now.
    pub(super) fn pose(&self, k: usize, bodies: &[Body], h: f64) -> Pose {
        let body = &bodies[k];
        if h > 0.0 && !body.is_round() {
            return self.poses[k];
        }
        Pose { place: body.centre + 0.5 * h * body.velocity, orientation: body.orientation() }
    }

    /// Finds how the bodies that are not round lie in the middle of a substep `h` (s), and how they
    /// respond there.
    pub(super) fn turn_to_middle(&mut self, bodies: &[Body], h: f64) {
        let turning = bodies.iter().enumerate().filter(|(_, body)| !body.is_round());
        for (k, body) in turning.filter(|(k, _)| self.paired[*k]) {
            let mut middle = body.clone();
            middle.turn_freely(0.5 * h);
            let orientation = middle.orientation();
            self.poses[k] = Pose { place: body.centre + 0.5 * h * body.velocity, orientation };
            self.inverse_masses[k].turn(body, &self.own_inertias[k], &orientation);
        }
    }

    /// How a pair meets in the middle of a substep `h` (s), and the arms of the contact.
    pub(super) fn kinematics(&self, pair: &Pair, bodies: &[Body], h: f64) -> (Kinematics, Arms) {
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
        let body = &bodies[pair.first];
        let inverse_mass = &self.inverse_masses[pair.first];
        let &Meeting { normal, overlap, gain, arms, velocity, approach, .. } = meeting;
        let (mut whole, mut inverse, mut accelerations) =
            (inverse_mass.whole, inverse_mass.mass, inverse_mass.accelerations);
        let mut spin = Vector3::zeros();
        let mut angular = Vector3::zeros();
        if let Some(other) = bodies.get(pair.second) {
            let its = &self.inverse_masses[pair.second];
            (spin, angular) = (other.spin, its.accelerations.angular);
            accelerations.acceleration -= its.accelerations.acceleration;
            whole += its.whole;
            inverse += its.mass;
        }
        let turning = arms.turning([&body.spin, &spin]);
        let turned = arms.turning([&accelerations.angular, &angular]);
        let accelerations = accelerations.acceleration;
        let round = self.are_round(pair, bodies);
        if pair.is_own_image() {
            // An impulse and its reaction on the same body move it nowhere, and turn it twice.
            inverse = Vector3::zeros();
        }
        let along = |v: Vector3<f64>, turning: Vector3<f64>| {
            let v = v + turning;
            v - v.dot(&normal) * normal
        };
        let inverse_turn = self.turning_response(pair, &arms, round);
        // Along an axis where neither gives way the damper changes nothing, but has to stay finite.
        let finite = |inverse: f64| if inverse > 1e-6 * whole { inverse } else { whole };
        Kinematics {
            h,
            overlap,
            gain,
            normal,
            approach,
            slip: along(velocity, turning),
            accelerations: accelerations.dot(&normal)
                + if round { 0.0 } else { turned.dot(&normal) },
            push_slip: along(accelerations, turned),
            inverse_normal: finite(normal.component_mul(&normal).dot(&inverse) + inverse_turn[0]),
            inverse_tangential: finite(inverse.max() + inverse_turn[1]),
        }
    }

    /// How the surfaces of a pair respond at the contact by turning (1/kg): along the normal, and
    /// most across it. That of round ones is the same all across.
    fn turning_response(&self, pair: &Pair, arms: &Arms, round: bool) -> [f64; 2] {
        let to = &arms.to;
        let normal = &arms.normal;
        let first = &self.inverse_masses[pair.first].inertia;
        let second = self.inverse_masses.get(pair.second).map(|its| &its.inertia);
        if round {
            let sides = match (pair.is_own_image(), second) {
                (true, _) => (to[0] - to[1]).norm_squared() * first.max(),
                (_, Some(its)) => {
                    to[0].norm_squared() * first.max() + to[1].norm_squared() * its.max()
                }
                _ => to[0].norm_squared() * first.max(),
            };
            return [0.0, sides];
        }
        // By what impulses along a and b turn both.
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

impl Meeting {
    /// That of two parts whose centres are so far from the place (m) and have a relative velocity
    /// (m/s), and spins (rad/s).
    pub(super) fn of(
        touch: &Touch,
        to: [Vector3<f64>; 2],
        velocity: Vector3<f64>,
        spins: [&Vector3<f64>; 2],
    ) -> Meeting {
        let &Touch { normal, overlap, gain, couple, spread, radii, .. } = touch;
        let arms = Arms { to, normal, couple };
        let approach = (velocity + arms.turning(spins)).dot(&normal);
        Meeting { normal, overlap, gain, arms, spread, radii, velocity, approach }
    }

    /// That of two parts beyond what a soft contact can be: as deep as the skins are thick.
    fn too_deep(
        parts: [&Part; 2],
        way: &Vector3<f64>,
        to: [Vector3<f64>; 2],
        velocity: Vector3<f64>,
    ) -> Meeting {
        let normal = way.try_normalize(0.0).unwrap_or_else(Vector3::x);
        Meeting {
            normal,
            overlap: parts[0].rounding + parts[1].rounding,
            gain: 1.0,
            arms: Arms { to, normal, couple: 0.0 },
            spread: 0.0,
            radii: parts.map(|part| part.radius),
            velocity,
            approach: velocity.dot(&normal),
        }
    }
}
