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
use crate::poisson::pressure::Projected;
use crate::scene::Scene;
use crate::system::{cpu_seconds, now};
use crate::{Error, Result};
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
    /// C-HSMAC iterations, Krylov iterations, solves that were repeated, setups of the
    /// preconditioner.
    pub outer: u64,
    #[allow(missing_docs)]
    pub krylov: u64,
    #[allow(missing_docs)]
    pub retries: u64,
    #[allow(missing_docs)]
    pub setups: u64,
    /// The last step (s).
    pub dt: Option<f64>,
    /// Time of the newest snapshot (s).
    pub last_fields: Option<f64>,
    /// Step of the newest rows of particles.
    pub last_rows: Option<u64>,
}

impl Account {
    /// That of a run that begins now.
    pub(super) fn begin() -> Account {
        Account { began: now(), ..Account::default() }
    }

    /// Counts a step of `dt` (s).
    pub(super) fn count(&mut self, dt: f64, projected: &Projected) {
        self.dt = Some(dt);
        self.divergence_max = self.divergence_max.max(projected.divergence_max);
        self.outer += u64::from(projected.outer);
        self.krylov += u64::from(projected.krylov);
        self.retries += u64::from(projected.retries);
        self.setups += u64::from(projected.setups);
    }
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
            setups,
            dt,
            last_fields,
            last_rows,
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
            setups,
            dt,
            last_fields,
            last_rows,
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
        let mut cpu = [cpu_seconds()];
        let clock = self.scene.domain.clock.clone();
        self.session.sum(&mut cpu)?;
        let mut account = Account {
            wall: self.wall(),
            cpu: self.account.cpu + cpu[0],
            clock,
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
    /// The newest whole checkpoint in a run's folder; `explain` may change the error where there is
    /// none. Collective.
    pub fn open(
        session: &Session,
        run: &Path,
        explain: impl Fn(Error) -> Error,
    ) -> Result<Restart> {
        let found = if session.rank() == 0 { checkpoint::newest(run).map(Some) } else { Ok(None) };
        let found = session.agree(found.map_err(explain))?;
        let mut step = [found.as_ref().map_or(-1.0, |(step, _)| *step as f64)];
        session.max(&mut step)?;
        let step = step[0] as u64;
        let path = checkpoint::path(run, step);
        let mut header = Header::default();
        let read = checkpoint::open(run, step).and_then(|mut rest| {
            header
                .serialize(&mut Archive::read(session, &mut rest))
                .map_err(|e| misfit(&path, e))?;
            Ok(rest)
        });
        let rest = session.agree(read)?;
        Ok(Restart { step, path, header, rest, refused: found.map(|f| f.1).unwrap_or_default() })
    }

    /// The newest whole checkpoint in a run's folder, of the same case as far as a restart may not
    /// change it. Collective.
    ///
    /// # Errors
    /// When there is none, or the case is another one.
    pub fn find(session: &Session, run: &Path, loaded: &Loaded) -> Result<Restart> {
        let found = Restart::open(session, run, |e| e)?;
        session.agree(loaded.refuse_changes(&found.header.case).map_err(|e| match e {
            Error::Case { .. } => e,
            other => misfit(&found.path, other),
        }))?;
        Ok(found)
    }

    /// The case of the run that wrote it.
    ///
    /// # Errors
    /// Why it cannot be read, in words.
    pub fn case(&self) -> std::result::Result<Case, String> {
        written(&self.header.case)
    }

    /// Reads all that follows the header. Collective.
    pub fn read_contents<const D: usize>(
        &mut self,
        session: &Session,
        account: &mut Account,
        series: &mut [Series],
        statistics: &mut Option<Statistics<D>>,
        case: &Case,
        scene: &mut Scene<D>,
    ) -> Result<Marks> {
        let mut marks = Marks::default();
        let mut archive = Archive::read(session, &mut self.rest);
        let whole = serialize(&mut archive, account, series, &mut marks, statistics, case, scene);
        session.agree(whole).and_then(|()| archive.finish()).map_err(|e| misfit(&self.path, e))?;
        Ok(marks)
    }

    /// Reads it into the scene and what the run counts. Collective.
    ///
    /// # Errors
    /// When it does not fit, or the run has passed a limit of the case already.
    pub fn read<const D: usize>(
        &mut self,
        session: &Session,
        account: &mut Account,
        series: &mut [Series],
        statistics: &mut Option<Statistics<D>>,
        loaded: &Loaded,
        scene: &mut Scene<D>,
    ) -> Result<Marks> {
        let before = self.case().map_err(|why| misfit(&self.path, Error::Usage(why)))?;
        let mut kept = measure::series(&before);
        let marks =
            self.read_contents(session, account, &mut kept, statistics, &loaded.case, scene)?;
        scene.resume().map_err(|e| misfit(&self.path, e))?;
        scene.domain.clock.add(&account.clock);
        for new in series.iter_mut() {
            match kept.iter().position(|old| old.measure().is_of(new.measure())) {
                Some(at) => new.take_over(kept.swap_remove(at)),
                None => new.begin_at(scene.state.time),
            }
        }
        self.refuse_passed_limits(loaded, account, scene.state.time)?;
        Ok(marks)
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
    pub fn say(&self, log: &mut Log, case: &Case, time: f64, ranks: usize) {
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
        let before = self.case().map_or(Vec::new(), |before| before.measure);
        let new = |measure: &&Measure| !before.iter().any(|old| old.is_of(measure));
        let added = case.measure.iter().filter(new).map(|measure| measure.name.as_str());
        let added = added.collect::<Vec<_>>().join(", ");
        if !added.is_empty() {
            log.say(&format!(
                "measured from t = {time:.6} s on only, since the run before did not: {added}"
            ));
        }
    }

    /// Refuses limits of a case that the run has passed already, at `time` (s).
    ///
    /// # Errors
    /// With the key and what was reached.
    fn refuse_passed_limits(&self, loaded: &Loaded, account: &Account, time: f64) -> Result<()> {
        let case = &loaded.case;
        let reached = account.divergence_max;
        if reached >= case.pressure.divergence_limit {
            return Err(loaded.error_at(
                "pressure.divergence_limit",
                format!(
                    "the run that goes on has reached |D| = {reached:.3e} 1/s already; give a \
                    limit above that"
                ),
            ));
        }
        // A fixed step may pass the end: a run that was killed there has its summary and figures
        // left to write.
        let end = case.time.end;
        let same_end = self.case().is_ok_and(|before| before.time.end == end);
        if !same_end && end < time * (1.0 - 1e-12) {
            return Err(loaded.error_at(
                "time.end",
                format!(
                    "the run that goes on has reached {time} s already; give a later end than that"
                ),
            ));
        }
        Ok(())
    }

    /// The step after which it goes on.
    pub fn step(&self) -> u64 {
        self.step
    }
}

/// A whole checkpoint that cannot be read here.
fn misfit(path: &Path, e: Error) -> Error {
    match e {
        Error::Usage(why) | Error::Run(why) => Error::Usage(format!(
            "{}: this checkpoint does not fit: {why}; go on with the version of mics that wrote \
            it, or delete it to go on from the one before",
            path.display()
        )),
        other => other,
    }
}
