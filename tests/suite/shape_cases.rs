//! Bodies of any shape as a user meets them: cases that name files, runs, figures, restarts.

use crate::support::{columns, mics, run};
use std::path::{Path, PathBuf};

/// A brick of 20 x 15 x 10 mm as an STL file.
const BRICK: &str = include_str!("brick.stl");

/// A flow in 2D past bodies of all kinds.
const FLAT: &str = r#"name = "flat"
[domain]
size = [0.2, 0.1]
cells = [80, 40]
[fluid]
density = 1000.0
viscosity = 0.1
gravity = [0.0, -9.81]
[boundary]
west = "wall"
east = "wall"
south = "wall"
north = "wall"
[[particle]]
shape = { ellipse = { axes = [0.04, 0.02] } }
position = [0.03, 0.05]
orientation = 60
motion = "fixed"
[[particle]]
shape = { polygon = { file = "outline.csv", scale = 0.001, rounding = 0.002 } }
position = [0.08, 0.05]
motion = { prescribed = { spin = 5.0 } }
[[particle]]
shape = { clump = { file = "balls.csv" } }
position = [0.13, 0.06]
density = 1500.0
[[particle]]
shape = { disc = { diameter = 0.02 } }
position = [0.175, 0.05]
density = 1500.0
[time]
end = 0.004
step = 0.001
[output]
particles = { every = 1 }
checkpoint = { every_steps = 2 }
figures = false
"#;

/// A flow in 3D past bodies of all kinds.
const DEEP: &str = r#"name = "deep"
[domain]
size = [0.16, 0.08, 0.08]
cells = [40, 20, 20]
[fluid]
density = 1000.0
viscosity = 0.1
gravity = [0.0, 0.0, -9.81]
[boundary]
west = "periodic"
east = "periodic"
south = "wall"
north = "wall"
bottom = "wall"
top = "wall"
[[particle]]
shape = { polyhedron = { file = "brick.stl", scale = 0.001 } }
position = [0.02, 0.04, 0.04]
orientation = { axis = [0, 1, 0], degrees = 30 }
density = 2650.0
[[particle]]
shape = { superquadric = { axes = [0.022, 0.022, 0.022], exponents = [6, 6] } }
position = [0.06, 0.04, 0.04]
motion = "fixed"
[[particle]]
shape = { ellipsoid = { axes = [0.03, 0.02, 0.02] } }
position = [0.1, 0.04, 0.04]
orientation = { quaternion = [0.8, 0.0, 0.6, 0.0] }
motion = { prescribed = { spin = [0.0, 5.0, 0.0] } }
[[particle]]
shape.clump.spheres = [
    { at = [0, 0, 0], diameter = 0.02 },
    { at = [0.01, 0, 0], diameter = 0.016 },
]
position = [0.135, 0.04, 0.04]
density = 2650.0
[time]
end = 0.004
step = 0.001
[output]
particles = { every = 1 }
checkpoint = { every_steps = 2 }
figures = false
"#;

/// Writes a case with the files that it names into a folder.
fn written(folder: &Path, text: &str) -> PathBuf {
    for (name, content) in [
        ("outline.csv", "x,y\n# mm\n0,0\n30,0\n30,20\n10,25\n"),
        ("balls.csv", "x,y,diameter\n0,0,0.02\n0.012,0,0.016\n"),
        ("brick.stl", BRICK),
        ("case.toml", text),
    ] {
        std::fs::write(folder.join(name), content).unwrap();
    }
    folder.join("case.toml")
}

/// Output of a command, which must succeed.
fn printed(words: &[&str]) -> String {
    let output = mics(words);
    let said =
        String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned();
    assert!(output.status.success(), "{words:?}: {said}");
    said
}

