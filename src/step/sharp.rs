//! A step with sharp walls ([`crate::coupling::sharp`] has the formulas).

use super::copy_rows;
use crate::Result;
use crate::clock::Stage;
use crate::coupling::Coupling;
use crate::coupling::sharp::Sharp;
use crate::fluid::border;
use crate::fluid::faces::{self, FaceCoefficient};
use crate::fluid::pressure::Projected;
use crate::grid::{Boundaries, Grid, VectorField};
use crate::scene::Scene;

impl<const D: usize> Scene<D> {
    pub(super) fn step_sharp(&mut self, dt: f64) -> Result<Projected> {
        self.go_ahead(dt)?; //                  (17, 18, 20-26) bodies to their new place, faces open there
        self.predict_cells_sharp(dt)?; //       (7)      u* without pressure, the wall imposed
        self.predict_faces_sharp(dt)?; //       (8)      U = H q + m U_b.n; bodies by all forces but the new pressure
        let projected = self.project_sharp(dt)?; // (13-15) C-HSMAC: |D| < D0, bodies riding along
        self.correct_cells_sharp(dt)?; //       (16)     u = u* - dt/rho grad p, the wall imposed
        self.close_sharp(dt)?; //               (19)     the force: what the fluid lost
        self.count_step(dt);
        Ok(projected)
    }

    /// A consistent start from the cell velocities, as [`Scene::start`].
    pub(crate) fn start_sharp(&mut self) -> Result<()> {
        self.p.fill(0.0);
        let Some(Coupling::Sharp(walls)) = &mut self.coupling else { return Ok(()) };
        walls.settle(&self.grid, &self.boundaries, &mut self.beta);
        self.boundaries.reach_deep(self.session.size() > 1 || walls.near_borders(&self.grid));
        self.projection.assemble(&self.grid, &self.beta)?;
        self.assembled = true;
        self.acceleration.iter_mut().for_each(|f| f.fill(0.0));
        for pass in 0..2 {
            walls.impose_with_ghosts(&self.grid, &mut self.boundaries, false, false, &mut self.u)?;
            if pass == 0 {
                self.boundaries.fill_velocity(&mut self.u)?;
                walls.forget_faces();
                walls.forget(0.0, 0.0);
                walls.pass_faces(&self.grid, &self.u, 0.0, &self.acceleration, &mut self.faces);
                self.boundaries.set_faces(&mut self.faces);
                let p = &mut self.p;
                // With dt = 1 the potential is the pressure's impulse; it corrects the cells and is forgotten.
                self.projection.project(&self.grid, &mut self.boundaries, &self.beta, 1.0, p, &mut self.faces, None)?;
                plain_acceleration(&self.grid, &self.boundaries, self.density.at(0), &self.p, &mut self.acceleration);
                faces::add_to_cells(&self.grid, 1.0, &self.acceleration, &mut self.u);
                walls.find_open_gradient(&self.grid, &self.beta, &self.acceleration);
                walls.open_gradient(&self.grid, 1.0, false, &mut self.u);
            }
        }
        self.boundaries.fill_velocity(&mut self.u)?;
        walls.hold_faces(&self.faces);
        copy_rows(&self.u, &mut self.stage);
        walls.start_forces(&self.grid, &self.boundaries, &self.u)?;
        if let Some(audit) = &mut self.audit {
            audit.start_sharp(&self.session, &self.grid, &self.u, walls)?;
        }
        self.p.fill(0.0);
        self.acceleration.iter_mut().for_each(|f| f.fill(0.0));
        self.clock = Default::default();
        Ok(())
    }

    fn go_ahead(&mut self, dt: f64) -> Result<()> {
        let Some(Coupling::Sharp(walls)) = &mut self.coupling else { return Ok(()) };
        self.substeps = walls.go_ahead(&self.grid, &self.boundaries, &mut self.beta, dt)?;
        self.boundaries.reach_deep(self.session.size() > 1 || walls.near_borders(&self.grid));
        let mut speed = [faces::fastest(&self.grid, &self.faces)];
        self.session.max(&mut speed)?;
        walls.forget(dt, speed[0]);
        walls.start_books();
        self.clock.lap(Stage::Particles);
        if walls.moves() {
            self.projection.assemble(&self.grid, &self.beta)?;
            self.clock.lap(Stage::Assembly);
            copy_rows(&self.u, &mut self.total);
            walls.impose_with_ghosts(&self.grid, &mut self.boundaries, true, false, &mut self.total)?;
            self.boundaries.fill_velocity(&mut self.total)?;
            // What the last wall changed after the projection faces have yet to see.
            for ((moved, u), before) in self.total.iter_mut().zip(&self.u).zip(&self.stage) {
                moved.iter_mut().zip(u).zip(before).for_each(|((moved, u), before)| *moved += before - u);
            }
            walls.remember_faces(&self.grid, &self.beta, &self.total, self.dt_before, &self.acceleration);
        } else {
            walls.remember_faces(&self.grid, &self.beta, &self.stage, self.dt_before, &self.acceleration);
        }
        walls.find_open_gradient(&self.grid, &self.beta, &self.acceleration);
        self.clock.lap(Stage::Mixing);
        Ok(())
    }

