//! Contacts: bodies as soft discs and spheres that overlap a little (discrete element model, eq.
//! 20-26).
//!
//! ```text
//!   search    pairs whose gap <= reach_i + reach_j,
//!              search_radius = |v| T + |a| T^2/2 over the rest T of the step
//!   substeps  n >= 40 T / (shortest contact time of a pair, undamped),  h = T/n
//!   middle    d, n, arms at x + h v/2                           F: mean over the substep ([`law`])
//!   kick      v' = v + h (a + F/m),  w' = w + h (b + M/I)
//!              a, b: accelerations by fluid and gravity, frozen
//!   drift     x' = x + h (v + v')/2
//! ```
//! That is Verlet's scheme with the force at the middle: one evaluation per substep, and exact
//! where a is constant. A body that goes beyond its search_radius (struck, say) has the pairs found
//! anew for the rest of the step. Bodies without a pair take one move for all the substeps; pairs
//! too far apart to have touched since they were looked at last are passed over, and the fluid
//! between pairs that cannot touch in the step acts once in several substeps, for all of them.
//!
//! In a fluid, m is the mass of a body and a part of its added mass, `m + c C_a` with
//! `c = min(1.6, 0.4 + s/4)`: C_a is the added mass of a lone body and s its density over the
//! fluid's. The fluid responds with its own inertia; `impulses.rs` compares the two once in a
//! step, and bounds the work of the contacts.
//!
//! ```text
//!      first          second        arms r: from the centres to the middle of the overlap
//!     (   o----n--->()<-----o   )   slip = (v_i - v_j + w_i x r_i - w_j x r_j)_t
//! ```
//!
//! [`Contacts::advance`] searches for pairs (`pairs.rs`), moves the bodies on in substeps
//! (`integrator.rs`), and returns what contacts did, an [`Outcome`]. While the pressure is found,
//! the impulses of the step are corrected (`impulses.rs`).
//!
//! A body that is not round has convex parts ([`mics_shapes::Part`]), each a contact of its own
//! with every part near it, and with the walls ([`mics_shapes::touch`]); its orientation and its
//! tensor of inertia turn in every substep.

mod arms;
mod body;
mod cluster;
mod correction;
mod count;
mod gaps;
mod impulses;
mod integrator;
mod law;
mod lubrication;
mod meeting;
mod obstacle;
mod outcome;
mod overlap;
mod pair;
mod pairs;
mod response;
mod rolling;
mod setup;
mod stiffness;
#[cfg(test)]
mod tests;
mod wall;

use crate::Result;
use crate::archive::{Archive, Checkpointed};
pub use crate::particles::Impulse;
use crate::particles::{Accelerations, Body, Inertia, RigidVelocity};
use body::ContactBody;
use cluster::Clusters;
use correction::Constraint;
pub(crate) use impulses::Impulses;
use integrator::{ContactForce, Integrator};
pub use law::{Damping, Laws, Material};
pub use lubrication::Medium;
use meeting::Layout;
use nalgebra::Vector3;
pub use outcome::{BodyOutcome, Outcome};
use pairs::Pairs;
pub use setup::Setup;
pub use stiffness::Impact;
pub use wall::{Wall, WallSide};

/// Overlap, of the smaller radius, that ends a run: soft contacts are no model of bodies beyond it.
pub const DEEPEST_OVERLAP: f64 = 0.2;

/// Number of substeps of a step in which bodies could meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Substeps {
    /// Enough for the shortest contact.
    Auto,
    /// A fixed number.
    Fixed(usize),
}

/// The springs of a contact between a body and an image of another one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Springs {
    /// Which image: whole periods from the centre of the second body to that of the image, along
    /// each axis.
    pub image: Vector3<f64>,
    /// Which parts of both bodies; 0 of round bodies and of walls, of an obstacle the face that
    /// holds the contact.
    pub parts: [usize; 2],
    /// The tangential spring (m), which pulls the first body back.
    pub tangential: Vector3<f64>,
    /// The rolling spring (rad).
    pub rolling: Vector3<f64>,
}

/// State of the contacts from one step to the next.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Touching {
    /// The springs of sustained contacts, after the first body and the second, or the number of
    /// bodies plus that of a wall.
    pub springs: Vec<(usize, usize, Springs)>,
}

