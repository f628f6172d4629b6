//! Histories of the pressure solves, `solves.csv`: they agree with `steps.csv`, change nothing, go
//! on after a restart, and are drawn.

use crate::allocation::count;
use crate::estimates::says;
use crate::plots::plotted;
use crate::program::write;
use crate::restart::{checkpoints, colliding};
use crate::support::{box_case, columns, mics, petsc, run, run_on_ranks};
use mics::scene::Scene;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

/// Six free discs in a closed box, for ten steps.
fn six(dir: &Path, more: &str) -> PathBuf {
    let grains = format!(
        "[[swarm]]\nname = \"grain\"\ncount = 6\n\
        region = {{ min = [0.005, 0.015], max = [0.075, 0.035] }}\n\
        diameter = 0.006\ndensity = 2650.0\n[contact]\n[time]\nend = 0.001\nstep = 1.0e-4\n\
        [output]\nfigures = false\n{more}"
    );
    let scene = box_case([0.08, 0.04], [64, 32], 0.005, ["\"wall\""; 4], &grains)
        .replace("density = 1.0\n", "density = 1000.0\ngravity = [0.0, -9.81]\n");
    write(dir, &scene)
}

const HISTORY: &str = "[pressure]\nhistory = true\n";

/// A solve of `solves.csv`: the rows of it.
type Solve = Vec<HashMap<String, f64>>;

/// The solves of each step, by C-HSMAC iteration and attempt.
fn solves(out: &Path) -> BTreeMap<u64, BTreeMap<(u64, u64), Solve>> {
    let all = columns(&out.join("solves.csv"));
    let mut steps: BTreeMap<u64, BTreeMap<(u64, u64), Solve>> = BTreeMap::new();
    for k in 0..all["step"].len() {
        let row: HashMap<String, f64> =
            all.iter().map(|(name, column)| (name.clone(), column[k])).collect();
        let [step, outer, attempt] =
            ["step", "outer_iteration", "attempt"].map(|name| row[name] as u64);
        steps.entry(step).or_default().entry((outer, attempt)).or_default().push(row);
    }
    steps
}

/// Every step's solves have the iterations, the divergence and the tolerances that the run went by.
fn expect_agreement(out: &Path, limit: f64) {
    let (steps, solves) = (columns(&out.join("steps.csv")), solves(out));
    assert_eq!(solves.len(), steps["step"].len() - 1, "a history of each step");
    for k in 1..steps["step"].len() {
        let all = &solves[&(steps["step"][k] as u64)];
        let last = |solve: &Solve| solve.last().unwrap()["krylov_iteration"];
        assert_eq!(all.values().map(last).sum::<f64>(), steps["krylov_iterations"][k], "step {k}");
        assert_eq!(all.keys().map(|key| key.0).max().unwrap() as f64, steps["outer_iterations"][k]);
        let mut after = f64::NAN;
        for solve in all.values() {
            let (first, last) = (&solve[0], solve.last().unwrap());
            assert_eq!([first["krylov_iteration"], first["relative_residual"]], [0.0, 1.0]);
            assert_eq!(last["time"], steps["time"][k]);
            // The next iteration begins with what this one left.
            assert!(
                first["projection"] > 1.0
                    || after.is_nan()
                    || first["attempt"] > 1.0
                    || first["divergence_before"] == after
            );
            after = last["divergence_after"];
            assert!(
                last["tolerance"].is_nan() || last["residual"] <= last["tolerance"],
                "step {k}: {last:?}"
            );
        }
        assert_eq!(after, steps["divergence_max"][k]);
        assert!(after < limit);
    }
}

/// `steps.csv` without the time that steps took.
fn steps_without_wall(out: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(out.join("steps.csv")).unwrap();
    let without = |line: &str| {
        let cells = line.split(',').enumerate().filter(|(k, _)| *k != 8).map(|(_, cell)| cell);
        cells.collect::<Vec<_>>().join(",")
    };
    text.lines().map(without).collect()
}

