//! The impulses of a step while the fluid responds to them: their correction
//! ([`super::correction`]), and the bound on the work of clusters that part ([`super::cluster`]).

use super::Impulse;
use super::arms::PairImpulse;
use super::body::ContactBody;
use super::cluster::{ClusterBody, Clusters, ContactWork, parts};
use super::correction::Constraint;
use super::meeting::Layout;
use super::outcome::Outcome;
use super::pair::Pair;
use super::pairs::Pairs;
use super::setup::Setup;
use crate::particles::{Body, RigidVelocity};
use nalgebra::Vector3;

/// Most sweeps over the pairs.
const MOST_SWEEPS: usize = 200;
/// The sweeps end where one changes less than this part of what the first one did.
const TOLERANCE: f64 = 1e-2;

/// The impulses of the contacts of a step while the fluid responds to them.
pub(crate) struct Impulses<'a> {
    pub(super) setup: &'a Setup,
    pub(super) pairs: &'a mut Pairs,
    pub(super) states: &'a mut [ContactBody],
    pub(super) clusters: &'a mut Clusters,
    /// Scratch of the correction.
    pub(super) constraints: &'a mut Vec<Constraint>,
    pub(super) outcome: &'a mut Outcome,
}

impl Impulses<'_> {
    /// Finds the clusters of bodies that touched in the step, which have the given velocities and
    /// spins at the end of the substeps; whether one of them parts.
    pub(crate) fn find_clusters(
        &mut self,
        bodies: &[Body],
        expected: impl Fn(usize) -> RigidVelocity,
    ) -> bool {
        let Impulses { setup, pairs, states, clusters, .. } = self;
        let touching = || pairs.list.iter().filter(|pair| pair.touched());
        touching().for_each(|pair| clusters.join(pair, bodies));
        let layout = Layout { setup, regions: &pairs.regions, states, bodies };
        for pair in touching() {
            let first = clusters.of_pair(pair, bodies);
            let released = pair.springs.stored - layout.stored(pair);
            let with = work_of(setup, pair, &expected);
            let parts = parts(with, expected_response(&layout, pair));
            for k in [pair.first, pair.second] {
                clusters.bodies.get_mut(k).into_iter().for_each(|body| body.parts |= parts);
            }
            let work = &mut clusters.works[first];
            work.with += with;
            work.released += released;
        }
        for (k, state) in states.iter().enumerate() {
            let response = state.response.energy(&clusters.bodies[k].touch);
            clusters.of_mut(k).expected += response;
        }
        clusters.works.iter_mut().for_each(|work| work.parts = work.may_exceed());
        clusters.keep_impulses(&pairs.list, bodies, |work| work.parts);
        clusters.works.iter().any(|work| work.parts)
    }

    /// Finds the clusters that part though the substeps did not expect it, by the velocities with
    /// the corrected impulses, which the bodies now have; whether there are any.
    pub(crate) fn find_late_parting(&mut self, bodies: &[Body]) -> bool {
        self.find_works(bodies, |body, _| moving(body), |work, joule| work.with = joule);
        let late = |work: &ContactWork| !work.parts && work.may_exceed();
        let any = self.clusters.works.iter().any(late);
        if any {
            self.clusters.keep_impulses(&self.pairs.list, bodies, late);
            self.clusters.works.iter_mut().for_each(|work| work.parts |= late(work));
        }
        any
    }

    /// The impulse of touch on a body whose cluster was found last to part.
    pub(crate) fn impulse_of_touch(&self, body: usize) -> Impulse {
        self.clusters.bodies[body].touch
    }

    /// Takes note of the velocities without the impulses of touch, which the bodies of the clusters
    /// that part now have.
    pub(crate) fn note_without(&mut self, bodies: &[Body]) {
        for (k, body) in bodies.iter().enumerate() {
            let parts = self.clusters.of(k).parts;
            let known = &mut self.clusters.bodies[k].without;
            *known = known.or(parts.then_some(moving(body)));
        }
        self.find_works(bodies, |body, _| moving(body), |work, joule| work.without = joule);
    }

    /// Finds the response of the clusters that part, whose bodies now have the velocities with the
    /// impulses by the substeps.
    pub(crate) fn find_response(&mut self, bodies: &[Body]) {
        self.find_works(bodies, |body, _| moving(body), |work, joule| work.with = joule);
        self.clusters
            .works
            .iter_mut()
            .filter(|work| work.parts)
            .for_each(ContactWork::find_response);
    }

    /// Corrects the impulses of the step of `dt` (s) by the residuals of all bodies, of velocity
    /// and spin (m/s, rad/s), and leaves the correction impulses of the bodies in `corrections`.
    pub(crate) fn correct(
        &mut self,
        bodies: &[Body],
        residuals: &[RigidVelocity],
        corrections: &mut [Impulse],
        dt: f64,
    ) {
        self.scale_responses(|response| response);
        let Impulses { setup, pairs, states, constraints, outcome, .. } = self;
        let Pairs { list, colours, regions, .. } = &mut **pairs;
        let layout = Layout { setup, regions, states, bodies };
        let gave = colours.order().iter().filter(|p| list[**p].sums.normal != 0.0);
        constraints.clear();
        constraints.extend(gave.map(|&p| Constraint::new(&layout, p, &list[p], dt)));
        corrections.fill(Impulse::default());
        let mut first = 0.0;
        for sweep in 0..MOST_SWEEPS {
            let mut changed = 0.0f64;
            let mut solve = |constraint: &mut Constraint| {
                let pair = &list[constraint.pair];
                changed = changed.max(constraint.solve(pair, states, residuals, corrections));
            };
            // There and back, so that neither end of a pile comes first.
            if sweep % 2 == 0 {
                constraints.iter_mut().for_each(&mut solve);
            } else {
                constraints.iter_mut().rev().for_each(&mut solve);
            }
            if sweep == 0 {
                first = changed;
            }
            if changed <= TOLERANCE * first {
                break;
            }
        }
        for constraint in constraints.iter() {
            let pair = &mut list[constraint.pair];
            let impulse = constraint.add_to(pair);
            if let Some(wall) = setup.wall(pair) {
                outcome.strike_wall(&impulse, &wall.velocity);
            }
        }
        outcome.add(corrections);
        self.scale_responses(|response| 1.0 / response);
    }

    /// Multiplies the inverse masses of bodies by a function of the response of their clusters.
    fn scale_responses(&mut self, factor: impl Fn(f64) -> f64) {
        for (k, state) in self.states.iter_mut().enumerate() {
            state.response.scale(factor(self.clusters.of(k).response));
        }
    }

    /// Bounds the work of the clusters that part, whose bodies now have the velocities with all
    /// impulses, corrected. Returns how much energy that takes (J): none where all keep the bound.
    pub(crate) fn bound_work(&mut self, bodies: &[Body]) -> f64 {
        self.find_works(bodies, |body, _| moving(body), |work, joule| work.with = joule);
        let without = |_: &Body, body: &ClusterBody| body.without.unwrap_or_default();
        self.find_works(bodies, without, |work, joule| work.without = joule);
        let parting = self.clusters.works.iter_mut().filter(|work| work.parts);
        parting.fold(0.0, |taken, work| taken + work.bound())
    }

    /// Reduces the impulses by the factors of the bound, and leaves in `corrections` what that is
    /// for each body.
    pub(crate) fn reduce(&mut self, bodies: &[Body], corrections: &mut [Impulse]) {
        let Impulses { setup, pairs, clusters, outcome, .. } = self;
        corrections.fill(Impulse::default());
        for pair in pairs.list.iter_mut().filter(|pair| pair.touched()) {
            let factor = clusters.works[clusters.of_pair(pair, bodies)].factor;
            if factor == 1.0 {
                continue;
            }
            let change = pair.sums.impulse.times(factor - 1.0);
            for (k, given) in pair.each(&change) {
                corrections.get_mut(k).into_iter().for_each(|sum| *sum += given);
            }
            pair.sums.reduce(factor, change);
            if let Some(wall) = setup.wall(pair) {
                outcome.strike_wall(&change, &wall.velocity);
            }
        }
        outcome.add(corrections);
    }

    /// Gives all clusters the work of their impulses of touch at these velocities and spins of the
    /// free bodies (J).
    fn find_works(
        &mut self,
        bodies: &[Body],
        motion: impl Fn(&Body, &ClusterBody) -> RigidVelocity,
        take: impl Fn(&mut ContactWork, f64),
    ) {
        let Impulses { setup, pairs, clusters, .. } = self;
        clusters.works.iter_mut().for_each(|work| work.sum = 0.0);
        for pair in pairs.list.iter().filter(|pair| pair.touched()) {
            let first = clusters.of_pair(pair, bodies);
            let work = work_of(setup, pair, &|k| match bodies[k].freedom() {
                Some(_) => motion(&bodies[k], &clusters.bodies[k]),
                None => moving(&bodies[k]),
            });
            clusters.works[first].sum += work;
        }
        clusters.works.iter_mut().for_each(|work| take(work, work.sum));
    }

    /// Change of a body's spin (rad/s) by an angular impulse (N m s) of contacts, with what turns
    /// with it.
    pub(crate) fn turned_by(&self, body: usize, turn: &Vector3<f64>) -> Vector3<f64> {
        self.states[body].response.inertia.of(turn)
    }
}

/// The velocity that a body has.
fn moving(body: &Body) -> RigidVelocity {
    RigidVelocity { velocity: body.velocity, spin: body.spin }
}

/// Work of a pair's impulses at given velocities and spins (J).
fn work_of(setup: &Setup, pair: &Pair, motion: &impl Fn(usize) -> RigidVelocity) -> f64 {
    let own = motion(pair.first);
    let its = match setup.wall(pair) {
        None => motion(pair.second),
        Some(wall) => RigidVelocity { velocity: wall.sliding(), spin: Vector3::zeros() },
    };
    let PairImpulse { linear, turns: [turn, its_turn] } = &pair.sums.impulse;
    linear.dot(&(own.velocity - its.velocity)) + turn.dot(&own.spin) + its_turn.dot(&its.spin)
}

/// `P.M^-1 P` of the linear impulse of a pair (J), as the substeps expect the response.
fn expected_response(layout: &Layout, pair: &Pair) -> f64 {
    let (response, its_response) = layout.responses(pair);
    let inverse = response.mass + its_response.map_or_else(Vector3::zeros, |its| its.mass);
    let impulse = &pair.sums.impulse.linear;
    inverse.dot(&impulse.component_mul(impulse))
}
