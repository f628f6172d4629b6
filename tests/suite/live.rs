//! A run while it goes on: its progress on a terminal, in a pipe, without colour, quiet, on several
//! ranks.

use crate::support::{STREAM, box_case, command, mics_command, mpirun};
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

/// A case of `steps` steps, some milliseconds each.
fn case(dir: &Path, steps: u32) -> PathBuf {
    let more = format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [0.6, 0.5]\n\
        motion = \"fixed\"\n\
         [coupling]\nwall = \"sharp\"\n[[measure]]\nname = \"drag\"\nkind = \"drag_coefficient\"\n\
             [output]\nfigures = false\n\
         [time]\nend = {:?}\nstep = 0.002",
        0.002 * f64::from(steps)
    );
    let path = dir.join("case.toml");
    std::fs::write(&path, box_case([2.0, 1.0], [64, 32], 0.01, STREAM, &more)).unwrap();
    path
}

/// The records of `progress.jsonl`.
fn records(out: &Path) -> Vec<serde_json::Value> {
    let text = std::fs::read_to_string(out.join("progress.jsonl")).unwrap_or_default();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn progress_in_pipe_quiet_and_on_two_ranks() {
    let dir = tempfile::tempdir().unwrap();
    let case = case(dir.path(), 40);
    let go = |name: &str, ranks: usize, more: &[&str]| {
        let out = dir.path().join(name);
        let words_of = ["run".as_ref(), case.as_os_str(), "--out".as_ref(), out.as_os_str()];
        let output = match ranks {
            1 => mics_command().args(words_of).args(more).output(),
            _ => mpirun(ranks, env!("CARGO_BIN_EXE_mics")).args(words_of).args(more).output(),
        };
        let output = output.unwrap();
        assert!(output.status.success(), "{}", words(&output));
        let kept = records(&out);
        let (first, last) = (&kept[0], &kept[kept.len() - 1]);
        assert_eq!(
            (first["status"].as_str(), last["status"].as_str()),
            (Some("running"), Some("done")),
            "{name}"
        );
        assert_eq!(last["step"].as_u64(), Some(40));
        assert!((last["time"].as_f64().unwrap() - 0.08).abs() < 1e-12, "{last}");
        for key in ["dt", "rate", "left", "divergence", "largest_speed"] {
            assert!(first[key].is_f64(), "{name}: {key} in {first}");
        }
        let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        assert_eq!(last["measures"], summary["measures"], "{name}");
        words(&output)
    };
    let piped = go("pipe", 1, &[]);
    assert!(!piped.contains(['\r', '\u{1b}']), "no terminal, no control characters: {piped:?}");
    assert_eq!(piped.matches("64 x 32 cells").count(), 1);
    assert_eq!(go("quiet", 1, &["--quiet"]), "");
    let ranks = go("ranks", 2, &[]);
    assert_eq!(
        (ranks.matches("64 x 32 cells").count(), ranks.matches("drag = ").count()),
        (1, 1),
        "{ranks}"
    );
    assert!(!ranks.contains('\u{1b}'), "{ranks:?}");
}

/// Runs the case in a terminal of its own, as `script` makes one.
fn in_terminal(case: &Path, out: &Path, environment: &[(&str, &str)]) -> String {
    let line =
        format!("{} run {} --out {}", env!("CARGO_BIN_EXE_mics"), case.display(), out.display());
    let mut script = command("script");
    script.envs([("TERM", "xterm-256color")]).envs(environment.iter().copied());
    let output = script
        .args(["-qec", &line, "/dev/null"])
        .stdin(Stdio::null())
        .output()
        .expect("script of bsdutils");
    assert!(output.status.success(), "{}", words(&output));
    words(&output)
}

#[test]
fn progress_bar_on_plain_and_dumb_terminals() {
    let dir = tempfile::tempdir().unwrap();
    let case = case(dir.path(), 40);
    // A colour is ESC [ numbers m.
    let coloured = |said: &str| {
        said.split('\u{1b}').skip(1).any(|s| {
            s.strip_prefix('[').is_some_and(|s| {
                s.trim_start_matches(|c: char| c.is_ascii_digit() || c == ';').starts_with('m')
            })
        })
    };
    let shown = in_terminal(&case, &dir.path().join("a"), &[("NO_COLOR", "1")]);
    assert!(shown.contains("steps/s") && shown.contains(" %  t = "), "a bar: {shown:?}");
    assert!(!coloured(&shown), "{shown:?}");
    // The bar is gone when the table comes, and comes back no more.
    let table = shown.find("ns per cell and step").unwrap();
    assert!(!shown[table..].contains("steps/s"), "{shown:?}");
    let dumb = in_terminal(&case, &dir.path().join("b"), &[("TERM", "dumb")]);
    assert!(!dumb.contains('\u{1b}') && !dumb.contains("steps/s"), "{dumb:?}");
}

/// Waits until it is `ready`.
pub fn wait_for(mut ready: impl FnMut() -> bool) {
    let started = Instant::now();
    while !ready() {
        assert!(started.elapsed() < Duration::from_secs(300), "nothing happens in five minutes");
        std::thread::sleep(Duration::from_millis(1));
    }
}
