//! What lasts of sharp walls from one step to the next.

use super::{Ride, Sharp};
use crate::Result;
use crate::fluid::faces::FaceCoefficient;
use crate::grid::{Boundaries, Grid};
use crate::archive::{Checkpointed, Archive};

impl Checkpointed for Ride {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Ride {
            push,
            shear_before,
            rest,
            owed,
            inside,
            swirl,
            // Found anew in every step.
            start: _,
            expected: _,
            turned: _,
            inertia: _,
            turns: _,
            pressure: _,
            pressure_torque: _,
            shear: _,
            given: _,
            missed: _,
            used: _,
            spun: _,
        } = self;
        archive.serialize([push, shear_before, rest, owed, inside, swirl])
    }
}

impl<const D: usize> Sharp<D> {
    /// Passes what lasts. Collective.
    pub fn serialize(&mut self, grid: &Grid<D>, archive: &mut Archive) -> Result<()> {
        let Sharp {
            bodies,
            rides,
            exchange,
            contacts,
            memory,
            // Follow from the bodies' places ([`Sharp::take_up`]); faces opened in a step are found in it.
            skins: _,
            near: _,
            beside: _,
            had_near: _,
            neighbours: _,
            covered: _,
            // Found anew in every step.
            push: _,
            before: _,
            deviations: _,
            nudges: _,
            unpushed: _,
            passed_on: _,
            values: _,
            excess: _,
            chi: _,
            courant: _,
            weights: _,
            entries: _,
            buffer: _,
            total: _,
            // The case's.
            periods: _,
            h: _,
            largest: _,
            reach: _,
            oblong: _,
            shells: _,
            fluid_density: _,
            fluid_viscosity: _,
            gravity: _,
            session: _,
        } = self;
        archive.label("sharp walls")?;
        archive.each("bodies", bodies)?;
        archive.each("rides", rides)?;
        archive.each("exchange", exchange)?;
        if let Some(contacts) = contacts {
            archive.label("contacts")?;
            contacts.serialize(archive)?;
        }
        archive.faces(grid, memory)
    }

    /// Finds what follows from the bodies' places after they have been played.
    pub fn take_up(&mut self, grid: &Grid<D>, boundaries: &Boundaries<D>, beta: &mut FaceCoefficient<D>) {
        self.settle(grid, boundaries, beta);
        // What the old places covered is no history of this run.
        self.covered.iter_mut().for_each(Vec::clear);
    }
}
