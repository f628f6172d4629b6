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

use super::Impulse;
use super::pair::Pair;
use crate::particles::{Body, RigidVelocity};

/// The least response to impulses that is assumed without a solve, of the one that substeps expect.
const LEAST_RESPONSE: f64 = 0.25;
/// Reduction of the impulses that is not worth a solve.
const SAME: f64 = 1e-4;

/// Clusters of bodies that touch each other in a step.
#[derive(Clone, Debug)]
pub(super) struct Clusters {
    pub(super) bodies: Vec<ClusterBody>,
    /// Per first body of a cluster.
    pub(super) works: Vec<ContactWork>,
}

/// A body of a cluster.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClusterBody {
    /// Another body of its cluster; the first one has itself. Bodies that touch nothing are alone.
    parent: usize,
    /// The impulses of touch on it.
    pub(super) touch: Impulse,
    /// Its velocity without those, where it is known.
    pub(super) without: Option<RigidVelocity>,
    /// Whether one of its contacts parts.
    pub(super) parts: bool,
}

/// The work of the contacts of a cluster (J).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ContactWork {
    /// J.u_1, J.u_0 and J.M^-1 J.
    pub(super) with: f64,
    pub(super) without: f64,
    pub(super) expected: f64,
    /// S.
    pub(super) released: f64,
    /// Whether the cluster parts.
    pub(super) parts: bool,
    /// q and a.
    pub(super) response: f64,
    pub(super) factor: f64,
    /// Scratch of a sum over pairs.
    pub(super) sum: f64,
}

impl Clusters {
    /// Clusters of `n` bodies, each of which is alone.
    pub(super) fn new(n: usize) -> Clusters {
        let bodies = vec![ClusterBody::default(); n];
        let mut clusters = Clusters { bodies, works: vec![ContactWork::default(); n] };
        clusters.clear();
        clusters
    }

    /// Forgets the step before.
    pub(super) fn clear(&mut self) {
        for (parent, body) in self.bodies.iter_mut().enumerate() {
            *body = ClusterBody { parent, ..ClusterBody::default() };
        }
        self.works.fill(ContactWork { response: 1.0, factor: 1.0, ..ContactWork::default() });
    }

    /// Makes one cluster of the two of a pair where both are free, and adds its impulses of touch.
    pub(super) fn join(&mut self, pair: &Pair, bodies: &[Body]) {
        self.add(pair);
        let free = |k: usize| bodies.get(k).is_some_and(|body| body.freedom().is_some());
        if free(pair.first) && free(pair.second) {
            let one = self.first(pair.first);
            let other = self.first(pair.second);
            self.bodies[one.max(other)].parent = one.min(other);
        }
    }

    /// Adds the impulses of a pair to its two bodies.
    fn add(&mut self, pair: &Pair) {
        for (k, given) in pair.each(&pair.sums.impulse) {
            self.bodies.get_mut(k).into_iter().for_each(|body| body.touch += given);
        }
    }

    /// Leaves the impulses of touch on the bodies of some clusters alone.
    pub(super) fn keep_impulses(
        &mut self,
        pairs: &[Pair],
        bodies: &[Body],
        wanted: impl Fn(&ContactWork) -> bool,
    ) {
        self.bodies.iter_mut().for_each(|body| body.touch = Impulse::default());
        for pair in pairs.iter().filter(|pair| pair.touched()) {
            if wanted(&self.works[self.of_pair(pair, bodies)]) {
                self.add(pair);
            }
        }
    }

    /// The first body of the cluster of a body.
    fn first(&self, mut body: usize) -> usize {
        while self.bodies[body].parent != body {
            body = self.bodies[body].parent;
        }
        body
    }

    /// The work of the cluster of a body.
    pub(super) fn of(&self, body: usize) -> &ContactWork {
        &self.works[self.first(body)]
    }

    /// The work of the cluster of a body, to be changed.
    pub(super) fn of_mut(&mut self, body: usize) -> &mut ContactWork {
        let first = self.first(body);
        &mut self.works[first]
    }

    /// The first body of the cluster of a pair.
    pub(super) fn of_pair(&self, pair: &Pair, bodies: &[Body]) -> usize {
        let free = bodies[pair.first].freedom().is_some();
        self.first(if free || pair.second >= bodies.len() { pair.first } else { pair.second })
    }
}

impl ContactWork {
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
        // No a keeps the bound where the springs have taken up too much: a of the least work.
        let root = (w * w + 2.0 * d * self.released).max(0.0).sqrt();
        ((root - w) / d).clamp(0.0, 1.0)
    }

    /// Whether the impulses with these velocities may bring more energy than the springs let go, by
    /// the least response that is assumed.
    pub(super) fn may_exceed(&self) -> bool {
        self.with > self.released + 0.5 * LEAST_RESPONSE * self.expected
    }

    /// Takes q from the velocities with and without the impulses of the substeps.
    pub(super) fn find_response(&mut self) {
        let response = (self.with - self.without) / self.expected;
        self.response = if response.is_finite() && response > 0.0 { response } else { 1.0 };
    }

    /// Takes the largest a that keeps the bound; returns the energy that this removes (J).
    pub(super) fn bound(&mut self) -> f64 {
        let factor = self.bounded();
        if factor >= 1.0 - SAME {
            return 0.0;
        }
        self.factor = factor;
        self.at(1.0) - self.at(factor)
    }
}

/// Whether a pair may part: its work exceeds half of the least response to its linear impulse,
/// which is `expected` by the substeps (J).
pub(super) fn parts(work: f64, expected: f64) -> bool {
    work > 0.5 * LEAST_RESPONSE * expected
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that a contact throws back faster than it came: the bound leaves it the speed at
    /// which its energy is what it was.
    #[test]
    fn contact_energy_bound_removes_excess_rebound_only() {
        let of = |rebound: f64, released: f64| ContactWork {
            with: (1.0 + rebound) * rebound,
            without: -(1.0 + rebound),
            released,
            ..ContactWork::default()
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
