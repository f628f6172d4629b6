//! Stopping and going on: what lasts from step to step, kill -9, signals, damage, full disks, other
//! numbers of ranks.

use crate::live::wait_for;
use crate::support::{SHARP, box_case, columns, command, mics, mics_command, run, summary};
use mics_run::snapshot::Snapshot;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

pub const STREAM: [&str; 4] = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"wall\"", "\"slip\""];

/// Free discs that press on each other, and one on the wall.
pub fn discs(more: &str) -> String {
    let disc = |place: [f64; 2], density: f64, velocity: [f64; 2], spin: f64| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = {place:?}\n\
            density = {density:?}\n\
             velocity = {velocity:?}\nspin = {spin:?}\n"
        )
    };
    [
        disc([0.45, 0.5], 2.65, [0.6, 0.0], 3.0),
        disc([0.755, 0.52], 20.0, [-0.3, 0.1], 0.0),
        disc([0.95, 0.155], 0.8, [0.1, -0.2], -1.0),
        format!("[contact]\nnormal_stiffness = 500.0\nfriction = 0.3\nrestitution = 0.6\n{more}"),
    ]
    .concat()
}

const MEASURES: &str = "[[measure]]\nname = \"a\"\nkind = \"largest_speed\"\n[[measure]]\n\
    name = \"b\"\n\
    kind = \"contact_start\"\n[[measure]]\nname = \"c\"\nkind = \"position_x\"\nparticle = 2\n\
        [[measure]]\nname = \"d\"\n\
    kind = \"lift_rms\"\nspeed = 1.0\n[[measure]]\nname = \"e\"\nkind = \"velocity_y\"\n\
        from = 0.05\n";

/// Colliding discs with checkpoints every few steps.
pub fn colliding(dir: &Path, time: &str, every: u32) -> PathBuf {
    let walls = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"slip\""];
    let more = format!(
        "{SHARP}[time]\n{time}\n{MEASURES}[output]\nfields = {{ every_time = 0.07 }}\n\
        particles = {{ every = 2 }}\nfigures = false\n\
         checkpoint = {{ every_steps = {every} }}"
    );
    let text = box_case([1.2, 1.0], [30, 25], 0.01, walls, &discs(&more));
    let path = dir.join("case.toml");
    std::fs::write(
        &path,
        text.replace("viscosity = 0.01", "viscosity = 0.01\ngravity = [0.3, -1.0]"),
    )
    .unwrap();
    path
}

pub fn words<'a>(case: &'a Path, out: &'a Path, more: &[&'a str]) -> Vec<&'a str> {
    [&["run", case.to_str().unwrap(), "--out", out.to_str().unwrap()][..], more].concat()
}

