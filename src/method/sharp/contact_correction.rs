//! Contacts and fluid at one: what the pressure makes of the contact impulses is compared with what
//! the substeps expected, corrected once, and bounded ([`crate::contact`] has the formulas).
//!
//! ```text
//!   v_0      without the impulses of touch of the clusters that part
//!              a rough solve, where there are such
//!   v_1      with the impulses of the substeps                           a rough solve
//!   v_2      with these corrected, towards the velocities of the substeps   to the end
//!   v_0      of the clusters that part though the substeps did not expect it   likewise
//!   v_0 + a (v_2 - v_0)  where their work is too much                    to the end
//! ```

use super::pressure_step::PressureStep;
use crate::Result;
use crate::contact::{Impulse, Impulses};
use crate::particles::RigidVelocity;
use crate::poisson::pressure::{Accuracy, Projected};
use nalgebra::Vector3;

/// Part of the digits asked for, to which the pressure is found for the response to contact
/// impulses: the solve after it, with the corrected impulses, has all of them.
const RESPONSE_DIGITS: f64 = 0.5;

/// Scratch, per body.
pub struct CorrectionScratch {
    residuals: Vec<RigidVelocity>,
    corrections: Vec<Impulse>,
    /// Time for which each body has moved as its residual lets expect, by its contacts (s).
    pub(super) followed: Vec<f64>,
}

impl CorrectionScratch {
    /// Scratch for `n` bodies.
    pub fn new(n: usize) -> CorrectionScratch {
        CorrectionScratch {
            residuals: vec![RigidVelocity::default(); n],
            corrections: vec![Impulse::default(); n],
            followed: vec![0.0; n],
        }
    }
}

/// (13-15) where contacts gave impulses in the step: these are corrected, and their work is
/// bounded. Returns also the work (J) that the bound took. Collective.
///
/// # Errors
/// As [`PressureStep::solve`].
pub fn solve<const D: usize>(
    impulses: &mut Impulses,
    step: &mut PressureStep<D>,
    work: &mut CorrectionScratch,
) -> Result<(Projected, f64)> {
    let mut done = Projected::default();
    let motions = step.motions();
    let parts = impulses.find_clusters(step.bodies(), |k| motions[k].expected);
    if parts {
        done.add(find_without(impulses, step, work)?);
    }
    done.add(step.solve(Accuracy::Digits(RESPONSE_DIGITS))?);
    impulses.find_response(step.bodies());
    correct(impulses, step, work);
    done.add(step.solve(Accuracy::Full)?);
    let late = impulses.find_late_parting(step.bodies());
    if late {
        done.add(find_without(impulses, step, work)?);
        done.add(step.solve(Accuracy::Full)?);
    }
    let taken = if parts || late { impulses.bound_work(step.bodies()) } else { 0.0 };
    if taken > 0.0 {
        impulses.reduce(step.bodies(), &mut work.corrections);
        step.apply(impulses, &work.corrections);
        done.add(step.solve(Accuracy::Full)?);
    }
    Ok((done, taken))
}

/// Finds the velocities without the impulses of touch of the clusters that part, by a rough solve.
/// Collective.
fn find_without<const D: usize>(
    impulses: &mut Impulses,
    step: &mut PressureStep<D>,
    work: &mut CorrectionScratch,
) -> Result<Projected> {
    apply_touch(impulses, step, work, -1.0);
    let done = step.solve(Accuracy::Digits(RESPONSE_DIGITS))?;
    impulses.note_without(step.bodies());
    apply_touch(impulses, step, work, 1.0);
    Ok(done)
}

/// Corrects the impulses of contacts by what the pressure has made of them.
fn correct<const D: usize>(
    impulses: &mut Impulses,
    step: &mut PressureStep<D>,
    work: &mut CorrectionScratch,
) {
    let CorrectionScratch { residuals, corrections, .. } = work;
    for ((residual, body), motion) in residuals.iter_mut().zip(step.bodies()).zip(step.motions()) {
        let RigidVelocity { velocity, spin } = motion.expected;
        let turned = if body.is_round() { Vector3::zeros() } else { body.spin - spin };
        let moved = RigidVelocity { velocity: body.velocity - velocity, spin: turned };
        let free = body.freedom().map(|_| moved);
        *residual = free.unwrap_or_default();
    }
    impulses.correct(step.bodies(), residuals, corrections, step.dt());
    step.apply(impulses, corrections);
}

/// Gives the bodies of the clusters that part a multiple of the impulses of touch.
fn apply_touch<const D: usize>(
    impulses: &Impulses,
    step: &mut PressureStep<D>,
    work: &mut CorrectionScratch,
    factor: f64,
) {
    for (k, correction) in work.corrections.iter_mut().enumerate() {
        let Impulse { linear, angular } = impulses.impulse_of_touch(k);
        *correction = Impulse { linear: factor * linear, angular: factor * angular };
    }
    step.apply(impulses, &work.corrections);
}
