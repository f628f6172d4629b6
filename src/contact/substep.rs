//! A substep: the kick by accelerations and contacts, the drift; formulas in [`super`].

use super::law::Kinematics;
use super::meeting::{Arms, Meeting, Met};
use super::pair::Pair;
use super::{Contacts, Impulse};
use crate::Result;
use crate::numerics::SLIDING_ONSET;
use crate::particles::{Accelerations, Body, Motion};
use nalgebra::Vector3;

/// Gap that is none (of the radius).
pub(super) const TOUCHING: f64 = 1e-9;

impl Contacts {
    /// One substep of the bodies that have a pair; whether all of them stay within their search
    /// radius in the next. `done` counts it.
    pub(super) fn substep(&mut self, bodies: &mut [Body], h: f64, done: usize) -> Result<bool> {
        self.load(bodies, h)?;
        let within = self.carry(bodies, h);
        self.lubricate(bodies, h, Some(done));
        Ok(within)
    }

    /// What two have gone since the search, together, by `ways` (m).
    pub(super) fn together(pair: &Pair, ways: &[f64]) -> f64 {
        ways[pair.first] + ways.get(pair.second).copied().unwrap_or(0.0)
    }

    /// The forces of all pairs in a substep of `h` (s).
    fn load(&mut self, bodies: &[Body], h: f64) -> Result<()> {
        self.loads.fill(Impulse::default());
        self.tangential_forces.clear();
        self.met.resize(self.pairs.len(), None);
        self.turn_to_middle(bodies, h);
        for (i, body) in bodies.iter().enumerate().filter(|(i, _)| self.paired[*i]) {
            self.reach[i] = self.travelled[i] + h * (body.velocity.norm() + rim_speed(body));
        }
        for p in 0..self.pairs.len() {
            let reach = Self::together(&self.pairs[p], &self.reach);
            if reach < self.pairs[p].clear {
                continue;
            }
            let meeting = self.closest(&self.pairs[p], bodies, h);
            let gone = Self::together(&self.pairs[p], &self.travelled);
            self.pairs[p].seen = meeting.normal;
            if !self.are_round(&self.pairs[p], bodies) {
                self.met[p] = Some(Met { meeting, age: -0.5 * h, gone });
            }
            if !meeting.touches(h) {
                let pair = &mut self.pairs[p];
                (pair.spring, pair.rolled) = (None, Vector3::zeros());
                pair.clear = gone - meeting.overlap - 0.5 * (reach - gone);
                continue;
            }
            self.press(p, bodies, h, &meeting)?;
        }
        self.slid -= self
            .tangential_forces
            .iter()
            .map(|tangential| h * self.power(tangential, bodies))
            .sum::<f64>();
        Ok(())
    }

    /// The force of the pair at the place `p`, which touches, on its two in a substep of `h` (s).
    fn press(&mut self, p: usize, bodies: &[Body], h: f64, meeting: &Meeting) -> Result<()> {
        let mut pair = self.pairs[p];
        let kinematics = self.kinematics_at(&pair, bodies, h, meeting);
        let arms = meeting.arms;
        let limit = self.deepest_allowed(&pair, bodies);
        self.deepest = self.deepest.max(kinematics.overlap);
        if kinematics.overlap > limit.overlap {
            return Err(self.too_deep(&pair, bodies, &kinematics, &limit));
        }
        let (normal, tangential) = self.law(&pair).force(&kinematics, &mut pair.spring);
        let rolling = self.resist_turning(&mut pair, bodies, &kinematics, meeting, normal);
        pair.normal += h * normal;
        pair.tangential += h * tangential;
        pair.touched += if normal > 0.0 { h } else { 0.0 };
        let limit = self.law(&pair).material.friction * normal;
        let held = (1.0 - tangential.norm() / limit.max(f64::MIN_POSITIVE)) / SLIDING_ONSET;
        pair.normal_impulse += h * normal;
        pair.stuck += h * normal * held.clamp(0.0, 1.0);
        let force = tangential - normal * kinematics.normal;
        let turns = arms.turns(&force);
        let turns = [turns[0] + rolling, turns[1] - rolling];
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
                self.wall_work += h * force.dot(&self.walls[pair.second - bodies.len()].velocity);
            }
        }
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
            let turned = half * inverse_mass.inertia.of(&load.angular);
            let spin = body.spin + half * inverse_mass.accelerations.angular + turned;
            (half * inverse_mass.mass.component_mul(&load.linear), turned, spin)
        };
        let ((moved, turned, spin), (other, its, its_spin)) = (mean(pair.first), mean(pair.second));
        let turned = arms.turning([&turned, &its]);
        let slip =
            kinematics.slip + 0.5 * kinematics.h * kinematics.push_slip + (moved - other) + turned;
        force.dot(&slip) + torque.dot(&(spin - its_spin))
    }

    /// Takes note that a pair touches.
    pub(super) fn touch(&mut self, pair: &Pair) {
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
            let load = &self.loads[i];
            let inverse_mass = &self.inverse_masses[i];
            self.impulses[i].linear += h * load.linear;
            self.impulses[i].angular += h * load.angular;
            let accelerations = Accelerations {
                acceleration: inverse_mass.accelerations.acceleration
                    + inverse_mass.mass.component_mul(&load.linear),
                angular: inverse_mass.accelerations.angular
                    + inverse_mass.inertia.of(&load.angular),
            };
            let (way, turned) = travel(body, &accelerations, h, &self.periods);
            self.travelled[i] += way;
            self.turned[i] += turned;
            let next = (body.speed() + 0.5 * inverse_mass.accelerations.acceleration.norm() * h)
                * h
                + rim_speed(body) * h;
            within &= self.travelled[i] + next <= self.search_radius[i];
        }
        within
    }

    /// Moves bodies by `time` (s) under their pushes only: those of which `wanted` likes whether
    /// they have a pair.
    pub(super) fn drift(&mut self, bodies: &mut [Body], time: f64, wanted: impl Fn(bool) -> bool) {
        for (i, body) in bodies.iter_mut().enumerate().filter(|(i, _)| wanted(self.paired[*i])) {
            self.turned[i] +=
                travel(body, &self.inverse_masses[i].accelerations, time, &self.periods).1;
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
    arms: Arms,
}

/// Speed (m/s) at which a body's turning moves its rim: nothing of a round one.
pub(super) fn rim_speed(body: &Body) -> f64 {
    if body.is_round() { 0.0 } else { body.spin.norm() * body.radius() }
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
    let rim = rim_speed(body);
    let speed = if free {
        (body.velocity + 0.5 * h * accelerations.acceleration).norm()
    } else {
        body.speed()
    };
    ((speed + rim) * h, body.shift(h, accelerations, periods))
}
