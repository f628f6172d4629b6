//! Studies: a table of runs, what it says of each, and what is refused before any of them starts.

use crate::support::{AS_ROOT, STREAM, box_case, mics, mics_command, shipped};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Stdio;

const MORE: &str = "[time]\nend = 0.05\ncfl = 0.4\n[[measure]]\nname = \"speed\"\n\
    kind = \"max_speed\"\n\
    [pressure]\ndivergence_limit = 1e-4\n\
    [[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [0.6, 0.5]\n\
    motion = \"fixed\"\n[coupling]\nwall = \"sharp\"\n";
const STUDY: &str = r#"name = "tiny"
case = "case.toml"
repeats = 2

[[axis]]
name = "N"
choices = [
  { label = 16, set = { "domain.cells" = [16, 8] } },
  { label = 32, set = { "domain.cells" = [32, 16] } },
]

[[axis]]
name = "solver"
choices = [
  { label = "bcgs" },
  { label = "cg", set = { "petsc.options" = "-ksp_type cg -pc_type gamg" } },
  { label = "none", set = { "petsc.options" = "-ksp_type cg -pc_type none -ksp_max_it 1" } },
]

[[row]]
labels = { N = 24, solver = "fixed step" }
set = { "time.step" = 0.01 }

[reference.speed]
file = "exact.csv"
column = "speed"
row = { re = 100 }

[quick]
keep = { N = [16], solver = ["bcgs"] }
"#;

/// A folder with a tiny case, its reference and a study of that text.
pub fn written(study: &str) -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(
        dir.path().join("case.toml"),
        box_case([2.0, 1.0], [24, 12], 0.01, STREAM, MORE),
    )
    .unwrap();
    std::fs::write(dir.path().join("exact.csv"), "# where from\nre,speed\n40,1.0\n100,1.5\n")
        .unwrap();
    let file = dir.path().join("tiny.study.toml");
    std::fs::write(&file, study).unwrap();
    (dir, file)
}

