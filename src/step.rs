//! The method: one step of MICS, in the order of the paper, and the same with sharp walls (`sharp`).

mod restart;
mod sharp;

use crate::clock::Stage;
use crate::coupling::Coupling;
use crate::coupling::mixing::{Mixing, Part};
use crate::error::NotFinite;
use crate::fluid::advection::{self, Carrier};
use crate::fluid::{border, diffusion, faces, pressure::Projected};
use crate::grid::{Coefficient, VectorField};
use crate::scene::{Advection, Scene};
use crate::{Error, Result};

impl<const D: usize> Scene<D> {
    /// Advances the scene by `dt` (s). Collective.
    ///
    /// # Errors
    /// When the divergence cannot be brought below D0, or a value is no longer finite: names the cell or the particle.
    pub fn step(&mut self, dt: f64) -> Result<Projected> {
        match self.advance(dt) {
            Err(Error::NotFinite(NotFinite::Velocity)) => Err(self.name_what_is_lost()?),
            done => done,
        }
    }

    fn advance(&mut self, dt: f64) -> Result<Projected> {
        if let Some(Coupling::Sharp(_)) = self.coupling {
            return self.step_sharp(dt);
        }
        self.mix_properties()?; //              (1)      density, viscosity; 1/rho on faces; the operator (the first time)
        self.predict_cells(dt)?; //             (7)      u* without pressure
        self.predict_faces(dt)?; //             (8)      U = mean of u* - dt/rho dp^n/dn
        let projected = self.project(dt)?; //   (13-15)  C-HSMAC: |D| < D0
        self.correct_cells(dt); //              (16)     u_f = u* - dt/rho grad p
        self.sum_pressure_force(); //           (19)     the last of its three parts
        self.move_particles(dt)?; //            (17, 18, 20-26) to the new place, through contacts
        self.mix_properties()?; //              (1)      there, for the mixing and the next step
        self.mix_velocity(dt)?; //              (27)     the wall; the momentum it takes is the force
        self.count_step(dt);
        Ok(projected)
    }

    /// (1). Where nothing has moved since the last time, nothing changes.
    pub(crate) fn mix_properties(&mut self) -> Result<()> {
        if !std::mem::take(&mut self.properties_stale) {
            return Ok(());
        }
        if let Some(coupling) = mixing(&mut self.coupling) {
            coupling.mix_properties(&mut self.boundaries, &mut self.density, &mut self.viscosity)?;
            coupling.face_coefficient(&self.grid, &self.density, &mut self.beta);
            if let Some(gravity) = &mut self.gravity {
                coupling.mix_excess(&mut self.boundaries, gravity)?;
            }
            self.clock.lap(Stage::Properties);
        }
        if !self.assembled || matches!(self.density, Coefficient::Field(_)) {
            self.projection.assemble(&self.grid, &self.beta)?;
            self.assembled = true;
            self.clock.lap(Stage::Assembly);
            self.find_acceleration();
        }
        Ok(())
    }

    /// (7) by the scheme's stages; the pressure of the last step takes part in the stages and is taken out of u* again.
    fn predict_cells(&mut self, dt: f64) -> Result<()> {
        if let Some(coupling) = mixing(&mut self.coupling) {
            coupling.start_tally();
        }
        if let Some(audit) = &mut self.audit {
            audit.begin(&self.grid, &self.density, &self.u);
            self.clock.lap(Stage::Force);
        }
        for (stage, &weight) in self.scheme.weights.iter().enumerate() {
            if stage > 0 {
                self.set_stage(stage, dt);
            }
            self.add_rates(stage, weight, dt)?;
        }
        self.sum_stages(dt);
        Ok(())
    }

    /// The velocity that a stage after the first starts from.
    fn set_stage(&mut self, stage: usize, dt: f64) {
        let (of_total, of_pressure) = self.scheme.stages[stage - 1];
        let (rate, acceleration) = ((dt * of_total, &self.total), (dt * of_pressure, &self.acceleration));
        faces::step_cells(&self.grid, Some(&self.u), rate, acceleration, &mut self.stage);
        self.clock.lap(Stage::Update);
    }

    fn add_rates(&mut self, stage: usize, weight: f64, dt: f64) -> Result<()> {
        let u = if stage == 0 { &mut self.u } else { &mut self.stage };
        self.boundaries.fill_velocity(u)?;
        self.clock.lap(Stage::Ghosts);
        self.audit_sides(stage, weight, dt);
        if self.is_plain() {
            self.put_rates(stage, weight, dt);
            return Ok(());
        }
        if stage == 0 {
            self.total.iter_mut().for_each(|f| f.fill(0.0));
        }
        self.add_advection(stage, weight, dt)?;
        self.add_diffusion(stage, weight);
        Ok(())
    }

