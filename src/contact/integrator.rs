//! The substeps (20-26): the kick by accelerations and contacts, the drift, and the fluid in the
//! gaps; formulas in [`super`].

use super::arms::{Arms, PairImpulse};
use super::body::ContactBody;
use super::law::Kinematics;
use super::meeting::Layout;
use super::outcome::Outcome;
use super::pair::{Meeting, Met, Pair};
use super::pairs::{Pairs, Travel, together};
use super::setup::Setup;
use super::{Impulse, count, gaps, overlap, rolling};
use crate::Result;
use crate::particles::Body;
use nalgebra::Vector3;

/// Part of a gap between shapes that the two may go before it is found anew.
const SAME_PLACE: f64 = 1e-2;

/// Moves bodies on in substeps, under accelerations that are frozen over the step and under their
/// contacts.
pub(super) struct Integrator<'a> {
    pub(super) setup: &'a Setup,
    pub(super) pairs: &'a mut Pairs,
    /// Per body, its response and its load in the step.
    pub(super) states: &'a mut [ContactBody],
    pub(super) bodies: &'a mut [Body],
    /// The forces of the contacts that press in the substep.
    pub(super) forces: &'a mut Vec<ContactForce>,
    pub(super) outcome: &'a mut Outcome,
}

/// The force of a contact over a substep.
#[derive(Clone, Debug)]
pub(super) struct ContactForce {
    /// The place of its pair.
    pair: usize,
    /// Its normal force (N).
    normal: f64,
    /// Total force on the first of the pair, and torques on both (N, N m).
    whole: PairImpulse,
    /// Tangential force, and torque against rolling or twisting, on the first of the pair (N, N m).
    tangential: Vector3<f64>,
    torque: Vector3<f64>,
    kinematics: Kinematics,
    arms: Arms,
}

