//! The wall where it is: faces of the pressure equation open as far as they are, and the velocity inside a body set from
//! the profile beside it. Nothing is relaxed, so that the time step does not enter.
//!
//! With `H = 1 - m` the open part of a face (m the covered one), `U_b = V + omega x r` a body's motion, `a = -grad p/rho`
//! on faces and `I` the mean of four cells across a free face, of two across a covered one, moved to the centroid of the
//! open part by the derivatives:
//!
//! ```text
//!   faces      q  = I(u*) + (1 - chi) (q^n - I(u^n)) + dt a,   U = H q + m U_b.n,   chi = min(1, dt U_max/(0.2 h))
//!   pressure   -div( H grad phi )/rho + sum_k (dV/M_k) j_k (j_k.phi) = -D/dt,       D = div U
//!   bodies     V += (dt/M_k) F_p,   F_p = dV sum_c p_c j_c,   j_c = sum_f m_f n_f/h   (n_f outwards from the cell)
//!   cells      u  = u* + dt (H_w a_w + H_e a_e)/(1 + (H_w + H_e)/2)
//!   inside     u  = U_b + the profile of the flow beside the wall, continued into the body ([`skin`])
//! ```
//! The equation stays symmetric, and its solution holds the added mass of a free body implicitly, whatever its density.
//! The memory `q^n - I(u^n)` keeps dt out of the wall's pressure; its u^n is that of the cells before the wall was imposed
//! last, so that what this changes reaches the faces with the next step. A turning disc or sphere displaces nothing.
//! In time the force is of second order. Of first order, and small, are cells that change sides, at the end of a step, and
//! the history of faces beside a wall that gathers speed.
//!
//! The force is what the fluid loses. All cells together lose momentum only where the profile is imposed (`du`) and where
//! the gradient of a cut cell differs from the plain mean of its faces'; what lies inside the body is no fluid:
//!
//! ```text
//!   F = -(rho dV/dt) sum du - rho dV sum (open - plain gradient) + d/dt( rho dV sum alpha u )
//! ```
//! Each step's F jitters as cells change sides. A body moves by pressure and wall shear, `F_p + F_v`, and takes in what
//! these miss, `X += eps (F - F_p - F_v - X)`, over the time the flow needs for some cells; what it still owes is kept and
//! is part of the balance of momentum.

mod faces;
mod force;
mod gap;
mod impact;
mod motion;
mod openings;
mod probe;
mod skin;
mod state;

use super::Exchange;
use crate::fluid::faces::FaceCoefficient;
use crate::fluid::poisson::Covered;
use crate::geometry::Overlap;
use crate::grid::{Boundaries, Grid, VectorField, wide};
use crate::petsc::Session;
use crate::solids::Body;
use crate::solids::contact::{Contacts, Medium, Neighbours, Push};
use gap::{Neighbour, Surroundings};
use nalgebra::{Matrix3, Vector3};
use skin::{Before, Skin};

/// Openings below this count as this: what is behind them keeps a pressure, and the equation constants as its only null
/// space.
const LEAST_OPEN: f64 = 1e-6;
/// Courant number over which a step forgets the face velocity's own history.
const FORGET: f64 = 0.2;
/// Reynolds number of a spacing and the velocity at the first probe up to which the layer at the wall is resolved.
const RESOLVED: f64 = 40.0;
/// Numbers that ranks sum for a body.
const NUMBERS: usize = 12;
/// Spacings that the flow crosses while a body takes in what pressure and wall shear miss of the force on it.
const TAKE_IN: f64 = 3.0;

/// How a body rides along.
#[derive(Clone, Copy, Debug, Default)]
struct Ride {
    /// Velocity and spin at the start of the step (m/s, rad/s), and those expected at its end.
    start: (Vector3<f64>, Vector3<f64>),
    expected: (Vector3<f64>, Vector3<f64>),
    /// Acceleration by fluid and gravity in the last step (m/s2, rad/s2).
    push: Push,
    /// Angular momentum at the start of the step (kg m2/s).
    turned: Vector3<f64>,
    /// What a force changes (kg): the mass with the wall shear's resistance over a step; infinite along held directions.
    inertia: f64,
    /// What a torque's impulse changes of the spin of a body that is not round (1/(kg m2)), with that resistance likewise.
    turns: Matrix3<f64>,
    /// Pressure force of the step so far (N), and its torque on a body that is not round (N m).
    pressure: Vector3<f64>,
    pressure_torque: Vector3<f64>,
    /// Wall shear's force and torque (N, N m), now and a step before.
    shear: (Vector3<f64>, Vector3<f64>),
    shear_before: Option<(Vector3<f64>, Vector3<f64>)>,
    /// What the two miss (N), taken in slowly; and the impulse (N s) that is still owed.
    rest: Vector3<f64>,
    owed: Vector3<f64>,
    /// Momentum (kg m/s) and angular momentum (kg m2/s) that the imposed profile and the gradient of cut cells have given to
    /// this rank's cells in the step; of the latter, once the step is closed, what the fluid lost to the body.
    given: Vector3<f64>,
    /// What pressure and wall shear miss of what the fluid lost in the step, and what the body has felt of it (N).
    missed: Vector3<f64>,
    used: Vector3<f64>,
    spun: Vector3<f64>,
    /// Momentum and angular momentum inside.
    inside: Vector3<f64>,
    swirl: Vector3<f64>,
}

