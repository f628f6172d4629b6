//! The parts of a step with sharp surfaces, in its order ([`super`] has the formulas).

use super::cut::CutBodies;
use super::exchanged::ExchangedMomentum;
use super::pressure_step::PressureStep;
use super::{Sharp, StepNumbers, contact_correction, copy, history};
use crate::Result;
use crate::clock::Stage;
use crate::domain::Domain;
use crate::grid::VectorField;
use crate::kernels::boundary::Sides;
use crate::kernels::faces;
use crate::method::prediction::{Walls, Within};
use crate::numerics::{
    CORRECTION_COURANT, CORRECTION_DECAY_CUT_2D, CORRECTION_DECAY_CUT_3D, CORRECTION_DECAY_FIXED,
    CORRECTION_DECAY_OPEN, PRESSURE_TIME,
};
use crate::particles::{Body, all_fixed};
use crate::petsc::LogStage;
use crate::poisson::pressure::Projected;
use crate::state::{BeforeForcing, State};

impl<const D: usize> Sharp<D> {
    /// How far a step of `dt` (s) goes. Collective.
    pub(super) fn step_numbers(
        &self,
        domain: &Domain<D>,
        s: &State<D>,
        dt: f64,
    ) -> Result<StepNumbers> {
        let crowded = self.cut.bodies.iter().any(|body| body.has_neighbours);
        let mut most = [faces::fastest(&domain.grid, &s.faces), f64::from(crowded)];
        domain.session.max(&mut most)?;
        let [speed, crowded] = [most[0], most[1]];
        let h = self.cut.h;
        let nu = domain.fluid.viscosity / domain.fluid.density;
        let courant = dt * speed / h;
        let diffusion = nu * dt / (h * h);
        let rest = all_fixed(&s.bodies);
        // Of cells that are longer one way it goes by the way that they are short: what faces
        // remember is of that size.
        let least = domain.grid.h.iter().copied().fold(h, f64::min);
        let kept = |decay: f64| {
            1.0 - (courant / CORRECTION_COURANT + decay * diffusion * (h / least).powi(2)).min(1.0)
        };
        let [cut, open] = match (rest, D) {
            (true, _) => [CORRECTION_DECAY_FIXED; 2],
            (false, 3) => [CORRECTION_DECAY_CUT_3D, CORRECTION_DECAY_OPEN],
            (false, _) => [CORRECTION_DECAY_CUT_2D, CORRECTION_DECAY_OPEN],
        };
        let short = (PRESSURE_TIME / diffusion).min(CORRECTION_COURANT / courant);
        let own = if rest { short.min(1.0) } else { 1.0 };
        let keep = kept(cut);
        let keep_open = kept(open);
        let crowded = crowded > 0.0;
        Ok(StepNumbers { courant, diffusion, keep, keep_open, own, crowded })
    }

    /// Sets the velocity of the cells inside the bodies. Collective.
    pub(super) fn set_ghost_cells(
        &mut self,
        domain: &mut Domain<D>,
        bodies: &[Body],
        u: &mut VectorField<D>,
    ) -> Result<()> {
        domain.boundaries.fill_velocity(u)?;
        self.cut.set_ghost_cells(domain, bodies, false, None, u);
        domain.boundaries.fill_velocity(u)
    }

