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
//! In a fluid, m is the mass of a body and a part of its added mass, `m + c C_a` with `c = min(1.6,
//! 0.4 + s/4)`: C_a is the added mass of a lone body and s its density over the fluid's. The fluid
//! responds with its own inertia; `correction.rs` compares the two once in a step, and bounds the
//! work of the contacts.
//!
//! ```text
//!      first          second        arms: from the centres to the middle of the overlap
//!     (   o----n--->()<-----o   )   slip = (v_i - v_j)_t + (a_i w_i + a_j w_j) x n
//! ```

mod cluster;
mod correction;
mod law;
mod lubrication;
mod rolling;
mod stiffness;
mod substep;
#[cfg(test)]
mod tests;

use crate::archive::{Archive, Checkpointed};
use crate::error::NotFinite;
use crate::numerics::Numerics;
use crate::particles::{Accelerations, Body, Inertia, Neighbours};
use crate::{Error, Result};
use cluster::Clusters;
use correction::Constraint;
use law::Law;
pub use law::{Damping, Laws, Material};
use lubrication::Lubrication;
pub use lubrication::Medium;
use nalgebra::Vector3;
pub use stiffness::Impact;
use substep::{InverseMass, Meeting, RIGID, TangentialForce};

/// Overlap, of the smaller radius, that ends a run: soft contacts are no model of bodies beyond it.
pub const DEEPEST_OVERLAP: f64 = 0.2;

/// A border of the box, normal to an axis; its inner side faces the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Its normal: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Whether the box lies below it.
    pub high: bool,
    /// Its coordinate (m).
    pub at: f64,
    /// Its velocity (m/s), of which the part along the wall counts.
    pub velocity: Vector3<f64>,
    /// Its material.
    pub material: usize,
    /// What the fluid does there.
    pub side: WallSide,
}

/// What the fluid does at a border that stops bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WallSide {
    /// It sticks, and a lubrication layer of it is between body and wall.
    Closed,
    /// It slips: a plane of symmetry, beyond which bodies see their own images.
    Slip,
    /// It comes in, as through a grate: no lubrication layer.
    Inflow,
}

/// How many substeps a step is divided into where bodies could meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Substeps {
    /// Enough for the shortest contact.
    Auto,
    /// So many.
    Fixed(usize),
}

/// What contacts gave to a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse {
    /// Momentum (N s; per metre of depth in 2D).
    pub linear: Vector3<f64>,
    /// Angular momentum about its centre (N m s).
    pub angular: Vector3<f64>,
}

/// Two that could meet within the step.
#[derive(Clone, Copy, Debug)]
struct Pair {
    first: usize,
    /// A body, or the number of bodies plus that of a wall.
    second: usize,
    /// Which image of the second body it is: whole periods from its path to that of the image,
    /// along each axis.
    image: Vector3<f64>,
    /// Tangential spring (m), while they touch, and that of their rolling (rad).
    spring: Option<Vector3<f64>>,
    rolled: Vector3<f64>,
    /// Impulse on the first and angular impulses on both over the step, by touch and lubrication (N
    /// s, N m s).
    impulse: Vector3<f64>,
    turns: [Vector3<f64>; 2],
    /// Normal impulse over the step, by touch and lubrication, positive where it parts the two (N
    /// s).
    normal: f64,
    /// Of touch alone: tangential impulse on the first, normal impulse, in all and while the two
    /// stick (N s), and its time (s).
    tangential: Vector3<f64>,
    pressed: f64,
    stuck: f64,
    touched: f64,
    /// Energy in the springs at the start of the step (J).
    stored: f64,
    /// What the fluid between them resists, after how many substeps each, and for how long (s) it
    /// has not yet.
    lubrication: Lubrication,
    stride: usize,
    due: f64,
    /// They cannot touch before the two have gone so far since the search, together (m).
    clear: f64,
}

/// The springs of a contact between a body and an image of another one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Springs {
    /// Which image: whole periods from the centre of the second body to that of the image, along
    /// each axis.
    pub image: Vector3<f64>,
    /// The tangential spring (m), which pulls the first body back.
    pub tangential: Vector3<f64>,
    /// The rolling spring (rad).
    pub rolling: Vector3<f64>,
}

