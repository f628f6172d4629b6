//! Studies of solvers: runs compared with each other, failures as results, limits of time, and what
//! tables and figures show of costs.

use crate::live::wait_for;
use crate::study::{rows, study, written};
use crate::support::{AS_ROOT, mics_command};
use std::collections::HashMap;
use std::path::Path;

const SOLVERS: &str = r#"name = "tiny"
case = "case.toml"
across = "nu"
columns = ["krylov_per_step", "speed"]

[[axis]]
name = "scene"
choices = [
  { label = "coarse, one" },
  { label = "fine", set = { "domain.cells" = [32, 16] } },
]

[[axis]]
name = "solver"
choices = [
  { label = "tight", set = { "pressure.divergence_limit" = 1e-9 } },
  { label = "default" },
  { label = "none", set = { "petsc.options" = "-ksp_type cg -pc_type none -ksp_max_it 1" } },
]

[[axis]]
name = "nu"
choices = [
  { label = 0.01 },
  { label = 0.02, set = { "fluid.viscosity" = 0.02 } },
]

[[row]]
labels = { solver = "amg", scene = "fine", nu = 0.01 }
set = { "domain.cells" = [32, 16], "pressure.solver" = "bcgs-boomeramg" }

[[row]]
labels = { solver = "lone", scene = "none", nu = 0.03 }

[reference.speed]
run = { solver = "tight" }

[quick]
keep = { scene = ["fine"], nu = [0.01] }
"#;

fn number(row: &HashMap<String, String>, name: &str) -> Option<f64> {
    row[name].parse().ok()
}

/// The cells of each line of a Markdown table that begins after `title`.
fn lines(text: &str, title: &str) -> Vec<Vec<String>> {
    let table = text[text.find(title).unwrap() + title.len()..].trim_start();
    let lines = table.lines().take_while(|line| line.starts_with('|'));
    let cells = |line: &str| line[1..line.len() - 1].split('|').map(|c| c.trim().into()).collect();
    lines.map(cells).collect()
}

#[test]
fn study_across_viscosity_compares_solvers_with_a_tight_solve() {
    let (dir, file) = written(SOLVERS);
    let out = dir.path().join("out");
    let (code, said, error) = study(&file, &out, &[]);
    assert_eq!(code, Some(1), "{said}{error}");
    assert!(
        error.contains("4 of 14 runs are not done: scene=coarse,_one,solver=none,nu=0.01 (failed)")
    );
    let table = rows(&out);
    for row in &table {
        let tight = table.iter().find(|other| {
            other["solver"] == "tight"
                && ["scene", "nu"].iter().all(|name| other[*name] == row[*name])
        });
        let exact = tight.and_then(|tight| number(tight, "speed"));
        match row["solver"].as_str() {
            // Compared with itself it would be right by definition.
            "tight" | "lone" | "none" => assert_eq!(row["speed_error"], "", "{row:?}"),
            _ => {
                let (speed, error) = (number(row, "speed").unwrap(), number(row, "speed_error"));
                let off = error.unwrap() - (speed / exact.unwrap() - 1.0);
                assert!(off.abs() < 1e-15, "{row:?}");
            }
        }
        let done = row["solver"] != "none";
        assert_eq!((row["status"] == "done", row["status"] == "failed"), (done, !done));
        if done {
            let [whole, pressure, per_solve, krylov, outer, reached] = [
                "cpu_seconds",
                "pressure_cpu_seconds",
                "krylov_per_solve",
                "krylov_iterations",
                "outer_iterations",
                "divergence_over_limit",
            ]
            .map(|name| number(row, name).unwrap_or_else(|| panic!("{name} of {row:?}")));
            assert!(0.0 < pressure && pressure < whole, "{row:?}");
            assert!((per_solve - krylov / outer).abs() < 1e-12 && reached < 1.0, "{row:?}");
        }
    }
    let different =
        |row: &&HashMap<String, String>| number(row, "speed_error").is_some_and(|e| e != 0.0);
    assert!(table.iter().any(|row| different(&row)), "D0 of 1e-4 and 1e-9 give the same digits");

    let text = std::fs::read_to_string(out.join("study.md")).unwrap();
    assert!(said.contains(&text), "{said}");
    let across = lines(&text, "Krylov iterations per step:");
    assert_eq!(across[0], ["scene", "solver", "nu = 0.01", "nu = 0.02", "nu = 0.03"]);
    assert_eq!(across[4], ["coarse, one", "none", "failed", "failed", ""]);
    let amg = across.iter().find(|line| line[1] == "amg").unwrap();
    assert!(amg[2].parse::<f64>().is_ok() && amg[3].is_empty(), "{across:?}");
    let across = lines(&text, "speed:");
    let cell = |label: &str| &across.iter().find(|line| line[1] == label).unwrap()[2];
    assert!(cell("tight").parse::<f64>().is_ok(), "no error of the reference: {across:?}");
    let (speed, error) = cell("default").split_once(" (").unwrap();
    assert!(speed.parse::<f64>().is_ok() && error.ends_with(')'), "{across:?}");
    for name in ["value_krylov_per_step", "value_speed"] {
        let figure = std::fs::read_to_string(out.join(format!("{name}.svg"))).unwrap();
        let shows = |word: &str| figure.contains(&format!(">\n{word}\n<"));
        assert!(shows("nu") && shows("fine, amg") && !shows("fine, none"), "{name}");
    }
}

