//! Checkpoints of a run: when one is due, what it holds, going on from one.

use super::cost::Account;
use super::measures::Measures;
use super::record::Written;
use crate::archive::{Archive, Checkpointed};
use crate::config::{Case, Loaded, Measure, refuse_changes, written};
use crate::output::checkpoint::{self, Header, Reader, Writer};
use crate::output::measure;
use crate::output::{Folder, Log, Marks};
use crate::petsc::Session;
use crate::scene::{self, Scene};
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Minutes of running time after which a run has its first checkpoint at the latest: one that is
/// killed before it has to begin anew.
const FIRST: f64 = 1.0;

/// When checkpoints are due and when the last one was written.
pub(super) struct Checkpoints {
    every: crate::config::Checkpoints,
    written: Instant,
    /// Step of the newest one.
    pub newest: Option<u64>,
}

impl Checkpoints {
    pub fn new(case: &Case, newest: Option<u64>) -> Checkpoints {
        Checkpoints { every: case.output.checkpoint, written: Instant::now(), newest }
    }

    /// Whether one is due after a step, by this rank's clock.
    pub fn due(&self, step: u64) -> bool {
        match self.every {
            crate::config::Checkpoints::Steps(n) => step.is_multiple_of(n),
            crate::config::Checkpoints::WallMinutes(most) => {
                let most = if self.newest.is_none() { most.min(FIRST) } else { most };
                self.written.elapsed().as_secs_f64() / 60.0 >= most
            }
        }
    }

    /// Writes a checkpoint into a run's folder. Collective.
    pub fn write<const D: usize>(
        &mut self,
        session: &Session,
        run: &Path,
        mut contents: Contents<D>,
    ) -> Result<()> {
        let step = contents.scene.state.steps;
        let mut writer = Writer::begin(session, run, step)?;
        let mut header = Header {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            case: contents.case.to_toml(),
            ranks: session.size() as u64,
        };
        let mut archive = Archive::write(session, &mut writer);
        header.serialize(&mut archive)?;
        contents.serialize(&mut archive)?;
        archive.finish()?;
        writer.commit(session)?;
        *self = Checkpoints::new(contents.case, Some(step));
        Ok(())
    }
}

/// Contents of a checkpoint after its header.
pub(super) struct Contents<'a, const D: usize> {
    pub account: &'a mut Account,
    pub written: &'a mut Written,
    pub measures: &'a mut Measures<D>,
    pub marks: &'a mut Marks,
    pub case: &'a Case,
    pub scene: &'a mut Scene<D>,
}

impl<const D: usize> Contents<'_, D> {
    /// Writes or reads all of it, in its one order. Collective.
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        self.account.serialize(archive)?;
        self.written.serialize(archive)?;
        archive.each("measures", &mut self.measures.series)?;
        self.marks.serialize(archive)?;
        let scene = &mut *self.scene;
        let mut ids = scene::ids(&scene.state.bodies);
        archive.label("roster")?;
        ids.serialize(archive)?;
        scene::keep_only(scene, self.case, &ids)?;
        let grid = &scene.domain.grid;
        scene.state.serialize(grid, archive)?;
        let statistics = self.measures.statistics.as_mut();
        statistics.map_or(Ok(()), |statistics| statistics.serialize(grid, archive))
    }
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
        session.agree(refuse_changes(loaded, &found.header.case).map_err(|e| match e {
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
        mut contents: Contents<D>,
    ) -> Result<()> {
        let mut archive = Archive::read(session, &mut self.rest);
        let whole = contents.serialize(&mut archive);
        session.agree(whole).and_then(|()| archive.finish()).map_err(|e| misfit(&self.path, e))
    }

    /// Reads it into the scene and what the run counts. Collective.
    ///
    /// # Errors
    /// When it does not fit, or the run has passed a limit of the case already.
    pub fn read<const D: usize>(
        &mut self,
        session: &Session,
        loaded: &Loaded,
        contents: Contents<D>,
    ) -> Result<()> {
        let before = self.case().map_err(|why| misfit(&self.path, Error::Usage(why)))?;
        let Contents { account, written, measures, marks, case, scene } = contents;
        let wanted = std::mem::replace(&mut measures.series, measure::series(&before));
        let read = Contents { account, written, measures, marks, case, scene };
        self.read_contents(session, read)?;
        scene.resume().map_err(|e| misfit(&self.path, e))?;
        scene.domain.clock.add(&account.clock);
        measures.go_on_with(wanted, scene.state.time);
        self.refuse_passed_limits(loaded, account, scene.state.time)
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

    /// Says in the log from where the run goes on, and what differs from before.
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
