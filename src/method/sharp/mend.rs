//! Contacts and fluid at one: what the fluid makes of the contacts' impulses is compared with what the substeps expected, and
//! mended with another solve where it differs ([`crate::contact`] has the formulas).

use super::Sharp;
use crate::params;
use crate::state::State;
use nalgebra::Vector3;

/// Scratch, per body.
pub struct Work {
    /// How far velocities are from the expected ones (m/s).
    deviations: Vec<Vector3<f64>>,
    /// Impulses that mend them (N s).
    nudges: Vec<Vector3<f64>>,
}

impl Work {
    /// That of so many bodies.
    pub fn new(n: usize) -> Work {
        let none = vec![Vector3::zeros(); n];
        Work { deviations: none.clone(), nudges: none }
    }
}

impl<const D: usize> Sharp<D> {
    /// Pushes bodies in contact to the velocities along their contacts that the substeps expected, and the faces with them;
    /// whether there was anything to push, so that the pressure has to be found anew. `round` counts from 0.
    pub(super) fn mend_contacts(&mut self, s: &mut State<D>, round: usize, dt: f64) -> bool {
        let Some(contacts) = &mut self.contacts else { return false };
        if !contacts.gave() {
            return false;
        }
        let Work { deviations, nudges } = &mut self.work.mend;
        if round == params::mending_solves() as usize {
            return false;
        }
        for ((deviation, body), motion) in deviations.iter_mut().zip(&s.bodies).zip(&self.motions) {
            *deviation = if body.freedom().is_some() { body.velocity - motion.expected.0 } else { Default::default() };
        }
        let tolerance =
            params::mending_deviation() * contacts.pace(&s.bodies) + params::mending_floor() * self.cut.h / dt;
        let off = contacts.mend(&s.bodies, deviations, nudges, tolerance);
        if off < tolerance {
            return false;
        }
        for (k, (body, motion)) in s.bodies.iter_mut().zip(&self.motions).enumerate() {
            let Some(freedom) = body.freedom() else { continue };
            let change = freedom.along(&nudges[k]) / motion.inertia;
            body.velocity += change;
            self.cut.bodies[k].carry_faces(&change, &mut s.faces);
        }
        true
    }
}
