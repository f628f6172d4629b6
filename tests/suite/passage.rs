//! Free bodies that reach an outflow leave, return or end the run, and nothing of the others changes.

use crate::support::{box_case, columns, mics, mpirun, run, summary};
use std::path::Path;

const STREAM: [&str; 4] = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"slip\"", "\"slip\""];

/// Four discs in a stream that carries them out one after the other, with these tables.
fn carried(time: &str, more: &str) -> String {
    let disc = |x: f64, y: f64, density: f64| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [{x:?}, {y:?}]\nvelocity = [1.0, 0.0]\n\
             density = {density:?}\n"
        )
    };
    let discs = disc(1.55, 0.3, 1.5) + &disc(0.4, 0.6, 1.0) + &disc(1.2, 0.72, 0.8) + &disc(0.8, 0.25, 3.0);
    let ends = "[[measure]]\nname = \"first\"\nkind = \"velocity_x\"\nparticle = 0\n[[measure]]\nname = \"light\"\nkind = \"mean_speed\"\n\
                particles = [0, 2]\n[[measure]]\nname = \"last\"\nkind = \"position_x\"\nparticle = 1\n[[measure]]\nname = \"all\"\nkind = \"mean_speed\"\n";
    box_case(
        [2.0, 1.0],
        [48, 24],
        0.01,
        STREAM,
        &format!("{discs}{ends}[output]\nfigures = false\n[time]\n{time}\n{more}"),
    )
    .replace("[output]\nfigures = false\n[time]", "[time]")
}

fn write(dir: &Path, text: &str) -> std::path::PathBuf {
    std::fs::write(dir.join("case.toml"), text).unwrap();
    dir.join("case.toml")
}

#[test]
fn discs_leave_through_an_outflow_one_after_the_other_and_the_others_keep_their_numbers() {
    for (wall, contact) in [("sharp", "[contact]\n"), ("sharp", ""), ("mixing", "[contact]\n"), ("mixing", "")] {
        let dir = tempfile::tempdir().unwrap();
        let case =
            write(dir.path(), &carried("end = 1.0\nstep = 0.005", &format!("{contact}[coupling]\nwall = \"{wall}\"")));
        let out = dir.path().join("out");
        let found = run(&case, &out, &[]);
        let left = std::fs::read_to_string(out.join("passages.csv")).unwrap();
        let ids: Vec<&str> = left.lines().skip(1).map(|line| line.split(',').nth(2).unwrap()).collect();
        assert_eq!(ids, ["0", "2"], "{wall}: {left}");
        let mass: f64 = left.lines().nth(1).unwrap().split(',').nth(4).unwrap().parse().unwrap();
        assert!((mass / (1.5 * 0.25 * std::f64::consts::PI * 0.09) - 1.0).abs() < 1e-12);
        let rows = columns(&out.join("particles.csv"));
        let count = |step: f64| rows["step"].iter().filter(|s| **s == step).count();
        assert_eq!((count(0.0), count(120.0), count(200.0)), (4, 3, 2), "{wall}");
        // The second one goes on with the stream, and measures know it by its number.
        let end = rows["x"][rows["id"].iter().rposition(|id| *id == 1.0).unwrap()];
        assert!((1.3..1.5).contains(&end), "{wall}: {end} m");
        assert_eq!(found["measures"]["last"].as_f64().unwrap(), end);
        // Nothing is missing in the balance of any step, and nothing has come from nothing.
        let steps = columns(&out.join("steps.csv"));
        assert!(steps["momentum_error"].iter().all(|e| *e < 1e-11), "{wall}");
        assert!(steps["method_loss"].iter().all(|e| e.abs() < 0.1), "{wall}: {:?}", steps["method_loss"]);
        // A measure of what has left is that of the time when it was there.
        assert!((found["measures"]["first"].as_f64().unwrap() - 1.0).abs() < 0.1, "{wall}: {found}");
        let shown = mics(&["plot", out.to_str().unwrap()]);
        assert!(shown.status.success(), "{}", String::from_utf8_lossy(&shown.stderr));
    }
}

