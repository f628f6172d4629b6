//! Substeps: how many, the kick by pushes and contacts, the drift; formulas in [`super`].

use super::law::{Kinematics, Law};
use super::lubrication::Lubrication;
use super::{Contacts, DEEPEST_OVERLAP, Impulse, Pair, Substeps, WallSide};
use crate::config::MOST_SUBSTEPS;
use crate::numerics::Numerics;
use crate::particles::{Accelerations, Body, Inertia, Motion};
use crate::{Error, Result};
use nalgebra::Vector3;

/// Substeps in a contact below which a run ends.
const FEWEST_PER_CONTACT: f64 = 5.0;
/// Part of a gap by which it may change before what fills it is found anew.
const SAME_GAP: f64 = 1e-3;
/// Gap that is none (of the radius).
pub(super) const TOUCHING: f64 = 1e-9;

/// How a body responds to forces: zero along the axes where it does not.
#[derive(Clone, Copy, Debug)]
pub(super) struct InverseMass {
    /// Inverse mass of a free body, whatever its axes (1/kg).
    whole: f64,
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

/// Fewest substeps of a step in which the fluid between two acts: what resists their approach,
/// their sliding and their rolling does so one after the other (a sphere pulled along a wall at
/// 0.02 h: 3 % too fast in one substep, 0.15 % in 20).
fn fewest_of_films(numerics: &Numerics) -> f64 {
    0.5 * numerics.contact_substeps
}

impl Contacts {
    /// Substeps for the rest of the step, `time` (s), after those `taken`.
    pub(super) fn count(&self, bodies: &[Body], time: f64, taken: usize) -> Result<usize> {
        self.pairs
            .iter()
            .try_fold(1, |count, pair| Ok(count.max(self.count_for(pair, bodies, time, taken)?)))
    }

    /// Those that a pair needs.
    fn count_for(&self, pair: &Pair, bodies: &[Body], time: f64, taken: usize) -> Result<usize> {
        let lubrication = self.apart(pair, bodies, time);
        match (self.substeps, lubrication) {
            // The fluid between them alone counts.
            (Substeps::Auto, Some(wanted)) => Ok(wanted.ceil() as usize),
            (Substeps::Fixed(_), Some(_)) => Ok(1),
            (Substeps::Auto, None) => {
                let (law, mass, contact) = self.contact_of(pair, bodies, time);
                let wanted = self.numerics.contact_substeps * time / contact
                    * law.damping_ratio(mass).max(1.0);
                let wanted = if self.medium.range(&self.numerics) > 0.0 {
                    wanted.max(fewest_of_films(&self.numerics))
                } else {
                    wanted
                };
                if wanted > MOST_SUBSTEPS {
                    Err(self.too_stiff(pair, contact, time, wanted))
                } else {
                    Ok(wanted.ceil() as usize)
                }
            }
            (Substeps::Fixed(n), None) => {
                let (_, _, contact) = self.contact_of(pair, bodies, time);
                let count = n.saturating_sub(taken).max(1);
                if contact / time * (count as f64) < FEWEST_PER_CONTACT {
                    Err(self.too_few(pair, contact, time / count as f64))
                } else {
                    Ok(count)
                }
            }
        }
    }

    /// Speed (m/s) at which a pair may come to approach within `time` (s).
    fn pushed(&self, pair: &Pair, bodies: &[Body], time: f64) -> f64 {
        let mut velocity = bodies[pair.first].velocity;
        let mut accelerations = self.inverse_masses[pair.first].accelerations.acceleration;
        if let Some(other) = bodies.get(pair.second) {
            velocity -= other.velocity;
            accelerations -= self.inverse_masses[pair.second].accelerations.acceleration;
        }
        velocity.norm() + accelerations.norm() * time
    }

    /// How many substeps the fluid between a pair wants in `time` (s), where the two cannot touch
    /// in it, whatever strikes them.
    fn apart(&self, pair: &Pair, bodies: &[Body], time: f64) -> Option<f64> {
        let gap = -self.closest(pair, bodies, 0.0).overlap;
        let way = self.pushed(pair, bodies, time) * time;
        let fewest = if gap < self.medium.range(&self.numerics) {
            fewest_of_films(&self.numerics)
        } else {
            1.0
        };
        let most = self.numerics.contact_substeps;
        let wanted =
            || (self.numerics.gap_substeps * way / (gap - way).max(0.25 * gap)).clamp(fewest, most);
        // A body never touches its own image.
        (pair.is_own_image() || gap > 2.0 * way + 0.05 * bodies[pair.first].radius()).then(wanted)
    }

