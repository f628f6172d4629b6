//! Obstacles from case files: what is read, what is written, what is refused.

use crate::config::shape::tests::{loaded, refusal, text};
use crate::config::{Case, Motion, Wall, written};
use mics_shapes::Shape;

const CUBE: &str = "points = [[0.05, 0.05, 0.05], [0.15, 0.05, 0.05], [0.15, 0.15, 0.05], \
    [0.05, 0.15, 0.05], [0.05, 0.05, 0.15], [0.15, 0.05, 0.15], [0.15, 0.15, 0.15], \
    [0.05, 0.15, 0.15]]";
const FACES: &str = "triangles = [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], \
    [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]]";

fn obstacle(keys: &str) -> String {
    format!("[[obstacle]]\n{keys}\n")
}

/// A case with one obstacle, read and written and read again.
fn case(dimension: usize, keys: &str, files: &[(&str, &str)]) -> Case {
    let case = loaded(&text(dimension, &obstacle(keys)), files).unwrap_or_else(|e| panic!("{e}"));
    let case = case.case;
    // The files are gone by now. A run that goes on compares the texts.
    let again = written(&case.to_toml()).unwrap();
    assert_eq!(again, case, "{}", case.to_toml());
    assert_eq!(again.to_toml(), case.to_toml());
    case
}

fn wall(dimension: usize, keys: &str, files: &[(&str, &str)]) -> Wall {
    case(dimension, keys, files).obstacle[0].wall().clone()
}

#[test]
fn polygon_may_be_concave_and_has_holes_where_outlines_lie_within_others() {
    let l = "polygon = { points = [[0.05, 0.05], [0.15, 0.05], [0.15, 0.1], [0.1, 0.1], \
        [0.1, 0.15], [0.05, 0.15]] }";
    let l = wall(2, l, &[]);
    assert!((l.geometry().volume() - 0.0075).abs() < 1e-12);
    // About the centre of its area across, the middle of the box along the period.
    assert!((l.centre()[0] - 0.1).abs() < 1e-12 && (l.centre()[1] - 0.275 / 3.0).abs() < 1e-9);
    let outlines = "outline,x,y\n1,0.02,0.02\n1,0.02,0.18\n1,0.18,0.18\n1,0.18,0.02\n\
        2,0.05,0.05\n2,0.15,0.05\n2,0.15,0.15\n2,0.05,0.15\n";
    let ring = wall(2, "polygon = { file = \"ring.csv\" }", &[("ring.csv", outlines)]);
    assert!((ring.geometry().volume() - (0.16 * 0.16 - 0.01)).abs() < 1e-12);
    assert!(ring.nearest(&[0.1, 0.1]).distance > 0.04);
    assert!((ring.thickness() - 0.03).abs() < 1e-9, "{}", ring.thickness());
}

#[test]
fn surface_is_read_from_file_and_from_numbers_and_moved() {
    let listed = format!("surface = {{ {CUBE}, {FACES} }}");
    let cube = wall(3, &listed, &[]);
    assert!((cube.geometry().volume() - 1e-3).abs() < 1e-12);
    assert!((cube.nearest(&[0.1, 0.1, 0.18]).distance - 0.03).abs() < 1e-12);
    let moved = wall(3, &(listed + "\nposition = [0.0, 0.0, 0.02]"), &[]);
    assert!((moved.nearest(&[0.1, 0.1, 0.18]).distance - 0.01).abs() < 1e-12);
}

#[test]
fn line_of_heights_goes_on_to_the_sides_and_round_a_period() {
    let bed = wall(2, "heights = { points = [[0.05, 0.02], [0.15, 0.06]] }", &[]);
    // Along the period from 0.06 at 0.15 down to 0.02 at 0.25.
    let area = 0.2 * 0.04;
    assert!((bed.geometry().volume() - area).abs() < 1e-9 * area, "{}", bed.geometry().volume());
    assert!(bed.nearest(&[0.0, 0.05]).distance > 0.0 && bed.nearest(&[0.1, 0.03]).distance < 0.0);
    let closed = text(2, &obstacle("heights = { points = [[0.05, 0.02], [0.15, 0.06]] }"))
        .replace("\"periodic\"", "\"wall\"");
    let bed = loaded(&closed, &[]).unwrap().case.obstacle[0].wall().clone();
    // Level beyond both ends.
    assert!((bed.geometry().volume() - area).abs() < 1e-9 * area);
    assert!((bed.nearest(&[0.01, 0.05]).distance - 0.03).abs() < 1e-3);
    let (key, message) =
        refusal(&text(2, &obstacle("heights = { points = [[0.0, 0.02], [0.2, 0.06]] }")), &[]);
    assert!(key == "obstacle.0.heights" && message.contains("along a period in x"), "{message}");
}

