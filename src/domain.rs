//! Where a scene takes place: what every method works with and no step changes but for scratch.

use crate::Result;
use crate::clock::Clock;
use crate::grid::{Boundaries, Grid};
use crate::kernels::faces::FaceCoefficient;
use crate::petsc::Session;
use crate::poisson::pressure::{BodyCoupling, Projected, Projection};
use crate::state::State;
use nalgebra::Vector3;

/// The fluid.
#[derive(Clone, Copy, Debug)]
pub struct Fluid {
    /// Density (kg/m3).
    pub density: f64,
    /// Viscosity (Pa s).
    pub viscosity: f64,
    /// Gravity (m/s2).
    pub gravity: Vector3<f64>,
}

/// The grid with its borders, the fluid, and what solves the pressure.
pub struct Domain<const D: usize> {
    /// The ranks.
    pub session: Session,
    /// The grid of this rank.
    pub grid: Grid<D>,
    /// Conditions at the borders.
    pub boundaries: Boundaries<D>,
    /// The fluid.
    pub fluid: Fluid,
    /// The pressure equation and its iteration.
    pub projection: Projection,
    /// Where the time goes.
    pub clock: Clock,
}

impl<const D: usize> Domain<D> {
    /// The lengths (m) of the periodic axes.
    pub fn periods(&self) -> [Option<f64>; 3] {
        std::array::from_fn(|a| (a < D && self.grid.periodic[a]).then(|| self.grid.size[a]))
    }

    /// (13-15): makes the velocity through faces free of divergence over the step `dt` (s), with `beta = 1/rho` on faces; `bodies`
    /// follow the pressure. Collective.
    ///
    /// # Errors
    /// As [`Projection::project`].
    pub fn project(
        &mut self,
        beta: &FaceCoefficient<D>,
        s: &mut State<D>,
        dt: f64,
        bodies: Option<&mut dyn BodyCoupling<D>>,
    ) -> Result<Projected> {
        let Domain { grid, boundaries, projection, .. } = self;
        projection.project(grid, boundaries, beta, dt, &mut s.p, &mut s.faces, bodies, None)
    }
}