#[test]
fn solve_history_agrees_with_steps_and_changes_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let case = six(dir.path(), "[pressure]\nsolver = \"auto\"\n");
    let sets: [(&str, &str, &[&str]); 6] = [
        ("boxmg", "pressure.solver=\"auto\"", &[]),
        ("boomeramg", "pressure.solver=\"bcgs-boomeramg\"", &[]),
        ("gamg", "time.cfl=0.1", &["--", "-ksp_type", "gmres", "-pc_type", "gamg"]),
        // Another norm, residuals of other than whole iterations, and a guess that is not zero.
        ("minres", "time.cfl=0.1", &["--", "-ksp_type", "minres"]),
        ("tfqmr", "time.cfl=0.1", &["--", "-ksp_type", "tfqmr", "-pc_type", "gamg"]),
        ("rtol", "time.cfl=0.1", &["--", "-ksp_rtol", "1e-3"]),
    ];
    for (name, set, options) in sets {
        let [with, without] = ["with", "without"].map(|which| {
            let out = dir.path().join(format!("{name}-{which}"));
            let history = format!("pressure.history={}", which == "with");
            run(&case, &out, &[&["--set", set, "--set", &history], options].concat());
            out
        });
        assert!(!without.join("solves.csv").exists());
        assert!(steps_without_wall(&with) == steps_without_wall(&without), "{name}");
        expect_agreement(&with, 1e-6);
    }
}

/// PETSc tests no residual of a factorization; the true one stands before and after it.
#[test]
fn solve_history_of_factorization_has_true_residuals() {
    let dir = tempfile::tempdir().unwrap();
    let more = "[initial]\nvelocity = [1.0, 0.2]\nperturbation = 0.1\n[time]\nend = 0.1\n\
        step = 0.01\n[output]\nfigures = false\n[pressure]\nhistory = { every = 5 }\n";
    let sides = ["\"slip\"", "\"outflow\"", "\"wall\"", "\"wall\""];
    let case = write(dir.path(), &box_case([2.0, 1.0], [32, 16], 0.01, sides, more));
    let out = dir.path().join("out");
    run(&case, &out, &["--", "-ksp_type", "preonly", "-pc_type", "cholesky"]);
    let solves = solves(&out);
    assert_eq!(solves.keys().copied().collect::<Vec<_>>(), [5, 10]);
    for step in solves.values() {
        let [first, last] = &step[&(1, 1)][..] else { panic!("two rows") };
        assert_eq!(first["relative_residual"], 1.0);
        assert!(last["relative_residual"] > 0.0 && last["relative_residual"] < 1e-12);
        assert!(last["krylov_iteration"] == 1.0 && last["tolerance"].is_nan());
    }
}

