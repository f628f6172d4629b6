//! `mics export-system`: what it writes, read back by readers of this file's own, is the system
//! that it says it is. (SciPy's and PETSc's own readers: `ci/read-system`.)

use crate::bad_input::{expect_none, shortcomings};
use crate::program::{text, write};
use crate::support::{MIXING, SHARP, box_case, mics, mpirun};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Entries of a matrix by row and column.
type Entries = BTreeMap<(usize, usize), f64>;

/// A matrix of a MatrixMarket file, an array of one column too.
fn market(path: &Path) -> (usize, Entries) {
    let text = fs::read_to_string(path).unwrap();
    let head = text.lines().next().unwrap();
    let (symmetric, array) = (head.ends_with("symmetric"), head.contains(" array "));
    let mut lines = text.lines().filter(|line| !line.starts_with('%'));
    let size: Vec<usize> =
        lines.next().unwrap().split(' ').map(|word| word.parse().unwrap()).collect();
    let mut entries = Entries::new();
    let mut count = 0;
    for line in lines {
        let words: Vec<f64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        let (row, column, value) = match array {
            true => (count, 0, words[0]),
            false => (words[0] as usize - 1, words[1] as usize - 1, words[2]),
        };
        entries.insert((row, column), value);
        if symmetric {
            assert!(column <= row, "the upper part of {path:?}");
            entries.insert((column, row), value);
        }
        count += 1;
    }
    assert_eq!(count, *size.get(2).unwrap_or(&size[0]), "{path:?}");
    (size[0], entries)
}

/// A matrix or vector of a file of PETSc's.
fn petsc(path: &Path) -> (usize, Entries) {
    let bytes = fs::read(path).unwrap();
    let integer = |k: usize| i32::from_be_bytes(bytes[4 * k..][..4].try_into().unwrap()) as usize;
    let doubles =
        |at: usize| bytes[at..].chunks(8).map(|d| f64::from_be_bytes(d.try_into().unwrap()));
    if integer(0) == 1_211_214 {
        let values = doubles(8).enumerate().map(|(row, value)| ((row, 0), value));
        return (integer(1), values.collect());
    }
    assert_eq!(integer(0), 1_211_216);
    let (rows, count) = (integer(1), integer(3));
    let row_of = (0..rows).flat_map(|row| std::iter::repeat_n(row, integer(4 + row)));
    let columns = (0..count).map(|k| integer(4 + rows + k));
    (rows, row_of.zip(columns).zip(doubles(4 * (4 + rows + count))).collect())
}

/// A matrix or vector, which both files have alike; `None` where there is neither.
fn read(folder: &Path, name: &str) -> Option<(usize, Entries)> {
    let [text, binary] = ["mtx", "petsc"].map(|ending| folder.join(format!("{name}.{ending}")));
    assert_eq!(text.exists(), binary.exists(), "{name}");
    text.exists().then(|| {
        let both = (market(&text), petsc(&binary));
        assert_eq!(both.0, both.1, "{name}");
        both.0
    })
}

fn vector(folder: &Path, name: &str) -> Option<Vec<f64>> {
    read(folder, name).map(|(_, entries)| entries.into_values().collect())
}

fn product(matrix: &Entries, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; x.len()];
    matrix.iter().for_each(|((row, column), value)| y[*row] += value * x[*column]);
    y
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// A system that was read back.
struct Read {
    json: serde_json::Value,
    fluid: Entries,
    /// As a whole, where it was written so.
    whole: Option<Entries>,
    /// The columns of J and their weights.
    factors: Vec<(Vec<(usize, f64)>, f64)>,
    b: Vec<f64>,
    x: Vec<f64>,
    null: Option<Vec<f64>>,
}

impl Read {
    fn from(folder: &Path) -> Read {
        let weights = vector(folder, "w").unwrap_or_default();
        let mut factors: Vec<_> = weights.into_iter().map(|w| (Vec::new(), w)).collect();
        for ((row, column), value) in read(folder, "J").map(|j| j.1).unwrap_or_default() {
            factors[column].0.push((row, value));
        }
        let json = fs::read_to_string(folder.join("system.json")).unwrap();
        Read {
            json: serde_json::from_str(&json).unwrap(),
            fluid: read(folder, "A_fluid").unwrap().1,
            whole: read(folder, "A").map(|(_, entries)| entries),
            factors,
            b: vector(folder, "b").unwrap(),
            x: vector(folder, "x").unwrap(),
            null: vector(folder, "null"),
        }
    }

    /// A by its factors.
    fn sum(&self) -> Entries {
        let mut sum = self.fluid.clone();
        for (column, weight) in &self.factors {
            for (row, a) in column {
                column.iter().for_each(|(other, b)| {
                    *sum.entry((*row, *other)).or_default() += weight * (a * b)
                });
            }
        }
        sum
    }

