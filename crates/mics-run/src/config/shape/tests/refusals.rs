//! Refusals of shapes: key, file and place, and the cure.

use super::{body, brick, loaded, near, refusal, stl, stone, text};

/// Refusals of one body in this many dimensions: shape, key after `particle.0.`, words.
fn refused(dimension: usize, shape: &str, key: &str, words: &str, files: &[(&str, &str)]) {
    let (found, why) = refusal(&text(dimension, &body(dimension, shape, "")), files);
    assert_eq!(found, format!("particle.0.{key}"), "{shape}: {why}");
    assert!(why.contains(words), "{shape}: {why}");
}

#[test]
fn wrong_numbers_of_shapes_are_refused_by_key() {
    let flat = |shape: &str, key: &str, words: &str| refused(2, shape, key, words, &[]);
    let solid = |shape: &str, key: &str, words: &str| refused(3, shape, key, words, &[]);
    flat("{ ellipse = { axes = [0.02, 0] } }", "shape.ellipse.axes.1", "must be positive");
    flat("{ ellipsoid = { axes = [0.02, 0.02, 0.02] } }", "shape", "this case is 2D");
    solid("{ ellipse = { axes = [0.02, 0.02] } }", "shape", "this case is 3D");
    flat(
        "{ ellipse = { axes = [0.02, 0.01], diameter = -1.0 } }",
        "shape.ellipse.diameter",
        "must be positive",
    );
    solid(
        "{ superquadric = { axes = [0.02, 0.02, 0.02], exponents = [8, 1.5] } }",
        "shape.superquadric.exponents.1",
        "from 2 (round) to 20",
    );
    flat("{ polygon = {} }", "shape.polygon", "needs exactly one of points and file");
    flat(
        "{ polygon = { points = [[0, 0], [0.02, 0], [0, 0.02]], file = \"a.csv\" } }",
        "shape.polygon",
        "exclude each other",
    );
    flat(
        "{ polygon = { points = [[0, 0], [0.02, 0], [0, 0.02]], scale = 2.0 } }",
        "shape.polygon.scale",
        "is for a file",
    );
    flat(
        "{ polygon = { points = [[0, 0], [0.02, 0], [0, 0.02]], rounding = 0.1 } }",
        "shape.polygon",
        "as large as the polygon's inner radius",
    );
    flat(
        "{ clump = { spheres = [{ at = [0, 0, 0], diameter = 1.0 }] } }",
        "shape.clump.spheres",
        "give discs",
    );
    flat("{ clump = { discs = [] } }", "shape.clump.discs", "is empty");
    flat(
        "{ clump = { discs = [{ at = [0], diameter = 1.0 }] } }",
        "shape.clump.discs.0.at",
        "a 2D case needs 2 numbers",
    );
    flat(
        "{ clump = { discs = [{ at = [0, 0], diameter = 0.01 }, { at = [0.03, 0], diameter = 0.01 \
        }] } }",
        "shape.clump",
        "touches none",
    );
    flat("{ like = { particle = 0 } }", "shape.like.particle", "an earlier particle, below 0");
    flat("{ polygon = { file = \"\" } }", "shape.polygon.file", "is empty");
    solid(
        "{ polyhedron = { points = [[0, 0, 0], [0.02, 0, 0], [0, 0.02, 0], [0.02, 0.02, 0]] } }",
        "shape.polyhedron",
        "flat",
    );
}

#[test]
fn outline_that_is_not_convex_or_crosses_itself_is_refused_by_corner() {
    let dart = "[[0, 0], [0.02, 0], [0.005, 0.005], [0, 0.02]]";
    let bow = "[[0, 0], [0.02, 0.02], [0.02, 0], [0, 0.02]]";
    let points = |list: &str| format!("{{ polygon = {{ points = {list} }} }}");
    refused(2, &points(dart), "shape.polygon.points.2", "not convex here", &[]);
    refused(2, &points(bow), "shape.polygon.points.2", "crosses itself", &[]);
    refused(
        2,
        &points("[[0, 0], [0.02, 0], [0.02, 0], [0, 0.02]]"),
        "shape.polygon.points.2",
        "lies on the one before",
        &[],
    );
    refused(
        2,
        &points("[[0, 0], [0.02, 0], [0.01, 0]]"),
        "shape.polygon.points.0",
        "on a line",
        &[],
    );
    refused(2, &points("[[0, 0], [0.02, 0]]"), "shape.polygon.points.1", "3 or more", &[]);
    let file = "{ polygon = { file = \"pts.csv\" } }";
    let of = |text: &str, words: &str| {
        refused(2, file, "shape.polygon.file", words, &[("pts.csv", text)]);
    };
    of("x,y\n0,0\n0.02,0\n0.005,0.005\n0,0.02\n", "pts.csv:4: the outline is not convex here");
    of("x,y\n# a comment\n0,0\n0.02,0.02\n0.02,0\n0,0.02\n", "pts.csv:5: the outline crosses");
    of("", "pts.csv:1: the header must be x,y");
    of("x,y\n", "pts.csv: lists no corners");
    of("x,y\n0,a\n", "pts.csv:2: column `y` must be a finite number, not \"a\"");
    of("0,0\n0.02,0\n", "the header must be x,y, not \"0,0\"");
    refused(2, file, "shape.polygon.file", "pts.csv: there is no such file", &[]);
}

