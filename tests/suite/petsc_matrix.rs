//! The assembled matrix: what PETSc writes of it, how often preconditioners are built from it, and
//! the stages of PETSc's log.

use crate::program::{DISC, text, write};
use crate::support::{MIXING, STREAM, box_case, mics_command, run};
use std::path::Path;

/// Runs a case in `dir`, which must succeed, and returns what it printed.
fn printed(dir: &Path, case: &Path, options: &[&str]) -> String {
    let mut command = mics_command();
    command.current_dir(dir).args(["run", "--force", "--out", "out"]).arg(case);
    let output = command.arg("--").args(options).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout).to_owned()
}

/// Rows and nonzeros of the first matrix that PETSc wrote to a file, or rows of the first vector,
/// from the header in big-endian integers.
fn header(file: &Path) -> [i32; 4] {
    let bytes = std::fs::read(file).unwrap();
    let number = |k: usize| i32::from_be_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap());
    std::array::from_fn(number)
}

#[test]
fn matrix_without_free_bodies_is_written_as_operator() {
    let dir = tempfile::tempdir().unwrap();
    let scene =
        box_case([2.0, 1.0], [32, 16], 0.01, STREAM, &format!("{DISC}\n[time]\nend = 0.02"));
    let case = write(dir.path(), &scene);
    let chosen = ["-ksp_type", "cg", "-pc_type", "icc"];
    let views = ["-ksp_view_mat", "binary:A", "-ksp_view_rhs", "binary:b"];
    printed(dir.path(), &case, &[chosen, views].concat());
    let [class, rows, columns, nonzeros] = header(&dir.path().join("A"));
    // Five entries a row, less one for each face at a side.
    assert_eq!((class, rows, columns, nonzeros), (1211216, 512, 512, 5 * 512 - 2 * (32 + 16)));
    let [class, rows, ..] = header(&dir.path().join("b"));
    assert_eq!((class, rows), (1211214, 512));
}

#[test]
fn preconditioner_serves_as_many_matrices_as_asked() {
    let dir = tempfile::tempdir().unwrap();
    let disc = "[[particle]]\nshape = { disc = { diameter = 0.25 } }\ndensity = 2.65\n\
        position = [1.0, 0.5]\n[time]\nend = 0.1\nstep = 0.005\n[output]\nfigures = false\n";
    let scene = box_case([2.0, 1.0], [32, 16], 0.01, STREAM, &format!("{disc}{MIXING}"));
    let case = write(dir.path(), &scene);
    let of = |lag: &str| {
        let options =
            ["--", "-ksp_type", "bcgs", "-pc_type", "hypre", "-ksp_lag_preconditioner", lag];
        let summary = run(&case, &dir.path().join(lag), &options);
        let number = |name: &str| summary[name].as_u64().unwrap();
        (number("steps"), number("preconditioner_setups"), number("krylov_iterations"))
    };
    let (steps, setups, iterations) = of("1");
    // The first one is that of the start.
    assert_eq!((steps, setups), (20, 19));
    let (_, setups, with_older) = of("4");
    assert!((4..=6).contains(&setups), "{setups} setups");
    assert!(with_older > iterations, "{with_older} iterations, {iterations} with new ones");
    let (_, setups, _) = of("auto");
    assert!((1..=10).contains(&setups), "{setups} setups");
}

#[test]
fn log_view_has_stages_by_the_names_of_a_step() {
    let dir = tempfile::tempdir().unwrap();
    let scene =
        box_case([2.0, 1.0], [32, 16], 0.01, STREAM, &format!("{DISC}\n[time]\nend = 0.02"));
    let log = printed(dir.path(), &write(dir.path(), &scene), &["-log_view"]);
    for stage in ["prediction", "assembly", "pressure", "correction", "bodies"] {
        let line = log.lines().find(|line| line.contains(&format!("{stage}: ")));
        let seconds = line.and_then(|line| line.split(": ").nth(2)?.split_whitespace().next());
        let seconds: f64 = seconds.unwrap_or_else(|| panic!("no stage {stage}")).parse().unwrap();
        assert!(seconds > 0.0, "{stage}");
    }
}