/// The contacts among bodies and walls.
#[derive(Clone, Debug)]
pub struct Contacts {
    setup: Setup,
    pairs: Pairs,
    /// Per body, its response and its load in the step.
    states: Vec<ContactBody>,
    clusters: Clusters,
    /// Scratch of a substep, and of the correction.
    forces: Vec<ContactForce>,
    constraints: Vec<Constraint>,
    outcome: Outcome,
}

impl Contacts {
    /// Contacts among `bodies` of the given `materials`, and with `walls`, in a box from 0 to
    /// `size` (m) of which some axes are periodic (their lengths, m).
    pub fn new(
        bodies: &[Body],
        materials: Vec<usize>,
        walls: Vec<Wall>,
        laws: Laws,
        size: [f64; 3],
        periods: [Option<f64>; 3],
        substeps: Substeps,
    ) -> Contacts {
        let pairs = Pairs::new(bodies, size, periods);
        Contacts {
            states: bodies.iter().map(ContactBody::new).collect(),
            clusters: Clusters::new(bodies.len()),
            forces: Vec::with_capacity(pairs.list.capacity()),
            constraints: Vec::with_capacity(pairs.list.capacity()),
            outcome: Outcome::new(bodies.len()),
            pairs,
            setup: Setup {
                names: bodies.iter().map(Body::called).collect(),
                materials,
                obstacles: (0..bodies.len()).filter(|&k| bodies[k].is_obstacle()).collect(),
                walls,
                laws,
                size,
                periods,
                substeps,
                medium: Medium::default(),
            },
        }
    }

    /// Surfaces with asperities of this height (m).
    pub fn rough(mut self, roughness: f64) -> Contacts {
        self.setup.medium.roughness = roughness;
        self
    }

    /// Contacts in a fluid that follows the bodies within the step, its mass with theirs, and
    /// resists in the gaps between them.
    pub fn within(mut self, medium: Medium) -> Contacts {
        self.setup.medium = Medium { roughness: self.setup.medium.roughness, ..medium };
        self
    }

    /// The state of contacts where nothing touches yet.
    pub fn untouched(&self) -> Touching {
        Touching { springs: Vec::with_capacity(self.pairs.list.capacity()) }
    }

    /// The setup, which never changes: walls, laws, materials and the fluid in the gaps.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Moves all bodies on by `dt` (s): free ones under `accelerations` and contacts, prescribed
    /// ones as told. `turning` is the moment of inertia of a body and of the fluid that turns with
    /// it (kg m2).
    ///
    /// # Errors
    /// When a state is not finite, an overlap is too deep, the substeps are too few, or a body
    /// leaves the box.
    pub fn advance(
        &mut self,
        bodies: &mut [Body],
        touching: &mut Touching,
        accelerations: &[Accelerations],
        turning: impl Fn(usize, &Body) -> Inertia,
        dt: f64,
    ) -> Result<&Outcome> {
        let Contacts { setup, pairs, states, clusters, forces, outcome, .. } = self;
        setup.refuse_strays(bodies)?;
        for (k, (state, body)) in states.iter_mut().zip(&*bodies).enumerate() {
            state.begin(body, &accelerations[k], setup.mass_in_contact(body), &turning(k, body));
        }
        pairs.recall(setup, states, bodies, touching);
        clusters.clear();
        outcome.clear();
        let mut left = dt;
        while left > 0.0 {
            let first = outcome.substeps == 0;
            pairs.search(setup, states, bodies, left, !first);
            if first {
                pairs.find_stored(setup, states, bodies);
            }
            left = Integrator { setup, pairs, states, bodies, forces, outcome }.advance(left)?;
        }
        bodies.iter_mut().zip(&*states).for_each(|(body, state)| body.rotate(&state.turned));
        setup.refuse_strays(bodies)?;
        outcome.find_damping(&pairs.list, bodies);
        pairs.find_faces(setup, states, bodies);
        pairs.keep(setup, bodies, touching);
        Ok(outcome)
    }

    /// Outcome of the contacts in the last step.
    pub fn outcome(&self) -> &Outcome {
        &self.outcome
    }

    /// Counts an angular impulse of contacts on a body beyond what the step found (N m s).
    pub(crate) fn add_turn(&mut self, body: usize, turn: &Vector3<f64>) {
        self.outcome.bodies[body].impulse.angular += turn;
    }

