//! Figures of many bodies and of several runs.

use crate::plots::{fall, plotted};
use crate::support::{mics, run, shipped};
use std::path::Path;

/// 16 discs of stone and 8 larger ones of steel let go in water.
const POUR: &str = r#"
name = "pour"
domain = { size = [0.12, 0.16], cells = [60, 80] }
fluid = { density = 1000.0, viscosity = 0.005, gravity = [3.0, -9.81] }
boundary = { west = "wall", east = "wall", south = "wall", north = "wall" }
contact = { restitution = 0.6, friction = 0.4 }
time = { end = 0.02, cfl = 0.4 }
output = { fields = { every_time = 0.01 } }
[[swarm]]
name = "gravel"
count = 16
diameter = 0.008
density = 2650.0
material = "stone"
region = { min = [0.01, 0.06], max = [0.11, 0.155] }
[[swarm]]
name = "balls"
count = 8
diameter = 0.012
density = 7800.0
material = "steel"
region = { min = [0.01, 0.06], max = [0.11, 0.155] }
"#;

#[test]
fn figures_of_many_bodies_group_by_material_and_size() {
    let dir = tempfile::tempdir().unwrap();
    let (file, out) = (dir.path().join("pour.toml"), dir.path().join("pour"));
    std::fs::write(&file, POUR).unwrap();
    run(&file, &out, &[]);
    let svg =
        |name: &str| std::fs::read_to_string(out.join(format!("figures/{name}.svg"))).unwrap();
    for (name, what, unit) in [("forces", "force", "N/m"), ("speeds", "velocity", "m/s")] {
        let svg = svg(name);
        for label in ["gravel, stone, d = 0.008 m (16)", "balls, steel, d = 0.012 m (8)"] {
            assert!(svg.contains(&format!(">\n{label}\n<")), "{name} lacks {label}");
        }
        for axis in ["x", "y"] {
            assert!(
                svg.contains(&format!(">\n{what} along {axis} ({unit})\n<")),
                "{name} lacks {axis}"
            );
        }
        assert!(svg.contains("the middle 80 %"), "{name} says what its bands are");
    }
    let paths = svg("paths");
    for label in
        ["pour: paths of 7 of 24 bodies", "gravel 0", "gravel 15", "balls 16", "balls 23", "x (m)"]
    {
        assert!(paths.contains(&format!(">\n{label}\n<")), "paths lack {label}");
    }
    let folder = out.to_str().unwrap();
    plotted(&[folder, "--figure", "paths", "--particle", "gravel"]);
    let paths = svg("paths");
    assert_eq!(paths.matches(">\ngravel ").count(), 7, "as many as there are colours");
    assert!(paths.contains("paths of 7 of 16 bodies") && paths.contains("x/d, d = 0.008 m"));
    // Two sizes have a legend.
    plotted(&[folder, "--field", "speed", "--bodies", "size"]);
    assert_eq!(svg("speed_field").matches("data:image/png").count(), 2);
}

fn short_run(out: &Path, viscosity: f64) {
    let viscosity = format!("fluid.viscosity={viscosity:?}");
    let words = [
        "--set",
        &viscosity,
        "--set",
        "domain.cells=[80,32]",
        "--set",
        "time.end=4.0",
        "--set",
        "measure.2.from=1.0",
    ];
    let from = ["--set", "measure.0.from=1.0", "--set", "measure.1.from=1.0"];
    run(&shipped("cases/cylinder-wake/case.toml"), out, &[&words[..], &from].concat());
}

#[test]
fn plots_of_several_runs_share_drag_over_reynolds() {
    let dir = tempfile::tempdir().unwrap();
    let [a, b, out] = ["a", "b", "out"].map(|n| dir.path().join(n));
    short_run(&a, 20.0);
    short_run(&b, 5.0);
    std::fs::remove_dir_all(a.join("figures")).unwrap();
    let [a, b, out] = [&a, &b, &out].map(|p| p.to_str().unwrap());
    let drag = || {
        plotted(&[a, b, "--figure", "drag", "--out", out]);
        std::fs::read_to_string(Path::new(out).join("drag_over_reynolds.svg")).unwrap()
    };
    assert!(drag().contains("unbounded stream"));
    // Between walls it is another scene, which has the references of its own case alone.
    let case = Path::new(b).join("case.toml");
    let text = std::fs::read_to_string(&case).unwrap();
    std::fs::write(&case, text.replace("\"periodic\"", "\"wall\"")).unwrap();
    assert!(!drag().contains("unbounded stream"));
    std::fs::write(&case, text).unwrap();
    let output = mics(&["plot", a, b, "--out", out]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let listed = String::from_utf8(output.stdout).unwrap();
    for (folder, name) in [
        (a, "figures/vorticity"),
        (b, "figures/streamlines"),
        (b, "figures/forces"),
        (out, "drag_over_reynolds"),
    ] {
        for kind in ["png", "svg"] {
            let path = Path::new(folder).join(format!("{name}.{kind}"));
            assert!(listed.contains(path.to_str().unwrap()), "{listed}");
            let bytes = std::fs::read(&path).unwrap();
            assert!(
                bytes.len() > 2000 && (bytes.starts_with(b"\x89PNG") || bytes.starts_with(b"<svg")),
                "{path:?}"
            );
        }
    }
}

/// Solvers and methods are compared in one picture, in which each run has its name.
#[test]
fn speeds_forces_and_solves_of_several_runs_share_a_picture() {
    let dir = tempfile::tempdir().unwrap();
    let short = ["--set", "time.end=0.02", "--set", "pressure.history=true"];
    let other = ["--set", "pressure.solver=\"bcgs-boomeramg\""];
    let [a, b] = [("first", &[][..]), ("second", &other)]
        .map(|(name, more)| fall(dir.path(), name, &[&short[..], more].concat()));
    let out = dir.path().join("out");
    let out = out.to_str().unwrap();
    let figures = ["convergence", "convergence-steps", "speeds", "forces"];
    let drawn = plotted(&[&a, &b, "--figure", &figures.join(","), "--out", out]);
    assert_eq!(drawn.len(), 2 * figures.len(), "{drawn:?}");
    for figure in figures {
        let svg = format!("{out}/{}.svg", figure.replace('-', "_"));
        let svg = std::fs::read_to_string(svg).unwrap();
        for label in ["first", "second"] {
            assert!(svg.contains(&format!(">\n{label}\n<")), "{figure}: {label}");
        }
    }
}