#[test]
fn surface_that_is_open_empty_or_missing_is_refused_by_file() {
    let shape = "{ polyhedron = { file = \"stone.stl\", scale = 0.001 } }";
    let of = |text: &str, words: &str| {
        refused(3, shape, "shape.polyhedron.file", words, &[("stone.stl", text)]);
    };
    let whole = brick([20.0, 15.0, 10.0]);
    of(&stl(&whole[1..]), "stone.stl: the surface is open: 3 edges");
    let mut twisted = whole.clone();
    twisted[3].swap(0, 1);
    of(&stl(&twisted), "disagree about which side is outside");
    of("", "stone.stl: ");
    of("solid s\nendsolid s\n", "stone.stl: has no triangles");
    refused(3, shape, "shape.polyhedron.file", "stone.stl: there is no such file", &[]);
    let balls = "{ clump = { file = \"balls.csv\" } }";
    let rows = "x,y,z,diameter\n0,0,0,0\n";
    let words = "balls.csv:2: column `diameter` must be positive";
    refused(3, balls, "shape.clump.file", words, &[("balls.csv", rows)]);
}

#[test]
fn surface_inside_out_is_turned_and_said() {
    let mut turned = brick([20.0, 15.0, 10.0]);
    turned.iter_mut().for_each(|corners| corners.swap(1, 2));
    let shape = "{ polyhedron = { file = \"stone.stl\", scale = 0.001 } }";
    let files = [("stone.stl", stl(&turned))];
    let files = files.each_ref().map(|(name, text)| (*name, text.as_str()));
    let loaded = loaded(&text(3, &body(3, shape, "")), &files).unwrap();
    near(loaded.case.particle[0].shape.volume(), 3e-6);
    assert_eq!(loaded.notes.len(), 1);
    assert!(
        loaded.notes[0].contains("stone.stl: the surface was inside out"),
        "{:?}",
        loaded.notes
    );
}

#[test]
fn millimetres_for_metres_are_refused() {
    let shape = "{ polyhedron = { file = \"stone.stl\" } }";
    let words = "is 26.9258 m long, and the box 0.2 m: if its file is in mm, set scale = 0.001";
    refused(3, shape, "shape", words, &[("stone.stl", &stone())]);
    let shape = "{ polyhedron = { file = \"stone.stl\", scale = 1e-6 } }";
    refused(3, shape, "shape", "which is 8.62e-3 cells", &[("stone.stl", &stone())]);
    let swarm = "[[swarm]]\ncount = 2\nregion = { min = [0, 0], max = [0.2, 0.2] }\n\
        shape = { ellipse = { axes = [20, 10] } }\n";
    assert_eq!(refusal(&text(2, swarm), &[]).0, "swarm.0.shape");
}

#[test]
fn orientations_of_other_dimension_are_refused() {
    let of = |dimension: usize, orientation: &str| {
        let shape = [
            "{ ellipse = { axes = [0.02, 0.01] } }",
            "{ ellipsoid = { axes = [0.02, 0.01, 0.01] } }",
        ][dimension - 2];
        let more = format!("orientation = {orientation}");
        refusal(&text(dimension, &body(dimension, shape, &more)), &[])
    };
    assert!(of(3, "30").1.contains("in 3D; this case is 3D"));
    assert!(of(2, "{ axis = [0, 0, 1], degrees = 30 }").1.contains("this case is 2D"));
    let (key, why) = of(3, "{ axis = [0, 0, 0], degrees = 30 }");
    assert_eq!(key, "particle.0.orientation.axis");
    assert!(why.contains("has no length"), "{why}");
    let (key, why) = of(3, "{ quaternion = [1, 1, 0, 0] }");
    assert_eq!(key, "particle.0.orientation.quaternion");
    assert!(why.contains("must have the length 1, not 1.4142"), "{why}");
    assert!(of(2, "\"up\"").1.contains("an orientation is degrees in 2D"));
}

#[test]
fn wrong_shapes_of_swarms_are_refused_by_key() {
    let swarm = |more: &str| {
        let keys = "[[swarm]]\ncount = 2\nregion = { min = [0, 0], max = [0.2, 0.2] }\n";
        refusal(&text(2, &format!("{keys}{more}\n")), &[])
    };
    let ellipse = "{ ellipse = { axes = [0.02, 0.01] } }";
    let (key, why) = swarm(&format!("shape = {ellipse}\nshapes = [{ellipse}]"));
    assert!(key == "swarm.0.shapes" && why.contains("exclude each other"), "{key}: {why}");
    assert_eq!(swarm("shapes = []").0, "swarm.0.shapes");
    assert_eq!(swarm("shapes = [{ share = 2 }]").0, "swarm.0.shapes.0");
    let (key, _) = swarm("shapes = [{ ellipse = { axes = [0.02, 0.01] }, share = 0 }]");
    assert_eq!(key, "swarm.0.shapes.0.share");
    assert_eq!(swarm("shape = { like = { particle = 0 } }").0, "swarm.0.shape");
    assert_eq!(
        swarm("shape = { ellipse = { axes = [0.02, -1] } }").0,
        "swarm.0.shape.ellipse.axes.1"
    );
    let (key, why) = swarm("");
    assert!(key == "swarm.0.diameter" && why.contains("(or a shape)"), "{key}: {why}");
}
