//! Clusters of bodies that touch each other: their response to the impulses of touch, and the bound
//! on the work of these, which bring no more energy than the springs let go.
//!
//! ```text
//!   u(a) = u_0 + a (u_1 - u_0)   linear in the impulses: u_0 without those of touch, u_1 with them
//!   W(a) = a J.(u_0 + u(a))/2 = a w + a^2 d/2           w = J.u_0,  d = J.(u_1 - u_0),
//!              u the velocities of pairs at their contacts
//!   W(a) <= S                   S: what the springs held at the start of the step, less at its end
//!   q = d/(J.M^-1 J)                    response to the impulses over the one that substeps expect
//! ```
//! a is the largest factor in [0, 1] that keeps the bound, or the one with the least work where
//! none does. Walls and prescribed bodies do work of their own: u is relative to them. u_0 needs a
//! solve of the pressure. A cluster parts, and needs it, where the substeps leave velocities u*
//! with `J.u* > S + J.M^-1 J/8`: otherwise W keeps the bound if the fluid lets pairs respond at
//! least a quarter as much as expected, `d >= J.M^-1 J/4`, as at rest.

use super::pair::Pair;
use super::{Contacts, Impulse};
use crate::particles::Body;
use nalgebra::Vector3;

/// The least response to impulses that is assumed without a solve, of the one that substeps expect.
const LEAST_RESPONSE: f64 = 0.25;
/// Reduction of the impulses that is not worth a solve.
const SAME: f64 = 1e-4;

/// Clusters of bodies that touch each other, one after the other; scratch of a step.
#[derive(Clone, Debug, Default)]
pub(super) struct Clusters {
    /// Per body, another one of its cluster; the first one has itself. Bodies that touch nothing
    /// are alone.
    parent: Vec<usize>,
    /// Per body, the impulses of touch.
    impulses: Vec<Impulse>,
    /// Per body, velocity and spin without those, where they are known (m/s, rad/s), and whether
    /// one of its contacts parts.
    without: Vec<Option<[Vector3<f64>; 2]>>,
    parting: Vec<bool>,
    /// Per first body of a cluster.
    works: Vec<Work>,
}

/// The work of the contacts of a cluster (J).
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    /// J.u_1, J.u_0 and J.M^-1 J.
    with: f64,
    without: f64,
    expected: f64,
    /// S.
    released: f64,
    /// Whether the cluster parts.
    parts: bool,
    /// q and a.
    response: f64,
    factor: f64,
    /// Scratch of a sum over pairs.
    sum: f64,
}

impl Clusters {
    /// Those of so many bodies.
    pub(super) fn new(n: usize) -> Clusters {
        let impulses = vec![Impulse::default(); n];
        let works = vec![Work::default(); n];
        let mut clusters = Clusters {
            parent: vec![0; n],
            impulses,
            without: vec![None; n],
            parting: vec![false; n],
            works,
        };
        clusters.clear();
        clusters
    }

    /// Forgets the step before.
    pub(super) fn clear(&mut self) {
        self.parent.iter_mut().enumerate().for_each(|(k, parent)| *parent = k);
        self.impulses.fill(Impulse::default());
        self.without.fill(None);
        self.parting.fill(false);
        self.works.fill(Work { response: 1.0, factor: 1.0, ..Work::default() });
    }

    /// Adds the impulses of a pair to its two bodies.
    fn add(&mut self, pair: &Pair) {
        for (k, impulse, turn) in
            [(pair.first, pair.impulse, pair.turns[0]), (pair.second, -pair.impulse, pair.turns[1])]
        {
            if let Some(given) = self.impulses.get_mut(k) {
                given.linear += impulse;
                given.angular += turn;
            }
        }
    }

    /// The first body of the cluster of a body.
    fn first(&self, mut body: usize) -> usize {
        while self.parent[body] != body {
            body = self.parent[body];
        }
        body
    }
}

impl Work {
    /// W(a).
    fn at(&self, a: f64) -> f64 {
        a * self.without + 0.5 * a * a * (self.with - self.without)
    }

