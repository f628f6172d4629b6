//! A run that ends at one pressure solve, for the system that is solved there; it leaves no folder.

use super::{Request, Run};
use crate::check::check_memory;
use crate::config::Loaded;
use crate::interrupt::Interrupt;
use crate::petsc::Session;
use crate::poisson::{Origin, System};
use crate::scene::{Scene, read_case};
use crate::{Error, Result};

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
    /// That of this number, the first of a run being 1.
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
    /// What each factor of the system stands for, in words.
    pub factors: Vec<String>,
    /// The least and the largest density of the bodies in the box, in parts of the fluid's; `None`
    /// where there are none.
    pub density_ratios: Option<(f64, f64)>,
    /// Bodies in the box, and how many of them are free.
    pub bodies: usize,
    #[allow(missing_docs)]
    pub free_bodies: usize,
    /// The solver of the run, its PETSc options, and PETSc's version.
    pub solver: String,
    #[allow(missing_docs)]
    pub options: String,
    #[allow(missing_docs)]
    pub petsc: String,
}

/// Waits for the step of the solve that is wanted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Awaited {
    wanted: Wanted,
    /// The length (s) of the step, once it has begun.
    dt: Option<f64>,
}

impl Awaited {
    /// Lets the scene keep the system, where the step of `dt` (s) that comes next is the one.
    pub fn see_step<const D: usize>(&mut self, scene: &mut Scene<D>, dt: f64) {
        let next = scene.state.steps + 1;
        let end = scene.state.time + dt;
        let comes = match self.wanted.moment {
            Moment::Step(step) => step == next,
            Moment::Time(time) => end >= time * (1.0 - 1e-9),
        };
        if comes {
            self.dt = Some(dt);
            scene.domain.projection.keep_system_of(self.wanted.solve);
        }
    }
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
    let mut run = Run::<D>::new(&session, loaded, request, None, interrupt, None)?;
    run.awaited = Some(Awaited { wanted, dt: None });
    run.reach_system(wanted)
}

impl<const D: usize> Run<'_, D> {
    /// Steps to the solve that is wanted.
    fn reach_system(&mut self, wanted: Wanted) -> Result<Exported> {
        let mut pending = self.pending();
        self.progress.begin(0, self.scene.state.time);
        while self.scene.state.time < self.case.time.end * (1.0 - 1e-12) {
            self.began = (self.scene.state.steps, self.scene.state.time);
            let Some(came) = self.pass_boundaries()? else { break };
            let stepped = self.step(came, &mut pending);
            if let Some(dt) = self.awaited.and_then(|awaited| awaited.dt) {
                return match self.scene.domain.projection.take_system() {
                    (_, Some(system)) => self.exported(system, dt),
                    (solves, None) => self.failed(stepped).and(Err(self.unsolved(&wanted, solves))),
                };
            }
            let outcome = self.failed(stepped)?;
            self.show_progress(outcome.dt, outcome.projected.divergence_max, &pending);
            if self.interrupt.asked() {
                return Err(Error::Interrupted("interrupted; nothing was written".into()));
            }
        }
        let steps = self.scene.state.steps;
        let time = self.scene.state.time;
        Err(Error::Usage(format!(
            "the run ends with step {steps}, at t = {time} s: give an earlier step, or a later end \
            (--set time.end=...)"
        )))
    }

    /// A step's failure, with the step.
    fn failed<T>(&self, stepped: Result<T>) -> Result<T> {
        stepped.map_err(|failed| match failed {
            refused @ Error::Usage(_) => refused,
            failed => Error::Run(format!(
                "step {}, from t = {:.6} s: {failed}; nothing was written",
                self.began.0 + 1,
                self.began.1
            )),
        })
    }

    /// The refusal of a solve that a step has not.
    fn unsolved(&self, wanted: &Wanted, solves: u64) -> Error {
        Error::Usage(format!(
            "step {}, from t = {:.6} s, solves for the pressure {solves} times (0: its velocities \
            are free of divergence as they are): there is no --solve {}",
            self.began.0 + 1,
            self.began.1,
            wanted.solve
        ))
    }

    /// What is to be said of a system of a step of `dt` (s) that has just ended, or failed.
    fn exported(&self, system: System, dt: f64) -> Result<Exported> {
        let domain = &self.scene.domain;
        let bodies = &self.scene.state.bodies;
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
            step: self.began.0 + 1,
            time: self.began.1 + dt,
            dt,
            cells: domain.grid.cells.to_vec(),
            spacing: domain.grid.h.to_vec(),
            factors: factors.collect(),
            density_ratios: (!bodies.is_empty()).then(|| (least, ratios.fold(0.0, f64::max))),
            bodies: bodies.len(),
            free_bodies: bodies.iter().filter(|body| body.freedom().is_some()).count(),
            solver: self.scene.solver()?,
            options: self.session.options()?,
            petsc: self.session.version(),
            system,
        })
    }
}
