//! CPU time of a touch of two shapes, and of one of a shape on a raster:
//! `cargo run --release -p mics-shapes --example touch_cost`.
//!
//! Two turn slowly on each other, an overlap of 1e-4 of their size deep, as in the substeps of a
//! contact: the direction of the one before is known.

use mics_shapes::{
    Ellipse, Ellipsoid, Extent, Obstacle, Part, Polygon, Polyhedron, Pose, Reach, Regions, Shape,
    Superquadric, closest, touch, touch_region,
};
use nalgebra::{Rotation3, Vector3};
use std::hint::black_box;

/// Touches of a pair that are timed.
const COUNT: usize = 200_000;

/// The first and the second of a pair, whose centres are a distance apart (m) along x.
struct Pair<'a> {
    name: &'static str,
    parts: [&'a Part; 2],
    turns: [Vector3<f64>; 2],
}

/// CPU time of this thread (ns).
fn cpu() -> f64 {
    let all = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux");
    all.split(' ').next().and_then(|first| first.parse().ok()).expect("a time")
}

fn pose(x: f64, turn: Vector3<f64>) -> Pose {
    Pose { place: Vector3::x() * x, orientation: Rotation3::from_scaled_axis(turn) }
}

impl Pair<'_> {
    /// The distance at which the two overlap by 1e-4 (m).
    fn apart(&self) -> f64 {
        let [a, b] = self.parts;
        let mut low = 0.0;
        let mut high = 2.0 * (a.radius + b.radius);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            let poses = [pose(0.0, self.turns[0]), pose(middle, self.turns[1])];
            let found = closest(a, &poses[0], b, &poses[1], &Vector3::x());
            let free = found.is_some_and(|found| found.distance > -1e-4);
            *(if free { &mut high } else { &mut low }) = middle;
        }
        high
    }

    fn time(&self) {
        if std::env::args().nth(1).is_some_and(|only| !self.name.contains(&only)) {
            return;
        }
        let [a, b] = self.parts;
        let apart = self.apart();
        let mut guess = Vector3::x();
        let begin = cpu();
        let mut sum = 0.0;
        let turned = [0, 1, 2, 3].map(|k| self.turns[0] + Vector3::z() * (1e-5 * f64::from(k)));
        let firsts = turned.map(|turn| pose(0.0, turn));
        let second = pose(apart, self.turns[1]);
        for k in 0..COUNT {
            let poses = [firsts[k % 4], second];
            if let Some(found) = touch(a, &poses[0], black_box(b), &poses[1], &guess) {
                guess = found.normal;
                sum += found.overlap;
            }
        }
        let each = (cpu() - begin) / COUNT as f64;
        println!("{:32} {each:8.0} ns   overlap {:.2e} m", self.name, sum / COUNT as f64);
    }
}

/// The hull of points that are spread over a sphere of diameter 1.
fn stone(points: usize) -> Polyhedron {
    let at = |k: usize| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / points as f64;
        let angle = 2.399_963 * k as f64;
        let radius = (1.0 - z * z).sqrt();
        0.5 * Vector3::new(radius * angle.cos(), 0.8 * radius * angle.sin(), 0.7 * z)
    };
    let triangles: Vec<[Vector3<f64>; 3]> =
        (0..points).map(|k| [at(k), at((k + 1) % points), at((k + 2) % points)]).collect();
    Polyhedron::new(&triangles, 0.0).expect("a hull")
}

fn cube() -> Polyhedron {
    let at = |k: usize| {
        Vector3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2 & 1) as f64)
            - Vector3::repeat(0.5)
    };
    let triangles: Vec<[Vector3<f64>; 3]> =
        (0..6).map(|k| [at(k), at(k + 1), at(k + 2)]).chain([[at(0), at(5), at(7)]]).collect();
    Polyhedron::new(&triangles, 0.0).expect("a hull")
}

/// A raster of n by n squares on a floor of 4 by 4 m, rough or flat, in a box.
fn raster(n: usize, rough: f64) -> Obstacle {
    let size = 4.0;
    let height = |i: usize, j: usize| {
        1.0 + rough * (1.7 * i as f64 + 0.3).sin() * (2.3 * j as f64 + 0.1).cos()
    };
    let at = |i: usize, j: usize| {
        let step = size / n as f64;
        Vector3::new(i as f64 * step, j as f64 * step, height(i, j))
    };
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let floor = |v: Vector3<f64>| Vector3::new(v.x, v.y, -1.0);
    for k in 0..n {
        let sides = [
            [at(k, 0), at(k + 1, 0)],
            [at(n, k), at(n, k + 1)],
            [at(k + 1, n), at(k, n)],
            [at(0, k + 1), at(0, k)],
        ];
        for [a, b] in sides {
            triangles.extend([[a, floor(a), floor(b)], [a, floor(b), b]]);
        }
    }
    // The underside, as fine as the rim.
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)].map(floor);
            triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    let room = Extent { size: Vector3::new(size, size, size), periodic: [false; 3] };
    Obstacle::surface(&triangles, &room).expect("a closed bed")
}