/// What lasts of contacts from one step to the next.
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
    /// Their numbers in the case.
    ids: Vec<usize>,
    walls: Vec<Wall>,
    laws: Laws,
    size: [f64; 3],
    periods: [Option<f64>; 3],
    substeps: Substeps,
    neighbours: Neighbours,
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
    /// Of the substep.
    tangential_forces: Vec<TangentialForce>,
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
    /// What fills the gaps.
    medium: Medium,
    numerics: Numerics,
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
        Contacts {
            ids: bodies.iter().map(|body| body.id).collect(),
            materials,
            walls,
            laws,
            size,
            periods,
            substeps,
            neighbours: Neighbours::new(bodies, size, periods),
            pairs: Vec::with_capacity(8 * n),
            old: Vec::with_capacity(8 * n),
            inverse_masses: vec![RIGID; n],
            damping: vec![0.0; n],
            travelled: vec![0.0; n],
            search_radius: vec![0.0; n],
            paired: vec![false; n],
            loads: vec![Impulse::default(); n],
            tangential_forces: Vec::with_capacity(8 * n),
            constraints: Vec::with_capacity(8 * n),
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
            numerics: Numerics::default(),
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

    /// Contacts by these numbers of the method, in place of the defaults.
    pub fn with_numerics(mut self, numerics: Numerics) -> Contacts {
        self.numerics = numerics;
        self
    }

    /// The numbers of the method.
    pub fn numerics(&self) -> &Numerics {
        &self.numerics
    }

    /// Nothing touches yet.
    pub fn untouched(&self) -> Touching {
        Touching { springs: Vec::with_capacity(8 * self.materials.len()) }
    }

    /// Effective mass of a body in contact (kg): its own, and a part of its added mass that grows
    /// with its density.
    pub fn mass_in_contact(&self, body: &Body) -> f64 {
        let added = body.added_mass(self.medium.density);
        let displaced = self.medium.density * body.volume();
        let ratio = if displaced > 0.0 { body.mass() / displaced } else { f64::INFINITY };
        let part = self.numerics.added_mass_share + ratio * self.numerics.added_mass_slope;
        body.mass() + part.min(self.numerics.largest_added_mass_share) * added
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
        for (i, (body, accelerations)) in bodies.iter().zip(accelerations).enumerate() {
            self.inverse_masses[i] =
                InverseMass::of(body, accelerations, self.mass_in_contact(body), &turning(i, body));
        }
        self.pairs.clear();
        let (kept, periods) = (touching.springs.iter(), &self.periods);
        self.pairs.extend(kept.map(|&(i, j, springs)| Pair {
            spring: Some(springs.tangential),
            rolled: springs.rolling,
            ..Pair::new(i, j, springs.image - crossed(bodies, i, j, periods))
        }));
        self.impulses.fill(Impulse::default());
        self.wall_impulse = Vector3::zeros();
        (self.wall_work, self.slid) = (0.0, 0.0);
        self.deepest = 0.0;
        self.clusters.clear();
        self.touched.fill(false);
        self.turned.fill(Vector3::zeros());
        let (mut left, mut taken) = (dt, 0);
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
        touching.springs.clear();
        let lasting = self.pairs.iter().filter_map(|p| {
            let image = p.image + crossed(bodies, p.first, p.second, &self.periods);
            Some((p.first, p.second, Springs { image, tangential: p.spring?, rolling: p.rolled }))
        });
        touching.springs.extend(lasting);
        Ok(taken)
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
                self.damping[k] += if pair.pressed > 0.0 { f64::INFINITY } else { lubrication };
            }
        }
    }

    /// Part of a change of a body's spin, which the substeps did not expect, that contacts leave
    /// over the step `dt` (s): all without any, nothing of a body that touches. `inertia` is the
    /// moment of inertia about an axis (kg m2), the fluid's included.
    pub fn contact_damping(&self, body: usize, inertia: f64, dt: f64) -> f64 {
        1.0 / (1.0 + dt * self.damping[body] / inertia)
    }

    /// What an impulse (N m s) of contacts changes of a body's spin, with what turns with it
    /// (rad/s).
    pub(crate) fn turned_by(&self, body: usize, turn: &Vector3<f64>) -> Vector3<f64> {
        self.inverse_masses[body].inertia.component_mul(turn)
    }

    /// Takes note of what contacts gave beyond what [`advance`](Contacts::advance) found (N m s).
    pub(crate) fn add_turn(&mut self, body: usize, turn: &Vector3<f64>) {
        self.impulses[body].angular += turn;
    }

    /// What contacts gave to each body over the last [`advance`](Contacts::advance).
    pub fn impulses(&self) -> &[Impulse] {
        &self.impulses
    }

    /// Momentum that bodies gave to walls over the last [`advance`](Contacts::advance) (N s).
    pub fn wall_impulse(&self) -> Vector3<f64> {
        self.wall_impulse
    }

    /// Work of moving walls on bodies over the last [`advance`](Contacts::advance) (J).
    pub fn wall_work(&self) -> f64 {
        self.wall_work
    }

    /// What friction took over the last [`advance`](Contacts::advance) (J): the work of tangential
    /// forces and of the resistance to rolling, less what their springs hold.
    pub fn slid(&self) -> f64 {
        self.slid
    }

    /// Finds the pairs of bodies as they lie, before any [`advance`](Contacts::advance).
    pub fn meet(&mut self, bodies: &[Body]) {
        for (i, body) in bodies.iter().enumerate() {
            self.inverse_masses[i] = InverseMass::of(
                body,
                &Accelerations::default(),
                self.mass_in_contact(body),
                &body.inertia(),
            );
        }
        self.search(bodies, 0.0, false);
    }

    /// Whether a body is in reach of another or of a wall after a [`meet`](Contacts::meet).
    pub fn is_paired(&self, body: usize) -> bool {
        self.paired[body]
    }

    /// Per body, whether it lies on another or on a wall after a [`meet`](Contacts::meet): they
    /// touch and hardly come nearer.
    pub fn lying(&self, bodies: &[Body]) -> Vec<bool> {
        let mut lying = vec![false; bodies.len()];
        for pair in self.pairs.iter().filter(|pair| !pair.is_own_image()) {
            let met = self.kinematics(pair, bodies, 0.0).0;
            // An approach by less than a thousandth of the radius while a contact lasts is no
            // impact.
            let lasts =
                self.law(pair).contact_time(1.0 / met.inverse_normal, met.approach.max(0.0));
            let still =
                met.approach <= 0.0 || met.approach * lasts < 1e-3 * bodies[pair.first].radius();
            let least = -self.medium.roughness.max(substep::TOUCHING * bodies[pair.first].radius());
            for k in [pair.first, pair.second] {
                lying
                    .get_mut(k)
                    .into_iter()
                    .for_each(|lies| *lies |= still && met.overlap >= least);
            }
        }
        lying
    }

    /// Energy in the normal springs of the pairs of the last [`advance`](Contacts::advance) or
    /// [`meet`](Contacts::meet), where the bodies lie now and are to be displaced (m) yet (J).
    pub fn stored(&self, bodies: &[Body], displaced: impl Fn(usize) -> Vector3<f64>) -> f64 {
        let of = |k: usize| if k < bodies.len() { displaced(k) } else { Vector3::zeros() };
        let overlap = |pair: &Pair| {
            let Meeting { normal, overlap, .. } = self.closest(pair, bodies, 0.0);
            overlap + normal.dot(&(of(pair.first) - of(pair.second)))
        };
        self.pairs.iter().fold(0.0, |sum, pair| sum + self.law(pair).stored(overlap(pair)))
    }

    /// Per body, whether it touched another or a wall over the last [`advance`](Contacts::advance),
    /// or came as near as their asperities are high.
    pub fn touched(&self) -> &[bool] {
        &self.touched
    }

    /// Deepest overlap of two bodies, or of one and a wall, over the last
    /// [`advance`](Contacts::advance) (m).
    pub fn deepest(&self) -> f64 {
        self.deepest
    }

    /// Shortest duration (s) of a contact that could happen, undamped and at an impact of `speed`
    /// (m/s), which counts where the exponent is not 1; infinite where none could.
    pub fn contact_time(&self, bodies: &[Body], speed: f64) -> f64 {
        // Per material, the lightest free body and the number of bodies.
        let mut lightest = vec![(f64::INFINITY, 0); self.laws.materials()];
        for (body, &material) in bodies.iter().zip(&self.materials) {
            let (mass, count) = &mut lightest[material];
            let own = self.mass_in_contact(body);
            *mass = mass.min(if body.freedom().is_some() { own } else { f64::INFINITY });
            *count += 1;
        }
        let mut shortest = f64::INFINITY;
        let mut meet = |a: usize, b: usize, inverse: f64| {
            if inverse > 0.0 {
                shortest = self.laws.of(a, b).contact_time(1.0 / inverse, speed).min(shortest);
            }
        };
        for (a, &(mass, count)) in lightest.iter().enumerate() {
            for (b, &(other, others)) in lightest.iter().enumerate().skip(a) {
                if others > 0 && count > usize::from(a == b) {
                    meet(a, b, 1.0 / mass + 1.0 / other);
                }
            }
            self.walls.iter().for_each(|wall| meet(a, wall.material, 1.0 / mass));
        }
        shortest
    }

    /// Refuses what no run of this case has left.
    ///
    /// # Errors
    /// When a number belongs to no body or wall, or an image to no period.
    pub fn check(&self, touching: &Touching) -> Result<()> {
        let bodies = self.inverse_masses.len();
        for &(first, second, Springs { image, .. }) in &touching.springs {
            let imaged =
                (0..3).any(|a| image[a] != 0.0 && (second >= bodies || self.periods[a].is_none()));
            if first >= bodies || second <= first || second >= bodies + self.walls.len() || imaged {
                return Err(Error::Run(format!(
                    "the saved contact of particle {first} with {second} does not belong to this \
                    case: restart with \
                     the particles and walls of the run that saved it"
                )));
            }
        }
        Ok(())
    }

    /// Finds the pairs that could meet within `time` (s), and keeps the springs. With `again`, the
    /// search_radius leaves room for what contacts do to speeds.
    fn search(&mut self, bodies: &[Body], time: f64, again: bool) {
        let mut farthest: f64 = 0.0;
        for (i, (body, inverse_mass)) in bodies.iter().zip(&self.inverse_masses).enumerate() {
            let way =
                (body.speed() + 0.5 * inverse_mass.accelerations.acceleration.norm() * time) * time;
            self.search_radius[i] = 0.5 * self.medium.range(&self.numerics)
                + if again { 2.0 * way + 0.05 * body.radius() } else { way + 1e-6 * body.radius() };
            farthest = farthest.max(body.radius() + self.search_radius[i]);
        }
        self.travelled.fill(0.0);
        self.paired.fill(false);
        std::mem::swap(&mut self.pairs, &mut self.old);
        self.pairs.clear();
        self.neighbours.sort(bodies, 2.0 * farthest);
        let free = |i: usize| bodies[i].freedom().is_some();
        let mut rest = &self.old[..];
        for (i, body) in bodies.iter().enumerate() {
            let mine = rest.iter().take_while(|p| p.first == i).count();
            let (before, after) = rest.split_at(mine);
            rest = after;
            let kept = |j, image| {
                let old = before.iter().find(|p| p.second == j && p.image == image).copied();
                Pair { clear: 0.0, ..old.unwrap_or(Pair::new(i, j, image)) }
            };
            let periods = &self.periods;
            let (pairs, paired) = (&mut self.pairs, &mut self.paired);
            let begin = pairs.len();
            self.neighbours.around(i, bodies, &self.search_radius, |j, image| {
                if free(i) || free(j) {
                    pairs.push(kept(j, image - crossed(bodies, i, j, periods)));
                    (paired[i], paired[j]) = (true, true);
                }
            });
            for (w, wall) in self.walls.iter().enumerate().filter(|_| free(i)) {
                if wall.distance(&body.centre)
                    <= body.radius()
                        + 0.5 * self.medium.range(&self.numerics)
                        + self.search_radius[i]
                {
                    pairs.push(kept(bodies.len() + w, Vector3::zeros()));
                    paired[i] = true;
                }
            }
            // Pairs act one after the other: bodies by number, their images and walls by distance,
            // in an order that no mirror changes.
            let walls = &self.walls;
            let away = |pair: &Pair| {
                pair.second.checked_sub(bodies.len()).map(|wall| walls[wall].distance(&body.centre))
            };
            let ordered = |one: &Pair, other: &Pair| match (away(one), away(other)) {
                (Some(near), Some(far)) => near.total_cmp(&far),
                (None, None) if one.second == other.second => {
                    let [near, far] =
                        [one, other].map(|pair| pair.apart(bodies, periods).norm_squared());
                    near.total_cmp(&far)
                }
                _ => one.second.cmp(&other.second),
            };
            pairs[begin..].sort_unstable_by(ordered);
        }
    }

    fn law(&self, pair: &Pair) -> &Law {
        let wall = |w: usize| self.walls[w].material;
        let bodies = self.materials.len();
        let second =
            self.materials.get(pair.second).copied().unwrap_or_else(|| wall(pair.second - bodies));
        self.laws.of(self.materials[pair.first], second)
    }

    fn name(&self, pair: &Pair) -> String {
        match pair.second.checked_sub(self.materials.len()) {
            None => format!("particles {} and {}", self.ids[pair.first], self.ids[pair.second]),
            Some(w) => format!("particle {} and {}", self.ids[pair.first], self.walls[w].name()),
        }
    }

    /// Refuses bodies of which the state is not finite, or that are outside the box or beyond a
    /// wall.
    fn refuse_strays(&self, bodies: &[Body]) -> Result<()> {
        for body in bodies {
            let i = body.id;
            if !body.is_finite() {
                return Err(Error::NotFinite(NotFinite::Particle(i)));
            }
            if let Some(wall) = self.walls.iter().find(|wall| wall.distance(&body.centre) < 0.0) {
                return Err(Error::Run(format!(
                    "the centre of particle {i} is beyond {}: shorten the step or make the contact \
                    stiffer",
                    wall.name()
                )));
            }
            for a in (0..body.shape().dimension()).filter(|&a| self.periods[a].is_none()) {
                if !(0.0..=self.size[a]).contains(&body.centre[a]) {
                    return Err(Error::Run(format!(
                        "the centre of particle {i} has left the box: it is at {} = {:.6} m, and \
                        no wall ends the box \
                         there; make that border a wall or the axis periodic, or end the run \
                         before",
                        ["x", "y", "z"][a],
                        body.centre[a]
                    )));
                }
            }
        }
        Ok(())
    }
}

