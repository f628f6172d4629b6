//! Shapes from case files: what is read, what is written, what is refused.

mod refusals;

use crate::config::{Case, Loaded, load, written};
use crate::{Error, Result};
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;

/// A case of 2 or 3 dimensions in a box of 0.2 m, periodic along x, with these further keys.
pub(in crate::config) fn text(dimension: usize, keys: &str) -> String {
    let (size, cells, lids) = match dimension {
        2 => ("[0.2, 0.2]", "[64, 64]", ""),
        _ => ("[0.2, 0.2, 0.2]", "[64, 64, 64]", "bottom = \"wall\"\ntop = \"wall\"\n"),
    };
    format!(
        "name = \"box\"\ntime.end = 1.0\ndomain = {{ size = {size}, cells = {cells} }}\n\
        fluid = {{ density = 1000.0, viscosity = 1e-3 }}\n[boundary]\nwest = \"periodic\"\n\
        east = \"periodic\"\nsouth = \"wall\"\nnorth = \"wall\"\n{lids}{keys}\n"
    )
}

fn body(dimension: usize, shape: &str, more: &str) -> String {
    let at = if dimension == 2 { "[0.1, 0.1]" } else { "[0.1, 0.1, 0.1]" };
    format!("[[particle]]\nshape = {shape}\nposition = {at}\n{more}\n")
}

/// Loads a case beside these files.
pub(in crate::config) fn loaded(text: &str, files: &[(&str, &str)]) -> Result<Loaded> {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    std::fs::write(folder.path().join("case.toml"), text).unwrap();
    load(&folder.path().join("case.toml"), &[])
}

/// A case with one body of a shape, read and written and read again.
fn case(dimension: usize, shape: &str, more: &str, files: &[(&str, &str)]) -> Case {
    let case = loaded(&text(dimension, &body(dimension, shape, more)), files).unwrap().case;
    // The files are gone by now.
    assert_eq!(written(&case.to_toml()).unwrap(), case, "{}", case.to_toml());
    case
}

/// Key, line and message of a refusal, with the name of the file cut off to its last part.
pub(in crate::config) fn refusal(text: &str, files: &[(&str, &str)]) -> (String, String) {
    match loaded(text, files) {
        Err(Error::Case { key, message, .. }) => {
            let folders = message.split_once("/case.toml").map_or(message.clone(), |s| s.0.into());
            let at = folders.find("/tmp").map(|from| {
                let path = &folders[from..];
                let end = path.find(": ").unwrap_or(path.len());
                let name = Path::new(&path[..end]).file_name().unwrap_or_default();
                folders[..from].to_owned() + &name.to_string_lossy() + &path[end..]
            });
            (key, at.unwrap_or(message))
        }
        other => panic!("expected a refusal, got {other:?}"),
    }
}

/// An ASCII STL file of triangles.
fn stl(triangles: &[[[f64; 3]; 3]]) -> String {
    let mut text = "solid s\n".to_owned();
    for corners in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in corners {
            let _ = writeln!(text, "vertex {x} {y} {z}");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid s\n"
}

/// A box with these edges by its 12 triangles.
fn brick([a, b, c]: [f64; 3]) -> Vec<[[f64; 3]; 3]> {
    let size = [a, b, c];
    let mut all = Vec::new();
    for axis in 0..3 {
        for high in [false, true] {
            let corner = |u: f64, v: f64| {
                let mut at = [0.0; 3];
                at[axis] = if high { size[axis] } else { 0.0 };
                at[(axis + 1) % 3] = u * size[(axis + 1) % 3];
                at[(axis + 2) % 3] = v * size[(axis + 2) % 3];
                at
            };
            let ring = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
            let [p, q, r, s] = ring;
            let both = if high { [[p, q, r], [p, r, s]] } else { [[p, r, q], [p, s, r]] };
            all.extend(both);
        }
    }
    all
}

/// A brick of 20 x 15 x 10 mm.
fn stone() -> String {
    stl(&brick([20.0, 15.0, 10.0]))
}

fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9 * b.abs(), "{a} {b}");
}

