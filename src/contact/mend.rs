//! What contacts have to give beyond what they gave: the fluid answers with a mass of its own, which the substeps can but
//! expect.
//!
//! ```text
//!   deviation   e_i = v_i - (v_i expected),  o_i = w_i - (w_i expected)
//!   normal      P = q m_n e_n,   e_n = n.(e_i - e_j)           1/m_n, 1/m_t as in [`super::law`]
//!   tangential  Q = -q m_t e_t,  e_t = (e_i - e_j)_t + (a_i o_i + a_j o_j) x n
//! ```
//! q is 1 for a pair that touched, along n, and along its surfaces what part of the impulse between them they stuck for: it parts, rests or
//! slips as the substeps found, `|Q + what gripped| <= mu (P + what pressed)`. The film in a gap resists a deviation as it does a speed: `q = x/(1 + x)`,
//! x = dt lambda/m over the step. Pairs are taken one after the other, a few times over. Spin deviates by what Q turns alone.

use super::{Contacts, Impulse};
use crate::params;
use crate::particles::Body;
use nalgebra::Vector3;

impl Contacts {
    /// Finds for each body the impulse that takes the `deviation` (m/s) of its velocity from the expected one over the step `dt` (s)
    /// back at its contacts, adds it to the impulses, and leaves it in `nudges`. Returns the largest deviation of a pair before (m/s).
    pub(crate) fn mend(
        &mut self,
        bodies: &[Body],
        deviation: &[Vector3<f64>],
        nudges: &mut [Impulse],
        tolerance: f64,
        dt: f64,
    ) -> f64 {
        nudges.fill(Impulse::default());
        for pair in &mut self.pairs {
            // What it was mended by before, in the same step, is given.
            let (press, grip) = std::mem::take(&mut pair.mended);
            let touching = if pair.pressed > 0.0 { press } else { 0.0 };
            (pair.given, pair.pressed, pair.grip) = (pair.given + press, pair.pressed + touching, pair.grip + grip);
        }
        let mut largest = 0.0f64;
        for sweep in 0..params::mending_sweeps() as usize {
            for p in 0..self.pairs.len() {
                let off = self.mend_pair(p, bodies, deviation, nudges, dt);
                if sweep == 0 {
                    largest = largest.max(off);
                }
            }
            if sweep == 0 && largest < tolerance {
                // Nothing worth a solve: what little there was is the next step's.
                self.pairs.iter_mut().for_each(|pair| pair.mended = (0.0, Vector3::zeros()));
                return largest;
            }
        }
        for pair in &self.pairs {
            let Some(wall) = pair.second.checked_sub(bodies.len()) else { continue };
            let impulse = pair.mended.1 - pair.mended.0 * self.kinematics(pair, bodies, 0.0).0.normal;
            self.wall_impulse -= impulse;
            self.wall_work += impulse.dot(&self.walls[wall].velocity);
        }
        for (impulse, nudge) in self.impulses.iter_mut().zip(nudges.iter()) {
            impulse.linear += nudge.linear;
            impulse.angular += nudge.angular;
        }
        largest
    }

    /// The same for the pair `p`, as the nudges now are; the deviation of the pair before (m/s).
    fn mend_pair(
        &mut self,
        p: usize,
        bodies: &[Body],
        deviation: &[Vector3<f64>],
        nudges: &mut [Impulse],
        dt: f64,
    ) -> f64 {
        let pair = self.pairs[p];
        if pair.given == 0.0 {
            return 0.0;
        }
        let (kinematics, arms) = self.kinematics(&pair, bodies, 0.0);
        let (n, touched) = (kinematics.normal, pair.pressed > 0.0);
        let part = |touching: f64, inverse: f64, film: f64| {
            let x = dt * film * inverse;
            if touched { touching } else { x / (1.0 + x) }
        };
        // As if the pair had not been mended yet.
        let (before, inverse) = (pair.mended, kinematics.inverse_normal);
        let off = self.deviates(p, deviation, nudges).0.dot(&n);
        let mut press = part(1.0, inverse, pair.film.normal) * (before.0 + off / inverse);
        if touched {
            // Contacts hold nothing back.
            press = press.max(-pair.given.max(0.0));
        }
        self.nudge(p, (before.0 - press) * n, [Vector3::zeros(); 2], nudges);

        let inverse = kinematics.inverse_tangential;
        let (moved, spun) = self.deviates(p, deviation, nudges);
        let slips = moved - moved.dot(&n) * n + (arms[0] * spun[0] + arms[1] * spun[1]).cross(&n);
        let mut grip = part(pair.stuck / pair.pressed, inverse, pair.film.sliding) * (before.1 - slips / inverse);
        if touched {
            let limit = self.law(&pair).material.friction * (pair.pressed + press).max(0.0);
            let whole = pair.grip + grip;
            grip += whole * ((limit / whole.norm().max(f64::MIN_POSITIVE)).min(1.0) - 1.0);
        }
        let along = grip - before.1;
        let turn = n.cross(&along);
        self.nudge(p, along, arms.map(|arm| arm * turn), nudges);

        self.pairs[p].mended = (press, grip);
        ((press - before.0).abs() * kinematics.inverse_normal).max(along.norm() * inverse)
    }

    /// By how much the velocity of the first of a pair beside the second's (m/s) and their spins (rad/s) are off, the nudges counted.
    fn deviates(&self, p: usize, deviation: &[Vector3<f64>], nudges: &[Impulse]) -> (Vector3<f64>, [Vector3<f64>; 2]) {
        let off = |k: usize| {
            let Some(nudge) = nudges.get(k) else { return (Vector3::zeros(), Vector3::zeros()) };
            let answer = &self.answers[k];
            (deviation[k] + answer.mass.component_mul(&nudge.linear), answer.inertia.component_mul(&nudge.angular))
        };
        let ((one, spun), (other, its)) = (off(self.pairs[p].first), off(self.pairs[p].second));
        (one - other, [spun, its])
    }

    /// Nudges the first of a pair by an impulse (N s) and the second the other way, and turns them (N m s).
    fn nudge(&self, p: usize, impulse: Vector3<f64>, turns: [Vector3<f64>; 2], nudges: &mut [Impulse]) {
        let pair = &self.pairs[p];
        for (k, impulse, turn) in [(pair.first, impulse, turns[0]), (pair.second, -impulse, turns[1])] {
            if let Some(nudge) = nudges.get_mut(k) {
                nudge.linear += impulse;
                nudge.angular += turn;
            }
        }
    }

    /// The largest speed at which a pair that touched comes together or parts (m/s).
    pub(crate) fn pace(&self, bodies: &[Body]) -> f64 {
        let touched = self.pairs.iter().filter(|pair| pair.pressed > 0.0);
        touched.fold(0.0, |most, pair| most.max(self.kinematics(pair, bodies, 0.0).0.approach.abs()))
    }

    /// Whether any pair gave something.
    pub(crate) fn gave(&self) -> bool {
        self.pairs.iter().any(|pair| pair.given != 0.0)
    }
}