/// Particles in a fluid with sharp walls.
pub struct Sharp<const D: usize> {
    bodies: Vec<Body>,
    skins: Vec<Skin<D>>,
    near: Vec<Vec<usize>>,
    /// Those near the body whose skin is built.
    beside: Vec<Neighbour>,
    neighbours: Box<Neighbours>,
    /// Largest radius (m), and half the distance at which bodies are near each other, for every one (m).
    largest: f64,
    reach: Vec<f64>,
    /// Whether a body had others near before the last search.
    had_near: Vec<bool>,
    rides: Vec<Ride>,
    exchange: Vec<Exchange>,
    contacts: Option<Contacts>,
    push: Vec<Push>,
    /// Bodies that are not round: pressure turns them.
    oblong: Vec<u32>,
    /// Per body, how it lay before it moved.
    before: Vec<Before>,
    /// Per body, its surface: area (m2; m in 2D), and moments of inertia in its own axes as a shell of a kilogram per area.
    shells: Vec<(f64, Matrix3<f64>)>,
    /// What mends contacts: how far velocities are from the expected ones (m/s), and the impulses (N s).
    deviations: Vec<Vector3<f64>>,
    nudges: Vec<Vector3<f64>>,
    /// Force of the fluid (N) in gaps that the grid does not resolve, which walls and held bodies have in place of free ones.
    passed_on: Vector3<f64>,
    /// Velocities before the last of these impulses (m/s).
    unpushed: Vec<Vector3<f64>>,
    periods: [Option<f64>; 3],
    h: f64,
    fluid_density: f64,
    fluid_viscosity: f64,
    gravity: Vector3<f64>,
    values: Vec<Vector3<f64>>,
    /// What covered faces change of the acceleration of the cells beside them (m/s2), in the order of the skins' own cells.
    excess: Vec<[f64; D]>,
    /// History of the face velocities beside that of the cells (m/s).
    memory: VectorField<D>,
    /// Faces that were covered in the last step, by axis, and the open part that they had.
    covered: [Vec<(usize, f64)>; D],
    chi: f64,
    courant: f64,
    weights: Vec<f64>,
    entries: Vec<Covered>,
    buffer: Vec<f64>,
    /// What bodies cover of each face of an axis while faces are opened; zero otherwise.
    total: Vec<f64>,
    session: Session,
}

/// The spacing that probes count in (m), and the layers of ghosts that they reach, on a grid of the spacings `h` (m): no axis
/// may have fewer cells.
pub fn reach(h: &[f64]) -> (f64, usize) {
    let least = h.iter().copied().fold(f64::INFINITY, f64::min);
    let most = h.iter().copied().fold(0.0, f64::max).min(2.0 * least);
    (most, 2 + ((skin::DEPTH + skin::PROFILE[1]) * most / least - 1e-9).ceil() as usize)
}

