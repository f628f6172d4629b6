//! The program as a person at a terminal meets it: the run folder, check, schema, PETSc's options,
//! failures.

use crate::support::{MIXING, SHARP, box_case, columns, mics, petsc, run, shipped};
use mics::Error;
use mics::error::NotFinite;
use mics::scene::Scene;
use std::path::{Path, PathBuf};

const STREAM: [&str; 4] = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"slip\"", "\"slip\""];

const DISC: &str = "[[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [0.6, 0.5]\n\
    motion = \"fixed\"\n\
    [coupling]\nwall = \"sharp\"\n";

fn write(dir: &Path, text: &str) -> PathBuf {
    let path = dir.join("case.toml");
    std::fs::write(&path, text).unwrap();
    path
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_run_leaves_the_folder_that_the_contract_promises() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("run");
    let short = [
        "--set",
        "time.end=0.1",
        "--set",
        "measure=[]",
        "--set",
        "output.fields={ every_time = 0.04 }",
    ];
    let summary = run(&shipped("cases/cylinder-wake/case.toml"), &out, &short);
    for name in [
        "case",
        "status",
        "cells",
        "steps",
        "time",
        "wall_seconds",
        "cpu_seconds",
        "peak_memory_bytes",
        "step_seconds",
        "divergence_max",
        "divergence_limit",
        "outer_iterations",
        "krylov_iterations",
        "measures",
        "stages_ns_per_cell_step",
        "peak_memory_bytes_per_cell",
    ] {
        assert!(!summary[name].is_null(), "{name}");
    }
    assert!((summary["time"].as_f64().unwrap() - 0.1).abs() < 1e-12);
    let head = std::fs::read_to_string(out.join("particles.csv")).unwrap();
    assert!(head.starts_with(
        "step,time,id,x,y,z,path_x,path_y,path_z,angle,vx,vy,vz,wx,wy,wz,fluid_fx,fluid_fy,\
        fluid_fz,fluid_tx,fluid_ty,fluid_tz,\
         pressure_fx,pressure_fy,pressure_fz,viscous_fx"
    ));
    // Each column that a run writes is described, with its unit.
    let page = std::fs::read_to_string(shipped("docs/output.md")).unwrap();
    for file in ["particles.csv", "steps.csv"] {
        let head = std::fs::read_to_string(out.join(file)).unwrap();
        for column in head.lines().next().unwrap().split(',') {
            assert!(
                page.contains(&format!("`{column}`")),
                "docs/output.md says nothing of {column} in {file}"
            );
        }
    }
    let (particles, steps) = (columns(&out.join("particles.csv")), columns(&out.join("steps.csv")));
    assert_eq!(particles["time"][0], 0.0);
    assert_eq!(particles["step"].len(), steps["step"].len());
    assert_eq!(steps["step"].len() as u64, summary["steps"].as_u64().unwrap() + 1);
    let run: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("run.json")).unwrap()).unwrap();
    assert!(
        run["petsc_options"].as_str().unwrap().contains("-ksp_type cg -pc_type boxmg"),
        "{run}"
    );
    assert!(run["end"].is_string() && run["ranks"] == 1);
    let series = std::fs::read_to_string(out.join("fields/series.pvd")).unwrap();
    assert_eq!(series.matches("<DataSet").count(), 4, "{series}");
    // The case as run is a case, and runs to the same end.
    let again = dir.path().join("again");
    run_again(&out.join("case.toml"), &again);
    let repeated = columns(&again.join("particles.csv"));
    assert_eq!(
        repeated["fluid_fx"], particles["fluid_fx"],
        "the same case on the same machine is the same run"
    );
}

fn run_again(case: &Path, out: &Path) {
    run(case, out, &[]);
}

#[test]
fn check_describes_the_scene_and_says_what_it_skips_and_why() {
    let output = mics(&["check", shipped("cases/cylinder-wake/case.toml").to_str().unwrap()]);
    let said = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    for part in [
        "160 x 64 cells",
        "d/h = 8.0",
        "Reynolds     100",
        "advection limit (Courant number 1.2)",
        "by time.cfl",
        "skips        fractions at every step: nothing moves",
        "skips        pressure operator at every step",
        "skips        contacts",
        "ms a step",
        "cg + boxmg (auto: the coefficient varies from face to face)",
    ] {
        assert!(said.contains(part), "{part} in {said}");
    }
}

