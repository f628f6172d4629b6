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
//! the other in the order of their colours, there and back, until a sweep changes little beside the
//! first one: each layer of a pile slides by little on the one below.

use super::Impulse;
use super::arms::{Arms, PairImpulse};
use super::body::ContactBody;
use super::law::Kinematics;
use super::meeting::Layout;
use super::pair::Pair;
use super::response::InverseMass;
use crate::particles::RigidVelocity;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Least part of its speed that lubrication can take from a pair in a step for its impulse to be
/// corrected: what is less costs a solve, and changes no measure by 0.01 %.
const FAINT: f64 = 0.01;

/// A pair that gave an impulse in the step, while that is corrected.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constraint {
    /// Its place among the pairs.
    pub(super) pair: usize,
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

impl Constraint {
    /// The pair at the place `p`, of which nothing is corrected yet, after a step of `dt` (s).
    pub(super) fn new(layout: &Layout, p: usize, pair: &Pair, dt: f64) -> Constraint {
        let (kinematics, arms) = layout.kinematics(pair, 0.0);
        let inverse = [kinematics.inverse_normal, kinematics.inverse_tangential];
        // Two that touch for a part of the step, and are drawn together by their lubrication in
        // all, are held by that.
        let touched = pair.touched() && pair.sums.normal > 0.0;
        let share = if touched {
            let held = held_by_contact(layout, pair, &kinematics);
            [held, held * pair.sums.stuck / pair.sums.touch]
        } else {
            let held = |resistance: f64, inverse: f64| {
                let x = dt * resistance * inverse;
                x / (1.0 + x)
            };
            let film = &pair.film.lubrication;
            [held(film.normal, inverse[0]), held(film.sliding, inverse[1])]
        };
        Constraint {
            pair: p,
            normal: kinematics.normal,
            arms,
            inverse,
            share,
            friction: touched.then(|| layout.law(pair).material.friction),
            press: 0.0,
            along: Vector3::zeros(),
        }
    }

    /// Corrects the pair as the corrections of the others now are; returns the change of its
    /// residual by that (m/s).
    pub(super) fn solve(
        &mut self,
        pair: &Pair,
        states: &[ContactBody],
        residuals: &[RigidVelocity],
        corrections: &mut [Impulse],
    ) -> f64 {
        let n = self.normal;
        let [normal, tangential] = self.inverse;
        // As if the pair had not been corrected yet.
        let off = self.press + self.residual(pair, states, residuals, corrections).0 / normal;
        let press = self.within_contact(pair, self.share[0] * off);
        let pressed = press - self.press;
        self.apply(pair, -pressed * n, corrections);

        let slips = self.along - self.residual(pair, states, residuals, corrections).1 / tangential;
        let along = self.within_cone(pair, press, self.share[1] * slips);
        let slid = along - self.along;
        self.apply(pair, slid, corrections);

        self.press = press;
        self.along = along;
        (pressed.abs() * normal).max(slid.norm() * tangential)
    }

    /// Residuals of the approach and of the slip of the pair (m/s), the corrections counted.
    fn residual(
        &self,
        pair: &Pair,
        states: &[ContactBody],
        residuals: &[RigidVelocity],
        corrections: &[Impulse],
    ) -> (f64, Vector3<f64>) {
        let of = |k: usize| {
            let Some(given) = corrections.get(k) else { return [Vector3::zeros(); 2] };
            let InverseMass { mass, inertia, .. } = &states[k].response;
            let RigidVelocity { velocity, spin } = &residuals[k];
            [velocity + mass.component_mul(&given.linear), spin + inertia.of(&given.angular)]
        };
        let [[one, spun], [other, its]] = [pair.first, pair.second].map(of);
        let n = self.normal;
        let arms = &self.arms;
        let moved = one - other + spun.cross(&arms.to[0]) - its.cross(&arms.to[1]);
        let moved = arms.coupled(moved, [&spun, &its]);
        (moved.dot(&n), moved - moved.dot(&n) * n)
    }

    /// Counts the correction in what the pair gave; the correction.
    pub(super) fn add_to(&self, pair: &mut Pair) -> PairImpulse {
        let Constraint { press, along, normal, .. } = *self;
        let impulse = self.arms.impulse(along - press * normal);
        let sums = &mut pair.sums;
        sums.normal += press;
        sums.impulse += impulse;
        if self.friction.is_some() {
            sums.touch += press;
            sums.tangential += along;
        }
        impulse
    }

    /// The part of a normal correction (N s) that a contact can give: it never pulls.
    fn within_contact(&self, pair: &Pair, press: f64) -> f64 {
        if self.friction.is_some() { press.max(-pair.sums.normal.max(0.0)) } else { press }
    }

    /// The part of a tangential correction (N s) within Coulomb's cone, with so much more normal
    /// impulse.
    fn within_cone(&self, pair: &Pair, press: f64, along: Vector3<f64>) -> Vector3<f64> {
        let Some(friction) = self.friction else { return along };
        let limit = friction * (pair.sums.touch + press).max(0.0);
        let whole = pair.sums.tangential + along;
        along + whole * ((limit / whole.norm().max(f64::MIN_POSITIVE)).min(1.0) - 1.0)
    }

    /// Adds an impulse (N s) at the contact to the first of the pair, its opposite to the second.
    fn apply(&self, pair: &Pair, impulse: Vector3<f64>, corrections: &mut [Impulse]) {
        for (k, given) in pair.each(&self.arms.impulse(impulse)) {
            corrections.get_mut(k).into_iter().for_each(|sum| *sum += given);
        }
    }
}

/// q of a pair that touched.
pub(super) fn held_by_contact(layout: &Layout, pair: &Pair, kinematics: &Kinematics) -> f64 {
    if kinematics.overlap <= 0.0 {
        return 1.0;
    }
    let law = layout.law(pair);
    let mass = kinematics.mass_of_overlap();
    // The energy of an overlap counts as that of an approach.
    let speed = ((kinematics.gain * kinematics.approach).powi(2)
        + 2.0 * law.stored(kinematics.overlap) / mass)
        .sqrt();
    let x = (PI * pair.sums.time / law.contact_time(mass, speed)).min(PI);
    1.0 - x.sin() / x
}

/// Whether a pair gave an impulse that counts: see [`super::Contacts::gave`].
pub(super) fn gave(layout: &Layout, pair: &Pair, dt: f64) -> bool {
    let slows = || {
        let kinematics = layout.kinematics(pair, 0.0).0;
        let film = &pair.film.lubrication;
        let normal = film.normal * kinematics.inverse_normal;
        let sliding = film.sliding * kinematics.inverse_tangential;
        dt * normal.max(sliding) >= FAINT
    };
    pair.sums.normal != 0.0 && (pair.touched() || slows())
}
