//! What a step leaves to the next one, and all that follows from it.

use super::sharp::plain_acceleration;
use crate::coupling::Coupling;
use crate::scene::Scene;
use crate::tape::{Lasting, Tape};
use crate::{Error, Result};

impl<const D: usize> Scene<D> {
    /// Passes what lasts from step to step: after playing it, [`Scene::take_up`] finds the rest. Collective.
    ///
    /// # Errors
    /// When the tape plays another case.
    pub fn pass(&mut self, tape: &mut Tape) -> Result<()> {
        let Scene {
            grid,
            time,
            steps,
            dt_before,
            substeps,
            u,
            p,
            faces,
            faces_before,
            stage,
            coupling,
            audit,
            // Follow from these ([`Scene::take_up`]).
            density: _,
            viscosity: _,
            beta: _,
            gravity: _,
            acceleration: _,
            properties_stale: _,
            assembled: _,
            projection: _,
            // Found anew in every step.
            advection: _,
            total: _,
            fluxes: _,
            scratch: _,
            // The case's, and the process's.
            boundaries: _,
            scheme: _,
            solver_reason: _,
            border_rate: _,
            mix_pressure: _,
            cell_gradient: _,
            clock: _,
            session: _,
        } = self;
        tape.label("scene")?;
        tape.pass([time, steps, dt_before, substeps])?;
        tape.label("velocity")?;
        tape.cells(grid, u)?;
        tape.label("pressure")?;
        tape.cells(grid, std::slice::from_mut(p))?;
        tape.label("faces")?;
        tape.faces(grid, faces)?;
        if !faces_before[0].is_empty() {
            tape.label("faces before")?;
            tape.faces(grid, faces_before)?;
        }
        match coupling {
            None => tape.label("no particles")?,
            Some(Coupling::Mixing(coupling)) => coupling.pass(tape)?,
            Some(Coupling::Sharp(coupling)) => {
                coupling.pass(grid, tape)?;
                tape.label("velocity before the wall")?;
                tape.cells(grid, stage)?;
            }
        }
        if let Some(audit) = audit {
            tape.label("audit")?;
            audit.pass(tape)?;
        }
        Ok(())
    }

    /// Finds what follows from a state that has just been played: ghosts, what the particles touch, the mixture and its
    /// operator, the acceleration by the pressure. Collective.
    ///
    /// # Errors
    /// When a body is outside the box, or nothing could be played before.
    pub fn take_up(&mut self) -> Result<()> {
        let size: [f64; 3] = std::array::from_fn(|a| self.grid.size.get(a).copied().unwrap_or(f64::INFINITY));
        let bodies = self.coupling.iter().flat_map(Coupling::bodies).enumerate();
        let inside = |x: f64, size: f64| (0.0..=size).contains(&x);
        for (k, body) in bodies {
            if !(0..D).all(|a| inside(body.centre[a], size[a])) {
                return Err(Error::Usage(format!("it has particle {k} outside the box")));
            }
        }
        if self.time < 0.0 || self.dt_before < 0.0 {
            return Err(Error::Usage("its time runs backwards".into()));
        }
        self.boundaries.fill_velocity(&mut self.u)?;
        self.boundaries.fill_pressure(&mut self.p)?;
        match &mut self.coupling {
            Some(Coupling::Sharp(walls)) => {
                self.boundaries.fill_velocity(&mut self.stage)?;
                walls.take_up(&self.grid, &self.boundaries, &mut self.beta);
                self.projection.assemble(&self.grid, &self.beta)?;
                let (density, acceleration) = (self.density.at(0), &mut self.acceleration);
                plain_acceleration(&self.grid, &self.boundaries, density, &self.p, acceleration);
            }
            Some(Coupling::Mixing(coupling)) => {
                coupling.take_up(&self.grid);
                self.properties_stale = true;
                self.mix_properties()?;
                self.find_acceleration();
            }
            None => self.find_acceleration(),
        }
        self.clock = Default::default();
        Ok(())
    }
}
