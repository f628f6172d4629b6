//! The bound on the work of contacts: the impulses of a cluster of bodies that touch each other bring no more energy than its springs
//! have let go.
//!
//! ```text
//!   u(a) = u_0 + a (u_1 - u_0)                          linear in the impulses: u_0 without those of touch, u_1 with them
//!   W(a) = a J.(u_0 + u(a))/2 = a w + a^2 d/2           w = J.u_0,  d = J.(u_1 - u_0),  u the velocities of pairs at their contacts
//!   W(a) <= S                                           S: what the springs held at the start of the step, less at its end
//! ```
//! a is the largest factor in [0, 1] that keeps this bound, or the one with the least work where none does. Walls and prescribed
//! bodies do work of their own: u is relative to them. W(1) needs u_0, and so a solve of the pressure. Where
//! `J.u_1 <= S + J.M^-1 J/8` it keeps the bound if the pairs respond to impulses at least a quarter as much as the substeps expect,
//! `d >= J.M^-1 J/4`: contacts at rest, and those that hardly part, need no u_0.

use super::{Contacts, Impulse, Pair};
use crate::particles::Body;
use nalgebra::Vector3;

/// The least response to impulses that is assumed without a solve, of the one that substeps expect.
const LEAST_RESPONSE: f64 = 0.25;
/// Reduction of the impulses that is not worth a solve.
const SAME: f64 = 1e-4;

/// Clusters of bodies that touch each other, one after the other; scratch of a step.
#[derive(Clone, Debug, Default)]
pub(super) struct Clusters {
    /// Per body, another one of its cluster; the first one has itself. Bodies that touch nothing are alone.
    parent: Vec<usize>,
    /// Per body, the impulses of touch.
    impulses: Vec<Impulse>,
    /// Per body, velocity and spin without those, where they are known (m/s, rad/s).
    without: Vec<Option<[Vector3<f64>; 2]>>,
    /// Per first body of a cluster.
    works: Vec<Work>,
}

/// The work of the contacts of a cluster (J).
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    /// J.u_1 and J.u_0.
    with: f64,
    without: f64,
    /// S.
    released: f64,
    /// Whether u_0 is wanted.
    wanted: bool,
    /// a.
    factor: f64,
}

impl Clusters {
    /// Those of so many bodies.
    pub(super) fn new(n: usize) -> Clusters {
        Clusters {
            parent: vec![0; n],
            impulses: vec![Impulse::default(); n],
            without: vec![None; n],
            works: vec![Work::default(); n],
        }
    }

    /// Forgets the step before.
    pub(super) fn clear(&mut self) {
        self.without.fill(None);
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
        let (w, d) = (self.without, self.with - self.without);
        if self.at(1.0) <= self.released || d <= 0.0 {
            return 1.0;
        }
        // Where the springs have taken up more than there was to take, the least work.
        let root = (w * w + 2.0 * d * self.released).max(0.0).sqrt();
        ((root - w) / d).clamp(0.0, 1.0)
    }
}

impl Contacts {
    /// Finds the clusters of bodies that touched in the step, which now have the velocities with all impulses; whether the bound on
    /// the work of one of them has to be looked at.
    pub(crate) fn find_clusters(&mut self, bodies: &[Body]) -> bool {
        let mut clusters = std::mem::take(&mut self.clusters);
        clusters.parent.iter_mut().enumerate().for_each(|(k, parent)| *parent = k);
        clusters.impulses.fill(Impulse::default());
        clusters.works.fill(Work { factor: 1.0, ..Work::default() });
        let free = |k: usize| bodies.get(k).is_some_and(|body| body.freedom().is_some());
        for pair in self.pairs.iter().filter(|pair| pair.pressed > 0.0) {
            for (k, impulse, turn) in
                [(pair.first, pair.impulse, pair.turns[0]), (pair.second, -pair.impulse, pair.turns[1])]
            {
                if let Some(given) = clusters.impulses.get_mut(k) {
                    given.linear += impulse;
                    given.angular += turn;
                }
            }
            if free(pair.first) && free(pair.second) {
                let (one, other) = (clusters.first(pair.first), clusters.first(pair.second));
                clusters.parent[one.max(other)] = one.min(other);
            }
        }
        for pair in self.pairs.iter().filter(|pair| pair.pressed > 0.0) {
            let (first, released) = (self.cluster_of(&clusters, pair, bodies), pair.stored - self.stored_in(pair, bodies));
            let work = &mut clusters.works[first];
            work.with += self.work_of(pair, bodies);
            work.released += released;
        }
        for k in 0..bodies.len() {
            let (answer, Impulse { linear, angular }) = (&self.answers[k], &clusters.impulses[k]);
            let response = answer.mass.dot(&linear.component_mul(linear)) + answer.inertia.dot(&angular.component_mul(angular));
            let first = clusters.first(k);
            clusters.works[first].without += response;
        }
        let mut any = false;
        for work in &mut clusters.works {
            work.wanted = work.with > work.released + 0.5 * LEAST_RESPONSE * work.without;
            any |= work.wanted;
        }
        self.clusters = clusters;
        any
    }

