//! The force on each particle as printed, (19), in its three parts.

use super::Mics2003;
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
    fluid_density: f64,
    bodies: &[Body],
    overlaps: &[Vec<Overlap>],
    (term, sign, rate): (Term, f64, &VectorField<D>),
    exchange: &mut [Exchange],
) {
    let volume = sign * grid.cell_volume();
    for ((body, overlaps), exchange) in bodies.iter().zip(overlaps).zip(exchange) {
        let (mut flux, mut swirl, mut swirl_at_boundary) =
            (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
        for o in overlaps {
            let a = (volume * o.fraction) * vector(rate, o.cell);
            let turn = o.arm.cross(&a);
            flux += a;
            swirl += turn;
            if o.is_cut() {
                swirl_at_boundary += turn;
            }
        }
        match term {
            Term::Convective => {
                let excess = body.density - fluid_density;
                exchange.convective += body.density * flux;
                exchange.excess_momentum += excess * flux;
                exchange.excess_torque += excess * swirl;
            }
            Term::Viscous => exchange.viscous += body.density * flux,
        }
        exchange.literal_torque += body.density * swirl_at_boundary;
    }
}

impl<const D: usize> Mics2003<D> {
    /// Adds the pressure part of (19), the gradient taken at cells as (16) takes it: by the mean of
    /// the accelerations on a cell's faces, less gravity and contacts, which they contain, or,
    /// where the case says so, from the pressure of the cells.
    pub(super) fn sum_pressure_force(&self, domain: &mut Domain<D>, s: &mut State<D>) {
        let (grid, flow, volume) = (&domain.grid, &self.flow, domain.grid.cell_volume());
        for ((body, overlaps), exchange) in s.bodies.iter().zip(&self.overlaps).zip(&mut s.exchange)
        {
            for o in overlaps {
                let a = Vector3::from_fn(|axis, _| {
                    if axis >= D {
                        return 0.0;
                    }
                    if flow.cell_gradient {
                        let driven = domain.felt(&s.drive, 1.0)[axis];
                        return (driven - faces::cell_gradient(grid, axis, o.cell, &s.p))
                            / flow.mixture.density.at(o.cell);
                    }
                    let given = |f| {
                        flow.force.as_ref().map_or(0.0, |force| force.at(grid, &flow.beta, axis, f))
                    };
                    let own = |f: usize| flow.acceleration[axis][f] - given(f);
                    0.5 * (own(o.cell) + own(o.cell + grid.stride[axis]))
                });
                let df = (volume * o.fraction * body.density) * a;
                exchange.pressure += df;
                if o.is_cut() {
                    exchange.literal_torque += o.arm.cross(&df);
                }
            }
        }
        domain.clock.lap(Stage::Force);
    }
}
