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

use super::coupled::CoupledFaces;
use super::{Sharp, history};
use crate::Result;
use crate::contact::Impulse;
use crate::domain::Domain;
use crate::poisson::pressure::Projected;
use crate::state::State;
use nalgebra::Vector3;

/// Part of the digits asked for to which the pressure is found that shows the response to contact
/// impulses: the solve after it, with the corrected impulses, has all of them.
const RESPONSE_DIGITS: f64 = 0.5;

/// Scratch, per body.
pub struct Work {
    residuals: Vec<Vector3<f64>>,
    corrections: Vec<Impulse>,
    followed: Vec<f64>,
}

impl Work {
    /// That of so many bodies.
    pub fn new(n: usize) -> Work {
        Work {
            residuals: vec![Vector3::zeros(); n],
            corrections: vec![Impulse::default(); n],
            followed: vec![0.0; n],
        }
    }
}

impl<const D: usize> Sharp<D> {
    /// (13-15) where contacts gave impulses in the step `dt` (s): these are corrected, and their
    /// work is bounded. Collective.
    pub(super) fn project_with_contacts(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<Projected> {
        let (digits, motions) = (Some(RESPONSE_DIGITS), &self.motions);
        let expected = |k: usize| [motions[k].expected.0, motions[k].expected.1];
        let parts = self
            .contacts
            .as_mut()
            .is_some_and(|contacts| contacts.find_clusters(&s.bodies, expected));
        let mut done = Projected::default();
        if parts {
            done.add(self.find_without(domain, s, dt)?);
        }
        done.add(self.project_with_bodies(domain, s, dt, digits)?);
        self.contacts.iter_mut().for_each(|contacts| contacts.find_response(&s.bodies));
        self.correct_contacts(s, dt);
        done.add(self.project_with_bodies(domain, s, dt, None)?);
        let late =
            self.contacts.as_mut().is_some_and(|contacts| contacts.find_late_parting(&s.bodies));
        if late {
            done.add(self.find_without(domain, s, dt)?);
            done.add(self.project_with_bodies(domain, s, dt, None)?);
        }
        let taken = self
            .contacts
            .as_mut()
            .filter(|_| parts || late)
            .map_or(0.0, |contacts| contacts.bound_work(&s.bodies));
        if taken > 0.0 {
            s.energy.bounded += taken;
            self.reduce_contacts(s);
            done.add(self.project_with_bodies(domain, s, dt, None)?);
        }
        Ok(done)
    }

    /// Finds the velocities without the impulses of touch of the clusters that part, by a rough
    /// solve. Collective.
    fn find_without(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<Projected> {
        self.apply_touch(s, -1.0);
        let done = self.project_with_bodies(domain, s, dt, Some(RESPONSE_DIGITS))?;
        self.contacts.iter_mut().for_each(|contacts| contacts.note_without(&s.bodies));
        self.apply_touch(s, 1.0);
        Ok(done)
    }

    /// Corrects the impulses of contacts by what the pressure has made of them.
    fn correct_contacts(&mut self, s: &mut State<D>, dt: f64) {
        let Some(contacts) = &mut self.contacts else { return };
        let (Work { residuals, corrections, .. }, motions) =
            (&mut self.work.contacts, &self.motions);
        for ((residual, body), motion) in residuals.iter_mut().zip(&s.bodies).zip(motions) {
            let free = body.freedom().is_some();
            *residual = if free { body.velocity - motion.expected.0 } else { Vector3::zeros() };
        }
        contacts.correct(&s.bodies, residuals, corrections, dt);
        self.apply_corrections(s);
    }

    /// Takes the corrections of the positions of bodies in contact for the next step.
    pub(super) fn take_displacements(&mut self, s: &mut State<D>) -> Result<()> {
        let Some(contacts) = &self.contacts else { return Ok(()) };
        let followed = &mut self.work.contacts.followed;
        contacts.find_followed(&s.bodies, followed);
        let histories = history(&mut s.walls)?.bodies.iter_mut();
        for (((history, body), motion), time) in
            histories.zip(&s.bodies).zip(&self.motions).zip(followed)
        {
            history.displacement = 0.5 * *time * (body.velocity - motion.expected.0);
        }
        Ok(())
    }

    /// Takes back what the bound leaves of the impulses of touch.
    fn reduce_contacts(&mut self, s: &mut State<D>) {
        if let Some(contacts) = &mut self.contacts {
            contacts.reduce(&s.bodies, &mut self.work.contacts.corrections);
        }
        self.apply_corrections(s);
    }

    /// Gives the bodies of the clusters that part a multiple of the impulses of touch.
    fn apply_touch(&mut self, s: &mut State<D>, factor: f64) {
        let Some(contacts) = &self.contacts else { return };
        for (k, correction) in self.work.contacts.corrections.iter_mut().enumerate() {
            let Impulse { linear, angular } = contacts.impulse_of_touch(k);
            *correction = Impulse { linear: factor * linear, angular: factor * angular };
        }
        self.apply_corrections(s);
    }

    /// Gives all bodies, and their faces, the correction impulses.
    fn apply_corrections(&mut self, s: &mut State<D>) {
        let Some(contacts) = &self.contacts else { return };
        let mut coupled = CoupledFaces::new(&self.cut, &mut s.faces, &mut s.bodies);
        for (k, correction) in self.work.contacts.corrections.iter().enumerate() {
            let Some(freedom) = coupled.bodies()[k].freedom() else { continue };
            let change = freedom.along(&correction.linear) / self.motions[k].inertia;
            coupled.change(k, &change, &contacts.turned_by(k, &correction.angular));
        }
    }
}