#[test]
fn volume_of_every_shape() {
    let of = |dimension: usize, shape: &str, files: &[(&str, &str)], volume: f64, name: &str| {
        let case = case(dimension, shape, "", files);
        let shape = &case.particle[0].shape;
        assert_eq!((shape.name(), shape.is_round(), shape.dimension()), (name, false, dimension));
        near(shape.volume(), volume);
        let d = shape.diameter();
        near(if dimension == 2 { 0.25 * PI * d * d } else { PI / 6.0 * d.powi(3) }, volume);
        assert!(shape.bounding_diameter() > d && shape.thickness() < d, "{shape:?}");
    };
    of(2, "{ ellipse = { axes = [0.02, 0.01] } }", &[], 0.25 * PI * 2e-4, "ellipse");
    let square = "[[0, 0], [0.02, 0], [0.02, 0.01], [0, 0.01]]";
    of(2, &format!("{{ polygon = {{ points = {square} }} }}"), &[], 2e-4, "polygon");
    let corners = ("square.csv", "x,y\n0,0\n# mm\n0,10\n20,10\n20,0\n");
    let file = "{ polygon = { file = \"square.csv\", scale = 0.001 } }";
    of(2, file, &[corners], 2e-4, "polygon");
    let round = format!("{{ polygon = {{ points = {square}, rounding = 0.002 }} }}");
    of(2, &round, &[], 2e-4 - (4.0 - PI) * 4e-6, "polygon");
    let pair = "{ clump = { discs = [{ at = [0, 0], diameter = 0.02 }, { at = [0.02, 0], diameter \
        = 0.02 }] } }";
    of(2, pair, &[], 2.0 * 0.25 * PI * 4e-4, "clump");
    let ellipsoid = "{ ellipsoid = { axes = [0.02, 0.015, 0.01] } }";
    of(3, ellipsoid, &[], PI / 6.0 * 3e-6, "ellipsoid");
    let brick = "{ polyhedron = { file = \"stone.stl\", scale = 0.001 } }";
    of(3, brick, &[("stone.stl", &stone())], 3e-6, "polyhedron");
    let balls = ("balls.csv", "x,y,z,diameter\n0,0,0,0.02\n0.02,0,0,0.02\n");
    of(3, "{ clump = { file = \"balls.csv\" } }", &[balls], PI / 3.0 * 8e-6, "clump");
}

#[test]
fn superquadric_lies_between_ellipsoid_and_box() {
    let of = |p: f64| {
        let shape =
            format!("{{ superquadric = {{ axes = [0.02, 0.02, 0.02], exponents = [{p}, {p}] }} }}");
        case(3, &shape, "", &[]).particle[0].shape.volume()
    };
    let ball = of(2.0);
    let round = of(4.0);
    let sharp = of(8.0);
    assert!((ball - PI / 6.0 * 8e-6).abs() < 1e-4 * ball, "{ball}");
    assert!(ball < round && round < sharp && sharp < 8e-6, "{ball} {round} {sharp}");
}

#[test]
fn diameter_scales_to_equal_volume() {
    let shape = "{ ellipsoid = { axes = [2, 1, 1], diameter = 0.02 } }";
    let scaled = &case(3, shape, "", &[]).particle[0].shape;
    assert_eq!(scaled.diameter(), 0.02);
    near(scaled.volume(), PI / 6.0 * 8e-6);
    near(scaled.bounding_diameter(), 0.02 * 4.0_f64.cbrt());
    let brick = "{ polyhedron = { file = \"stone.stl\", rounding = 1, diameter = 0.02 } }";
    let scaled = &case(3, brick, "", &[("stone.stl", &stone())]).particle[0].shape;
    assert!((scaled.volume() / (PI / 6.0 * 8e-6) - 1.0).abs() < 1e-6, "{}", scaled.volume());
}

#[test]
fn orientation_turns_body() {
    let long = "{ ellipse = { axes = [0.16, 0.04] } }";
    let turned = case(2, long, "orientation = 30", &[]);
    near(turned.particle[0].angle(), PI / 6.0);
    near(turned.particle[0].turn().angle(), PI / 6.0);
    // Upright it fits where it does not lying.
    let near_wall = |degrees: f64| {
        let keys = format!(
            "[[particle]]\nshape = {long}\nposition = [0.05, 0.05]\norientation = {degrees:?}\n"
        );
        loaded(&text(2, &keys), &[])
    };
    assert!(near_wall(0.0).is_ok(), "across periodic sides");
    let why = near_wall(90.0).unwrap_err().to_string();
    assert!(why.contains("reaches from -0.03 to 0.13 m along y"), "{why}");
    let axis = "orientation = { axis = [0, 0, 2], degrees = 90 }";
    let shape = "{ ellipsoid = { axes = [0.1, 0.02, 0.02] } }";
    let turned = case(3, shape, axis, &[]);
    let along = turned.particle[0].turn() * nalgebra::Vector3::x();
    assert!((along - nalgebra::Vector3::y()).norm() < 1e-12, "{along}");
    let solid = turned.particle[0].shape.solid().unwrap();
    near(solid.reach(1, &turned.particle[0].turn())[1], 0.05);
    near(solid.reach(0, &turned.particle[0].turn())[0], 0.01);
    let quaternion = "orientation = { quaternion = [0.6, 0.0, 0.8, 0.0] }";
    near(case(3, shape, quaternion, &[]).particle[0].turn().w, 0.6);
}

