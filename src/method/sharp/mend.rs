//! Contacts and fluid at one: what the fluid makes of the contacts' impulses, as a rough solve shows it, is compared with what the
//! substeps expected, and mended before the pressure is found to the end ([`crate::contact`] has the formulas).

use super::{Sharp, history};
use crate::Result;
use crate::contact::{Deviation, Found, Impulse};
use crate::domain::Domain;
use crate::params;
use crate::poisson::pressure::Projected;
use crate::state::State;
use std::ops::Range;

/// The part of what there was to mend that is left by a round which is the last one worth it.
const STALLED: f64 = 0.9;

/// Scratch, per body.
pub struct Work {
    /// How far it is from what was expected.
    deviations: Vec<Deviation>,
    /// The impulse that mends it.
    nudges: Vec<Impulse>,
}

impl Work {
    /// That of so many bodies.
    pub fn new(n: usize) -> Work {
        Work { deviations: vec![Deviation::default(); n], nudges: vec![Impulse::default(); n] }
    }
}

impl<const D: usize> Sharp<D> {
    /// Pushes bodies in contact, some of them `light`, to the velocities and spins at their contacts that the substeps expected, and the faces with them,
    /// and finds the pressure to the end. Collective.
    pub(super) fn project_mended(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        light: bool,
        dt: f64,
    ) -> Result<Projected> {
        // Of what bodies that lay on others before their first step weigh, contacts know nothing yet.
        let lying = history(&mut s.walls)?.bodies.iter().any(|history| history.pressed.0.is_none());
        let digits = Some(params::mending_digits());
        // What is looked at last in other steps is a pressure found to the end.
        let (rounds, again) = match (lying, light) {
            (true, _) => (params::first_mendings() as usize, digits),
            (false, true) => (params::most_mendings() as usize, None),
            (false, false) => (1, None),
        };
        let mut sum = self.project_with_bodies(domain, s, dt, digits)?;
        let (mut worth, mut mended) = (0.0..f64::INFINITY, false);
        for round in 0..rounds {
            let Some(found) = self.mend_contacts(s, round, &worth, lying, dt)? else { break };
            mended = true;
            if round == 0 && !lying {
                worth.start = params::mend_again() * found.size;
            }
            if round > 0 {
                // The first round may leave more than there was, of which the second makes use.
                worth.end = STALLED * found.size;
            }
            sum.add(self.project_with_bodies(domain, s, dt, again)?);
        }
        if again.is_some() || !mended {
            sum.add(self.project_with_bodies(domain, s, dt, None)?);
        }
        Ok(sum)
    }

    /// Mends the contacts once more, in the `round` of the step; what there was to mend, unless that was nothing worth it, or of a size that is not
    /// `worth` it.
    fn mend_contacts(
        &mut self,
        s: &mut State<D>,
        round: usize,
        worth: &Range<f64>,
        lying: bool,
        dt: f64,
    ) -> Result<Option<Found>> {
        let Some(contacts) = &mut self.contacts else { return Ok(None) };
        let Work { deviations, nudges } = &mut self.work.mend;
        for ((deviation, body), motion) in deviations.iter_mut().zip(&s.bodies).zip(&self.motions) {
            let free = body.freedom().is_some();
            let linear = if free { body.velocity - motion.expected.0 } else { Default::default() };
            *deviation = Deviation { linear, angular: motion.mended };
        }
        if round == 0 {
            let histories = &history(&mut s.walls)?.bodies;
            for (k, (body, history)) in s.bodies.iter().zip(histories).enumerate() {
                let lasting = history.pressed.lasting(&(contacts.impulses()[k].linear / dt));
                contacts.weigh(k, contacts.mass_in_contact(body, lasting));
            }
        }
        let tolerance =
            params::mending_deviation() * contacts.pace(&s.bodies) + params::mending_floor() * self.cut.h / dt;
        let found = contacts.find_mending(&s.bodies, deviations, nudges, round, tolerance, dt);
        // A fluid that answers with less than was expected has the rest in the next step, as a damper.
        let less = round == 1 && !lying && !found.turned;
        if found.off < tolerance || less || !worth.contains(&found.size) {
            return Ok(None);
        }
        contacts.mend(&s.bodies, nudges, round);
        for (k, (body, motion)) in s.bodies.iter_mut().zip(&mut self.motions).enumerate() {
            let Some(freedom) = body.freedom() else { continue };
            let change = freedom.along(&nudges[k].linear) / motion.inertia;
            let turned = contacts.turned_by(k, &nudges[k].angular);
            body.velocity += change;
            body.spin += turned;
            motion.mended += turned;
            self.cut.bodies[k].carry_faces(&change, &mut s.faces);
        }
        Ok(Some(found))
    }
}