/// The cost of a search and of a substep of a body on a raster (us), of which the deepest point
/// lies this deep (m).
fn on_raster(name: &str, part: &Part, bed: &Obstacle, deep: f64) {
    let mesh = bed.faces();
    let turn = Rotation3::from_scaled_axis(Vector3::new(0.3, 0.2, 0.1));
    let middle = bed.centre();
    let at = |z: f64| Pose { place: Vector3::new(2.03, 1.96, z) - middle, orientation: turn };
    let mut regions = Regions::default();
    let overlap = |z: f64, regions: &mut Regions| {
        regions.clear();
        let found = regions.find(mesh, part, &at(z), Reach { all: 0.1, touched: 0.1 });
        let all = found.map(|k| touch_region(mesh, regions.get(k), part, &at(z), 2.5).overlap);
        all.fold(f64::NEG_INFINITY, f64::max)
    };
    // Down to where it touches, and then as deep.
    let mut high = 3.0;
    while overlap(high, &mut regions) < -0.02 {
        high -= 0.01;
    }
    let mut low = high - 0.03;
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        *(if overlap(middle, &mut regions) > 1e-4 { &mut low } else { &mut high }) = middle;
    }
    high -= deep;
    let reach = Reach { all: 0.03, touched: 0.03 };
    let begin = cpu();
    let mut searches = 0;
    while cpu() - begin < 1e8 {
        searches += 1;
        regions.clear();
        black_box(regions.find(mesh, part, &at(high + 0.01), reach));
    }
    let search = (cpu() - begin) / 1e3 / f64::from(searches);
    regions.clear();
    let found = regions.find(mesh, part, &at(high + 0.01), reach);
    let faces = found.len();
    let begin = cpu();
    let mut rounds = 0;
    let mut sum = 0.0;
    while rounds % 10 > 0 || cpu() - begin < 1e8 {
        rounds += 1;
        let k = rounds % 1000;
        let pose = at(high - 1e-9 * f64::from(k));
        for region in found.clone() {
            sum += touch_region(mesh, regions.get(region), part, &pose, 2.5).overlap;
        }
    }
    let each = (cpu() - begin) / 1e3 / f64::from(rounds);
    println!("{name:32} search {search:8.1} us, {faces} regions, substep {each:8.2} us {sum:.1e}");
}

fn main() {
    let ellipse = Ellipse::new([1.0, 0.6]);
    let square =
        Polygon::new(&[[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]], 0.0).expect("a square");
    let corner = |k: usize| {
        let angle = 1.256_637 * k as f64;
        [0.5 * angle.cos(), 0.5 * angle.sin()]
    };
    let pentagon = Polygon::new(&[0, 1, 2, 3, 4].map(corner), 0.0).expect("a pentagon");
    let ellipsoid = Ellipsoid::new([1.0, 0.8, 0.6]);
    let cube = cube();
    let stone = stone(27);
    let superquadric = Superquadric::new([1.0, 0.9, 0.8], [8.0; 2]).expect("a superquadric");
    let of = |shape: &'static str, part: &[Part]| (shape, part[0].clone());
    let [(_, e), (_, s), (_, p)] =
        [of("", ellipse.parts()), of("", square.parts()), of("", pentagon.parts())];
    let [(_, o), (_, c), (_, h), (_, q)] = [
        of("", ellipsoid.parts()),
        of("", cube.parts()),
        of("", stone.parts()),
        of("", superquadric.parts()),
    ];
    let none = Vector3::zeros();
    let some = Vector3::new(0.3, -0.4, 0.7);
    let flat = Vector3::z();
    for (name, parts, turns) in [
        ("ellipses", [&e, &e], [0.4 * flat, 1.3 * flat]),
        ("squares, face on face", [&s, &s], [none, none]),
        ("squares, corner on face", [&s, &s], [0.6 * flat, none]),
        ("pentagon and ellipse", [&p, &e], [0.1 * flat, 0.7 * flat]),
        ("ellipsoids", [&o, &o], [some, -some]),
        ("cubes, face on face", [&c, &c], [none, none]),
        ("cubes, edge on edge", [&c, &c], [Vector3::z() * 0.785, Vector3::y() * 0.785]),
        ("cubes, corner on face", [&c, &c], [some, none]),
        ("stones of 50 facets", [&h, &h], [some, none]),
        ("stone and ellipsoid", [&h, &o], [some, -some]),
        ("superquadrics", [&q, &q], [some, -some]),
        ("superquadric and stone", [&q, &h], [some, -some]),
    ] {
        Pair { name, parts, turns }.time();
    }
    if std::env::args().nth(1).is_some_and(|only| only != "raster") {
        return;
    }
    let ball = Part::ball(Vector3::zeros(), 0.5);
    for (n, rough) in [(64, 0.0), (64, 0.01), (192, 0.005)] {
        let bed = raster(n, rough);
        println!("raster, {:.0} squares a diameter, {rough} m rough", n as f64 / 4.0);
        for (name, part) in [("ball", &ball), ("ellipsoid", &o), ("stone of 50 facets", &h)] {
            on_raster(&format!("{name}, at rest"), part, &bed, 1e-4);
            on_raster(&format!("{name}, in impact"), part, &bed, 0.01);
        }
    }
}
