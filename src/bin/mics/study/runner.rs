//! The runs of a study, one after another, repeat by repeat: the same command goes on where it was
//! stopped.

use super::child::{self, Bounds, Outcome};
use super::plan::Plan;
use super::planned::Planned;
use super::show::short;
use mics_run::interrupt::Interrupt;
use mics_run::{Error, Result};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The copy of the study file that marks a study's folder.
pub const COPY: &str = "study.toml";

/// Refuses ranks that somebody else started, and a folder that holds something other than a study.
pub fn may_start(command: &str, folder: &Path) -> Result<()> {
    if std::env::var("OMPI_COMM_WORLD_SIZE").is_ok_and(|size| size != "1") {
        return Err(Error::Usage(format!("{command} starts its runs by itself: without mpirun")));
    }
    let refuse = |why: &str| Err(Error::Usage(format!("{}: {why}", folder.display())));
    match fs::read_dir(folder).map(|mut entries| entries.next().is_none()) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(e) => refuse(&format!("cannot be made a study's folder: {e}; give another --out")),
        Ok(empty) if empty || folder.join(COPY).exists() => Ok(()),
        Ok(_) => refuse(
            "the folder exists and holds no study (no study.toml); give another folder with --out",
        ),
    }
}

/// The runs of a plan in a folder.
pub struct Runner<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// The study's folder.
    pub folder: &'a Path,
    /// Number of times that each run is done.
    pub repeats: usize,
    /// Wall-clock time that a run may take (s).
    pub limit_seconds: Option<f64>,
    /// Whether runs that are finished are repeated.
    pub force: bool,
    /// Says a line of progress.
    pub say: fn(&str) -> Result<()>,
}

/// The ends of the repeats of each run, in the plan's order.
pub type Outcomes = Vec<Vec<Outcome>>;

impl Runner<'_> {
    /// The folder of a repeat of a run.
    pub fn place(&self, run: &Planned, repeat: usize) -> PathBuf {
        self.folder.join("runs").join(&run.id).join((repeat + 1).to_string())
    }

    /// The end of a repeat of a run that is done already.
    pub fn kept(&self, run: &Planned, repeat: usize) -> Option<Outcome> {
        if self.force { None } else { child::kept(run, &self.place(run, repeat)) }
    }

    /// Runs what is not done yet; a run that is not done once is not repeated. `after` is called
    /// after every run.
    ///
    /// # Errors
    /// When this program cannot be started, a folder cannot be written, or somebody interrupts it.
    pub fn go(&self, after: &dyn Fn(&Outcomes) -> Result<()>) -> Result<Outcomes> {
        let mut outcomes = self.refused()?;
        let limit = self.limit_seconds.map(Duration::from_secs_f64);
        let bounds = Bounds { limit, interrupt: Interrupt::listen()? };
        let runs = self.plan.runs.iter().enumerate();
        let all = (0..self.repeats).flat_map(|repeat| runs.clone().map(move |run| (repeat, run)));
        let total = self.plan.runs.len() * self.repeats;
        for (count, (repeat, (index, run))) in all.enumerate() {
            if outcomes[index].iter().any(|outcome| outcome.status != "done") {
                continue;
            }
            let name = format!("{}/{total} {}", count + 1, run.id);
            outcomes[index].push(self.one(run, repeat, &name, &bounds)?);
            after(&outcomes)?;
            if bounds.interrupt.asked() {
                let words = "interrupted; the same command goes on with what is not done";
                return Err(Error::Interrupted(words.into()));
            }
        }
        let others = outcomes.iter().flatten().filter(|outcome| outcome.commit != crate::COMMIT);
        match others.count() {
            0 => {}
            older => (self.say)(&format!(
                "{older} runs were kept that another build of mics did; --force does them again"
            ))?,
        }
        Ok(outcomes)
    }

    /// The runs that are refused, by their scenes too, said before the first one starts.
    fn refused(&self) -> Result<Outcomes> {
        let of = |run: &Planned| {
            if (0..self.repeats).all(|repeat| self.kept(run, repeat).is_some()) {
                return Ok(Vec::new());
            }
            let Some(why) = child::refusal(run)? else { return Ok(Vec::new()) };
            (self.say)(&format!("{} is refused: {why}", run.id))?;
            Ok(vec![Outcome::refused(&why)])
        };
        self.plan.runs.iter().map(of).collect()
    }

    /// Does a repeat of a run, unless it is done, and says how it ended.
    fn one(&self, run: &Planned, repeat: usize, name: &str, bounds: &Bounds) -> Result<Outcome> {
        let folder = self.place(run, repeat);
        let kept = self.kept(run, repeat);
        let word = if kept.is_some() { "kept" } else { "done" };
        let outcome = kept.map_or_else(|| child::run(run, &folder, name, bounds), Ok)?;
        if ["done", "too slow"].contains(&outcome.status) {
            child::drop_fields(&folder)?;
        }
        let end = match (outcome.status, outcome.summary["cpu_seconds"].as_f64()) {
            ("done", Some(cpu)) => {
                let remark = if outcome.message.is_empty() { "" } else { "; " };
                format!("{word}, {} CPU s{remark}{}", short(cpu), outcome.message)
            }
            (status, _) => format!("{status}: {}", outcome.message),
        };
        let again = if self.repeats > 1 { format!(", repeat {}", repeat + 1) } else { "".into() };
        (self.say)(&format!("{name}{again}: {end}"))?;
        Ok(outcome)
    }
}