pub fn start(arguments: &[&str]) -> Child {
    mics_command()
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

pub fn checkpoints(out: &Path) -> Vec<PathBuf> {
    let entries =
        std::fs::read_dir(out.join("checkpoint")).into_iter().flatten().map(|e| e.unwrap().path());
    let mut paths: Vec<_> =
        entries.filter(|p| p.extension().is_some_and(|e| e == "ckpt")).collect();
    paths.sort();
    paths
}

/// Waits until `holds`, or the process has ended.
pub fn wait_until(process: &mut Child, holds: impl Fn() -> bool) {
    wait_for(|| holds() || process.try_wait().unwrap().is_some());
}

/// Starts a run into `out` and holds it still, as SIGSTOP does, once it `holds`. A run that is over
/// before anybody could look is done anew: on a busy machine that happens.
pub fn held(case: &Path, out: &Path, holds: impl Fn() -> bool) -> Child {
    for _ in 0..20 {
        let _ = std::fs::remove_dir_all(out);
        let mut process = start(&words(case, out, &[]));
        wait_until(&mut process, &holds);
        signal(&process, "STOP");
        if process.try_wait().unwrap().is_none() {
            return process;
        }
    }
    panic!("{} is over before it can be held", case.display());
}

pub fn signal(process: &Child, name: &str) {
    let sent = Command::new("kill")
        .args([&format!("-{name}"), &process.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
}

pub fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

/// Step and status of every record of `progress.jsonl` that is whole.
pub fn progress(out: &Path) -> Vec<(u64, String)> {
    let text = std::fs::read_to_string(out.join("progress.jsonl")).unwrap_or_default();
    let record = |line: &str| serde_json::from_str::<serde_json::Value>(line).unwrap();
    let said = |r: serde_json::Value| {
        (r["step"].as_u64().unwrap(), r["status"].as_str().unwrap().to_owned())
    };
    let whole = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
    whole.map(record).map(said).collect()
}

/// Steps, particles, measures and the fields of two runs are the same, byte for byte, but for the
/// time that they took. The progress of the second goes forward only, and ends once.
pub fn expect_the_same_run(a: &Path, b: &Path) {
    let text = |out: &Path, name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let rows = |out: &Path| -> Vec<String> {
        let without_wall = |line: &str| {
            let cells: Vec<_> =
                line.split(',').enumerate().filter(|(k, _)| *k != 8).map(|(_, c)| c).collect();
            cells.join(",")
        };
        text(out, "steps.csv").lines().map(without_wall).collect()
    };
    assert!(rows(a) == rows(b), "steps.csv of {} and {}", a.display(), b.display());
    assert!(
        text(a, "particles.csv") == text(b, "particles.csv"),
        "particles.csv of {}",
        b.display()
    );
    let files = |out: &Path| -> Vec<(String, Vec<u8>)> {
        let entries = std::fs::read_dir(out.join("fields")).unwrap().map(|e| e.unwrap().path());
        let name = |p: &Path| p.file_name().unwrap().to_str().unwrap().to_owned();
        let mut files: Vec<_> = entries.map(|p| (name(&p), std::fs::read(&p).unwrap())).collect();
        files.sort();
        files
    };
    assert!(files(a) == files(b), "fields of {} and {}", a.display(), b.display());
    let records = progress(b);
    let ((last, status), before) = records.split_last().unwrap();
    let forward =
        before.is_sorted_by(|(a, _), (b, _)| a < b) && before.iter().all(|(step, _)| step <= last);
    let one_end = status == "done" && before.iter().all(|(_, status)| status == "running");
    assert!(forward && one_end, "progress.jsonl of {}: {records:?}", b.display());
    let (a, b) = (summary(a), summary(b));
    for key in [
        "status",
        "steps",
        "time",
        "divergence_max",
        "outer_iterations",
        "krylov_iterations",
        "measures",
    ] {
        assert_eq!(a[key], b[key], "{key}");
    }
}

#[test]
fn killed_run_resumes_to_identical_files() {
    let dir = tempfile::tempdir().unwrap();
    let mut random = 1_u32;
    for (name, time) in [
        ("rk2", "end = 0.35\ncfl = 0.2"),
        ("euler", "end = 0.35\nscheme = \"euler\"\nstep = 0.006"),
    ] {
        let case = colliding(dir.path(), time, 2);
        let straight = dir.path().join(name);
        run(&case, &straight, &[]);
        let out = dir.path().join(format!("{name}-killed"));
        let (mut kills, mut resume) = (0, false);
        loop {
            let mut process = start(&words(&case, &out, if resume { &["--resume"] } else { &[] }));
            wait_until(&mut process, || resume || !checkpoints(&out).is_empty());
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if kills < 3 {
                // The first comes soon, so that there is one; the others may meet the start, a
                // write or the end.
                let most = if resume { 250 } else { 50 };
                std::thread::sleep(Duration::from_millis(u64::from(random >> 16) % most));
                process.kill().unwrap();
            }
            let output = process.wait_with_output().unwrap();
            if output.status.code() == Some(0) && kills > 0 {
                break;
            }
            if output.status.code() == Some(0) {
                // Over before it could be killed: on a busy machine that happens.
                std::fs::remove_dir_all(&out).unwrap();
                continue;
            }
            assert_eq!(output.status.code(), None, "killed, not failed: {}", said(&output));
            (kills, resume) = (kills + 1, true);
        }
        expect_the_same_run(&straight, &out);
        assert_eq!(checkpoints(&out).len(), 2);
    }
}

#[test]
fn ctrl_c_and_sigterm_write_checkpoint_and_exit_with_130() {
    let dir = tempfile::tempdir().unwrap();
    let case = colliding(dir.path(), "end = 0.25\ncfl = 0.2", 1000);
    let straight = dir.path().join("straight");
    run(&case, &straight, &[]);
    assert_eq!(checkpoints(&straight).len(), 1, "that of the end alone");
    for name in ["INT", "TERM"] {
        let out = dir.path().join(name);
        let process = held(&case, &out, || out.join("steps.csv").exists());
        signal(&process, name);
        signal(&process, "CONT");
        let output = process.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{}", said(&output));
        let line = "the same command with --resume goes on from there";
        assert!(
            String::from_utf8_lossy(&output.stderr).starts_with("interrupted after step "),
            "{}",
            said(&output)
        );
        let log = std::fs::read_to_string(out.join("log.txt")).unwrap();
        assert!(said(&output).contains(line) && log.contains(line), "{log}");
        let kept = std::fs::read_to_string(out.join("summary.json")).unwrap();
        assert!(kept.contains("\"status\": \"interrupted\""), "{kept}");
        assert_eq!(checkpoints(&out).len(), 1);
        assert_eq!(progress(&out).last().unwrap().1, "interrupted");
        run(&case, &out, &["--resume"]);
        expect_the_same_run(&straight, &out);
    }
}

#[test]
fn second_ctrl_c_stops_at_once() {
    let dir = tempfile::tempdir().unwrap();
    let case = dir.path().join("case.toml");
    std::fs::write(&case, box_case([1.0, 1.0], [300, 300], 1e-4, STREAM, "")).unwrap();
    let out = dir.path().join("out");
    for _ in 0..20 {
        let mut process = held(&case, &out, || out.join("steps.csv").exists());
        signal(&process, "INT");
        signal(&process, "CONT");
        // The system makes one of two signals that come before the first is taken.
        let status = format!("/proc/{}/status", process.id());
        let untaken = "ShdPnd:\t0000000000000002";
        wait_until(&mut process, || !std::fs::read_to_string(&status).unwrap().contains(untaken));
        signal(&process, "STOP");
        // After one interruption the run ends its step and writes where it is.
        if process.try_wait().unwrap().is_some() || !checkpoints(&out).is_empty() {
            process.kill().unwrap();
            continue;
        }
        signal(&process, "INT");
        signal(&process, "CONT");
        let output = process.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{}", said(&output));
        assert!(checkpoints(&out).is_empty(), "{}", said(&output));
        return;
    }
    panic!("a step is over before it can be held");
}

#[test]
fn wall_clock_checkpoints_do_not_change_results() {
    let dir = tempfile::tempdir().unwrap();
    let case = colliding(dir.path(), "end = 0.12\ncfl = 0.2", 1000);
    let (straight, out) = (dir.path().join("straight"), dir.path().join("out"));
    run(&case, &straight, &[]);
    run(&case, &out, &["--set", "output.checkpoint.every_wall_minutes=1e-9"]);
    assert_eq!([&straight, &out].map(|run| checkpoints(run).len()), [1, 2]);
    expect_the_same_run(&straight, &out);
}

/// The disc of 0.6 m/s goes 7.5e-4 h a step, so that a checkpoint finds it between two places where
/// it is cut.
#[test]
fn creeping_bodies_resume_where_they_are_cut() {
    let dir = tempfile::tempdir().unwrap();
    let case = colliding(dir.path(), "end = 1e-3\nstep = 5e-5", 1000);
    let (straight, out) = (dir.path().join("straight"), dir.path().join("out"));
    let soon = ["--set", "measure.4.from=0"];
    run(&case, &straight, &soon);
    run(&case, &out, &[&soon[..], &["--set", "time.end=3e-4"]].concat());
    for end in ["time.end=7e-4", "time.end=1e-3"] {
        run(&case, &out, &[&soon[..], &["--resume", "--set", end]].concat());
    }
    let rows = |run: &Path| std::fs::read_to_string(run.join("particles.csv")).unwrap();
    assert_eq!(rows(&straight), rows(&out));
}

#[test]
fn damaged_checkpoint_falls_back_to_the_previous_one() {
    let dir = tempfile::tempdir().unwrap();
    let case = colliding(dir.path(), "end = 0.12\ncfl = 0.2", 4);
    let (straight, out) = (dir.path().join("straight"), dir.path().join("out"));
    run(&case, &straight, &[]);
    run(&case, &out, &[]);
    let [older, newest] = checkpoints(&out).try_into().unwrap();
    let whole = std::fs::read(&newest).unwrap();
    let mut bytes = whole.clone();
    bytes[whole.len() / 2] ^= 1;
    std::fs::write(&newest, &bytes).unwrap();
    let output = mics(&words(&case, &out, &["--resume"]));
    let said = said(&output);
    assert!(output.status.success(), "{said}");
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    assert!(
        said.contains("refused") && said.contains(&name(&newest)) && said.contains("checksum"),
        "{said}"
    );
    assert!(said.contains("goes on after step") && said.contains(&name(&older)), "{said}");
    expect_the_same_run(&straight, &out);
    // Neither is whole.
    for path in checkpoints(&out) {
        std::fs::write(path, &whole[..100]).unwrap();
    }
    let before = std::fs::read(out.join("steps.csv")).unwrap();
    let output = mics(&words(&case, &out, &["--resume"]));
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("no checkpoint to go on from") && said.matches("damaged").count() == 2,
        "{said}"
    );
    assert_eq!(std::fs::read(out.join("steps.csv")).unwrap(), before, "nothing is written");
}

#[test]
fn resume_to_later_end_and_refusal_of_changed_case() {
    let dir = tempfile::tempdir().unwrap();
    let case = colliding(dir.path(), "end = 0.1\nstep = 0.006", 5);
    let out = dir.path().join("out");
    run(&case, &out, &[]);
    let longer = ["--set", "time.end=0.16", "--set", "output.checkpoint.every_wall_minutes=3"];
    let rows = std::fs::read_to_string(out.join("steps.csv")).unwrap();
    // As if it had been killed between its last checkpoint and its summary, past its end by a part
    // of a fixed step.
    std::fs::remove_file(out.join("summary.json")).unwrap();
    run(&case, &out, &["--resume"]);
    assert!(std::fs::read_to_string(out.join("summary.json")).unwrap().contains("\"done\""));
    assert_eq!(std::fs::read_to_string(out.join("steps.csv")).unwrap(), rows, "no step more");
    for (more, why) in [
        (
            &["--resume", "--set", "fluid.viscosity=0.02"][..],
            "fluid.viscosity: was 0.01 in the run to go on with",
        ),
        (&["--resume", "--set", "time.end=0.09"], "time.end: the run that goes on has reached 0.1"),
        (&["--resume", "--set", "measure.0.particle=1"], "measure.0.particle: was 0 in the run"),
        (&[], "holds a run; give --resume to go on with it, --force to replace it"),
    ] {
        let output = mics(&words(&case, &out, more));
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(why), "{}", said(&output));
    }
    let nothing = mics(&words(&case, &dir.path().join("nothing"), &["--resume"]));
    assert_eq!(nothing.status.code(), Some(2), "{}", said(&nothing));
    assert!(!dir.path().join("nothing").exists());
    // A log that somebody has cut.
    std::fs::write(out.join("steps.csv"), &rows[..200]).unwrap();
    let output = mics(&words(&case, &out, &[&["--resume"], &longer[..]].concat()));
    assert!(
        output.status.code() == Some(2) && said(&output).contains("steps.csv"),
        "{}",
        said(&output)
    );
    assert!(out.join("summary.json").exists(), "nothing has changed");
    std::fs::write(out.join("steps.csv"), &rows).unwrap();
    run(&case, &out, &[&["--resume"], &longer[..]].concat());
    let straight = dir.path().join("straight");
    run(&case, &straight, &longer);
    let (a, b) = (columns(&straight.join("particles.csv")), columns(&out.join("particles.csv")));
    let last = |c: &std::collections::HashMap<String, Vec<f64>>| *c["fluid_fx"].last().unwrap();
    assert_eq!(last(&a), last(&b));
    assert!(std::fs::read_to_string(out.join("case.toml")).unwrap().contains("end = 0.16"));
}

#[test]
fn resume_adds_measures_and_keeps_measured_values() {
    let dir = tempfile::tempdir().unwrap();
    let case = colliding(dir.path(), "end = 0.4\ncfl = 0.2", 10);
    let (straight, out) = (dir.path().join("straight"), dir.path().join("out"));
    let longer = ["--set", "time.end=0.8"];
    let expected = run(&case, &straight, &longer);
    run(&case, &out, &[]);
    let text = std::fs::read_to_string(&case).unwrap();
    let more = "[[measure]]\nname = \"new\"\nkind = \"position_y\"\n[[measure]]\n\
        name = \"speed\"\nkind = \"mean_speed\"\n[output]";
    std::fs::write(&case, text.replacen("[output]", more, 1)).unwrap();
    let found = run(&case, &out, &[&["--resume"], &longer[..]].concat());
    // The steps next to the end of the part before are of another length.
    for name in ["a", "c"] {
        let [whole, parts] =
            [&expected, &found].map(|summary| summary["measures"][name].as_f64().unwrap());
        assert!((parts / whole - 1.0).abs() < 0.02, "{name}: {whole} and {parts}");
    }
    assert!(
        found["measures"]["new"].is_number() && found["measures"]["speed"].is_number(),
        "{found}"
    );
    let log = std::fs::read_to_string(out.join("log.txt")).unwrap();
    let line = log.lines().find(|line| line.starts_with("measured from t = 0.4")).unwrap();
    assert!(line.ends_with(" on only, since the run before did not: new, speed"), "{line}");
}

#[test]
fn full_disk_exits_with_3_and_leaves_files_to_resume_from() {
    let dir = tempfile::tempdir().unwrap();
    let case = colliding(dir.path(), "end = 1.6\ncfl = 0.2", 10);
    let (straight, out) = (dir.path().join("straight"), dir.path().join("out"));
    let every = ["--set", "output.particles={ every = 1 }"];
    run(&case, &straight, &every);
    // A limit on the size of files: writing fails as it does on a full disk, here for
    // particles.csv.
    let script = "trap '' XFSZ; ulimit -f 100; exec \"$0\" \"$@\"";
    let output = command("bash")
        .args(["-c", script, env!("CARGO_BIN_EXE_mics")])
        .args(words(&case, &out, &[&["--quiet"], &every[..]].concat()))
        .output();
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    let why = ["particles.csv: File too large", "--resume goes on after step"];
    assert!(why.iter().all(|why| said(&output).contains(why)), "{}", said(&output));
    for name in ["steps.csv", "particles.csv", "log.txt"] {
        assert!(
            std::fs::read_to_string(out.join(name)).unwrap().ends_with('\n'),
            "{name} ends with a line"
        );
    }
    for file in std::fs::read_dir(out.join("fields")).unwrap().map(|e| e.unwrap().path()) {
        let whole = match file.extension().unwrap().to_str().unwrap() {
            "vti" => Snapshot::read(&file).is_ok(),
            _ => std::fs::read_to_string(&file).unwrap().ends_with("</VTKFile>\n"),
        };
        assert!(whole, "{}", file.display());
    }
    assert_eq!(checkpoints(&out).len(), 2);
    run(&case, &out, &[&["--resume"], &every[..]].concat());
    expect_the_same_run(&straight, &out);
}
