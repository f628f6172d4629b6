//! The force on a body, four ways: by pressure, by wall shear, by what both miss, and by what the fluid loses (formulas in
//! the parent).

use super::{Sharp, TAKE_IN};
use crate::Result;
use crate::coupling::vector;
use crate::grid::{Grid, VectorField};
use nalgebra::Vector3;

impl<const D: usize> Sharp<D> {
    /// This rank's pressure force on the body `k` by a pressure (Pa) with its ghosts filled: every face counts on the rank
    /// of the cell above it.
    pub(super) fn pressure_force(&self, grid: &Grid<D>, k: usize, p: &[f64]) -> Vector3<f64> {
        let mut force = Vector3::zeros();
        for axis in 0..D {
            let (s, area) = (grid.stride[axis], grid.cell_volume() / grid.h[axis]);
            for cut in self.skins[k].cuts[axis].iter().filter(|cut| grid.owns_cell(cut.face)) {
                force[axis] += area * cut.covered * (p[cut.face - s] - p[cut.face]);
            }
        }
        force
    }

    /// This rank's force and torque by wall shear; ghosts of `u` filled.
    pub(super) fn shear_force(&self, grid: &Grid<D>, k: usize, u: &VectorField<D>) -> (Vector3<f64>, Vector3<f64>) {
        let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
        let skin = &self.skins[k];
        for point in &skin.points {
            let slope = skin.value(&point.slope, grid, u, &self.bodies, k);
            let df = (self.fluid_viscosity * point.area) * slope;
            force += df;
            torque += point.arm.cross(&df);
        }
        (force, torque)
    }

    /// This rank's part of the momentum inside the body `k`, relative to its own motion (kg m/s).
    fn momentum_inside(&self, grid: &Grid<D>, k: usize, u: &VectorField<D>) -> Vector3<f64> {
        let mass = self.fluid_density * grid.cell_volume();
        let velocity = self.bodies[k].velocity;
        self.skins[k].solid.iter().map(|o| (mass * o.fraction) * (vector(u, o.cell) - velocity)).sum()
    }

    /// Forgets all that forces remember, and takes the momentum inside the bodies. Collective.
    pub fn start_forces(&mut self, grid: &Grid<D>, u: &VectorField<D>) -> Result<()> {
        for ride in &mut self.rides {
            (ride.rest, ride.owed, ride.shear_before) = (Vector3::zeros(), Vector3::zeros(), None);
        }
        self.start_books();
        self.close_books(grid, u, 1.0)?;
        for ride in &mut self.rides {
            (ride.rest, ride.owed) = (Vector3::zeros(), Vector3::zeros());
        }
        self.exchange.iter_mut().for_each(|e| *e = Default::default());
        Ok(())
    }

    /// Starts the step's sums.
    pub fn start_books(&mut self) {
        for ride in &mut self.rides {
            (ride.imposed, ride.gradient) = (Vector3::zeros(), Vector3::zeros());
        }
    }

    /// Closes the step `dt` (s): what each body exchanged with the fluid, and what it takes in of what it missed. Collective.
    pub fn close_books(&mut self, grid: &Grid<D>, u: &VectorField<D>, dt: f64) -> Result<()> {
        let mut buffer = std::mem::take(&mut self.buffer);
        for (k, row) in buffer.chunks_exact_mut(9).enumerate() {
            let ride = &self.rides[k];
            for (slot, v) in
                row.chunks_exact_mut(3).zip([ride.imposed, ride.gradient, self.momentum_inside(grid, k, u)])
            {
                slot.copy_from_slice(v.as_slice());
            }
        }
        self.session.sum(&mut buffer)?;
        let take_in = (self.chi * super::FORGET / TAKE_IN).min(1.0);
        for (k, row) in buffer.chunks_exact(9).enumerate() {
            let [imposed, gradient, inside] = [0, 3, 6].map(|n| Vector3::from_column_slice(&row[n..n + 3]));
            let (body, ride) = (&self.bodies[k], &mut self.rides[k]);
            let inside = inside + self.fluid_density * body.volume() * body.velocity;
            let lost = (inside - ride.inside - imposed - gradient) / dt;
            ride.inside = inside;
            let felt = ride.pressure + ride.shear.0 + ride.rest;
            let used = match body.freedom() {
                None => felt,
                Some(freedom) => {
                    let moved = ride.used(
                        body,
                        dt,
                        self.fluid_density,
                        &self.gravity,
                        self.contacts.as_ref().map(|c| c.impulses()[k]),
                    );
                    felt - freedom.along(&felt) + freedom.along(&moved)
                }
            };
            ride.owed += dt * (lost - used);
            let missing = lost - ride.pressure - ride.shear.0 - ride.rest;
            self.exchange[k].momentum = used;
            self.exchange[k].momentum_torque = ride.shear.1;
            self.exchange[k].pressure = ride.pressure;
            self.exchange[k].viscous = ride.shear.0;
            self.exchange[k].convective = used - ride.pressure - ride.shear.0;
            self.exchange[k].literal_torque = ride.shear.1;
            let struck = self.contacts.as_ref().map(|c| c.impulses()[k]).unwrap_or_default();
            self.exchange[k].contact = struck.linear / dt;
            ride.rest += take_in * missing;
        }
        self.buffer = buffer;
        Ok(())
    }
}