#[test]
fn failed_solve_has_history_of_both_attempts() {
    let dir = tempfile::tempdir().unwrap();
    let (case, out) = (six(dir.path(), HISTORY), dir.path().join("out"));
    let words = ["run", case.to_str().unwrap(), "--quiet", "--out", out.to_str().unwrap(), "--"];
    let options = ["-ksp_type", "cg", "-pc_type", "jacobi", "-ksp_max_it", "7"];
    assert_eq!(mics(&[&words[..], &options].concat()).status.code(), Some(3));
    let solves = solves(&out);
    assert_eq!(solves[&1].keys().copied().collect::<Vec<_>>(), [(1, 1), (1, 2)]);
    for solve in solves[&1].values() {
        let numbers: Vec<f64> = solve.iter().map(|row| row["krylov_iteration"]).collect();
        assert_eq!(numbers, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        assert!(solve[7]["residual"] > solve[7]["tolerance"]);
        assert!(solve[7]["divergence_after"].is_nan());
    }
}

#[test]
fn solve_history_goes_on_after_restart_bit_for_bit() {
    let dir = tempfile::tempdir().unwrap();
    let case = colliding(dir.path(), "end = 0.25\nstep = 0.006\n[pressure]\nhistory = true", 7);
    let out = dir.path().join("out");
    run(&case, &out, &[]);
    expect_agreement(&out, 1e-6);
    let read = || std::fs::read_to_string(out.join("solves.csv")).unwrap();
    let straight = read();
    // Collisions take several projections of a step.
    assert!(columns(&out.join("solves.csv"))["projection"].iter().any(|number| *number > 1.0));
    let newest = checkpoints(&out).pop().unwrap();
    std::fs::remove_file(newest).unwrap();
    std::fs::write(out.join("solves.csv"), straight.clone() + "a row of a step to be repeated\n")
        .unwrap();
    run(&case, &out, &["--resume"]);
    assert!(read() == straight, "the file is cut back and goes on");
    // A run that goes on may keep its history or not; what there was stays.
    run(&case, &out, &["--resume", "--set", "time.end=0.4", "--set", "pressure.history=false"]);
    assert!(read() == straight);
    run(&case, &out, &["--resume", "--set", "time.end=0.5"]);
    let all = read();
    assert!(all.starts_with(&straight) && all.lines().last().unwrap().starts_with("84,"), "{all}");
}

#[test]
fn solve_history_on_two_ranks() {
    let dir = tempfile::tempdir().unwrap();
    let case = six(dir.path(), HISTORY);
    let out = dir.path().join("out");
    run_on_ranks(2, &case, &out);
    expect_agreement(&out, 1e-6);
}

#[test]
fn convergence_is_drawn_and_reported_where_there_is_a_history() {
    let dir = tempfile::tempdir().unwrap();
    let case = six(dir.path(), HISTORY);
    let [out, without] = ["out", "without"].map(|name| dir.path().join(name));
    run(&case, &out, &["--set", "output.figures=true"]);
    let drawn =
        |name: &str| ["png", "svg"].map(|end| out.join("figures").join(format!("{name}.{end}")));
    for file in [drawn("convergence"), drawn("convergence_steps")].concat() {
        assert!(std::fs::metadata(&file).unwrap().len() > 2000, "{}", file.display());
    }
    let folder = out.to_str().unwrap();
    let files = plotted(&[folder, "--figure", "convergence", "--times", "0.0004"]);
    let svg = std::fs::read_to_string(&files[1]).unwrap();
    for said in [
        "test: pressure solves of step 4, t = 0.0004 s",
        ">\nC-HSMAC iteration 1\n<",
        ">\nresidual (1/s2), 2-norm\n<",
        ">\nlargest |D| (1/s)\n<",
    ] {
        assert!(svg.contains(said), "{said}");
    }
    let (code, said) = says(&["plot", folder, "--figure", "convergence", "--times", "7"]);
    assert!(code == Some(2) && said.contains("to 0.001 s; give a time in there"), "{said}");
    assert!(mics(&["report", folder]).status.success());
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(report.contains("<h3>Convergence</h3>") && report.contains("of step 10, t = 0.001 s"));

    run(&case, &without, &["--set", "pressure.history=false"]);
    let folder = without.to_str().unwrap();
    let (code, said) = says(&["plot", folder, "--figure", "convergence"]);
    assert!(code == Some(2) && said.contains("run it with --set pressure.history=true"), "{said}");
    assert_eq!(plotted(&[folder, "--figure", "convergence-steps"]).len(), 2);
}

#[test]
fn check_says_how_large_solve_history_gets() {
    let dir = tempfile::tempdir().unwrap();
    let case = six(dir.path(), "");
    let check = |history: &str| {
        let set = format!("pressure.history={history}");
        says(&["check", case.to_str().unwrap(), "--set", &set])
    };
    let (_, said) = check("true");
    assert!(said.contains("; solves.csv every step, "), "{said}");
    let (_, said) = check("{ every = 5 }");
    assert!(said.contains("; solves.csv every 5 steps, "), "{said}");
    assert!(!check("false").1.contains("solves.csv"));
    let (code, said) = check("{ every = 0 }");
    assert!(code == Some(2) && said.contains("pressure.history.every"), "{said}");
    let (code, said) = check("3");
    assert!(code == Some(2) && said.contains("true, false or as often as in"), "{said}");
}

#[test]
fn recorded_step_allocates_nothing() {
    let petsc = petsc();
    let dir = tempfile::tempdir().unwrap();
    let scene = std::fs::read_to_string(six(dir.path(), "")).unwrap();
    let mut scene: Scene<2> = petsc.scene(&scene);
    let step = |scene: &mut Scene<2>| {
        scene.domain.projection.record(true);
        scene.step(1e-4).unwrap();
        scene.domain.projection.solves().count()
    };
    // The first steps need the most iterations.
    let most = (0..3).map(|_| step(&mut scene)).max().unwrap();
    let before = count();
    for _ in 0..5 {
        assert!(step(&mut scene) <= most);
    }
    assert_eq!(count() - before, 0);
}
