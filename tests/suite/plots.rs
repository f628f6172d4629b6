//! `mics plot`: figures from one or several run folders.

use crate::support::{mics, run, shipped};
use std::path::Path;

/// A disc that falls beside a wall and has not landed after 0.3 s, with a field every 0.05 s.
pub const FALL: &str = r#"
name = "fall"
domain = { size = [0.1, 0.15], cells = [40, 60] }
fluid = { density = 1000.0, viscosity = 0.01, gravity = [0.0, -9.81] }
boundary = { west = "wall", east = "wall", south = "wall", north = "slip" }
particle = [{ shape = { disc = { diameter = 0.02 } }, density = 1200.0, position = [0.015, 0.1] }]
contact = { normal_stiffness = 1.0e6, friction = 0.4, restitution = 0.3 }
time = { end = 0.3, cfl = 0.4 }
pressure.divergence_limit = 1.0e-2
output = { fields = { every_time = 0.05 }, figures = false }
[[measure]]
name = "landing_x"
kind = "position_x"
reference = [0.04, 0.07]
source = "an experiment"
"#;

pub fn fall(folder: &Path, name: &str, more: &[&str]) -> String {
    let (case, out) = (folder.join("fall.toml"), folder.join(name));
    std::fs::write(&case, FALL).unwrap();
    run(&case, &out, more);
    out.to_str().unwrap().to_owned()
}