impl<const D: usize> Sharp<D> {
    /// Bodies in a fluid of the given density (kg/m3), viscosity (Pa s) and gravity (m/s2).
    pub fn new(
        session: &Session,
        grid: &Grid<D>,
        bodies: Vec<Body>,
        contacts: Option<Contacts>,
        gravity: Vector3<f64>,
        fluid_density: f64,
        fluid_viscosity: f64,
    ) -> Sharp<D> {
        let (n, h) = (bodies.len(), reach(&grid.h).0);
        let periods = std::array::from_fn(|a| (a < D && grid.periodic[a]).then(|| grid.size[a]));
        let size = std::array::from_fn(|a| if a < D { grid.size[a] } else { 1.0 });
        let skins: Vec<_> = bodies.iter().map(|b| Skin::new(grid, b.shape(), h)).collect();
        let oblong: Vec<u32> = (0..n as u32).filter(|k| !bodies[*k as usize].shape().is_round()).collect();
        let room = |k: usize| skins[k].cuts[0].capacity();
        let (faces, turning): (usize, usize) = ((0..n).map(room).sum(), oblong.iter().map(|k| room(*k as usize)).sum());
        let medium = Medium { density: fluid_density, viscosity: fluid_viscosity, spacing: h, ..Medium::default() };
        Sharp {
            values: Vec::with_capacity(skins.iter().map(|s| s.inside.capacity()).sum()),
            excess: Vec::with_capacity(skins.iter().map(|s| s.solid.capacity()).sum()),
            covered: std::array::from_fn(|_| Vec::with_capacity(faces)),
            entries: Vec::with_capacity(2 * D * faces + D * D * turning),
            weights: Vec::with_capacity((n + oblong.len()) * D),
            oblong,
            skins,
            near: (0..n).map(|_| Vec::with_capacity(16)).collect(),
            beside: Vec::with_capacity(16),
            had_near: vec![false; n],
            largest: bodies.iter().fold(0.0, |most, b| most.max(b.radius())),
            reach: vec![0.5 * gap::NEAR * h; n],
            neighbours: Box::new(Neighbours::new(&bodies, size, periods)),
            rides: vec![Ride::default(); n],
            exchange: vec![Exchange::default(); n],
            push: vec![Push::default(); n],
            before: bodies.iter().map(Before::here).collect(),
            shells: bodies.iter().map(|b| b.shape().shell()).collect(),
            deviations: vec![Vector3::zeros(); n],
            nudges: vec![Vector3::zeros(); n],
            passed_on: Vector3::zeros(),
            unpushed: vec![Vector3::zeros(); n],
            contacts: contacts.map(|c| c.within(&bodies, medium)),
            periods,
            h,
            fluid_density,
            fluid_viscosity,
            gravity,
            memory: grid.vector_field(),
            chi: 1.0,
            courant: 0.0,
            buffer: vec![0.0; n * NUMBERS],
            total: grid.field(),
            session: session.clone(),
            bodies,
        }
    }

    /// The bodies, in the case's order.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// What each body exchanged with the fluid in the last step.
    pub fn exchange(&self) -> &[Exchange] {
        &self.exchange
    }

    /// The law of contacts, where there is one.
    pub fn contacts(&self) -> Option<&Contacts> {
        self.contacts.as_ref()
    }

    /// Gravity (m/s2).
    pub fn gravity(&self) -> Vector3<f64> {
        self.gravity
    }

    /// Density of the fluid (kg/m3).
    pub fn fluid_density(&self) -> f64 {
        self.fluid_density
    }

    /// The cells of this rank that bodies touch.
    pub fn overlaps(&self) -> impl Iterator<Item = &Overlap> {
        self.skins.iter().flat_map(|s| &s.solid)
    }

    /// Builds the skins of all bodies and opens the faces. To be called once, before the first step, and whenever bodies
    /// have been put elsewhere.
    pub fn settle(&mut self, grid: &Grid<D>, boundaries: &Boundaries<D>, beta: &mut FaceCoefficient<D>) {
        self.before.iter_mut().zip(&self.bodies).for_each(|(before, body)| *before = Before::here(body));
        self.rebuild(grid, boundaries, beta, true);
    }

    /// Puts the bodies where `bodies` are (the same ones, at another time).
    pub fn place(
        &mut self,
        grid: &Grid<D>,
        boundaries: &Boundaries<D>,
        beta: &mut FaceCoefficient<D>,
        bodies: &[Body],
    ) {
        self.bodies.clone_from_slice(bodies);
        self.settle(grid, boundaries, beta);
    }

