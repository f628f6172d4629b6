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
//! between such as cannot touch in the step acts every so many substeps, for all of them.
//!
//! In a fluid, m is the mass of a body and a part of its added mass, `m + c C_a` with
//! `c = min(1.6, 0.4 + s/4)`: C_a is the added mass of a lone body and s its density over the
//! fluid's. The fluid responds with its own inertia; `correction.rs` compares the two once in a
//! step, and bounds the work of the contacts.
//!
//! ```text
//!      first          second        arms r: from the centres to the middle of the overlap
//!     (   o----n--->()<-----o   )   slip = (v_i - v_j + w_i x r_i - w_j x r_j)_t
//! ```
//!
//! A body that is not round has convex parts ([`mics_shapes::Part`]), each a contact of its own
//! with every part near it, and with the walls ([`mics_shapes::touch`]); its orientation and its
//! tensor of inertia turn in every substep.

mod cluster;
mod correction;
mod count;
mod gaps;
mod law;
mod lubrication;
mod meeting;
mod obstacle;
mod overlap;
mod pair;
mod response;
mod results;
mod rolling;
mod search;
mod stiffness;
mod substep;
#[cfg(test)]
mod tests;
mod wall;

use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::numerics::{ADDED_MASS_SHARE, ADDED_MASS_SLOPE, LARGEST_ADDED_MASS_SHARE};
use crate::particles::{Accelerations, Body, Inertia, Neighbours};
use cluster::Clusters;
use correction::Constraint;
pub use law::{Damping, Laws, Material};
pub use lubrication::Medium;
use meeting::Met;
use mics_shapes::{Pose, Regions};
use nalgebra::{Matrix3, Vector3};
use pair::{Pair, crossed};
use response::{InverseMass, RIGID};
pub use stiffness::Impact;
use substep::TangentialForce;
pub use wall::{Wall, WallSide};

/// Overlap, of the smaller radius, that ends a run: soft contacts are no model of bodies beyond it.
pub const DEEPEST_OVERLAP: f64 = 0.2;

/// How many substeps a step is divided into where bodies could meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Substeps {
    /// Enough for the shortest contact.
    Auto,
    /// So many.
    Fixed(usize),
}

/// Impulses that contacts gave to a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse {
    /// Momentum (N s; per metre of depth in 2D).
    pub linear: Vector3<f64>,
    /// Angular momentum about its centre (N m s).
    pub angular: Vector3<f64>,
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
    /// The springs of contacts that last, after the first body and the second, or the number of
    /// bodies plus that of a wall.
    pub springs: Vec<(usize, usize, Springs)>,
}

