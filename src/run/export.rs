//! A run that ends at one pressure solve, for the system that is solved there; it leaves no folder.

use super::stepper::{Planned, StepOutcome, Stepper};
use super::{Request, ended};
use crate::check::check_memory;
use crate::config::{Case, Loaded};
use crate::interrupt::Interrupt;
use crate::output::Log;
use crate::output::progress::Progress;
use crate::petsc::Session;
use crate::poisson::{Origin, System};
use crate::scene::read_case;
use crate::{Error, Result};
use mics_run::progress::Record;

/// The solve whose system is wanted.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Its step.
    pub moment: Moment,
    /// Its number among the solves of that step, counted from 1.
    pub solve: u64,
}

/// A step of a run.
#[derive(Clone, Copy, Debug)]
pub enum Moment {
    /// The step of this number, the first of a run being 1.
    Step(u64),
    /// The one in which the run comes to this time (s).
    Time(f64),
}

/// A system and where it is from.
#[derive(Clone, Debug)]
pub struct Exported {
    /// The system.
    pub system: System,
    /// The number of its step, the time at the end of it (s), and its length (s).
    pub step: u64,
    #[allow(missing_docs)]
    pub time: f64,
    #[allow(missing_docs)]
    pub dt: f64,
    /// Cells and their spacing (m) along each axis.
    pub cells: Vec<usize>,
    #[allow(missing_docs)]
    pub spacing: Vec<f64>,
    /// Meaning of each factor of the system, in words.
    pub factors: Vec<String>,
    /// The bodies in the box.
    pub bodies: BodiesInBox,
    /// The solver of the run, its PETSc options, and PETSc's version.
    pub solver: String,
    #[allow(missing_docs)]
    pub options: String,
    #[allow(missing_docs)]
    pub petsc: String,
}

/// Numbers and densities of the bodies of a system.
#[derive(Clone, Copy, Debug)]
pub struct BodiesInBox {
    /// Number of bodies.
    pub count: usize,
    /// Number of free bodies.
    pub free: usize,
    /// The least and the largest density, in parts of the fluid's; `None` where there are none.
    pub density_ratios: Option<(f64, f64)>,
}

/// Runs the case of a request, as `mics run` does, to the solve that is wanted, and returns its
/// system; what a request says of folders is not used. On one rank.
///
/// # Errors
/// When the case is wrong, the run fails before, it does not come there, or nothing is solved
/// there; and on several ranks.
pub fn system_of(request: &Request, wanted: Wanted) -> Result<Exported> {
    let loaded = read_case(&request.case, &request.set)?;
    refuse_unreachable(&loaded, wanted.moment)?;
    match loaded.case.dimension() {
        2 => export::<2>(request, &loaded, wanted),
        _ => export::<3>(request, &loaded, wanted),
    }
}

/// Refuses what no run of the case comes to.
fn refuse_unreachable(loaded: &Loaded, moment: Moment) -> Result<()> {
    let end = loaded.case.time.end;
    let why = match moment {
        Moment::Time(time) if !(time.is_finite() && time > 0.0) => {
            format!("--at {time} s is no time after the start")
        }
        Moment::Time(time) if time > end * (1.0 + 1e-9) => format!(
            "--at {time} s comes after the end of the run, {end} s; give an earlier time, or \
            --set time.end={time}"
        ),
        _ => return Ok(()),
    };
    Err(Error::Usage(why))
}

fn export<const D: usize>(request: &Request, loaded: &Loaded, wanted: Wanted) -> Result<Exported> {
    let session = Session::start_by(&loaded.case.petsc.options, &request.petsc)?;
    if session.size() > 1 {
        let why = "a system is exported by one rank, which has all of its rows: start \
                   export-system without mpirun";
        return Err(Error::Usage(why.into()));
    }
    check_memory(loaded, &session)?;
    let interrupt = Interrupt::listen()?;
    let case = &loaded.case;
    let (scene, _) = ended::begin::<D>(&session, case, case.initial.from.as_ref())?;
    crate::check::refuse(loaded, &scene)?;
    let export = Export {
        case,
        stepper: Stepper::new(case, scene),
        progress: Progress::new(!request.quiet, case.time.end, None),
        log: Log::new(!request.quiet),
        interrupt,
        wanted,
    };
    export.reach_system()
}

/// A run to the solve that is wanted.
struct Export<'a, const D: usize> {
    case: &'a Case,
    stepper: Stepper<'a, D>,
    progress: Progress,
    log: Log,
    interrupt: Interrupt,
    wanted: Wanted,
}