    /// The largest a that keeps the bound.
    fn bounded(&self) -> f64 {
        let w = self.without;
        let d = self.with - self.without;
        if self.at(1.0) <= self.released || d <= 0.0 {
            return 1.0;
        }
        // Where the springs have taken up more than there was to take, the least work.
        let root = (w * w + 2.0 * d * self.released).max(0.0).sqrt();
        ((root - w) / d).clamp(0.0, 1.0)
    }
}

impl Contacts {
    /// Finds the clusters of bodies that touched in the step, which have the given velocities and
    /// spins at the end of the substeps; whether one of them parts.
    pub(crate) fn find_clusters(
        &mut self,
        bodies: &[Body],
        expected: impl Fn(usize) -> [Vector3<f64>; 2],
    ) -> bool {
        let mut clusters = std::mem::take(&mut self.clusters);
        let free = |k: usize| bodies.get(k).is_some_and(|body| body.freedom().is_some());
        for pair in self.pairs.iter().filter(|pair| pair.normal_impulse > 0.0) {
            clusters.add(pair);
            if free(pair.first) && free(pair.second) {
                let one = clusters.first(pair.first);
                let other = clusters.first(pair.second);
                clusters.parent[one.max(other)] = one.min(other);
            }
        }
        for pair in self.pairs.iter().filter(|pair| pair.normal_impulse > 0.0) {
            let (first, released) = (
                self.cluster_of(&clusters, pair, bodies),
                pair.stored - self.stored_in(pair, bodies),
            );
            let with = self.work_of(pair, &expected);
            let parts = with > 0.5 * LEAST_RESPONSE * self.expected_response(pair);
            for k in [pair.first, pair.second] {
                clusters.parting.get_mut(k).into_iter().for_each(|parting| *parting |= parts);
            }
            let work = &mut clusters.works[first];
            work.with += with;
            work.released += released;
        }
        for k in 0..bodies.len() {
            let (inverse_mass, Impulse { linear, angular }) =
                (&self.inverse_masses[k], &clusters.impulses[k]);
            let response = inverse_mass.mass.dot(&linear.component_mul(linear))
                + angular.dot(&inverse_mass.inertia.of(angular));
            let first = clusters.first(k);
            clusters.works[first].expected += response;
        }
        for work in &mut clusters.works {
            work.parts = work.with > work.released + 0.5 * LEAST_RESPONSE * work.expected;
        }
        let any = clusters.works.iter().any(|work| work.parts);
        self.clusters = clusters;
        self.keep_impulses(bodies, |work| work.parts);
        any
    }

    /// Finds the clusters that part though the substeps did not expect it, by the velocities with
    /// the corrected impulses, which the bodies now have; whether there are any.
    pub(crate) fn find_late_parting(&mut self, bodies: &[Body]) -> bool {
        self.find_works(bodies, |work, joule| work.with = joule);
        let late = |work: &Work| {
            !work.parts && work.with > work.released + 0.5 * LEAST_RESPONSE * work.expected
        };
        let any = self.clusters.works.iter().any(late);
        if any {
            self.keep_impulses(bodies, late);
            self.clusters.works.iter_mut().for_each(|work| work.parts |= late(work));
        }
        any
    }

    /// Leaves the impulses of touch on the bodies of some clusters alone.
    fn keep_impulses(&mut self, bodies: &[Body], wanted: impl Fn(&Work) -> bool) {
        let mut clusters = std::mem::take(&mut self.clusters);
        clusters.impulses.fill(Impulse::default());
        for pair in self.pairs.iter().filter(|pair| pair.normal_impulse > 0.0) {
            if !wanted(&clusters.works[self.cluster_of(&clusters, pair, bodies)]) {
                continue;
            }
            clusters.add(pair);
        }
        self.clusters = clusters;
    }

    /// The first body of the cluster of a pair.
    fn cluster_of(&self, clusters: &Clusters, pair: &Pair, bodies: &[Body]) -> usize {
        let free = bodies[pair.first].freedom().is_some();
        clusters.first(if free || pair.second >= bodies.len() { pair.first } else { pair.second })
    }

    /// The impulses of touch on a body whose cluster was found last to part.
    pub(crate) fn impulse_of_touch(&self, body: usize) -> Impulse {
        self.clusters.impulses[body]
    }

