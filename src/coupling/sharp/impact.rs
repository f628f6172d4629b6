//! Contacts and fluid at one: what the fluid makes of the contacts' impulses is compared with what the substeps expected, and
//! mended with another solve where it differs ([`crate::solids::contact`] has the formulas).

use super::Sharp;
use crate::Result;
use crate::grid::VectorField;

/// Solves that mend a step.
pub(in crate::coupling) const MOST_ROUNDS: usize = 3;
/// Deviation from the expected speed of a contact that is worth a solve, of that speed; and of a spacing over the step.
const WORTH: f64 = 5e-3;
const WORTH_OF_SPACING: f64 = 2e-6;

impl<const D: usize> Sharp<D> {
    /// Pushes bodies in contact to the velocities along their contacts that the substeps expected, and the faces with them;
    /// whether there was anything to push, so that the pressure has to be found anew. `round` counts from 0.
    pub fn mend_contacts(&mut self, round: usize, dt: f64, faces: &mut VectorField<D>) -> Result<bool> {
        let Some(contacts) = &mut self.contacts else { return Ok(false) };
        if !contacts.gave() {
            return Ok(false);
        }
        if round > 0 {
            for (k, (body, unpushed)) in self.bodies.iter().zip(&self.unpushed).enumerate() {
                contacts.learn(body, k, &self.nudges[k], &(body.velocity - unpushed));
            }
        }
        if round == MOST_ROUNDS {
            return Ok(false);
        }
        for ((deviation, body), ride) in self.deviations.iter_mut().zip(&self.bodies).zip(&self.rides) {
            *deviation = if body.freedom().is_some() { body.velocity - ride.expected.0 } else { Default::default() };
        }
        let tolerance = WORTH * contacts.pace(&self.bodies) + WORTH_OF_SPACING * self.h / dt;
        let off = contacts.mend(&self.bodies, &mut self.deviations, &mut self.nudges, tolerance);
        if off < tolerance {
            return Ok(false);
        }
        for (k, (body, ride)) in self.bodies.iter_mut().zip(&self.rides).enumerate() {
            self.unpushed[k] = body.velocity;
            let Some(freedom) = body.freedom() else { continue };
            let change = freedom.along(&self.nudges[k]) / ride.inertia;
            body.velocity += change;
            for (axis, cuts) in self.skins[k].cuts.iter().enumerate() {
                cuts.iter().for_each(|cut| faces[axis][cut.face as usize] += cut.covered * change[axis]);
            }
        }
        Ok(true)
    }
}
