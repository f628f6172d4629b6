//! Number of substeps that a step needs.

use super::Substeps;
use super::law::Law;
use super::meeting::Layout;
use super::pair::Pair;
use crate::config::MOST_SUBSTEPS;
use crate::numerics::CONTACT_SUBSTEPS;
use crate::{Error, Result};
use mics_shapes::Part;

/// Substeps in a contact over those in which a gap changes by its width: the fluid in the gap acts
/// implicitly, and half and twice as many change a rebound by 0.2 %.
const GAP_SHARE: f64 = 10.0;

/// Substeps in a contact below which a run ends.
const FEWEST_PER_CONTACT: f64 = 5.0;

/// Fewest substeps of a step in which the fluid between two acts: what resists their approach,
/// their sliding and their rolling does so one after the other (a sphere pulled along a wall at
/// 0.02 h: 3 % too fast in one substep, 0.15 % in 20).
const FEWEST_OF_FILMS: f64 = 0.5 * CONTACT_SUBSTEPS;

/// Substeps for the rest of the step, `time` (s), after those `taken`.
pub(super) fn count(layout: &Layout, pairs: &[Pair], time: f64, taken: usize) -> Result<usize> {
    pairs.iter().try_fold(1, |count, pair| Ok(count.max(count_for(layout, pair, time, taken)?)))
}

/// Substeps that a pair needs.
fn count_for(layout: &Layout, pair: &Pair, time: f64, taken: usize) -> Result<usize> {
    let lubrication = apart(layout, pair, time);
    match (layout.setup.substeps, lubrication) {
        // The fluid between them alone counts.
        (Substeps::Auto, Some(wanted)) => Ok(wanted.ceil() as usize),
        (Substeps::Fixed(_), Some(_)) => Ok(1),
        (Substeps::Auto, None) => {
            let (law, mass, contact) = contact_of(layout, pair, time);
            let wanted = CONTACT_SUBSTEPS * time / contact * law.damping_ratio(mass).max(1.0);
            let films = layout.setup.medium.range() > 0.0;
            let wanted = if films { wanted.max(FEWEST_OF_FILMS) } else { wanted };
            if wanted > MOST_SUBSTEPS {
                Err(too_stiff(layout, pair, contact, time, wanted))
            } else {
                Ok(wanted.ceil() as usize)
            }
        }
        (Substeps::Fixed(n), None) => {
            let (_, _, contact) = contact_of(layout, pair, time);
            let count = n.saturating_sub(taken).max(1);
            if contact / time * (count as f64) < FEWEST_PER_CONTACT {
                Err(too_few(layout, pair, contact, time / count as f64))
            } else {
                Ok(count)
            }
        }
    }
}

/// Speed (m/s) at which a pair may come to approach within `time` (s).
fn pushed(layout: &Layout, pair: &Pair, time: f64) -> f64 {
    let (body, other) = layout.two(pair);
    let (response, its_response) = layout.responses(pair);
    let mut velocity = body.velocity;
    let mut acceleration = response.accelerations.acceleration;
    if let (Some(other), Some(its)) = (other, its_response) {
        velocity -= other.velocity;
        acceleration -= its.accelerations.acceleration;
    }
    let its_rim = other.map_or(0.0, |other| layout.states[pair.second].rim_speed(other));
    let rims = layout.states[pair.first].rim_speed(body) + its_rim;
    velocity.norm() + acceleration.norm() * time + rims
}

/// Substeps that the fluid between a pair needs in `time` (s), where the two cannot touch in that
/// time, whatever strikes them; `None` where they could.
fn apart(layout: &Layout, pair: &Pair, time: f64) -> Option<f64> {
    let gap = -layout.closest(pair, 0.0).overlap;
    let way = pushed(layout, pair, time) * time;
    let fewest = if gap < layout.setup.medium.range() { FEWEST_OF_FILMS } else { 1.0 };
    let wanted = || {
        let wanted = CONTACT_SUBSTEPS / GAP_SHARE * way / (gap - way).max(0.25 * gap);
        wanted.clamp(fewest, CONTACT_SUBSTEPS)
    };
    let radius = layout.bodies[pair.first].radius();
    // A body never touches its own image.
    (pair.is_own_image() || gap > 2.0 * way + 0.05 * radius).then(wanted)
}

/// Least mass (kg) that a contact of a pair may stop: at the longest arm of bodies that are not
/// round, which turn out of the way.
fn least_mass(layout: &Layout, pair: &Pair) -> f64 {
    if pair.round {
        return f64::INFINITY;
    }
    let of = |k: usize, part: usize| {
        let Some(body) = layout.bodies.get(k) else { return 0.0 };
        let response = &layout.states[k].response;
        let arm = body.parts().get(part).map_or(0.0, Part::lever);
        response.mass.max() + arm * arm * response.inertia.max()
    };
    1.0 / (of(pair.first, pair.parts[0]) + of(pair.second, pair.parts[1]))
}

/// The law of a pair, its mass (kg), and the duration of a contact (s) at the speed that the pair
/// may reach within `time` (s).
fn contact_of<'a>(layout: &Layout<'a>, pair: &Pair, time: f64) -> (&'a Law, f64, f64) {
    let law = layout.law(pair);
    let kinematics = layout.kinematics(pair, 0.0).0;
    let mass = kinematics.mass_of_overlap().min(least_mass(layout, pair));
    let pushed = pushed(layout, pair, time);
    // The energy of an overlap counts as that of an approach.
    let speed = (pushed * pushed + 2.0 * law.stored(kinematics.overlap) / mass).sqrt();
    (law, mass, law.contact_time(mass, speed))
}

/// Number of substeps in which the fluid between a pair acts once, of `count` in `time` (s).
pub(super) fn stride(layout: &Layout, pair: &Pair, time: f64, count: usize) -> usize {
    let wanted = apart(layout, pair, time);
    let stride = wanted.map_or(1.0, |wanted| count as f64 / wanted);
    (stride as usize).max(1)
}

fn too_stiff(layout: &Layout, pair: &Pair, contact: f64, time: f64, wanted: f64) -> Error {
    Error::Run(format!(
        "{}: a contact lasts {contact:.3e} s, for which a step of {time:.3e} s would need \
        {wanted:.1e} substeps: lower the \
        stiffness or shorten the step",
        layout.setup.name(pair),
    ))
}

fn too_few(layout: &Layout, pair: &Pair, contact: f64, substep: f64) -> Error {
    Error::Run(format!(
        "{}: a contact lasts {contact:.3e} s, which are {:.2} substeps of {substep:.3e} s, and \
        {FEWEST_PER_CONTACT} at \
        least are needed: raise contact.substeps or lower the stiffness",
        layout.setup.name(pair),
        contact / substep,
    ))
}
