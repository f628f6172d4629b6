//! Forces of the fluid in the gaps in a substep, pair by pair; [`super::lubrication`] has formulas.

use super::law::Kinematics;
use super::lubrication::Lubrication;
use super::meeting::{Arms, Met};
use super::pair::Pair;
use super::substep::TOUCHING;
use super::{Contacts, WallSide};
use crate::particles::Body;
use nalgebra::Vector3;

/// Part of a gap by which it may change before what fills it is found anew.
const SAME_GAP: f64 = 1e-3;

/// Part of a gap between shapes that the two may go before it is found anew.
const SAME_PLACE: f64 = 1e-2;

impl Contacts {
    /// What the fluid in the gaps does over the substep of `h` (s) that is `done`, or over what is
    /// left for it to do, pair by pair, each implicitly.
    pub(super) fn lubricate(&mut self, bodies: &mut [Body], h: f64, done: Option<usize>) {
        let range = self.medium.range();
        if range == 0.0 {
            return;
        }
        for p in 0..self.pairs.len() {
            let pair = &mut self.pairs[p];
            pair.due += h;
            if let Some(met) = &mut self.met[p] {
                met.age += h;
            }
            if pair.due == 0.0 || done.is_some_and(|done| done % pair.stride > 0) {
                continue;
            }
            let substep = if done.is_some() { h } else { 0.0 };
            let h = std::mem::take(&mut pair.due);
            let pair = self.pairs[p];
            let gone = Self::together(&pair, &self.travelled);
            // No nearer than since it was looked at last.
            if pair.clear - gone > range {
                continue;
            }
            // Carried on from the substep before, until they have gone too far since it was found.
            let still = |met: &Met| gone - met.gone <= SAME_PLACE * -met.meeting.overlap;
            let fresh = |met: &Met| met.age < substep;
            let known = self.met[p].filter(|met| met.age <= h && (fresh(met) || still(met)));
            let meeting = match known {
                Some(met) => self.at_end(&pair, bodies, &met),
                None => self.closest(&pair, bodies, 0.0),
            };
            if !self.are_round(&pair, bodies) {
                let found = known.map_or(gone, |met| met.gone);
                self.met[p] = Some(Met { meeting, age: 0.0, gone: found });
            }
            self.pairs[p].seen = meeting.normal;
            let gap = -meeting.overlap;
            let arms = meeting.arms;
            if gap > range {
                continue;
            }
            if gap <= self.medium.roughness {
                self.touch(&pair);
            }
            let kinematics = self.kinematics_at(&pair, bodies, 0.0, &meeting);
            let next = gap - h * kinematics.approach;
            let lubrication = self.lubrication(&pair, bodies, meeting.radii, gap, next);
            self.pairs[p].lubrication = lubrication;
            let resistance = h * lubrication.normal;
            let impulse =
                resistance * kinematics.approach / (1.0 + resistance * kinematics.inverse_normal);
            self.pairs[p].normal += impulse;
            let impulse = -impulse * kinematics.normal;
            self.apply_impulse(p, bodies, impulse, arms.turns(&impulse));
            let slip = self.slide(p, bodies, &kinematics, &arms, h * lubrication.sliding);
            self.roll(p, bodies, (kinematics.normal, slip), arms.to, h * lubrication.rolling);
        }
    }

    /// What the fluid in a pair's gap resists as it goes from a width to another (m): as it was
    /// found last, where it has hardly changed.
    pub(super) fn lubrication(
        &self,
        pair: &Pair,
        bodies: &[Body],
        [radius, other]: [f64; 2],
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
        let dimension = bodies[pair.first].shape().dimension();
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
                2.0 * self.medium.resistance(dimension, radius, radius, 2.0 * g0, 2.0 * g1)
            } else {
                self.medium.resistance(dimension, radius, other, g0, g1)
            }
        };
        // A substep that goes through the end of the gap is in it for a part of its time only.
        let touches = (gap <= 0.0) != (next <= 0.0);
        let normal = if touches {
            let wide = gap.max(next);
            let outside = gap.max(next) / (gap - next).abs();
            outside * between(wide, f64::MIN_POSITIVE) + (1.0 - outside) * between(0.0, 0.0)
        } else {
            between(gap, next.max(0.0))
        };
        let [sliding, rolling] = if mirrored {
            [0.0, self.medium.shear_resistance(dimension, radius, radius, 2.0 * gap)[1]]
        } else {
            self.medium.shear_resistance(dimension, radius, other, gap)
        };
        Lubrication { gap: if touches { f64::NAN } else { gap.max(0.0) }, normal, sliding, rolling }
    }

    /// What the fluid does at the wall of a pair; `None` where the second is a body.
    pub(super) fn side(&self, pair: &Pair) -> Option<WallSide> {
        pair.second.checked_sub(self.inverse_masses.len()).map(|wall| self.walls[wall].side)
    }

    /// Resistance over a substep (N s^2/m) to surfaces that slide along a gap; the slip that is
    /// left (m/s).
    pub(super) fn slide(
        &mut self,
        p: usize,
        bodies: &mut [Body],
        kinematics: &Kinematics,
        arms: &Arms,
        resistance: f64,
    ) -> Vector3<f64> {
        let left = 1.0 / (1.0 + resistance * kinematics.inverse_tangential);
        let impulse = -resistance * left * kinematics.slip;
        self.apply_impulse(p, bodies, impulse, arms.turns(&impulse));
        left * kinematics.slip
    }

    /// The same to surfaces that roll on each other, seen with their line of centres `n`.
    pub(super) fn roll(
        &mut self,
        p: usize,
        bodies: &mut [Body],
        (n, slip): (Vector3<f64>, Vector3<f64>),
        arms: [Vector3<f64>; 2],
        resistance: f64,
    ) {
        let pair = self.pairs[p];
        // From the centre of the first to that of the second.
        let apart = arms[0] - arms[1];
        // How far the contact is from both centres along the normal.
        let arms = [arms[0].dot(&n), -arms[1].dot(&n)];
        let body = &bodies[pair.first];
        let other = self.other(&pair, bodies);
        // That of a wall turns the line of centres with it.
        let wall = bodies.get(pair.second).filter(|_| other.is_none());
        let spin = body.spin - wall.map_or(Vector3::zeros(), |wall| wall.spin);
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
            Some(other) => {
                (arms[0] * spin - arms[1] * other.spin, (arms[0] - arms[1]) / (arms[0] + arms[1]))
            }
            None => (arms[0] * spin, -1.0),
        };
        let own = arms[0] * spin + other.map_or(Vector3::zeros(), |other| arms[1] * other.spin);
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
        let impulse = lever * impulse;
        // On an obstacle about its own centre.
        let reaction = match wall {
            Some(_) => apart.cross(&impulse) - arms[0] * turn,
            None => -arms[1] * turn,
        };
        self.apply_impulse(p, bodies, impulse, [arms[0] * turn, reaction]);
    }

    /// Gives an impulse (N s) to the first of a pair and takes it from the second one, with what
    /// turns each (N m s).
    pub(super) fn apply_impulse(
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
            body.spin += self.inverse_masses[k].inertia.of(&turn);
            self.impulses[k].linear += sign * impulse;
            self.impulses[k].angular += turn;
        }
    }
}