#[test]
fn the_schema_is_json_and_knows_the_keys() {
    let output = mics(&["schema"]);
    let schema: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(
        schema["properties"]["domain"].is_object() && schema["properties"]["particle"].is_object()
    );
    let kept = std::fs::read_to_string(shipped("cases/case.schema.json")).unwrap();
    let kept: serde_json::Value = serde_json::from_str(&kept).unwrap();
    assert!(kept == schema, "the cases' schema is another: mics schema > cases/case.schema.json");
}

#[test]
fn petsc_options_that_end_the_program_or_write_nothing_are_refused_with_the_reason() {
    let dir = tempfile::tempdir().unwrap();
    let case = write(dir.path(), &box_case([2.0, 1.0], [32, 16], 0.01, STREAM, DISC));
    let out = dir.path().join("out");
    let refused = |options: &[&str], words: &str| {
        let run = ["run", case.to_str().unwrap(), "--quiet", "--out", out.to_str().unwrap(), "--"];
        let output = mics(&[&run[..], options].concat());
        assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
    };
    refused(&["-pc_type", "mg", "-pc_mg_levels", "3"], "-pc_type gamg or hypre find theirs");
    refused(&["-ksp_monitor", "hdf5:residuals.h5"], "give ascii:FILE");
    refused(&["-ksp_view_mat", "binary:A"], "there is no matrix to write");
    refused(&["-ksp_view_pmat", "binary:A"], "there is no matrix to write");
}