    /// The law of a pair, its mass (kg), and how long a contact lasts at the speed that it may come
    /// to within `time` (s).
    fn contact_of(&self, pair: &Pair, bodies: &[Body], time: f64) -> (&Law, f64, f64) {
        let (law, kinematics) = (self.law(pair), self.kinematics(pair, bodies, 0.0).0);
        let (mass, pushed) = (1.0 / kinematics.inverse_normal, self.pushed(pair, bodies, time));
        // The energy of an overlap counts as that of an approach.
        let speed = (pushed * pushed + 2.0 * law.stored(kinematics.overlap) / mass).sqrt();
        (law, mass, law.contact_time(mass, speed))
    }

    /// Finds after how many of `count` substeps of `time` (s) the fluid between each pair is to
    /// act.
    pub(super) fn pace_films(&mut self, bodies: &[Body], time: f64, count: usize) {
        for p in 0..self.pairs.len() {
            let wanted = self.apart(&self.pairs[p], bodies, time);
            let stride = wanted.map_or(1.0, |wanted| count as f64 / wanted);
            self.pairs[p].stride = (stride as usize).max(1);
        }
    }

    fn too_stiff(&self, pair: &Pair, contact: f64, time: f64, wanted: f64) -> Error {
        Error::Run(format!(
            "{}: a contact lasts {contact:.3e} s, for which a step of {time:.3e} s would need \
            {wanted:.1e} substeps: lower the \
             stiffness or shorten the step",
            self.name(pair),
        ))
    }

    fn too_few(&self, pair: &Pair, contact: f64, substep: f64) -> Error {
        Error::Run(format!(
            "{}: a contact lasts {contact:.3e} s, which are {:.2} substeps of {substep:.3e} s, and \
            {FEWEST_PER_CONTACT} at \
             least are needed: raise contact.substeps or lower the stiffness",
            self.name(pair),
            contact / substep,
        ))
    }

    /// A locked axis along which a body of the pair is driven on: its number, the axis, and its
    /// velocity there (m/s).
    fn driven_on(
        &self,
        pair: &Pair,
        bodies: &[Body],
        kinematics: &Kinematics,
    ) -> Option<(usize, usize, f64)> {
        let locked = [pair.first, pair.second]
            .into_iter()
            .filter(|&k| k < bodies.len() && self.inverse_masses[k].whole > 0.0);
        let axes = locked
            .flat_map(|k| (0..3).map(move |axis| (k, axis)))
            .filter(|(k, axis)| self.inverse_masses[*k].mass[*axis] == 0.0);
        let along = |(k, axis): (usize, usize)| bodies[k].velocity[axis];
        let fast = axes.filter(|&at| {
            (along(at) * kinematics.normal[at.1]).abs() > 0.5 * kinematics.approach.abs()
        });
        fast.max_by(|&a, &b| along(a).abs().total_cmp(&along(b).abs()))
            .map(|at| (at.0, at.1, along(at)))
    }

    fn too_deep(
        &self,
        pair: &Pair,
        bodies: &[Body],
        kinematics: &Kinematics,
        radius: f64,
    ) -> Error {
        if let Some((k, axis, velocity)) = self.driven_on(pair, bodies, kinematics) {
            return Error::Run(format!(
                "{} overlap by {:.3e} m, {:.2} of the smaller radius, where {} is the limit: \
                particle {} goes on along {} at {velocity:.3e} m/s, \
                 which is locked, so that nothing stops it; unlock that axis, give it no velocity \
                 along it, or end the run before",
                self.name(pair),
                kinematics.overlap,
                kinematics.overlap / radius,
                DEEPEST_OVERLAP,
                self.ids[k],
                ["x", "y", "z"][axis],
            ));
        }
        let (overlap, law, mass) =
            (kinematics.overlap, self.law(pair), 1.0 / kinematics.inverse_normal);
        let exponent = law.material.exponent;
        // What strikes, or presses by what pushes the two, stopped at a fiftieth of the radius.
        let accelerations = |k: usize| {
            self.inverse_masses
                .get(k)
                .map_or_else(Vector3::zeros, |inverse_mass| inverse_mass.accelerations.acceleration)
        };
        let (depth, pressed) =
            (0.02 * radius, mass * (accelerations(pair.first) - accelerations(pair.second)).norm());
        let energy = law.stored(overlap) + 0.5 * mass * kinematics.approach.powi(2);
        let enough = ((exponent + 1.0) * energy / depth.powf(exponent + 1.0))
            .max(pressed / depth.powf(exponent));
        Error::Run(format!(
            "{} overlap by {overlap:.3e} m, {:.2} of the smaller radius, where {} is the limit, at \
            {:.3e} m/s: its \
             stiffness is too small for what strikes or presses it; make the contact stiffer, \
             {:.1e} N/m^exponent or \"auto\", or the step shorter; what is prescribed to press \
             them together \
             no stiffness holds",
            self.name(pair),
            overlap / radius,
            DEEPEST_OVERLAP,
            kinematics.approach.abs(),
            enough.max(2.0 * law.material.normal_stiffness),
        ))
    }

