//! One run of a study: a process of this very program with a folder of its own, and what it left
//! there.

use super::planned::Planned;
use mics_run::interrupt::Interrupt;
use mics_run::progress;
use mics_run::{Error, Result};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs, io, thread};

/// End of a run, and what it left.
pub struct Outcome {
    /// `done`, `failed`, `refused`, `too slow` or `interrupted`.
    pub status: &'static str,
    /// Why it is not done, or what is to be said of one that is.
    pub message: String,
    /// Its `summary.json`, where it left one.
    pub summary: Value,
    /// The commit of the program that ran it.
    pub commit: String,
}

impl Outcome {
    /// The end of a run that was not even tried.
    pub fn refused(message: &str) -> Outcome {
        let commit = crate::COMMIT.to_owned();
        Outcome { status: "refused", message: message.into(), summary: Value::Null, commit }
    }
}

/// Doubts about a run in its summary: PETSc options that nothing used, say.
fn notes(summary: &Value) -> String {
    let notes = summary["notes"].as_array();
    notes.into_iter().flatten().filter_map(Value::as_str).collect::<Vec<_>>().join("; ")
}

fn json(path: &Path) -> Value {
    let text = fs::read_to_string(path).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// End of this very run in a folder, finished earlier: the same case on as many ranks. `None` if it
/// is to be run.
pub fn kept(run: &Planned, folder: &Path) -> Option<Outcome> {
    let summary = json(&folder.join("summary.json"));
    let record = json(&folder.join("run.json"));
    let case = fs::read_to_string(folder.join("case.toml")).ok()?;
    let same = run.loaded.as_ref().is_ok_and(|loaded| loaded.to_toml() == case)
        && record["ranks"] == run.ranks
        && summary["status"] == "done";
    let commit = record["git_commit"].as_str().unwrap_or_default().to_owned();
    same.then(|| Outcome { status: "done", message: notes(&summary), summary, commit })
}

/// Time between two lines of a run's progress.
const LINE_EVERY: Duration = Duration::from_secs(30);
/// Time between two looks whether a run has ended.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Signals that ask a run to end, one after another: to stop after its step, to stop at once, and
/// one that leaves no choice.
const ENDINGS: [Signal; 3] = [Signal::USR1, Signal::USR1, Signal::KILL];
/// Time that each of them is given.
const GRACE: Duration = Duration::from_secs(3);

/// What bounds a run: its time, and whoever asks the study to stop.
pub struct Bounds {
    /// Wall-clock time that it may take.
    pub limit: Option<Duration>,
    /// Whether the study is asked to stop.
    pub interrupt: Interrupt,
}

impl Bounds {
    /// Status of a run that goes on for so long; `None` while it may go on.
    fn over(&self, elapsed: Duration) -> Option<&'static str> {
        let slow = self.limit.is_some_and(|limit| elapsed >= limit).then_some("too slow");
        if self.interrupt.asked() { Some("interrupted") } else { slow }
    }

    /// Waits for a run, ends it where it is over its bounds, and says every now and then on
    /// standard error how far it is, `name` ahead; returns what it said there, and its status where
    /// it was ended.
    fn wait(
        &self,
        command: &mut Command,
        folder: &Path,
        name: &str,
    ) -> io::Result<(Output, Option<&'static str>)> {
        let mut child =
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?;
        let stderr = child.stderr.take();
        let reader = thread::spawn(move || {
            let mut said = Vec::new();
            stderr.map(|mut pipe| pipe.read_to_end(&mut said));
            said
        });
        let began = Instant::now();
        let mut next_line = began + LINE_EVERY;
        let mut next_ending = began;
        let mut endings = ENDINGS.iter();
        let mut over = None;
        let status = loop {
            if let Some(status) = child.try_wait()? {
                break status;
            }
            thread::sleep(LOOK_EVERY);
            let now = Instant::now();
            over = over.or_else(|| self.over(began.elapsed()));
            if over.is_some() && now >= next_ending {
                next_ending = now + GRACE;
                // One that has just ended by itself is no failure to end it.
                let _ = endings.next().map(|signal| kill_process(Pid::from_child(&child), *signal));
            }
            if now >= next_line {
                next_line += LINE_EVERY;
                // A folder without progress is that of a run that has not begun.
                if let Some(line) = progress::newest(folder) {
                    let _ = writeln!(io::stderr(), "{name}: {line}");
                }
            }
        };
        let stderr = reader.join().unwrap_or_default();
        Ok((Output { status, stdout: Vec::new(), stderr }, over))
    }
}