#[test]
fn gamg_as_the_preconditioner_of_cg_solves_for_free_bodies_in_a_closed_box() {
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
fn petsc_options_work_and_those_that_nothing_used_are_named() {
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
        // What nothing knows is said after the first solve, on stderr; what is used at the end
        // alone is not.
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
fn a_fixed_tolerance_is_kept_whatever_d0_says() {
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
fn a_solver_that_fails_ends_the_run_with_its_reasons_after_one_retry_if_that_could_help() {
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
fn a_limit_below_rounding_ends_the_run_and_names_the_last_good_state() {
    let dir = tempfile::tempdir().unwrap();
    let more = "[[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [0.6, 0.5]\n\
                motion = { prescribed = { velocity = [0.4, 0.0] } }\n[coupling]\n\
                wall = \"sharp\"\n";
    let case = write(dir.path(), &box_case([2.0, 1.0], [64, 32], 0.01, STREAM, more));
    let out = dir.path().join("run");
    let words = ["run", case.to_str().unwrap(), "--out", out.to_str().unwrap(), "--set"];
    let output = mics(&[&words[..], &["pressure.divergence_limit=1e-15"]].concat());
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(
        said.contains("C-HSMAC reached max |D|") || said.contains("the pressure solve failed"),
        "{said}"
    );
    assert!(!out.exists(), "the very first projection failed: nothing is written");
}

#[test]
fn a_fixed_step_that_the_flow_outgrows_stops_the_run_with_the_limit_and_keeps_its_state() {
    let dir = tempfile::tempdir().unwrap();
    let more = "[initial]\nvelocity = [0.0, 0.0]\n[[particle]]\n\
        shape = { disc = { diameter = 0.3 } }\nposition = [0.6, 0.5]\n\
                motion = \"fixed\"\n[coupling]\nwall = \"mixing\"\n[time]\nend = 1.0\n\
                    step = 0.0155";
    let case = write(dir.path(), &box_case([2.0, 1.0], [64, 32], 0.001, STREAM, more));
    let out = dir.path().join("run");
    let output = mics(&["run", case.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(
        said.contains("over the advection limit")
            && said.contains("step ")
            && said.contains("the last good state"),
        "{said}"
    );
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(summary.contains("\"failed\""), "{summary}");
    // The state that the refused step began with is the one kept, and its rows are written.
    let name = said[said.find("fields/").unwrap() + 7..].trim();
    let kept = mics_run::snapshot::Snapshot::read(&out.join("fields").join(name)).unwrap();
    let rows = columns(&out.join("steps.csv"));
    assert!(
        kept.time > 0.0 && kept.time == *rows["time"].last().unwrap(),
        "{} of {:?}",
        kept.time,
        rows["time"]
    );
}

#[test]
fn a_value_that_is_not_a_number_stops_the_step_and_its_cell_is_named() {
    let petsc = petsc();
    let mut scene: Scene<2> = petsc.scene(&box_case([2.0, 1.0], [32, 16], 0.01, STREAM, ""));
    scene.step(0.01).unwrap();
    let cell = scene.domain.grid.owned_index([7, 3]).unwrap();
    scene.state.u[1][cell] = f64::NAN;
    let error = scene.step(0.01).unwrap_err();
    assert!(
        matches!(
            &error,
            Error::NotFinite(NotFinite::Cell { field, .. }) if field.contains("velocity")
        ),
        "{error}"
    );
    let error = scene.energy_and_speed().unwrap_err();
    assert_eq!(error.exit_code(), 3);
}

#[test]
fn a_particle_that_is_lost_stops_the_step_and_is_named() {
    let petsc = petsc();
    let disc = |x: f64| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [{x:?}, 0.5]\n\
            density = 2.0\n"
        )
    };
    for wall in [SHARP, MIXING] {
        let more = [&disc(0.5), &disc(1.2), "[contact]\nnormal_stiffness = 100.0\n", wall].concat();
        let mut scene: Scene<2> = petsc.scene(&box_case([2.0, 1.0], [32, 16], 0.01, STREAM, &more));
        scene.step(0.01).unwrap();
        scene.state.bodies[1].velocity.y = f64::INFINITY;
        let error = scene.step(0.01).unwrap_err();
        assert!(matches!(error, Error::NotFinite(NotFinite::Particle(1))), "{wall}: {error}");
        assert!(
            error.to_string().contains("particle 1 is not a finite number")
                && error.exit_code() == 3,
            "{error}"
        );
    }
}

#[test]
fn a_flow_that_overflows_exits_with_three_and_names_step_and_place() {
    let dir = tempfile::tempdir().unwrap();
    let case =
        write(dir.path(), &box_case([1.0, 1.0], [16, 16], 0.01, crate::support::PERIODIC, ""));
    let out = dir.path().join("run");
    let words = ["run", case.to_str().unwrap(), "--out", out.to_str().unwrap(), "--set"];
    let output =
        mics(&[&words[..], &["fluid.density=1e-300", "--set", "drive.force=[1e30,0.0]"]].concat());
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("not a finite number"), "{}", text(&output.stderr));
}

#[test]
fn prescribed_bodies_that_meet_or_leave_the_box_stop_the_run_and_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let moving = |x: f64, v: [f64; 2]| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [{x:?}, 0.5]\n\
             motion = {{ prescribed = {{ velocity = {v:?} }} }}\n"
        )
    };
    let meeting = || moving(0.6, [1.0, 0.0]) + &moving(1.2, [-1.0, 0.0]);
    for (name, bodies, says) in [
        ("meet-sharp", meeting() + SHARP, "has run into particle 1"),
        ("meet-mixing", meeting() + MIXING, "has run into particle 1"),
        (
            "wall-sharp",
            moving(0.6, [0.0, 2.0]) + SHARP,
            "has reached the border of the box along y",
        ),
        (
            "wall-mixing",
            moving(0.6, [0.0, 2.0]) + MIXING,
            "has reached the border of the box along y",
        ),
    ] {
        let case = write(dir.path(), &box_case([2.0, 1.0], [32, 16], 0.01, STREAM, &bodies));
        let out = dir.path().join(name);
        let output =
            mics(&["run", case.to_str().unwrap(), "--out", out.to_str().unwrap(), "--quiet"]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{said}");
        assert!(
            said.contains("particle 0") && said.contains(says) && said.contains("error: step "),
            "{said}"
        );
        let rows = columns(&out.join("particles.csv"));
        assert!(
            *rows["time"].last().unwrap() > 0.1,
            "they met after 0.15 s: {:?}",
            rows["time"].last()
        );
    }
}

#[test]
fn flows_at_the_limit_of_every_scheme_keep_their_energy_bounded() {
    let petsc = petsc();
    for (viscosity, scheme) in [
        (1e-6, "scheme = \"rk2\"\ncfl = 0.5"),
        (1e-6, "scheme = \"rk3\"\ncfl = 1.2"),
        (1e-6, "scheme = \"euler\"\nadvection = \"qsi\"\ncfl = 0.9"),
        (2e-3, "scheme = \"euler\"\ncfl = 0.25"),
        (1.0, "scheme = \"rk2\"\ncfl = 0.5"),
        (1.0, "scheme = \"rk3\"\ncfl = 1.2"),
        (1.0, "scheme = \"euler\"\nadvection = \"qsi\"\ncfl = 0.9"),
    ] {
        let more = format!(
            "[initial]\nvelocity = [1.0, 0.3]\nperturbation = 0.5\n[time]\nend = 1.0\n{scheme}"
        );
        let text = box_case([1.0, 1.0], [24, 24], viscosity, crate::support::PERIODIC, &more);
        let mut scene: Scene<2> = petsc.scene(&text);
        let (start, _) = scene.energy_and_speed().unwrap();
        let mut before = start;
        for step in 0..200 {
            let (_, dt) = scene.limits().unwrap().tightest();
            scene.step(dt).unwrap();
            let (energy, _) = scene.energy_and_speed().unwrap();
            // The noise of the start has another pressure in each of the first steps.
            let growth = if step < 5 { 0.02 } else { 1e-3 };
            assert!(
                energy < before * (1.0 + growth),
                "{scheme}, nu = {viscosity}: {energy} after {before}"
            );
            before = energy;
        }
        assert!(before < start, "{scheme}, nu = {viscosity}: {before} of {start}");
    }
}

/// OpenMPI's folder for temporary files is the same for all lone processes, which remove it when
/// they end: runs side by side failed.
#[test]
fn a_lone_run_shares_no_folder_for_temporary_files_with_others() {
    let dir = tempfile::tempdir().unwrap();
    let case = write(
        dir.path(),
        &box_case([1.0, 1.0], [8, 8], 0.01, crate::support::PERIODIC, "[time]\nend = 0.01"),
    );
    let mut command = crate::support::mics_command();
    // Where nothing can be made.
    command.env("TMPDIR", "/dev/null/none").args(["check", case.to_str().unwrap(), "--quiet"]);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

#[test]
fn a_run_asked_for_ranks_starts_them_by_itself() {
    let dir = tempfile::tempdir().unwrap();
    let case = write(
        dir.path(),
        &box_case([1.0, 1.0], [32, 32], 0.01, crate::support::PERIODIC, "[time]\nend = 0.1"),
    );
    let (out, session) = (dir.path().join("out"), dir.path().join("session"));
    let go = |ranks: &str| {
        // A session folder of its own, as other tests' ranks have.
        let mut command = crate::support::mics_command();
        command.envs(crate::support::AS_ROOT).env("OMPI_MCA_orte_tmpdir_base", &session);
        command.args([
            "run",
            case.to_str().unwrap(),
            "--quiet",
            "--force",
            "--ranks",
            ranks,
            "--out",
            out.to_str().unwrap(),
        ]);
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let record = std::fs::read_to_string(out.join("run.json")).unwrap();
        serde_json::from_str::<serde_json::Value>(&record).unwrap()["ranks"].as_u64()
    };
    std::fs::create_dir(&session).unwrap();
    assert_eq!(go("2"), Some(2));
    assert_eq!(go("auto"), Some(1), "a thousand cells are too few for two");
}

#[test]
fn petsc_options_in_capitals_are_taken_and_types_in_capitals_named_in_lower_case() {
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

#[test]
fn a_failure_is_said_once_on_the_screen_and_kept_in_the_log() {
    let dir = tempfile::tempdir().unwrap();
    let disc = |x: f64, v: f64| {
        let motion = format!("motion = {{ prescribed = {{ velocity = [{v:?}, 0.0] }} }}");
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [{x:?}, 0.5]\n\
            {motion}\n"
        )
    };
    let meet = [&disc(0.6, 1.0), &disc(1.2, -1.0), SHARP].concat();
    let case =
        write(dir.path(), &box_case([2.0, 1.0], [32, 16], 0.01, crate::support::PERIODIC, &meet));
    let out = dir.path().join("run");
    let output = mics(&["run", case.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3));
    let [said, errors] = [text(&output.stdout), text(&output.stderr)];
    assert!(!said.contains("error: ") && errors.matches("error: ").count() == 1, "{said}{errors}");
    let log = std::fs::read_to_string(out.join("log.txt")).unwrap();
    assert_eq!(log.matches("error: ").count(), 1, "{log}");
}

/// A disc of 0.25 m in a stream of 1 m/s that begins at once, Re = 50.
fn stream_past_a_disc(measures: &str) -> String {
    format!(
        "name = \"s\"\ntime.end = 3.0\noutput.figures = false\n\
        domain = {{ size = [2.0, 1.0], cells = [64, 32] }}\n\
         fluid = {{ density = 1000.0, viscosity = 5.0 }}\n\
         boundary = {{ west = {{ inflow = [1.0, 0.0] }}, east = \"outflow\", south = \"slip\", \
             north = \"slip\" }}\n\
         particle = [{{ shape = {{ disc = {{ diameter = 0.25 }} }}, position = [0.6, 0.52], motion \
         = \"fixed\" }}]\n\
         measure = [{measures}]\n"
    )
}

#[test]
fn mean_drag_including_impulsive_start_is_remarked_with_later_mean_and_units() {
    let dir = tempfile::tempdir().unwrap();
    let measures = "{ name = \"drag\", kind = \"drag_coefficient\" }, \
        { name = \"late\", kind = \"drag_coefficient\", from = 1.5 }, \
                    { name = \"push\", kind = \"force\", from = 1.5 }";
    let case = write(dir.path(), &stream_past_a_disc(measures));
    let out = dir.path().join("run");
    let summary = run(&case, &out, &[]);
    let log = std::fs::read_to_string(out.join("log.txt")).unwrap();
    let line = |name: &str| {
        log.lines().find(|line| line.starts_with(&format!("{name} = "))).unwrap().to_owned()
    };
    let remark = summary["remarks"]["drag"].as_str().unwrap();
    assert!(
        remark.starts_with("counts the start of the flow; from t = 1.5")
            && line("drag").ends_with(remark),
        "{log}"
    );
    let later: f64 =
        remark.split(" it is ").nth(1).unwrap().split(':').next().unwrap().parse().unwrap();
    let late = summary["measures"]["late"].as_f64().unwrap();
    assert!((later / late - 1.0).abs() < 1e-3, "{remark}, {late}");
    assert!(summary["notes"].to_string().contains("drag counts the start"), "{summary}");
    assert!(summary["remarks"]["late"].is_null() && line("push").ends_with(" N/m"), "{log}");
    assert_eq!(
        (summary["units"]["drag"].as_str(), summary["units"]["push"].as_str()),
        (Some(""), Some("N/m"))
    );
}

#[test]
fn terminal_speed_states_steadiness_and_old_measure_name_is_noted() {
    let dir = tempfile::tempdir().unwrap();
    let case = shipped("cases/settling-disc/case.toml");
    let measures = "measure=[{ name = \"v\", kind = \"terminal_velocity\" }, \
        { name = \"t\", kind = \"terminal_speed\" }]";
    for (end, steady) in [("time.end=0.65", true), ("time.end=0.1", false)] {
        let out = dir.path().join("run");
        let summary = run(
            &case,
            &out,
            &["--force", "--set", measures, "--set", end, "--set", "output.figures=false"],
        );
        let speed = |name: &str| summary["measures"][name].as_f64().unwrap();
        let remark = summary["remarks"]["t"].as_str().unwrap();
        assert_eq!(remark.starts_with("steady within 0."), steady, "{remark}");
        assert_eq!((speed("t") / speed("v") - 1.0).abs() < 1e-2, steady, "{summary}");
        let log = std::fs::read_to_string(out.join("log.txt")).unwrap();
        assert!(log.contains("\"terminal_velocity\" is called \"largest_speed\" now"), "{log}");
        let kept = std::fs::read_to_string(out.join("case.toml")).unwrap();
        assert!(kept.contains("kind = \"largest_speed\""), "{kept}");
    }
}

/// Twelve discs that sink.
const MANY: &str = "name = \"many\"\ntime.end = 0.2\noutput.figures = false\n\
    domain = { size = [2.0, 1.0], cells = [64, 32] }\n\
    fluid = { density = 1000.0, viscosity = 5.0, gravity = [0.0, -9.81] }\n\
    boundary = { west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" }\n\
    contact = {}\n\
    swarm = [{ name = \"a, b\", material = \"steel\", count = 12, region = \
        { min = [0.0, 0.0], max = [2.0, 1.0] }, diameter = 0.125, \
    density = 2000.0, gap = 0.01 }]\n";

#[test]
fn bodies_csv_has_what_each_particle_is_and_particles_csv_four_rows_a_step() {
    let dir = tempfile::tempdir().unwrap();
    let case = write(dir.path(), MANY);
    let out = dir.path().join("run");
    run(&case, &out, &[]);
    let mut bodies = csv::Reader::from_path(out.join("bodies.csv")).unwrap();
    let head = bodies.headers().unwrap().iter().collect::<Vec<_>>().join(",");
    assert_eq!(head, "id,name,material,shape,diameter,density,motion");
    let rows: Vec<_> = bodies.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 12);
    assert_eq!(
        rows[11].iter().collect::<Vec<_>>(),
        ["11", "a, b", "steel", "disc", "0.125", "2000.0", "free"]
    );
    let (particles, steps) = (columns(&out.join("particles.csv")), columns(&out.join("steps.csv")));
    let last = steps["step"].len() - 1;
    let mut sampled = particles["step"].clone();
    sampled.dedup();
    let expected: Vec<f64> =
        (0..=last).filter(|k| k % 3 == 0 || *k == last).map(|k| k as f64).collect();
    assert_eq!(sampled, expected);
}

#[test]
fn new_case_begins_as_a_shipped_one_under_its_own_name() {
    let dir = tempfile::tempdir().unwrap();
    let (own, copy) = (dir.path().join("my-bed"), dir.path().join("copy"));
    let made = mics(&["new", own.to_str().unwrap(), "--template", "sheared-bed"]);
    assert!(made.status.success(), "{}", text(&made.stderr));
    let case = own.join("case.toml");
    let said = mics(&["check", "--quiet", case.to_str().unwrap()]);
    assert!(said.status.success(), "{}", text(&said.stderr));
    let begun = std::fs::read_to_string(&case).unwrap();
    assert!(begun.contains("name = \"my-bed\"") && !begun.contains("#:schema"), "{begun}");
    // What is there stays, and a name that is none is answered with what was probably meant.
    let again = mics(&["new", own.to_str().unwrap()]);
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("is there already"), "{}", text(&again.stderr));
    let none = mics(&["cases", "copy", "sheared-bad"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(text(&none.stderr).contains("did you mean `sheared-bed`?"), "{}", text(&none.stderr));
    let copied = mics(&["cases", "copy", "wet-rebound", copy.to_str().unwrap()]);
    assert!(copied.status.success(), "{}", text(&copied.stderr));
    for file in ["stokes.study.toml", "collision_sphere.csv"] {
        assert!(copy.join(file).is_file(), "{file}");
    }
}

#[test]
fn cases_lists_every_shipped_case_with_its_scene() {
    let listed = mics(&["cases"]);
    let words = text(&listed.stdout);
    let folders = std::fs::read_dir(shipped("cases")).unwrap().map(|entry| entry.unwrap().path());
    for folder in folders.filter(|folder| folder.join("case.toml").is_file()) {
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        let line = words.lines().find(|line| line.split_whitespace().next() == Some(&name));
        assert!(line.is_some_and(|line| line.len() > name.len() + 12), "{name}: {line:?}");
    }
}
