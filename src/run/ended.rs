//! The end of another run, from which a case starts (`initial.from`): its bodies and its flow.

use super::cost::Account;
use super::measures::Measures;
use super::record::Written;
use super::restart::{Contents, Restart};
use crate::config::Case;
use crate::output::Marks;
use crate::petsc::Session;
use crate::scene::{self, Scene};
use crate::state::State;
use crate::{Error, Result};
use mics_run::vti::ArrayRows;
use std::path::{Path, PathBuf};

/// The scene of a case as a run begins with it, `from` where the run in a folder ended if there is
/// one, with what was taken over from there in lines. Collective.
///
/// # Errors
/// When the scene cannot be built, or that run is none to begin from.
pub(super) fn begin<const D: usize>(
    session: &Session,
    case: &Case,
    from: Option<&String>,
) -> Result<(Scene<D>, Vec<String>)> {
    let ended = from.map(|from| Ended::<D>::read(session, Path::new(from))).transpose()?;
    let mut scene = Scene::new(session, case)?;
    let inherited = match ended {
        Some(ended) => ended.initialise(session, case, &mut scene)?,
        None => Vec::new(),
    };
    Ok((scene, inherited))
}

/// Where another run ended: its case, the state, and its last snapshot.
struct Ended<const D: usize> {
    case: Case,
    state: State<D>,
    run: PathBuf,
}

impl<const D: usize> Ended<D> {
    /// Reads the end of the run in a folder. Comes before the scene that begins there, since the
    /// options of PETSc in force are those of the scene built last. Collective.
    ///
    /// # Errors
    /// When that run has not ended, or cannot be read.
    fn read(session: &Session, run: &Path) -> Result<Ended<D>> {
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
        let cure =
            "it has no whole checkpoint of its end: run it again, with a mics of this version";
        let mut end = Restart::open(session, run, |_| refuse(cure.into()))?;
        let before = end.case().map_err(|why| refuse(format!("its case cannot be read: {why}")))?;
        let mut scene = Scene::<D>::new(session, &before)?;
        let contents = Contents {
            account: &mut Account::default(),
            written: &mut Written::default(),
            measures: &mut Measures::new(&before, &scene),
            marks: &mut Marks::default(),
            case: &before,
            scene: &mut scene,
        };
        end.read_contents(session, contents)?;
        Ok(Ended { case: before, state: scene.state, run: run.to_owned() })
    }

    /// Initialises the scene of a case from here; returns what was taken and what not, in lines.
    /// Collective.
    ///
    /// # Errors
    /// When the snapshot cannot be read, or bodies are elsewhere than the case has them.
    fn initialise(
        self,
        session: &Session,
        case: &Case,
        scene: &mut Scene<D>,
    ) -> Result<Vec<String>> {
        let bodies = self.bodies();
        let Ended { case: before, state, run } = self;
        let taken = if scene::go_on_from(scene, case, &before, state)? {
            "the whole state, bit for bit"
        } else {
            let newest =
                newest_snapshot(&run).ok_or_else(|| refuse(&run, "it has no fields".into()))?;
            let velocity = ArrayRows::open(&newest, "velocity");
            let velocity = velocity.map_err(|e| refuse(&run, e.to_string()));
            let missing = || refuse(&run, "its last snapshot has no velocity".into());
            let velocity = session.agree(velocity.and_then(|rows| rows.ok_or_else(missing)))?;
            scene::start_from(scene, &velocity)?;
            "the velocity, interpolated"
        };
        let first = format!("begins where {} ended: {taken}", run.display());
        Ok([first].into_iter().chain(bodies).collect())
    }

    /// Lines on that run's bodies, where not all of them come over by their numbers.
    fn bodies(&self) -> Vec<String> {
        let there = &self.state.bodies;
        let waiting = self.state.waiting.len();
        let gone = self.case.particle.len().saturating_sub(there.len() + waiting);
        let mut lines = Vec::new();
        let mut numbers: Vec<usize> = there.iter().map(|body| body.id).collect();
        numbers.sort_unstable();
        if numbers.iter().enumerate().any(|(k, id)| *id != k) {
            let count = numbers.len();
            let listed = spans(&numbers);
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

/// The newest snapshot in a run's folder.
fn newest_snapshot(run: &Path) -> Option<PathBuf> {
    let paths = std::fs::read_dir(run.join("fields")).ok()?.flatten().map(|entry| entry.path());
    paths.filter(|path| path.extension().is_some_and(|ending| ending == "vti")).max()
}