    /// That it is what it says; returns A.
    fn check(&self) -> Entries {
        let sum = self.sum();
        let largest = sum.values().fold(0.0f64, |most, a| most.max(a.abs()));
        if let Some(whole) = &self.whole {
            assert_eq!(whole.keys().collect::<Vec<_>>(), sum.keys().collect::<Vec<_>>());
            let apart = whole.iter().zip(&sum).map(|((_, a), (_, b))| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) < 1e-15 * largest);
        }
        let whole = self.whole.clone().unwrap_or(sum);
        for ((row, column), value) in &whole {
            assert_eq!(whole[&(*column, *row)], *value, "A is symmetric");
        }
        let n = self.b.len();
        assert_eq!(self.json["unknowns"], n);
        let residual: Vec<f64> =
            product(&whole, &self.x).iter().zip(&self.b).map(|(a, b)| a - b).collect();
        assert!(norm(&residual) < 1e-12 * norm(&self.b), "{}", norm(&residual) / norm(&self.b));
        assert_eq!(self.json["singular"], self.null.is_some());
        if let Some(null) = &self.null {
            assert!((norm(null) - 1.0).abs() < 1e-13);
            assert!(norm(&product(&whole, null)) < 1e-14 * largest * (n as f64).sqrt());
            assert!(self.x.iter().sum::<f64>().abs() < 1e-12 * norm(&self.x) * (n as f64).sqrt());
            assert!(self.b.iter().sum::<f64>().abs() < 1e-12 * norm(&self.b) * (n as f64).sqrt());
        }
        whole
    }
}

/// Exports, which must succeed, and reads back.
fn exported(folder: &Path, case: &str, more: &[&str]) -> Read {
    let (case, out) = (write(folder, case), folder.join("system"));
    let words =
        ["export-system", case.to_str().unwrap(), "--force", "--out", out.to_str().unwrap()];
    let output = mics(&[&words[..], more].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    Read::from(&out)
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
    let read = exported(folder.path(), &disc(CLOSED, SHARP), &["--step", "2"]);
    let whole = read.check();
    assert_eq!(read.factors.len(), 2, "{}", read.json);
    assert!(read.null.is_some() && read.json["run"]["outcome"]["iterations"].as_u64() > Some(0));
    assert!(whole.len() > read.fluid.len());
    // A row of open fluid is the Laplacian's: 1/(rho h^2) for each of its faces, and no shift.
    assert_eq!(read.fluid[&(33, 33)], 4.0 * 32.0 * 32.0);
    assert_eq!(read.fluid[&(33, 34)], -32.0 * 32.0);
    assert_eq!(read.fluid[&(0, 0)], 2.0 * 32.0 * 32.0);
    // A time of the step names it as well.
    let dt = read.json["dt"].as_f64().unwrap();
    let at = (read.json["time"].as_f64().unwrap() - 0.5 * dt).to_string();
    let same = exported(folder.path(), &disc(CLOSED, SHARP), &["--at", &at]);
    assert_eq!((&same.json["step"], &same.x), (&read.json["step"], &read.x));
}

#[test]
fn exported_system_with_outflow_is_regular_and_mixture_has_no_factors() {
    let folder = tempfile::tempdir().unwrap();
    let read = exported(folder.path(), &disc(STREAM, SHARP), &["--step", "2"]);
    read.check();
    assert!(read.null.is_none() && read.factors.len() == 2);
    let words = ["--step", "2", "--most-nonzeros", "1"];
    let read = exported(folder.path(), &disc(CLOSED, MIXING), &words);
    read.check();
    assert!(read.null.is_some() && read.factors.is_empty());
    assert_eq!(read.whole.as_ref(), Some(&read.fluid));
    // The mixture within the disc is heavier.
    let least = read.fluid.iter().filter(|((r, c), _)| r == c).map(|(_, a)| *a);
    assert!((least.fold(f64::INFINITY, f64::min) - 4.0 * 1024.0 / 2.65).abs() < 1e-9);
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
    let read = exported(folder.path(), case, &["--step", "1"]);
    read.check();
    let weights: Vec<f64> = read.factors.iter().map(|factor| factor.1).collect();
    assert_eq!(weights.len(), 4);
    assert!(weights[..3].iter().all(|w| *w > 0.0) && weights[3] < 0.0, "{weights:?}");
    // By its parts alone, where the whole would be too large.
    let parts = exported(folder.path(), case, &["--step", "1", "--most-nonzeros", "1000"]);
    parts.check();
    assert!(parts.whole.is_none() && parts.json["nonzeros"]["A"].is_null());
    assert_eq!((parts.x, parts.fluid), (read.x, read.fluid));
}

#[test]
fn exported_system_says_what_the_runs_own_solver_takes_or_why_it_fails() {
    let folder = tempfile::tempdir().unwrap();
    let case = disc(CLOSED, SHARP);
    let with = |options: &[&str]| {
        let words = ["--step", "1", "--", "-ksp_type", "cg", "-pc_type", "icc"];
        exported(folder.path(), &case, &[&words[..], options].concat()).json["run"].clone()
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
        row(&case, &["--step", "0"], &["--step 1"]),
        row(&case, &["--at", "0"], &["no time after the start"]),
        row(&case, &["--at", "-1"], &["no time after the start"]),
        row(&case, &["--step", "1", "--solve", "0"], &["--solve 1"]),
        row(&case, &["--step", "1", "--solve", "99"], &["step 1", "no --solve 99"]),
        row(&case, &["--at", "1.5"], &["after the end of the run", "time.end=1.5"]),
        row(&case, &[&short[..], &["--step", "900"]].concat(), &["the run ends with step", "0.01"]),
        row(&still_case, &["--step", "1"], &["nothing is solved in step 1"]),
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
    fs::write(out.join("notes.txt"), "mine").unwrap();
    let (code, said) = export(&out, &["--force"]);
    assert!(code == Some(2) && said.contains("notes.txt"), "{said}");
    // A README of somebody else's.
    let other = folder.path().join("other");
    fs::create_dir(&other).unwrap();
    fs::write(other.join("README.md"), "mine").unwrap();
    let (code, said) = export(&other, &["--force"]);
    assert!(code == Some(2) && said.contains("no system.json"), "{said}");
    assert_eq!(fs::read_to_string(other.join("README.md")).unwrap(), "mine");
}