/// The law of the contacts among bodies and walls, and what a step needs to follow it.
#[derive(Clone, Debug)]
pub struct Contacts {
    materials: Vec<usize>,
    /// Convex parts in all.
    parts: usize,
    /// What messages call them.
    names: Vec<String>,
    walls: Vec<Wall>,
    laws: Laws,
    size: [f64; 3],
    periods: [Option<f64>; 3],
    substeps: Substeps,
    neighbours: Neighbours,
    /// The bodies that are obstacles, and the regions of them in reach of parts of bodies.
    obstacles: Vec<usize>,
    regions: Regions,
    /// By their first body, ascending; those of the search before.
    pairs: Vec<Pair>,
    old: Vec<Pair>,
    /// Per body: its response, its way since the search (m) and the way it may go (m), whether it
    /// has a pair, its load now.
    inverse_masses: Vec<InverseMass>,
    /// Per body, see [`Contacts::contact_damping`].
    damping: Vec<f64>,
    travelled: Vec<f64>,
    search_radius: Vec<f64>,
    paired: Vec<bool>,
    loads: Vec<Impulse>,
    /// Scratch of the correction and of the bound on the work of contacts.
    constraints: Vec<Constraint>,
    clusters: Clusters,
    /// How pairs of which one is not round met last, and of the substep what held.
    met: Vec<Option<Met>>,
    tangential_forces: Vec<TangentialForce>,
    /// Per body that is not round, its pose in the middle of the substep.
    poses: Vec<Pose>,
    /// Per body that is not round, its moments of inertia in its own axes, with the fluid that
    /// turns with it (kg m2).
    own_inertias: Vec<Matrix3<f64>>,
    /// Per body, its way since the search when the next substep is done (m), and by how much it has
    /// turned in the step (rad).
    reach: Vec<f64>,
    turned: Vec<Vector3<f64>>,
    impulses: Vec<Impulse>,
    wall_impulse: Vector3<f64>,
    /// Work of moving walls on bodies, and what friction took, in the last step (J).
    wall_work: f64,
    slid: f64,
    /// Deepest overlap of the last step (m).
    deepest: f64,
    /// Per body, whether it touched something in the last step.
    touched: Vec<bool>,
    /// The fluid that fills the gaps.
    medium: Medium,
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
        let n = bodies.len();
        let parts = bodies.iter().map(|body| body.parts().len().max(1)).sum::<usize>();
        Contacts {
            parts,
            names: bodies.iter().map(Body::called).collect(),
            materials,
            walls,
            laws,
            size,
            periods,
            substeps,
            neighbours: Neighbours::new(bodies, size, periods),
            obstacles: (0..n).filter(|k| bodies[*k].shape().is_obstacle()).collect(),
            regions: Regions::default(),
            pairs: Vec::with_capacity(8 * parts),
            old: Vec::with_capacity(8 * parts),
            inverse_masses: vec![RIGID; n],
            damping: vec![0.0; n],
            travelled: vec![0.0; n],
            search_radius: vec![0.0; n],
            paired: vec![false; n],
            loads: vec![Impulse::default(); n],
            met: Vec::with_capacity(8 * parts),
            tangential_forces: Vec::with_capacity(8 * parts),
            constraints: Vec::with_capacity(8 * parts),
            poses: vec![Pose::default(); n],
            own_inertias: vec![Matrix3::zeros(); n],
            clusters: Clusters::new(n),
            reach: vec![0.0; n],
            turned: vec![Vector3::zeros(); n],
            impulses: vec![Impulse::default(); n],
            wall_impulse: Vector3::zeros(),
            wall_work: 0.0,
            slid: 0.0,
            deepest: 0.0,
            touched: vec![false; n],
            medium: Medium::default(),
        }
    }

    /// Surfaces with asperities of this height (m).
    pub fn rough(mut self, roughness: f64) -> Contacts {
        self.medium.roughness = roughness;
        self
    }

    /// Contacts in a fluid that follows the bodies within the step, its mass with theirs, and
    /// resists in the gaps between them.
    pub fn within(mut self, medium: Medium) -> Contacts {
        self.medium = Medium { roughness: self.medium.roughness, ..medium };
        self
    }

    /// Nothing touches yet.
    pub fn untouched(&self) -> Touching {
        Touching { springs: Vec::with_capacity(8 * self.parts) }
    }

    /// Effective mass of a body in contact (kg): its own, and a part of its added mass that grows
    /// with its density.
    pub fn mass_in_contact(&self, body: &Body) -> f64 {
        let added = body.added_mass(self.medium.density);
        let displaced = self.medium.density * body.volume();
        let ratio = if displaced > 0.0 { body.mass() / displaced } else { f64::INFINITY };
        let part = ADDED_MASS_SHARE + ratio * ADDED_MASS_SLOPE;
        body.mass() + part.min(LARGEST_ADDED_MASS_SHARE) * added
    }

    /// Moves all bodies on by `dt` (s): free ones under `accelerations` and contacts, prescribed
    /// ones as told. `turning` is the moment of inertia of a body and of the fluid that turns with
    /// it (kg m2). Returns the substeps taken: 0 where nobody is in reach of anybody, and everybody
    /// has made one ballistic move.
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
    ) -> Result<usize> {
        self.refuse_strays(bodies)?;
        self.begin(bodies, touching, accelerations, turning);
        let mut left = dt;
        let mut taken = 0;
        while left > 0.0 {
            self.search(bodies, left, taken > 0);
            if taken == 0 {
                self.find_stored(bodies);
            }
            if self.pairs.is_empty() {
                self.drift(bodies, left, |_| true);
                break;
            }
            let count = self.count(bodies, left, taken)?;
            let h = left / count as f64;
            self.pace_films(bodies, left, count);
            let mut done = 0;
            let mut within = true;
            while done < count && within {
                done += 1;
                within = self.substep(bodies, h, done)?;
            }
            self.lubricate(bodies, 0.0, None);
            self.drift(bodies, h * done as f64, |paired| !paired);
            left = if done < count { left - h * done as f64 } else { 0.0 };
            taken += done;
        }
        bodies.iter_mut().zip(&self.turned).for_each(|(body, turned)| body.rotate(turned));
        self.refuse_strays(bodies)?;
        self.find_damping(bodies);
        self.find_faces(bodies);
        touching.springs.clear();
        let sustained = self.pairs.iter().filter_map(|p| {
            let image = p.image + crossed(bodies, p.first, p.second, &self.periods);
            let parts = p.parts;
            let rolling = p.rolled;
            Some((p.first, p.second, Springs { image, parts, tangential: p.spring?, rolling }))
        });
        touching.springs.extend(sustained);
        Ok(taken)
    }

    /// Takes what bodies respond with in the step and the contacts that last, and forgets the step
    /// before.
    fn begin(
        &mut self,
        bodies: &[Body],
        touching: &Touching,
        accelerations: &[Accelerations],
        turning: impl Fn(usize, &Body) -> Inertia,
    ) {
        for (i, (body, accelerations)) in bodies.iter().zip(accelerations).enumerate() {
            let inertia = turning(i, body);
            if let Inertia::Tensor(tensor) = inertia {
                let turn = body.orientation();
                self.own_inertias[i] = turn.transpose() * tensor * turn.matrix();
            }
            self.inverse_masses[i] =
                InverseMass::of(body, accelerations, self.mass_in_contact(body), &inertia);
        }
        self.pairs.clear();
        let kept = touching.springs.iter();
        let periods = &self.periods;
        self.pairs.extend(kept.map(|&(i, j, springs)| Pair {
            spring: Some(springs.tangential),
            rolled: springs.rolling,
            parts: springs.parts,
            ..Pair::new(i, j, springs.image - crossed(bodies, i, j, periods))
        }));
        self.impulses.fill(Impulse::default());
        self.wall_impulse = Vector3::zeros();
        (self.wall_work, self.slid) = (0.0, 0.0);
        self.deepest = 0.0;
        self.clusters.clear();
        self.touched.fill(false);
        self.turned.fill(Vector3::zeros());
    }

    /// Finds the energy in the springs of the pairs as the bodies lie.
    fn find_stored(&mut self, bodies: &[Body]) {
        for p in 0..self.pairs.len() {
            self.pairs[p].stored = self.stored_in(&self.pairs[p], bodies);
        }
    }

    /// Energy in the springs of a pair as its two lie (J).
    fn stored_in(&self, pair: &Pair, bodies: &[Body]) -> f64 {
        self.law(pair)
            .stored_with(self.closest(pair, bodies, 0.0).overlap, &pair.spring.unwrap_or_default())
    }

    /// Finds how strongly pairs damp a body's spin (N m s): without bound where it touches, and
    /// else by lubrication.
    fn find_damping(&mut self, bodies: &[Body]) {
        self.damping.fill(0.0);
        for pair in &self.pairs {
            for k in [pair.first, pair.second] {
                let Some(body) = bodies.get(k) else { continue };
                // The surfaces of a body and of its own image slide with both spins, and both turn
                // the body.
                let sides = if pair.is_own_image() { 2.0 } else { 1.0 };
                let lubrication = body.radius().powi(2)
                    * (sides * pair.lubrication.sliding + pair.lubrication.rolling);
                self.damping[k] +=
                    if pair.normal_impulse > 0.0 { f64::INFINITY } else { lubrication };
            }
        }
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