#[test]
fn bodies_like_another_share_its_shape() {
    let stones = "[[particle]]\nshape = { polyhedron = { file = \"stone.stl\", scale = 0.001 } }\n\
        position = [0.03, 0.03, 0.03]\n\
        [[particle]]\nshape = { like = { particle = 0 } }\nposition = [0.08, 0.03, 0.03]\n\
        [[particle]]\nshape = { like = { particle = 1, diameter = 0.03 } }\n\
        position = [0.13, 0.03, 0.03]\n\
        [[particle]]\nshape = { polyhedron = { file = \"stone.stl\", scale = 0.001 } }\n\
        position = [0.18, 0.03, 0.03]\n";
    let case = loaded(&text(3, stones), &[("stone.stl", &stone())]).unwrap().case;
    let geometry = |k: usize| case.particle[k].shape.solid().unwrap().geometry().clone();
    assert!(std::sync::Arc::ptr_eq(&geometry(0), &geometry(1)));
    assert!(std::sync::Arc::ptr_eq(&geometry(0), &geometry(3)));
    assert_eq!(case.particle[2].shape.diameter(), 0.03);
    let text = case.to_toml();
    assert_eq!(text.matches("points = ").count(), 2, "once as it is and once scaled: {text}");
    assert_eq!(written(&text).unwrap(), case);
    assert!(!text.contains("stone.stl"), "{text}");
}

#[test]
fn swarm_has_its_shares_of_shapes() {
    let swarm = "[[swarm]]\ncount = 12\nregion = { min = [0, 0, 0], max = [0.2, 0.2, 0.2] }\n\
        diameter = { uniform = [0.015, 0.02] }\ndensity = 2650.0\nshapes = [\n\
        { ellipsoid = { axes = [3, 2, 1] }, share = 3 },\n\
        { superquadric = { axes = [1, 1, 1], exponents = [6, 6] }, share = 2 },\n\
        { sphere = { diameter = 1.0 } } ]\n";
    let case = loaded(&text(3, swarm), &[]).unwrap().case;
    let count = |name: &str| case.particle.iter().filter(|p| p.shape.name() == name).count();
    assert_eq!(["ellipsoid", "superquadric", "sphere"].map(count), [6, 4, 2]);
    for p in &case.particle {
        assert!((0.015..=0.02).contains(&p.shape.diameter()), "{p:?}");
        assert_eq!(p.orientation.is_some(), !p.shape.is_round());
    }
    assert_eq!(written(&case.to_toml()).unwrap(), case);
    let fixed = loaded(&text(3, &(swarm.to_owned() + "orientations = \"fixed\"\n")), &[]);
    assert!(fixed.unwrap().case.particle.iter().all(|p| p.orientation.is_none()));
    let as_they_are = swarm
        .replace("diameter = { uniform = [0.015, 0.02] }\n", "")
        .replace("[3, 2, 1]", "[0.03, 0.02, 0.01]")
        .replace("[1, 1, 1]", "[0.02, 0.02, 0.02]")
        .replace("diameter = 1.0", "diameter = 0.01");
    let case = loaded(&text(3, &as_they_are), &[]).unwrap().case;
    let spheres = case.particle.iter().filter(|p| p.shape.name() == "sphere");
    assert!(spheres.clone().all(|p| p.shape.diameter() == 0.01) && spheres.count() == 2);
}

#[test]
fn random_orientations_are_uniform() {
    let swarm = "[[swarm]]\ncount = 3000\nregion = { min = [0, 0, 0], max = [0.2, 0.2, 0.2] }\n\
        shape = { ellipsoid = { axes = [0.004, 0.003, 0.003] } }\n\
        feed = { rate = 10.0 }\n";
    let text = text(3, swarm).replace("[64, 64, 64]", "[256, 256, 256]");
    let case = loaded(&text, &[]).unwrap().case;
    // A direction of the body is spread evenly over the sphere: mean 0, mean squares a third each.
    let mut sums = [nalgebra::Vector3::zeros(); 2];
    for p in &case.particle {
        let along = p.turn() * nalgebra::Vector3::new(0.6, 0.0, 0.8);
        sums[0] += along / 3000.0;
        sums[1] += along.component_mul(&along) / 3000.0;
    }
    assert!(sums[0].amax() < 0.04, "{}", sums[0]);
    assert!((sums[1].add_scalar(-1.0 / 3.0)).amax() < 0.02, "{}", sums[1]);
    let angles: f64 = case.particle.iter().map(|p| p.turn().angle()).sum::<f64>() / 3000.0;
    // Mean angle of uniform rotations: pi/2 + 2/pi.
    assert!((angles - (0.5 * PI + 2.0 / PI)).abs() < 0.05, "{angles}");
}

