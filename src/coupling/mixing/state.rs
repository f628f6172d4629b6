//! What lasts of the mixing from one step to the next.

use super::Mixing;
use crate::Result;
use crate::grid::Grid;
use crate::tape::{Lasting, Tape};

impl<const D: usize> Lasting for Mixing<D> {
    fn pass(&mut self, tape: &mut Tape) -> Result<()> {
        let Mixing {
            bodies,
            exchange,
            contacts,
            // Follow from the bodies' places ([`Mixing::take_up`]).
            overlaps: _,
            // Found anew in every step.
            kicks: _,
            departures: _,
            push: _,
            settled: _,
            struck: _,
            buffer: _,
            // The case's.
            choices: _,
            fluid_density: _,
            fluid_viscosity: _,
            periods: _,
            session: _,
        } = self;
        tape.label("mixing")?;
        tape.each("bodies", bodies)?;
        tape.each("exchange", exchange)?;
        if let Some(contacts) = contacts {
            tape.label("contacts")?;
            contacts.pass(tape)?;
        }
        Ok(())
    }
}

impl<const D: usize> Mixing<D> {
    /// Finds what follows from the bodies' places after they have been played.
    pub fn take_up(&mut self, grid: &Grid<D>) {
        self.find_overlaps(grid, |_| true);
    }
}