    /// Updates the momentum-interpolation correction of the faces: what their velocity was beyond
    /// that of the cells with ghost cells set at the present place; nothing where nothing will be
    /// kept of it. Collective.
    pub(super) fn update_face_correction(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        numbers: StepNumbers,
        dt: f64,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Prediction)?;
        let moves = s.bodies.iter().any(Body::moves);
        if moves {
            domain.projection.assemble(&domain.grid, &self.cut.beta)?;
            domain.clock.lap(Stage::Assembly);
        }
        if numbers.keep > 0.0 || numbers.crowded {
            let surfaces = history(&mut s.surfaces)?;
            let stage = &mut self.prediction.stage;
            copy(&s.u, stage);
            if moves {
                // The drive has not accelerated the fluid of this step yet, nor the bodies beside
                // it.
                for body in &mut s.bodies {
                    body.velocity -= dt * self.acceleration.driven(body);
                }
                self.cut.set_ghost_cells(domain, &s.bodies, true, None, stage);
                for (body, motion) in s.bodies.iter_mut().zip(&self.motions) {
                    body.velocity = motion.expected.velocity;
                }
            }
            // Faces have yet to see what ghost cells changed after the projection.
            for BeforeForcing { cell, velocity } in &surfaces.before_forcing {
                let cell = *cell as usize;
                for ((stage, u), before) in stage.iter_mut().zip(&s.u).zip(velocity) {
                    stage[cell] += before - u[cell];
                }
            }
            domain.boundaries.fill_stencils(stage)?;
            self.cut.update_face_correction(
                domain,
                stage,
                s.dt,
                &self.acceleration,
                &mut surfaces.correction,
            );
        }
        self.acceleration.find_cut_changes(domain, &mut self.cut, &s.bodies);
        domain.clock.lap(Stage::Mixing);
        Ok(())
    }

    /// (7): ghost cells are set on every stage and on their sum, which has the last pressure; the
    /// bodies are at the step's end already. Returns the forces of this
    /// rank's sides on the fluid, where a balance is kept. Collective.
    pub(super) fn predict_cells(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<Sides> {
        let _logged = domain.session.log(LogStage::Prediction)?;
        self.work.exchanged.fill(Default::default());
        if let Some(forces) = &mut domain.forces {
            let bodies = &self.cut.bodies;
            let exchanged = &mut self.work.exchanged;
            let bodies = bodies.each().map(|(k, body)| (k, &body.solid[..]));
            forces.share(&domain.session, &domain.grid, bodies, |k, arm, force| {
                exchanged[k].add(arm, &(dt * force));
            })?;
        }
        self.cut.find_cubic(domain, &s.bodies, &s.u);
        let Sharp { mixture, prediction, cut, acceleration, work, .. } = self;
        if prediction.is_long(domain, dt) {
            cut.find_targets(domain, &s.bodies, true, &s.u);
            cut.find_offsets(&s.u);
        }
        let mut walls = Surfaces { cut, exchanged: &mut work.exchanged };
        let sides = prediction.predict(domain, s, mixture, &acceleration.faces, dt, &mut walls)?;
        domain.boundaries.fill_velocity(&mut s.u)?;
        cut.set_ghost_cells(domain, &s.bodies, true, Some(&mut work.exchanged), &mut s.u);
        domain.boundaries.fill_imposed(&mut s.u)?;
        domain.clock.lap(Stage::Mixing);
        Ok(sides)
    }

    /// (8), from the cells without the last pressure. Collective.
    pub(super) fn predict_faces(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        numbers: StepNumbers,
        dt: f64,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Prediction)?;
        self.acceleration.add_to(domain, &self.cut, -numbers.own * dt, &mut s.u);
        domain.boundaries.fill_stencils(&mut s.u)?;
        domain.clock.lap(Stage::Ghosts);
        if !s.faces_before[0].is_empty() {
            std::mem::swap(&mut s.faces, &mut s.faces_before);
        }
        self.cut.interpolate(domain, s, numbers, dt, &self.acceleration)?;
        domain.boundaries.set_faces(&mut s.faces);
        if numbers.own < 1.0 {
            self.acceleration.add_to(domain, &self.cut, (numbers.own - 1.0) * dt, &mut s.u);
        }
        domain.clock.lap(Stage::Faces);
        Ok(())
    }

    /// (13-15), the free bodies and the impulses of their contacts with it. Collective.
    pub(super) fn project(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<Projected> {
        let _logged = domain.session.log(LogStage::Pressure)?;
        let Sharp { cut, contacts, modes, motions, work, .. } = self;
        let sums = &mut work.sums;
        let in_contact = contacts.as_mut().filter(|contacts| contacts.gave(&s.bodies, dt));
        let mut step = PressureStep::new(domain, cut, s, (modes, motions, sums), dt)?;
        let (projected, taken) = match in_contact {
            Some(contacts) => {
                contact_correction::solve(&mut contacts.impulses(), &mut step, &mut work.contacts)?
            }
            None => (step.solve(None)?, 0.0),
        };
        s.energy.bounded += taken;
        domain.clock.lap(Stage::Pressure);
        Ok(projected)
    }

    /// (16), ghost cells set. Collective.
    pub(super) fn correct_cells(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Correction)?;
        let Sharp { cut, acceleration, work, .. } = self;
        acceleration.of_pressure(domain, cut, &s.bodies, &s.p, s.drive);
        faces::add_to_cells(&domain.grid, dt, &acceleration.faces, &mut s.u);
        cut.add_cut_cells(domain, dt, Some(&mut work.exchanged), &mut s.u);
        domain.clock.lap(Stage::Faces);
        domain.boundaries.fill_velocity(&mut s.u)?;
        let before_forcing = &mut history(&mut s.surfaces)?.before_forcing;
        cut.take_before_forcing(&s.u, before_forcing);
        cut.set_ghost_cells(domain, &s.bodies, false, Some(&mut work.exchanged), &mut s.u);
        domain.boundaries.fill_imposed(&mut s.u)?;
        domain.clock.lap(Stage::Mixing);
        Ok(())
    }
}

/// The surfaces of bodies within the stages of a step. The bodies are at the step's end, and a
/// Legendre stage at the time c of it has inside them what is imposed there and `1 - c` of what the
/// start had beyond that: no cell jumps at once.
struct Surfaces<'a, const D: usize> {
    cut: &'a mut CutBodies<D>,
    exchanged: &'a mut Vec<ExchangedMomentum>,
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
                cut.add_cut_cells(domain, part * dt, None, u);
                if part == 1.0 {
                    domain.boundaries.fill_velocity(u)?;
                    cut.set_ghost_cells(domain, &s.bodies, true, None, u);
                } else {
                    cut.set_ghost_cells_within(part, &s.u, u);
                }
                domain.clock.lap(Stage::Mixing);
                domain.boundaries.fill_stencils(u)?;
                domain.clock.lap(Stage::Ghosts);
            }
            Within::Legendre(stage) => {
                cut.add_cut_cells(domain, stage.part() * dt, None, u);
                if stage.weight != 0.0 {
                    domain.boundaries.fill_velocity(u)?;
                    cut.find_targets(domain, &s.bodies, true, u);
                    cut.add_offsets(1.0 - stage.time);
                    cut.apply_targets(domain, true, Some((stage.remains, exchanged)), u);
                    domain.boundaries.fill_imposed(u)?;
                }
                domain.clock.lap(Stage::Mixing);
            }
            // Ghost cells belong to the velocity with its pressure.
            Within::End => cut.add_cut_cells(domain, dt, None, u),
        }
        Ok(())
    }
}
