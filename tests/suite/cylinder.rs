//! The paper's section 3 at N = 8 and 16: drag against a control volume, steady and shedding wakes.

use crate::support::{columns, run, shipped};
use mics_run::snapshot::Snapshot;
use std::path::Path;

const SPEED: f64 = 1.0;
const DIAMETER: f64 = 0.2;
const DENSITY: f64 = 1000.0;

fn section3(out: &Path, re: f64, wall: &str, more: &[&str]) -> serde_json::Value {
    let viscosity = format!("fluid.viscosity={:?}", DENSITY * SPEED * DIAMETER / re);
    let wall = format!("coupling.wall=\"{wall}\"");
    let words = ["--set", &viscosity, "--set", &wall, "--set", "output.figures=false"];
    run(&shipped("cases/cylinder-wake/case.toml"), out, &[&words[..], more].concat())
}

/// Drag by the balance of momentum over a box around the cylinder, from the fields of the last
/// snapshot alone: fluxes, pressure and viscous stress through its sides, by means of the two cells
/// beside each side.
fn control_volume_drag(out: &Path, viscosity: f64) -> f64 {
    let fields = std::fs::read_dir(out.join("fields")).unwrap();
    let newest = fields
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().unwrap() == "vti")
        .max()
        .unwrap();
    let s = Snapshot::read(&newest).unwrap();
    let (nx, h) = (s.cells[0], s.h[0]);
    let velocity = &s.array("velocity").unwrap().values;
    let pressure = &s.array("pressure").unwrap().values;
    let u = |i: usize, j: usize, a: usize| velocity[3 * (j * nx + i) + a];
    let p = |i: usize, j: usize| pressure[j * nx + i];
    let cell = |x: f64| (x / h).round() as usize;
    let (west, east, south, north) = (cell(0.5), cell(1.3), cell(0.4), cell(1.2));
    let mut force = 0.0;
    for j in south..north {
        for (i, sign) in [(west, 1.0), (east, -1.0)] {
            let mean = 0.5 * (u(i - 1, j, 0) + u(i, j, 0));
            let stress = 2.0 * viscosity * (u(i, j, 0) - u(i - 1, j, 0)) / h;
            force += sign * h * (DENSITY * mean * mean + 0.5 * (p(i - 1, j) + p(i, j)) - stress);
        }
    }
    for i in west..east {
        for (j, sign) in [(south, 1.0), (north, -1.0)] {
            let mean = [0, 1].map(|a| 0.5 * (u(i, j - 1, a) + u(i, j, a)));
            let across = (u(i, j, 0) - u(i, j - 1, 0)) / h;
            let along = 0.25
                * (u(i + 1, j - 1, 1) + u(i + 1, j, 1) - u(i - 1, j - 1, 1) - u(i - 1, j, 1))
                / h;
            force += sign * h * (DENSITY * mean[0] * mean[1] - viscosity * (across + along));
        }
    }
    force
}

#[test]
fn momentum_force_equals_control_volume_force() {
    let dir = tempfile::tempdir().unwrap();
    for (re, cells, wall) in [(20.0, "[160,64]", "mixing"), (40.0, "[160,64]", "sharp")] {
        let out = dir.path().join(format!("{re}{cells}{wall}"));
        let set = format!("domain.cells={cells}");
        section3(
            &out,
            re,
            wall,
            &[
                "--set",
                &set,
                "--set",
                "time.end=12.0",
                "--set",
                "measure=[]",
                "--set",
                "initial.perturbation=0.0",
            ],
        );
        let rows = columns(&out.join("particles.csv"));
        let force = *rows["momentum_fx"].last().unwrap();
        let balance = control_volume_drag(&out, DENSITY * SPEED * DIAMETER / re);
        println!(
            "Re {re} {cells}: momentum {force:.3} N, control volume {balance:.3} N, {:+.2} %",
            100.0 * (force / balance - 1.0)
        );
        assert!(
            (force / balance - 1.0).abs() < 0.005,
            "Re {re} {cells}: {force} against {balance}"
        );
        let literal = ["pressure_fx", "viscous_fx", "convective_fx"]
            .map(|n| *rows[n].last().unwrap())
            .iter()
            .sum::<f64>();
        assert!(
            wall == "sharp" || literal < force,
            "(19) as printed misses a part: {literal} of {force}"
        );
    }
}

/// The wake at a Reynolds number, a row of the reference: the drag within a part of that there, the
/// Strouhal number within 2 %.
fn expect_the_wake(re: f64, row: usize, within: f64) {
    let dir = tempfile::tempdir().unwrap();
    let reference = columns(&shipped("cases/cylinder-wake/cylinder_s3.csv"));
    let summary = section3(dir.path(), re, "sharp", &["--set", "time.end=30.0"]);
    let strouhal = summary["measures"]["strouhal"].as_f64();
    let expected = reference["st"][row];
    println!("Re {re}: {:?}, reference St {expected}", summary["measures"]);
    if re < 50.0 {
        assert_eq!(strouhal, None, "Re {re} is steady");
    } else {
        assert!(
            (strouhal.unwrap() / expected - 1.0).abs() < 0.02,
            "Re {re}: {strouhal:?} against {expected}"
        );
    }
    let (drag, expected) =
        (summary["measures"]["drag_coefficient"].as_f64().unwrap(), reference["cd"][row]);
    assert!((drag / expected - 1.0).abs() < within, "Re {re}: Cd {drag} against {expected}");
}

#[test]
fn cylinder_wake_steady_at_re_40_and_strouhal_at_re_100() {
    expect_the_wake(40.0, 2, 0.02);
    expect_the_wake(100.0, 3, 0.02);
}

/// There the boundary layer is thinner than a spacing: the study offsets.study.toml says what
/// eight places within a cell give.
#[test]
#[ignore = "takes long; ci/weekly"]
fn cylinder_wake_strouhal_at_re_200() {
    expect_the_wake(200.0, 4, 0.075);
}

#[test]
fn divergence_below_d0_for_loose_and_tight_limits() {
    let dir = tempfile::tempdir().unwrap();
    for limit in ["1e-4", "1e-8"] {
        let set = format!("pressure.divergence_limit={limit}");
        let sharp = "coupling.wall=\"sharp\"";
        let short = ["--set", &set, "--set", "time.end=0.2", "--set", "measure=[]", "--set", sharp];
        for case in ["cylinder-wake", "sphere-stream"] {
            let out = dir.path().join(format!("{case}{limit}"));
            let summary = run(&shipped(&format!("cases/{case}/case.toml")), &out, &short);
            let steps = columns(&out.join("steps.csv"));
            assert!(
                steps["divergence_max"].iter().all(|d| *d < limit.parse().unwrap()),
                "{case} {limit}"
            );
            assert!(summary["krylov_iterations"].as_u64() > Some(0));
        }
    }
}