/// Whole periods, along each axis, by which the second of two bodies has crossed more periodic
/// borders; none of a wall.
fn crossed(
    bodies: &[Body],
    first: usize,
    second: usize,
    periods: &[Option<f64>; 3],
) -> Vector3<f64> {
    let Some(other) = bodies.get(second) else { return Vector3::zeros() };
    let further = other.crossed - bodies[first].crossed;
    Vector3::from_fn(|a, _| periods[a].map_or(0.0, |length| (further[a] / length).round()))
}

impl Pair {
    fn new(first: usize, second: usize, image: Vector3<f64>) -> Pair {
        Pair {
            first,
            second,
            image,
            spring: None,
            rolled: Vector3::zeros(),
            impulse: Vector3::zeros(),
            turns: [Vector3::zeros(); 2],
            normal: 0.0,
            tangential: Vector3::zeros(),
            pressed: 0.0,
            stuck: 0.0,
            touched: 0.0,
            stored: 0.0,
            lubrication: Lubrication::UNKNOWN,
            stride: 1,
            due: 0.0,
            clear: 0.0,
        }
    }

    /// Counts an impulse on the first (N s), and angular impulses on both (N m s).
    fn add(&mut self, impulse: Vector3<f64>, turns: [Vector3<f64>; 2]) {
        self.impulse += impulse;
        self.turns.iter_mut().zip(turns).for_each(|(sum, turn)| *sum += turn);
    }