    /// Whether a pair gave an impulse over the last step of `dt` (s) that counts: lubrication that
    /// can hardly slow two in that time does not.
    pub(crate) fn gave(&self, bodies: &[Body], dt: f64) -> bool {
        let layout = self.layout(bodies);
        self.pairs.list.iter().any(|pair| correction::gave(&layout, pair, dt))
    }

    /// The impulses of the last step, to be corrected.
    pub(crate) fn impulses(&mut self) -> Impulses<'_> {
        let Contacts { setup, pairs, states, clusters, constraints, outcome, .. } = self;
        Impulses { setup, pairs, states, clusters, constraints, outcome }
    }

    /// Finds the time (s) of the last step in which each body has moved as its residual lets
    /// expect: the shortest t (1 - q) of its contacts, and none where it has no contact.
    pub(crate) fn find_followed(&self, bodies: &[Body], followed: &mut [f64]) {
        let layout = self.layout(bodies);
        followed.fill(f64::INFINITY);
        for pair in self.pairs.list.iter().filter(|pair| pair.touched()) {
            let kinematics = layout.kinematics(pair, 0.0).0;
            let held = correction::held_by_contact(&layout, pair, &kinematics);
            for k in [pair.first, pair.second] {
                let Some(time) = followed.get_mut(k) else { continue };
                *time = time.min((1.0 - held) * pair.sums.time);
            }
        }
        followed.iter_mut().filter(|time| time.is_infinite()).for_each(|time| *time = 0.0);
    }

    /// Velocity of a body (m/s) without the impulses of touch of the last step, where one of its
    /// contacts parts and it is known.
    pub(crate) fn velocity_without(&self, k: usize) -> Option<Vector3<f64>> {
        let body = &self.clusters.bodies[k];
        body.without.filter(|_| body.parts).map(|without| without.velocity)
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
        let RigidVelocity { velocity, spin } = self.clusters.bodies[k].without?;
        let Impulse { linear, angular } = self.outcome.impulse(k);
        let bent = way / dt - 0.5 * (start + velocity);
        let early = self.setup.mass_in_contact(body) * bent.dot(&(velocity - start));
        let turned = angular.dot(&(spin + body.spin));
        Some(0.5 * (linear.dot(&(velocity + body.velocity)) + turned) - early)
    }

    /// Finds the pairs of bodies as they lie, before any [`advance`](Contacts::advance).
    pub fn meet(&mut self, bodies: &[Body]) {
        let Contacts { setup, pairs, states, .. } = self;
        let still = Accelerations::default();
        for (state, body) in states.iter_mut().zip(bodies) {
            state.begin(body, &still, setup.mass_in_contact(body), &body.inertia());
        }
        pairs.search(setup, states, bodies, 0.0, false);
    }

    /// Whether a body is in reach of another or of a wall after a [`meet`](Contacts::meet).
    pub fn is_paired(&self, body: usize) -> bool {
        self.pairs.travels[body].paired
    }

    /// Energy in the normal springs of the pairs of the last [`advance`](Contacts::advance) or
    /// [`meet`](Contacts::meet), where the bodies lie now and are to be displaced (m) yet (J).
    pub fn stored(&self, bodies: &[Body], displaced: impl Fn(usize) -> Vector3<f64>) -> f64 {
        let layout = self.layout(bodies);
        let of = |k: usize| if k < bodies.len() { displaced(k) } else { Vector3::zeros() };
        self.pairs.list.iter().fold(0.0, |sum, pair| {
            let meeting = layout.closest(pair, 0.0);
            let displaced = of(pair.first) - of(pair.second);
            let overlap = meeting.overlap + meeting.normal.dot(&displaced);
            sum + layout.law(pair).stored(overlap)
        })
    }

    /// The bodies as they lie now.
    fn layout<'a>(&'a self, bodies: &'a [Body]) -> Layout<'a> {
        let Contacts { setup, pairs, states, .. } = self;
        Layout { setup, regions: &pairs.regions, states, bodies }
    }
}

impl Checkpointed for Springs {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Springs { image, parts: [first, second], tangential, rolling } = self;
        archive.serialize([image, tangential, rolling])?;
        first.serialize(archive)?;
        second.serialize(archive)
    }
}

impl Checkpointed for Touching {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        archive.serialize([&mut self.springs])
    }
}