#[test]
fn a_run_that_bodies_have_left_goes_on_byte_for_byte_and_on_ranks() {
    let dir = tempfile::tempdir().unwrap();
    let text = carried("end = 1.0\nstep = 0.005", "[contact]\n[pressure]\ndivergence_limit = 1e-9\n");
    let case = write(dir.path(), &text);
    let [through, broken, shared] = ["through", "broken", "shared"].map(|name| dir.path().join(name));
    run(&case, &through, &[]);
    run(&case, &broken, &["--set", "time.end=0.7"]);
    let on = mics(&["run", case.to_str().unwrap(), "--out", broken.to_str().unwrap(), "--resume", "--quiet"]);
    assert!(on.status.success(), "{}", String::from_utf8_lossy(&on.stderr));
    for file in ["particles.csv", "passages.csv"] {
        let [a, b] = [&through, &broken].map(|out| std::fs::read(out.join(file)).unwrap());
        assert!(a == b, "{file}");
    }
    let ranks = mpirun(2, env!("CARGO_BIN_EXE_mics"))
        .args(["run", case.to_str().unwrap(), "--quiet", "--out", shared.to_str().unwrap()])
        .output()
        .unwrap();
    assert!(ranks.status.success(), "{}", String::from_utf8_lossy(&ranks.stderr));
    summary(&shared);
    let [a, b] = [&through, &shared].map(|out| columns(&out.join("particles.csv")));
    assert_eq!(a["id"], b["id"]);
    let apart = a["x"].iter().zip(&b["x"]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-6, "{apart} m");
    // A case can begin where it ended, with those that were left.
    let next = carried("end = 0.1\nstep = 0.005", &format!("[contact]\n[initial]\nfrom = {through:?}\n"));
    let next = next.split("[[particle]]").next().unwrap().to_owned()
        + &next[next.find("[time]").unwrap()..].replace("[[measure]]", "#");
    run(&write(dir.path(), &next), &dir.path().join("next"), &[]);
    assert_eq!(columns(&dir.path().join("next/particles.csv"))["id"][..2], [0.0, 1.0]);
}

#[test]
fn where_all_have_left_the_fluid_goes_on_alone_and_a_case_begins_with_none() {
    let dir = tempfile::tempdir().unwrap();
    let (out, next) = (dir.path().join("out"), dir.path().join("next"));
    let text = carried("end = 2.0\nstep = 0.005", "[contact]\n");
    let found = run(&write(dir.path(), &text), &out, &[]);
    let left = std::fs::read_to_string(out.join("passages.csv")).unwrap();
    assert_eq!(left.lines().count(), 5, "{left}");
    assert!((found["measures"]["first"].as_f64().unwrap() - 1.0).abs() < 0.1, "{found}");
    let alone = text.split("[[particle]]").next().unwrap().to_owned()
        + &format!("[time]\nend = 0.1\nstep = 0.005\n[initial]\nfrom = {out:?}\n");
    run(&write(dir.path(), &alone), &next, &[]);
    assert!(!next.join("particles.csv").exists());
}

#[test]
fn a_body_returns_or_ends_the_run_where_the_case_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let returns = carried("end = 1.0\nstep = 0.005", "[contact]\n[output]\nfigures = false\nremoved = \"return\"\n");
    let out = dir.path().join("out");
    run(&write(dir.path(), &returns), &out, &[]);
    let rows = columns(&out.join("particles.csv"));
    assert_eq!(rows["id"][rows["id"].len() - 4..], [0.0, 1.0, 2.0, 3.0]);
    let first = rows["x"][rows["x"].len() - 4];
    assert!((0.8..0.9).contains(&first), "{first} m");
    let stops = returns.replace("\"return\"", "\"stop\"");
    let said =
        mics(&["run", write(dir.path(), &stops).to_str().unwrap(), "--out", dir.path().join("stop").to_str().unwrap()]);
    let words = String::from_utf8_lossy(&said.stderr).into_owned();
    assert!(said.status.code() == Some(3) && words.contains("particle 0 has reached an outflow"), "{words}");
}