    /// Takes note of the velocities without the impulses of touch, which the bodies of the clusters
    /// that part now have.
    pub(crate) fn note_without(&mut self, bodies: &[Body]) {
        for (k, body) in bodies.iter().enumerate() {
            let parts = self.clusters.works[self.clusters.first(k)].parts;
            let known = &mut self.clusters.without[k];
            *known = known.or(parts.then_some([body.velocity, body.spin]));
        }
        self.find_works(bodies, |work, joule| work.without = joule);
    }

    /// Finds the response of the clusters that part, whose bodies now have the velocities with the
    /// impulses by the substeps.
    pub(crate) fn find_response(&mut self, bodies: &[Body]) {
        self.find_works(bodies, |work, joule| work.with = joule);
        for work in self.clusters.works.iter_mut().filter(|work| work.parts) {
            let response = (work.with - work.without) / work.expected;
            work.response = if response.is_finite() && response > 0.0 { response } else { 1.0 };
        }
    }

    /// q of a body's cluster.
    pub(super) fn response_of(&self, body: usize) -> f64 {
        self.clusters.works[self.clusters.first(body)].response
    }

    /// Bounds the work of the clusters that part, whose bodies now have the velocities with all
    /// impulses, corrected. Returns how much energy that takes (J): none where all keep the bound.
    pub(crate) fn bound_work(&mut self, bodies: &[Body]) -> f64 {
        let mut taken = 0.0;
        self.find_works(bodies, |work, joule| work.with = joule);
        let without = std::mem::take(&mut self.clusters.without);
        self.find_works_of(
            bodies,
            |k| without[k].unwrap_or_default(),
            |work, joule| work.without = joule,
        );
        self.clusters.without = without;
        for work in self.clusters.works.iter_mut().filter(|work| work.parts) {
            let factor = work.bounded();
            if factor < 1.0 - SAME {
                taken += work.at(1.0) - work.at(factor);
                work.factor = factor;
            }
        }
        taken
    }

    /// Gives all clusters the work of their impulses of touch at the velocities that the bodies
    /// have (J).
    fn find_works(&mut self, bodies: &[Body], take: impl Fn(&mut Work, f64)) {
        self.find_works_of(bodies, |k| [bodies[k].velocity, bodies[k].spin], take);
    }

    /// The same at given velocities and spins of the free bodies.
    fn find_works_of(
        &mut self,
        bodies: &[Body],
        motion: impl Fn(usize) -> [Vector3<f64>; 2],
        take: impl Fn(&mut Work, f64),
    ) {
        let mut clusters = std::mem::take(&mut self.clusters);
        clusters.works.iter_mut().for_each(|work| work.sum = 0.0);
        let of = |k: usize| match bodies[k].freedom() {
            Some(_) => motion(k),
            None => [bodies[k].velocity, bodies[k].spin],
        };
        for pair in self.pairs.iter().filter(|pair| pair.normal_impulse > 0.0) {
            let first = self.cluster_of(&clusters, pair, bodies);
            clusters.works[first].sum += self.work_of(pair, &of);
        }
        clusters.works.iter_mut().for_each(|work| take(work, work.sum));
        self.clusters = clusters;
    }

    /// Work of all contacts on a body over the last step (J), which now has the velocity at its
    /// end, had the velocity `start` (m/s) at its start and was moved by `way` (m) in the step of
    /// `dt` (s): known where the bound on the work of its cluster was looked at.
    ///
    /// ```text
    ///   J.(v_0 + v_1)/2 - a.sum J_i (dt - t_i)        v_0: without J, a = (v_0 - v)/dt
    ///              sum J_i (dt - t_i) = M (way - dt (v + v_0)/2)
    /// ```
    /// v_0 is that of the step's end; a contact at the time `t_i` meets a body that the other
    /// forces have not brought so far.
    pub fn work_on(
        &self,
        k: usize,
        body: &Body,
        start: &Vector3<f64>,
        way: &Vector3<f64>,
        dt: f64,
    ) -> Option<f64> {
        let ([velocity, spin], Impulse { linear, angular }) =
            (self.clusters.without[k]?, self.impulses[k]);
        let bent = way / dt - 0.5 * (start + velocity);
        let early = self.mass_in_contact(body) * bent.dot(&(velocity - start));
        let turned = angular.dot(&(spin + body.spin));
        Some(0.5 * (linear.dot(&(velocity + body.velocity)) + turned) - early)
    }