    /// The first body of the cluster of a pair.
    fn cluster_of(&self, clusters: &Clusters, pair: &Pair, bodies: &[Body]) -> usize {
        let free = bodies[pair.first].freedom().is_some();
        clusters.first(if free || pair.second >= bodies.len() { pair.first } else { pair.second })
    }

    /// The impulses of touch on a body over the step, if its cluster's work has to be looked at.
    pub(crate) fn impulse_of_touch(&self, body: usize) -> Impulse {
        let clusters = &self.clusters;
        if clusters.works[clusters.first(body)].wanted { clusters.impulses[body] } else { Impulse::default() }
    }

    /// Bounds the work of the clusters, whose bodies now have the velocities without the impulses of touch. Returns how much energy
    /// that takes (J): none where all keep the bound.
    pub(crate) fn bound_work(&mut self, bodies: &[Body]) -> f64 {
        let mut clusters = std::mem::take(&mut self.clusters);
        clusters.works.iter_mut().for_each(|work| work.without = 0.0);
        for pair in self.pairs.iter().filter(|pair| pair.pressed > 0.0) {
            let first = self.cluster_of(&clusters, pair, bodies);
            clusters.works[first].without += self.work_of(pair, bodies);
        }
        for (k, body) in bodies.iter().enumerate() {
            let wanted = clusters.works[clusters.first(k)].wanted;
            clusters.without[k] = wanted.then_some([body.velocity, body.spin]);
        }
        let mut taken = 0.0;
        for work in clusters.works.iter_mut().filter(|work| work.wanted) {
            let factor = work.bounded();
            if factor < 1.0 - SAME {
                taken += work.at(1.0) - work.at(factor);
                work.factor = factor;
            }
        }
        self.clusters = clusters;
        taken
    }

    /// Work of all contacts on a body over the last step (J), which now has the velocity at its end: known where the bound on the work
    /// of its cluster was looked at.
    pub fn work_on(&self, k: usize, body: &Body) -> Option<f64> {
        let ([velocity, spin], Impulse { linear, angular }) = (self.clusters.without[k]?, self.impulses[k]);
        Some(0.5 * (linear.dot(&(velocity + body.velocity)) + angular.dot(&(spin + body.spin))))
    }

    /// Takes back what the bound leaves of the impulses, and what that is for each body, in `corrections`.
    pub(crate) fn reduce(&mut self, bodies: &[Body], corrections: &mut [Impulse]) {
        let clusters = std::mem::take(&mut self.clusters);
        for (k, (correction, given)) in corrections.iter_mut().zip(&clusters.impulses).enumerate() {
            let part = clusters.works[clusters.first(k)].factor - 1.0;
            *correction = Impulse { linear: part * given.linear, angular: part * given.angular };
            self.impulses[k].linear += correction.linear;
            self.impulses[k].angular += correction.angular;
        }
        for p in 0..self.pairs.len() {
            if self.pairs[p].pressed <= 0.0 {
                continue;
            }
            let factor = clusters.works[self.cluster_of(&clusters, &self.pairs[p], bodies)].factor;
            let pair = &mut self.pairs[p];
            if let Some(wall) = pair.second.checked_sub(bodies.len()) {
                let impulse = (factor - 1.0) * pair.impulse;
                self.wall_impulse -= impulse;
                self.wall_work += impulse.dot(&self.walls[wall].velocity);
            }
            pair.impulse *= factor;
            pair.turns.iter_mut().for_each(|turn| *turn *= factor);
            pair.normal *= factor;
            pair.pressed *= factor;
            pair.tangential *= factor;
        }
        self.clusters = clusters;
    }

    /// Work of a pair's impulses at the velocities that its two have now (J).
    fn work_of(&self, pair: &Pair, bodies: &[Body]) -> f64 {
        let body = &bodies[pair.first];
        let (other, spin) = match bodies.get(pair.second) {
            Some(other) => (other.velocity, other.spin),
            None => (self.walls[pair.second - bodies.len()].sliding(), Vector3::zeros()),
        };
        pair.impulse.dot(&(body.velocity - other)) + pair.turns[0].dot(&body.spin) + pair.turns[1].dot(&spin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that a contact throws back faster than it came: the bound leaves it the speed at which its energy is what it was.
    #[test]
    fn bound_takes_the_excess_of_a_rebound_and_nothing_else() {
        let of = |rebound: f64, released: f64| Work { with: (1.0 + rebound) * rebound, without: -(1.0 + rebound), released, ..Work::default() };
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
