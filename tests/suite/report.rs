//! `mics report` and `mics validate`. How a report looks in a browser is `ci/read-report`'s.

use crate::support::{mics, run, shipped};
use std::fs;
use std::path::Path;

fn report(run: &Path) -> String {
    let output = mics(&["report", run.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(
        String::from_utf8_lossy(&output.stdout).trim(),
        run.join("report.html").to_str().unwrap()
    );
    fs::read_to_string(run.join("report.html")).unwrap()
}

#[test]
fn report_has_case_comparison_and_command() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    // The source would be markup, were it not escaped; one measure passes, one falls short, one has
    // no reference.
    let measures = "measure=[{ name = \"speed\", kind = \"largest_speed\", reference = [0.0, 9.0], \
        source = \"<b>me</b> & co\" }, \
        { name = \"y\", kind = \"position_y\", reference = 99.0, tolerance = 0.01 }, { name = \
            \"x\", kind = \"position_x\" }]";
    let more = ["--set", measures, "--set", "time.end=0.05", "--set", "domain.cells=[32,96]"];
    let summary = run(
        &shipped("cases/settling-disc/case.toml"),
        &out,
        &[&more[..], &["--", "-ksp_type", "cg"]].concat(),
    );
    assert_eq!(
        (&summary["comparisons"]["speed"]["pass"], &summary["comparisons"]["y"]["pass"]),
        (&true.into(), &false.into())
    );
    assert!(summary["comparisons"]["x"].is_null());
    let html = report(&out);
    for part in [
        "1 of 2 fall short of their references",
        "&lt;b&gt;me&lt;/b&gt; &amp; co",
        "0 to 9",
        " m/s</td>",
        "falls short",
        "no reference",
        "V d/nu of the particle that reaches most",
        "sqrt(|s - 1| g d^3)/nu",
        "contacts (20-25)",
        "the case has no [contact]",
        "cg + boxmg",
        "mics run case.toml --out again -- -ksp_type cg",
        "density ratio 1.2500, free",
        "<pre>name = &quot;settling-disc&quot;",
        "assembly",
    ] {
        assert!(html.contains(part), "no `{part}`");
    }
    for title in
        ["Vorticity", "Streamlines", "Forces", "Paths", "Velocity", "Iterations and divergence"]
    {
        assert!(
            html.contains(&format!("<h3>{title}</h3><svg role=\"img\" aria-label=\"{title}\"")),
            "no figure {title}"
        );
    }
    // It needs nothing else: no script, and no address but those of the XML names.
    assert!(!html.contains("<script") && !html.contains("<b>me"));
    let addresses = html.match_indices("http").map(|(at, _)| &html[at..at + 21]);
    let foreign: Vec<_> = addresses
        .filter(|a| !a.starts_with("http://www.w3.org/") && !a.starts_with("http-equiv"))
        .collect();
    assert!(foreign.is_empty(), "{foreign:?}");
    // It is a run's file: a run that replaces this one takes it away.
    run(&shipped("cases/settling-disc/case.toml"), &out, &[&more[..], &["--force"]].concat());
    assert!(!out.join("report.html").exists());
}

/// A disc that sinks in the middle of a box, with a profile, a probe and a line of probes.
const SINKS: &str = r#"
name = "sinks"
domain = { size = [0.1, 0.15], cells = [20, 30] }
fluid = { density = 1000.0, viscosity = 0.05, gravity = [0.0, -9.81] }
boundary = { west = "wall", east = "wall", south = "wall", north = "wall" }
contact = { restitution = 0.35, pair = [{ between = ["stone", "wall"], restitution = 0.85 }] }
time = { end = 0.05, cfl = 0.4 }
statistics = { from = 0.01, profile = "y" }
probe = [
  { name = "below", at = [0.05, 0.05] },
  { name = "row", at = [0.02, 0.05], to = [0.08, 0.05], points = 4, every = 2 },
]
measure = [{ name = "speed", kind = "max_speed", reference = [0.00000001, 0.30000000000000004] }]
[[particle]]
shape.disc.diameter = 0.020000000000000004
material = "stone"
density = 1200.0
position = [0.05, 0.1]
"#;

#[test]
fn report_has_profiles_probes_and_contact_laws() {
    let dir = tempfile::tempdir().unwrap();
    let (case, out) = (dir.path().join("sinks.toml"), dir.path().join("run"));
    fs::write(&case, SINKS).unwrap();
    run(&case, &out, &[]);
    for name in ["profile", "probes", "probe_lines"] {
        assert!(out.join(format!("figures/{name}.png")).exists(), "{name}");
    }
    let html = report(&out);
    let said = html.split("<details>").next().unwrap();
    for part in [
        "<h3>Profile</h3>",
        "<h3>Probes over time</h3>",
        "<h3>Probes along lines</h3>",
        "mean velocity along",
        "all other contacts: friction",
        "restitution 0.35",
        "stone with wall: friction",
        "d = 0.02 m",
        "1e-8 to 0.3",
        "force along y (N/m)",
        // A symmetric scene has no force across, and nothing is drawn of it.
        "force along x is zero",
    ] {
        assert!(said.contains(part), "no `{part}`");
    }
    assert!(!said.contains("force along x (N"));
    let digits = said
        .match_indices("00000000")
        .map(|(at, _)| &said[at.saturating_sub(20)..at + 10])
        .collect::<Vec<_>>();
    assert!(
        digits.iter().all(|around| !around.contains("0.0200") && !around.contains("0.3000")),
        "{digits:?}"
    );
}

/// A run that was warned of its numbers is no plain success.
#[test]
fn warnings_of_a_run_head_its_report() {
    let dir = tempfile::tempdir().unwrap();
    let (case, out) = (dir.path().join("sinks.toml"), dir.path().join("run"));
    fs::write(&case, SINKS.replace("viscosity = 0.05", "viscosity = 1e-5")).unwrap();
    let short = ["time.end=0.005", "statistics.from=0.0", "output.figures=false"];
    run(&case, &out, &short.map(|set| ["--set", set]).concat());
    let html = report(&out);
    let said = html.split("<nav").next().unwrap();
    for part in ["<span class=\"chip warn\">done</span>", "warning      the boundary layer of "] {
        assert!(said.contains(part), "no `{part}` in {said}");
    }
}

#[test]
fn report_of_failed_or_unfinished_run() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let case = shipped("cases/settling-disc/case.toml");
    run(
        &case,
        &out,
        &[
            "--set",
            "time.end=0.02",
            "--set",
            "domain.cells=[32,96]",
            "--set",
            "output.figures=false",
        ],
    );
    // As a run that has not ended leaves it.
    fs::remove_file(out.join("summary.json")).unwrap();
    let html = report(&out);
    assert!(
        html.contains("not ended")
            && html.contains("<h3>Iterations and divergence</h3>")
            && !html.contains("Where the time went")
    );
    // As one that failed leaves it.
    fs::write(out.join("summary.json"), "{\"status\": \"failed\", \"steps\": 3}").unwrap();
    let log = fs::read_to_string(out.join("log.txt")).unwrap();
    fs::write(out.join("log.txt"), log + "error: step 4, from t = 0.01 s: the sky fell\n").unwrap();
    assert!(report(&out).contains("<p class=\"notice\">step 4, from t = 0.01 s: the sky fell</p>"));
}