    /// The stages of (7) in their order, the wall imposed on every one and on their sum.
    fn predict_cells_sharp(&mut self, dt: f64) -> Result<()> {
        for (stage, &weight) in self.scheme.weights.iter().enumerate() {
            if stage > 0 {
                self.set_stage(stage, dt);
                let part = self.scheme.stages[stage - 1].1;
                let Some(Coupling::Sharp(walls)) = &mut self.coupling else { return Ok(()) };
                walls.open_gradient(&self.grid, part * dt, false, &mut self.stage);
                if part == 1.0 {
                    walls.impose_with_ghosts(&self.grid, &mut self.boundaries, true, false, &mut self.stage)?;
                } else {
                    // The bodies are at the step's end already.
                    walls.impose_within(part, &self.u, &mut self.stage);
                }
                self.clock.lap(Stage::Mixing);
            }
            self.add_rates(stage, weight, dt)?;
        }
        let Some(Coupling::Sharp(walls)) = &mut self.coupling else { return Ok(()) };
        // The wall belongs to the velocity with its pressure.
        faces::step_cells(&self.grid, None, (dt, &self.total), (dt, &self.acceleration), &mut self.u);
        self.clock.lap(Stage::Update);
        walls.open_gradient(&self.grid, dt, false, &mut self.u);
        walls.impose_with_ghosts(&self.grid, &mut self.boundaries, true, true, &mut self.u)?;
        self.boundaries.fill_velocity(&mut self.u)?;
        walls.release(&self.grid, &self.u, &self.p, dt)?;
        faces::add_to_cells(&self.grid, -dt, &self.acceleration, &mut self.u);
        walls.open_gradient(&self.grid, -dt, false, &mut self.u);
        self.clock.lap(Stage::Mixing);
        Ok(())
    }

    fn predict_faces_sharp(&mut self, dt: f64) -> Result<()> {
        self.boundaries.fill_velocity(&mut self.u)?;
        self.clock.lap(Stage::Ghosts);
        if !self.faces_before[0].is_empty() {
            std::mem::swap(&mut self.faces, &mut self.faces_before);
        }
        let Some(Coupling::Sharp(walls)) = &mut self.coupling else { return Ok(()) };
        walls.pass_faces(&self.grid, &self.u, dt, &self.acceleration, &mut self.faces);
        self.boundaries.set_faces(&mut self.faces);
        self.clock.lap(Stage::Faces);
        Ok(())
    }

    fn project_sharp(&mut self, dt: f64) -> Result<Projected> {
        let Some(Coupling::Sharp(walls)) = &mut self.coupling else { return Ok(Projected::default()) };
        if walls.flies() {
            let (weights, entries, turning) = walls.modes(&self.grid);
            self.projection.set_modes(weights, entries, turning)?;
        }
        let (p, faces) = (&mut self.p, &mut self.faces);
        let (projection, boundaries) = (&mut self.projection, &mut self.boundaries);
        let mut projected = projection.project(&self.grid, boundaries, &self.beta, dt, p, faces, Some(&mut *walls))?;
        let mut round = 0;
        while walls.mend_contacts(round, dt, faces)? {
            let more = projection.project(&self.grid, boundaries, &self.beta, dt, p, faces, Some(&mut *walls))?;
            projected.outer += more.outer;
            projected.krylov += more.krylov;
            projected.retries += more.retries;
            projected.divergence_max = more.divergence_max;
            round += 1;
        }
        self.clock.lap(Stage::Pressure);
        Ok(projected)
    }

    fn correct_cells_sharp(&mut self, dt: f64) -> Result<()> {
        let Some(Coupling::Sharp(walls)) = &mut self.coupling else { return Ok(()) };
        plain_acceleration(&self.grid, &self.boundaries, self.density.at(0), &self.p, &mut self.acceleration);
        faces::add_to_cells(&self.grid, dt, &self.acceleration, &mut self.u);
        walls.find_open_gradient(&self.grid, &self.beta, &self.acceleration);
        walls.open_gradient(&self.grid, dt, true, &mut self.u);
        self.clock.lap(Stage::Faces);
        self.boundaries.fill_velocity(&mut self.u)?;
        copy_rows(&self.u, &mut self.stage);
        walls.impose(&self.grid, false, true, &mut self.u);
        self.boundaries.fill_velocity(&mut self.u)?;
        self.clock.lap(Stage::Mixing);
        Ok(())
    }

    fn close_sharp(&mut self, dt: f64) -> Result<()> {
        let Some(Coupling::Sharp(walls)) = &mut self.coupling else { return Ok(()) };
        walls.close_books(&self.grid, &self.boundaries, &self.u, dt)?;
        walls.note_push(dt);
        if let Some(audit) = &mut self.audit {
            let pressure = border::pressure(&self.grid, &self.boundaries, &self.p);
            audit.close_sharp(&self.session, &self.grid, &self.u, pressure, walls, dt)?;
        }
        self.clock.lap(Stage::Force);
        Ok(())
    }
}

impl<const D: usize> Sharp<D> {
    fn impose_with_ghosts(
        &mut self,
        grid: &Grid<D>,
        boundaries: &mut Boundaries<D>,
        fresh: bool,
        book: bool,
        u: &mut VectorField<D>,
    ) -> Result<()> {
        boundaries.fill_velocity(u)?;
        self.impose(grid, fresh, book, u);
        Ok(())
    }
}

/// The acceleration by pressure on every face, open or not (m/s2).
pub(super) fn plain_acceleration<const D: usize>(
    grid: &Grid<D>,
    boundaries: &Boundaries<D>,
    density: f64,
    p: &[f64],
    acceleration: &mut VectorField<D>,
) {
    faces::acceleration(grid, &FaceCoefficient::Uniform(1.0 / density), None, p, acceleration);
    boundaries.extrapolate_to_closed_faces(acceleration);
}
