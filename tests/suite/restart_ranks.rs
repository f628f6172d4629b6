//! Going on, and stopping, on several ranks.

use crate::restart::{checkpoints, colliding, progress, said, signal, wait_until, words};
use crate::support::{columns, mpirun, run};
use std::process::Stdio;

#[test]
fn resume_on_other_numbers_of_ranks_keeps_paths_and_forces() {
    let dir = tempfile::tempdir().unwrap();
    let set = |end: f64| format!("time.end={end}");
    let case =
        colliding(dir.path(), "end = 0.4\nstep = 0.008\n[pressure]\ndivergence_limit = 1.0e-9", 5);
    let each = ["--quiet", "--set", "output.particles={ every = 1 }", "--set"];
    let (straight, out) = (dir.path().join("straight"), dir.path().join("out"));
    run(&case, &straight, &[&each[1..], &[&set(0.4)]].concat());
    let mut ends = Vec::new();
    for (ranks, end) in [(1, 0.1), (2, 0.2), (4, 0.3), (1, 0.4)] {
        let (end, more) = (set(end), if ends.is_empty() { None } else { Some("--resume") });
        let arguments = [&words(&case, &out, &each)[..], &[&end[..]]].concat();
        let output =
            mpirun(ranks, env!("CARGO_BIN_EXE_mics")).args(arguments).args(more).output().unwrap();
        assert!(output.status.success(), "{ranks} ranks: {}", said(&output));
        let rows = columns(&out.join("steps.csv"));
        ends.push(*rows["step"].last().unwrap() as usize);
    }
    let (a, b) = (columns(&straight.join("particles.csv")), columns(&out.join("particles.csv")));
    assert_eq!(a["step"], b["step"]);
    for name in ["x", "y", "angle", "vx", "vy", "wz"] {
        let gap = a[name].iter().zip(&b[name]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(gap < 1e-6, "{name} differs by {gap:e}");
    }
    let particles = 3;
    for name in ["fluid_fx", "fluid_fy", "fluid_tz", "pressure_fx", "viscous_fy"] {
        for k in 0..particles {
            let change = |step: usize| {
                let at = |step: usize| b[name][step * particles + k];
                (at(step + 1) - at(step)).abs()
            };
            for &end in &ends[..3] {
                let usual = (end - 6..end).chain(end + 1..end + 7).map(change).fold(0.0, f64::max);
                assert!(
                    change(end) <= 3.0 * usual,
                    "{name} of {k} jumps by {:e}, usually {usual:e}",
                    change(end)
                );
            }
        }
    }
}

#[test]
fn all_ranks_stop_together_after_a_signal_to_mpirun() {
    let dir = tempfile::tempdir().unwrap();
    let case = colliding(dir.path(), "end = 50.0\ncfl = 0.2", 10_000);
    let out = dir.path().join("out");
    let mut command = mpirun(2, env!("CARGO_BIN_EXE_mics"));
    command.args(words(&case, &out, &["--quiet"])).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut process = command.spawn().unwrap();
    wait_until(&mut process, || !progress(&out).is_empty());
    signal(&process, "USR1");
    let output = process.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    assert_eq!(said(&output).matches("interrupted after step").count(), 1, "{}", said(&output));
    let after = checkpoints(&out)
        .last()
        .and_then(|p| p.file_stem()?.to_str()?.parse::<u64>().ok())
        .unwrap();
    let rows = columns(&out.join("steps.csv"));
    assert_eq!(*rows["step"].last().unwrap(), after as f64, "the logs are closed at that step");
}