impl Integrator<'_> {
    /// Moves the bodies on by at most `time` (s), until one goes beyond its search radius; returns
    /// the time that is left (s).
    pub(super) fn advance(&mut self, time: f64) -> Result<f64> {
        if self.pairs.list.is_empty() {
            self.drift(time);
            return Ok(0.0);
        }
        let count = self.count(time)?;
        let h = time / count as f64;
        let mut done = 0;
        let mut within = true;
        while done < count && within {
            done += 1;
            self.load(h)?;
            within = self.carry(h);
            self.lubricate(h, Some(done));
        }
        self.lubricate(0.0, None);
        self.drift(h * done as f64);
        self.outcome.substeps += done;
        Ok(if done < count { time - h * done as f64 } else { 0.0 })
    }

    /// Finds how many substeps `time` (s) needs, and after how many the fluid of a pair is to act.
    fn count(&mut self, time: f64) -> Result<usize> {
        let Integrator { setup, pairs: Pairs { list, regions, .. }, states, bodies, .. } = self;
        let layout = Layout { setup, regions, states, bodies };
        let count = count::count(&layout, list, time, self.outcome.substeps)?;
        list.iter_mut().for_each(|p| p.film.stride = count::stride(&layout, p, time, count));
        Ok(count)
    }

    /// Finds the forces of all pairs in a substep of `h` (s).
    fn load(&mut self, h: f64) -> Result<()> {
        let Integrator { setup, pairs, states, bodies, forces, outcome } = self;
        let Pairs { list, travels, regions, .. } = &mut **pairs;
        forces.clear();
        for (k, (state, body)) in states.iter_mut().zip(bodies.iter()).enumerate() {
            state.load = Impulse::default();
            if travels[k].paired {
                state.turn_to_middle(body, h);
                travels[k].next =
                    travels[k].gone + h * (body.velocity.norm() + state.rim_speed(body));
            }
        }
        for (p, pair) in list.iter_mut().enumerate() {
            let layout = Layout { setup, regions, states, bodies };
            let Some(meeting) = look(&layout, pair, travels, h) else { continue };
            outcome.deepest = outcome.deepest.max(meeting.overlap);
            let force = press(&layout, p, pair, h, &meeting)?;
            if let Some(wall) = setup.wall(pair) {
                outcome.wall_impulse -= h * force.whole.linear;
                outcome.wall_work += h * force.whole.linear.dot(&wall.velocity);
            }
            for (k, load) in pair.each(&force.whole) {
                states.get_mut(k).into_iter().for_each(|state| state.load += load);
            }
            if force.normal > 0.0 {
                outcome.touch(pair);
                forces.push(force);
            }
        }
        let layout = Layout { setup, regions, states, bodies };
        let powers = forces.iter().map(|force| h * force.power(&layout, &list[force.pair]));
        outcome.friction_loss -= powers.sum::<f64>();
        Ok(())
    }

    /// Moves the bodies that have a pair by `h` (s) under their loads; whether all stay within
    /// their search radius in the next substep.
    fn carry(&mut self, h: f64) -> bool {
        let Integrator { setup, pairs, states, bodies, outcome, .. } = self;
        let mut within = true;
        for (k, (state, body)) in states.iter_mut().zip(bodies.iter_mut()).enumerate() {
            let way = &mut pairs.travels[k];
            if !way.paired {
                continue;
            }
            let Impulse { linear, angular } = state.load;
            outcome.bodies[k].impulse += Impulse { linear: h * linear, angular: h * angular };
            let loaded = state.response.accelerations_under(&state.load);
            way.gone += state.travel(body, &loaded, h, &setup.periods);
            let acceleration = state.response.accelerations.acceleration.norm();
            let next = (body.speed() + 0.5 * acceleration * h) * h + state.rim_speed(body) * h;
            within &= way.gone + next <= pairs.search_radius[k];
        }
        within
    }

    /// Moves the bodies without a pair by `time` (s).
    fn drift(&mut self, time: f64) {
        let all = self.states.iter_mut().zip(self.bodies.iter_mut()).zip(&self.pairs.travels);
        for ((state, body), _) in all.filter(|(_, way)| !way.paired) {
            let accelerations = state.response.accelerations;
            state.travel(body, &accelerations, time, &self.setup.periods);
        }
    }

    /// Lets the fluid in the gaps act over the substep of `h` (s) that is `done`, or over what is
    /// left for it to do, pair by pair, each implicitly.
    fn lubricate(&mut self, h: f64, done: Option<usize>) {
        let Integrator { setup, pairs, states, bodies, outcome, .. } = self;
        let Pairs { list, colours, travels, regions, .. } = &mut **pairs;
        let range = setup.medium.range();
        if range == 0.0 {
            return;
        }
        let substep = if done.is_some() { h } else { 0.0 };
        for &place in colours.order() {
            let pair = &mut list[place];
            pair.film.due += h;
            if let Some(met) = &mut pair.seen.met {
                met.age += h;
            }
            if pair.film.due == 0.0 || done.is_some_and(|done| done % pair.film.stride > 0) {
                continue;
            }
            let h = std::mem::take(&mut pair.film.due);
            let gone = together(pair, travels, |way| way.gone);
            // No nearer than since it was looked at last.
            if pair.seen.clear - gone > range {
                continue;
            }
            let layout = Layout { setup, regions, states, bodies };
            let meeting = see(&layout, pair, h, substep, gone);
            let gap = -meeting.overlap;
            if gap > range {
                continue;
            }
            if gap <= setup.medium.roughness {
                outcome.touch(pair);
            }
            let kinematics = layout.kinematics_at(pair, 0.0, &meeting);
            let next = gap - h * kinematics.approach;
            let film = gaps::lubrication(&layout, pair, meeting.radii, gap, next);
            pair.film.lubrication = film;
            let resistance = h * film.normal;
            let pressed =
                resistance * kinematics.approach / (1.0 + resistance * kinematics.inverse_normal);
            pair.sums.normal += pressed;
            let impulse = meeting.arms.impulse(-pressed * meeting.normal);
            apply(setup, states, pair, bodies, outcome, &impulse);
            // Along the gap, and what is left of the slip.
            let resistance = h * film.sliding;
            let left = 1.0 / (1.0 + resistance * kinematics.inverse_tangential);
            let impulse = meeting.arms.impulse(-resistance * left * kinematics.slip);
            apply(setup, states, pair, bodies, outcome, &impulse);
            let slip = left * kinematics.slip;
            let layout = Layout { setup, regions, states, bodies };
            let impulse = gaps::rolling_impulse(&layout, pair, &meeting, &slip, h * film.rolling);
            apply(setup, states, pair, bodies, outcome, &impulse);
        }
    }
}

/// Gives an impulse to the two of a pair.
fn apply(
    setup: &Setup,
    states: &[ContactBody],
    pair: &mut Pair,
    bodies: &mut [Body],
    outcome: &mut Outcome,
    impulse: &PairImpulse,
) {
    pair.sums.impulse += *impulse;
    if let Some(wall) = setup.wall(pair) {
        outcome.strike_wall(impulse, &wall.velocity);
    }
    for (k, given) in pair.each(impulse) {
        let Some(body) = bodies.get_mut(k) else { continue };
        let response = &states[k].response;
        body.velocity += response.mass.component_mul(&given.linear);
        body.spin += response.inertia.of(&given.angular);
        outcome.bodies[k].impulse += given;
    }
}

