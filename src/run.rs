//! A run: from the command line's words to a folder of results. The time loop, its dt, its schedule
//! and its end.

mod cost;
mod ended;
mod energy_bound;
mod export;
mod kept;
mod measures;
mod origin;
mod record;
mod restart;
mod schedule;
mod stepper;
mod summary;

use crate::check::check_memory;
use crate::clock::Stage;
use crate::config::{Case, Loaded};
use crate::interrupt::Interrupt;
use crate::launch::RunSize;
use crate::output::progress::Progress;
use crate::output::{Folder, Log, Marks, may_use, refuse_held};
use crate::petsc::Session;
use crate::scene::read_case;
use crate::system::now;
use crate::{Error, Result};
pub use cost::Account;
use cost::Cost;
pub use export::{BodiesInBox, Exported, Moment, Wanted, system_of};
use kept::Kept;
use measures::Measures;
use origin::Origin;
use record::Records;
pub use record::Written;
use restart::{Checkpoints, Contents, Restart};
use schedule::Schedule;
use std::path::{Path, PathBuf};
use stepper::{StepOutcome, Stepper};
use summary::Summary;

/// Draws the figures of the run in a folder, and returns their files. The solver knows no figures:
/// whoever starts a run gives it what draws them.
pub type Draw = fn(&Path) -> Result<Vec<PathBuf>>;

/// Request to `mics run`.
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
        2 => go::<2>(request, &loaded),
        _ => go::<3>(request, &loaded),
    }
}

fn go<const D: usize>(request: &Request, loaded: &Loaded) -> Result<()> {
    let session = Session::start_by(&loaded.case.petsc.options, &request.petsc)?;
    let out = request.out.clone().unwrap_or_else(|| Path::new("runs").join(&loaded.case.name));
    let interrupt = Interrupt::listen()?;
    session.agree(refuse_held(&out))?;
    let restart = if request.resume {
        Some(Restart::find(&session, &out, loaded)?)
    } else {
        session.agree(may_use(&out, request.force, &request.case))?;
        None
    };
    check_memory(loaded, &session)?;
    Run::<D>::new(&session, loaded, request, out, interrupt, restart)?.go()
}

/// A run of a case into a folder.
struct Run<'a, const D: usize> {
    session: &'a Session,
    case: &'a Case,
    origin: Origin<'a>,
    stepper: Stepper<'a, D>,
    records: Records<'a, D>,
    cost: Cost,
    checkpoints: Checkpoints,
    kept: Kept<D>,
    interrupt: Interrupt,
    draw: Draw,
}

/// Requests of the ranks at the end of a step.
struct Requested {
    /// To stop, since somebody asked for it.
    stop: bool,
    /// To write a checkpoint, since one is due.
    checkpoint: bool,
}

impl<'a, const D: usize> Run<'a, D> {
    fn new(
        session: &'a Session,
        loaded: &'a Loaded,
        request: &Request,
        out: PathBuf,
        interrupt: Interrupt,
        mut restart: Option<Restart>,
    ) -> Result<Self> {
        let case = &loaded.case;
        let mut account = Account::begin();
        let from = case.initial.from.as_ref().filter(|_| restart.is_none());
        let (mut scene, inherited) = ended::begin(session, case, from)?;
        let mut measures = Measures::new(case, &scene);
        let mut written = Written::default();
        let mut marks = Marks::default();
        if let Some(restart) = &mut restart {
            let contents = Contents {
                account: &mut account,
                written: &mut written,
                measures: &mut measures,
                marks: &mut marks,
                case,
                scene: &mut scene,
            };
            restart.read(session, loaded, contents)?;
        }
        crate::check::refuse(loaded, &scene)?;
        let lead = session.rank() == 0;
        let shown = lead && !request.quiet;
        let mut log = Log::new(shown);
        let opened = match &restart {
            _ if !lead => Ok(None),
            Some(restart) => restart.open_folder(&out, &mut log, case, marks).map(Some),
            None => Folder::create(&out, &mut log, case, &scene.state).map(Some),
        };
        let folder = session.agree(opened)?;
        Ok(Run {
            session,
            case,
            kept: Kept::new(&scene.state),
            checkpoints: Checkpoints::new(case, restart.as_ref().map(Restart::step)),
            records: Records {
                session,
                case,
                folder,
                progress: Progress::new(shown, case.time.end, lead.then_some(&out)),
                log,
                out,
                measures,
                written,
                fields: Schedule::new(case.output.fields, scene.state.time),
                particles: Schedule::new(Some(case.output.rows()), scene.state.time),
            },
            stepper: Stepper::new(case, scene),
            cost: Cost::new(account),
            origin: Origin { commit: request.commit, notes: &loaded.notes, inherited, restart },
            interrupt,
            draw: request.draw,
        })
    }

