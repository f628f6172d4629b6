//! The domain of a scene, which every method works with and no step changes but for scratch.

use crate::Result;
use crate::clock::Clock;
use crate::drive::{self, Drive, Driving};
use crate::force::Forces;
use crate::grid::{Boundaries, Grid, VectorField};
use crate::kernels::faces::FaceCoefficient;
use crate::petsc::Session;
use crate::poisson::pressure::{Accuracy, Coupled, Projected, Projection};
use crate::state::State;
use crate::varying::Varying;
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

/// The grid with its boundaries, the fluid, and what solves the pressure.
pub struct Domain<const D: usize> {
    /// The ranks.
    pub session: Session,
    /// The grid of this rank.
    pub grid: Grid<D>,
    /// Conditions at the boundaries.
    pub boundaries: Boundaries<D>,
    /// Whether a side of the box, on any rank, can do work on the fluid.
    pub sides_work: bool,
    /// The fluid.
    pub fluid: Fluid,
    /// Drive that moves it besides the boundaries.
    pub drive: Option<Drive>,
    /// Boundaries and drive that vary over time, which [`Domain::set_time`] sets.
    pub varying: Varying<D>,
    /// Forces on it that vary in space and time; `None` where there are none.
    pub forces: Option<Forces<D>>,
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

    /// Gives boundaries and a mean velocity that is held what they have at a time (s).
    pub fn set_time(&mut self, time: f64) {
        self.varying.set(|factor| factor.at(time), &mut self.boundaries, &mut self.drive);
    }

    /// Takes the forces that vary, at a time (s), on fluid of the velocity `u` (m/s).
    pub fn take_forces(&mut self, u: &VectorField<D>, time: f64) {
        if let Some(forces) = &mut self.forces {
            forces.take(&self.grid, u, time);
        }
    }

    /// The force of the drive on the fluid (N/m3) before the first step; `None` where nothing
    /// drives it.
    pub fn drive_at_start(&self) -> Option<Vector3<f64>> {
        self.drive.as_ref().map(Drive::at_start)
    }

    /// Part (N) of a force on the fluid (N/m3), taken up by a body's cells, that it does not feel.
    pub fn unfelt(&self, force: &Option<Vector3<f64>>, volume: f64) -> Vector3<f64> {
        let felt =
            |(drive, force): (&Drive, &Vector3<f64>)| volume * force - drive.on_body(force, volume);
        self.drive.as_ref().zip(force.as_ref()).map_or_else(Vector3::zeros, felt)
    }

    /// Part (N) that a body feels of that force besides the pressure.
    pub fn felt(&self, force: &Option<Vector3<f64>>, volume: f64) -> Vector3<f64> {
        let felt = |(drive, force): (&Drive, &Vector3<f64>)| drive.on_body(force, volume);
        self.drive.as_ref().zip(force.as_ref()).map_or_else(Vector3::zeros, felt)
    }

    /// The force of the drive on fluid and bodies together, and of other forces on the fluid (N).
    pub fn driving_force(&self, s: &State<D>) -> Vector3<f64> {
        let on_fluid = self.forces.as_ref().map_or_else(Vector3::zeros, Forces::on_fluid);
        let Some(force) = s.drive else { return on_fluid };
        let unfelt = s.bodies.iter().map(|body| self.unfelt(&s.drive, body.volume()));
        drive::box_volume(&self.grid) * force - unfelt.sum::<Vector3<f64>>() + on_fluid
    }

    /// Power of the drive (W), by the mean velocity of everything in the box. Collective.
    pub fn driving_power(&self, s: &State<D>) -> Result<f64> {
        let Some(force) = s.drive else { return Ok(0.0) };
        let mut power = 0.0;
        for axis in (0..D).filter(|axis| force[*axis] != 0.0) {
            let mean = drive::mean(&self.session, &self.grid, axis, &s.faces)?;
            power += drive::box_volume(&self.grid) * force[axis] * mean;
        }
        let unfelt =
            s.bodies.iter().map(|body| self.unfelt(&s.drive, body.volume()).dot(&body.velocity));
        Ok(power - unfelt.sum::<f64>())
    }

    /// (13-15): makes the velocity through faces free of divergence over the step `dt` (s), with
    /// `beta = 1/rho` on faces; the drive follows the pressure, and bodies keep their velocity.
    /// Collective.
    ///
    /// # Errors
    /// As [`Projection::project`].
    pub fn project(
        &mut self,
        beta: &FaceCoefficient<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<Projected> {
        let inverse_density = self.hold(beta, std::iter::empty())?;
        let Domain { session, grid, boundaries, projection, drive, .. } = self;
        let State { p, faces, drive: force, .. } = s;
        let Some((drive, force)) = drive.as_ref().zip(force.as_mut()) else {
            return projection.project(grid, boundaries, beta, dt, p, faces, Accuracy::Full);
        };
        let driving = Driving { drive, force, beta, inverse_density, session };
        projection.project(
            grid,
            boundaries,
            beta,
            dt,
            p,
            &mut Driven { driving, faces },
            Accuracy::Full,
        )
    }

    /// Gives the pressure equation the response to the pressure of a drive that holds a mean
    /// velocity; `carried` are the faces along its axis through which bodies go as it changes, how
    /// much (m3/kg), and whether the face counts on this rank. Returns the mean response (m3/kg; C
    /// of [`crate::drive`]), 0 for another drive. Collective.
    ///
    /// # Errors
    /// When the solver would pass over this.
    pub fn hold(
        &mut self,
        beta: &FaceCoefficient<D>,
        carried: impl Iterator<Item = (usize, f64, bool)> + Clone,
    ) -> Result<f64> {
        let Some(axis) = self.drive.as_ref().and_then(Drive::held) else { return Ok(0.0) };
        let grid = &self.grid;
        let cells = grid.total_cells() as f64;
        let mut with_bodies = [carried.clone().filter(|c| c.2).map(|c| c.1).sum::<f64>() / cells];
        self.session.sum(&mut with_bodies)?;
        let inverse_density =
            drive::mean_coefficient(&self.session, grid, axis, beta)? + with_bodies[0];
        if let FaceCoefficient::Field(beta) = beta {
            let beta = &beta[axis];
            let whole = 1.0 / self.fluid.density;
            let less = grid
                .face_rows(axis)
                .flatten()
                .filter(|f| beta[*f] != whole)
                .map(|f| (f, whole - beta[f]));
            let faces = less.chain(carried.map(|(face, part, _)| (face, -part)));
            self.projection.set_held(
                axis,
                grid.h[axis],
                faces,
                -1.0 / (cells * inverse_density),
            )?;
        }
        Ok(inverse_density)
    }
}

/// A drive while the pressure is found, of a fluid whose bodies keep their velocity.
struct Driven<'a, const D: usize> {
    driving: Driving<'a, D>,
    faces: &'a mut VectorField<D>,
}

impl<const D: usize> Coupled<D> for Driven<'_, D> {
    fn faces(&mut self) -> &mut VectorField<D> {
        self.faces
    }

    fn begin(&mut self, grid: &Grid<D>, dt: f64) -> Result<()> {
        self.driving.follow(grid, dt, self.faces).map(drop)
    }

    fn follow(&mut self, grid: &Grid<D>, dt: f64, _: &[f64]) -> Result<()> {
        self.begin(grid, dt)
    }
}
