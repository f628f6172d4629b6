//! Runs that start their ranks by themselves.

use crate::restart::{checkpoints, colliding, progress, said, signal, wait_until, words};
use crate::support::{AS_ROOT, PERIODIC, box_case, mics_command};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// A fluid at rest on so many cells, for two steps.
fn still(dir: &Path, cells: [usize; 2]) -> PathBuf {
    let time = "[time]\nstep = 1e-3\nend = 2e-3\n[output]\nfigures = false";
    let path = dir.join(format!("{}.toml", cells[0]));
    std::fs::write(&path, box_case([1.0, 1.0], cells, 0.01, PERIODIC, time)).unwrap();
    path
}

fn program() -> Command {
    let mut command = mics_command();
    for (name, _) in AS_ROOT {
        command.env_remove(name);
    }
    command
}

fn output(case: &Path, out: &Path, more: &[&str]) -> Output {
    program().args(words(case, out, more)).output().unwrap()
}

#[test]
fn run_starts_as_many_ranks_as_its_cells_and_cores_are_good_for() {
    let dir = tempfile::tempdir().unwrap();
    let (small, large) = (still(dir.path(), [32, 32]), still(dir.path(), [512, 420]));
    let out = dir.path().join("out");
    let ranks = |case: &Path, more: &[&str]| {
        let output = output(case, &out, &[&["--force"], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        let record = std::fs::read_to_string(out.join("run.json")).unwrap();
        let found = serde_json::from_str::<serde_json::Value>(&record).unwrap()["ranks"].as_u64();
        (found.unwrap(), said(&output))
    };
    let cores = std::thread::available_parallelism().unwrap().get() as u64;
    assert_eq!(ranks(&large, &[]).0, cores.min(2));
    let (one, words) = ranks(&large, &["--ranks", "1"]);
    let advice = "1 rank on 2 cores: cells and bodies are work for 2; --ranks 2 uses the cores";
    assert!(one == 1 && (cores != 2 || words.contains(advice)), "{words}");
    assert_eq!(ranks(&large, &["--", "-ksp_rtol", "1e-8"]).0, 1, "a solver was chosen");
    assert_eq!(ranks(&large, &["--set", "pressure.solver=\"multigrid\""]).0, 1);
    assert_eq!(ranks(&small, &[]).0, 1, "a thousand cells are too few for two");
    assert_eq!(ranks(&small, &["--ranks", "auto"]).0, 1);
    assert_eq!(ranks(&small, &["--ranks", "2"]).0, 2);
}

/// A run on two ranks of its own that has taken its first steps.
fn going(case: &Path, out: &Path) -> std::process::Child {
    let mut command = program();
    command.args(words(case, out, &["--ranks", "2", "--quiet"]));
    let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_until(&mut process, || !progress(out).is_empty());
    process
}

#[test]
fn interrupt_of_a_run_stops_its_ranks_with_a_checkpoint() {
    let dir = tempfile::tempdir().unwrap();
    let case = colliding(dir.path(), "end = 50.0\ncfl = 0.2", 10_000);
    for name in ["INT", "TERM"] {
        let out = dir.path().join(name);
        let process = going(&case, &out);
        signal(&process, name);
        let output = process.wait_with_output().unwrap();
        let said = said(&output);
        assert_eq!(output.status.code(), Some(130), "{said}");
        let lines: Vec<_> = said.lines().filter(|line| !line.contains("orwarding")).collect();
        assert!(lines.len() == 1 && lines[0].starts_with("interrupted after step"), "{said}");
        assert!(!checkpoints(&out).is_empty());
    }
}

/// The process of the first rank of a run.
fn first_rank(out: &Path) -> String {
    let record = std::fs::read_to_string(out.join("run.json")).unwrap();
    serde_json::from_str::<serde_json::Value>(&record).unwrap()["pid"].to_string()
}

/// A rank that is held still never ends its step, which the first interrupt asks for.
#[test]
fn second_interrupt_ends_ranks_at_once() {
    let dir = tempfile::tempdir().unwrap();
    let case = colliding(dir.path(), "end = 50.0\ncfl = 0.2", 10_000);
    let out = dir.path().join("out");
    let mut process = going(&case, &out);
    let rank = first_rank(&out);
    assert!(Command::new("kill").args(["-STOP", &rank]).status().unwrap().success());
    while process.try_wait().unwrap().is_none() {
        signal(&process, "INT");
        std::thread::sleep(Duration::from_millis(50));
    }
    let ended = process.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130), "{}", said(&ended));
}

#[test]
fn killed_rank_or_refused_folder_is_told_once() {
    let dir = tempfile::tempdir().unwrap();
    let case = colliding(dir.path(), "end = 50.0\ncfl = 0.2", 10_000);
    let out = dir.path().join("killed");
    let process = going(&case, &out);
    let rank = first_rank(&out);
    assert!(Command::new("kill").args(["-9", &rank]).status().unwrap().success());
    let ended = process.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(3), "{}", said(&ended));
    let expected = "error: a rank was ended by signal 9, which the system sends when memory is";
    assert!(said(&ended).contains(expected), "{}", said(&ended));

    let refused = output(&case, &out, &["--ranks", "2"]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(said(&refused).lines().count() == 1, "{}", said(&refused));
}