#[test]
fn rasters_of_both_kinds_are_the_same_ground() {
    // z = 0.05 + 0.2 (y - 0.1) on a raster of 0.05 m; beyond its first and last rows it is level.
    let y = |j: usize| 0.025 + 0.05 * j as f64;
    let z = |j: usize| 0.05 + 0.2 * (y(j) - 0.1);
    let mut rows = "x,y,z\n".to_owned();
    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
        rows += &format!("{},{},{}\n", 0.025 + 0.05 * i as f64, y(j), z(j));
    }
    let head = "ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 50\nNODATA_value -9999\n";
    let line = |j: usize| format!("{0} {0} {0} {0}\n", 1e3 * z(j));
    let grid = head.to_owned() + &(0..4).rev().map(line).collect::<String>();
    let csv = wall(3, "heights = { file = \"bed.csv\" }", &[("bed.csv", &rows)]);
    let asc = wall(3, "heights = { file = \"bed.asc\", scale = 0.001 }", &[("bed.asc", &grid)]);
    let exact = 0.2 * 0.2 * 0.05;
    for bed in [&csv, &asc] {
        assert!((bed.geometry().volume() - exact).abs() < 1e-9, "{}", bed.geometry().volume());
        let slope = 1.0_f64.hypot(0.2);
        let above = bed.nearest(&[0.07, 0.1, 0.06]).distance;
        assert!((above - 0.01 / slope).abs() < 1e-9, "{above}");
    }
    let (key, message) =
        refusal(&text(3, &obstacle("heights = { file = \"bed.asc\" }")), &[("bed.asc", &grid)]);
    assert!(
        key == "obstacle.0.heights.file" && message.contains("scale = 0.001"),
        "{key} {message}"
    );
    let torn = rows.replace("0.025,0.125,", "0.026,0.125,");
    let (_, message) =
        refusal(&text(3, &obstacle("heights = { file = \"bed.csv\" }")), &[("bed.csv", &torn)]);
    assert!(message.starts_with("bed.csv: is no raster"), "{message}");
    let hole = grid.replacen("65 65 65 65", "65 -9999 65 65", 1);
    let (_, message) = refusal(
        &text(3, &obstacle("heights = { file = \"bed.asc\", scale = 0.001 }")),
        &[("bed.asc", &hole)],
    );
    assert!(message.starts_with("bed.asc:") && message.contains("no height"), "{message}");
}

#[test]
fn what_is_wrong_with_an_obstacle_is_named() {
    let square = "[[0.05, 0.05], [0.15, 0.05], [0.15, 0.15], [0.05, 0.15]]";
    let polygon = format!("polygon = {{ points = {square} }}");
    let cases = [
        (2, "name = \"pier\"".to_owned(), "obstacle.0", "needs exactly one of polygon"),
        (3, polygon.clone(), "obstacle.0.polygon", "is for 2D"),
        (
            2,
            "polygon = { points = [[0, 0], [1, 1], [1, 0], [0, 1]] }".into(),
            "obstacle.0.polygon.points.2",
            "crosses itself",
        ),
        (
            2,
            "polygon = { points = [[5, 5], [15, 5], [15, 15]] }".into(),
            "obstacle.0.polygon",
            "mm",
        ),
        (
            2,
            "polygon = { points = [[0.05, 0.05], [0.052, 0.05], [0.05, 0.052]] }".into(),
            "obstacle.0.polygon",
            "cells",
        ),
        (2, polygon.clone() + "\ncentre = [0.05, 0.1]", "obstacle.0.centre.0", "periodic"),
        (
            2,
            polygon.clone() + "\nmotion = { prescribed = { velocity = [0.0, 1.0] } }",
            "obstacle.0.motion",
            "stay in the box",
        ),
    ];
    refused(&cases);
    let open = FACES.replace(", [3, 4, 7]", "");
    let (_, message) =
        refusal(&text(3, &obstacle(&format!("surface = {{ {CUBE}, {open} }}"))), &[]);
    assert!(message.contains("the surface is open"), "{message}");
}

