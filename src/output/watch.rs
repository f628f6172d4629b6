//! `mics watch`: follows runs until they end, from another terminal, by their `progress.jsonl`: the
//! bar of `mics run` for each, or a line every few seconds.

use super::progress;
use crate::{Error, Result};
use indicatif::{MultiProgress, ProgressBar};
use mics_run::progress::{FILE, Record};
use mics_run::summary::Provenance;
use mics_run::{not_a_run, print};
use std::fs::File;
use std::io::{Read as _, Seek as _};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// How often it looks.
const LOOK_EVERY: Duration = Duration::from_millis(200);

/// A run that is followed.
struct Follower<'a> {
    run: &'a Path,
    /// What its lines begin with: its folder, of one among others.
    name: String,
    /// Whether it runs on this machine.
    here: bool,
    path: PathBuf,
    file: File,
    /// Of a line that is not whole yet.
    text: Vec<u8>,
    newest: Record,
    bar: Option<ProgressBar>,
    said: Option<Instant>,
    ended: bool,
}

impl<'a> Follower<'a> {
    fn new(run: &'a Path, alone: bool) -> Result<Follower<'a>> {
        let provenance = Provenance::read(run)?;
        let path = run.join(FILE);
        let file = File::open(&path).map_err(|e| not_a_run(run, &format!("{FILE}: {e}")))?;
        Ok(Follower {
            run,
            name: if alone { String::new() } else { format!("{}: ", run.display()) },
            here: provenance.host == crate::system::host(),
            path,
            file,
            text: Vec::new(),
            newest: Record { pid: provenance.pid, ..Record::default() },
            bar: None,
            said: None,
            ended: false,
        })
    }

    /// Reads what is new, and shows it.
    fn look(&mut self) -> Result<()> {
        // Looked at before the file, so that the last words of a process that ends now are still
        // read.
        let gone = self.here
            && self.newest.pid > 0
            && !Path::new("/proc").join(self.newest.pid.to_string()).exists();
        let latest = self.read()?;
        let fresh = latest.is_some();
        self.newest = latest.unwrap_or(std::mem::take(&mut self.newest));
        if let (true, Some(bar)) = (fresh, &self.bar) {
            progress::show(bar, &self.newest);
        }
        self.ended = gone || !matches!(self.newest.status.as_str(), "" | "running");
        let due = self.said.is_none_or(|at| at.elapsed() >= progress::LINE_EVERY);
        if fresh && self.bar.is_none() && !self.ended && due {
            self.say(&self.newest.line())?;
            self.said = Some(Instant::now());
        }
        Ok(())
    }

    /// The newest record since the last look.
    fn read(&mut self) -> Result<Option<Record>> {
        self.read_on().map_err(Error::io(&self.path))?;
        let whole = self.text.iter().rposition(|b| *b == b'\n').map_or(0, |end| end + 1);
        let lines: Vec<u8> = self.text.drain(..whole).collect();
        let records = String::from_utf8_lossy(&lines);
        Ok(records.lines().rev().find_map(|line| serde_json::from_str::<Record>(line).ok()))
    }

    /// Takes what the file has more; all of it where it has been cut.
    fn read_on(&mut self) -> std::io::Result<()> {
        if self.file.metadata()?.len() < self.file.stream_position()? {
            self.file.rewind()?;
            self.text.clear();
        }
        self.file.read_to_end(&mut self.text).map(drop)
    }

    fn say(&self, line: &str) -> Result<()> {
        print(&format!("{}{line}", self.name))
    }

    /// Says how it ended.
    ///
    /// # Errors
    /// When it failed, was interrupted, or was killed.
    fn close(&self) -> Result<()> {
        self.say(&self.newest.line())?;
        let Record { measures, time, step, pid, status, .. } = &self.newest;
        measures.iter().try_for_each(|(name, value)| self.say(&format!("{name} = {value}")))?;
        let (at, run) = (format!("at t = {time:.6} s, step {step}"), self.run.display());
        match status.as_str() {
            "done" => self.say(&format!("done {at}")),
            "running" | "" => Err(Error::Run(format!(
                "{run}: process {pid} was killed: it is gone without an end; last update {at}"
            ))),
            "interrupted" => Err(Error::Interrupted(format!(
                "{run}: the run was interrupted {at}, with exit status {}; its command with \
                --resume goes on from there",
                crate::error::INTERRUPTED
            ))),
            _ => Err(Error::Run(format!("{run}: the run failed {at}; log.txt says why"))),
        }
    }
}

/// The bar of a run that ranks compute which this process has started.
pub struct Glance {
    run: PathBuf,
    bar: ProgressBar,
    looked: Instant,
}

impl Glance {
    /// That of the run in a folder, which need not be there yet; `None` where standard error is no
    /// terminal that can draw it.
    pub fn at(run: &Path) -> Option<Glance> {
        progress::bar().map(|bar| Glance { run: run.to_owned(), bar, looked: Instant::now() })
    }

    /// Shows the newest record, once a second.
    pub fn look(&mut self) {
        if self.looked.elapsed() < progress::RECORD_EVERY {
            return;
        }
        self.looked = Instant::now();
        let newest = Record::newest(&self.run).filter(|newest| newest.status == "running");
        newest.iter().for_each(|newest| progress::show(&self.bar, newest));
    }

    /// Takes the bar away.
    pub fn close(&self) {
        self.bar.finish_and_clear();
    }
}

/// Follows runs until all have ended.
///
/// # Errors
/// When a folder holds no run, before anything is followed; or that of the first run that did not
/// end well, as it ends itself. What went wrong with others is said.
pub fn watch(runs: &[PathBuf]) -> Result<()> {
    let mut all: Vec<_> =
        runs.iter().map(|run| Follower::new(run, runs.len() == 1)).collect::<Result<_>>()?;
    let bars = MultiProgress::new();
    for one in &mut all {
        one.bar = progress::bar().map(|bar| bars.add(bar.with_prefix(one.name.clone())));
    }
    let mut wrong = None;
    while all.iter().any(|one| !one.ended) {
        for one in all.iter_mut().filter(|one| !one.ended) {
            one.look()?;
            if !one.ended {
                continue;
            }
            if let Some(bar) = one.bar.take() {
                bar.finish_and_clear();
                bars.remove(&bar);
            }
            match (one.close(), &wrong) {
                (Ok(()), _) => {}
                (Err(e), None) => wrong = Some(e),
                (Err(e), Some(_)) => print(&e.to_string())?,
            }
        }
        sleep(LOOK_EVERY);
    }
    wrong.map_or(Ok(()), Err)
}
