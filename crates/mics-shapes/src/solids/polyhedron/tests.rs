use super::*;
use crate::Orientation;
use crate::scatter::{counted, feet, lattice, scatter};
use crate::surface::patches;
use crate::{Extent, Obstacle};

/// A box turned by a vector (rad).
fn cuboid(half: Vector3<f64>, turn: Vector3<f64>) -> Vec<[Vector3<f64>; 3]> {
    let mut body = Convex::default();
    body.set_box(&Vector3::new(3.0, 1.0, -2.0), &[0, 1, 2].map(|a| Vector3::ith(a, half[a])));
    let turn = Orientation::from_scaled_axis(turn);
    Facets::new(&{
        body.shift(&Vector3::new(-3.0, -1.0, 2.0));
        body
    })
    .triangles()
    .into_iter()
    .map(|corners| corners.map(|x| turn * x + Vector3::new(3.0, 1.0, -2.0)))
    .collect()
}

/// A stone: points on an ellipsoid.
fn stone(points: usize) -> Vec<[Vector3<f64>; 3]> {
    let at = |k: usize| {
        let n = Vector3::from_fn(|a, _| scatter(3 * k + a)).normalize();
        n.component_mul(&Vector3::new(1.0, 0.8, 0.6))
    };
    // The hull is all that counts.
    (0..points / 3).map(|k| [at(3 * k), at(3 * k + 1), at(3 * k + 2)]).collect()
}

#[test]
fn cube_and_its_rounding_have_exact_volumes() {
    for turn in [Vector3::zeros(), Vector3::new(0.3, 1.0, -0.4)] {
        let mesh = cuboid(Vector3::new(0.5, 0.4, 0.3), turn);
        let body = Polyhedron::new(&mesh, 0.0).unwrap();
        assert!((body.volume / 0.48 - 1.0).abs() < 1e-12 && body.hull_excess.abs() < 1e-12);
        assert_eq!((body.face_count(), body.solid.corners().len()), (6, 8));
        let own = Orientation::from_scaled_axis(turn).inverse();
        let inertia = own * body.inertia * own.transpose();
        let exact = 0.04 * Vector3::new(1.0, 1.36, 1.64);
        assert!((inertia - Matrix3::from_diagonal(&exact)).norm() < 1e-12, "{inertia}");
        assert!((body.thickness() - 0.6).abs() < 1e-12);
        let r = 0.1;
        let round = Polyhedron::new(&mesh, r).unwrap();
        let [a, b, c] = [0.8, 0.6, 0.4];
        let exact = a * b * c
            + 2.0 * (a * b + b * c + c * a) * r
            + PI * r * r * (a + b + c)
            + 4.0 / 3.0 * PI * r.powi(3);
        assert!((round.volume / exact - 1.0).abs() < 1e-12, "{} {exact}", round.volume);
        // About x: core, slabs, quarter rods and eighths of a ball.
        let n = own.inverse() * Vector3::x();
        let found = n.dot(&(round.inertia * n));
        let exact = rounded_inertia([a, b, c], r);
        println!("inertia of the rounded one: {:.1e} off", found / exact - 1.0);
        assert!((found / exact - 1.0).abs() < 1e-4, "{found} {exact}");
    }
}

/// About x of a box of these edges within r.
fn rounded_inertia([a, b, c]: [f64; 3], r: f64) -> f64 {
    let block = |a: f64, b: f64, c: f64| a * b * c * (b * b + c * c) / 12.0;
    let core = block(a + 2.0 * r, b, c);
    let slab = |b: f64, c: f64| {
        2.0 * (a * b * r * (b * b + r * r) / 12.0 + a * b * r * (0.5 * (c + r)).powi(2))
    };
    let quarter = PI * r * r / 4.0;
    let centre = 4.0 * r / (3.0 * PI);
    let own = PI * r.powi(4) / 16.0;
    let square = |b: f64| own + quarter * (b * centre + 0.25 * b * b);
    let rods = 4.0 * a * (square(b) + square(c));
    // Rods along y, and along z.
    let along = |b: f64, c: f64| 4.0 * (b.powi(3) / 12.0 * quarter + b * square(c));
    let eighth = PI * r.powi(3) / 6.0;
    let ball = |b: f64| r.powi(5) * PI / 30.0 + eighth * (b * 0.375 * r + 0.25 * b * b);
    core + slab(b, c) + slab(c, b) + rods + along(b, c) + along(c, b) + 8.0 * (ball(b) + ball(c))
}

#[test]
fn boxes_of_a_turned_lattice_sum_to_the_polyhedron() {
    let cube = cuboid(Vector3::new(0.5, 0.4, 0.3), Vector3::new(0.3, 1.0, -0.4));
    for (name, mesh) in [("cube", &cube), ("stone", &stone(102))] {
        for rounding in [0.0, 0.05] {
            let body = Polyhedron::new(mesh, rounding).unwrap();
            let (volume, first) = lattice(&body);
            let feet = feet(&body, 1.5);
            let parts = counted(&body, 16);
            let faces = body.face_count();
            println!(
                "{name} of {faces}, rounding {rounding}: {volume:.1e}, {first:.1e}, feet {feet:.1e}"
            );
            assert!(volume < 1e-12 && first < 1e-12 && feet < 1e-12);
            assert!(parts.0 < 1e-2 && parts.1 < 1e-2, "{parts:?}");
            let middle: Vector3<f64> = body.surface(0.05).iter().map(|p| p.area * p.normal).sum();
            assert!(rounding > 0.0 || middle.norm() < 1e-12, "{middle}");
            let [part] = body.parts() else { panic!() };
            for (n, _) in patches::directions(3) {
                let below = body.extent(&n) - part.core.support(&n).dot(&n) - part.rounding;
                assert!((-1e-12..0.05).contains(&below), "{below}");
            }
        }
    }
}