    /// Rebuilds the skins of the bodies that move, or of all, and sets `H/rho` on faces; `before` tells how they
    /// lay then.
    fn rebuild(&mut self, grid: &Grid<D>, boundaries: &Boundaries<D>, beta: &mut FaceCoefficient<D>, all: bool) {
        let FaceCoefficient::Field(beta) = beta else { return };
        let whole = 1.0 / self.fluid_density;
        self.covered.iter_mut().for_each(Vec::clear);
        for skin in &self.skins {
            for ((covered, beta), cuts) in self.covered.iter_mut().zip(beta.iter_mut()).zip(&skin.cuts) {
                // What two bodies cover is listed once: the sign says so.
                for face in cuts.iter().map(|cut| cut.face as usize) {
                    if beta[face] < 0.0 {
                        continue;
                    }
                    covered.push((face, beta[face] / whole));
                    beta[face] *= -1.0;
                }
            }
        }
        for skin in &self.skins {
            for (beta, cuts) in beta.iter_mut().zip(&skin.cuts) {
                cuts.iter().for_each(|cut| beta[cut.face as usize] = whole);
            }
        }
        self.find_near();
        for k in 0..self.bodies.len() {
            // What comes near a body at rest changes its probes.
            if !all && !self.bodies[k].moves() && self.near[k].is_empty() && !self.had_near[k] {
                continue;
            }
            self.beside.clear();
            self.beside.extend(self.near[k].iter().map(|&j| Neighbour::new(&self.bodies, k, j, &self.periods)));
            let (bodies, turn) = (&self.bodies[..], self.bodies[k].turn());
            let around = Surroundings { grid, boundaries, bodies, turn, near: &self.beside, h: self.h };
            self.skins[k].rebuild(&around, k, &self.before[k]);
        }
        self.open_faces(grid, boundaries, beta);
    }

    /// For each body, those within reach of its probes.
    fn find_near(&mut self) {
        for (had, near) in self.had_near.iter_mut().zip(&mut self.near) {
            *had = !near.is_empty();
            near.clear();
        }
        let near = &mut self.near;
        self.neighbours.sort(&self.bodies, 2.0 * self.largest + self.reach[0]);
        for i in 0..self.bodies.len() {
            self.neighbours.around(i, &self.bodies, &self.reach, |j| {
                near[i].push(j);
                near[j].push(i);
            });
        }
        // In the order of the bodies, so that sums do not depend on how they were found.
        near.iter_mut().for_each(|near| near.sort_unstable());
    }

    /// Whether a body is so near to a side of the box that its probes reach deep into the ghosts there.
    pub fn near_borders(&self, grid: &Grid<D>) -> bool {
        let near = |b: &Body, a: usize| {
            let reach = b.radius() + grid.ghosts as f64 * grid.h[a];
            b.centre[a] < reach || b.centre[a] > grid.size[a] - reach
        };
        self.bodies.iter().any(|b| (0..D).any(|a| near(b, a)))
    }

    /// Sets the velocity of the cells inside the bodies within the step: `part` of the way from `start`, at its start, to
    /// what was imposed last, at its end.
    pub fn impose_within(&self, part: f64, start: &VectorField<D>, u: &mut VectorField<D>) {
        let insides = self.skins.iter().flat_map(|skin| &skin.inside);
        for (inside, end) in insides.zip(&self.values) {
            for (a, (start, u)) in start.iter().zip(u.iter_mut()).enumerate() {
                let (cell, start) = (inside.cell as usize, start[inside.cell as usize]);
                u[cell] += inside.weight * (start + part * (end[a] - start) - u[cell]);
            }
        }
    }

    /// Sets the velocity of the cells inside the bodies; ghosts of `u` filled. With `fresh`, also that of cells which the
    /// bodies have just left. With `book`, the momentum that this adds is booked.
    pub fn impose(&mut self, grid: &Grid<D>, fresh: bool, book: bool, u: &mut VectorField<D>) {
        let (values, skins, bodies) = (&mut self.values, &self.skins, &self.bodies);
        values.clear();
        let resolved = RESOLVED * self.fluid_viscosity / (self.fluid_density * self.h);
        wide(
            #[inline(always)]
            || {
                for (k, skin) in skins.iter().enumerate() {
                    for inside in skin.inside.iter().filter(|i| fresh || !i.fresh) {
                        let rigid = bodies[k].velocity_at(&inside.arm);
                        let profile = skin.value(&inside.trace, &inside.arm, grid, u, bodies, k, Some(resolved));
                        values.push(rigid + profile);
                    }
                }
            },
        );
        let mass = self.fluid_density * grid.cell_volume();
        let mut values = self.values.iter();
        for (skin, ride) in self.skins.iter().zip(&mut self.rides) {
            for (inside, value) in skin.inside.iter().filter(|i| fresh || !i.fresh).zip(&mut values) {
                let (mut added, cell) = (Vector3::zeros(), inside.cell as usize);
                for (a, field) in u.iter_mut().enumerate() {
                    let change = inside.weight * (value[a] - field[cell]);
                    added[a] = mass * change;
                    field[cell] += change;
                }
                if book {
                    ride.given += added;
                    ride.spun += inside.arm.cross(&added);
                }
            }
        }
    }
}