    /// With sharp walls the balance of momentum knows what the sides of the box do.
    fn audit_sides(&mut self, stage: usize, weight: f64, dt: f64) {
        let (Some(audit), Some(Coupling::Sharp(_))) = (&mut self.audit, &self.coupling) else { return };
        let carrier = Carrier { now: &self.faces, before: before(&self.faces_before, self.steps, dt, self.dt_before) };
        let u = if stage == 0 { &self.u } else { &self.stage };
        let force = border::stress(&self.grid, &carrier, u, self.density.at(0), self.viscosity.at(0));
        audit.add_sides(weight, force);
        self.clock.lap(Stage::Force);
    }

    /// Whether advection and diffusion are one pass: nobody asks for them one by one, and the mixture is the fluid.
    fn is_plain(&self) -> bool {
        let mixed = matches!(self.coupling, Some(Coupling::Mixing(_)));
        let one = |property: &Coefficient| matches!(property, Coefficient::Uniform(_));
        !mixed && matches!(self.advection, Advection::Upwind5) && one(&self.density) && one(&self.viscosity)
    }

    /// Both in one pass; the first stage's replace what `total` has.
    fn put_rates(&mut self, stage: usize, weight: f64, dt: f64) {
        let carrier = Carrier { now: &self.faces, before: before(&self.faces_before, self.steps, dt, self.dt_before) };
        let u = if stage == 0 { &self.u } else { &self.stage };
        let nu = self.viscosity.at(0) / self.density.at(0);
        advection::upwind5(&self.grid, &carrier, u, nu, weight, stage == 0, &mut self.total, &mut self.fluxes);
        self.clock.lap(Stage::Advection);
    }

    fn sum_stages(&mut self, dt: f64) {
        for (u, r) in self.u.iter_mut().zip(&self.total) {
            for row in self.grid.rows() {
                for (u, r) in u[row.clone()].iter_mut().zip(&r[row]) {
                    *u += dt * r;
                }
            }
        }
        self.clock.lap(Stage::Update);
    }

    fn add_advection(&mut self, stage: usize, weight: f64, dt: f64) -> Result<()> {
        self.tally(Part::Convective, -1.0);
        let u = if stage == 0 { &self.u } else { &self.stage };
        let grid = &self.grid;
        match &mut self.advection {
            Advection::Upwind5 => {
                let before = before(&self.faces_before, self.steps, dt, self.dt_before);
                let carrier = Carrier { now: &self.faces, before };
                advection::upwind5(grid, &carrier, u, 0.0, weight, false, &mut self.total, &mut self.fluxes);
            }
            Advection::Upwind5Advective => {
                for (q, rate) in u.iter().zip(&mut self.total) {
                    advection::upwind5_advective(grid, u, q, weight, rate);
                }
            }
            Advection::Qsi { from, to } => {
                copy_rows(u, from);
                for axis in 0..D {
                    self.boundaries.fill_velocity(from)?;
                    for (q, out) in from.iter().zip(to.iter_mut()) {
                        advection::qsi_sweep(grid, axis, &u[axis], dt, q, out);
                    }
                    std::mem::swap(from, to);
                }
                for ((rate, end), start) in self.total.iter_mut().zip(from.iter()).zip(u) {
                    for c in grid.rows().flatten() {
                        rate[c] += weight * (end[c] - start[c]) / dt;
                    }
                }
            }
        }
        self.clock.lap(Stage::Advection);
        self.tally(Part::Convective, 1.0);
        Ok(())
    }

    fn add_diffusion(&mut self, stage: usize, weight: f64) {
        self.tally(Part::Viscous, -1.0);
        let u = if stage == 0 { &self.u } else { &self.stage };
        match &self.viscosity {
            Coefficient::Uniform(0.0) => {}
            Coefficient::Uniform(mu) => {
                for (q, rate) in u.iter().zip(&mut self.total) {
                    diffusion::laplacian(&self.grid, *mu, &self.density, q, weight, rate);
                }
            }
            Coefficient::Field(mu) => {
                for (i, rate) in self.total.iter_mut().enumerate() {
                    diffusion::stress(&self.grid, mu, &self.density, u, i, weight, rate, &mut self.scratch);
                }
            }
        }
        self.clock.lap(Stage::Diffusion);
        self.tally(Part::Viscous, 1.0);
    }

    fn tally(&mut self, part: Part, sign: f64) {
        if let Some(coupling) = mixing(&mut self.coupling) {
            coupling.tally(&self.grid, part, sign, &self.total);
            self.clock.lap(Stage::Force);
        }
    }

