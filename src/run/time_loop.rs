//! The time loop: bodies that leave or come in, the length of the step, the step, and what is due
//! after it.
//!
//! ```text
//!   while t < end    bodies through the boundaries; dt; step; refusals; rows, fields, checkpoint
//! ```

use super::{Run, StepOutcome, Wishes, energy_bound};
use crate::clock::Stage;
use crate::config::Cadence;
use crate::scheme::Limits;
use crate::step_size::choose_step;
use crate::{Error, Result};
use mics_run::progress::Record;
use std::io::Write;

/// Steps from one state that is kept, should the run fail, to the next; while the fluid gets faster
/// by more than this, each is.
const KEPT_EVERY: u64 = 8;
const FASTER: f64 = 1.05;

/// What the loop remembers from step to step.
pub(super) struct Pending {
    fields: Schedule,
    particles: Schedule,
    history: Schedule,
    /// Largest speed of the fluid (m/s), now and in the state that was kept last.
    speed: f64,
    kept_speed: f64,
    /// Whether a pressure has been solved for.
    solved: bool,
}

impl<const D: usize> Run<'_, D> {
    /// Steps from the state that the run has to its end.
    ///
    /// # Errors
    /// When a step fails or is refused, nothing can be written, or somebody interrupts the run.
    pub(super) fn advance(&mut self) -> Result<()> {
        let mut pending = self.pending();
        if self.restart.is_none() {
            self.write_start()?;
        }
        while self.scene.state.time < self.case.time.end * (1.0 - 1e-12) {
            self.began = (self.scene.state.steps, self.scene.state.time);
            let Some(came) = self.pass_boundaries()? else { break };
            self.keep_state(&mut pending);
            let outcome = self.step(came, &mut pending)?;
            let wishes = self.write_due(outcome, &mut pending)?;
            if wishes.stop || wishes.checkpoint {
                self.checkpoint()?;
                self.scene.domain.clock.lap(Stage::Fields);
            }
            if wishes.stop {
                return Err(Error::Interrupted(format!(
                    "interrupted after step {}, t = {:.6} s; the same command with --resume goes \
                    on from there",
                    self.scene.state.steps, self.scene.state.time
                )));
            }
        }
        if self.account.last_fields != Some(self.scene.state.time) {
            self.write_fields()?;
        }
        // A run may be given a later end, and others begin here.
        self.checkpoint()
    }

    /// What the loop begins with.
    pub(super) fn pending(&self) -> Pending {
        let time = self.scene.state.time;
        Pending {
            fields: Schedule::new(self.case.output.fields, time),
            particles: Schedule::new(Some(self.case.output.rows()), time),
            history: Schedule::new(self.case.pressure.history.cadence(), time),
            speed: 0.0,
            kept_speed: 0.0,
            solved: false,
        }
    }

    /// Writes the state at time 0.
    fn write_start(&mut self) -> Result<()> {
        let (_, speed) = self.scene.energy_and_speed()?;
        self.write_row(StepOutcome::default())?;
        self.write_particles()?;
        self.write_fields()?;
        self.sample(speed)?;
        self.record()
    }

    /// Takes bodies out and lets others in, and says whether one came in; nothing where the run
    /// ends here. None passes after the last step: a run ends with the bodies of its last rows.
    pub(super) fn pass_boundaries(&mut self) -> Result<Option<bool>> {
        let Some(dt) = self.account.dt else { return Ok(Some(false)) };
        let Some(returned) = self.pass(dt)? else { return Ok(None) };
        Ok(Some(self.admit()? || returned))
    }

    /// Keeps the state, should the run fail, where that is due.
    fn keep_state(&mut self, pending: &mut Pending) {
        if self.began.0.is_multiple_of(KEPT_EVERY)
            || pending.speed > FASTER * pending.kept_speed
            || self.scene.state.differs(&self.good)
        {
            self.scene.state.keep(&mut self.good);
            pending.kept_speed = pending.speed;
        }
    }

    /// Chooses a length and steps; the step is counted, and refused where energy was gained. Where
    /// a body `came` in, the flow is set off anew: the length of the step before says nothing.
    pub(super) fn step(&mut self, came: bool, pending: &mut Pending) -> Result<StepOutcome> {
        let limits = self.scene.limits()?;
        let before = if came { None } else { self.account.dt };
        let left = self.case.time.end - self.scene.state.time;
        let (dt, _) = choose_step(self.case, &limits, before, left);
        refuse_broken_limit(dt, &limits)?;
        if let Some(awaited) = &mut self.awaited {
            awaited.see_step(&mut self.scene, dt);
        }
        self.scene.domain.clock.lap(Stage::Logs);
        let step = self.scene.state.steps + 1;
        let end = self.scene.state.time + dt;
        self.scene.domain.projection.record(pending.history.due(step, end));
        let stepped = self.scene.step(dt);
        if stepped.is_err() {
            self.write_failed_solves(dt);
        }
        let report = stepped?;
        let projected = report.projected;
        pending.speed = report.largest_speed;
        self.account.count(dt, &projected);
        if !pending.solved && projected.krylov > 0 {
            pending.solved = true;
            self.name_unused_options()?;
        }
        let domain = &self.scene.domain;
        let state = &self.scene.state;
        energy_bound::refuse_made(state, energy_bound::settling(domain, &state.bodies))?;
        Ok(StepOutcome { dt, projected, cfl: dt * limits.courant_rate })
    }

    /// Writes what is due after a step, and returns what ranks wish for.
    fn write_due(&mut self, outcome: StepOutcome, pending: &mut Pending) -> Result<Wishes> {
        let step = self.scene.state.steps;
        let time = self.scene.state.time;
        let dt = outcome.dt;
        let divergence = outcome.projected.divergence_max;
        let wishes = self.write_row(outcome)?;
        if pending.particles.due(step, time) {
            self.write_particles()?;
        }
        self.sample(pending.speed)?;
        self.record()?;
        self.show_progress(dt, divergence, pending);
        self.scene.domain.clock.lap(Stage::Logs);
        if pending.fields.due(step, time) {
            self.write_fields()?;
        }
        Ok(wishes)
    }

    /// Shows how far the run is, where that is due, after a step of `dt` (s) that left this
    /// divergence (1/s).
    pub(super) fn show_progress(&mut self, dt: f64, divergence: f64, pending: &Pending) {
        if self.progress.due() {
            let state = Record {
                step: self.scene.state.steps,
                time: self.scene.state.time,
                end: self.case.time.end,
                dt: Some(dt),
                divergence,
                largest_speed: pending.speed,
                measures: self.values(),
                ..Record::default()
            };
            self.progress.take(state).into_iter().for_each(|line| self.log.say(&line));
        }
    }

    /// Names the PETSc options that nothing has used, once a solve has set up what it works with.
    fn name_unused_options(&self) -> Result<()> {
        let unused = self.session.unused_options()?;
        if !unused.is_empty() && self.session.rank() == 0 {
            let count = unused.len();
            let unused = unused.join(", ");
            let one =
                if count == 1 { "option that nothing uses" } else { "options that nothing uses" };
            // A closed stderr is no reason to end a run.
            let _ = writeln!(
                std::io::stderr(),
                "warning: PETSc {one} so far: {unused}; check the spelling"
            );
        }
        Ok(())
    }
}