    /// Whether the second is an image of the first itself.
    fn is_own_image(&self) -> bool {
        self.first == self.second
    }

    /// From the centre of the first body to that of the image of the second (m).
    fn apart(&self, bodies: &[Body], periods: &[Option<f64>; 3]) -> Vector3<f64> {
        let way = bodies[self.second].centre - bodies[self.first].centre;
        let image = self.image + crossed(bodies, self.first, self.second, periods);
        Vector3::from_fn(|a, _| way[a] + periods[a].map_or(0.0, |length| length * image[a]))
    }
}

impl Checkpointed for Springs {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Springs { image, tangential, rolling } = self;
        archive.serialize([image, tangential, rolling])
    }
}

impl Checkpointed for Touching {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        archive.serialize([&mut self.springs])
    }
}

impl Wall {
    /// How far inside the box a point is (m).
    fn distance(&self, point: &Vector3<f64>) -> f64 {
        if self.high { self.at - point[self.axis] } else { point[self.axis] - self.at }
    }

    /// Its velocity along itself (m/s).
    fn sliding(&self) -> Vector3<f64> {
        self.velocity - self.velocity.dot(&self.normal()) * self.normal()
    }

    /// Out of the box.
    fn normal(&self) -> Vector3<f64> {
        let mut normal = Vector3::zeros();
        normal[self.axis] = if self.high { 1.0 } else { -1.0 };
        normal
    }

    fn name(&self) -> String {
        let what = if self.side == WallSide::Inflow { "inflow" } else { "wall" };
        format!("the {what} at {} = {} m", ["x", "y", "z"][self.axis], self.at)
    }
}
