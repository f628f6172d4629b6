//! Contacts and fluid at one: what the fluid makes of the contacts' impulses, as a rough solve shows it, is compared with what the
//! substeps expected, and mended before the pressure is found to the end ([`crate::contact`] has the formulas).

use super::{Sharp, history};
use crate::contact::Impulse;
use crate::state::State;
use crate::{Result, params};
use nalgebra::Vector3;

/// Scratch, per body.
pub struct Work {
    /// How far velocities are from the expected ones (m/s).
    deviations: Vec<Vector3<f64>>,
    /// Impulses that mend them.
    nudges: Vec<Impulse>,
}

impl Work {
    /// That of so many bodies.
    pub fn new(n: usize) -> Work {
        Work { deviations: vec![Vector3::zeros(); n], nudges: vec![Impulse::default(); n] }
    }
}

impl<const D: usize> Sharp<D> {
    /// Pushes bodies in contact to the velocities and spins at their contacts that the substeps expected, and the faces with them, before
    /// the pressure is found to the end. Returns how far a pair was off at most (m/s).
    pub(super) fn mend_contacts(&mut self, s: &mut State<D>, dt: f64) -> Result<f64> {
        let Some(contacts) = &mut self.contacts else { return Ok(0.0) };
        let Work { deviations, nudges } = &mut self.work.mend;
        for ((deviation, body), motion) in deviations.iter_mut().zip(&s.bodies).zip(&self.motions) {
            *deviation = if body.freedom().is_some() { body.velocity - motion.expected.0 } else { Default::default() };
        }
        let histories = &history(&mut s.walls)?.bodies;
        for (k, (body, history)) in s.bodies.iter().zip(histories).enumerate() {
            let lasting = history.lasting(&(contacts.impulses()[k].linear / dt));
            contacts.weigh(k, contacts.mass_in_contact(body, lasting));
        }
        let tolerance =
            params::mending_deviation() * contacts.pace(&s.bodies) + params::mending_floor() * self.cut.h / dt;
        let off = contacts.mend(&s.bodies, deviations, nudges, tolerance, dt);
        if off < tolerance {
            return Ok(0.0);
        }
        for (k, (body, motion)) in s.bodies.iter_mut().zip(&self.motions).enumerate() {
            let Some(freedom) = body.freedom() else { continue };
            let change = freedom.along(&nudges[k].linear) / motion.inertia;
            body.velocity += change;
            body.spin += contacts.turned_by(k, &nudges[k].angular);
            self.cut.bodies[k].carry_faces(&change, &mut s.faces);
        }
        Ok(off)
    }
}
