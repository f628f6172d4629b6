//! The correction of contact impulses: the substeps hold contacts with masses of their own, the
//! fluid responds with its inertia.
//!
//! ```text
//!   residual    e_i = v_i - v_i*,  o_i = w_i - w_i*
//!              v*: at the end of the substeps, w* likewise; of round bodies, which no pressure
//!              turns, before it
//!   at contact  e = e_i - e_j + o_i x r_i - o_j x r_j
//!   normal      P = q m_n e_n,   e_n = n.e                   1/m_n, 1/m_t as in [`super::law`]
//!   tangential  Q = -q m_t e_t,  e_t = e - e_n n,
//!              |Q + Q_1| <= mu (P + P_1)
//!   position    x_i = x_i* + t (1 - q)/2 (v_i - v_i*)       by the least t (1 - q) of its contacts
//!   share       q = 1 - sin(x)/x,  x = pi t/T <= pi
//!              in contact for a time t so far, which lasts T in all
//!               q = 1                                     a contact that has ended within the step
//!               q = x/(1 + x),  x = dt lambda/m              lubrication that resists with lambda
//! ```
//! Where a cluster parts, 1/m is that of the substeps times its response ([`super::cluster`]): a
//! contact that is alone is exact then. q is the part of a velocity, gained evenly over the time,
//! that a spring or a damper takes back within that time: a contact that lasts for many steps keeps
//! its impulse, and the fluid responds as it does; one that is shorter than the step parts, rests
//! or slips as the substeps found. A body in a contact that lasts has moved with the mean of its
//! velocities at the start and at the end of the step, not as the substeps expected: without the
//! correction of its position its springs store less than it loses (a disc of s = 2.5 that leaves a
//! wall in four steps keeps 0.70 of its speed, and 0.79 with it). The pairs are corrected one after
//! the other, there and back, until a sweep changes little beside the first one: each layer of a
//! pile slides by little on the one below.

use super::law::Kinematics;
use super::meeting::Arms;
use super::pair::Pair;
use super::response::InverseMass;
use super::{Contacts, Impulse};
use crate::particles::Body;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Most sweeps over the pairs.
const MOST_SWEEPS: usize = 200;
/// The sweeps end where one changes less than this part of what the first one did.
const TOLERANCE: f64 = 1e-2;
/// Part of its speed that lubrication has to be able to take from a pair in a step for its impulse
/// to be corrected: what is less costs a solve, and changes no measure by 0.01 %.
const FAINT: f64 = 0.01;

/// A pair that gave an impulse in the step, while that is corrected.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constraint {
    /// Its place among the pairs, and its two.
    pair: usize,
    two: [usize; 2],
    /// From the first to the second, and the arms of both.
    normal: Vector3<f64>,
    arms: Arms,
    /// `1/m_n`, `1/m_t` (1/kg), and q along both.
    inverse: [f64; 2],
    share: [f64; 2],
    /// Coulomb's coefficient where the two touch; `None` for lubrication.
    friction: Option<f64>,
    /// Correction impulses: P, which parts the two, and Q on the first (N s).
    press: f64,
    along: Vector3<f64>,
}

impl Contacts {
    /// Corrects the impulses of the last [`advance`](Contacts::advance) over `dt` (s) by the
    /// residuals of all bodies, of velocity and spin (m/s, rad/s), and leaves the correction
    /// impulses of the bodies in `corrections`.
    pub(crate) fn correct(
        &mut self,
        bodies: &[Body],
        residuals: &[[Vector3<f64>; 2]],
        corrections: &mut [Impulse],
        dt: f64,
    ) {
        self.scale_responses(|response| response);
        let mut constraints = std::mem::take(&mut self.constraints);
        constraints.clear();
        let gave = self.pairs.iter().enumerate().filter(|(_, pair)| pair.normal != 0.0);
        constraints.extend(gave.map(|(p, pair)| self.constraint(p, pair, bodies, dt)));
        corrections.fill(Impulse::default());
        let mut first = 0.0;
        for sweep in 0..MOST_SWEEPS {
            let mut changed = 0.0f64;
            let mut solve = |constraint: &mut Constraint| {
                changed = changed.max(self.solve(constraint, residuals, corrections));
            };
            // There and back, so that neither end of a pile comes first.
            if sweep % 2 == 0 {
                constraints.iter_mut().for_each(&mut solve);
            } else {
                constraints.iter_mut().rev().for_each(&mut solve);
            }
            if sweep == 0 {
                first = changed;
            }
            if changed <= TOLERANCE * first {
                break;
            }
        }
        constraints.iter().for_each(|constraint| self.add_correction(constraint, bodies.len()));
        self.add_corrections(corrections);
        self.constraints = constraints;
        self.scale_responses(|response| 1.0 / response);
    }

