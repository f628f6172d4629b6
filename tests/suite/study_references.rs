//! References of the runs of a study, run by run, and their worst errors over positions.

use crate::study::{rows, study, written};
use std::collections::HashMap;

/// Three Reynolds numbers, of which the reference knows two, at two places each.
const PLACES: &str = r#"name = "tiny"
case = "case.toml"
over = ["place"]

[[axis]]
name = "Re"
choices = [
  { label = "40", set = { "fluid.viscosity" = 0.0075 } },
  { label = "100", set = { "fluid.viscosity" = 0.003 } },
  { label = "150", set = { "fluid.viscosity" = 0.002 } },
]

[[axis]]
name = "place"
choices = [
  { label = "a" },
  { label = "b", set = { "initial.velocity" = [1.1, 0.0] } },
]

[reference.speed]
file = "exact.csv"
column = "speed"
row = { re = "Re" }
"#;

#[test]
fn study_references_by_row_and_worst_error_over_positions() {
    let (dir, file) = written(PLACES);
    let out = dir.path().join("out");
    let (code, said, error) = study(&file, &out, &[]);
    assert_eq!(code, Some(0), "{said}{error}");
    let table = rows(&out);
    let number = |row: &HashMap<String, String>, name: &str| row[name].parse::<f64>().ok();
    let exact = |re: &str| match re {
        "40" => Some(1.0),
        "100" => Some(1.5),
        _ => None,
    };
    for row in &table {
        let (speed, error) = (number(row, "speed").unwrap(), number(row, "speed_error"));
        assert_eq!(error.is_some(), exact(&row["Re"]).is_some(), "{row:?}");
        let off = exact(&row["Re"]).map(|exact| error.unwrap() - (speed / exact - 1.0));
        assert!(off.is_none_or(|off| off.abs() < 1e-12), "{row:?}");
    }

    let text = std::fs::read_to_string(out.join("study.md")).unwrap();
    assert!(said.contains(&text), "{said}");
    let lines: Vec<Vec<&str>> = text
        .lines()
        .map(|line| line[1..line.len() - 1].split('|').map(str::trim).collect())
        .collect();
    assert_eq!(lines[0][..4], ["Re", "runs", "speed", "CPU time (s)"]);
    assert_eq!(lines.len(), 2 + 3, "{text}");
    for (line, re) in lines[2..].iter().zip(["40", "100", "150"]) {
        let of = |name: &str| -> Vec<f64> {
            table.iter().filter(|row| row["Re"] == re).filter_map(|row| number(row, name)).collect()
        };
        let speeds = of("speed");
        assert!(speeds.len() == 2 && speeds[0] != speeds[1], "the place matters: {speeds:?}");
        let low = speeds[0].min(speeds[1]);
        let high = speeds[0].max(speeds[1]);
        let worst = of("speed_error").into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let error = worst.map_or(String::new(), |worst| format!(" ({:+.2} %)", 100.0 * worst));
        assert_eq!(line[..3], [re, "2", &format!("{low:.3} ... {high:.3}{error}")], "{text}");
    }
}

#[test]
fn wrong_study_reference_is_refused() {
    for (from, to, line, says) in [
        ("row = { re =", "row = { rey =", 23, "has no column `rey`; did you mean `re`?"),
        ("row = { re = \"Re\" }", "row = { re = \"re\" }", 23, "0 rows of"),
        ("row = { re = \"Re\" }", "run = { Re = 40 }", 23, "drop one"),
        (
            "over = [\"place\"]",
            "over = [\"plaec\"]",
            3,
            "no axis or label `plaec`; did you mean `place`?",
        ),
        ("over = [", "ovre = [", 3, "did you mean `over`?"),
    ] {
        assert!(PLACES.contains(from), "{from}");
        let (dir, file) = written(&PLACES.replacen(from, to, 1));
        let out = dir.path().join("out");
        let (code, _, error) = study(&file, &out, &[]);
        assert_eq!(code, Some(2), "{to}: {error}");
        assert!(
            error.contains(&format!("tiny.study.toml:{line}: ")) && error.contains(says),
            "{to}: {error}"
        );
        assert!(!out.exists(), "{to}");
    }
}

#[test]
fn study_reference_applies_to_cases_with_the_measure() {
    let text = "name = \"tiny\"\ncase = \"case.toml\"\n[[row]]\nlabels = { what = \"speed\" }\n\
        [[row]]\n\
        labels = { what = \"drag\" }\nset = { case = \"other.toml\" }\n[reference]\ndrag = 2.0\n";
    let (dir, file) = written(text);
    let other = std::fs::read_to_string(dir.path().join("case.toml")).unwrap();
    let other = other.replace("\"speed\"", "\"drag\"").replace("max_speed", "drag_coefficient");
    std::fs::write(dir.path().join("other.toml"), other).unwrap();
    let out = dir.path().join("out");
    let (code, said, error) = study(&file, &out, &[]);
    assert_eq!(code, Some(0), "{said}{error}");
    let has: Vec<_> = rows(&out)
        .iter()
        .map(|r| ["speed", "drag", "drag_error"].map(|c| !r[c].is_empty()))
        .collect();
    assert_eq!(has, [[true, false, false], [false, true, true]], "{said}");
}
