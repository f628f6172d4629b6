//! A run's folder: one process at a time, nothing of anybody else's deleted, and a way on from
//! every state that it can be in.

use crate::restart::{
    checkpoints, colliding, expect_the_same_run, held, said, signal, start, wait_until, words,
};
use crate::support::{command, mics, run};
use std::fs;

#[test]
fn folder_of_a_running_run_is_locked() {
    let dir = tempfile::tempdir().unwrap();
    let (case, out) = (colliding(dir.path(), "end = 0.5\ncfl = 0.2", 20), dir.path().join("out"));
    let first = held(&case, &out, || !checkpoints(&out).is_empty());
    let refused = |more: &[&str]| {
        let output = mics(&words(&case, &out, more));
        assert_eq!(output.status.code(), Some(2), "{more:?}: {}", said(&output));
        let why = said(&output);
        let holder = format!("another mics (process {}) is writing here", first.id());
        assert!(why.contains(&holder), "{more:?}: {why}");
    };
    [&[][..], &["--force"], &["--resume"]].into_iter().for_each(refused);
    // As before its first checkpoint.
    let [there, away] = [out.join("checkpoint"), dir.path().join("away")];
    fs::rename(&there, &away).unwrap();
    refused(&["--resume"]);
    fs::rename(&away, &there).unwrap();
    signal(&first, "CONT");
    assert!(first.wait_with_output().unwrap().status.success());
    let alone = dir.path().join("alone");
    run(&case, &alone, &[]);
    expect_the_same_run(&alone, &out);
}

#[test]
fn full_disk_at_start_leaves_reusable_folder() {
    let dir = tempfile::tempdir().unwrap();
    let (case, out) = (colliding(dir.path(), "end = 0.1\nstep = 0.006", 5), dir.path().join("out"));
    let script = "trap '' XFSZ; ulimit -f 0; exec \"$0\" \"$@\"";
    let output = command("bash")
        .args(["-c", script, env!("CARGO_BIN_EXE_mics")])
        .args(words(&case, &out, &[]))
        .output();
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    assert!(out.join("fields").is_dir());
    run(&case, &out, &[]);
}

#[test]
fn resume_without_snapshots_and_refusal_of_tighter_divergence_limit() {
    let dir = tempfile::tempdir().unwrap();
    let (case, out) = (colliding(dir.path(), "end = 0.1\nstep = 0.006", 5), dir.path().join("out"));
    run(&case, &out, &[]);
    fs::remove_dir_all(out.join("fields")).unwrap();
    let later = ["--resume", "--set", "time.end=0.16"];
    let output = mics(&words(
        &case,
        &out,
        &[&later[..], &["--set", "pressure.divergence_limit=1e-13"]].concat(),
    ));
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(
        said(&output).contains("pressure.divergence_limit: the run that goes on has reached"),
        "{}",
        said(&output)
    );
    run(&case, &out, &later);
    assert!(fs::read_dir(out.join("fields")).unwrap().count() > 1);
}

#[test]
fn validate_exits_with_130_and_refuses_foreign_folder() {
    let dir = tempfile::tempdir().unwrap();
    let (mine, out) = (dir.path().join("mine"), dir.path().join("out"));
    fs::create_dir(&mine).unwrap();
    fs::write(mine.join("settling-disc-N-8.toml"), "mine").unwrap();
    let output = mics(&["validate", "settling-disc N 8", "--out", mine.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(
        said(&output).contains("holds no study") && fs::read_dir(&mine).unwrap().count() == 1,
        "{}",
        said(&output)
    );

    let mut process =
        start(&["validate", "settling-disc N 16", "lid", "--out", out.to_str().unwrap()]);
    let first = out.join("runs/case=lid-driven-cavity/1/steps.csv");
    wait_until(&mut process, || first.exists());
    signal(&process, "TERM");
    let output = process.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    assert!(
        said(&output).contains("interrupted") && !said(&output).contains("--resume"),
        "{}",
        said(&output)
    );
}

#[test]
fn exit_status_does_not_depend_on_stderr() {
    let status = command("bash")
        .args(["-c", "exec \"$0\" check /nowhere.toml 2>/dev/full", env!("CARGO_BIN_EXE_mics")])
        .status()
        .unwrap();
    assert_eq!(status.code(), Some(2));
}
