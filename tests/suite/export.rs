//! `mics export-system`: what it says of the system, and what it refuses. (What it writes is read
//! back by SciPy and PETSc, and solved: `ci/read-system`.)

use crate::bad_input::{expect_none, shortcomings};
use crate::program::{text, write};
use crate::support::{MIXING, SHARP, box_case, mics, mpirun};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Exports, which must succeed; returns what `system.json` says.
fn exported(folder: &Path, case: &str, more: &[&str]) -> Value {
    let case = write(folder, case);
    let out = folder.join("system");
    let words =
        ["export-system", case.to_str().unwrap(), "--force", "--out", out.to_str().unwrap()];
    let output = mics(&[&words[..], more].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json = fs::read_to_string(out.join("system.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    assert!(json["relative_residual_of_x"].as_f64() < Some(1e-12), "{json}");
    for (file, there) in [
        ("A.mtx", !json["nonzeros"]["A"].is_null()),
        ("J.petsc", json["factors"][0].is_object()),
        ("null.mtx", json["singular"] == true),
    ] {
        assert_eq!(out.join(file).exists(), there, "{file}");
    }
    let page = fs::read_to_string(out.join("README.md")).unwrap();
    let unfilled = page.split('@').skip(1).any(|rest| rest.starts_with(char::is_uppercase));
    assert!(!unfilled, "{page}");
    json
}

/// The weights of the factors.
fn weights(json: &Value) -> Vec<f64> {
    let factors = json["factors"].as_array().unwrap();
    factors.iter().map(|factor| factor["weight"].as_f64().unwrap()).collect()
}

const CLOSED: [&str; 4] = ["\"wall\""; 4];
const STREAM: [&str; 4] = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"wall\"", "\"wall\""];

/// A free disc of s = 2.65 that falls.
fn disc(sides: [&str; 4], coupling: &str) -> String {
    let particle = "[[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [0.55, 0.5]\n\
        density = 2.65\n";
    box_case([1.0, 1.0], [32, 32], 0.01, sides, &format!("{particle}{coupling}"))
        .replace("density = 1.0\n", "density = 1.0\ngravity = [0.0, -1.0]\n")
}

#[test]
fn exported_system_of_disc_in_closed_box_is_singular_with_its_two_motions() {
    let folder = tempfile::tempdir().unwrap();
    let first = exported(folder.path(), &disc(CLOSED, SHARP), &["--step", "2"]);
    assert_eq!(weights(&first).len(), 2, "{first}");
    assert!(first["singular"] == true && first["nonzeros"]["A"].as_u64() > Some(5 * 32 * 32));
    assert!(first["run"]["outcome"]["iterations"].as_u64() > Some(0));
    // A time of the step names it as well.
    let middle = first["time"].as_f64().unwrap() - 0.5 * first["dt"].as_f64().unwrap();
    let same = exported(folder.path(), &disc(CLOSED, SHARP), &["--at", &middle.to_string()]);
    assert_eq!(same, first);
}

#[test]
fn exported_system_with_outflow_is_regular_and_mixture_has_no_factors() {
    let folder = tempfile::tempdir().unwrap();
    let stream = exported(folder.path(), &disc(STREAM, SHARP), &["--step", "2"]);
    assert!(stream["singular"] == false && weights(&stream).len() == 2);
    let words = ["--step", "2", "--most-nonzeros", "1"];
    let mixture = exported(folder.path(), &disc(CLOSED, MIXING), &words);
    assert!(mixture["singular"] == true && weights(&mixture).is_empty());
    assert_eq!(mixture["nonzeros"]["A"], mixture["nonzeros"]["A_fluid"]);
}

#[test]
fn exported_system_of_sphere_and_of_held_mean_velocity_in_periodic_box() {
    let folder = tempfile::tempdir().unwrap();
    let case = "name = \"test\"\n[domain]\nsize = [1.0, 1.0, 1.0]\ncells = [12, 12, 12]\n[fluid]\n\
        density = 1.0\nviscosity = 0.01\ngravity = [0.0, 0.0, -1.0]\n[boundary]\n\
        west = \"periodic\"\neast = \"periodic\"\nsouth = \"wall\"\nnorth = \"wall\"\n\
        bottom = \"wall\"\ntop = \"wall\"\n[drive]\nmean_velocity = { axis = \"x\", value = 0.1 }\n\
        [[particle]]\nshape = { sphere = { diameter = 0.5 } }\nposition = [0.45, 0.5, 0.5]\n\
        density = 2.65\n[time]\nend = 0.1\n";
    let whole = weights(&exported(folder.path(), case, &["--step", "1"]));
    assert_eq!(whole.len(), 4);
    assert!(whole[..3].iter().all(|w| *w > 0.0) && whole[3] < 0.0, "{whole:?}");
    // By its parts alone, where the whole would be too large.
    let parts = exported(folder.path(), case, &["--step", "1", "--most-nonzeros", "1000"]);
    assert!(parts["nonzeros"]["A"].is_null() && weights(&parts) == whole);
}

#[test]
fn exported_system_says_what_the_runs_own_solver_takes_or_why_it_fails() {
    let folder = tempfile::tempdir().unwrap();
    let case = disc(CLOSED, SHARP);
    let with = |options: &[&str]| {
        let words = ["--step", "1", "--", "-ksp_type", "cg", "-pc_type", "icc"];
        exported(folder.path(), &case, &[&words[..], options].concat())["run"].clone()
    };
    let run = with(&["-ksp_rtol", "1e-10"]);
    assert!((20..200).contains(&run["outcome"]["iterations"].as_u64().unwrap()), "{run}");
    assert_eq!((run["rtol"].as_f64(), run["atol"].as_f64()), (Some(1e-10), Some(0.0)));
    let run = with(&["-ksp_max_it", "3"]);
    assert!(run["outcome"]["failure"].as_str().unwrap().contains("DIVERGED_ITS"), "{run}");
}

#[test]
fn bad_export_system_is_refused_and_nothing_written() {
    let folder = tempfile::tempdir().unwrap();
    let (case, out) = (write(folder.path(), &disc(CLOSED, SHARP)), folder.path().join("out"));
    // Nothing moves the fluid, and the disc is as heavy.
    let still = disc(CLOSED, SHARP).replace("density = 2.65", "density = 1.0");
    let still_case = folder.path().join("still.toml");
    fs::write(&still_case, still).unwrap();
    let row = |case: &Path, words: &[&str], says: &[&str]| {
        let first = ["export-system", case.to_str().unwrap(), "--out", out.to_str().unwrap()];
        let output = mics(&[&first[..], words].concat());
        (words.join(" "), shortcomings(&output, &out, says))
    };
    let short = ["--set", "time.end=0.01"];
    expect_none([
        row(&case, &[], &["--at <T>", "--step <N>"]),
        row(&case, &["--at", "1", "--step", "1"], &["cannot be used with"]),
        row(&case, &["--step", "0"], &["--step <N>", "not in 1.."]),
        row(&case, &["--at", "0"], &["no time after the start"]),
        row(&case, &["--at", "-1"], &["no time after the start"]),
        row(&case, &["--step", "1", "--solve", "0"], &["--solve <K>", "not in 1.."]),
        row(&case, &["--step", "1", "--solve", "99"], &["step 1", "no --solve 99"]),
        row(&case, &["--at", "1.5"], &["after the end of the run", "time.end=1.5"]),
        row(&case, &[&short[..], &["--step", "900"]].concat(), &["the run ends with step", "0.01"]),
        row(&still_case, &["--step", "1"], &["step 1", "solves for the pressure 0 times"]),
        row(&case, &["--step", "1", "--set", "fluid.viscosity=-1"], &["fluid.viscosity"]),
        row(&case, &["--step", "1", "--", "-pc_type", "eisenstat"], &["as a matrix"]),
    ]);
    let ranks = mpirun(2, env!("CARGO_BIN_EXE_mics"))
        .arg("export-system")
        .arg(&case)
        .args(["--step", "1", "--out"])
        .arg(&out)
        .output()
        .unwrap();
    expect_none([("2 ranks".to_owned(), shortcomings(&ranks, &out, &["without mpirun"]))]);
}

#[test]
fn folder_that_holds_no_system_is_left_alone_and_one_that_does_replaced_by_force() {
    let folder = tempfile::tempdir().unwrap();
    let (case, out) = (write(folder.path(), &disc(CLOSED, SHARP)), folder.path().join("out"));
    let words = ["export-system", case.to_str().unwrap(), "--step", "1", "--quiet", "--out"];
    let export = |out: &Path, more: &[&str]| {
        let output = mics(&[&words[..], &[out.to_str().unwrap()], more].concat());
        (output.status.code(), text(&output.stderr))
    };
    assert_eq!(export(&out, &[]), (Some(0), String::new()));
    let (code, said) = export(&out, &[]);
    assert!(code == Some(2) && said.contains("--force"), "{said}");
    assert_eq!(export(&out, &["--force"]).0, Some(0));
    // Other files there stay.
    fs::write(out.join("notes.txt"), "mine").unwrap();
    assert_eq!(export(&out, &["--force"]).0, Some(0));
    assert_eq!(fs::read_to_string(out.join("notes.txt")).unwrap(), "mine");
    // A README of somebody else's.
    let other = folder.path().join("other");
    fs::create_dir(&other).unwrap();
    fs::write(other.join("README.md"), "mine").unwrap();
    let (code, said) = export(&other, &["--force"]);
    assert!(code == Some(2) && said.contains("no system.json"), "{said}");
    assert_eq!(fs::read_to_string(other.join("README.md")).unwrap(), "mine");
}