/// Message of `mics check` on a case that it must refuse.
fn refused(case: &Path) -> String {
    let output = mics(&["check", case.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn run_of_any_shape_stands_without_its_files() {
    for (text, shapes) in [
        (FLAT, ["ellipse", "polygon", "clump", "disc"]),
        (DEEP, ["polyhedron", "superquadric", "ellipsoid", "clump"]),
    ] {
        let dir = tempfile::tempdir().unwrap();
        let case = written(dir.path(), text);
        let said = printed(&["check", case.to_str().unwrap()]);
        assert!(shapes[..3].iter().all(|name| said.contains(name)), "{said}");
        assert!(said.contains("thinnest"), "{said}");
        let out = dir.path().join("run");
        run(&case, &out, &[]);
        let roster = std::fs::read_to_string(out.join("bodies.csv")).unwrap();
        assert!(shapes.iter().all(|name| roster.contains(&format!(",{name},"))), "{roster}");
        let bodies = newest_bodies(&out);
        let cells = if text == FLAT { "NumberOfLines=\"0\"" } else { "NumberOfPolys=\"0\"" };
        assert!(bodies.contains("NumberOfVerts=\"4\""), "centres");
        assert!(!bodies.contains(cells), "cells of the surfaces");
        for name in ["outline.csv", "balls.csv", "brick.stl", "case.toml"] {
            std::fs::remove_file(dir.path().join(name)).unwrap();
        }
        let out = out.to_str().unwrap();
        printed(&["plot", out]);
        printed(&["report", out]);
        let svg = std::fs::read_dir(dir.path().join("run/figures")).unwrap();
        assert!(svg.count() > 1);
    }
}

/// The newest file with bodies of a run.
fn newest_bodies(out: &Path) -> String {
    let all = std::fs::read_dir(out.join("fields")).unwrap().map(|entry| entry.unwrap().path());
    let newest = all.filter(|path| path.extension().is_some_and(|e| e == "vtp")).max();
    std::fs::read_to_string(newest.unwrap()).unwrap()
}

#[test]
fn restart_of_any_shape_is_exact() {
    for text in [FLAT, DEEP] {
        let dir = tempfile::tempdir().unwrap();
        let case = written(dir.path(), text);
        let (whole, parts) = (dir.path().join("whole"), dir.path().join("parts"));
        run(&case, &whole, &[]);
        run(&case, &parts, &["--set", "time.end=0.002"]);
        run(&case, &parts, &["--resume"]);
        let rows = |out: &Path| std::fs::read_to_string(out.join("particles.csv")).unwrap();
        assert_eq!(rows(&whole), rows(&parts));
    }
}

#[test]
fn initial_from_restores_shape_and_orientation() {
    let dir = tempfile::tempdir().unwrap();
    let case = written(dir.path(), DEEP);
    let (first, second) = (dir.path().join("first"), dir.path().join("second"));
    run(&case, &first, &[]);
    let head = &DEEP[..DEEP.find("[[particle]]").unwrap()];
    let tail = &DEEP[DEEP.find("[time]").unwrap()..];
    let text = format!("{head}[initial]\nfrom = {:?}\n{tail}", first.to_str().unwrap());
    let case = dir.path().join("on.toml");
    std::fs::write(&case, text).unwrap();
    run(&case, &second, &[]);
    let [before, after] = [&first, &second].map(|out| columns(&out.join("particles.csv")));
    let last = |name: &str| before[name][before[name].len() - 4..].to_vec();
    for name in ["qw", "qx", "qy", "qz", "x", "z"] {
        let begun = &after[name][..4];
        assert!(
            last(name).iter().zip(begun).all(|(a, b)| (a - b).abs() < 1e-12),
            "{name}: {:?} {begun:?}",
            last(name)
        );
    }
    assert!(last("qy")[2] > 0.6, "it has turned on: {:?}", last("qy"));
}

#[test]
fn check_names_bad_file_and_place() {
    let dir = tempfile::tempdir().unwrap();
    let case = written(dir.path(), FLAT);
    let with = |name: &str, content: &str| {
        written(dir.path(), FLAT);
        std::fs::write(dir.path().join(name), content).unwrap();
        refused(&case)
    };
    let dart = with("outline.csv", "x,y\n0,0\n30,0\n10,10\n0,30\n");
    assert!(dart.contains("outline.csv:4: the outline is not convex here"), "{dart}");
    let bow = with("outline.csv", "x,y\n0,0\n30,30\n30,0\n0,30\n");
    assert!(bow.contains("outline.csv:4: the outline crosses itself"), "{bow}");
    let empty = with("outline.csv", "x,y\n");
    assert!(empty.contains("outline.csv: lists no corners"), "{empty}");
    let flat = with("balls.csv", "x,y,diameter\n0,0,-1\n");
    assert!(flat.contains("balls.csv:2: column `diameter` must be positive"), "{flat}");
    std::fs::remove_file(dir.path().join("balls.csv")).unwrap();
    std::fs::write(dir.path().join("outline.csv"), "x,y\n0,0\n30,0\n0,30\n").unwrap();
    let gone = refused(&case);
    assert!(gone.contains("balls.csv: there is no such file"), "{gone}");
    assert!(gone.contains("case.toml:24: particle.2.shape.clump.file"), "{gone}");
}

#[test]
fn check_names_bad_surface() {
    let dir = tempfile::tempdir().unwrap();
    let case = written(dir.path(), DEEP);
    let with = |content: &str| {
        std::fs::write(dir.path().join("brick.stl"), content).unwrap();
        refused(&case)
    };
    let first = BRICK.find("facet").unwrap();
    let second = first + BRICK[first..].find("endfacet\n").unwrap() + "endfacet\n".len();
    let open = with(&(BRICK[..first].to_owned() + &BRICK[second..]));
    assert!(open.contains("brick.stl: the surface is open"), "{open}");
    let metres = DEEP.replace(", scale = 0.001", "");
    std::fs::write(&case, metres).unwrap();
    let long = with(BRICK);
    assert!(long.contains("is 26.9258 m long") && long.contains("scale = 0.001"), "{long}");
}