/// Refuses a step over a limit that the flow has tightened since the start.
fn refuse_broken_limit(dt: f64, limits: &Limits) -> Result<()> {
    let (bound, limit) = limits.tightest();
    if dt <= limit * (1.0 + 1e-9) {
        return Ok(());
    }
    Err(Error::Run(format!(
        "the step of {dt} s is over the {bound}, now {limit:.4e} s: the flow is faster than at the \
        start; give a smaller time.step, or time.cfl instead"
    )))
}

/// When something is due that happens every so often: decided by step and time alone, so that all
/// ranks agree.
struct Schedule {
    cadence: Option<Cadence>,
    done: f64,
}

impl Schedule {
    /// From `time` (s) on.
    fn new(cadence: Option<Cadence>, time: f64) -> Schedule {
        let mut schedule = Schedule { cadence, done: 0.0 };
        schedule.due(0, time);
        schedule
    }

    /// Whether a step that ended at `time` (s) is the first at or after a due moment.
    fn due(&mut self, step: u64, time: f64) -> bool {
        match self.cadence {
            Some(Cadence::Steps(n)) => step.is_multiple_of(n),
            Some(Cadence::Time(interval)) => {
                let passed = (time / interval * (1.0 + 1e-9)).floor();
                std::mem::replace(&mut self.done, passed) < passed
            }
            None => false,
        }
    }
}
