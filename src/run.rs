//! A run: from the command line's words to a folder of results. The time loop, its dt, its schedule
//! and its end.

mod collapse;
mod energy_bound;
mod extensions;
mod passage;
mod restart;
mod symmetry;

use crate::check::{check_memory, expected_rest};
use crate::clock::Stage;
use crate::config::{Cadence, Case, FixedRows, Loaded};
use crate::interrupt::Interrupt;
use crate::output::measure::{self, Measure, Series};
use crate::output::probe::Probes;
use crate::output::progress::Progress;
use crate::output::snapshot;
use crate::output::statistics::Statistics;
use crate::output::{Folder, Log, Output, StepRow, fields_file, may_use};
use crate::particles::{Body, Motion};
use crate::petsc::{Session, Traffic};
use crate::poisson::pressure::Projected;
use crate::scene::{Scene, read_case};
use crate::scheme::Limits;
use crate::state::Readable;
use crate::step_size::choose_step;
use crate::system::{cpu_seconds, host, now, peak_memory};
use crate::{Error, Result};
pub use extensions::Extensions;
use mics_run::compare::measured;
use mics_run::progress::Record;
pub use restart::Account;
use restart::{Checkpoints, Ended, Restart};
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Steps from one state that is kept, should the run fail, to the next; while the fluid gets faster
/// by more than this, each is.
const KEPT_EVERY: u64 = 8;
const FASTER: f64 = 1.05;

/// Draws the figures of the run in a folder, and returns their files. The solver knows no figures:
/// whoever starts a run gives it what draws them.
pub type Draw = fn(&Path) -> Result<Vec<PathBuf>>;

/// What `mics run` was told.
#[derive(Clone, Debug)]
pub struct Request {
    /// The case file.
    pub case: PathBuf,
    /// The run's folder, default `runs/NAME`.
    pub out: Option<PathBuf>,
    /// Overrides, `key.path=value`.
    pub set: Vec<String>,
    /// Replace a run that is in the folder.
    pub force: bool,
    /// Go on from the newest checkpoint in the folder.
    pub resume: bool,
    /// Print errors only.
    pub quiet: bool,
    /// PETSc options.
    pub petsc: Vec<String>,
    /// Draws the figures of a run that is done.
    pub draw: Draw,
    /// The git commit that the program was built from.
    pub commit: &'static str,
}

/// Runs a case. Collective.
///
/// # Errors
/// When the case is wrong (nothing is written) or the run fails.
pub fn run(request: &Request) -> Result<()> {
    let loaded = read_case(&request.case, &request.set)?;
    match loaded.case.dimension() {
        2 => go::<2>(request, &loaded, Extensions::default()),
        _ => go::<3>(request, &loaded, Extensions::default()),
    }
}

/// Runs a case of D dimensions with what a library's user adds to it. Collective.
///
/// # Errors
/// As [`run`]; when the case has another dimension, or what is added does not fit it.
pub fn run_with<const D: usize>(request: &Request, added: Extensions<D>) -> Result<()> {
    let loaded = read_case(&request.case, &request.set)?;
    let dimension = loaded.case.dimension();
    if dimension != D {
        let why = format!("the case has {dimension} dimensions, and what is added {D}");
        return Err(Error::Usage(why));
    }
    go(request, &loaded, added)
}

fn go<const D: usize>(request: &Request, loaded: &Loaded, added: Extensions<D>) -> Result<()> {
    added.refuse_names(loaded.case.measure.iter().map(|m| &m.name[..]))?;
    let session = Session::start_by(&loaded.case.petsc.options, &request.petsc)?;
    let out = request.out.clone().unwrap_or_else(|| Path::new("runs").join(&loaded.case.name));
    let interrupt = Interrupt::listen()?;
    let restart = if request.resume {
        Some(Restart::find(&session, &out, loaded)?)
    } else {
        session.agree(may_use(&out, request.force, &request.case))?;
        None
    };
    check_memory(loaded, &session)?;
    Run::new(&session, loaded, request, added, out, interrupt, restart)?.go()
}