    fn go(mut self) -> Result<()> {
        self.write_origin(None)?;
        self.say_what_begins()?;
        let state = &self.stepper.scene.state;
        self.records.progress.begin(state.steps, state.time);
        self.cost.begin(self.session, state.steps);
        let result = self.advance();
        let (status, result) = match result {
            Ok(()) => ("done", Ok(())),
            Err(stop @ Error::Interrupted(_)) => ("interrupted", Err(stop)),
            // The first solve refuses something that the user asked for.
            Err(refused @ Error::Usage(_)) => ("failed", Err(refused)),
            Err(e) => ("failed", Err(self.bring_back_kept(e)?)),
        };
        let state = &self.stepper.scene.state;
        let values = self.records.measures.values();
        self.records.progress.finish(status, state.steps, state.time, values);
        // A second error must not hide the first.
        let closed = self.close(status);
        if let Err(e) = &result {
            let kind = if let Error::Interrupted(_) = e { "" } else { "error: " };
            self.records.keep_error(&format!("{kind}{e}"));
        }
        result?;
        closed
    }

    /// Says what runs, what was taken over from other runs, and what the run is warned of.
    fn say_what_begins(&mut self) -> Result<()> {
        let scene = &self.stepper.scene;
        let log = &mut self.records.log;
        let cells =
            self.case.domain.cells.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
        let solver = scene.solver()?;
        let particles = self.case.particle.len();
        let ranks = self.session.size();
        log.say(&format!(
            "{}: {cells} cells, {particles} particle{}, {ranks} rank{}, {solver}, to t = {} s, \
            into {}",
            self.case.name,
            if particles == 1 { "" } else { "s" },
            if ranks == 1 { "" } else { "s" },
            self.case.time.end,
            self.records.out.display()
        ));
        let Origin { notes, inherited, restart, .. } = &self.origin;
        let idle = RunSize::of(self.case).advice(ranks);
        notes.iter().chain(inherited).chain(&idle).for_each(|line| log.say(line));
        for warning in crate::check::warnings(self.case, scene)? {
            log.say(&warning);
        }
        if let Some(restart) = restart {
            restart.say(log, self.case, scene.state.time, ranks);
        }
        Ok(())
    }

    /// Steps from the state that the run has to its end.
    ///
    /// ```text
    ///   while t < end    bodies through the boundaries; dt; step; refusals; rows, fields,
    ///                    checkpoint
    /// ```
    /// # Errors
    /// When a step fails or is refused, nothing can be written, or somebody interrupts the run.
    fn advance(&mut self) -> Result<()> {
        if self.origin.restart.is_none() {
            // Refuses a velocity that is not finite.
            self.stepper.scene.energy_and_speed()?;
            self.write_row(&StepOutcome::default())?;
            self.records.write_start(&mut self.stepper.scene)?;
        }
        let mut speed = 0.0;
        while self.stepper.begin_step() {
            let Some(came) = self.pass_boundaries()? else { break };
            self.kept.take(&self.stepper.scene.state, speed);
            let outcome = self.step(came)?;
            speed = outcome.speed;
            let requested = self.write_row(&outcome)?;
            self.records.write_due(&mut self.stepper.scene, &outcome)?;
            if requested.stop || requested.checkpoint {
                self.write_checkpoint()?;
                self.stepper.scene.domain.clock.lap(Stage::Fields);
            }
            if requested.stop {
                return Err(self.interrupted());
            }
        }
        self.records.write_last_fields(&mut self.stepper.scene)?;
        // A run may be given a later end, and others begin here.
        self.write_checkpoint()
    }

    /// Takes bodies out and lets others in, and says whether one came in; nothing where the run
    /// ends here.
    fn pass_boundaries(&mut self) -> Result<Option<bool>> {
        let passed = self.stepper.pass_boundaries(self.cost.account.dt)?;
        let state = &self.stepper.scene.state;
        self.records.write_passages(state, &passed)?;
        passed.ending(state.time).iter().for_each(|line| self.records.log.say(line));
        Ok(passed.last.is_none().then_some(passed.came))
    }

    /// Chooses a length and steps; the step is counted, and refused where energy was gained. Where
    /// a body `came` in, the flow is set off anew: the length of the step before says nothing.
    fn step(&mut self, came: bool) -> Result<StepOutcome> {
        let before = if came { None } else { self.cost.account.dt };
        let planned = self.stepper.plan(before)?;
        let stepped = self.stepper.step(&planned);
        if stepped.is_err() {
            self.records.write_failed_solves(&self.stepper, planned.dt);
        }
        let outcome = stepped?;
        self.cost.account.count(outcome.dt, &outcome.projected);
        self.stepper.judge(&outcome)?;
        Ok(outcome)
    }