/// Exit status of a study, and what it says on both channels.
pub fn study(file: &Path, out: &Path, more: &[&str]) -> (Option<i32>, String, String) {
    let words = ["study", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let output = mics(&[&words[..], more].concat());
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// The rows of `study.csv`, by the names of the columns.
pub fn rows(out: &Path) -> Vec<HashMap<String, String>> {
    csv::Reader::from_path(out.join("study.csv"))
        .unwrap()
        .deserialize()
        .map(Result::unwrap)
        .collect()
}

#[test]
fn study_writes_rows_and_figures_and_resumes() {
    let (dir, file) = written(STUDY);
    let out = dir.path().join("out");
    let (code, said, error) = study(&file, &out, &[]);
    assert_eq!(code, Some(1), "{said}{error}");
    let names = "2 of 7 runs are not done: N=16,solver=none (failed), N=32,solver=none (failed)";
    assert!(error.contains(names), "{error}");
    let table = rows(&out);
    let labels: Vec<_> =
        table.iter().map(|row| (row["N"].as_str(), row["solver"].as_str())).collect();
    let pairs =
        ["16", "32"].into_iter().flat_map(|n| ["bcgs", "cg", "none"].map(|solver| (n, solver)));
    assert_eq!(labels, pairs.chain([("24", "fixed step")]).collect::<Vec<_>>());
    for row in &table {
        if row["solver"] == "none" {
            assert_eq!(
                (row["status"].as_str(), row["repeats"].as_str(), row["cpu_seconds"].as_str()),
                ("failed", "0", "")
            );
            assert!(row["message"].contains("failed twice"), "{row:?}");
            continue;
        }
        let number =
            |name: &str| row[name].parse::<f64>().unwrap_or_else(|_| panic!("{name} in {row:?}"));
        assert_eq!((row["status"].as_str(), number("repeats")), ("done", 2.0));
        assert!((number("speed_error") - (number("speed") / 1.5 - 1.0)).abs() < 1e-12, "{row:?}");
        assert!(
            number("cpu_seconds") > 0.0
                && number("us_per_cell_step") > 0.0
                && number("peak_memory_bytes") > 1e6
        );
        let cells = match row["N"].as_str() {
            "16" => 128.0,
            "32" => 512.0,
            _ => 288.0,
        };
        assert_eq!(number("cells"), cells);
    }
    assert!(table[1]["set"].ends_with("petsc.options=\"-ksp_type cg -pc_type gamg\""));
    assert_eq!(table[6]["steps"], "5", "the step of the row, not the case's Courant number");
    for name in ["value_speed.png", "work_precision_speed.png", "work_precision_speed.svg"] {
        assert!(std::fs::metadata(out.join(name)).is_ok_and(|m| m.len() > 2000), "{name}");
    }
    let svg = std::fs::read_to_string(out.join("value_speed.svg")).unwrap();
    for label in ["N", "speed (m/s)", "bcgs", "cg", "reference"] {
        assert!(svg.contains(&format!(">\n{label}\n<")), "the figure of the value lacks {label}");
    }
    let plot = mics(&["plot", out.to_str().unwrap()]);
    let refused = String::from_utf8_lossy(&plot.stderr).into_owned();
    assert!(
        plot.status.code() == Some(2) && refused.contains("a study's folder; `mics study` draws"),
        "{refused}"
    );
    assert!(said.contains("| N  | solver     | speed ") && said.contains("| failed: "), "{said}");

    // Runs that are done stay; those that are not, or are other runs by now, are done.
    std::fs::remove_dir_all(out.join("runs/N=16,solver=cg/2")).unwrap();
    std::fs::write(&file, STUDY.replace("0.01 }", "0.0125 }")).unwrap();
    let (code, said, error) = study(&file, &out, &[]);
    assert_eq!(code, Some(1), "{said}{error}");
    let times = |word: &str| said.matches(&format!(": {word}, ")).count();
    assert_eq!((times("kept"), times("done")), (7, 3), "{said}");
    assert_eq!(rows(&out)[6]["steps"], "4");
    let (_, listed, _) = study(&file, &out, &["--list"]);
    assert!(listed.contains("N=16,solver=cg: 16 x 8 cells, 2 of 2 done"), "{listed}");
    assert!(
        listed.ends_with(&format!("7 runs, 2 times each, 4 left to do, into {}\n", out.display())),
        "{listed}"
    );

    let quick = dir.path().join("quick");
    let (code, said, error) = study(&file, &quick, &["--quick"]);
    assert_eq!(code, Some(0), "{said}{error}");
    assert_eq!(rows(&quick).len(), 1, "{said}");
}

#[test]
fn studies_on_several_ranks_run_concurrently() {
    let text = "name = \"tiny\"\ncase = \"case.toml\"\nrepeats = 2\n[[axis]]\nname = \"ranks\"\n\
        key = \"ranks\"\nvalues = [1, 2]\n";
    let (dir, file) = written(text);
    let start = |name: &str| {
        let (file, out) = (file.to_str().unwrap(), dir.path().join(name));
        let mut command = mics_command();
        command.envs(AS_ROOT).args(["study", file, "--out", out.to_str().unwrap()]);
        (out, command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap())
    };
    let both = ["a", "b"].map(start);
    for (out, process) in both {
        let output = process.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let table = rows(&out);
        let found: Vec<_> =
            table.iter().map(|row| (row["ranks"].as_str(), row["status"].as_str())).collect();
        assert_eq!(found, [("1", "done"), ("2", "done")], "{table:?}");
        let speed = |row: &HashMap<String, String>| row["speed"].parse::<f64>().unwrap();
        assert!((speed(&table[0]) / speed(&table[1]) - 1.0).abs() < 1e-3, "{table:?}");
    }
}

#[test]
fn study_reports_refused_combination_as_row() {
    let axes = "[[axis]]\nname = \"scheme\"\nkey = \"time.scheme\"\nvalues = [\"euler\", \"rk2\"]\n\
                [[axis]]\nname = \"advection\"\nkey = \"time.advection\"\n\
                    values = [\"upwind5\", \"qsi\"]\n";
    let text =
        format!("name = \"tiny\"\ncase = \"case.toml\"\nset = {{ \"time.cfl\" = 0.2 }}\n{axes}");
    let (dir, file) = written(&text);
    let out = dir.path().join("out");
    let (code, said, error) = study(&file, &out, &[]);
    assert_eq!(code, Some(1), "{said}{error}");
    let status: Vec<_> = rows(&out).iter().map(|row| row["status"].clone()).collect();
    assert_eq!(status, ["done", "done", "done", "refused"]);
    assert!(rows(&out)[3]["message"].contains("qsi"), "{said}");

    let (dir, file) = written(&text.replace("\"upwind5\", \"qsi\"", "\"upwind5\", \"qsy\""));
    let (code, _, error) = study(&file, &dir.path().join("out"), &[]);
    assert_eq!(code, Some(2), "{error}");
    assert!(
        error.contains("tiny.study.toml:11: axis.1.values.1: time.advection: unknown value `qsy`"),
        "{error}"
    );
}

#[test]
fn study_reports_out_of_range_choice_as_row() {
    let axis = "[[axis]]\nname = \"cells\"\nkey = \"domain.cells\"\n\
        values = [[24, 12], [24, 1], [16, 8]]\n";
    let text =
        format!("name = \"tiny\"\ncase = \"case.toml\"\n{}", axis.replace("\"cells\"", "\"N\""));
    let (dir, file) = written(&text);
    let out = dir.path().join("out");
    let (code, said, error) = study(&file, &out, &[]);
    assert_eq!(code, Some(1), "{said}{error}");
    let table = rows(&out);
    let status: Vec<_> = table.iter().map(|row| row["status"].clone()).collect();
    assert_eq!(status, ["done", "refused", "done"], "{said}");
    assert!(table[1]["message"].contains("domain.cells.1: must be at least 6"), "{:?}", table[1]);
    assert!(error.contains("1 of 3 runs are not done"), "{error}");

    // Where no run is left the file is at fault.
    let (dir, file) = written(&text.replace("[[24, 12], [24, 1], [16, 8]]", "[[24, 1], [1, 8]]"));
    let (code, _, error) = study(&file, &dir.path().join("out"), &[]);
    assert!(code == Some(2) && error.contains("axis.0.values.0: domain.cells.1"), "{error}");
}

#[test]
fn study_names_refused_runs_before_the_first() {
    let axis = "[[axis]]\nname = \"step\"\nkey = \"time.step\"\nvalues = [0.01, 5.0, 0.0125]\n";
    let (dir, file) = written(&format!("name = \"tiny\"\ncase = \"case.toml\"\n{axis}"));
    let out = dir.path().join("out");
    let (code, said, error) = study(&file, &out, &[]);
    assert_eq!(code, Some(1), "{said}{error}");
    let first = said.lines().next().unwrap();
    assert!(first.starts_with("step=5.0 is refused: time.step: 5 s is over the"), "{said}");
    assert!(error.contains("1 of 3 runs are not done: step=5.0 (refused)"), "{error}");
    let status: Vec<_> = rows(&out).iter().map(|row| row["status"].clone()).collect();
    assert_eq!(status, ["done", "refused", "done"], "{said}");
}

#[test]
fn wrong_study_file_is_refused_with_line_and_cure() {
    for (from, to, line, says) in [
        ("repeats = 2", "repeat = 2", 3, "unknown key `repeat`; did you mean `repeats`?"),
        ("repeats = 2", "repeats = 0", 3, "repeats: must be 1 or more"),
        ("repeats = 2", "ranks = [1]", 3, "[[axis]] with key = \"ranks\""),
        ("repeats = 2", "set = { ranks = 0 }", 3, "ranks must be a whole number, 1 or more"),
        ("name = \"tiny\"", "name = \"a/b\"", 1, "cannot name a folder"),
        ("case = \"case.toml\"", "", 0, "missing key `case`"),
        ("{ label = 16, set", "{ lable = 16, set", 8, "did you mean `label`?"),
        ("label = 16", "label = 32", 9, "`32` is there twice"),
        (
            "\"domain.cells\" = [16, 8]",
            "domain.cells = [16, 8]",
            8,
            "write each override's key in quotes: \"domain.cells\"",
        ),
        ("\"domain.cells\" = [16, 8]", "\"domain.cels\" = [16, 8]", 8, "did you mean `cells`?"),
        ("name = \"solver\"", "name = \"N\"", 13, "there is an axis `N` already"),
        ("name = \"solver\"", "name = \"cells\"", 13, "is a column that study.csv has anyway"),
        (
            "choices = [\n  { label = \"bcgs\" }",
            "values = [\n  { label = \"bcgs\" }",
            12,
            "lacks the `key`",
        ),
        ("\"time.step\" = 0.01", "\"time.stop\" = -1", 22, "time.stop: unknown key"),
        (
            "[reference.speed]",
            "[reference.sped]",
            24,
            "the case has no measure `sped`; did you mean `speed`?",
        ),
        ("[reference.speed]", "[[reference]]\nmeasure = \"speed\"", 25, "[reference.MEASURE]"),
        ("file = \"exact.csv\"", "file = \"other.csv\"", 25, "other.csv: No such file"),
        (
            "column = \"speed\"",
            "column = \"spead\"",
            26,
            "has no column `spead`; did you mean `speed`?",
        ),
        ("row = { re = 100 }", "", 24, "2 rows of"),
        ("row = { re = 100 }", "value = 1.0", 27, "unknown key `value`"),
        ("keep = { N = [16]", "keep = { N = [17]", 30, "`N` has no `17`"),
        ("[quick]", "[plot]\nseries = [\"N\"]\n[quick]", 29, "leave this table out"),
    ] {
        assert!(STUDY.contains(from), "{from}");
        let (dir, file) = written(&STUDY.replacen(from, to, 1));
        let out = dir.path().join("out");
        let (code, _, error) = study(&file, &out, &[]);
        assert_eq!(code, Some(2), "{to}: {error}");
        // A key that is missing at the top has no line.
        let place = if line == 0 {
            "tiny.study.toml: ".into()
        } else {
            format!("tiny.study.toml:{line}: ")
        };
        assert!(error.contains(&place) && error.contains(says), "{to}: {error}");
        assert!(!out.exists(), "{to}");
    }
}

#[test]
fn study_refuses_foreign_folder() {
    let (dir, file) = written(STUDY);
    let (code, _, error) = study(&file, dir.path(), &[]);
    assert_eq!(code, Some(2));
    assert!(error.contains("holds no study") && error.contains("--out"), "{error}");
}

#[test]
fn shipped_studies_are_valid_with_quick_part() {
    let cases = std::fs::read_dir(shipped("cases")).unwrap().map(|case| case.unwrap().path());
    let files =
        cases.filter(|case| case.is_dir()).flat_map(|case| std::fs::read_dir(case).unwrap());
    let files = files
        .map(|file| file.unwrap().path())
        .filter(|file| file.to_str().unwrap().ends_with(".study.toml"));
    let mut count = 0;
    for file in files {
        let name = file.display();
        let dir = tempfile::tempdir().unwrap();
        let runs = |more: &[&str]| {
            let (code, said, error) =
                study(&file, &dir.path().join("out"), &[&["--list"], more].concat());
            assert_eq!(code, Some(0), "{name}: {error}");
            // At its limits, being refused is a result.
            assert!(
                !said.contains("refused") || name.to_string().contains("stress"),
                "{name}: {said}"
            );
            said.lines().count()
        };
        assert!(runs(&["--quick"]) < runs(&[]), "{name}");
        count += 1;
    }
    assert!(count >= 14, "{count} studies are shipped");
}