    /// One substep of the bodies that have a pair; whether all of them stay within their search
    /// radius in the next. `done` counts it.
    pub(super) fn substep(&mut self, bodies: &mut [Body], h: f64, done: usize) -> Result<bool> {
        self.load(bodies, h)?;
        let within = self.carry(bodies, h);
        self.lubricate(bodies, h, Some(done));
        Ok(within)
    }

    /// What two have gone since the search, together, by `ways` (m).
    fn together(pair: &Pair, ways: &[f64]) -> f64 {
        ways[pair.first] + ways.get(pair.second).copied().unwrap_or(0.0)
    }

    /// The forces of all pairs in a substep of `h` (s).
    fn load(&mut self, bodies: &[Body], h: f64) -> Result<()> {
        self.loads.fill(Impulse::default());
        self.tangential_forces.clear();
        for (i, body) in bodies.iter().enumerate().filter(|(i, _)| self.paired[*i]) {
            self.reach[i] = self.travelled[i] + h * body.velocity.norm();
        }
        for p in 0..self.pairs.len() {
            let reach = Self::together(&self.pairs[p], &self.reach);
            if reach < self.pairs[p].clear {
                continue;
            }
            let meeting = self.closest(&self.pairs[p], bodies, h);
            if !meeting.touches(h) {
                let (gone, pair) =
                    (Self::together(&self.pairs[p], &self.travelled), &mut self.pairs[p]);
                (pair.spring, pair.rolled) = (None, Vector3::zeros());
                pair.clear = gone - meeting.overlap - 0.5 * (reach - gone);
                continue;
            }
            let mut pair = self.pairs[p];
            let (kinematics, arms) = (self.kinematics_at(&pair, bodies, h, &meeting), meeting.arms);
            let radius = bodies
                .get(pair.second)
                .map_or(f64::INFINITY, |b| b.radius())
                .min(bodies[pair.first].radius());
            self.deepest = self.deepest.max(kinematics.overlap);
            if kinematics.overlap > DEEPEST_OVERLAP * radius {
                return Err(self.too_deep(&pair, bodies, &kinematics, radius));
            }
            let (normal, tangential) = self.law(&pair).force(&kinematics, &mut pair.spring);
            let rolling = self.resist_rolling(&mut pair, bodies, &kinematics, arms, normal);
            pair.normal += h * normal;
            pair.tangential += h * tangential;
            pair.touched += if normal > 0.0 { h } else { 0.0 };
            let limit = self.law(&pair).material.friction * normal;
            let held = (1.0 - tangential.norm() / limit.max(f64::MIN_POSITIVE))
                / self.numerics.sliding_onset;
            pair.pressed += h * normal;
            pair.stuck += h * normal * held.clamp(0.0, 1.0);
            let (force, turn) =
                (tangential - normal * kinematics.normal, kinematics.normal.cross(&tangential));
            let turns = [arms[0] * turn + rolling, arms[1] * turn - rolling];
            pair.add(h * force, turns.map(|turn| h * turn));
            self.pairs[p] = pair;
            if normal > 0.0 {
                self.touch(&pair);
                self.tangential_forces.push(TangentialForce {
                    pair: p,
                    force: tangential,
                    torque: rolling,
                    kinematics,
                    arms,
                });
            }
            self.loads[pair.first].linear += force;
            self.loads[pair.first].angular += turns[0];
            match self.loads.get_mut(pair.second) {
                Some(load) => {
                    load.linear -= force;
                    load.angular += turns[1];
                }
                None => {
                    self.wall_impulse -= h * force;
                    self.wall_work +=
                        h * force.dot(&self.walls[pair.second - bodies.len()].velocity);
                }
            }
        }
        self.slid -= self
            .tangential_forces
            .iter()
            .map(|tangential| h * self.power(tangential, bodies))
            .sum::<f64>();
        Ok(())
    }

