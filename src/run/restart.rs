//! Checkpoints of a run: what it counts, writing one, going on from one.

use super::Run;
use crate::archive::{Archive, Checkpointed};
use crate::clock::Clock;
use crate::config::{Case, Loaded, Measure, written};
use crate::output::checkpoint::{self, Header, Reader, Writer};
use crate::output::measure::{self, Series};
use crate::output::statistics::Statistics;
use crate::output::{Folder, Log, Marks};
use crate::petsc::Session;
use crate::scene::Scene;
use crate::state::State;
use crate::system::cpu_seconds;
use crate::{Error, Result};
use mics_run::vti::Rows;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What a run has counted so far, in all its sessions.
#[derive(Clone, Debug, Default)]
pub struct Account {
    /// When it began, in words.
    pub began: String,
    /// Seconds that it took before this session, those of all cores, and where they went.
    pub wall: f64,
    #[allow(missing_docs)]
    pub cpu: f64,
    #[allow(missing_docs)]
    pub clock: Clock,
    /// Largest |D| (1/s).
    pub divergence_max: f64,
    /// C-HSMAC iterations, Krylov iterations, and solves that were repeated.
    pub outer: u64,
    #[allow(missing_docs)]
    pub krylov: u64,
    #[allow(missing_docs)]
    pub retries: u64,
    /// The last step (s).
    pub dt: Option<f64>,
    /// Time of the newest snapshot (s).
    pub last_fields: Option<f64>,
    /// Step of the newest rows of particles.
    pub last_rows: Option<u64>,
    /// What measures and outputs that a library's user has added go on with.
    pub added: String,
}

impl Checkpointed for Account {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Account {
            began,
            wall,
            cpu,
            clock,
            divergence_max,
            outer,
            krylov,
            retries,
            dt,
            last_fields,
            last_rows,
            added,
        } = self;
        archive.label("run")?;
        archive.serialize([
            began,
            wall,
            cpu,
            clock,
            divergence_max,
            outer,
            krylov,
            retries,
            dt,
            last_fields,
            last_rows,
            added,
        ])
    }
}

/// When checkpoints are due and when the last one was written.
pub(super) struct Checkpoints {
    every: crate::config::Checkpoints,
    written: Instant,
    /// Step of the newest one.
    pub newest: Option<u64>,
}

impl Checkpoints {
    pub fn new(every: crate::config::Checkpoints, newest: Option<u64>) -> Checkpoints {
        Checkpoints { every, written: Instant::now(), newest }
    }

    /// Whether one is due after a step, by this rank's clock.
    pub fn due(&self, step: u64) -> bool {
        match self.every {
            crate::config::Checkpoints::Steps(n) => step.is_multiple_of(n),
            crate::config::Checkpoints::WallMinutes(most) => {
                self.written.elapsed().as_secs_f64() / 60.0 >= most
            }
        }
    }
}

impl<const D: usize> Run<'_, D> {
    /// Writes a checkpoint, unless this step has one. Collective.
    pub(super) fn checkpoint(&mut self) -> Result<()> {
        let step = self.scene.state.steps;
        if self.checkpoints.newest == Some(step) {
            return Ok(());
        }
        let marked = self
            .folder
            .as_mut()
            .map_or(Ok(Marks::default()), |folder| folder.mark(&mut self.log, &self.progress));
        let mut marks = self.session.agree(marked)?;
        let mut writer = Writer::begin(self.session, &self.out, step)?;
        let mut header = Header {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            case: self.case.to_toml(),
            ranks: self.session.size() as u64,
        };
        let added = self.added.kept(self.session)?;
        let (mut cpu, clock) = ([cpu_seconds()], self.scene.domain.clock.clone());
        self.session.sum(&mut cpu)?;
        let mut account = Account {
            wall: self.wall(),
            cpu: self.account.cpu + cpu[0],
            clock,
            added,
            ..self.account.clone()
        };
        let mut archive = Archive::write(self.session, &mut writer);
        header.serialize(&mut archive)?;
        serialize(
            &mut archive,
            &mut account,
            &mut self.series,
            &mut marks,
            &mut self.statistics,
            self.case,
            &mut self.scene,
        )?;
        archive.finish()?;
        writer.commit(self.session)?;
        self.checkpoints = Checkpoints::new(self.case.output.checkpoint, Some(step));
        Ok(())
    }
}