/// Words on a run that was ended for its limit, with how far it was.
fn too_slow(folder: &Path, limit: Duration) -> String {
    let reached = progress::Record::newest(folder).filter(|record| record.step > 0);
    let reached = reached.map_or("no step recorded".to_owned(), |record| {
        format!("at step {}, {:.0} % of the time", record.step, 100.0 * record.done())
    });
    format!("ended after {} s, {reached} (limit_seconds)", limit.as_secs_f64())
}

/// Runs it into a folder, and waits for it within its bounds; lines of its progress begin with
/// `name`.
///
/// # Errors
/// When this program cannot be started. A run that fails is an outcome.
pub fn run(run: &Planned, folder: &Path, name: &str, bounds: &Bounds) -> Result<Outcome> {
    let program = env::current_exe().map_err(Error::io("this program"))?;
    let mut command = Command::new(&program);
    command.arg("run").arg(&run.case).args(["--quiet", "--force", "--out"]).arg(folder);
    command.args(["--ranks", &run.ranks.to_string()]);
    add_overrides(&mut command, run);
    // Files that an earlier try left must not be taken for this one's.
    for file in ["summary.json", progress::FILE] {
        absent(fs::remove_file(folder.join(file)), &folder.join(file))?;
    }
    let waited = bounds.wait(&mut command, folder, name);
    let (ended, over) = waited.map_err(Error::io(program))?;
    let words = words(run, &ended.stderr);
    let summary = json(&folder.join("summary.json"));
    let status = match (ended.status.code(), over) {
        (Some(0), _) if summary["status"] == "done" => "done",
        (_, Some(over)) => over,
        (Some(2), _) => "refused",
        (Some(130), _) => "interrupted",
        _ => "failed",
    };
    let message = match (status, words.as_str()) {
        ("done", _) => notes(&summary),
        ("too slow", _) => too_slow(folder, bounds.limit.unwrap_or_default()),
        ("interrupted", _) => "asked to stop".into(),
        (_, "") => format!("it ended with {} and said nothing", ended.status),
        _ => words,
    };
    Ok(Outcome { status, message, summary, commit: crate::COMMIT.to_owned() })
}

/// Why a run would be refused before its first step; `None` where it would start, or fail in
/// another way.
///
/// # Errors
/// When this program cannot be started.
pub fn refusal(run: &Planned) -> Result<Option<String>> {
    if let Err(refusal) = &run.loaded {
        return Ok(Some(refusal.why.clone()));
    }
    let program = env::current_exe().map_err(Error::io("this program"))?;
    let mut command = Command::new(&program);
    command.arg("check").arg(&run.case).arg("--quiet");
    add_overrides(&mut command, run);
    let ended =
        command.stdin(Stdio::null()).stdout(Stdio::null()).output().map_err(Error::io(program))?;
    Ok((ended.status.code() == Some(2)).then(|| words(run, &ended.stderr)))
}

fn add_overrides(command: &mut Command, run: &Planned) {
    command.args(run.set.iter().flat_map(|given| ["--set", given]));
}

/// Words of a run on its failure, without what the study says anyway.
fn words(run: &Planned, stderr: &[u8]) -> String {
    let said = String::from_utf8_lossy(stderr);
    let words = said.lines().find_map(|line| line.strip_prefix("error: "));
    let words = words
        .or_else(|| said.lines().rfind(|line| line.contains(char::is_alphanumeric)))
        .unwrap_or_default();
    let words = words.trim();
    let place = format!("{}: ", run.case.display());
    words.strip_prefix(&place).unwrap_or(words).replace(" (given by --set)", "")
}

/// Deletes the snapshots and checkpoints of a run: those of a large grid are gigabytes, which a
/// table has no use for.
///
/// # Errors
/// When they cannot be deleted.
pub fn drop_fields(folder: &Path) -> Result<()> {
    for name in ["fields", "checkpoint"] {
        absent(fs::remove_dir_all(folder.join(name)), &folder.join(name))?;
    }
    Ok(())
}

/// What was to be removed may have been absent.
fn absent(removed: io::Result<()>, place: &Path) -> Result<()> {
    match removed {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(Error::io(place)(e)),
        _ => Ok(()),
    }
}
