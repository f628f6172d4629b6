//! The state lasts from one step to the next, and nothing else does: a step is a function of it.
//! Whatever else a method keeps can be dropped and made anew between any two steps, and is, when a
//! run goes on from a checkpoint.

mod balance;
mod energy;
mod exchange;
mod support;
mod surfaces;

use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::contact::Touching;
use crate::grid::{Grid, VectorField};
use crate::particles::Body;
pub use balance::{Balance, Impulses};
pub use energy::{EnergyBudget, EnergyLosses, SuppliedWork};
pub use exchange::Exchange;
use nalgebra::Vector3;
pub use support::MeanContactForce;
pub use surfaces::{BeforeForcing, BodyHistory, CutAt, SurfaceHistory};

/// The state of a scene. Fields have the layout of [`Grid::field`], with ghosts.
#[derive(Clone, Debug)]
pub struct State<const D: usize> {
    /// Time reached (s).
    pub time: f64,
    /// Steps done.
    pub steps: u64,
    /// The last step (s).
    pub dt: f64,
    /// Substeps of the contacts in the last step.
    pub substeps: usize,
    /// Velocity at cell centres (m/s), after the forcing by bodies.
    pub u: VectorField<D>,
    /// Pressure without its hydrostatic part (Pa).
    pub p: Vec<f64>,
    /// Velocity through faces (m/s), divergence-free to D0.
    pub faces: VectorField<D>,
    /// Face velocity of the step before (m/s); empty where the scheme carries with `faces` alone.
    pub faces_before: VectorField<D>,
    /// The bodies: first those there from the start, by their distance from the middle of the box
    /// then, next those that have come in, last the case's obstacles. [`Body::id`] is the number.
    pub bodies: Vec<Body>,
    /// Numbers of the bodies that have yet to come in, ascending.
    pub waiting: Vec<u64>,
    /// Exchange of each body with the fluid in the last step.
    pub exchange: Vec<Exchange>,
    /// Contacts that last; none where the scene has no law of contacts.
    pub touching: Touching,
    /// History of sharp surfaces; `None` with another method.
    pub surfaces: Option<SurfaceHistory<D>>,
    /// The force by which the fluid is driven (N/m3), uniform; `None` where nothing drives it.
    pub drive: Option<Vector3<f64>>,
    /// The balance of momentum; `None` where no body is free.
    pub balance: Option<Balance>,
    /// The budget of energy.
    pub energy: EnergyBudget,
}

/// The part of a state that readers of the results need.
#[derive(Clone, Debug)]
pub struct Readable<const D: usize> {
    /// Time (s).
    pub time: f64,
    /// Steps done.
    pub steps: u64,
    u: VectorField<D>,
    p: Vec<f64>,
    bodies: Vec<Body>,
}

impl<const D: usize> State<D> {
    /// Everything at rest, at time 0. With `extrapolates`, the faces of the step before are kept.
    pub fn new(grid: &Grid<D>, bodies: Vec<Body>, extrapolates: bool) -> State<D> {
        State {
            time: 0.0,
            steps: 0,
            dt: 0.0,
            substeps: 0,
            u: grid.vector_field(),
            p: grid.field(),
            faces: grid.vector_field(),
            faces_before: if extrapolates {
                grid.vector_field()
            } else {
                std::array::from_fn(|_| Vec::new())
            },
            exchange: vec![Exchange::default(); bodies.len()],
            bodies,
            waiting: Vec::new(),
            touching: Touching::default(),
            surfaces: None,
            drive: None,
            balance: None,
            energy: EnergyBudget::default(),
        }
    }

    /// Counts a step of `dt` (s).
    pub fn count(&mut self, dt: f64) {
        self.time += dt;
        self.dt = dt;
        self.steps += 1;
    }

    /// Whether a body is free, or one is to come in.
    pub fn has_free_bodies(&self) -> bool {
        self.bodies.iter().any(|body| body.freedom().is_some()) || !self.waiting.is_empty()
    }

    /// Whether it has other bodies than what was kept.
    pub fn differs(&self, kept: &Readable<D>) -> bool {
        !self.bodies.iter().map(|body| body.id).eq(kept.bodies.iter().map(|body| body.id))
    }

    /// Copies the part that readers need into `kept`: it takes a twentieth of a step.
    pub fn keep(&self, kept: &mut Readable<D>) {
        kept.time = self.time;
        kept.steps = self.steps;
        kept.u.clone_from(&self.u);
        kept.p.clone_from(&self.p);
        kept.bodies.clone_from(&self.bodies);
    }

    /// Brings back what [`State::keep`] copied: for readers, since a step needs more.
    pub fn restore(&mut self, kept: &Readable<D>) {
        self.time = kept.time;
        self.steps = kept.steps;
        self.u.clone_from(&kept.u);
        self.p.clone_from(&kept.p);
        self.bodies.clone_from(&kept.bodies);
    }

    /// Correction of the position of a body, which the next step begins with (m).
    pub fn displacement(&self, body: usize) -> Vector3<f64> {
        self.surfaces
            .as_ref()
            .map_or_else(Vector3::zeros, |surfaces| surfaces.bodies[body].displacement)
    }

    /// Writes or reads all of it. Collective.
    ///
    /// # Errors
    /// When the archive holds another case.
    pub fn serialize(&mut self, grid: &Grid<D>, archive: &mut Archive) -> Result<()> {
        let State {
            time,
            steps,
            dt,
            substeps,
            u,
            p,
            faces,
            faces_before,
            bodies,
            waiting,
            exchange,
            touching,
            surfaces,
            drive,
            balance,
            energy,
        } = self;
        archive.label("state")?;
        archive.serialize([time, steps, dt, substeps])?;
        archive.label("velocity")?;
        archive.cells(grid, u)?;
        archive.label("pressure")?;
        archive.cells(grid, std::slice::from_mut(p))?;
        archive.label("faces")?;
        archive.faces(grid, faces)?;
        if !faces_before[0].is_empty() {
            archive.label("faces before")?;
            archive.faces(grid, faces_before)?;
        }
        archive.each("bodies", bodies)?;
        archive.label("waiting")?;
        waiting.serialize(archive)?;
        archive.each("exchange", exchange)?;
        archive.label("contacts")?;
        touching.serialize(archive)?;
        if let Some(surfaces) = surfaces {
            archive.label("sharp walls")?;
            surfaces.serialize(grid, u, archive)?;
        }
        if let Some(drive) = drive {
            archive.label("drive")?;
            drive.serialize(archive)?;
        }
        if let Some(balance) = balance {
            archive.label("balance")?;
            balance.serialize(archive)?;
        }
        archive.label("energy")?;
        energy.serialize(archive)
    }
}

impl<const D: usize> Default for Readable<D> {
    fn default() -> Self {
        let u = std::array::from_fn(|_| Vec::new());
        Readable { time: 0.0, steps: 0, u, p: Vec::new(), bodies: Vec::new() }
    }
}