/// Dimension, keys, the key that is refused and a part of the message.
fn refused(cases: &[(usize, String, &str, &str)]) {
    for (dimension, keys, key, part) in cases {
        let (found, message) = refusal(&text(*dimension, &obstacle(keys)), &[]);
        assert!(found == *key && message.contains(part), "{keys}: {found}: {message}");
    }
}

#[test]
fn corners_within_rounding_of_a_side_read_back_as_they_ran() {
    // Heights and points a millionth of the box from its sides.
    let line = "heights = { points = [[0.05, 1e-8], [0.1, 0.04], [0.15, 0.2000000001]] }";
    case(2, line, &[]);
    let raster = "x,y,z\n0.05,0.05,0.03\n0.1500000001,0.05,1e-9\n0.05,0.15,0.06\n\
        0.1500000001,0.15,0.05\n";
    case(3, "heights = { file = \"bed.csv\" }", &[("bed.csv", raster)]);
    let near = CUBE.replace("0.05]", "1e-9]").replace("0.15, 0.15, 0.15]", "0.15, 0.2, 0.15]");
    case(3, &format!("surface = {{ {near}, {FACES} }}"), &[]);
}

#[test]
fn numbers_of_another_unit_or_place_are_refused_with_file_and_cure() {
    let stl = |length: f64| {
        let mut text = "solid cube\n".to_owned();
        let numbers: Vec<Vec<usize>> = FACES[12..]
            .split("], [")
            .map(|t| t.split(',').map(|n| n.trim_matches(['[', ']', ' ']).parse().unwrap()))
            .map(Iterator::collect)
            .collect();
        for corners in numbers {
            text += "facet normal 0 0 0\nouter loop\n";
            for k in corners {
                let ends = [[0, 3, 4, 7].contains(&k), [0, 1, 4, 5].contains(&k), k < 4];
                let [x, y, z] = ends.map(|low| if low { 0.0 } else { length });
                text += &format!("vertex {x:?} {y:?} {z:?}\n");
            }
            text += "endloop\nendfacet\n";
        }
        text + "endsolid\n"
    };
    let closed = |keys: &str| text(3, &obstacle(keys)).replace("\"periodic\"", "\"wall\"");
    let surface = |scale: &str| {
        let keys = format!("surface = {{ file = \"cube.stl\"{scale} }}\n");
        closed(&(keys + "position = [0.06, 0.06, 0.06]"))
    };
    let (key, message) = refusal(&surface(""), &[("cube.stl", &stl(40.0))]);
    assert_eq!(key, "obstacle.0.surface.file");
    for part in ["cube.stl: is 200 times as long as the box", "scale = 0.001"] {
        assert!(message.contains(part), "{message}");
    }
    let scaled = loaded(&surface(", scale = 0.001"), &[("cube.stl", &stl(40.0))]).unwrap();
    assert!(scaled.notes.is_empty(), "{:?}", scaled.notes);
    // A surface that is drawn on beyond the box may be much longer than that, and is said.
    let long = loaded(&surface(""), &[("cube.stl", &stl(4.0))]).unwrap();
    assert!(long.notes[0].contains("is 20 times as long as the box"), "{:?}", long.notes);

    let raster = |x: f64, n: usize| {
        let rows = "0.02 ".repeat(n) + "\n";
        let head = format!("ncols {n}\nnrows {n}\nxllcorner {x:?}\nyllcorner 5870000\n");
        head + "cellsize 0.1\n" + &rows.repeat(n)
    };
    let bed = |at: &str| closed(&format!("heights = {{ file = \"h.asc\" }}\n{at}"));
    let (key, message) = refusal(&bed(""), &[("h.asc", &raster(384000.0, 3))]);
    assert_eq!(key, "obstacle.0.heights.file");
    for part in ["h.asc: goes from 384000.05 to 384000.25 m along x", "position"] {
        assert!(message.contains(part), "{message}");
    }
    // One that is larger than the box, and one that covers a part of it.
    for (position, n) in [("[-384001.0, -5870001.0, 0.0]", 30), ("[-383999.9, -5870000.2, 0.0]", 3)]
    {
        let moved = format!("position = {position}");
        loaded(&bed(&moved), &[("h.asc", &raster(384000.0, n))]).unwrap();
    }
    let line = "heights = { points = [[5.0, 0.02], [6.0, 0.06]] }";
    let (key, message) = refusal(&text(2, &obstacle(line)), &[]);
    assert!(key == "obstacle.0.heights" && message.contains("along x"), "{key} {message}");
}