    /// Takes back what the bound leaves of the impulses, and what that is for each body, in
    /// `corrections`.
    pub(crate) fn reduce(&mut self, bodies: &[Body], corrections: &mut [Impulse]) {
        let clusters = std::mem::take(&mut self.clusters);
        corrections.fill(Impulse::default());
        for p in 0..self.pairs.len() {
            let factor = clusters.works[self.cluster_of(&clusters, &self.pairs[p], bodies)].factor;
            if self.pairs[p].normal_impulse <= 0.0 || factor == 1.0 {
                continue;
            }
            let pair = &mut self.pairs[p];
            let (impulse, turns) =
                ((factor - 1.0) * pair.impulse, pair.turns.map(|turn| (factor - 1.0) * turn));
            for (k, impulse, turn) in
                [(pair.first, impulse, turns[0]), (pair.second, -impulse, turns[1])]
            {
                if let Some(given) = corrections.get_mut(k) {
                    given.linear += impulse;
                    given.angular += turn;
                }
            }
            pair.add(impulse, turns);
            pair.normal *= factor;
            pair.normal_impulse *= factor;
            pair.tangential *= factor;
            if let Some(wall) = pair.second.checked_sub(bodies.len()) {
                self.wall_impulse -= impulse;
                self.wall_work += impulse.dot(&self.walls[wall].velocity);
            }
        }
        self.add_corrections(corrections);
        self.clusters = clusters;
    }

    /// `P.M^-1 P` of the linear impulse of a pair (J), as the substeps expect the response.
    fn expected_response(&self, pair: &Pair) -> f64 {
        let inverse = |k: usize| {
            self.inverse_masses.get(k).map_or_else(Vector3::zeros, |inverse_mass| inverse_mass.mass)
        };
        (inverse(pair.first) + inverse(pair.second)).dot(&pair.impulse.component_mul(&pair.impulse))
    }

    /// Velocity of a body (m/s) without the impulses of touch of the last step, where one of its
    /// contacts parts and it is known.
    pub(crate) fn velocity_without(&self, k: usize) -> Option<Vector3<f64>> {
        self.clusters.without[k].filter(|_| self.clusters.parting[k]).map(|[velocity, _]| velocity)
    }

    /// Work of a pair's impulses at given velocities and spins (J).
    fn work_of(&self, pair: &Pair, motion: &impl Fn(usize) -> [Vector3<f64>; 2]) -> f64 {
        let [velocity, spin] = motion(pair.first);
        let [other, its] = match pair.second.checked_sub(self.inverse_masses.len()) {
            None => motion(pair.second),
            Some(wall) => [self.walls[wall].sliding(), Vector3::zeros()],
        };
        pair.impulse.dot(&(velocity - other)) + pair.turns[0].dot(&spin) + pair.turns[1].dot(&its)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that a contact throws back faster than it came: the bound leaves it the speed at
    /// which its energy is what it was.
    #[test]
    fn contact_energy_bound_removes_excess_rebound_only() {
        let of = |rebound: f64, released: f64| Work {
            with: (1.0 + rebound) * rebound,
            without: -(1.0 + rebound),
            released,
            ..Work::default()
        };
        for rebound in [0.0, 0.5, 1.0] {
            assert_eq!(of(rebound, 0.0).bounded(), 1.0, "{rebound}");
        }
        // Mass and speed are one: J = 1 + e, W = (e^2 - 1)/2.
        let work = of(1.2, 0.0);
        let a = work.bounded();
        assert!((a * 2.2 - 2.0).abs() < 1e-12 && work.at(a).abs() < 1e-12, "{a}");
        let work = of(1.2, 0.1);
        assert!((work.at(work.bounded()) - 0.1).abs() < 1e-12);
        // Springs that took up more than the body had: it stops.
        let work = of(0.5, -1.0);
        assert!((work.bounded() * 1.5 - 1.0).abs() < 1e-12);
    }
}