impl<const D: usize> Export<'_, D> {
    /// Steps to the solve that is wanted.
    fn reach_system(mut self) -> Result<Exported> {
        self.progress.begin(0, self.stepper.scene.state.time);
        let mut before = None;
        while self.stepper.begin_step() {
            let passed = self.stepper.pass_boundaries(before)?;
            let ending = passed.ending(self.stepper.scene.state.time);
            ending.iter().for_each(|line| self.log.say(line));
            if passed.last.is_some() {
                break;
            }
            let planned = self.stepper.plan(before.filter(|_| !passed.came))?;
            let comes = self.is_wanted(planned.dt);
            if comes {
                self.stepper.scene.domain.projection.keep_system_of(self.wanted.solve);
            }
            let stepped = self.step(&planned);
            if comes {
                return match self.stepper.scene.domain.projection.take_system() {
                    (_, Some(system)) => self.exported(system, planned.dt),
                    (solves, None) => self.failed(stepped).and(Err(self.unsolved(solves))),
                };
            }
            let outcome = self.failed(stepped)?;
            before = Some(outcome.dt);
            self.show_progress(&outcome);
            if self.interrupt.asked() {
                return Err(Error::Interrupted("interrupted; nothing was written".into()));
            }
        }
        let state = &self.stepper.scene.state;
        Err(Error::Usage(format!(
            "the run ends with step {}, at t = {} s: give an earlier step, or a later end (--set \
            time.end=...)",
            state.steps, state.time
        )))
    }

    /// Whether the step that comes next, of `dt` (s), is the one of the solve that is wanted.
    fn is_wanted(&self, dt: f64) -> bool {
        let state = &self.stepper.scene.state;
        match self.wanted.moment {
            Moment::Step(step) => step == state.steps + 1,
            Moment::Time(time) => state.time + dt >= time * (1.0 - 1e-9),
        }
    }

    fn step(&mut self, planned: &Planned) -> Result<StepOutcome> {
        let outcome = self.stepper.step(planned)?;
        self.stepper.judge(&outcome)?;
        Ok(outcome)
    }

    /// Shows how far the run is, where that is due, after a step.
    fn show_progress(&mut self, outcome: &StepOutcome) {
        if self.progress.due() {
            let end = self.case.time.end;
            let line =
                self.progress.take(Record { end, ..outcome.progress(&self.stepper.scene.state) });
            line.into_iter().for_each(|line| self.log.say(&line));
        }
    }

    /// A step's failure, with the step.
    fn failed<T>(&self, stepped: Result<T>) -> Result<T> {
        stepped.map_err(|failed| match failed {
            refused @ Error::Usage(_) => refused,
            failed => {
                Error::Run(format!("{}: {failed}; nothing was written", self.stepper.names_step()))
            }
        })
    }

    /// The refusal of a solve that a step has not.
    fn unsolved(&self, solves: u64) -> Error {
        Error::Usage(format!(
            "{}, solves for the pressure {solves} times (0: its velocities are free of divergence \
            as they are): there is no --solve {}",
            self.stepper.names_step(),
            self.wanted.solve
        ))
    }

    /// A system with where it is from: a step of `dt` (s) that has just ended, or failed.
    fn exported(&self, system: System, dt: f64) -> Result<Exported> {
        let scene = &self.stepper.scene;
        let domain = &scene.domain;
        let bodies = &scene.state.bodies;
        let ratios = bodies.iter().map(|body| body.density / domain.fluid.density);
        let least = ratios.clone().fold(f64::INFINITY, f64::min);
        let axis = |a: usize| ["x", "y", "z"][a];
        let called = |k: usize| self.case.called(bodies[k].id);
        let factors = system.factors.iter().map(|factor| match factor.origin {
            Origin::Translation { body, axis: a } => {
                format!("{} moves along {}", called(body), axis(a))
            }
            Origin::Rotation { body, mode } => {
                format!("{} turns, about axis {mode} of its response to torque", called(body))
            }
            Origin::HeldMean => "the drive holds the mean velocity (a negative weight)".into(),
        });
        Ok(Exported {
            step: self.stepper.number(),
            time: self.stepper.began_at + dt,
            dt,
            cells: domain.grid.cells.to_vec(),
            spacing: domain.grid.h.to_vec(),
            factors: factors.collect(),
            bodies: BodiesInBox {
                count: bodies.len(),
                free: bodies.iter().filter(|body| body.freedom().is_some()).count(),
                density_ratios: (!bodies.is_empty()).then(|| (least, ratios.fold(0.0, f64::max))),
            },
            solver: scene.solver()?,
            options: domain.session.options()?,
            petsc: domain.session.version(),
            system,
        })
    }
}
