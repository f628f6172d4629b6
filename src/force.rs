//! Forces per volume on the fluid that vary in space and time: a term of the prediction (7).
//!
//! ```text
//!   u* = u + dt [ ... + f(x, t + dt/2, u)/rho ]     in cells; u the velocity at the step's start
//!   (1 - alpha) f dV                                is the fluid's,
//!   alpha f dV                                      in a body of a sharp surface: nobody's
//! ```
//! A body feels such a force through the pressure and the wall shear alone. In time the method is
//! of second order for forces of place and time, of first order for those of the velocity. A
//! uniform force that acts as a mean gradient of the pressure, and one that holds a mean velocity,
//! are a [`drive`](crate::drive): these are solved for together with the pressure.

use crate::Result;
use crate::geometry::Overlap;
use crate::grid::{Coefficient, Grid, VectorField};
use crate::petsc::Session;
use nalgebra::Vector3;
use std::sync::Arc;

/// A force per volume on the fluid.
pub trait Force: Send + Sync {
    /// The force (N/m3) at a place (m) and a time (s) on fluid that has a velocity (m/s). In 2D the
    /// third components are zero, and that of the force does not count.
    fn at(&self, place: &Vector3<f64>, time: f64, velocity: &Vector3<f64>) -> Vector3<f64>;
}

/// The forces of a scene and their sum in a step.
pub struct Forces<const D: usize> {
    all: Vec<Arc<dyn Force>>,
    /// Their sum at cells (N/m3).
    field: VectorField<D>,
    /// Its largest value on this rank (N/m3).
    largest: f64,
    /// Its sum over the fluid outside the bodies, of all ranks (N).
    on_fluid: Vector3<f64>,
}

impl<const D: usize> Forces<D> {
    /// The given forces on a grid; `None` where there are none.
    pub fn new(grid: &Grid<D>, all: Vec<Arc<dyn Force>>) -> Option<Forces<D>> {
        (!all.is_empty()).then(|| Forces {
            all,
            field: grid.vector_field(),
            largest: 0.0,
            on_fluid: Vector3::zeros(),
        })
    }

    /// The forces themselves.
    pub fn into_all(self) -> Vec<Arc<dyn Force>> {
        self.all
    }

    /// Takes their sum at a time (s), on fluid of the velocity `u` (m/s).
    pub fn take(&mut self, grid: &Grid<D>, u: &VectorField<D>, time: f64) {
        self.largest = 0.0;
        for c in grid.rows().flatten() {
            let place = Vector3::from_fn(|a, _| if a < D { grid.centre(c)[a] } else { 0.0 });
            let velocity = Vector3::from_fn(|a, _| if a < D { u[a][c] } else { 0.0 });
            let sum: Vector3<f64> =
                self.all.iter().map(|force| force.at(&place, time, &velocity)).sum();
            for (a, field) in self.field.iter_mut().enumerate() {
                field[c] = sum[a];
                self.largest = self.largest.max(sum[a].abs());
            }
        }
    }

    /// Adds their acceleration of fluid of a density (kg/m3), times a weight, to a rate (m/s2).
    pub fn add_to(
        &self,
        grid: &Grid<D>,
        weight: f64,
        density: &Coefficient,
        rate: &mut VectorField<D>,
    ) {
        for (rate, field) in rate.iter_mut().zip(&self.field) {
            for c in grid.rows().flatten() {
                rate[c] += weight * field[c] / density.at(c);
            }
        }
    }

    /// Hands what lies in each of the bodies (N), which come with their numbers, cell by cell with
    /// the arm from its centre (m), to `take`, and keeps the sum of what the fluid has. Collective.
    ///
    /// # Errors
    /// When ranks cannot sum.
    pub fn share<'a>(
        &mut self,
        session: &Session,
        grid: &Grid<D>,
        bodies: impl Iterator<Item = (usize, &'a [Overlap])>,
        mut take: impl FnMut(usize, &Vector3<f64>, &Vector3<f64>),
    ) -> Result<()> {
        let volume = grid.cell_volume();
        let at = |c: usize| Vector3::from_fn(|a, _| if a < D { self.field[a][c] } else { 0.0 });
        let mut sum: Vector3<f64> = volume * grid.rows().flatten().map(at).sum::<Vector3<f64>>();
        for (k, overlaps) in bodies {
            for overlap in overlaps {
                let inside = volume * overlap.fraction * at(overlap.cell);
                take(k, &overlap.arm, &inside);
                sum -= inside;
            }
        }
        session.sum(sum.as_mut_slice())?;
        self.on_fluid = sum;
        Ok(())
    }

    /// This rank's part of their power on fluid of the velocity `u` (m/s) outside the bodies (W).
    pub fn power(
        &self,
        grid: &Grid<D>,
        u: &VectorField<D>,
        overlaps: &mut dyn Iterator<Item = &Overlap>,
    ) -> f64 {
        let at = |c: usize| self.field.iter().zip(u).map(|(f, u)| f[c] * u[c]).sum::<f64>();
        let inside: f64 = overlaps.map(|overlap| overlap.fraction * at(overlap.cell)).sum();
        grid.cell_volume() * (grid.rows().flatten().map(at).sum::<f64>() - inside)
    }

    /// The largest component on this rank (N/m3).
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// Sum of the forces on the fluid outside the bodies (N), as [`Forces::share`] found it.
    pub fn on_fluid(&self) -> Vector3<f64> {
        self.on_fluid
    }
}