#[test]
fn table_has_shapes_and_orientations() {
    let swarm = "[[swarm]]\nfrom = \"bodies.csv\"\nshapes = [{ ellipse = { axes = [2, 1] } }, { \
        polygon = { points = [[0, 0], [0.02, 0], [0.01, 0.02]] } }]\n";
    let rows = "x,y,diameter,shape,angle\n0.05,0.05,0.02,0,0.5\n0.1,0.1,0.03,1,1.5\n";
    let case = loaded(&text(2, swarm), &[("bodies.csv", rows)]).unwrap().case;
    let said: Vec<_> = case.particle.iter().map(|p| (p.shape.name(), p.shape.diameter())).collect();
    assert_eq!(said, [("ellipse", 0.02), ("polygon", 0.03)]);
    near(case.particle[1].angle(), 1.5);
    let refused = |rows: &str| refusal(&text(2, swarm), &[("bodies.csv", rows)]).1;
    assert!(refused("x,y\n0.1,0.1\n").contains("bodies.csv:1: column `shape` is missing"));
    let why = refused("x,y,shape\n0.1,0.1,2\n");
    assert!(
        why.contains("bodies.csv:2: column `shape` must be a number of `shapes`, 0 to 1"),
        "{why}"
    );
    let turned = "[[swarm]]\nfrom = \"bodies.csv\"\nshape = { ellipsoid = { axes = [0.02, 0.01, \
        0.01] } }\n";
    let rows = "x,y,z,qw,qx,qy,qz\n0.1,0.1,0.1,0.6,0,0,0.8\n";
    let case = loaded(&text(3, turned), &[("bodies.csv", rows)]).unwrap().case;
    near(case.particle[0].turn().k, 0.8);
    let rows = rows.replace("0.8\n", "1.8\n");
    assert!(refusal(&text(3, turned), &[("bodies.csv", &rows)]).1.contains("length 1, not 1.8974"));
    let round = "[[swarm]]\nfrom = \"bodies.csv\"\n";
    let why = refusal(&text(2, round), &[("bodies.csv", "x,y,diameter,angle\n0.1,0.1,0.1,1\n")]).1;
    assert!(why.contains("column `angle` is for a swarm with shape or shapes"), "{why}");
}

#[test]
fn overlap_is_of_surfaces_not_of_bounding_spheres() {
    let two = |apart: f64| {
        let ellipse = "{ ellipse = { axes = [0.1, 0.02] } }";
        format!(
            "[[particle]]\nshape = {ellipse}\nposition = [0.1, 0.1]\n\
            [[particle]]\nshape = {ellipse}\nposition = [0.1, {:?}]\n",
            0.1 + apart
        )
    };
    assert!(loaded(&text(2, &two(0.021)), &[]).is_ok(), "side by side");
    let (key, why) = refusal(&text(2, &two(0.0195)), &[]);
    assert_eq!(key, "particle.1.position");
    assert!(why.contains("particle 1 overlaps particle 0: one reaches 0.0005 m"), "{why}");
    let within = two(0.03)
        + "[[particle]]\nshape = { disc = { diameter = 0.004 } }\nposition = \
        [0.12, 0.1]\n";
    assert!(refusal(&text(2, &within), &[]).1.contains("particle 2 overlaps particle 0"));
    let across = "[[particle]]\nshape = { ellipse = { axes = [0.1, 0.02] } }\nposition = [0.01, \
        0.1]\n[[particle]]\nshape = { disc = { diameter = 0.02 } }\nposition = [0.17, 0.1]\n";
    assert!(refusal(&text(2, across), &[]).1.contains("particle 1 overlaps particle 0"));
}

#[test]
fn shapes_are_said_in_words() {
    let swarm = "[[swarm]]\ncount = 6\nregion = { min = [0, 0, 0], max = [0.2, 0.2, 0.2] }\n\
        diameter = 0.02\nshape = { polyhedron = { file = \"stone.stl\" } }\n";
    let case = loaded(&text(3, swarm), &[("stone.stl", &stone())]).unwrap().case;
    assert_eq!(
        case.describe_bodies()[1].to_string(),
        "shapes       6 polyhedra of 8 corners, equal-volume diameter 0.02 m, thinnest 0.0111769 m \
        = 3.6 cells"
    );
    let one = loaded(&text(2, &body(2, "{ ellipse = { axes = [0.04, 0.02] } }", "")), &[]);
    let words = one.unwrap().case.describe_bodies();
    assert!(
        words[0]
            .words
            .starts_with("ellipse, up to 0.04 m across, thinnest 0.02 m = 6.4 cells, d ="),
        "{words:?}"
    );
}