struct Run<'a, const D: usize> {
    session: &'a Session,
    case: &'a Case,
    scene: Scene<D>,
    out: PathBuf,
    /// On rank 0.
    folder: Option<Folder>,
    log: Log,
    series: Vec<Series>,
    probes: Probes,
    statistics: Option<Statistics<D>>,
    added: Extensions<D>,
    progress: Progress,
    started: Instant,
    account: Account,
    /// Step and what this rank had told others when the time loop began.
    before: (u64, Traffic),
    interrupt: Interrupt,
    checkpoints: Checkpoints,
    restart: Option<Restart>,
    /// What was taken of the run that it begins with, in lines.
    begun: Vec<String>,
    /// What is to be said of the case file, in lines.
    notes: &'a [String],
    /// Steps done and time (s) at the start of the step.
    began: (u64, f64),
    /// A state of late, for a run that fails.
    good: Readable<D>,
    draw: Draw,
    commit: &'static str,
}

/// What ranks wish for at the end of a step.
struct Wishes {
    /// To stop, since somebody asked for it.
    stop: bool,
    /// To write a checkpoint, since one is due.
    checkpoint: bool,
}

/// What a step gave, for the log.
#[derive(Default)]
struct StepOutcome {
    dt: f64,
    projected: Projected,
    cfl: f64,
}

impl<'a, const D: usize> Run<'a, D> {
    fn new(
        session: &'a Session,
        loaded: &'a Loaded,
        request: &Request,
        mut added: Extensions<D>,
        out: PathBuf,
        interrupt: Interrupt,
        mut restart: Option<Restart>,
    ) -> Result<Self> {
        let case = &loaded.case;
        let ended = match (&case.initial.from, &restart) {
            (Some(from), None) => Some(Ended::<D>::read(session, Path::new(from))?),
            _ => None,
        };
        let mut scene = Scene::<D>::extended(session, case, std::mem::take(&mut added.scene))?;
        let (mut account, mut series) =
            (Account { began: now(), ..Account::default() }, measure::series(case));
        let begun = ended.map_or(Ok(Vec::new()), |ended| ended.begin(session, case, &mut scene))?;
        let mut statistics = Statistics::of_case(&scene, case);
        let marks = restart.as_mut();
        let marks = marks
            .map(|r| r.read(session, &mut account, &mut series, &mut statistics, case, &mut scene))
            .transpose()?;
        if account.divergence_max >= case.pressure.divergence_limit {
            let reached = account.divergence_max;
            return Err(loaded.error_at(
                "pressure.divergence_limit",
                format!(
                    "the run that goes on has reached |D| = {reached:.3e} 1/s already; give a \
                    limit above that"
                ),
            ));
        }
        let (end, reached) = (case.time.end, scene.state.time);
        // A fixed step may pass the end: a run that was killed there has its summary and figures
        // left to write.
        let earlier = restart.as_ref().is_some_and(|restart| !restart.had_end(end));
        if earlier && end < reached * (1.0 - 1e-12) {
            return Err(loaded.error_at(
                "time.end",
                format!(
                    "the run that goes on has reached {reached} s already; give a later end \
                    than that"
                ),
            ));
        }
        crate::check::refuse(loaded, &scene)?;
        let lead = session.rank() == 0;
        let mut log = Log::new(lead && !request.quiet);
        let opened = if lead {
            match (&restart, marks) {
                (Some(restart), Some(marks)) => restart.open_folder(&out, &mut log, case, marks),
                _ => Folder::create(&out, &mut log, case, &scene.state),
            }
            .map(Some)
        } else {
            Ok(None)
        };
        let mut good = Readable::default();
        scene.state.keep(&mut good);
        Ok(Run {
            began: (scene.state.steps, scene.state.time),
            good,
            draw: request.draw,
            commit: request.commit,
            folder: session.agree(opened)?,
            progress: Progress::new(lead && !request.quiet, case.time.end, lead.then_some(&out)),
            checkpoints: Checkpoints::new(
                case.output.checkpoint,
                restart.as_ref().map(Restart::step),
            ),
            series,
            probes: Probes::new(&case.probe),
            statistics,
            added,
            account,
            before: Default::default(),
            interrupt,
            restart,
            begun,
            notes: &loaded.notes,
            session,
            case,
            scene,
            out,
            log,
            started: Instant::now(),
        })
    }

