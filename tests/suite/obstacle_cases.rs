//! Obstacles as a user meets them: cases that name files, runs, figures, restarts.

use crate::support::{box_case, columns, mics, run, run_on_ranks, shipped};
use std::path::{Path, PathBuf};

/// A stone and a disc fall onto a bed with a pier; the box is periodic along it.
const BED: &str = r#"name = "bed"
[domain]
size = [0.2, 0.1]
cells = [80, 40]
[fluid]
density = 1000.0
viscosity = 0.1
gravity = [0.0, -9.81]
[boundary]
west = "periodic"
east = "periodic"
south = "wall"
north = "wall"
[[obstacle]]
name = "bed"
heights = { file = "bed.csv" }
[[obstacle]]
name = "paddle"
polygon = { file = "paddle.csv", scale = 0.001 }
position = [0.12, 0.05]
centre = [0.1, 0.07]
motion = { prescribed = { velocity = [0.0, 0.1] } }
[[particle]]
shape = { disc = { diameter = 0.02 } }
position = [0.05, 0.031]
density = 2650.0
[[particle]]
shape = { polygon = { points = [[0, 0], [0.03, 0], [0.03, 0.02], [0, 0.02]] } }
position = [0.17, 0.035]
density = 2650.0
[contact]
friction = 0.5
[time]
end = 0.024
step = 0.001
[output]
particles = { every = 1 }
checkpoint = { every_steps = 12 }
figures = false
[statistics]
from = 0.0
[[measure]]
name = "weight"
kind = "force"
obstacle = "bed"
direction = [0, -1]
"#;

/// Writes the case with the files that it names into a folder.
fn written(folder: &Path) -> PathBuf {
    for (name, content) in [
        ("bed.csv", "x,y\n0.05,0.02\n0.15,0.02\n0.17,0.024\n"),
        ("paddle.csv", "x,y\n-20,0\n20,0\n20,15\n-20,15\n"),
        ("case.toml", BED),
    ] {
        std::fs::write(folder.join(name), content).unwrap();
    }
    folder.join("case.toml")
}