    /// Mean power of a contact's tangential force and rolling torque over the substep (W), in which
    /// all loads change the velocities: what holds still does no work, whatever else presses on it.
    fn power(&self, tangential: &TangentialForce, bodies: &[Body]) -> f64 {
        let TangentialForce { force, torque, kinematics, arms, .. } = tangential;
        let pair = &self.pairs[tangential.pair];
        let zero = || (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
        // What its loads change of a body's velocity and spin, and its mean spin.
        let mean = |k: usize| {
            let Some(body) = bodies.get(k) else { return zero() };
            let (load, inverse_mass, half) =
                (&self.loads[k], &self.inverse_masses[k], 0.5 * kinematics.h);
            let turned = half * inverse_mass.inertia.component_mul(&load.angular);
            let spin = body.spin + half * inverse_mass.accelerations.angular + turned;
            (half * inverse_mass.mass.component_mul(&load.linear), turned, spin)
        };
        let ((moved, turned, spin), (other, its, its_spin)) = (mean(pair.first), mean(pair.second));
        let turned = (arms[0] * turned + arms[1] * its).cross(&kinematics.normal);
        let slip =
            kinematics.slip + 0.5 * kinematics.h * kinematics.push_slip + (moved - other) + turned;
        force.dot(&slip) + torque.dot(&(spin - its_spin))
    }

    /// Takes note that a pair touches.
    fn touch(&mut self, pair: &Pair) {
        for body in [pair.first, pair.second] {
            if let Some(touched) = self.touched.get_mut(body) {
                *touched = true;
            }
        }
    }

    /// Moves the bodies that have a pair by `h` (s) under their loads; whether all stay within
    /// their search radius in the next.
    fn carry(&mut self, bodies: &mut [Body], h: f64) -> bool {
        let mut within = true;
        for (i, body) in bodies.iter_mut().enumerate().filter(|(i, _)| self.paired[*i]) {
            let (load, inverse_mass) = (&self.loads[i], &self.inverse_masses[i]);
            self.impulses[i].linear += h * load.linear;
            self.impulses[i].angular += h * load.angular;
            let accelerations = Accelerations {
                acceleration: inverse_mass.accelerations.acceleration
                    + inverse_mass.mass.component_mul(&load.linear),
                angular: inverse_mass.accelerations.angular
                    + inverse_mass.inertia.component_mul(&load.angular),
            };
            let (way, turned) = travel(body, &accelerations, h, &self.periods);
            self.travelled[i] += way;
            self.turned[i] += turned;
            let next =
                (body.speed() + 0.5 * inverse_mass.accelerations.acceleration.norm() * h) * h;
            within &= self.travelled[i] + next <= self.search_radius[i];
        }
        within
    }

    /// What the fluid in the gaps does over the substep of `h` (s) that is `done`, or over what is
    /// left for it to do, pair by pair, each implicitly.
    pub(super) fn lubricate(&mut self, bodies: &mut [Body], h: f64, done: Option<usize>) {
        let range = self.medium.range(&self.numerics);
        if range == 0.0 {
            return;
        }
        for p in 0..self.pairs.len() {
            let pair = &mut self.pairs[p];
            pair.due += h;
            if pair.due == 0.0 || done.is_some_and(|done| done % pair.stride > 0) {
                continue;
            }
            let h = std::mem::take(&mut pair.due);
            let pair = self.pairs[p];
            let meeting = self.closest(&pair, bodies, 0.0);
            let (gap, arms) = (-meeting.overlap, meeting.arms);
            if gap > range {
                continue;
            }
            if gap <= self.medium.roughness {
                self.touch(&pair);
            }
            let kinematics = self.kinematics_at(&pair, bodies, 0.0, &meeting);
            let lubrication = self.lubrication(&pair, bodies, gap, gap - h * kinematics.approach);
            self.pairs[p].lubrication = lubrication;
            let resistance = h * lubrication.normal;
            let impulse =
                resistance * kinematics.approach / (1.0 + resistance * kinematics.inverse_normal);
            self.pairs[p].normal += impulse;
            self.apply_impulse(p, bodies, -impulse * kinematics.normal, [Vector3::zeros(); 2]);
            let slip = self.slide(p, bodies, &kinematics, arms, h * lubrication.sliding);
            self.roll(p, bodies, (kinematics.normal, slip), arms, h * lubrication.rolling);
        }
    }

    /// What the fluid in a pair's gap resists as it goes from a width to another (m): as it was
    /// found last, where it has hardly changed.
    pub(super) fn lubrication(
        &self,
        pair: &Pair,
        bodies: &[Body],
        gap: f64,
        next: f64,
    ) -> Lubrication {
        // The two sides of a box round differently what is put down to touch them.
        let rounding = TOUCHING * bodies[pair.first].radius();
        let [gap, next] = [gap, next].map(|g| if g < rounding { g.min(0.0) } else { g });
        let near = |g: f64| (g - pair.lubrication.gap).abs() <= SAME_GAP * pair.lubrication.gap;
        if (gap <= 0.0 && next <= 0.0 && pair.lubrication.gap == 0.0)
            || (gap > 0.0 && near(gap) && near(next))
        {
            return pair.lubrication;
        }
        let (body, other) =
            (&bodies[pair.first], bodies.get(pair.second).map_or(f64::INFINITY, |b| b.radius()));
        let (dimension, radius) = (body.shape().dimension(), body.radius());
        let side = self.side(pair);
        if side == Some(WallSide::Inflow) {
            return Lubrication { gap: gap.max(0.0), normal: 0.0, sliding: 0.0, rolling: 0.0 };
        }
        // At a plane of symmetry the lubrication layer is half of that between the body and its
        // mirror image. The two approach alike, turn against each other and go along the plane
        // together: they roll on each other and never slide.
        let mirrored = side == Some(WallSide::Slip);
        let between = |g0: f64, g1: f64| {
            if mirrored {
                2.0 * self.medium.resistance(
                    &self.numerics,
                    dimension,
                    radius,
                    radius,
                    2.0 * g0,
                    2.0 * g1,
                )
            } else {
                self.medium.resistance(&self.numerics, dimension, radius, other, g0, g1)
            }
        };
        // A substep that goes through the end of the gap is in it for a part of its time only.
        let touches = (gap <= 0.0) != (next <= 0.0);
        let normal = if touches {
            let (wide, outside) = (gap.max(next), gap.max(next) / (gap - next).abs());
            outside * between(wide, f64::MIN_POSITIVE) + (1.0 - outside) * between(0.0, 0.0)
        } else {
            between(gap, next.max(0.0))
        };
        let [sliding, rolling] = if mirrored {
            [
                0.0,
                self.medium.shear_resistance(&self.numerics, dimension, radius, radius, 2.0 * gap)
                    [1],
            ]
        } else {
            self.medium.shear_resistance(&self.numerics, dimension, radius, other, gap)
        };
        Lubrication { gap: if touches { f64::NAN } else { gap.max(0.0) }, normal, sliding, rolling }
    }

    /// What the fluid does at the wall of a pair; `None` where the second is a body.
    fn side(&self, pair: &Pair) -> Option<WallSide> {
        pair.second.checked_sub(self.inverse_masses.len()).map(|wall| self.walls[wall].side)
    }

    /// Resistance over a substep (N s^2/m) to surfaces that slide along a gap; the slip that is
    /// left (m/s).
    fn slide(
        &mut self,
        p: usize,
        bodies: &mut [Body],
        kinematics: &Kinematics,
        arms: [f64; 2],
        resistance: f64,
    ) -> Vector3<f64> {
        let left = 1.0 / (1.0 + resistance * kinematics.inverse_tangential);
        let impulse = -resistance * left * kinematics.slip;
        let turn = kinematics.normal.cross(&impulse);
        self.apply_impulse(p, bodies, impulse, arms.map(|arm| arm * turn));
        left * kinematics.slip
    }

    /// The same to surfaces that roll on each other, seen with their line of centres `n`.
    fn roll(
        &mut self,
        p: usize,
        bodies: &mut [Body],
        (n, slip): (Vector3<f64>, Vector3<f64>),
        arms: [f64; 2],
        resistance: f64,
    ) {
        let pair = self.pairs[p];
        let (body, other) = (&bodies[pair.first], bodies.get(pair.second));
        if self.side(&pair) == Some(WallSide::Slip) {
            // The mirror image turns the other way, at the same arm.
            let inverse = 0.5 * arms[0] * arms[0] * self.inverse_masses[pair.first].inertia.max();
            let impulse =
                -0.5 * resistance / (1.0 + resistance * inverse) * (arms[0] * body.spin).cross(&n);
            self.apply_impulse(
                p,
                bodies,
                Vector3::zeros(),
                [arms[0] * n.cross(&impulse), Vector3::zeros()],
            );
            return;
        }
        let (spun, lever) = match other {
            Some(other) => (
                arms[0] * body.spin - arms[1] * other.spin,
                (arms[0] - arms[1]) / (arms[0] + arms[1]),
            ),
            None => (arms[0] * body.spin, -1.0),
        };
        let own =
            arms[0] * body.spin + other.map_or(Vector3::zeros(), |other| arms[1] * other.spin);
        let moved = slip - own.cross(&n);
        let speed = 0.5 * (spun.cross(&n) + lever * moved);
        let turns =
            |i: usize, body: usize| arms[i] * arms[i] * self.inverse_masses[body].inertia.max();
        let turning = turns(0, pair.first) + other.map_or(0.0, |_| turns(1, pair.second));
        let masses = self.inverse_masses[pair.first].mass.max()
            + other.map_or(0.0, |_| self.inverse_masses[pair.second].mass.max());
        let inverse = 0.25 * (lever * lever * masses + turning);
        let impulse = -0.5 * resistance / (1.0 + resistance * inverse) * speed;
        let turn = n.cross(&impulse);
        self.apply_impulse(p, bodies, lever * impulse, [arms[0] * turn, -arms[1] * turn]);
    }

    /// Gives an impulse (N s) to the first of a pair and takes it from the second one, with what
    /// turns each (N m s).
    fn apply_impulse(
        &mut self,
        p: usize,
        bodies: &mut [Body],
        impulse: Vector3<f64>,
        turns: [Vector3<f64>; 2],
    ) {
        let pair = &mut self.pairs[p];
        pair.add(impulse, turns);
        for (k, sign, turn) in [(pair.first, 1.0, turns[0]), (pair.second, -1.0, turns[1])] {
            let Some(body) = bodies.get_mut(k) else {
                let wall = self.walls[k - self.inverse_masses.len()].velocity;
                self.wall_impulse -= impulse;
                self.wall_work += impulse.dot(&wall);
                continue;
            };
            body.velocity += sign * self.inverse_masses[k].mass.component_mul(&impulse);
            body.spin += self.inverse_masses[k].inertia.component_mul(&turn);
            self.impulses[k].linear += sign * impulse;
            self.impulses[k].angular += turn;
        }
    }

    /// Moves bodies by `time` (s) under their pushes only: those of which `wanted` likes whether
    /// they have a pair.
    pub(super) fn drift(&mut self, bodies: &mut [Body], time: f64, wanted: impl Fn(bool) -> bool) {
        for (i, body) in bodies.iter_mut().enumerate().filter(|(i, _)| wanted(self.paired[*i])) {
            self.turned[i] +=
                travel(body, &self.inverse_masses[i].accelerations, time, &self.periods).1;
        }
    }

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
    fn kinematics_at(&self, pair: &Pair, bodies: &[Body], h: f64, meeting: &Meeting) -> Kinematics {
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

/// What holds a contact along its surface, and its rolling, over a substep.
#[derive(Clone, Debug)]
pub(super) struct TangentialForce {
    pair: usize,
    /// On the first of the pair (N, N m).
    force: Vector3<f64>,
    torque: Vector3<f64>,
    kinematics: Kinematics,
    arms: [f64; 2],
}

/// Where a pair touches.
pub(super) struct Meeting {
    /// From the first to the second.
    pub(super) normal: Vector3<f64>,
    /// Negative where they do not (m).
    pub(super) overlap: f64,
    /// From the centres to the contact (m).
    arms: [f64; 2],
    /// Relative velocity of the centres (m/s).
    velocity: Vector3<f64>,
}

impl Meeting {
    /// Whether they touch during a substep `h` (s) in whose middle this is.
    fn touches(&self, h: f64) -> bool {
        self.overlap > 0.0 || self.overlap + 0.5 * h * self.velocity.dot(&self.normal).abs() > 0.0
    }
}

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

/// Moves a body by `h` (s) under accelerations that last; the way it goes (m), and by what it is to
/// be turned (rad).
fn travel(
    body: &mut Body,
    accelerations: &Accelerations,
    h: f64,
    periods: &[Option<f64>; 3],
) -> (f64, Vector3<f64>) {
    if body.motion == Motion::Fixed {
        return (0.0, Vector3::zeros());
    }
    let free = body.freedom().is_some();
    let speed = if free {
        (body.velocity + 0.5 * h * accelerations.acceleration).norm()
    } else {
        body.speed()
    };
    (speed * h, body.shift(h, accelerations, periods))
}
