//! Progress of a run: one record, at most one a second, shown as a bar on a terminal, as a line now
//! and then elsewhere, and kept in `progress.jsonl`.
//!
//! ```text
//!   left = (end - t)/pace      pace: flow time a second, a mean that forgets over the last third
//!                              of the run: steps grow at
//!                              its start, and later follow what moves
//! ```

use crate::{Error, Result};
use indicatif::{ProgressBar, ProgressStyle};
use mics_run::progress::{FILE, Record};
use serde_json::{Map, Value};
use std::fs::File;
use std::io::{ErrorKind, IsTerminal, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Least time between two records.
const RECORD_EVERY: Duration = Duration::from_secs(1);
/// Time between plain lines.
const LINE_EVERY: Duration = Duration::from_secs(5);
/// The part of the seconds spent over which the pace forgets.
const MEMORY: f64 = 1.0 / 3.0;

/// A bar, where standard error is a terminal that can draw one.
fn bar() -> Option<ProgressBar> {
    let draws = std::io::stderr().is_terminal()
        && std::env::var_os("TERM").is_none_or(|term| term != "dumb");
    draws.then(|| {
        let style = ProgressStyle::with_template("{bar:20} {percent:>3} %  {msg}");
        ProgressBar::new(1000).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
    })
}

/// Shows a record on a bar.
fn show(bar: &ProgressBar, record: &Record) {
    bar.set_position((1000.0 * record.done()) as u64);
    bar.set_message(record.describe());
}

/// Shows and keeps how far a run is.
pub struct Progress {
    bar: Option<ProgressBar>,
    lines: bool,
    /// The file `progress.jsonl`, on rank 0.
    file: Option<File>,
    newest: Record,
    started: Instant,
    /// Step and time (s) that this process began with.
    from: Option<(u64, f64)>,
    /// When the pace was found last (s after the start), the time there (s), and the pace.
    paced: (f64, f64, Option<f64>),
    recorded: Option<Instant>,
    said: Instant,
}

impl Progress {
    /// Progress to the time `end` (s), on the screen where `shown`, and kept in the folder of the
    /// rank that has one.
    pub fn new(shown: bool, end: f64, folder: Option<&Path>) -> Progress {
        let bar = if shown { bar() } else { None };
        // A disk that takes no line of progress takes no log either, and the log says so.
        let file = folder.and_then(|f| {
            File::options().append(true).create(true).read(true).open(f.join(FILE)).ok()
        });
        let mut progress = Progress {
            lines: shown && bar.is_none() && std::env::var_os(crate::launch::WATCHED).is_none(),
            bar,
            file,
            newest: Record {
                status: "running".into(),
                end,
                pid: std::process::id(),
                ..Record::default()
            },
            started: Instant::now(),
            from: None,
            paced: (0.0, 0.0, None),
            recorded: None,
            said: Instant::now(),
        };
        progress.end_torn_line();
        progress
    }

    /// A run that was killed inside a write has left part of a line.
    fn end_torn_line(&mut self) {
        let Some(file) = &mut self.file else { return };
        let mut last = [b'\n'];
        if file.seek(SeekFrom::End(-1)).is_ok()
            && file.read_exact(&mut last).is_ok()
            && last != [b'\n']
        {
            let _ = file.write_all(b"\n");
        }
    }

    /// Bytes that the file has.
    pub fn length(&self) -> u64 {
        self.file.as_ref().and_then(|file| file.metadata().ok()).map_or(0, |about| about.len())
    }

    /// Takes the state that the run begins with: its step count and time (s).
    pub fn begin(&mut self, step: u64, time: f64) {
        self.from = Some((step, time));
        self.started = Instant::now();
        self.paced = (0.0, time, None);
        self.newest.step = step;
        self.newest.time = time;
    }

    /// Whether a record is due. False on ranks that keep and show none.
    pub fn due(&self) -> bool {
        let listened = self.file.is_some() || self.bar.is_some() || self.lines;
        listened && self.recorded.is_none_or(|at| at.elapsed() >= RECORD_EVERY)
    }

    /// Takes the state after a step, keeps and shows it; returns a line for the log where one is
    /// due.
    pub fn take(&mut self, state: Record) -> Option<String> {
        self.recorded = Some(Instant::now());
        let elapsed = self.started.elapsed().as_secs_f64().max(1e-9);
        let rate = (state.step - self.from.unwrap_or_default().0) as f64 / elapsed;
        let ahead = (state.end - state.time).max(0.0);
        let left = self.pace(elapsed, state.time).map(|pace| ahead / pace);
        self.newest =
            Record { rate, left, status: "running".into(), pid: self.newest.pid, ..state };
        self.keep();
        if let Some(bar) = &self.bar {
            show(bar, &self.newest);
        }
        (self.lines && self.said.elapsed() >= LINE_EVERY).then(|| {
            self.said = Instant::now();
            self.newest.line()
        })
    }

    /// The pace of late (s of the flow a second), at the time `time` (s) and so many seconds after
    /// the start.
    fn pace(&mut self, elapsed: f64, time: f64) -> Option<f64> {
        let (at, from, before) = self.paced;
        let now = (time - from) / (elapsed - at).max(1e-9);
        let fresh = 1.0 - (-(elapsed - at) / (MEMORY * elapsed)).exp();
        let pace = before.map_or(now, |before| before + fresh * (now - before));
        if time > from {
            self.paced = (elapsed, time, Some(pace));
        }
        self.paced.2.filter(|pace| *pace > 0.0)
    }

    /// Clears the bar and keeps how the run ended.
    pub fn finish(&mut self, status: &str, step: u64, time: f64, measures: Map<String, Value>) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        let left = None;
        self.newest =
            Record { status: status.into(), step, time, measures, left, ..self.newest.clone() };
        self.keep();
    }

    fn keep(&mut self) {
        let Some(file) = &mut self.file else { return };
        if let Ok(text) = serde_json::to_string(&self.newest) {
            // One write a line, so that a reader meets whole lines.
            let _ = file.write_all((text + "\n").as_bytes());
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
    /// The bar of the run in a folder, which need not be there yet; `None` where standard error is
    /// no terminal that can draw it.
    pub fn at(run: &Path) -> Option<Glance> {
        bar().map(|bar| Glance { run: run.to_owned(), bar, looked: Instant::now() })
    }

    /// Shows the newest record, once a second.
    pub fn look(&mut self) {
        if self.looked.elapsed() < RECORD_EVERY {
            return;
        }
        self.looked = Instant::now();
        let newest = Record::newest(&self.run).filter(|newest| newest.status == "running");
        newest.iter().for_each(|newest| show(&self.bar, newest));
    }

    /// Takes the bar away.
    pub fn close(&self) {
        self.bar.finish_and_clear();
    }
}

/// Drops what a run's file has after its first `length` bytes: steps that will be done again.
///
/// # Errors
/// When the file is there and cannot be cut. Nobody needs it, and so it may be shorter or not
/// there.
pub fn cut(run: &Path, length: u64) -> Result<()> {
    let path = run.join(FILE);
    let cut = File::options().write(true).open(&path).and_then(|file| {
        let kept = file.metadata()?.len().min(length);
        file.set_len(kept)
    });
    match cut {
        Err(e) if e.kind() != ErrorKind::NotFound => Err(Error::io(&path)(e)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::minutes;
    use mics_run::progress::newest;

    fn lines(folder: &Path) -> Vec<String> {
        std::fs::read_to_string(folder.join(FILE)).unwrap().lines().map(str::to_owned).collect()
    }

    #[test]
    fn progress_records_every_second_and_final_status() {
        let folder = tempfile::tempdir().unwrap();
        let mut progress = Progress::new(false, 2.0, Some(folder.path()));
        progress.begin(10, 1.0);
        let state =
            |step, time| Record { step, time, end: 2.0, dt: Some(0.1), ..Record::default() };
        assert!(progress.due());
        assert_eq!(progress.take(state(11, 1.25)), None, "nothing is shown");
        assert!(!progress.due(), "within the second");
        assert!(
            newest(folder.path()).unwrap().starts_with("62 %  t = 1.2500 s, step 11, "),
            "{:?}",
            newest(folder.path())
        );
        assert_eq!(newest(&folder.path().join("none")), None);
        let said = Map::from_iter([("drag".to_owned(), 1.5.into())]);
        progress.finish("done", 20, 2.0, said);
        let kept: Vec<Record> =
            lines(folder.path()).iter().map(|l| serde_json::from_str(l).unwrap()).collect();
        assert_eq!((kept.len(), kept[0].status.as_str(), kept[0].step), (2, "running", 11));
        assert_eq!(
            (kept[1].status.as_str(), kept[1].step, kept[1].time, kept[1].left),
            ("done", 20, 2.0, None)
        );
        assert_eq!(kept[1].measures["drag"], 1.5);
        // A quarter of the time that was left when this process began took as long as it did: three
        // times that is left.
        assert!(kept[0].rate > 0.0 && (kept[0].left.unwrap() * kept[0].rate - 3.0).abs() < 1e-9);
    }

    #[test]
    fn time_left_from_recent_rate() {
        let mut progress = Progress::new(false, 1.0, None);
        progress.begin(0, 0.0);
        // Ten seconds at a pace of 0.001 while the steps grow, then 0.01: 99 seconds more, of which
        // ten have gone here.
        let pace = |elapsed: f64| {
            if elapsed < 10.0 { 1e-3 * elapsed } else { 0.01 + 0.01 * (elapsed - 10.0) }
        };
        let left = |progress: &mut Progress, second: usize| {
            let time = pace(second as f64);
            (1.0 - time) / progress.pace(second as f64, time).unwrap()
        };
        let seen: Vec<f64> = (1..=30).map(|second| left(&mut progress, second)).collect();
        assert!((seen[8] / 991.0 - 1.0).abs() < 1e-9, "{}", seen[8]);
        let after_a_tenth = seen[19];
        let truth = 89.0;
        assert!((after_a_tenth / truth - 1.0f64).abs() < 0.3, "{after_a_tenth}");
        assert!((seen[29] / 79.0 - 1.0).abs() < 0.06, "{}", seen[29]);
        // Nothing has gone since: the same pace.
        let before = progress.pace(31.0, pace(31.0));
        assert_eq!(progress.pace(31.0, pace(31.0)), before);
    }

    #[test]
    fn progress_survives_truncated_line() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(FILE), "{\"status\":\"runn").unwrap();
        Progress::new(false, 2.0, Some(folder.path())).finish("done", 3, 2.0, Map::new());
        let kept = lines(folder.path());
        assert_eq!(kept.len(), 2);
        assert_eq!(serde_json::from_str::<Record>(&kept[1]).unwrap().step, 3);
    }

    #[test]
    fn resumed_progress_drops_repeated_steps_and_tolerates_short_files() {
        let folder = tempfile::tempdir().unwrap();
        let mut progress = Progress::new(false, 2.0, Some(folder.path()));
        progress.finish("interrupted", 3, 1.0, Map::new());
        let kept = progress.length();
        progress.finish("failed", 4, 1.5, Map::new());
        cut(folder.path(), kept).unwrap();
        let mut progress = Progress::new(false, 2.0, Some(folder.path()));
        progress.finish("done", 4, 2.0, Map::new());
        let status = |line: &String| serde_json::from_str::<Record>(line).unwrap().status;
        assert_eq!(
            lines(folder.path()).iter().map(status).collect::<Vec<_>>(),
            ["interrupted", "done"]
        );
        cut(folder.path(), 1 << 20).unwrap();
        assert_eq!(lines(folder.path()).len(), 2);
        cut(&folder.path().join("nothing"), 5).unwrap();
    }

    #[test]
    fn time_left_units() {
        assert_eq!(
            [4.0, 75.0, 3660.0, -1.0].map(minutes),
            ["4 s", "1 min 15 s", "1 h 01 min", "0 s"]
        );
    }
}