/// The one order of a checkpoint after its header.
fn serialize<const D: usize>(
    archive: &mut Archive,
    account: &mut Account,
    series: &mut [Series],
    marks: &mut Marks,
    statistics: &mut Option<Statistics<D>>,
    case: &Case,
    scene: &mut Scene<D>,
) -> Result<()> {
    account.serialize(archive)?;
    archive.each("measures", series)?;
    marks.serialize(archive)?;
    let mut ids = scene.ids();
    archive.label("roster")?;
    ids.serialize(archive)?;
    scene.keep_only(case, &ids)?;
    scene.state.serialize(&scene.domain.grid, archive)?;
    statistics
        .as_mut()
        .map_or(Ok(()), |statistics| statistics.serialize(&scene.domain.grid, archive))
}

/// A checkpoint to go on from, its header read.
pub(super) struct Restart {
    step: u64,
    path: PathBuf,
    header: Header,
    rest: Reader,
    /// Newer ones that are damaged, and why.
    refused: Vec<String>,
}

impl Restart {
    /// The newest whole checkpoint in a run's folder, of the same case as far as a restart may not
    /// change it. Collective.
    ///
    /// # Errors
    /// When there is none, or the case is another one.
    pub fn find(session: &Session, run: &Path, loaded: &Loaded) -> Result<Restart> {
        let found = if session.rank() == 0 { checkpoint::newest(run).map(Some) } else { Ok(None) };
        let found = session.agree(found)?;
        let mut step = [found.as_ref().map_or(-1.0, |(step, _)| *step as f64)];
        session.max(&mut step)?;
        let step = step[0] as u64;
        let (path, mut header) = (checkpoint::path(run, step), Header::default());
        let read = checkpoint::open(run, step).and_then(|mut rest| {
            header
                .serialize(&mut Archive::read(session, &mut rest))
                .map_err(|e| misfit(&path, e))?;
            Ok(rest)
        });
        let rest = session.agree(read)?;
        session.agree(loaded.refuse_changes(&header.case).map_err(|e| match e {
            Error::Case { .. } => e,
            other => misfit(&path, other),
        }))?;
        Ok(Restart { step, path, header, rest, refused: found.map(|f| f.1).unwrap_or_default() })
    }

    /// Reads it into the scene and what the run counts. Collective.
    pub fn read<const D: usize>(
        &mut self,
        session: &Session,
        account: &mut Account,
        series: &mut [Series],
        statistics: &mut Option<Statistics<D>>,
        case: &Case,
        scene: &mut Scene<D>,
    ) -> Result<Marks> {
        let mut marks = Marks::default();
        let before =
            written(&self.header.case).map_err(|why| misfit(&self.path, Error::Usage(why)))?;
        let mut kept = measure::series(&before);
        let mut archive = Archive::read(session, &mut self.rest);
        let whole =
            serialize(&mut archive, account, &mut kept, &mut marks, statistics, case, scene);
        session.agree(whole).and_then(|()| archive.finish()).map_err(|e| misfit(&self.path, e))?;
        scene.resume().map_err(|e| misfit(&self.path, e))?;
        scene.domain.clock.add(&account.clock);
        for new in series.iter_mut() {
            match kept.iter().position(|old| old.measure().is_of(new.measure())) {
                Some(at) => new.take_over(kept.swap_remove(at)),
                None => new.begin_at(scene.state.time),
            }
        }
        Ok(marks)
    }