/// The force of a pair that touches over a substep of `h` (s), by which its springs go on.
fn press(
    layout: &Layout,
    place: usize,
    pair: &mut Pair,
    h: f64,
    meeting: &Meeting,
) -> Result<ContactForce> {
    let kinematics = layout.kinematics_at(pair, h, meeting);
    let limit = overlap::deepest_allowed(pair, layout.bodies);
    if kinematics.overlap > limit.overlap {
        return Err(overlap::too_deep(layout, pair, &kinematics, &limit));
    }
    let law = layout.law(pair);
    let (normal, tangential) = law.force(&kinematics, &mut pair.springs.tangential);
    let torque = rolling::resist_turning(layout, pair, &kinematics, meeting, normal);
    pair.sums.add_touch(h, normal, &tangential, law.material.friction);
    let arms = meeting.arms;
    let mut whole = arms.impulse(tangential - normal * kinematics.normal);
    whole.turns = [whole.turns[0] + torque, whole.turns[1] - torque];
    pair.sums.impulse += whole.times(h);
    Ok(ContactForce { pair: place, normal, whole, tangential, torque, kinematics, arms })
}

/// Meeting of a pair in a substep of `h` (s), which the pair keeps; `None` where the two do not
/// touch. Pairs too far apart to have touched since they were looked at last are passed over.
fn look(layout: &Layout, pair: &mut Pair, travels: &[Travel], h: f64) -> Option<Meeting> {
    let next = together(pair, travels, |way| way.next);
    if next < pair.seen.clear {
        return None;
    }
    let meeting = layout.closest(pair, h);
    let gone = together(pair, travels, |way| way.gone);
    pair.seen.normal = meeting.normal;
    if !pair.round {
        pair.seen.met = Some(Met { meeting, age: -0.5 * h, gone });
    }
    if meeting.touches(h) {
        return Some(meeting);
    }
    pair.springs.tangential = None;
    pair.springs.rolling = Vector3::zeros();
    pair.seen.clear = gone - meeting.overlap - 0.5 * (next - gone);
    None
}

/// Meeting of a pair at the end of a substep, for its fluid, which has not acted for `h` (s); the
/// pair keeps it. An earlier one is carried on until the two have gone too far since.
fn see(layout: &Layout, pair: &mut Pair, h: f64, substep: f64, gone: f64) -> Meeting {
    let still = |met: &Met| gone - met.gone <= SAME_PLACE * -met.meeting.overlap;
    let fresh = |met: &Met| met.age < substep;
    let known = pair.seen.met.filter(|met| met.age <= h && (fresh(met) || still(met)));
    let meeting = match known {
        Some(met) => layout.at_end(pair, &met),
        None => layout.closest(pair, 0.0),
    };
    if !pair.round {
        let found = known.map_or(gone, |met| met.gone);
        pair.seen.met = Some(Met { meeting, age: 0.0, gone: found });
    }
    pair.seen.normal = meeting.normal;
    meeting
}

impl ContactForce {
    /// Mean power of its tangential force and rolling torque over the substep (W), in which all
    /// loads change the velocities: what holds still does no work, whatever else presses on it.
    fn power(&self, layout: &Layout, pair: &Pair) -> f64 {
        let ContactForce { tangential, torque, kinematics, arms, .. } = self;
        let half = 0.5 * kinematics.h;
        // Mean change of a body's velocity and of its spin by its loads, and its mean spin.
        let mean = |k: usize| {
            let Some(body) = layout.bodies.get(k) else { return [Vector3::zeros(); 3] };
            let ContactBody { response, load, .. } = &layout.states[k];
            let turned = half * response.inertia.of(&load.angular);
            let spin = body.spin + half * response.accelerations.angular + turned;
            [half * response.mass.component_mul(&load.linear), turned, spin]
        };
        let [moved, turned, spin] = mean(pair.first);
        let [other, its, its_spin] = mean(pair.second);
        let turned = arms.turning([&turned, &its]);
        let slip =
            kinematics.slip + 0.5 * kinematics.h * kinematics.push_slip + (moved - other) + turned;
        tangential.dot(&slip) + torque.dot(&(spin - its_spin))
    }
}