#[test]
fn run_with_obstacles_stands_without_their_files_and_restarts_exactly() {
    let dir = tempfile::tempdir().unwrap();
    let case = written(dir.path());
    let said = mics(&["check", case.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(
        said.contains("\nbed          outline of") && said.contains("\npaddle       "),
        "{said}"
    );
    let whole = dir.path().join("whole");
    let parts = dir.path().join("parts");
    let summary = run(&case, &whole, &[]);
    assert!(summary["measures"]["weight"].is_number(), "{summary}");
    run(&case, &parts, &["--set", "time.end=0.012"]);
    run(&case, &parts, &["--resume"]);
    for table in ["particles.csv", "obstacles.csv", "balance.csv"] {
        let rows = |out: &Path| std::fs::read_to_string(out.join(table)).unwrap();
        assert_eq!(rows(&whole), rows(&parts), "{table}");
    }
    let rows = columns(&whole.join("obstacles.csv"));
    // Two obstacles a step; what they carry is a contact's force.
    assert_eq!((rows["id"].len(), rows["id"][0], rows["id"][1]), (50, 0.0, 1.0));
    assert!((rows["y"][49] - 0.07 - 0.1 * 0.024).abs() < 1e-12);
    assert!(rows["contact_fy"][48] < -1.0, "{}", rows["contact_fy"][48]);
    let balance = columns(&whole.join("balance.csv"));
    for k in 0..2 {
        let [all, bed, paddle] = ["held", "held_bed", "held_paddle"].map(|name| balance[name][k]);
        assert!((all - bed - paddle).abs() < 1e-12 * (bed.abs() + paddle.abs()), "{all} {bed}");
    }
    let bodies = columns(&whole.join("particles.csv"));
    assert!(bodies["id"].iter().all(|id| *id < 2.0));
    for name in ["bed.csv", "paddle.csv", "case.toml"] {
        std::fs::remove_file(dir.path().join(name)).unwrap();
    }
    for command in ["plot", "report"] {
        let output = mics(&[command, whole.to_str().unwrap()]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let surfaces = std::fs::read_to_string(whole.join("fields/obstacles-00000024.vtp")).unwrap();
    assert!(surfaces.contains("NumberOfVerts=\"2\""));
}

#[test]
fn inflow_beside_obstacle_passes_what_is_open_and_reattaches_where_erturk_has_it() {
    let dir = tempfile::tempdir().unwrap();
    let measures = "measure=[{ name = \"flow\", kind = \"flow_rate\", axis = \"x\", from = 50.0 }, \
        { name = \"reattachment\", kind = \"reattachment\" }]";
    let more = [
        "--set",
        "domain.size=[16.0, 2.0]",
        "--set",
        "domain.cells=[128, 16]",
        "--set",
        "time.end=60.0",
        "--set",
        "output.figures=false",
        "--set",
        measures,
    ];
    let summary = run(&shipped("cases/backward-step/case.toml"), &dir.path().join("run"), &more);
    let value = |name: &str| summary["measures"][name].as_f64().unwrap();
    let place = (value("reattachment") - 5.0) / 2.922 - 1.0;
    let flow = value("flow");
    println!("reattachment {:+.2} %, flow {flow}", 100.0 * place);
    // A parabola by its values at the middles of faces: 1 + 1/(2 n^2) of 8 of them.
    assert!((flow - 1.0 - 0.5 / 64.0).abs() < 1e-3, "{flow}");
    assert!(place.abs() < 0.03, "{place}");
}

/// The force on a disc in a stream close above a bed, its centre at x (m) in a period of 0.2 m.
fn force_above_bed(x: f64) -> [f64; 2] {
    let dir = tempfile::tempdir().unwrap();
    let body = format!(
        "[[obstacle]]\nheights = {{ points = [[0.0, 0.02], [0.19, 0.02]] }}\n[[particle]]\n\
        shape = {{ disc = {{ diameter = 0.025 }} }}\nposition = [{x:?}, 0.033]\n\
        motion = \"fixed\"\n[drive]\nmean_velocity = {{ axis = \"x\", value = 0.2 }}\n\
        [time]\nend = 0.02\n[output]\nfigures = false\n[pressure]\n\
        divergence_limit = 1.0e-6\n"
    );
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"slip\""];
    let text = box_case([0.2, 0.1], [80, 40], 5e-5, sides, &body);
    let path = dir.path().join("case.toml");
    std::fs::write(&path, text).unwrap();
    run(&path, &dir.path().join("run"), &[]);
    let rows = columns(&dir.path().join("run/particles.csv"));
    ["fluid_fx", "fluid_fy"].map(|name| *rows[name].last().unwrap())
}

#[test]
fn body_above_bed_feels_no_end_of_period() {
    let middle = force_above_bed(0.1);
    // The second and the third reach across the end of the period, where the bed's images begin.
    for x in [0.05, 0.0, 0.1975] {
        let here = force_above_bed(x);
        let apart = (0..2).map(|a| (here[a] - middle[a]).abs()).fold(0.0, f64::max);
        let size = middle[0].hypot(middle[1]);
        println!("x = {x}: {here:?} beside {middle:?}");
        assert!(apart < 1e-5 * size, "{x}: {here:?} {middle:?}");
    }
}

/// Forces of the fluid on obstacles are measured, drawn and reported as those on particles.
#[test]
fn obstacle_force_and_torque_are_in_measures_figures_and_report() {
    let dir = tempfile::tempdir().unwrap();
    let case = written(dir.path());
    let turning = "[[measure]]\nname = \"turning\"\nkind = \"torque\"\nobstacle = \"paddle\"\n";
    let about = turning.replace("turning", "hinge") + "about = [0.08, 0.1]\n";
    std::fs::write(&case, BED.to_owned() + turning + &about).unwrap();
    let said = mics(&["check", case.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    let line = |name: &str| said.lines().find(|line| line.starts_with(name)).unwrap();
    // The ground goes on below the box: it has no thickness.
    assert!(!line("bed").contains("thinnest") && line("paddle").contains("thinnest"), "{said}");
    assert!(line("contacts  ").contains("2 of 2 free bodies touch"), "{said}");

    let out = dir.path().join("run");
    let summary = run(&case, &out, &["--set", "output.figures=true"]);
    let rows = columns(&out.join("obstacles.csv"));
    let of_paddle = rows["fluid_tz"].iter().zip(&rows["id"]).filter(|row| *row.1 == 1.0).skip(1);
    let torques: Vec<f64> = of_paddle.map(|row| *row.0).collect();
    let mean = torques.iter().sum::<f64>() / torques.len() as f64;
    let found = summary["measures"]["turning"].as_f64().unwrap();
    assert!(mean != 0.0 && (found - mean).abs() < 1e-9 * mean.abs(), "{found} {mean}");
    assert_eq!(summary["units"]["turning"], "N m/m");
    // T + (centre - about) x F of every step.
    let paddle = |row: &usize| rows["id"][*row] == 1.0;
    let about = (0..rows["id"].len()).filter(paddle).skip(1).map(|row| {
        let [x, y, fx, fy, torque] =
            ["x", "y", "fluid_fx", "fluid_fy", "fluid_tz"].map(|name| rows[name][row]);
        torque + (x - 0.08) * fy - (y - 0.1) * fx
    });
    let hinge = about.sum::<f64>() / torques.len() as f64;
    let found = summary["measures"]["hinge"].as_f64().unwrap();
    println!("torque about the centre {mean}, about the hinge {found}, by the rows {hinge}");
    assert!((hinge - mean).abs() > 0.1 * mean.abs(), "{hinge} {mean}");
    assert!((found - hinge).abs() < 1e-9 * hinge.abs(), "{found} {hinge}");

    let figure = |name: &str| std::fs::read_to_string(out.join("figures").join(name)).unwrap();
    for name in ["bed", "paddle", "particle 0"] {
        assert!(figure("forces.svg").contains(&format!(">\n{name}\n<")), "forces lack {name}");
    }
    assert!(figure("paths.svg").matches("#6E6E6E").count() > 1, "outlines of both obstacles");
    let html = dir.path().join("report.html");
    let told = mics(&["report", out.to_str().unwrap(), "--out", html.to_str().unwrap()]);
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    let html = std::fs::read_to_string(html).unwrap();
    for part in [
        "force of bed along -y",
        "torque of paddle about z",
        "torque of paddle about z through (0.08, 0.1) m",
        " N/m</td>",
        " N m/m</td>",
    ] {
        assert!(html.contains(part), "no `{part}`");
    }
}

/// The largest change of a column between two runs, over its largest value, for each column.
fn assert_alike(runs: [&Path; 2], table: &str, names: &[&str]) {
    let [alone, shared] = runs.map(|out| columns(&out.join(table)));
    for name in names.iter().copied() {
        let largest = alone[name].iter().fold(0.0f64, |most, v| most.max(v.abs()));
        let apart = alone[name].iter().zip(&shared[name]).map(|(a, b)| (a - b).abs());
        let apart = apart.fold(0.0, f64::max);
        assert!(apart <= 1e-5 * largest.max(1e-9), "{table} {name}: {apart:e} of {largest:e}");
    }
}

#[test]
fn obstacles_on_several_ranks_are_those_of_one() {
    let dir = tempfile::tempdir().unwrap();
    let case = written(dir.path());
    let one = dir.path().join("one");
    let three = dir.path().join("three");
    run(&case, &one, &[]);
    run_on_ranks(3, &case, &three);
    let of_bodies = ["x", "y", "vx", "vy", "wz", "fluid_fx", "fluid_fy", "contact_fy"];
    let of_walls = ["y", "vy", "fluid_fx", "viscous_fy", "contact_fx", "contact_fy"];
    assert_alike([&one, &three], "particles.csv", &of_bodies);
    assert_alike([&one, &three], "obstacles.csv", &of_walls);
}

/// All bodies that a coarse level of the multigrid resolves are those of the first of two ranks,
/// with which the second sums.
#[test]
fn bodies_resolved_on_one_rank_alone_move_as_on_one() {
    let dir = tempfile::tempdir().unwrap();
    let disc = |diameter: f64, x: f64| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = {diameter} }} }}\n\
            position = [{x}, 0.04]\ndensity = 1.1\nvelocity = [0.1, -0.05]\n"
        )
    };
    let rest = "[[obstacle]]\nheights = { points = [[0.0, 0.01], [0.2, 0.014]] }\n[time]\n\
        end = 0.02\n[output]\nfigures = false\n[pressure]\ndivergence_limit = 1.0e-6\n";
    let body = disc(0.02, 0.03) + &disc(0.006, 0.15) + rest;
    let sides = ["\"wall\"", "\"wall\"", "\"wall\"", "\"slip\""];
    let text = box_case([0.2, 0.1], [80, 40], 1e-4, sides, &body);
    let case = dir.path().join("case.toml");
    std::fs::write(&case, text).unwrap();
    let one = dir.path().join("one");
    let two = dir.path().join("two");
    run(&case, &one, &[]);
    run_on_ranks(2, &case, &two);
    assert_alike([&one, &two], "particles.csv", &["x", "y", "vx", "vy", "wz", "fluid_fy"]);
}
