//! The force on each particle as printed, (19), in its three parts.

use super::MixtureMethod;
use crate::clock::Stage;
use crate::domain::Domain;
use crate::geometry::Overlap;
use crate::grid::{Grid, VectorField};
use crate::kernels::faces;
use crate::method::momentum::Term;
use crate::method::vector;
use crate::particles::Body;
use crate::state::{Exchange, State};
use nalgebra::Vector3;

/// Adds `sign` times the force of a field of accelerations (m/s2) on the cells to the part of (19)
/// that belongs to a term: called before the term with -1 and after it with 1, this takes what the
/// term added.
pub(super) fn add_force<const D: usize>(
    grid: &Grid<D>,
    bodies: &[Body],
    overlaps: &[Vec<Overlap>],
    term: Term,
    sign: f64,
    rate: &VectorField<D>,
    exchange: &mut [Exchange],
) {
    let volume = sign * grid.cell_volume();
    for ((body, overlaps), exchange) in bodies.iter().zip(overlaps).zip(exchange) {
        let mut flux = Vector3::zeros();
        let mut swirl = Vector3::zeros();
        for o in overlaps {
            let a = (volume * o.fraction) * vector(rate, o.cell);
            flux += a;
            if o.is_cut() {
                swirl += o.arm.cross(&a);
            }
        }
        match term {
            Term::Convective => exchange.remainder += body.density * flux,
            Term::Viscous => exchange.viscous += body.density * flux,
        }
        exchange.literal_torque += body.density * swirl;
    }
}

impl<const D: usize> MixtureMethod<D> {
    /// Adds the pressure part of (19), the gradient taken at cells as (16) takes it.
    pub(super) fn sum_pressure_force(&self, domain: &mut Domain<D>, s: &mut State<D>) {
        let grid = &domain.grid;
        let density = &self.flow.mixture.density;
        let driven = domain.felt(&s.drive, 1.0);
        for ((body, overlaps), exchange) in s.bodies.iter().zip(&self.overlaps).zip(&mut s.exchange)
        {
            for o in overlaps {
                let mut a = Vector3::zeros();
                for axis in 0..D {
                    let gradient = faces::cell_gradient(grid, axis, o.cell, &s.p);
                    a[axis] = (driven[axis] - gradient) / density.at(o.cell);
                }
                let df = (grid.cell_volume() * o.fraction * body.density) * a;
                exchange.pressure += df;
                if o.is_cut() {
                    exchange.literal_torque += o.arm.cross(&df);
                }
            }
        }
        domain.clock.lap(Stage::Force);
    }
}