    /// Writes a row of `steps.csv`; what ranks ask for is agreed on with it.
    fn write_row(&mut self, outcome: &StepOutcome) -> Result<Requested> {
        let scene = &self.stepper.scene;
        let written = self.records.write_row(scene, outcome, self.cost.wall());
        let due = self.checkpoints.due(scene.state.steps);
        // One message for all three, every step.
        let mut anywhere = [written.is_err(), self.interrupt.asked(), due].map(f64::from);
        self.session.max(&mut anywhere)?;
        let [failed, stop, checkpoint] = anywhere.map(|flag| flag > 0.0);
        written?;
        if failed {
            Err(Error::Run("rank 0 failed".into()))
        } else {
            Ok(Requested { stop, checkpoint })
        }
    }

    /// The end of a run that somebody stops.
    fn interrupted(&self) -> Error {
        let state = &self.stepper.scene.state;
        Error::Interrupted(format!(
            "interrupted after step {}, t = {:.6} s; the same command with --resume goes on from \
            there",
            state.steps, state.time
        ))
    }

    /// Writes a checkpoint, unless this step has one. Collective.
    fn write_checkpoint(&mut self) -> Result<()> {
        let scene = &mut self.stepper.scene;
        if self.checkpoints.newest == Some(scene.state.steps) {
            return Ok(());
        }
        let mut marks = self.records.mark()?;
        let Records { out, measures, written, .. } = &mut self.records;
        let contents = Contents {
            account: &mut self.cost.so_far(self.session, &scene.domain.clock)?,
            written,
            measures,
            marks: &mut marks,
            case: self.case,
            scene,
        };
        self.checkpoints.write(self.session, out, contents)
    }

    /// Writes `run.json`; `ended` is the time of day. Collective.
    fn write_origin(&mut self, ended: Option<&str>) -> Result<()> {
        let scene = &self.stepper.scene;
        let began = &self.cost.account.began;
        let record = self.origin.json(self.session, scene, began, ended)?;
        self.records.write_json("run.json", &record)
    }

    /// Brings back and writes the last state that was kept, unless writing is what failed, and
    /// returns the failure with its step and the place of that state. Collective.
    fn bring_back_kept(&mut self, error: Error) -> Result<Error> {
        let mut broken = [f64::from(matches!(error, Error::Io { .. } | Error::Petsc { .. }))];
        self.session.max(&mut broken)?;
        if broken[0] == 0.0 {
            self.kept.restore(&mut self.stepper.scene);
            let _ = self.records.write_last_fields(&mut self.stepper.scene);
        }
        let mut said = format!("{}: {error}", self.stepper.names_step());
        if let Some(step) = self.checkpoints.newest {
            said += &format!("; with the cause gone, --resume goes on after step {step}");
        }
        let folder = self.records.folder.as_ref();
        if let Some((time, path)) = folder.and_then(Folder::last_snapshot) {
            said += &format!(
                "; the last good state that was kept, of t = {time:.6} s, is {}",
                path.display()
            );
        }
        Ok(Error::Run(said))
    }

    /// Closes the logs, sums up and draws. Collective.
    ///
    /// # Errors
    /// When ranks cannot sum, or the folder cannot be written.
    fn close(&mut self, status: &str) -> Result<()> {
        let scene = &self.stepper.scene;
        if status != "failed" {
            self.records.measures.write_statistics(scene, &self.records.out)?;
        }
        let totals = self.cost.totals(self.session, scene)?;
        let unused = self.session.unused_options()?;
        self.write_origin(Some(&now()))?;
        let Records { folder: Some(folder), log, measures, out, .. } = &mut self.records else {
            return Ok(());
        };
        let summary = Summary {
            status,
            case: self.case,
            scene: &self.stepper.scene,
            account: &self.cost.account,
            measures,
            totals,
            ranks: self.session.size(),
        };
        let notes = summary.notes(&unused);
        let lines = summary.cost_lines().into_iter().chain(summary.outside());
        // Remarks stand beside their measures on the screen.
        let lines = lines.chain(notes.iter().cloned()).chain(measures.lines());
        lines.for_each(|line| log.say(&line));
        folder.write_json("summary.json", &summary.json(&notes))?;
        folder.flush(log)?;
        if status == "done" && self.case.output.figures {
            for path in (self.draw)(out)? {
                log.say(&format!("figure {}", path.display()));
            }
        }
        folder.flush(log)
    }
}
