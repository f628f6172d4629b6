//! What sharp walls have of the past ([`crate::method::sharp`] has the formulas).

use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::grid::{Grid, VectorField};
use crate::params;
use crate::particles::Push;
use nalgebra::Vector3;

/// What lasts of sharp walls.
#[derive(Clone, Debug)]
pub struct WallHistory<const D: usize> {
    /// Velocity of the cells before the wall was imposed on it last (m/s).
    pub unimposed: VectorField<D>,
    /// Memory of the faces: their velocity beyond the mean of the cells' (m/s).
    pub memory: VectorField<D>,
    /// That of each body.
    pub bodies: Vec<BodyHistory>,
}

/// What lasts of a body in a fluid with sharp walls.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyHistory {
    /// Acceleration by fluid and gravity in the last step (m/s2, rad/s2).
    pub push: Push,
    /// Force of contacts, its mean over the last steps for as long as there are any (N); `None` for one that lay on something
    /// before its first step.
    pub pressed: Option<Vector3<f64>>,
    /// Wall shear's force and torque a step before (N, N m).
    pub shear: Option<(Vector3<f64>, Vector3<f64>)>,
    /// Force residual: what pressure and wall shear miss of what the fluid loses, taken in slowly (N).
    pub residual: Vector3<f64>,
    /// Deferred impulse: what the body has not felt yet of what the fluid lost (N s).
    pub deferred: Vector3<f64>,
    /// Momentum (kg m/s) and angular momentum (kg m2/s) of the cells inside the body.
    pub inside: (Vector3<f64>, Vector3<f64>),
}

impl BodyHistory {
    /// The part of a force of contacts (N) that lasts and is none of an impact, as the steps before show.
    pub fn lasting(&self, force: &Vector3<f64>) -> f64 {
        let (mean, size) = (mean_force(&self.pressed.unwrap_or_default(), force).norm(), force.norm());
        if size > params::lasting_force() * mean { params::lasting_force() * mean / size } else { 1.0 }
    }

    /// Takes note of the force of contacts (N) over a step; the part of it that lasts: all of it, where the body lay there before.
    pub fn press(&mut self, force: &Vector3<f64>) -> f64 {
        let lasting = self.pressed.map_or(1.0, |_| self.lasting(force));
        self.pressed = Some(self.pressed.map_or(*force, |mean| mean_force(&mean, force)));
        lasting
    }
}

/// The mean force of contacts after a step with this one (N).
fn mean_force(mean: &Vector3<f64>, force: &Vector3<f64>) -> Vector3<f64> {
    if *force == Vector3::zeros() { *force } else { mean + params::pressed_share() * (force - mean) }
}

impl<const D: usize> WallHistory<D> {
    /// Nothing has happened yet to so many bodies.
    pub fn new(grid: &Grid<D>, bodies: usize) -> WallHistory<D> {
        WallHistory {
            unimposed: grid.vector_field(),
            memory: grid.vector_field(),
            bodies: vec![BodyHistory::default(); bodies],
        }
    }

    /// Writes or reads all of it. Collective.
    ///
    /// # Errors
    /// When the archive holds another case.
    pub fn serialize(&mut self, grid: &Grid<D>, archive: &mut Archive) -> Result<()> {
        let WallHistory { unimposed, memory, bodies } = self;
        archive.each("histories", bodies)?;
        archive.faces(grid, memory)?;
        archive.label("velocity before the wall")?;
        archive.cells(grid, unimposed)
    }
}

impl Checkpointed for BodyHistory {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let BodyHistory { push, pressed, shear, residual, deferred, inside } = self;
        archive.serialize([push, pressed, shear, residual, deferred, inside])
    }
}