#[test]
fn petsc_option_that_nothing_used_is_said_in_tables_and_at_the_end() {
    let text = "name = \"tiny\"\ncase = \"case.toml\"\n[[axis]]\nname = \"solver\"\n\
        choices = [{ label = \"typo\", set = { \"petsc.options\" = \
        \"-ksp_type cg -pc_mg_level 3\" } }]\n";
    let (dir, file) = written(text);
    let out = dir.path().join("out");
    for how in ["run", "kept"] {
        let (code, said, error) = study(&file, &out, &[]);
        assert_eq!(code, Some(0), "{said}{error}");
        let [csv, md] =
            ["study.csv", "study.md"].map(|name| std::fs::read_to_string(out.join(name)).unwrap());
        let end: String = said.lines().skip_while(|line| !line.starts_with('|')).collect();
        for text in [csv, md, end] {
            assert!(text.contains("nothing used: -pc_mg_level 3"), "{how}: {text}");
        }
    }
}

#[test]
fn failed_reference_run_leaves_errors_empty() {
    let tight = "\"pressure.divergence_limit\" = 1e-9";
    let (dir, file) = written(&SOLVERS.replace(tight, "\"pressure.divergence_limit\" = 1e-17"));
    let out = dir.path().join("out");
    let (code, said, error) = study(&file, &out, &["--quick"]);
    assert_eq!(code, Some(1), "{said}{error}");
    let table = rows(&out);
    let of = |name: &str| table.iter().find(|row| row["solver"] == name).unwrap();
    assert_eq!(
        (of("tight")["status"].as_str(), of("default")["status"].as_str()),
        ("failed", "done")
    );
    assert!(!of("default")["speed"].is_empty() && of("default")["speed_error"].is_empty());
}

#[test]
fn wrong_keys_of_a_study_of_solvers_are_refused() {
    for (from, to, says) in [
        (
            "run = { solver =",
            "run = { solvers =",
            "no axis or label `solvers`; did you mean `solver`?",
        ),
        ("\"tight\" }\n", "\"tigth\" }\n", "`solver` has no `tigth`; did you mean `tight`?"),
        ("run = { solver =", "file = \"a.csv\"\nrun = { solver =", "drop one"),
        ("run = { solver = \"tight\" }", "run = { solver = \"lone\" }", "no run has the labels"),
        ("across = \"nu\"", "limit_seconds = 0", "limit_seconds: must be a time above zero"),
        ("across = \"nu\"", "across = \"mu\"", "no axis or label `mu`"),
        ("across = \"nu\"", "failures = \"rows\"", "failures: a run that is not done is a row"),
        ("\"krylov_per_step\"", "\"krylov_per_stp\"", "did you mean `krylov_per_step`?"),
        ("\"speed\"]", "\"status\"]", "study.csv has no number `status`"),
    ] {
        assert!(SOLVERS.contains(from), "{from}");
        let (dir, file) = written(&SOLVERS.replacen(from, to, 1));
        let out = dir.path().join("out");
        let (code, _, error) = study(&file, &out, &[]);
        assert!(code == Some(2) && error.contains(says), "{to}: {error}");
        assert!(error.contains("tiny.study.toml:") && !out.exists(), "{to}: {error}");
    }
    // --quick must not leave out what runs are compared with.
    let (dir, file) =
        written(&SOLVERS.replace("nu = [0.01] }", "nu = [0.01], solver = [\"default\"] }"));
    let (code, _, error) = study(&file, &dir.path().join("out"), &["--quick"]);
    assert!(code == Some(2) && error.contains("[quick] must keep it"), "{error}");
}

/// A study of runs that would take many minutes each.
fn endless(more: &str) -> String {
    format!(
        "name = \"tiny\"\ncase = \"case.toml\"\nlimit_seconds = 2\n{more}[[axis]]\n\
        name = \"end\"\nkey = \"time.end\"\nvalues = [1e4, 2e4]\n"
    )
}

/// Checks the rows of that study, and that nothing of its runs is left. On a busy machine they may
/// be ended before they have begun.
fn ended(out: &Path, ranks: usize) {
    let table = rows(out);
    assert_eq!(table.len(), 2, "{table:?}");
    for slow in &table {
        assert_eq!((&slow["status"][..], &slow["cpu_seconds"][..]), ("too slow", ""), "{slow:?}");
        let words = &slow["message"];
        assert!(
            words.starts_with("ended after 2 s, ") && words.ends_with("(limit_seconds)"),
            "{words}"
        );
        let folder = out.join(&slow["folder"]).join("1");
        assert!(!folder.join("checkpoint").exists() && !folder.join("fields").exists());
        let Ok(text) = std::fs::read_to_string(folder.join("run.json")) else { continue };
        let record: serde_json::Value = serde_json::from_str(&text).unwrap();
        wait_for(|| !Path::new("/proc").join(record["pid"].to_string()).exists());
        assert_eq!(record["ranks"], ranks, "{record}");
    }
}

#[test]
fn study_ends_a_run_that_is_over_its_limit() {
    let (dir, file) = written(&endless(""));
    let out = dir.path().join("out");
    let (code, said, error) = study(&file, &out, &[]);
    assert_eq!(code, Some(1), "{said}{error}");
    assert!(error.contains("2 of 2 runs are not done: end=10000.0 (too slow)"), "{error}");
    ended(&out, 1);
}

#[test]
fn study_ends_ranks_that_are_over_their_limit() {
    let (dir, file) = written(&endless("set = { ranks = 2 }\n"));
    let out = dir.path().join("out");
    let words = ["study", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let output = mics_command().envs(AS_ROOT).args(words).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    ended(&out, 2);
}
