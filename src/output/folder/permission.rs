//! Who may use a folder, and what a run may delete there.

use super::super::checkpoint;
use super::{PASSAGES, ROSTER};
use crate::{Error, Result};
use mics_run::folder::{BALANCE, FIELDS, OBSTACLES, PROFILE, REPORT, SOLVES};
use mics_run::progress::FILE as PROGRESS;
use rustix::fs::{FlockOperation, flock};
use std::fs::{self, File};
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

/// Says that a folder holds a run; there from the first moment to the last.
pub(super) const RUN: &str = "run.json";
/// Files that this program writes into a run's folder, and so may delete with `--force`.
const OURS: [&str; 16] = [
    "case.toml",
    ROSTER,
    "steps.csv",
    "particles.csv",
    OBSTACLES,
    "summary.json",
    "log.txt",
    PROGRESS,
    REPORT,
    "probes.csv",
    PASSAGES,
    SOLVES,
    FIELDS,
    PROFILE,
    BALANCE,
    RUN,
];
/// Its folders, with the endings of what it writes there.
const OUR_FOLDERS: [(&str, &[&str]); 3] = [
    ("fields", &["vti", "vtp", "pvd"]),
    ("figures", &["png", "svg"]),
    (checkpoint::FOLDER, &[checkpoint::ENDING]),
];
/// Ending of a file that is being written.
pub(super) const PART: &str = "part";
/// Whether a run of the case file `case` may be written to `path`.
///
/// # Errors
/// When the folder holds a run and `force` is not set, or holds anything that is not a run's, or
/// the case file itself.
pub fn may_use(path: &Path, force: bool, case: &Path) -> Result<()> {
    let refuse = |why: String| Err(Error::Usage(format!("{}: {why}", path.display())));
    let entries = match fs::read_dir(path) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(e) => return refuse(format!("cannot be used as a run's folder: {e}")),
        Ok(entries) => entries,
    };
    let names: Vec<String> =
        entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    if names.is_empty() {
        return Ok(());
    }
    let ours = |n: &str| {
        OURS.contains(&n.strip_suffix(".part").unwrap_or(n))
            || OUR_FOLDERS.iter().any(|(folder, _)| *folder == n)
    };
    if let Some(strange) = names.iter().find(|n| !ours(n)) {
        return refuse(format!(
            "the folder exists and holds {strange:?}, which no run wrote; give another folder with \
            --out"
        ));
    }
    // A start that failed, for want of room, leaves folders and parts of files at most.
    let begun = |n: &String| path.join(n).is_dir() || n.ends_with(".part");
    if names.iter().all(begun) {
        return Ok(());
    }
    if !names.iter().any(|n| n == RUN) {
        return refuse(
            "the folder exists and holds no run (no run.json); give another folder with --out"
                .into(),
        );
    }
    if !force {
        let on = if checkpoint::any(path)? { "--resume to go on with it, " } else { "" };
        return refuse(format!(
            "the folder exists and holds a run; give {on}--force to replace it, or another folder \
            with --out"
        ));
    }
    let inside = |p: &Path| Some(p.canonicalize().ok()?.starts_with(path.canonicalize().ok()?));
    if inside(case) == Some(true) {
        return refuse(format!(
            "--force would delete the case file {}; copy it elsewhere first",
            case.display()
        ));
    }
    Ok(())
}

pub(super) fn delete(file: &Path) -> Result<()> {
    match fs::remove_file(file) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::io(file)(e)),
        _ => Ok(()),
    }
}

/// Takes a run's folder for this process; let go of when the file is closed, also by a process that
/// is killed.
///
/// # Errors
/// When another process has it.
pub(super) fn lock(path: &Path) -> Result<File> {
    locked(path, FlockOperation::NonBlockingLockExclusive)
}

/// Refuses a run's folder, where there is one, that another process has.
pub fn refuse_held(path: &Path) -> Result<()> {
    // Shared by the ranks of this process, which all look at once.
    if path.is_dir() {
        locked(path, FlockOperation::NonBlockingLockShared)?;
    }
    Ok(())
}

fn locked(path: &Path, how: FlockOperation) -> Result<File> {
    let folder = File::open(path).map_err(Error::io(path))?;
    match flock(&folder, how) {
        Err(e) if e == rustix::io::Errno::WOULDBLOCK => Err(Error::Usage(format!(
            "{}: another mics{} is writing here; wait until it has ended, or give another folder \
            with --out",
            path.display(),
            holder(&folder).map_or_else(String::new, |id| format!(" (process {id})"))
        ))),
        // Some network file systems know no locks.
        _ => Ok(folder),
    }
}

/// The number of the process that holds the lock of an open folder, where the system says it.
fn holder(folder: &File) -> Option<u32> {
    let place = format!(":{}", folder.metadata().ok()?.ino());
    let locks = fs::read_to_string("/proc/locks").ok()?;
    // 1: FLOCK ADVISORY WRITE 4711 fe:00:131074 0 EOF
    let held = locks.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let of_folder = |words: &Vec<&str>| {
        words.get(1) == Some(&"FLOCK") && words.get(5).is_some_and(|at| at.ends_with(&place))
    };
    held.into_iter().find(of_folder)?.get(4)?.parse().ok()
}

/// Deletes what a run left in its folder, and nothing else.
pub(super) fn clear(path: &Path) -> Result<()> {
    for (name, endings) in OUR_FOLDERS {
        let Ok(entries) = fs::read_dir(path.join(name)) else { continue };
        for file in entries.flatten().map(|e| e.path()) {
            let ending = file.extension().unwrap_or_default();
            if ending == PART || endings.iter().any(|e| ending == *e) {
                delete(&file)?;
            }
        }
    }
    // The last one is what makes it a run's folder.
    for name in OURS {
        delete(&path.join(format!("{name}.{PART}")))?;
        delete(&path.join(name))?;
    }
    Ok(())
}