    /// The measures of the case that the run before has not had, and that count from here on.
    pub fn added<'a>(&self, case: &'a Case) -> Vec<&'a str> {
        let before = written(&self.header.case).map_or(Vec::new(), |before| before.measure);
        let new = |measure: &&Measure| !before.iter().any(|old| old.is_of(measure));
        case.measure.iter().filter(new).map(|measure| measure.name.as_str()).collect()
    }

    /// Takes up the run's folder. To be called by rank 0, once all else is known to fit.
    pub fn open_folder(
        &self,
        run: &Path,
        log: &mut Log,
        case: &Case,
        marks: Marks,
    ) -> Result<Folder> {
        let folder = Folder::go_on(run, log, case, marks)?;
        checkpoint::delete_after(run, self.step)?;
        Ok(folder)
    }

    /// What a reader of the log has to know.
    pub fn say(&self, log: &mut Log, time: f64, ranks: usize) {
        self.refused.iter().for_each(|why| log.say(&format!("refused {why}")));
        log.say(&format!(
            "goes on after step {}, t = {time:.6} s, from {}",
            self.step,
            self.path.display()
        ));
        if self.header.ranks != ranks as u64 {
            log.say(&format!(
                "on {ranks} rank{} after {}: the same to the solver's tolerance, not bit for bit",
                if ranks == 1 { "" } else { "s" },
                self.header.ranks
            ));
        }
    }

    /// Whether the run that wrote it was to end at this time (s).
    pub fn had_end(&self, end: f64) -> bool {
        written(&self.header.case).is_ok_and(|before| before.time.end == end)
    }

    /// The step after which it goes on.
    pub fn step(&self) -> u64 {
        self.step
    }
}

/// Where another run ended: its case, the state, and its last snapshot.
pub(super) struct Ended<const D: usize> {
    case: Case,
    state: State<D>,
    run: PathBuf,
}

impl<const D: usize> Ended<D> {
    /// That of the run in a folder. Comes before the scene that begins there, since what solves its
    /// pressure is told by what was built last. Collective.
    ///
    /// # Errors
    /// When that run has not ended, or cannot be read.
    pub fn read(session: &Session, run: &Path) -> Result<Ended<D>> {
        read_end(session, run)
    }

    /// Lets the scene of a case begin here; returns what was taken and what was not, in lines.
    /// Collective.
    ///
    /// # Errors
    /// When the snapshot cannot be read, or bodies are elsewhere than the case has them.
    pub fn begin(
        self,
        session: &Session,
        case: &Case,
        scene: &mut Scene<D>,
    ) -> Result<Vec<String>> {
        let bodies = self.bodies();
        let where_ended = format!("begins where {} ended", self.run.display());
        let Ended { case: before, state, run } = self;
        if scene.go_on_from(case, &before, state)? {
            return Ok([format!("{where_ended}: all that lasts")]
                .into_iter()
                .chain(bodies)
                .collect());
        }
        let newest =
            newest_snapshot(&run).ok_or_else(|| refuse(&run, "it has no fields".into()))?;
        let velocity = Rows::open(&newest, "velocity").map_err(|e| refuse(&run, e.to_string()));
        let missing = || refuse(&run, "its last snapshot has no velocity".into());
        let velocity = session.agree(velocity.and_then(|rows| rows.ok_or_else(missing)))?;
        scene.start_from(&velocity)?;
        Ok([format!("{where_ended}: the velocity, interpolated")]
            .into_iter()
            .chain(bodies)
            .collect())
    }

