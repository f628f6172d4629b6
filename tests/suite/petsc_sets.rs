//! The sets of PETSc's options that `docs/petsc.md` lists do what the page says: six free discs in
//! a closed box, a matrix that is singular and an operator with the bodies in it.

use crate::program::{text, write};
use crate::support::{box_case, mics_command, shipped, summary};
use std::path::{Path, PathBuf};

/// A row of the page's table.
struct Set {
    options: Vec<String>,
    /// Outcome in the closed box with s = 2.65, in the page's words.
    happens: String,
    /// Its other cells: whether they have a number.
    works: Vec<bool>,
}

/// The scenes of the cells, as overrides, in their order; the second one is that of `happens`.
const SCENES: [&[&str]; 5] = [
    &["swarm.0.density=100.0"],
    &[],
    &["swarm.0.density=1e6"],
    &["swarm.0.density=1e7"],
    &["boundary.west={ inflow = [0.1, 0.0] }", "boundary.east=\"outflow\""],
];

/// The rows of the page's table.
fn sets(page: &str) -> Vec<Set> {
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `-")?.split_once("` | "));
    let row = |(options, rest): (&str, &str)| {
        let cells: Vec<&str> = rest.trim_end_matches(" |").split(" | ").map(str::trim).collect();
        Set {
            options: format!("-{options}").split_whitespace().map(str::to_owned).collect(),
            happens: cells[0].to_owned(),
            works: cells[1..].iter().map(|cell| cell.parse::<f64>().is_ok()).collect(),
        }
    };
    rows.map(row).collect()
}

/// Runs the case with overrides and options and says what happens other than expected, in PETSc's
/// or our own words.
fn fault(
    case: &Path,
    out: &Path,
    set: &[&str],
    options: &[String],
    happens: &str,
) -> Option<String> {
    let run = ["run", case.to_str()?, "--quiet", "--force", "--out", out.to_str()?];
    let set = set.iter().flat_map(|set| ["--set", set]);
    let words: Vec<&str> = (run.into_iter().chain(set).chain(["--"]))
        .chain(options.iter().map(String::as_str))
        .collect();
    // Threads of superlu_dist wait for each other by spinning.
    let output = mics_command().args(&words).env("OMP_NUM_THREADS", "1").output().ok()?;
    let said = text(&output.stderr).to_owned();
    let (code, expected) = match happens.split_once(": ") {
        Some(("refused", words)) => (2, words),
        Some(("fails", words)) => (3, words),
        _ => (0, ""),
    };
    let unused = code == 0 && said.contains("warning: PETSc option");
    if output.status.code() != Some(code) || !said.contains(expected) || unused {
        return Some(format!("{words:?}: not \"{happens}\", but {}: {said}", output.status));
    }
    if code == 0 {
        // Below D0 in every cell and step.
        summary(out);
    }
    None
}

fn free_discs(dir: &Path, steps: usize) -> PathBuf {
    let grains = format!(
        "[[swarm]]\nname = \"grain\"\ncount = 6\n\
        region = {{ min = [0.005, 0.015], max = [0.075, 0.035] }}\n\
        diameter = 0.006\ndensity = 2650.0\n[contact]\n[time]\nend = {}\n[output]\n\
        figures = false\n",
        steps as f64 * 1e-4
    );
    let scene = box_case([0.08, 0.04], [128, 64], 0.005, ["\"wall\""; 4], &grains)
        .replace("density = 1.0\n", "density = 1000.0\ngravity = [0.0, -9.81]\n");
    write(dir, &scene)
}

#[test]
fn option_sets_of_the_petsc_page_work_or_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let case = free_discs(dir.path(), 10);
    let sets = sets(&std::fs::read_to_string(shipped("docs/petsc.md")).unwrap());
    assert!(sets.len() >= 40, "{} sets", sets.len());
    let fault = |(k, set): (usize, &Set)| {
        fault(&case, &dir.path().join(k.to_string()), &[], &set.options, &set.happens)
    };
    let faults: Vec<String> = sets.iter().enumerate().filter_map(fault).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Runs the cells of these scenes that have a number, and says which do not work.
fn faults_in(scenes: &[usize]) -> Vec<String> {
    let dir = tempfile::tempdir().unwrap();
    let case = free_discs(dir.path(), 3);
    let sets = sets(&std::fs::read_to_string(shipped("docs/petsc.md")).unwrap());
    let mut faults = Vec::new();
    for (k, set) in sets.iter().enumerate().filter(|(_, set)| set.happens == "works") {
        assert_eq!(set.works.len(), SCENES.len(), "{:?}", set.options);
        for scene in scenes.iter().filter(|scene| set.works[**scene]) {
            let out = dir.path().join(k.to_string());
            faults.extend(fault(&case, &out, SCENES[*scene], &set.options, "works"));
        }
    }
    faults
}

#[test]
fn option_sets_keep_continuity_at_lowest_and_highest_density() {
    let faults = faults_in(&[0, 3]);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
#[ignore = "takes long; ci/weekly"]
fn option_sets_keep_continuity_with_outflow_and_mixture() {
    let faults = faults_in(&[2, 4, 5]);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