#[test]
fn validate_prints_value_reference_error_and_verdict() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let output = mics(&["validate", "settling-disc N 8", "--out", out.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    let row = said
        .lines()
        .find(|line| line.contains("largest_speed"))
        .unwrap_or_else(|| panic!("{said}"));
    for part in ["settling-disc N 8", "5.575", " %", "2 %", "pass"] {
        assert!(row.contains(part), "no `{part}` in {row}");
    }
    assert!(said.trim_end().ends_with("7 of 7 values pass"), "{said}");
    assert!(out.join("runs/case=settling-disc_N_8/1/summary.json").exists());
}

#[test]
fn validate_compares_with_accuracy_page() {
    let dir = tempfile::tempdir().unwrap();
    let (out, page) = (dir.path().join("out"), dir.path().join("accuracy.md"));
    let go = |more: &[&str]| {
        let words = ["validate", "open-channel", "--out", out.to_str().unwrap()];
        let output = mics(&[&words[..], more].concat());
        let said = [&output.stdout, &output.stderr]
            .map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        (output.status.code(), said)
    };
    let (status, [written, _]) = go(&["--markdown"]);
    assert_eq!(status, Some(0), "{written}");
    assert!(
        written.starts_with("# Accuracy\n")
            && written.contains("`mics validate \"open-channel\" --markdown`"),
        "{written}"
    );
    let row = written
        .lines()
        .find(|line| line.contains(" pass "))
        .unwrap_or_else(|| panic!("{written}"))
        .to_owned();
    fs::write(&page, &written).unwrap();
    let compare = ["--compare", page.to_str().unwrap()];
    let (status, [said, _]) = go(&compare);
    assert!(status == Some(0) && said.contains("all are as"), "{said}");
    // A page that says another value is found out.
    let value = row.split('|').nth(3).unwrap().trim();
    let another = format!("{:.6}", 1.5 * value.parse::<f64>().unwrap());
    fs::write(&page, written.replacen(value, &another, 1)).unwrap();
    let (status, [_, said]) = go(&compare);
    assert!(status == Some(1) && said.contains("1 are not as") && said.contains(value), "{said}");
}