    /// Finds for how long (s) of the last step each body has moved as its residual lets expect: the
    /// shortest t (1 - q) of its contacts, and none where it has no contact.
    pub(crate) fn find_followed(&self, bodies: &[Body], followed: &mut [f64]) {
        followed.fill(f64::INFINITY);
        for pair in self.pairs.iter().filter(|pair| pair.normal_impulse > 0.0) {
            let held = self.held_by_contact(pair, &self.kinematics(pair, bodies, 0.0).0);
            for k in [pair.first, pair.second] {
                let Some(time) = followed.get_mut(k) else { continue };
                *time = time.min((1.0 - held) * pair.touched);
            }
        }
        followed.iter_mut().filter(|time| time.is_infinite()).for_each(|time| *time = 0.0);
    }

    /// Multiplies the inverse masses of bodies by a function of the response of their clusters.
    fn scale_responses(&mut self, factor: impl Fn(f64) -> f64) {
        for k in 0..self.inverse_masses.len() {
            let factor = factor(self.response_of(k));
            self.inverse_masses[k].scale(factor);
        }
    }

    /// Counts the correction impulses of the bodies.
    pub(super) fn add_corrections(&mut self, corrections: &[Impulse]) {
        for (impulse, correction) in self.impulses.iter_mut().zip(corrections) {
            impulse.linear += correction.linear;
            impulse.angular += correction.angular;
        }
    }

    /// Counts the correction of a pair in what it gave.
    fn add_correction(&mut self, constraint: &Constraint, bodies: usize) {
        let Constraint { press, along, normal, arms, .. } = *constraint;
        let pair = &mut self.pairs[constraint.pair];
        pair.normal += press;
        if constraint.friction.is_some() {
            pair.normal_impulse += press;
            pair.tangential += along;
        }
        let impulse = along - press * normal;
        pair.add(impulse, arms.turns(&impulse));
        if let Some(wall) = constraint.two[1].checked_sub(bodies) {
            self.wall_impulse -= impulse;
            self.wall_work += impulse.dot(&self.walls[wall].velocity);
        }
    }

    /// The pair at the place `p`, of which nothing is corrected yet.
    fn constraint(&self, p: usize, pair: &Pair, bodies: &[Body], dt: f64) -> Constraint {
        let (kinematics, arms) = self.kinematics(pair, bodies, 0.0);
        let inverse = [kinematics.inverse_normal, kinematics.inverse_tangential];
        // Two that touch for a part of the step, and are drawn together by their lubrication in
        // all, are held by that.
        let touched = pair.normal_impulse > 0.0 && pair.normal > 0.0;
        let share = if touched {
            let held = self.held_by_contact(pair, &kinematics);
            [held, held * pair.stuck / pair.normal_impulse]
        } else {
            let held = |resistance: f64, inverse: f64| {
                let x = dt * resistance * inverse;
                x / (1.0 + x)
            };
            [held(pair.lubrication.normal, inverse[0]), held(pair.lubrication.sliding, inverse[1])]
        };
        Constraint {
            pair: p,
            two: [pair.first, pair.second],
            normal: kinematics.normal,
            arms,
            inverse,
            share,
            friction: touched.then(|| self.law(pair).material.friction),
            press: 0.0,
            along: Vector3::zeros(),
        }
    }

    /// q of a pair that touched.
    fn held_by_contact(&self, pair: &Pair, kinematics: &Kinematics) -> f64 {
        if kinematics.overlap <= 0.0 {
            return 1.0;
        }
        let law = self.law(pair);
        let mass = kinematics.mass_of_overlap();
        // The energy of an overlap counts as that of an approach.
        let speed = ((kinematics.gain * kinematics.approach).powi(2)
            + 2.0 * law.stored(kinematics.overlap) / mass)
            .sqrt();
        let x = (PI * pair.touched / law.contact_time(mass, speed)).min(PI);
        1.0 - x.sin() / x
    }

