//! The parts of a step with sharp surfaces, in its order ([`super`] has the formulas).

use super::pressure_step::PressureStep;
use super::{Sharp, StepNumbers, contact_correction, copy, history};
use crate::Result;
use crate::clock::Stage;
use crate::domain::Domain;
use crate::grid::VectorField;
use crate::kernels::boundary::{self, Sides};
use crate::kernels::faces;
use crate::method::stabilised::Finish;
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
            let stage = &mut self.work.stage;
            copy(&s.u, stage);
            if moves {
                // The drive has not accelerated the fluid of this step yet, nor the bodies beside
                // it.
                for body in &mut s.bodies {
                    body.velocity -= dt * self.acceleration.driven(body);
                }
                self.cut.set_ghost_cells(domain, &s.bodies, true, None, stage);
                for (body, motion) in s.bodies.iter_mut().zip(&self.motions) {
                    body.velocity = motion.expected.0;
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

    /// (7): the stages in their order, ghost cells set on every one and on their sum, which has
    /// the last pressure; the bodies are at the step's end already. Returns the forces of this
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
        let sides = match &self.stabilised {
            Some(long) if long.is_for(domain, &self.momentum.scheme, dt) => {
                self.predict_stabilised(domain, s, dt)?
            }
            _ => self.predict_by_stages(domain, s, dt)?,
        };
        domain.boundaries.fill_velocity(&mut s.u)?;
        let Sharp { cut, work, .. } = self;
        cut.set_ghost_cells(domain, &s.bodies, true, Some(&mut work.exchanged), &mut s.u);
        domain.boundaries.fill_imposed(&mut s.u)?;
        domain.clock.lap(Stage::Mixing);
        Ok(sides)
    }

    fn predict_by_stages(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<Sides> {
        let Sharp { mixture, momentum, cut, acceleration, work, .. } = self;
        let scheme = momentum.scheme;
        let mut sides = Sides::zeros();
        for (k, &weight) in scheme.weights.iter().enumerate() {
            if k > 0 {
                let u = &mut work.stage;
                let part = scheme.stages[k - 1].1;
                momentum.start_stage(domain, k, &s.u, &acceleration.faces, dt, u);
                cut.add_cut_cells(domain, part * dt, None, u);
                if part == 1.0 {
                    domain.boundaries.fill_velocity(u)?;
                    cut.set_ghost_cells(domain, &s.bodies, true, None, u);
                } else {
                    cut.set_ghost_cells_within(part, &s.u, u);
                }
                domain.clock.lap(Stage::Mixing);
                domain.boundaries.fill_stencils(&mut work.stage)?;
                domain.clock.lap(Stage::Ghosts);
            }
            let u = if k == 0 { &s.u } else { &work.stage };
            let carrier = momentum.carrier(s, dt);
            if s.balance.is_some() {
                sides += weight
                    * boundary::stress(
                        &domain.grid,
                        &carrier,
                        u,
                        domain.fluid.density,
                        &mixture.viscosity,
                    );
                domain.clock.lap(Stage::Force);
            }
            momentum.add_stage(domain, k, mixture, &carrier, u, dt, None)?;
        }
        // Ghost cells belong to the velocity with its pressure.
        faces::step_cells(
            &domain.grid,
            None,
            (dt, momentum.rate()),
            (dt, &acceleration.faces),
            &mut s.u,
        );
        domain.clock.lap(Stage::Update);
        cut.add_cut_cells(domain, dt, None, &mut s.u);
        Ok(sides)
    }

    /// In Legendre stages. The bodies are at the step's end, and a stage at the time c of it has
    /// inside them what is imposed there and `1 - c` of what the start had beyond that: no cell
    /// jumps at once.
    fn predict_stabilised(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<Sides> {
        let Sharp { mixture, momentum, cut, acceleration, work, stabilised, .. } = self;
        let Some(stabilised) = stabilised else { return Ok(Sides::zeros()) };
        cut.find_targets(domain, &s.bodies, true, &s.u);
        cut.find_offsets(&s.u);
        let finish: Finish<D> = &mut |domain, bodies, stage, u| {
            cut.add_cut_cells(domain, stage.part() * dt, None, u);
            if stage.weight != 0.0 {
                domain.boundaries.fill_velocity(u)?;
                cut.find_targets(domain, bodies, true, u);
                cut.add_offsets(1.0 - stage.time);
                let exchanged = Some((stage.remains, &mut work.exchanged));
                cut.apply_targets(domain, true, exchanged, u);
                domain.boundaries.fill_imposed(u)?;
            }
            domain.clock.lap(Stage::Mixing);
            Ok(())
        };
        stabilised.predict(momentum, domain, s, mixture, &acceleration.faces, dt, finish)
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
