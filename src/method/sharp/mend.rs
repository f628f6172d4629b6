//! Contacts and fluid at one: what the fluid makes of the contacts' impulses, as a rough solve shows it, is compared with what the
//! substeps expected, and mended before the pressure is found to the end ([`crate::contact`] has the formulas).
//!
//! A light body that touches one wall or held body alone is the fluid that goes along with it, and how much that is depends on where it
//! is, and on what viscosity spreads within the step. So what mended it shows it, along each axis:
//!
//! ```text
//!   carried = sum P^2 / sum P dv - m        P: what it was mended by in each round, dv: what the fluid made of that
//! ```
//! for the contacts of the next step. Among other free bodies, with which it moves or does not, that is no property of its own.

use super::motion::resistance;
use super::{Sharp, history};
use crate::Result;
use crate::contact::{Deviation, Found, Impulse};
use crate::domain::Domain;
use crate::params;
use crate::poisson::pressure::Projected;
use crate::state::State;
use nalgebra::Vector3;

/// The part of what there was to mend that is left by a round which is the last one worth it.
const STALLED: f64 = 0.9;

/// Part of what mended a body, squared, that an axis has to have for the answer along it to count.
const SEEN: f64 = 0.01;

/// The most fluid that a body shows to go along with it: as an impact has it, and what the wall shear resists over so many times the step.
const MOST_STEPS: f64 = 4.0;

/// Scratch, per body.
pub struct Work {
    /// How far it is from what was expected.
    deviations: Vec<Deviation>,
    /// The impulse that mends it.
    nudges: Vec<Impulse>,
    /// Its velocity before that (m/s), and P^2 and P dv by axis, summed over the rounds.
    before: Vec<Vector3<f64>>,
    answered: Vec<[Vector3<f64>; 2]>,
}

impl Work {
    /// That of so many bodies.
    pub fn new(n: usize) -> Work {
        Work {
            deviations: vec![Deviation::default(); n],
            nudges: vec![Impulse::default(); n],
            before: vec![Vector3::zeros(); n],
            answered: vec![[Vector3::zeros(); 2]; n],
        }
    }
}

/// What a round has to find for another to be worth it, by its size (J^1/2).
#[derive(Clone, Copy, Default)]
struct Worth {
    /// At least so much where the fluid has answered with more than was expected; and where with less, of bodies that are alone at one wall or held body: in a
    /// pile the rest is left to the next step, as a damper.
    more: f64,
    less: f64,
    /// Less than that.
    most: Option<f64>,
}

impl Worth {
    fn has(&self, found: &Found) -> bool {
        let enough = if found.turned { found.size >= self.more } else { found.alone >= self.less };
        enough && self.most.is_none_or(|most| found.size < most)
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
        self.work.mend.answered.fill(Default::default());
        let mut sum = self.project_with_bodies(domain, s, dt, digits)?;
        let (mut worth, mut mended) = (Worth::default(), false);
        for round in 0..rounds {
            let Some(found) = self.mend_contacts(s, round, &worth, lying, dt)? else { break };
            mended = true;
            if round == 0 && !lying {
                let less = if found.alone > 0.0 { params::mend_on() * found.alone } else { f64::INFINITY };
                (worth.more, worth.less) = (params::mend_again() * found.size, less);
            }
            if round > 0 {
                // The first round may leave more than there was, of which the second makes use.
                worth.most = Some(STALLED * found.size);
            }
            sum.add(self.project_with_bodies(domain, s, dt, again)?);
            self.take_answers(s);
        }
        if again.is_some() || !mended {
            sum.add(self.project_with_bodies(domain, s, dt, None)?);
        }
        if light && !lying {
            self.find_carried(domain, s, dt)?;
        }
        Ok(sum)
    }

    /// Mends the contacts once more, in the `round` of the step; what there was to mend, unless that was nothing `worth` it.
    fn mend_contacts(
        &mut self,
        s: &mut State<D>,
        round: usize,
        worth: &Worth,
        lying: bool,
        dt: f64,
    ) -> Result<Option<Found>> {
        let Some(contacts) = &mut self.contacts else { return Ok(None) };
        let Work { deviations, nudges, before, .. } = &mut self.work.mend;
        for ((deviation, body), motion) in deviations.iter_mut().zip(&s.bodies).zip(&self.motions) {
            let free = body.freedom().is_some();
            let linear = if free { body.velocity - motion.expected.0 } else { Default::default() };
            *deviation = Deviation { linear, angular: motion.mended };
        }
        if round == 0 {
            let histories = &history(&mut s.walls)?.bodies;
            for (k, (body, history)) in s.bodies.iter().zip(histories).enumerate() {
                let lasting = history.pressed.lasting(&(contacts.impulses()[k].linear / dt));
                contacts.weigh(k, &contacts.mass_in_contact(body, lasting, &history.carried));
            }
        }
        let tolerance =
            params::mending_deviation() * contacts.pace(&s.bodies) + params::mending_floor() * self.cut.h / dt;
        let found = contacts.find_mending(&s.bodies, deviations, nudges, round, tolerance, dt);
        // What flies apart as fast as was expected but for a heavier fluid has the rest in the next step, as a damper.
        let flung = round == 1 && !lying && !found.turned && found.flung;
        if found.off < tolerance || flung || !worth.has(&found) {
            return Ok(None);
        }
        contacts.mend(&s.bodies, nudges, round);
        for (k, (body, motion)) in s.bodies.iter_mut().zip(&mut self.motions).enumerate() {
            before[k] = body.velocity;
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

    /// Takes note of what the fluid has made of a round.
    fn take_answers(&mut self, s: &State<D>) {
        let Work { nudges, before, answered, .. } = &mut self.work.mend;
        for (((body, nudge), before), [squares, products]) in s.bodies.iter().zip(nudges).zip(before).zip(answered) {
            *squares += nudge.linear.component_mul(&nudge.linear);
            *products += nudge.linear.component_mul(&(body.velocity - *before));
        }
    }

    /// Finds from that what goes along with light bodies which touch one wall or held body alone.
    fn find_carried(&mut self, domain: &Domain<D>, s: &mut State<D>, dt: f64) -> Result<()> {
        let Some(contacts) = &self.contacts else { return Ok(()) };
        let Work { answered, .. } = &self.work.mend;
        let (unit, histories) = (domain.fluid.viscosity / self.cut.h, &mut history(&mut s.walls)?.bodies);
        for (k, (body, history)) in s.bodies.iter().zip(histories).enumerate() {
            if !contacts.is_alone(k) || !contacts.is_light(body) {
                history.carried = Vector3::zeros();
                continue;
            }
            let (drag, _) = resistance(body, &self.motions[k].shell, unit);
            let most = contacts.carried_in_impact(body) + MOST_STEPS * dt * drag;
            let [squares, products] = answered[k];
            for axis in (0..D).filter(|&axis| squares[axis] > SEEN * squares.sum()) {
                let mass = if products[axis] > 0.0 { squares[axis] / products[axis] } else { f64::INFINITY };
                history.carried[axis] = (mass - body.mass()).clamp(contacts.least_carried(body), most);
            }
        }
        Ok(())
    }
}