    fn go(mut self) -> Result<()> {
        let kept = self.restart.as_ref().map(|_| &self.account.added[..]);
        self.added.begin(&self.out, &mut self.scene, kept)?;
        self.write_run(None)?;
        let cells =
            self.case.domain.cells.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
        let solver = self.scene.solver()?;
        let particles = self.case.particle.len();
        self.log.say(&format!(
            "{}: {cells} cells, {particles} particle{}, {} rank{}, {solver}, to t = {} s, into {}",
            self.case.name,
            if particles == 1 { "" } else { "s" },
            self.session.size(),
            if self.session.size() == 1 { "" } else { "s" },
            self.case.time.end,
            self.out.display()
        ));
        self.notes.iter().chain(&self.begun).for_each(|line| self.log.say(line));
        for warning in crate::check::warnings(self.case, &self.scene)? {
            self.log.say(&warning);
        }
        if let Some(restart) = &self.restart {
            restart.say(&mut self.log, self.scene.state.time, self.session.size());
            let added = restart.added(self.case);
            if !added.is_empty() {
                let (names, time) = (added.join(", "), self.scene.state.time);
                self.log.say(&format!(
                    "measured from t = {time:.6} s on only, since the run before did not: {names}"
                ));
            }
        }
        let rest = expected_rest(self.case, &self.scene.limits()?);
        self.progress.begin(self.scene.state.steps, self.scene.state.time, rest);
        self.before = (self.scene.state.steps, self.session.traffic());
        let result = self.advance();
        let (status, result) = match result {
            Ok(()) => ("done", Ok(())),
            Err(stop @ Error::Interrupted(_)) => ("interrupted", Err(stop)),
            Err(e) => ("failed", Err(self.keep_good_state(e)?)),
        };
        self.progress.finish(status, self.scene.state.steps, self.scene.state.time, self.values());
        // A second error must not hide the first.
        let closed = self.close(status);
        if let Err(e) = &result {
            let kind = if let Error::Interrupted(_) = e { "" } else { "error: " };
            // The program says it on standard error.
            self.log.keep(&format!("{kind}{e}"));
            let _ = self.on_lead(|folder, _, log| folder.flush(log));
        }
        result?;
        closed
    }

