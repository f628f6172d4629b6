//! The program as a person at a terminal meets it: the run folder, check, schema, PETSc's options,
//! failures.

use crate::support::{box_case, columns, mics, run, shipped};
use std::path::{Path, PathBuf};

pub const DISC: &str = "[[particle]]\nshape = { disc = { diameter = 0.3 } }\n\
    position = [0.6, 0.5]\nmotion = \"fixed\"\n[coupling]\nwall = \"sharp\"\n";

pub fn write(dir: &Path, text: &str) -> PathBuf {
    let path = dir.join("case.toml");
    std::fs::write(&path, text).unwrap();
    path
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn run_writes_documented_files() {
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
    let record: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("run.json")).unwrap()).unwrap();
    assert!(
        record["petsc_options"].as_str().unwrap().contains("-ksp_type cg -pc_type boxmg"),
        "{record}"
    );
    assert!(record["end"].is_string() && record["ranks"] == 1);
    let series = std::fs::read_to_string(out.join("fields/series.pvd")).unwrap();
    assert_eq!(series.matches("<DataSet").count(), 4, "{series}");
    // The case as run is a case, and runs to the same end.
    let again = dir.path().join("again");
    run(&out.join("case.toml"), &again, &[]);
    let repeated = columns(&again.join("particles.csv"));
    assert_eq!(
        repeated["fluid_fx"], particles["fluid_fx"],
        "the same case on the same machine is the same run"
    );
}

#[test]
fn check_describes_scene_and_skipped_parts() {
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
        "cg + boxmg (auto)",
    ] {
        assert!(said.contains(part), "{part} in {said}");
    }
}

#[test]
fn schema_is_json_with_all_keys() {
    let output = mics(&["schema"]);
    let schema: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(
        schema["properties"]["domain"].is_object() && schema["properties"]["particle"].is_object()
    );
    let kept = std::fs::read_to_string(shipped("cases/case.schema.json")).unwrap();
    let kept: serde_json::Value = serde_json::from_str(&kept).unwrap();
    assert!(kept == schema, "the cases' schema is another: mics schema > cases/case.schema.json");
}

/// OpenMPI's folder for temporary files is the same for all lone processes, which remove it when
/// they end: runs side by side failed.
#[test]
fn single_process_run_has_private_temporary_folder() {
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
fn mean_drag_with_impulsive_start_has_remark() {
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
        remark.starts_with("not steady: from t = 1.5") && line("drag").ends_with(remark),
        "{log}"
    );
    let later: f64 =
        remark.split(" it is ").nth(1).unwrap().split(';').next().unwrap().parse().unwrap();
    let late = summary["measures"]["late"].as_f64().unwrap();
    assert!((later / late - 1.0).abs() < 1e-3, "{remark}, {late}");
    assert!(summary["notes"].to_string().contains("drag not steady"), "{summary}");
    assert!(summary["remarks"]["late"].is_null() && line("push").ends_with(" N/m"), "{log}");
    assert_eq!(
        (summary["units"]["drag"].as_str(), summary["units"]["push"].as_str()),
        (Some(""), Some("N/m"))
    );
}

#[test]
fn terminal_speed_steadiness_and_old_measure_name() {
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
fn bodies_csv_and_particles_csv_rows() {
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
fn new_copies_shipped_case_under_own_name() {
    let dir = tempfile::tempdir().unwrap();
    let (own, copy) = (dir.path().join("my-bed"), dir.path().join("copy"));
    let made = mics(&["new", own.to_str().unwrap(), "--template", "sheared-bed"]);
    assert!(made.status.success(), "{}", text(&made.stderr));
    let case = own.join("case.toml");
    let said = mics(&["check", "--quiet", case.to_str().unwrap()]);
    assert!(said.status.success(), "{}", text(&said.stderr));
    let begun = std::fs::read_to_string(&case).unwrap();
    assert!(begun.contains("name = \"my-bed\"") && begun.starts_with("#:schema case.schema.json"));
    assert!(own.join("case.schema.json").is_file() && !begun.contains("reference ="), "{begun}");
    // A folder that is there stays, and an unknown name is answered with what was probably meant.
    let again = mics(&["new", own.to_str().unwrap()]);
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("is there already"), "{}", text(&again.stderr));
    let none = mics(&["cases", "copy", "sheared-bad"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(text(&none.stderr).contains("did you mean `sheared-bed`?"), "{}", text(&none.stderr));
    let copied = mics(&["cases", "copy", "wet-rebound", copy.to_str().unwrap()]);
    assert!(copied.status.success(), "{}", text(&copied.stderr));
    for file in ["stokes.study.toml", "collision_sphere.csv", "case.schema.json"] {
        assert!(copy.join(file).is_file(), "{file}");
    }
    let first = std::fs::read_to_string(copy.join("case.toml")).unwrap();
    assert!(first.starts_with("#:schema case.schema.json\n"), "{first}");
    // Files of its folders come along.
    let sorting = dir.path().join("sorting");
    assert!(mics(&["cases", "copy", "size-sorting", sorting.to_str().unwrap()]).status.success());
    let said = mics(&["check", "--quiet", sorting.join("case.toml").to_str().unwrap()]);
    assert!(said.status.success(), "{}", text(&said.stderr));
}

#[test]
fn cases_lists_shipped_cases() {
    let listed = mics(&["cases"]);
    let words = text(&listed.stdout);
    let folders = std::fs::read_dir(shipped("cases")).unwrap().map(|entry| entry.unwrap().path());
    for folder in folders.filter(|folder| folder.join("case.toml").is_file()) {
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        let line = words.lines().find(|line| line.split_whitespace().next() == Some(&name));
        // A whole sentence, however many lines it has in the case.
        let count = |bracket: char| line.map_or(0, |line| line.matches(bracket).count());
        let whole = line.is_some_and(|line| line.len() > name.len() + 12 && line.ends_with('.'));
        assert!(whole && count('(') == count(')'), "{name}: {line:?}");
    }
}