/// The files that `mics plot` lists, each there.
pub fn plotted(words: &[&str]) -> Vec<String> {
    let output = mics(&[&["plot"], words].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let listed: Vec<String> =
        String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect();
    assert!(listed.iter().all(|path| std::fs::metadata(path).unwrap().len() > 2000), "{listed:?}");
    listed
}

#[test]
fn named_figures_are_drawn_alone_with_titles() {
    let dir = tempfile::tempdir().unwrap();
    let (a, b) = (
        fall(dir.path(), "sharp", &[]),
        fall(dir.path(), "mixing", &["--set", "coupling.wall=\"mixing\""]),
    );
    let out = dir.path().join("out");
    let out = out.to_str().unwrap();
    let strip = plotted(&[
        &a,
        "--figure",
        "vorticity-strip,streamlines-strip",
        "--times",
        "0.1,0.2,0.3",
        "--interval",
        "20",
    ]);
    let name = |kind: &str| ["png", "svg"].map(|end| format!("{a}/figures/{kind}_strip.{end}"));
    assert_eq!(strip, [name("vorticity"), name("streamlines")].concat());
    let svg = std::fs::read_to_string(&strip[1]).unwrap();
    for said in [
        "(a) t = 0.10",
        "(b) t = 0.20",
        "(c) t = 0.30",
        "fall: vorticity, contour lines every 20 1/s, dashed",
    ] {
        assert!(svg.contains(said), "{said}");
    }
    assert!(!svg.contains("(d) "));
    // The two runs' paths in one picture, with the band that is in the case.
    assert_eq!(
        plotted(&[&a, &b, "--figure", "paths", "--out", out]),
        ["png", "svg"].map(|end| format!("{out}/paths.{end}"))
    );
    let svg = std::fs::read_to_string(format!("{out}/paths.svg")).unwrap();
    assert!(
        [
            ">\nsharp\n<",
            ">\nmixing\n<",
            ">\nan experiment\n<",
            ">\ny/d\n<",
            ">\nx/d, d = 0.02 m\n<"
        ]
        .iter()
        .all(|label| svg.contains(label))
    );
    let lines = "convective_fx+pressure_fx,vy";
    let parts = plotted(&[&b, "--columns", lines, "--over", "y", "--out", out]);
    let svg = std::fs::read_to_string(&parts[1]).unwrap();
    for label in ["convective_fx", "pressure_fx", "N/m", "vy (m/s)", "y (m)"] {
        assert!(svg.contains(&format!(">\n{label}\n<")), "{label}");
    }
    let part =
        plotted(&[&a, "--figure", "vorticity", "--window", "0.0,0.05,0.05,0.1", "--out", out]);
    assert_eq!(part, ["png", "svg"].map(|end| format!("{out}/vorticity.{end}")));
    assert!(
        std::fs::read_to_string(&part[1]).unwrap().contains(">\n0.10\n<"),
        "the axis says where the part is"
    );

    let at = plotted(&[
        &a,
        "--figure",
        "vorticity",
        "--times",
        "0.1",
        "--range=-20,20",
        "--size",
        "300",
        "--out",
        out,
    ]);
    let svg = std::fs::read_to_string(&at[1]).unwrap();
    assert!(
        svg.contains("fall, t = 0.10")
            && svg.contains(">\n\u{2212}20\n<")
            && svg.contains(">\n20\n<")
    );
    for (times, kind) in [("0.1", ""), ("0.1,0.2", "_strip")] {
        let usual = plotted(&[&a, "--times", times, "--out", out]);
        let name = |stem: &str| ["png", "svg"].map(|end| format!("{out}/{stem}{kind}.{end}"));
        assert_eq!(usual, [name("streamlines"), name("vorticity")].concat());
        assert!(std::fs::read_to_string(&usual[3]).unwrap().contains("t = 0.10"));
    }
    let field = plotted(&[&a, "--field", "pressure", "--out", out]);
    assert_eq!(field, ["png", "svg"].map(|end| format!("{out}/pressure_field.{end}")));
    let several = plotted(&[
        &a, "--figure", "field", "--times", "0.1,0.3", "--bodies", "speed", "--out", out,
    ]);
    assert_eq!(several, ["png", "svg"].map(|end| format!("{out}/vorticity_frames.{end}")));
    let svg = std::fs::read_to_string(&several[1]).unwrap();
    assert!(
        ["(b) t = 0.30", "fall: vorticity", "speed of particles (m/s)"]
            .iter()
            .all(|label| svg.contains(label))
    );

    for (words, said) in [
        (
            &[&a, "--figure", "vorticity", "--times", "0.1,0.2"][..],
            &["--times", "several are of a strip"][..],
        ),
        (&[&a, "--figure", "vorticity", "--field", "speed"], &["--field", "--figure field"]),
        (&[&a, "--range", "0,1"], &["--range is of the flow", "--figure field"]),
        (
            &[&a, "--field", "speed", "--range", "2,1"],
            &["--range [2.0, 1.0]", "the lower one first"],
        ),
        (&[&a, "--field", "speed", "--size", "9"], &["--size 9", "60 to 4000"]),
        (
            &[&a, "--figure", "vorticity-strip", "--times", "0.1,0.11,0.12"][..],
            &["7 snapshots are too few for 3", "output.fields.every_time"][..],
        ),
        (&[&a, "--figure", "vorticity", "--times", "99"], &["--times 99", "from t = 0 to 0.3 s"]),
        (&[&a, "--field", "speed", "--times", "0.1,99"], &["--times 99", "from t = 0 to 0.3 s"]),
        (&[&a, "--figure", "profile"], &["profile needs statistics"]),
        (&[&a, "--figure", "probes"], &["probes needs a [[probe]]"]),
        (&[&a, "--figure", "drag"], &["drag needs a measure of kind \"drag_coefficient\""]),
        (&[&a, "--figure", "paths", "--times", "0.1"], &["--times", "vorticity-strip"]),
        (&[&a, "--times", "0.1", "--range", "0,1"], &["--times", "--figure field"]),
        (&[&a, "--plane", "z=0.1"], &["--plane z=0.1", "in 2D"]),
        (&[&a, "--interval", "40"], &["--interval", "--figure vorticity-strip"]),
        (
            &[&a, "--figure", "vorticity-strip", "--interval", "-40"],
            &["--interval -40", "positive"],
        ),
        (
            &[&a, "--figure", "vorticity-strip", "--interval", "0.001"],
            &["every 0.001 1/s", "too many", "--interval "],
        ),
        (
            &[&a, "--figure", "vorticity-strip", "--window", "0.2,0.3,0,1"],
            &["--window", "0.1 m x 0.15 m"],
        ),
        (&[&a, "--figure", "vorticity-strip", "--window", "0.2,0.3"], &["--window", "X0,X1,Y0,Y1"]),
        (&[&a, "--figure", "vorticity-stripe"], &["'vorticity-stripe'", "vorticity-strip"]),
        (
            &[&a, &b, "--figure", "streamlines", "--out", out],
            &["--out", "streamlines is of one run"],
        ),
        (&[&a, "--figure", "columns"], &["--columns and --figure columns go together"]),
        (&[&a, "--over", "y"], &["--over is of --columns"]),
        (
            &[&a, "--columns", "vx,spin"],
            &["no table of", "has vx and spin", "particles.csv: step, time, id"],
        ),
    ] {
        let output = mics(&[&["plot"], words].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {message}");
        assert!(said.iter().all(|part| message.contains(part)), "{words:?}: {message}");
    }
}

#[test]
fn figures_of_forces_speeds_and_paths_choose_particles() {
    let dir = tempfile::tempdir().unwrap();
    let disc = |name: &str, x: f64, y: f64, density: f64| {
        format!(
            "{{ {name}shape = {{ disc = {{ diameter = 0.02 }} }}, density = {density:?}, \
                position = [{x:?}, {y:?}] }}"
        )
    };
    // The last one leaves through the periodic side and comes in again.
    let all = [
        disc("name = \"stone\", material = \"steel\", ", 0.02, 0.1, 1200.0),
        disc("name = \"grain\", ", 0.05, 0.1, 1300.0),
        disc("name = \"grain\", ", 0.075, 0.1, 1300.0),
        disc("velocity = [0.3, 0.0], ", 0.085, 0.125, 1200.0),
    ];
    let case = FALL
        .replace("west = \"wall\", east = \"wall\"", "west = \"periodic\", east = \"periodic\"")
        .lines()
        .map(|line| if line.starts_with("particle") { format!("particle = [{}]", all.join(", \
            ")) } else { line.to_owned() } + "\n")
        .collect::<String>();
    let (file, out) = (dir.path().join("four.toml"), dir.path().join("four"));
    std::fs::write(&file, case).unwrap();
    let summary = run(&file, &out, &["--set", "time.end=0.1", "--set", "output.figures=true"]);
    assert!(
        summary["stages_ns_per_cell_step"]["mixing"].is_null()
            && summary["stages_ns_per_cell_step"]["walls"].is_f64()
    );
    let svg =
        |name: &str| std::fs::read_to_string(out.join(format!("figures/{name}.svg"))).unwrap();
    let shows = |name: &str, labels: &[&str]| {
        let svg = svg(name);
        labels.iter().for_each(|label| {
            assert!(svg.contains(&format!(">\n{label}\n<")), "{name} lacks {label}")
        });
    };
    let names = ["stone", "grain 1", "grain 2", "particle 3"];
    for (name, label) in [
        ("forces", "force along y (N/m)"),
        ("speeds", "velocity along y (m/s)"),
        ("paths", "x/d, d = 0.02 m"),
    ] {
        shows(name, &[&names[..], &[label]].concat());
    }
    assert!(!svg("forces").contains("(19)"));
    shows("vorticity", &["0", "1", "2", "3"]);
    // Its way in the box jumps, that of the path does not.
    let rows = crate::support::columns(&out.join("particles.csv"));
    let last = |name: &str| *rows[name].last().unwrap();
    assert!(
        rows["id"].last() == Some(&3.0) && (last("path_x") - last("x") - 0.1).abs() < 1e-12,
        "{}",
        last("x")
    );

    let folder = out.to_str().unwrap();
    plotted(&[folder, "--figure", "forces,speeds,paths", "--particle", "stone"]);
    shows(
        "forces",
        &[
            "fall: force on stone",
            "force along y (N/m)",
            "fluid, in all",
            "pressure on the surface",
            "force defect",
        ],
    );
    shows("speeds", &["fall: velocity of stone", "velocity along y (m/s)"]);
    shows("paths", &["fall: path of stone"]);
    // Greys say of what a body is made, or how large it is, where that is one of few.
    shows("vorticity", &["material", "steel"]);
    // Two materials have a legend, and the speed alone a colour bar: two bitmaps.
    plotted(&[folder, "--field", "speed", "--bodies", "material"]);
    shows("speed_field", &["material", "steel"]);
    assert_eq!(svg("speed_field").matches("data:image/png").count(), 2);
    plotted(&[folder, "--figure", "speeds", "--particle", "grain,0"]);
    shows("speeds", &["grain 1", "grain 2", "stone"]);
    assert!(!svg("speeds").contains("particle 3"));
    for (words, said) in [
        (
            ["--figure", "paths", "--particle", "ston"],
            "no particle has the name \"ston\"; did you mean `stone`?",
        ),
        (
            ["--figure", "paths", "--particle", "4"],
            "there is no particle 4: the case has 4, counted from 0",
        ),
        (["--figure", "vorticity", "--particle", "0"], "--figure paths, forces, torques or speeds"),
        (["--figure", "solids", "--bodies", "size"], "solids needs three dimensions"),
        (["--figure", "solids", "--eye", "0,0,0"], "give a direction X,Y,Z"),
        (["--figure", "forces", "--eye", "1,0,0"], "--eye is of --figure solids"),
    ] {
        let output = mics(&[&["plot", folder], &words[..]].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {message}");
        assert!(message.contains(said), "{words:?}: {message}");
    }
}

#[test]
fn solids_of_a_3d_run_are_drawn_with_its_other_figures() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("shapes");
    let short = ["--set", "time.end=2e-4", "--set", "output.figures=true"];
    run(&shipped("ci/golden/shapes-3d.toml"), &out, &short);
    let svg = || std::fs::read_to_string(out.join("figures/solids.svg")).unwrap();
    assert!(svg().contains(">\nz, 0.06 m\n<") && svg().contains("diameter (m)"));
    let from_above = plotted(&[
        out.to_str().unwrap(),
        "--figure",
        "solids",
        "--eye=0,0,1",
        "--bodies",
        "material",
    ]);
    assert_eq!(from_above.len(), 2);
    // The upright edges are seen end on.
    assert!(!svg().contains("z, 0.06 m") && svg().contains("x, 0.08 m"));
}

#[test]
fn unfinished_run_is_plotted_with_a_note() {
    let dir = tempfile::tempdir().unwrap();
    let more = [
        "--set",
        "particle.0.motion=\"fixed\"",
        "--set",
        "time.end=0.1",
        "--set",
        "initial.velocity=[0.1, 0.0]",
    ];
    let a = fall(
        dir.path(),
        "a",
        &[&more[..], &["--set", "measure=[{ name = \"cd\", kind = \"drag_coefficient\" }]"]]
            .concat(),
    );
    // As a run that has not ended leaves it.
    let folder = Path::new(&a);
    std::fs::remove_file(folder.join("summary.json")).unwrap();
    let record = "{\"status\": \"running\", \"step\": 9, \"time\": 0.05, \"end\": 0.1, \
        \"measures\": {\"cd\": 1.25}}\n";
    std::fs::write(folder.join("progress.jsonl"), record).unwrap();
    let rows = std::fs::read_to_string(folder.join("particles.csv")).unwrap();
    let torn = rows.trim_end().rsplit_once('\n').unwrap().0.to_owned() + "\n999,99.0,0,1e9,1e9";
    std::fs::write(folder.join("particles.csv"), torn).unwrap();
    let output = mics(&["plot", &a]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("has not ended: figures show it to t = 0.05 of 0.1 s"), "{said}");
    let listed = String::from_utf8_lossy(&output.stdout);
    for name in ["vorticity.png", "forces.png", "drag_over_reynolds.png"] {
        assert!(listed.contains(name), "{listed}");
    }
}

#[test]
fn plot_refuses_folder_without_run() {
    let dir = tempfile::tempdir().unwrap();
    let output = mics(&["plot", dir.path().to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("not a run's folder") && said.contains("case.toml"), "{said}");
}