/// The grid finds for a point anywhere what a loop over all faces does.
#[test]
fn nearest_face_by_the_grid_is_the_nearest_of_all() {
    let body = Polyhedron::new(&stone(102), 0.0).unwrap().solid;
    for k in 0..5000 {
        let point = 1.3 * Vector3::from_fn(|a, _| scatter(3 * k + a));
        let distance = body.nearest(&point).distance;
        let triangles = body.triangles();
        let above = body.faces().iter().map(|face| face.normal.dot(&point) - face.offset);
        let above = above.fold(f64::NEG_INFINITY, f64::max);
        if above <= 0.0 {
            assert!((distance - above).abs() < 1e-14);
            continue;
        }
        // By parry's triangles.
        use parry3d_f64::query::PointQuery;
        let place = |x: &Vector3<f64>| Place::new(x.x, x.y, x.z);
        let own = triangles.iter().map(|[a, b, c]| {
            let triangle = parry3d_f64::shape::Triangle::new(place(a), place(b), place(c));
            triangle.distance_to_local_point(place(&point), true)
        });
        let least = own.fold(f64::INFINITY, f64::min);
        assert!((distance - least).abs() < 1e-12, "{point}: {distance} {least}");
    }
}

#[test]
fn sphere_of_triangles_is_nearly_a_sphere() {
    let mesh: Vec<_> = patches::triangles(10).collect();
    let body = Polyhedron::new(&mesh, 0.0).unwrap();
    let volume = body.volume();
    let exact = 4.0 / 3.0 * PI;
    println!("{} faces: volume {:.4} of the sphere", body.face_count(), volume / exact);
    let sphere = 0.4 * volume * (volume / exact).powf(2.0 / 3.0);
    assert!((body.inertia() - sphere * Matrix3::identity()).norm() < 1e-3 * sphere);
}

#[test]
fn faults_of_polyhedra_say_what_is_wrong() {
    let fault = |mesh: &[[Vector3<f64>; 3]], r| Polyhedron::new(mesh, r).unwrap_err().0;
    let flat = [[Vector3::x(), Vector3::y(), Vector3::zeros()]];
    assert!(fault(&flat, 0.0).contains("flat"));
    assert!(fault(&[], 0.0).contains("flat"));
    assert!(fault(&[[f64::NAN * Vector3::x(); 3]], 0.0).contains("triangle 1"));
    let cube = cuboid(Vector3::repeat(0.5), Vector3::zeros());
    assert!(fault(&cube, 0.6).contains("rounding"));
    // The hull of a cube with a dent is the cube.
    let mut dented = cube;
    let corner = dented[0];
    let middle = Vector3::new(3.0, 1.0, -2.0);
    dented[0] = [corner[0], corner[1], middle];
    dented.push([corner[1], corner[2], middle]);
    dented.push([corner[2], corner[0], middle]);
    let body = Polyhedron::new(&dented, 0.0).unwrap();
    assert!((body.hull_excess() - 1.0 / 11.0).abs() < 1e-12, "{}", body.hull_excess());
}

/// Beside the same surface as a mesh in a tree, which knows nothing of lists of faces.
#[test]
fn nearest_point_of_polyhedron_is_that_of_its_triangles() {
    let plate = cuboid(Vector3::new(0.9, 0.5, 0.05), Vector3::new(0.3, 1.0, -0.4));
    for mesh in [stone(60), stone(300), plate] {
        let body = Polyhedron::new(&mesh, 0.0).unwrap();
        let room = Extent { size: Vector3::repeat(20.0), periodic: [false; 3] };
        let middle = Vector3::repeat(10.0);
        let moved: Vec<_> =
            body.triangles(1.0).iter().map(|t| t.map(|corner| corner + middle)).collect();
        let tree = Obstacle::surface(&moved, &room).unwrap();
        let mut worst = 0.0f64;
        for k in 0..20000 {
            let point = 1.3 * Vector3::from_fn(|a, _| scatter(3 * k + a));
            let found = body.nearest(&point).distance;
            let exact = tree.nearest(&point).distance;
            worst = worst.max((found - exact).abs());
        }
        println!("{} faces: {worst:.1e} m off", body.face_count());
        assert!(worst < 1e-9, "{worst:e}");
    }
}

/// The plane's height is the distance inside and no more than it outside.
#[test]
fn planes_of_polyhedron_are_no_further_than_its_surface() {
    for body in [stone(60), stone(300)].map(|mesh| Polyhedron::new(&mesh, 0.0).unwrap()) {
        for k in 0..50_000 {
            let point = 1.3 * Vector3::from_fn(|a, _| scatter(6 * k + a));
            let plane = body.plane(&point).unwrap();
            let exact = body.nearest(&point).distance;
            let height = plane.distance;
            assert!(height * exact >= 0.0 && height <= exact + 1e-12, "{height} {exact}");
            assert!(exact > 0.0 || height == exact);
            let over = body.extent(&plane.normal) - (plane.normal.dot(&point) - height);
            assert!(over < 1e-12, "{over:e}");
        }
    }
    assert!(Polyhedron::new(&stone(60), 0.1).unwrap().plane(&Vector3::x()).is_none());
}
