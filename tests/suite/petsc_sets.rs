//! The sets of PETSc's options that `docs/petsc.md` lists do what the page says: six free discs in
//! a closed box, a matrix that is singular and an operator with the bodies in it.

use crate::program::{text, write};
use crate::support::{box_case, mics, shipped, summary};
use std::path::Path;

/// The rows of the page's table: options, and what happens.
fn rows(page: &str) -> Vec<(String, String)> {
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `-")?.split_once("` | "));
    let row = |(options, rest): (&str, &str)| {
        let happens = rest.split(" |").next().unwrap_or_default();
        (format!("-{options}"), happens.to_owned())
    };
    rows.map(row).collect()
}

/// Runs the case with the options and says what the page says of it where that is not so.
fn fault(case: &Path, out: &Path, options: &str, happens: &str) -> Option<String> {
    let run = ["run", case.to_str()?, "--quiet", "--force", "--out", out.to_str()?, "--"];
    let words: Vec<&str> = run.into_iter().chain(options.split_whitespace()).collect();
    let output = mics(&words);
    let said = text(&output.stderr).to_owned();
    let (code, words) = match happens.split_once(": ") {
        Some(("refused", words)) => (2, words),
        Some(("fails", words)) => (3, words),
        _ => (0, ""),
    };
    if output.status.code() != Some(code) || !said.contains(words) {
        return Some(format!("{options}: not \"{happens}\", but {}: {said}", output.status));
    }
    if code == 0 {
        // Below D0 in every cell and step.
        summary(out);
    }
    None
}

#[test]
fn option_sets_of_the_petsc_page_work_or_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let grains = "[[swarm]]\nname = \"grain\"\ncount = 6\n\
        region = { min = [0.005, 0.015], max = [0.075, 0.035] }\n\
        diameter = 0.006\ndensity = 2650.0\n[contact]\n[time]\nend = 0.001\n[output]\n\
        figures = false\n";
    let closed = ["\"wall\""; 4];
    let scene = box_case([0.08, 0.04], [128, 64], 0.005, closed, grains)
        .replace("density = 1.0\n", "density = 1000.0\ngravity = [0.0, -9.81]\n");
    let case = write(dir.path(), &scene);
    let page = std::fs::read_to_string(shipped("docs/petsc.md")).unwrap();
    let rows = rows(&page);
    assert!(rows.len() >= 40, "{} sets", rows.len());
    let fault = |(k, (options, happens)): (usize, &(String, String))| {
        fault(&case, &dir.path().join(k.to_string()), options, happens)
    };
    let faults: Vec<String> = rows.iter().enumerate().filter_map(fault).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