    /// Corrects one pair as the corrections of the others now are; by how much that changes its
    /// residual (m/s).
    fn solve(
        &self,
        constraint: &mut Constraint,
        residuals: &[[Vector3<f64>; 2]],
        corrections: &mut [Impulse],
    ) -> f64 {
        let (n, pair, [normal, tangential]) =
            (constraint.normal, &self.pairs[constraint.pair], constraint.inverse);
        // As if the pair had not been corrected yet.
        let off =
            constraint.press + self.residual_of(constraint, residuals, corrections).0 / normal;
        let press = constraint.within_contact(pair, constraint.share[0] * off);
        let pressed = press - constraint.press;
        constraint.apply(-pressed * n, corrections);

        let slips =
            constraint.along - self.residual_of(constraint, residuals, corrections).1 / tangential;
        let along = constraint.within_cone(pair, press, constraint.share[1] * slips);
        let slid = along - constraint.along;
        constraint.apply(slid, corrections);

        (constraint.press, constraint.along) = (press, along);
        (pressed.abs() * normal).max(slid.norm() * tangential)
    }

    /// Residuals of the approach and of the slip of a pair (m/s), the corrections counted.
    fn residual_of(
        &self,
        constraint: &Constraint,
        residuals: &[[Vector3<f64>; 2]],
        corrections: &[Impulse],
    ) -> (f64, Vector3<f64>) {
        let of = |k: usize| {
            let Some(given) = corrections.get(k) else {
                return (Vector3::zeros(), Vector3::zeros());
            };
            let (InverseMass { mass, inertia, .. }, [moved, turned]) =
                (&self.inverse_masses[k], &residuals[k]);
            (moved + mass.component_mul(&given.linear), turned + inertia.of(&given.angular))
        };
        let [(one, spun), (other, its)] = constraint.two.map(of);
        let n = constraint.normal;
        let arms = &constraint.arms;
        let moved = one - other + spun.cross(&arms.to[0]) - its.cross(&arms.to[1]);
        let moved = arms.coupled(moved, [&spun, &its]);
        (moved.dot(&n), moved - moved.dot(&n) * n)
    }

    /// Whether a pair gave an impulse over a step of `dt` (s) that counts: lubrication that can
    /// hardly slow two in that time does not.
    pub(crate) fn gave(&self, bodies: &[Body], dt: f64) -> bool {
        let slows = |pair: &Pair| {
            let kinematics = self.kinematics(pair, bodies, 0.0).0;
            let [normal, sliding] = [
                pair.lubrication.normal * kinematics.inverse_normal,
                pair.lubrication.sliding * kinematics.inverse_tangential,
            ];
            dt * normal.max(sliding) >= FAINT
        };
        self.pairs
            .iter()
            .any(|pair| pair.normal != 0.0 && (pair.normal_impulse > 0.0 || slows(pair)))
    }
}

impl Constraint {
    /// The part of a normal correction (N s) that a contact can give: it never pulls.
    fn within_contact(&self, pair: &Pair, press: f64) -> f64 {
        if self.friction.is_some() { press.max(-pair.normal.max(0.0)) } else { press }
    }

    /// The part of a tangential correction (N s) within Coulomb's cone, with so much more normal
    /// impulse.
    fn within_cone(&self, pair: &Pair, press: f64, along: Vector3<f64>) -> Vector3<f64> {
        let Some(friction) = self.friction else { return along };
        let (limit, whole) =
            (friction * (pair.normal_impulse + press).max(0.0), pair.tangential + along);
        along + whole * ((limit / whole.norm().max(f64::MIN_POSITIVE)).min(1.0) - 1.0)
    }

    /// Adds an impulse (N s) at the contact to the first of the pair, its opposite to the second.
    fn apply(&self, impulse: Vector3<f64>, corrections: &mut [Impulse]) {
        let turns = self.arms.turns(&impulse);
        for (k, impulse, turn) in
            [(self.two[0], impulse, turns[0]), (self.two[1], -impulse, turns[1])]
        {
            if let Some(given) = corrections.get_mut(k) {
                given.linear += impulse;
                given.angular += turn;
            }
        }
    }
}