    /// (8).
    fn predict_faces(&mut self, dt: f64) -> Result<()> {
        self.boundaries.fill_velocity(&mut self.u)?;
        self.clock.lap(Stage::Ghosts);
        if !self.faces_before[0].is_empty() {
            std::mem::swap(&mut self.faces, &mut self.faces_before);
        }
        faces::predict(&self.grid, &self.u, dt, &self.acceleration, &mut self.faces);
        self.boundaries.set_faces(&mut self.faces);
        self.clock.lap(Stage::Faces);
        Ok(())
    }

    /// (13-15).
    fn project(&mut self, dt: f64) -> Result<Projected> {
        let projected = self.projection.project(
            &self.grid,
            &mut self.boundaries,
            &self.beta,
            dt,
            &mut self.p,
            &mut self.faces,
            None,
        )?;
        self.clock.lap(Stage::Pressure);
        Ok(projected)
    }

    /// (16).
    fn correct_cells(&mut self, dt: f64) {
        self.find_acceleration();
        if self.cell_gradient {
            faces::add_cell_gradient(&self.grid, &self.density, dt, &self.p, &mut self.u);
        } else {
            faces::add_to_cells(&self.grid, dt, &self.acceleration, &mut self.u);
        }
        self.clock.lap(Stage::Faces);
    }

    /// The acceleration by pressure and gravity on faces, as cells and the next step's stages use it.
    fn find_acceleration(&mut self) {
        faces::acceleration(&self.grid, &self.beta, self.gravity.as_ref(), &self.p, &mut self.acceleration);
        self.boundaries.extrapolate_to_closed_faces(&mut self.acceleration);
    }

    fn sum_pressure_force(&mut self) {
        if let Some(coupling) = mixing(&mut self.coupling) {
            let (gravity, cells) = (self.gravity.as_ref(), self.cell_gradient.then_some(&self.p[..]));
            coupling.tally_pressure(&self.grid, &self.density, &self.beta, gravity, &self.acceleration, cells);
            self.clock.lap(Stage::Force);
        }
    }

    /// Fixed bodies stay, and the fractions of those that only turn.
    fn move_particles(&mut self, dt: f64) -> Result<()> {
        let Some(coupling) = mixing(&mut self.coupling) else { return Ok(()) };
        if let Some(audit) = &mut self.audit {
            audit.after_fluid(&self.grid, &self.density, &self.u);
        }
        coupling.depart(&self.grid, &self.density, &self.u, dt)?;
        self.substeps = coupling.advance(&self.grid, dt)?;
        self.properties_stale = coupling.moves();
        self.clock.lap(Stage::Particles);
        Ok(())
    }

    /// (27).
    fn mix_velocity(&mut self, dt: f64) -> Result<()> {
        let Some(coupling) = mixing(&mut self.coupling) else { return Ok(()) };
        coupling.settle(&self.grid, &self.density, &self.u, dt)?;
        coupling.impose(&self.grid, &self.density, dt, &mut self.u);
        coupling.finish_tally()?;
        if self.mix_pressure {
            //                                  (28, 29) as printed
            coupling.flatten_pressure(&mut self.p)?;
            self.boundaries.fill_pressure(&mut self.p)?;
        }
        if let Some(audit) = &mut self.audit {
            audit.close(&self.session, &self.grid, &self.density, &self.u, coupling, dt)?;
        }
        if self.mix_pressure {
            self.find_acceleration();
        }
        self.clock.lap(Stage::Mixing);
        Ok(())
    }

    fn count_step(&mut self, dt: f64) {
        self.time += dt;
        self.dt_before = dt;
        self.steps += 1;
        self.clock.count();
    }
}

/// The face velocities of the last step but one and how far ahead of the last to carry: to the middle of the step of `dt`
/// (s), for schemes of second order, which keep them.
fn before<const D: usize>(
    faces_before: &VectorField<D>,
    steps: u64,
    dt: f64,
    dt_before: f64,
) -> Option<(&VectorField<D>, f64)> {
    (!faces_before[0].is_empty() && steps > 0).then(|| (faces_before, 0.5 * dt / dt_before))
}

fn copy_rows<const D: usize>(from: &VectorField<D>, to: &mut VectorField<D>) {
    for (f, t) in from.iter().zip(to) {
        t.copy_from_slice(f);
    }
}

fn mixing<const D: usize>(coupling: &mut Option<Coupling<D>>) -> Option<&mut Mixing<D>> {
    coupling.as_mut().and_then(Coupling::mixing)
}