    /// What became of that run's bodies, where not all of them come over by their numbers: in
    /// lines.
    fn bodies(&self) -> Vec<String> {
        let (there, waiting) = (&self.state.bodies, self.state.waiting.len());
        let gone = self.case.particle.len().saturating_sub(there.len() + waiting);
        let mut lines = Vec::new();
        if there.iter().enumerate().any(|(k, body)| body.id != k) {
            let there: Vec<usize> = there.iter().map(|body| body.id).collect();
            let (count, listed) = (there.len(), spans(&there));
            lines.push(format!(
                "its particles {listed} come over and are 0 to {} here, in that order",
                count - 1
            ));
        }
        if waiting > 0 {
            let them =
                if waiting == 1 { "1 particle that" } else { &format!("{waiting} particles that") };
            lines.push(format!(
                "{them} waited there to come in stay behind: only what this case feeds comes in"
            ));
        }
        if gone > 0 {
            let them = if gone == 1 { "1 particle" } else { &format!("{gone} particles") };
            lines.push(format!("{them} had left through an outflow there"));
        }
        lines
    }
}

/// Ascending numbers in words, runs of them by their ends: "0, 3 to 7, 9".
fn spans(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b).map(|run| match run {
        [first, _, .., last] => format!("{first} to {last}"),
        few => few.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
    });
    runs.collect::<Vec<_>>().join(", ")
}

fn refuse(run: &Path, why: String) -> Error {
    Error::Usage(format!("initial.from: {}: {why}", run.display()))
}

fn read_end<const D: usize>(session: &Session, run: &Path) -> Result<Ended<D>> {
    let refuse = |why: String| refuse(run, why);
    session.agree(if run.join("case.toml").is_file() {
        Ok(())
    } else {
        Err(refuse(
            "holds no run (no case.toml in it); name the folder that `mics run` wrote".into(),
        ))
    })?;
    let status = std::fs::read_to_string(run.join("summary.json")).ok();
    let status = status.and_then(|text| serde_json::from_str::<serde_json::Value>(&text).ok());
    let ended = status.is_some_and(|summary| summary["status"] == "done");
    session.agree(if ended {
        Ok(())
    } else {
        Err(refuse("that run has not ended: bring it to its end with --resume".into()))
    })?;
    let found = if session.rank() == 0 { checkpoint::newest(run).map(Some) } else { Ok(None) };
    let cure = "it has no whole checkpoint of its end: run it again, with a mics of this version";
    let found = found.map_err(|_| refuse(cure.into()));
    let mut step = [session.agree(found)?.map_or(-1.0, |(step, _)| step as f64)];
    session.max(&mut step)?;
    let (step, mut header) = (step[0] as u64, Header::default());
    let mut rest = session.agree(checkpoint::open(run, step))?;
    let mut archive = Archive::read(session, &mut rest);
    header.serialize(&mut archive)?;
    let before =
        written(&header.case).map_err(|why| refuse(format!("its case cannot be read: {why}")))?;
    let mut ended = Scene::<D>::new(session, &before)?;
    let (mut account, mut series, mut marks) =
        (Account::default(), measure::series(&before), Marks::default());
    let mut statistics = Statistics::of_case(&ended, &before);
    let whole = serialize(
        &mut archive,
        &mut account,
        &mut series,
        &mut marks,
        &mut statistics,
        &before,
        &mut ended,
    );
    session
        .agree(whole)
        .and_then(|()| archive.finish())
        .map_err(|e| misfit(&checkpoint::path(run, step), e))?;
    Ok(Ended { case: before, state: ended.state, run: run.to_owned() })
}

/// The newest snapshot in a run's folder.
fn newest_snapshot(run: &Path) -> Option<PathBuf> {
    let paths = std::fs::read_dir(run.join("fields")).ok()?.flatten().map(|entry| entry.path());
    paths.filter(|path| path.extension().is_some_and(|ending| ending == "vti")).max()
}

/// A whole checkpoint that cannot be read here.
fn misfit(path: &Path, e: Error) -> Error {
    match e {
        Error::Usage(why) | Error::Run(why) => Error::Usage(format!(
            "{}: this checkpoint does not fit: {why}; go on with the version of mics that wrote \
            it, or delete it to go on \
             from the one before",
            path.display()
        )),
        other => other,
    }
}