    /// The time loop.
    fn advance(&mut self) -> Result<()> {
        let end = self.case.time.end;
        let mut fields = Schedule::new(self.case.output.fields, self.scene.state.time);
        let mut rows = Schedule::new(Some(self.case.output.particles), self.scene.state.time);
        let mut collapse = collapse::Collapse::default();
        let (mut speed, mut kept_speed, mut solved) = (0.0, 0.0, false);
        if self.restart.is_none() {
            let (_, speed) = self.scene.energy_and_speed()?;
            self.write_row(StepOutcome::default())?;
            self.write_particles()?;
            self.write_fields()?;
            self.sample(speed)?;
            self.record()?;
        }
        while self.scene.state.time < end * (1.0 - 1e-12) {
            self.began = (self.scene.state.steps, self.scene.state.time);
            // Not after the last step: a run ends with the bodies of its last rows.
            let mut came = false;
            if let Some(dt) = self.account.dt {
                let Some(returned) = self.pass(dt)? else { break };
                came = self.admit()? || returned;
            }
            if self.began.0.is_multiple_of(KEPT_EVERY)
                || speed > FASTER * kept_speed
                || self.scene.state.differs(&self.good)
            {
                self.scene.state.keep(&mut self.good);
                kept_speed = speed;
            }
            let limits = self.scene.limits()?;
            // Where a body has come in the flow is set off anew.
            let before = if came { None } else { self.account.dt };
            let (dt, _) = choose_step(self.case, &limits, before, end - self.scene.state.time);
            self.refuse_broken_limit(dt, &limits)?;
            self.scene.domain.clock.lap(Stage::Logs);
            let report = self.scene.step(dt)?;
            let projected = report.projected;
            speed = report.largest_speed;
            self.account.dt = Some(dt);
            let domain = &self.scene.domain;
            collapse.take(dt, &self.scene.state.bodies, &domain.grid.size, &domain.periods())?;
            self.account.divergence_max = self.account.divergence_max.max(projected.divergence_max);
            self.account.outer += u64::from(projected.outer);
            self.account.krylov += u64::from(projected.krylov);
            self.account.retries += u64::from(projected.retries);
            if !solved && projected.krylov > 0 {
                solved = true;
                self.name_unused_options()?;
            }
            let (domain, state) = (&self.scene.domain, &self.scene.state);
            energy_bound::refuse_made(state, energy_bound::settling(domain, &state.bodies))?;
            let wishes =
                self.write_row(StepOutcome { dt, projected, cfl: dt * limits.courant_rate })?;
            if rows.due(self.scene.state.steps, self.scene.state.time) {
                self.write_particles()?;
            }
            self.sample(speed)?;
            self.record()?;
            if self.progress.due() {
                let (step, time) = (self.scene.state.steps, self.scene.state.time);
                let (divergence, measures) = (projected.divergence_max, self.values());
                let state = Record {
                    step,
                    time,
                    end,
                    dt: Some(dt),
                    divergence,
                    largest_speed: speed,
                    measures,
                    ..Record::default()
                };
                self.progress.take(state).into_iter().for_each(|line| self.log.say(&line));
            }
            self.scene.domain.clock.lap(Stage::Logs);
            if fields.due(self.scene.state.steps, self.scene.state.time) {
                self.write_fields()?;
            }
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

    fn refuse_broken_limit(&self, dt: f64, limits: &Limits) -> Result<()> {
        let (bound, limit) = limits.tightest();
        if dt <= limit * (1.0 + 1e-9) {
            return Ok(());
        }
        Err(Error::Run(format!(
            "the step of {dt} s is over the {bound}, now {limit:.4e} s: the flow is faster than at \
            the start; give a \
             smaller time.step, or time.cfl instead"
        )))
    }

    /// Brings back and writes the last state that was kept, unless writing is what failed, and
    /// returns the failure with its step and the place of that state.
    fn keep_good_state(&mut self, error: Error) -> Result<Error> {
        let mut broken = [f64::from(matches!(error, Error::Io { .. } | Error::Petsc { .. }))];
        self.session.max(&mut broken)?;
        if broken[0] == 0.0 {
            self.scene.bring_back(&self.good);
            if self.account.last_fields != Some(self.scene.state.time) {
                let _ = self.write_fields();
            }
        }
        let mut said =
            format!("step {}, from t = {:.6} s: {error}", self.began.0 + 1, self.began.1);
        if let Some(step) = self.checkpoints.newest {
            said += &format!("; with the cause gone, --resume goes on after step {step}");
        }
        if let Some((time, path)) = self.folder.as_ref().and_then(Folder::last_snapshot) {
            said += &format!(
                "; the last good state that was kept, of t = {time:.6} s, is {}",
                path.display()
            );
        }
        Ok(Error::Run(said))
    }

    /// Writes a row of `steps.csv`; what ranks wish for is agreed on with it.
    fn write_row(&mut self, outcome: StepOutcome) -> Result<Wishes> {
        let row = StepRow {
            step: self.scene.state.steps,
            time: self.scene.state.time,
            dt: outcome.dt,
            outer: outcome.projected.outer,
            krylov: outcome.projected.krylov,
            divergence_max: outcome.projected.divergence_max,
            cfl: outcome.cfl,
            kinetic_energy: self.scene.state.energy.kinetic(),
            wall: self.wall(),
        };
        let (scene, log) = (&self.scene, &mut self.log);
        let written = self.folder.as_mut().map_or(Ok(()), |folder| {
            let s = &scene.state;
            folder.write_step(&row, s)?;
            folder.flush_when_due(log)
        });
        // One message for all three, every step.
        let flags = [written.is_err(), self.interrupt.asked(), self.checkpoints.due(row.step)];
        let mut anywhere = flags.map(f64::from);
        self.session.max(&mut anywhere)?;
        let [failed, stop, checkpoint] = anywhere.map(|flag| flag > 0.0);
        written?;
        if failed {
            Err(Error::Run("rank 0 failed".into()))
        } else {
            Ok(Wishes { stop, checkpoint })
        }
    }

    /// Seconds that the run has taken, in all its sessions.
    fn wall(&self) -> f64 {
        self.account.wall + self.started.elapsed().as_secs_f64()
    }

    fn write_particles(&mut self) -> Result<()> {
        if self.account.last_rows == Some(self.scene.state.steps) {
            return Ok(());
        }
        self.account.last_rows = Some(self.scene.state.steps);
        let (rule, fixed) = (self.case.coupling.force, self.case.output.fixed);
        self.on_lead(|folder, scene, _| {
            let s = &scene.state;
            let shown = |body: &Body| {
                body.motion != Motion::Fixed || fixed == FixedRows::Always || s.steps == 0
            };
            let rows = s.bodies.iter().zip(&s.exchange).filter(|(body, _)| shown(body));
            folder.write_particles(s.steps, s.time, rows, rule)
        })
    }

    fn write_fields(&mut self) -> Result<()> {
        let path = self.out.join("fields").join(fields_file(self.scene.state.steps));
        snapshot::write(&mut self.scene, &path)?;
        self.account.last_fields = Some(self.scene.state.time);
        self.series.iter_mut().try_for_each(|s| s.take_fields(&self.scene))?;
        // A figure of the fields shows the particles where they are.
        self.write_particles()?;
        self.on_lead(|folder, scene, log| {
            let s = &scene.state;
            folder.take_snapshot(s.steps, s.time, &s.bodies, &s.exchange)?;
            folder.flush(log)
        })?;
        self.scene.domain.clock.lap(Stage::Fields);
        Ok(())
    }

    /// Rank 0 writes; a failure there is a failure everywhere.
    fn on_lead(
        &mut self,
        write: impl FnOnce(&mut Folder, &Scene<D>, &mut Log) -> Result<()>,
    ) -> Result<()> {
        let written =
            self.folder.as_mut().map_or(Ok(()), |folder| write(folder, &self.scene, &mut self.log));
        self.session.agree(written)
    }

    fn sample(&mut self, speed: f64) -> Result<()> {
        // The state at time 0 has exchanged nothing yet.
        if self.scene.state.steps > 0 {
            let mut series = self.series.iter_mut();
            series.try_for_each(|series| series.take(&self.scene, speed))?;
            self.added.measure(&self.scene, speed)?;
        }
        Ok(())
    }

    /// Statistics, probes, and what was added.
    fn record(&mut self) -> Result<()> {
        if let Some(statistics) = &mut self.statistics {
            statistics.take(&mut self.scene)?;
        }
        let (folder, mut written) = (&mut self.folder, Ok(()));
        self.probes.record(&mut self.scene, |line| {
            if let (Some(folder), Ok(())) = (folder.as_mut(), &written) {
                written = folder.write_probe(line);
            }
            Ok(())
        })?;
        // A failure of rank 0's shall not keep it from what the others do now.
        let added = self.added.write(&mut self.scene);
        written.and(added)
    }

    /// Names the PETSc options that nothing has used, once a solve has set up what it works with.
    fn name_unused_options(&self) -> Result<()> {
        let unused = self.session.unused_options()?;
        if !unused.is_empty() && self.session.rank() == 0 {
            let (unused, count) = (unused.join(", "), unused.len());
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

    /// The measures of the case, and those that were added.
    fn measures(&self) -> impl Iterator<Item = &dyn Measure<D>> {
        let of_case = self.series.iter().map(|series| series as &dyn Measure<D>);
        of_case.chain(self.added.measures.iter().map(|measure| &**measure))
    }

    /// The measures that have a value so far, by name.
    fn values(&self) -> serde_json::Map<String, serde_json::Value> {
        self.measures().filter_map(|s| Some((s.name().to_owned(), json!(s.value()?)))).collect()
    }

    /// Closes the logs, sums up and draws.
    fn close(&mut self, status: &str) -> Result<()> {
        if status != "failed" {
            if let Some(statistics) = &mut self.statistics {
                statistics.end(&self.out, &mut self.scene)?;
            }
            self.added.end(&self.out, &mut self.scene)?;
        }
        let wall = self.wall();
        let cells = self.scene.domain.grid.total_cells();
        let stages = self.scene.stages();
        let (before, told) = self.before;
        let mut most = [&(self.session.traffic() - told).numbers()[..], &[peak_memory()]].concat();
        let mut used = [peak_memory(), cpu_seconds()];
        self.session.sum(&mut used)?;
        self.session.max(&mut most)?;
        let [memory, cpu] = used;
        let symmetric = symmetry::stayed(self.case, &self.scene)?;
        let unused = self.session.unused_options()?;
        self.write_run(Some(&now()))?;
        if self.folder.is_none() {
            return Ok(());
        }
        let found = self.values();
        let comparisons: serde_json::Map<_, _> = self
            .measures()
            .filter_map(|s| Some((s.name().to_owned(), json!(s.comparison()?))))
            .collect();
        let steps = self.scene.state.steps.max(1) as f64;
        let stepped = (self.scene.state.steps - before).max(1) as f64;
        let busiest = json!({
            "collectives_per_step": most[0] / stepped,
            "collective_bytes_per_step": most[1] / stepped,
            "messages_per_step": most[2] / stepped,
            "message_bytes_per_step": most[3] / stepped,
            "peak_memory_bytes": most[4],
        });
        let (domain, state) = (&self.scene.domain, &self.scene.state);
        let made = energy_bound::doubt(state, energy_bound::settling(domain, &state.bodies));
        let notes = [
            made.filter(|_| status == "done"),
            energy_bound::bounded(state),
            energy_bound::lost(self.case, state),
            symmetric.filter(|_| status == "done"),
        ];
        let remarks = || self.measures().filter_map(|s| Some((s.name(), s.remark()?)));
        let doubts = remarks().filter(|(_, remark)| remark.doubt && status == "done");
        let doubts = doubts.map(|(name, remark)| format!("{name} {}", remark.words));
        let mut notes: Vec<String> = notes.into_iter().flatten().collect();
        // Remarks stand beside their measures on the screen.
        let said = notes.len();
        notes.extend(doubts);
        let summary = json!({
            "notes": notes,
            "case": self.case.name,
            "status": status,
            "cells": cells,
            "steps": self.scene.state.steps,
            "time": self.scene.state.time,
            "wall_seconds": wall,
            "cpu_seconds": self.account.cpu + cpu,
            "step_seconds": wall / steps,
            "divergence_max": self.account.divergence_max,
            "divergence_limit": self.case.pressure.divergence_limit,
            "outer_iterations": self.account.outer,
            "krylov_iterations": self.account.krylov,
            "solver_retries": self.account.retries,
            "measures": found,
            "comparisons": comparisons,
            "units": table(self.measures().map(|s| (s.name(), json!(s.unit())))),
            "remarks": table(remarks().map(|(name, remark)| (name, json!(remark.words)))),
            "stages_ns_per_cell_step": table(stages.iter().map(|(n, t)| (*n, json!(t)))),
            "peak_memory_bytes": memory, "peak_memory_bytes_per_cell": memory / cells as f64,
            "ranks": self.session.size(), "busiest_rank": busiest,
        });

        let total: f64 = stages.iter().map(|s| s.1).sum();
        self.log.say("");
        self.log.say("stage          ns per cell and step    share");
        for (name, ns) in &stages {
            self.log.say(&format!("{name:<14} {ns:>12.1} {:>19.1} %", 100.0 * ns / total));
        }
        self.log.say(&format!("{:<14} {total:>12.1}", "all"));
        self.log.say("");
        self.log.say(&format!(
            "{} steps in {wall:.1} s, {:.2} ms a step; peak memory {:.0} MB, {:.0} bytes a cell",
            self.scene.state.steps,
            1e3 * wall / steps,
            memory / 1e6,
            memory / cells as f64
        ));
        self.log.say(&format!(
            "C-HSMAC {:.2} and Krylov {:.2} iterations a step{}; largest |D| {:.2e} 1/s, limit \
            {:.0e}",
            self.account.outer as f64 / steps,
            self.account.krylov as f64 / steps,
            if self.account.retries > 0 {
                format!(", {} solves repeated", self.account.retries)
            } else {
                String::new()
            },
            self.account.divergence_max,
            self.case.pressure.divergence_limit
        ));
        if self.session.size() > 1 {
            self.log.say(&format!(
                "{} ranks; the busiest: {:.0} collectives ({:.1} kB) and {:.0} messages ({:.1} kB) \
                a step, {:.0} MB",
                self.session.size(),
                most[0] / stepped,
                most[1] / stepped / 1e3,
                most[2] / stepped,
                most[3] / stepped / 1e3,
                most[4] / 1e6
            ));
        }
        if !self.scene.state.waiting.is_empty() {
            let count = self.scene.state.waiting.len();
            let cure = "their time had not come, or their place was never free";
            self.log.say(&format!("{count} of the particles never came in: {cure}"));
        }
        notes[..said].iter().for_each(|note| self.log.say(note));
        if !unused.is_empty() {
            let why =
                if self.account.krylov == 0 { ", since no pressure was solved for" } else { "" };
            self.log.say(&format!("PETSc options that nothing used{why}: {}", unused.join(", ")));
        }
        let mut lines = Vec::new();
        for series in self.measures() {
            let name = series.name();
            lines.push(match series.value() {
                Some(v) => {
                    let unit = series.unit();
                    let beside = series.comparison().map(|comparison| format!(", {comparison}"));
                    let remark = series.remark().map(|remark| format!("; {}", remark.words));
                    let (beside, remark) = (beside.unwrap_or_default(), remark.unwrap_or_default());
                    format!(
                        "{}{beside}{remark}",
                        format!("{name} = {} {unit}", measured(v)).trim_end()
                    )
                }
                None => {
                    format!(
                        "{name}: the run gives no value (no oscillation, no contact, a \
                        particle that was not there, or no steps after `from`)"
                    )
                }
            });
        }
        lines.iter().for_each(|line| self.log.say(line));
        let Some(folder) = &mut self.folder else { return Ok(()) };
        folder.write_json("summary.json", &summary)?;
        folder.flush(&mut self.log)?;
        if status == "done" && self.case.output.figures {
            for path in (self.draw)(&self.out)? {
                self.log.say(&format!("figure {}", path.display()));
            }
        }
        folder.flush(&mut self.log)
    }

    fn write_run(&mut self, ended: Option<&str>) -> Result<()> {
        let (options, solver) = (self.session.options()?, self.scene.solver()?);
        let needs = self.scene.needs();
        let needs = needs
            .iter()
            .map(|(what, needed, why)| json!({"what": what, "needed": needed, "why": why}));
        let words: Vec<String> = std::env::args().collect();
        let record = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "git_commit": self.commit,
            "command": words,
            "petsc_version": self.session.version(),
            "petsc_options": options,
            "ranks": self.session.size(),
            "host": host(), "pid": std::process::id(), "start": self.account.began, "end": ended,
            "resumed_after_step": self.restart.as_ref().map(Restart::step),
            "solver": solver,
            "needs": needs.collect::<Vec<_>>(),
        });
        self.on_lead(|folder, _, _| folder.write_json("run.json", &record))
    }
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

/// A table of values by their names.
fn table<'a>(rows: impl Iterator<Item = (&'a str, serde_json::Value)>) -> serde_json::Value {
    rows.map(|(name, value)| (name.to_owned(), value)).collect::<serde_json::Map<_, _>>().into()
}
