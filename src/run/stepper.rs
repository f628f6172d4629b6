//! A scene taken from step to step: bodies that reach an outflow leave, come in again at the other
//! end, or end the run, as the case says; bodies come in; the length of a step, and the step.

use super::energy_bound;
use super::schedule::Schedule;
use crate::clock::Stage;
use crate::config::Case;
use crate::poisson::pressure::Projected;
use crate::scene::{self, Passed, Scene};
use crate::scheme::Limits;
use crate::state::State;
use crate::step_size::choose_step;
use crate::{Error, Result};
use mics_run::progress::Record;
use std::io::Write;

/// The scene of a case on its way to the end of the run.
pub(super) struct Stepper<'a, const D: usize> {
    case: &'a Case,
    pub scene: Scene<D>,
    /// Steps done at the start of the step.
    began: u64,
    /// Time at the start of the step (s).
    pub began_at: f64,
    /// When the history of the solves is recorded.
    history: Schedule,
    /// Whether a pressure has been solved for.
    solved: bool,
}

/// Outcome of a step.
#[derive(Default)]
pub(super) struct StepOutcome {
    /// Its length (s).
    pub dt: f64,
    pub projected: Projected,
    pub cfl: f64,
    /// Largest speed of the fluid (m/s).
    pub speed: f64,
}

impl StepOutcome {
    /// Progress of the run after it, for display.
    pub fn progress<const D: usize>(&self, state: &State<D>) -> Record {
        Record {
            step: state.steps,
            time: state.time,
            dt: Some(self.dt),
            divergence: self.projected.divergence_max,
            largest_speed: self.speed,
            ..Record::default()
        }
    }
}

/// A step that is about to be made.
pub(super) struct Planned {
    /// Its length (s).
    pub dt: f64,
    cfl: f64,
}

impl<'a, const D: usize> Stepper<'a, D> {
    /// Begins with the scene as it is.
    pub fn new(case: &'a Case, scene: Scene<D>) -> Stepper<'a, D> {
        let time = scene.state.time;
        Stepper {
            case,
            began: scene.state.steps,
            began_at: time,
            history: Schedule::new(case.pressure.history.cadence(), time),
            solved: false,
            scene,
        }
    }

    /// Begins a step, unless the run has come to its end.
    pub fn begin_step(&mut self) -> bool {
        let state = &self.scene.state;
        let goes_on = state.time < self.case.time.end * (1.0 - 1e-12);
        if goes_on {
            self.began = state.steps;
            self.began_at = state.time;
        }
        goes_on
    }

    /// The number of the step.
    pub fn number(&self) -> u64 {
        self.began + 1
    }

    /// The step in words.
    pub fn names_step(&self) -> String {
        format!("step {}, from t = {:.6} s", self.number(), self.began_at)
    }

    /// Takes the bodies out that would reach an outflow in the next step, about as long as the last
    /// one, `dt` (s), and lets those in that wait for it. None passes before the first step, nor
    /// after the last one: a run ends with the bodies of its last rows. Collective.
    pub fn pass_boundaries(&mut self, dt: Option<f64>) -> Result<Passed> {
        dt.map_or_else(
            || Ok(Passed::default()),
            |dt| scene::pass_boundaries(&mut self.scene, self.case, dt),
        )
    }

    /// Plans a step by the last one (s), if there was one that says something of the next.
    ///
    /// # Errors
    /// When the step breaks a limit.
    pub fn plan(&self, before: Option<f64>) -> Result<Planned> {
        let limits = self.scene.limits()?;
        let left = self.case.time.end - self.scene.state.time;
        let (dt, _) = choose_step(self.case, &limits, before, left);
        refuse_broken_limit(dt, &limits)?;
        Ok(Planned { dt, cfl: dt * limits.courant_rate })
    }

    /// Makes a step.
    ///
    /// # Errors
    /// When it fails.
    pub fn step(&mut self, planned: &Planned) -> Result<StepOutcome> {
        let Planned { dt, cfl } = *planned;
        let scene = &mut self.scene;
        scene.domain.clock.lap(Stage::Logs);
        let recorded = self.history.due(scene.state.steps + 1, scene.state.time + dt);
        scene.domain.projection.record(recorded);
        let report = scene.step(dt)?;
        Ok(StepOutcome { dt, projected: report.projected, cfl, speed: report.largest_speed })
    }

    /// Judges a step: names the PETSc options that nothing has used after the first solve, and
    /// refuses energy that the method has made.
    ///
    /// # Errors
    /// When energy was gained.
    pub fn judge(&mut self, outcome: &StepOutcome) -> Result<()> {
        if !self.solved && outcome.projected.krylov > 0 {
            self.solved = true;
            self.name_unused_options()?;
        }
        let state = &self.scene.state;
        energy_bound::refuse_made(state, energy_bound::settling(&self.scene.domain, &state.bodies))
    }

    /// Names the PETSc options that nothing has used, once a solve has set up what it works with.
    fn name_unused_options(&self) -> Result<()> {
        let session = &self.scene.domain.session;
        let unused = session.unused_options()?;
        if !unused.is_empty() && session.rank() == 0 {
            let one = match unused.len() {
                1 => "option that nothing uses",
                _ => "options that nothing uses",
            };
            let unused = unused.join(", ");
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
