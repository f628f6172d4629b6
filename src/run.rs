//! A run: from the command line's words to a folder of results. The time loop, its dt, its schedule
//! and its end.

mod ended;
mod energy_bound;
mod export;
mod passage;
mod record;
mod restart;
mod summary;
mod time_loop;

use crate::check::check_memory;
use crate::config::{Case, Loaded};
use crate::interrupt::Interrupt;
use crate::launch::Work;
use crate::output::measure::{self, Series};
use crate::output::probe::Probes;
use crate::output::progress::Progress;
use crate::output::statistics::Statistics;
use crate::output::{Folder, Log, may_use, refuse_held};
use crate::petsc::{Session, Traffic};
use crate::poisson::pressure::Projected;
use crate::scene::{Scene, read_case};
use crate::state::Readable;
use crate::{Error, Result};
use ended::Ended;
use export::Awaited;
pub use export::{Exported, Moment, Wanted, system_of};
pub use restart::Account;
use restart::{Checkpoints, Restart};
use std::path::{Path, PathBuf};
use std::time::Instant;

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
    Run::<D>::new(&session, loaded, request, Some(out), interrupt, restart)?.go()
}

struct Run<'a, const D: usize> {
    session: &'a Session,
    case: &'a Case,
    scene: Scene<D>,
    /// Empty where the run leaves no folder.
    out: PathBuf,
    /// On rank 0.
    folder: Option<Folder>,
    log: Log,
    series: Vec<Series>,
    probes: Probes,
    statistics: Option<Statistics<D>>,
    progress: Progress,
    started: Instant,
    account: Account,
    /// Step and what this rank had told others when the time loop began.
    before: (u64, Traffic),
    interrupt: Interrupt,
    checkpoints: Checkpoints,
    restart: Option<Restart>,
    /// What was taken over from the run that `initial.from` names, in lines.
    inherited: Vec<String>,
    /// What is to be said of the case file, in lines.
    notes: &'a [String],
    /// Steps done and time (s) at the start of the step.
    began: (u64, f64),
    /// A state of late, for a run that fails.
    good: Readable<D>,
    draw: Draw,
    commit: &'static str,
    /// The solve that the run is made for, if it is made for one.
    awaited: Option<Awaited>,
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
        out: Option<PathBuf>,
        interrupt: Interrupt,
        mut restart: Option<Restart>,
    ) -> Result<Self> {
        let case = &loaded.case;
        let from = case.initial.from.as_ref().filter(|_| restart.is_none());
        let ended = from.map(|from| Ended::<D>::read(session, Path::new(from))).transpose()?;
        let mut scene = Scene::<D>::new(session, case)?;
        let (mut account, mut series) = (Account::begin(), measure::series(case));
        let inherited =
            ended.map_or(Ok(Vec::new()), |ended| ended.initialise(session, case, &mut scene))?;
        let mut statistics = Statistics::of_case(&scene, case);
        let marks = restart.as_mut().map(|restart| {
            let (account, series, statistics) = (&mut account, &mut series, &mut statistics);
            restart.read(session, account, series, statistics, loaded, &mut scene)
        });
        let marks = marks.transpose()?;
        crate::check::refuse(loaded, &scene)?;
        let (lead, every) = (session.rank() == 0, case.output.checkpoint);
        let mut log = Log::new(lead && !request.quiet);
        let kept = out.as_deref().filter(|_| lead);
        let opened = kept.map(|out| match (&restart, marks) {
            (Some(restart), Some(marks)) => restart.open_folder(out, &mut log, case, marks),
            _ => Folder::create(out, &mut log, case, &scene.state),
        });
        let folder = session.agree(opened.transpose())?;
        let mut good = Readable::default();
        scene.state.keep(&mut good);
        Ok(Run {
            began: (scene.state.steps, scene.state.time),
            good,
            draw: request.draw,
            commit: request.commit,
            folder,
            progress: Progress::new(lead && !request.quiet, case.time.end, kept),
            checkpoints: Checkpoints::new(every, restart.as_ref().map(Restart::step)),
            series,
            probes: Probes::new(&case.probe),
            statistics,
            account,
            before: Default::default(),
            interrupt,
            restart,
            inherited,
            notes: &loaded.notes,
            session,
            case,
            scene,
            out: out.unwrap_or_default(),
            log,
            awaited: None,
            started: Instant::now(),
        })
    }

    fn go(mut self) -> Result<()> {
        self.write_run(None)?;
        self.say_what_begins()?;
        self.progress.begin(self.scene.state.steps, self.scene.state.time);
        self.before = (self.scene.state.steps, self.session.traffic());
        let result = self.advance();
        let (status, result) = match result {
            Ok(()) => ("done", Ok(())),
            Err(stop @ Error::Interrupted(_)) => ("interrupted", Err(stop)),
            // What the user asked for and the first solve refuses.
            Err(refused @ Error::Usage(_)) => ("failed", Err(refused)),
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

    /// Says what runs, what was taken over from other runs, and what the run is warned of.
    fn say_what_begins(&mut self) -> Result<()> {
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
        let idle = Work::of(self.case).advice(self.session.size());
        self.notes.iter().chain(&self.inherited).chain(&idle).for_each(|line| self.log.say(line));
        for warning in crate::check::warnings(self.case, &self.scene)? {
            self.log.say(&warning);
        }
        if let Some(restart) = &self.restart {
            restart.say(&mut self.log, self.case, self.scene.state.time, self.session.size());
        }
        Ok(())
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
}
