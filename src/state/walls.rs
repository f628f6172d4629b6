//! What sharp walls have of the past ([`crate::method::sharp`] has the formulas).

use super::support::Pressed;
use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::grid::{Grid, VectorField};
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
    /// What contacts have pressed it with.
    pub pressed: Pressed,
    /// Wall shear's force and torque a step before (N, N m).
    pub shear: Option<(Vector3<f64>, Vector3<f64>)>,
    /// Force residual: what pressure and wall shear miss of what the fluid loses, taken in slowly (N).
    pub residual: Vector3<f64>,
    /// Deferred impulse: what the body has not felt yet of what the fluid lost (N s).
    pub deferred: Vector3<f64>,
    /// Momentum (kg m/s) and angular momentum (kg m2/s) of the cells inside the body.
    pub inside: (Vector3<f64>, Vector3<f64>),
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
