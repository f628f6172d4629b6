//! PETSc's options: those that work, those that are refused, and those that nothing uses.

use crate::program::{DISC, text, write};
use crate::support::{STREAM, box_case, mics, mics_command, run};

#[test]
fn petsc_options_that_end_the_program_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let case = write(dir.path(), &box_case([2.0, 1.0], [32, 16], 0.01, STREAM, DISC));
    let out = dir.path().join("out");
    let refused = |options: &[&str], words: &str| {
        let run = ["run", case.to_str().unwrap(), "--quiet", "--out", out.to_str().unwrap(), "--"];
        // PETSc opens its files before it is refused.
        let output =
            mics_command().args(run).args(options).current_dir(dir.path()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
    };
    refused(&["-ksp_monitor", "hdf5:residuals.h5"], "give ascii:FILE");
    refused(&["-ksp_view_mat", "binary:A"], "there is no matrix to write");
    refused(&["-ksp_view_pmat", "binary:A"], "there is no matrix to write");
}

#[test]
fn gamg_preconditioned_cg_with_free_bodies_in_closed_box() {
    let dir = tempfile::tempdir().unwrap();
    let grains = "[[swarm]]\nname = \"grain\"\ncount = 6\n\
        region = { min = [0.005, 0.015], max = [0.075, 0.035] }\n\
                  diameter = 0.006\ndensity = 2650.0\n[contact]\n[time]\nend = 0.02\n[output]\n\
                  figures = false\n\
                  [petsc]\noptions = \"\"\"\n# of one sign\n\
                      -ksp_type cg -pc_type gamg # smoothed\n\"\"\"\n";
    let closed = ["\"wall\""; 4];
    let text = box_case([0.08, 0.04], [128, 64], 0.005, closed, grains)
        .replace("density = 1.0\n", "density = 1000.0\ngravity = [0.0, -9.81]\n");
    let case = write(dir.path(), &text);
    assert_eq!(run(&case, &dir.path().join("out"), &[])["status"], "done");
}

#[test]
fn petsc_options_are_used_and_unused_ones_named() {
    let dir = tempfile::tempdir().unwrap();
    let case = write(
        dir.path(),
        &box_case(
            [2.0, 1.0],
            [32, 16],
            0.01,
            STREAM,
            &format!("{DISC}\n[petsc]\noptions = \"-ksp_type gmres\""),
        ),
    );
    let go = |name: &str, options: &[&str]| {
        let out = dir.path().join(name);
        let words = [
            "run",
            case.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
            "--set",
            "time.end=0.1",
            "--",
        ];
        let output = mics(&[&words[..], options].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        // Options that nothing knows are named after the first solve, on stderr; those that are
        // used at the end alone are not.
        assert_eq!(
            text(&output.stderr).contains("warning: PETSc option"),
            name == "b",
            "{}",
            text(&output.stderr)
        );
        text(&output.stdout)
    };
    assert!(go("a", &[]).contains("gmres + boxmg (PETSc's options)"));
    let said = go("b", &["-ksp_type", "cg", "-pc_type", "gamg", "-ksp_monitor", "-nonsense", "3"]);
    assert!(said.contains("cg + gamg") && said.contains("KSP Residual norm"), "{said}");
    assert!(said.contains("nothing used: -nonsense 3"), "{said}");
    let inner = [
        "-ksp_type",
        "cg",
        "-pc_type",
        "gamg",
        "-mg_levels_ksp_max_it",
        "3",
        "-ksp_converged_reason",
    ];
    assert!(!go("i", &inner).contains("nothing used"));
    assert!(go("c", &["-log_view"]).contains("KSPSolve"));
    assert!(go("d", &["-ksp_view"]).contains("boxmg"));
    assert!(go("e", &["-ksp_view", "-pc_type", "hypre"]).contains("BoomerAMG"));
    // A method that knows no norm of the true residual.
    let mild = [
        "--set",
        "time.end=0.1",
        "--set",
        "pressure.divergence_limit=1e-4",
        "--",
        "-ksp_type",
        "minres",
    ];
    assert_eq!(run(&case, &dir.path().join("g"), &mild)["status"], "done");
    // Our own options are read like PETSc's.
    let said = go("f", &["-pc_boxmg_smooth", "2", "-pc_boxmg_cycle", "w", "-pc_boxmg_levels", "2"]);
    assert!(!said.contains("nothing used"), "{said}");
}

#[test]
fn given_ksp_rtol_overrides_d0() {
    let dir = tempfile::tempdir().unwrap();
    let text = box_case(
        [2.0, 1.0],
        [32, 16],
        0.01,
        STREAM,
        &format!("{DISC}\n[pressure]\ndivergence_limit = 0.01"),
    );
    let case = write(dir.path(), &text);
    let divergence = |name: &str, options: &[&str]| {
        let words = [&["--set", "time.end=0.1", "--set", "output.figures=false"], options].concat();
        run(&case, &dir.path().join(name), &words)["divergence_max"].as_f64().unwrap()
    };
    let [chosen, fixed] =
        [divergence("chosen", &[]), divergence("fixed", &["--", "-ksp_rtol", "1e-9"])];
    assert!(chosen > 1e-5 && fixed < 1e-6, "{chosen:e} {fixed:e}");
}

#[test]
fn failed_pressure_solve_is_retried_once_and_explained() {
    let dir = tempfile::tempdir().unwrap();
    let case = write(dir.path(), &box_case([2.0, 1.0], [64, 32], 0.01, STREAM, DISC));
    let fails = |options: &[&str]| {
        let out = dir.path().join("run");
        let words = ["run", case.to_str().unwrap(), "--out", out.to_str().unwrap(), "--"];
        let output = mics(&[&words[..], options].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{said}");
        said
    };
    let said = fails(&["-ksp_type", "cg", "-pc_type", "jacobi", "-ksp_max_it", "3"]);
    assert!(
        said.contains("failed twice: DIVERGED_ITS after 3 iterations") && said.contains("rebuilt"),
        "{said}"
    );
    // Our own preconditioners would do the same again.
    let said = fails(&["-ksp_max_it", "1"]);
    assert!(
        said.contains("failed: DIVERGED_ITS after 1 iterations") && said.contains("bcgs-boomeramg"),
        "{said}"
    );
    assert!(!said.contains("rebuilt"), "{said}");
}

#[test]
fn petsc_options_in_capitals() {
    let dir = tempfile::tempdir().unwrap();
    let case = write(dir.path(), &box_case([2.0, 1.0], [32, 16], 0.01, STREAM, DISC));
    let out = dir.path().join("out");
    let start = |options: &[&str]| {
        let run = ["run", case.to_str().unwrap(), "--force", "--out", out.to_str().unwrap(), "--"];
        mics(&[&run[..], options].concat())
    };
    let output = start(&["-PC_type", "jacobi"]);
    assert!(
        text(&output.stdout).contains("cg + jacobi (PETSc's options)"),
        "{}",
        text(&output.stdout)
    );
    let output = start(&["-pc_type", "JACOBI"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output.stderr).contains("types are in lower case: jacobi"),
        "{}",
        text(&output.stderr)
    );
}
