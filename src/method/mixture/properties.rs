//! The properties of the mixture, by what bodies fill of the cells:
//!
//! ```text
//!   rho = rho_f + sum_k alpha_k (rho_k - rho_f)                    (1), viscosity alike
//! ```

use super::MixtureMethod;
use crate::Result;
use crate::clock::Stage;
use crate::domain::Domain;
use crate::geometry::Overlap;
use crate::grid::{Boundaries, Coefficient};
use crate::particles::Body;
use crate::state::State;

impl<const D: usize> MixtureMethod<D> {
    /// Density and viscosity of the mixture, `1/rho` on faces, and what the drive acts on.
    /// Collective.
    pub(super) fn mix_fields(&mut self, domain: &mut Domain<D>, s: &State<D>) -> Result<()> {
        let Domain { grid, boundaries, fluid, clock, .. } = domain;
        let flow = &mut self.flow;
        let overlaps = &self.overlaps;
        mix(boundaries, &s.bodies, overlaps, &mut flow.mixture.density, fluid.density, |b| {
            b.density
        })?;
        mix(boundaries, &s.bodies, overlaps, &mut flow.mixture.viscosity, fluid.viscosity, |b| {
            b.viscosity
        })?;
        flow.beta.update(grid, &flow.mixture.density);
        if let Some(solid) = &mut flow.solid {
            solid.fill(0.0);
            overlaps
                .iter()
                .flatten()
                .for_each(|o| solid[o.cell] = (solid[o.cell] + o.fraction).min(1.0));
            boundaries.fill_property(solid)?;
        }
        clock.lap(Stage::Properties);
        Ok(())
    }
}

/// A property by (1), with its ghosts, where it is a field. Collective.
fn mix<const D: usize>(
    boundaries: &mut Boundaries<D>,
    bodies: &[Body],
    overlaps: &[Vec<Overlap>],
    property: &mut Coefficient,
    of_fluid: f64,
    of_body: impl Fn(&Body) -> f64,
) -> Result<()> {
    let Coefficient::Field(field) = property else { return Ok(()) };
    field.fill(of_fluid);
    for (body, overlaps) in bodies.iter().zip(overlaps) {
        for o in overlaps {
            field[o.cell] += o.fraction * (of_body(body) - of_fluid);
        }
    }
    // Where bodies in contact overlap, a cell holds more than its volume of what is less than the
    // fluid.
    let least = bodies.iter().map(&of_body).fold(of_fluid, f64::min);
    for o in overlaps.iter().flatten() {
        field[o.cell] = field[o.cell].max(least);
    }
    boundaries.fill_property(field)
}