#[test]
fn directory_in_place_of_a_file_is_called_one() {
    for (dimension, keys) in [(3, "surface"), (3, "heights"), (2, "polygon")] {
        let named = format!("{keys} = {{ file = \".\" }}");
        let (key, message) = refusal(&text(dimension, &obstacle(&named)), &[]);
        assert_eq!(key, format!("obstacle.0.{keys}.file"));
        assert!(message.contains("is a directory: name a file in it"), "{message}");
    }
}

#[test]
fn turning_obstacle_in_a_periodic_box_turns_about_its_centre_of_volume() {
    // Periodic along x.
    let paddle = "motion = { prescribed = { spin = 2.0 } }\npolygon = { points = [[0.03, 0.08], \
        [0.05, 0.08], [0.05, 0.12], [0.03, 0.12]] }";
    let found = case(2, paddle, &[]);
    let wall = found.obstacle[0].wall();
    assert!((wall.centre()[0] - 0.04).abs() < 1e-12 && (wall.centre()[1] - 0.1).abs() < 1e-12);
    let said = &found.describe_bodies()[0].words;
    assert!(said.contains("turns about (0.04, 0.1) m"), "{said}");
    let [low, high] = wall.bounds();
    assert!((low.x - 0.03).abs() < 1e-12 && (high.x - 0.05).abs() < 1e-12, "{low} {high}");
    for (x, y, exact) in [(0.04, 0.15, 0.03), (0.11, 0.1, 0.06), (0.035, 0.1, -0.005)] {
        assert!((wall.nearest(&[x, y]).distance - exact).abs() < 1e-12, "{x} {y}");
    }
    let given = case(2, &format!("{paddle}\ncentre = [0.045, 0.1]"), &[]);
    assert_eq!(given.obstacle[0].wall().centre(), [0.045, 0.1]);
}

#[test]
fn measures_and_particles_beside_an_obstacle_are_checked() {
    let square = "[[0.05, 0.05], [0.15, 0.05], [0.15, 0.15], [0.05, 0.15]]";
    let polygon = format!("polygon = {{ points = {square} }}");
    let disc = |d: f64| {
        let at = "position = [0.16, 0.1]";
        format!("\n[[particle]]\nshape = {{ disc = {{ diameter = {d} }} }}\n{at}")
    };
    let beside = text(2, &obstacle(&(polygon.clone() + &disc(0.02))));
    assert!(loaded(&beside, &[]).is_ok());
    let cases = [
        (
            2,
            polygon.clone()
                + "\n[[measure]]\nname = \"d\"\nkind = \"drag_coefficient\"\n\
            obstacle = 0\nspeed = 1.0\ndirection = [1.0, 0.0]",
            "measure.0.length",
            "length",
        ),
        (
            2,
            polygon.clone()
                + "\n[[measure]]\nname = \"d\"\nkind = \"force\"\nobstacle = \"pillar\"\n",
            "measure.0.obstacle",
            "no obstacle has the name \"pillar\"",
        ),
        (2, polygon + &disc(0.03), "obstacle.0", "particle 0 reaches 0.005"),
    ];
    refused(&cases);
}

#[test]
fn motion_and_material_come_back() {
    let keys = "name = \"paddle\"\nmaterial = \"steel\"\nmotion = { prescribed = { spin = 2.0 } }\n\
        centre = [0.1, 0.1]\npolygon = { points = [[0.09, 0.05], [0.11, 0.05], [0.11, 0.15], \
        [0.09, 0.15]] }";
    let case = case(2, keys, &[]);
    let paddle = &case.obstacle[0];
    assert_eq!((paddle.name.as_deref(), paddle.material()), (Some("paddle"), "steel"));
    assert!(matches!(&paddle.motion, Motion::Prescribed(told) if told.about() == [0.0, 0.0, 2.0]));
    assert!(case.describe_bodies()[0].words.contains("outline of 4 corners"));
}
