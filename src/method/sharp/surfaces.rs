//! The surfaces of bodies within the stages of a step.

use super::cut::CutBodies;
use crate::Result;
use crate::clock::Stage;
use crate::domain::Domain;
use crate::grid::VectorField;
use crate::method::prediction::{Walls, Within};
use crate::particles::{Impulse, velocities};
use crate::state::State;

/// The surfaces of bodies within the stages of a step. The bodies are at the step's end, and a
/// Legendre stage at the time c of it has inside them what is imposed there and `1 - c` of what the
/// start had beyond that: no cell jumps at once.
pub struct Surfaces<'a, const D: usize> {
    /// The bodies as they cut the grid.
    pub cut: &'a mut CutBodies<D>,
    /// Momentum that the step gives to the cells of each.
    pub exchanged: &'a mut Vec<Impulse>,
}

impl<const D: usize> Walls<D> for Surfaces<'_, D> {
    const PRESSURE: f64 = 1.0;

    fn finish(
        &mut self,
        domain: &mut Domain<D>,
        s: &State<D>,
        within: Within,
        dt: f64,
        u: &mut VectorField<D>,
    ) -> Result<()> {
        let Surfaces { cut, exchanged } = self;
        match within {
            Within::Stage(part) => {
                super::acceleration::add_cut_cells(cut, domain, part * dt, None, u);
                if part == 1.0 {
                    domain.boundaries.fill_velocity(u)?;
                    cut.set_ghost_cells(domain, velocities(&s.bodies), true, None, u);
                } else {
                    cut.set_ghost_cells_within(part, &s.u, u);
                }
                domain.clock.lap(Stage::Mixing);
                domain.boundaries.fill_stencils(u)?;
                domain.clock.lap(Stage::Ghosts);
            }
            Within::Legendre(stage) => {
                super::acceleration::add_cut_cells(cut, domain, stage.part() * dt, None, u);
                if stage.weight != 0.0 {
                    domain.boundaries.fill_velocity(u)?;
                    cut.find_targets(domain, velocities(&s.bodies), true, u);
                    cut.add_offsets(1.0 - stage.time);
                    cut.apply_targets(domain, true, Some((stage.remains, exchanged)), u);
                    domain.boundaries.fill_imposed(u)?;
                }
                domain.clock.lap(Stage::Mixing);
            }
            // Ghost cells belong to the velocity with its pressure.
            Within::End => super::acceleration::add_cut_cells(cut, domain, dt, None, u),
        }
        Ok(())
    }
}
