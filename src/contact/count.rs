//! How many substeps a step needs.

use super::law::Law;
use super::pair::Pair;
use super::response::InverseMass;
use super::substep::rim_speed;
use super::{Contacts, Substeps};
use crate::config::MOST_SUBSTEPS;
use crate::numerics::CONTACT_SUBSTEPS;
use crate::particles::Body;
use crate::{Error, Result};
use mics_shapes::Part;

/// How many times fewer substeps there are while a gap changes by its width than in a contact: the
/// fluid in it acts implicitly, and half and twice as many change a rebound by 0.2 %.
const GAP_SHARE: f64 = 10.0;

/// Substeps in a contact below which a run ends.
const FEWEST_PER_CONTACT: f64 = 5.0;

/// Fewest substeps of a step in which the fluid between two acts: what resists their approach,
/// their sliding and their rolling does so one after the other (a sphere pulled along a wall at
/// 0.02 h: 3 % too fast in one substep, 0.15 % in 20).
const FEWEST_OF_FILMS: f64 = 0.5 * CONTACT_SUBSTEPS;

impl Contacts {
    /// Substeps for the rest of the step, `time` (s), after those `taken`.
    pub(super) fn count(&self, bodies: &[Body], time: f64, taken: usize) -> Result<usize> {
        self.pairs
            .iter()
            .try_fold(1, |count, pair| Ok(count.max(self.count_for(pair, bodies, time, taken)?)))
    }

    /// Those that a pair needs.
    pub(super) fn count_for(
        &self,
        pair: &Pair,
        bodies: &[Body],
        time: f64,
        taken: usize,
    ) -> Result<usize> {
        let lubrication = self.apart(pair, bodies, time);
        match (self.substeps, lubrication) {
            // The fluid between them alone counts.
            (Substeps::Auto, Some(wanted)) => Ok(wanted.ceil() as usize),
            (Substeps::Fixed(_), Some(_)) => Ok(1),
            (Substeps::Auto, None) => {
                let (law, mass, contact) = self.contact_of(pair, bodies, time);
                let wanted = CONTACT_SUBSTEPS * time / contact * law.damping_ratio(mass).max(1.0);
                let wanted =
                    if self.medium.range() > 0.0 { wanted.max(FEWEST_OF_FILMS) } else { wanted };
                if wanted > MOST_SUBSTEPS {
                    Err(self.too_stiff(pair, contact, time, wanted))
                } else {
                    Ok(wanted.ceil() as usize)
                }
            }
            (Substeps::Fixed(n), None) => {
                let (_, _, contact) = self.contact_of(pair, bodies, time);
                let count = n.saturating_sub(taken).max(1);
                if contact / time * (count as f64) < FEWEST_PER_CONTACT {
                    Err(self.too_few(pair, contact, time / count as f64))
                } else {
                    Ok(count)
                }
            }
        }
    }

    /// Speed (m/s) at which a pair may come to approach within `time` (s).
    pub(super) fn pushed(&self, pair: &Pair, bodies: &[Body], time: f64) -> f64 {
        let mut velocity = bodies[pair.first].velocity;
        let mut accelerations = self.inverse_masses[pair.first].accelerations.acceleration;
        if let Some(other) = bodies.get(pair.second) {
            velocity -= other.velocity;
            accelerations -= self.inverse_masses[pair.second].accelerations.acceleration;
        }
        let rims = rim_speed(&bodies[pair.first]) + bodies.get(pair.second).map_or(0.0, rim_speed);
        velocity.norm() + accelerations.norm() * time + rims
    }

    /// How many substeps the fluid between a pair wants in `time` (s), where the two cannot touch
    /// in it, whatever strikes them.
    pub(super) fn apart(&self, pair: &Pair, bodies: &[Body], time: f64) -> Option<f64> {
        let gap = -self.closest(pair, bodies, 0.0).overlap;
        let way = self.pushed(pair, bodies, time) * time;
        let fewest = if gap < self.medium.range() { FEWEST_OF_FILMS } else { 1.0 };
        let wanted = || {
            let wanted = CONTACT_SUBSTEPS / GAP_SHARE * way / (gap - way).max(0.25 * gap);
            wanted.clamp(fewest, CONTACT_SUBSTEPS)
        };
        // A body never touches its own image.
        (pair.is_own_image() || gap > 2.0 * way + 0.05 * bodies[pair.first].radius()).then(wanted)
    }

    /// Least mass (kg) that a contact of a pair may stop: at the longest arm of bodies that are not
    /// round, which turn out of the way.
    pub(super) fn least_mass(&self, pair: &Pair, bodies: &[Body]) -> f64 {
        if self.are_round(pair, bodies) {
            return f64::INFINITY;
        }
        let of = |k: usize, part: usize| {
            let Some(body) = bodies.get(k) else { return 0.0 };
            let InverseMass { mass, inertia, .. } = &self.inverse_masses[k];
            let arm = body.parts().get(part).map_or(0.0, Part::lever);
            mass.max() + arm * arm * inertia.max()
        };
        1.0 / (of(pair.first, pair.parts[0]) + of(pair.second, pair.parts[1]))
    }

    /// The law of a pair, its mass (kg), and how long a contact lasts at the speed that it may come
    /// to within `time` (s).
    pub(super) fn contact_of(&self, pair: &Pair, bodies: &[Body], time: f64) -> (&Law, f64, f64) {
        let law = self.law(pair);
        let kinematics = self.kinematics(pair, bodies, 0.0).0;
        let mass = kinematics.mass_of_overlap().min(self.least_mass(pair, bodies));
        let pushed = self.pushed(pair, bodies, time);
        // The energy of an overlap counts as that of an approach.
        let speed = (pushed * pushed + 2.0 * law.stored(kinematics.overlap) / mass).sqrt();
        (law, mass, law.contact_time(mass, speed))
    }

    /// Finds after how many of `count` substeps of `time` (s) the fluid between each pair is to
    /// act.
    pub(super) fn pace_films(&mut self, bodies: &[Body], time: f64, count: usize) {
        for p in 0..self.pairs.len() {
            let wanted = self.apart(&self.pairs[p], bodies, time);
            let stride = wanted.map_or(1.0, |wanted| count as f64 / wanted);
            self.pairs[p].stride = (stride as usize).max(1);
        }
    }

    pub(super) fn too_stiff(&self, pair: &Pair, contact: f64, time: f64, wanted: f64) -> Error {
        Error::Run(format!(
            "{}: a contact lasts {contact:.3e} s, for which a step of {time:.3e} s would need \
            {wanted:.1e} substeps: lower the \
             stiffness or shorten the step",
            self.name(pair),
        ))
    }

    pub(super) fn too_few(&self, pair: &Pair, contact: f64, substep: f64) -> Error {
        Error::Run(format!(
            "{}: a contact lasts {contact:.3e} s, which are {:.2} substeps of {substep:.3e} s, and \
            {FEWEST_PER_CONTACT} at \
             least are needed: raise contact.substeps or lower the stiffness",
            self.name(pair),
            contact / substep,
        ))
    }
}
