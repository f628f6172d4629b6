//! Obstacles against known distances, areas and volumes.

use super::*;
use std::f64::consts::{PI, TAU};

fn room(size: [f64; 3], periodic: [bool; 3]) -> Room {
    Room { size: Vector3::from(size), periodic }
}

/// Sums of what an obstacle fills of the cells of a grid: area or volume, and first moment.
fn sums(obstacle: &Obstacle, n: [usize; 3]) -> (f64, Vector3<f64>) {
    let (size, d) = (obstacle.room.size, obstacle.dimension);
    let h = Vector3::from_fn(|a, _| if a < d { size[a] / n[a] as f64 } else { 0.0 });
    let edges = [0, 1, 2].map(|a| {
        let mut edge = Vector3::zeros();
        edge[a] = 0.5 * h[a];
        edge
    });
    let (mut all, mut first) = (0.0, Vector3::zeros());
    for k in 0..n.iter().product() {
        let at = [k % n[0], k / n[0] % n[1], k / n[0] / n[1]];
        let middle =
            Vector3::from_fn(
                |a, _| {
                    if a < d { (at[a] as f64 + 0.5) * h[a] - 0.5 * size[a] } else { 0.0 }
                },
            );
        let (part, moment) = obstacle.filled(&middle, &edges);
        (all, first) = (all + part, first + moment);
    }
    (all, first)
}

#[test]
fn bed_has_walls_only_within_the_domain() {
    let bed = [[0.0, 0.0], [2.0, 0.0], [2.0, 0.3], [1.0, 0.3], [1.0, 0.5], [0.0, 0.5]];
    for outline in [bed.to_vec(), bed.iter().rev().copied().collect()] {
        let own = room([2.0, 1.0, 1.0], [false; 3]);
        let obstacle = Obstacle::outlines(&[outline], &own).unwrap();
        let distance =
            |x: f64, y: f64| obstacle.nearest(&Vector3::new(x - 1.0, y - 0.5, 0.0)).distance;
        for (x, y, exact) in [
            (0.001, 0.9, 0.4),
            (1.9, 0.9, 0.6),
            (1.999, 0.01, -0.29),
            (0.001, 0.1, -0.4),
            (1.1, 0.4, 0.1),
            (1.3, 0.9, 0.5),
        ] {
            assert!((distance(x, y) - exact).abs() < 1e-12, "{x} {y}: {}", distance(x, y));
        }
        let (area, first) = sums(&obstacle, [16, 10, 1]);
        assert!((area - 0.8).abs() < 1e-8, "{area}");
        assert!((obstacle.volume() - 0.8).abs() < 1e-8, "{}", obstacle.volume());
        let exact = Vector3::new(0.5 * -0.5 + 0.3 * 0.5, 0.5 * -0.25 + 0.3 * -0.35, 0.0);
        assert!((first - exact).norm() < 1e-8, "{first} {exact}");
        let length: f64 = obstacle.surface(0.07).iter().map(|patch| patch.area).sum();
        assert!((length - 2.2).abs() < 1e-12, "{length}");
    }
}

#[test]
fn bed_goes_on_across_periodic_side() {
    // It rises steeply at the side: much of what lies nearest is across it.
    let wave = |x: f64| 0.3 + 0.1 * (TAU * x / 2.0).sin();
    let mut outline: Vec<[f64; 2]> = vec![[0.0, -0.2], [2.0, -0.2]];
    outline.extend((0..=64).rev().map(|k| [k as f64 / 32.0, wave(k as f64 / 32.0)]));
    let own = room([2.0, 1.0, 1.0], [true, false, false]);
    let obstacle = Obstacle::outlines(&[outline], &own).unwrap();
    for y in [0.05, 0.2, 0.6, 0.9] {
        let [left, right] = [-1.0 + 1e-9, 1.0 - 1e-9]
            .map(|x| obstacle.nearest(&Vector3::new(x, y - 0.5, 0.0)).distance);
        assert!((left - right).abs() < 1e-8, "{y}: {left} {right}");
    }
    let (area, _) = sums(&obstacle, [16, 10, 1]);
    let exact: f64 =
        (0..64).map(|k| 0.5 * (wave(k as f64 / 32.0) + wave((k + 1) as f64 / 32.0)) / 32.0).sum();
    assert!((area - exact).abs() < 1e-8, "{area} {exact}");
}

#[test]
fn wrong_outlines_are_named() {
    let own = room([1.0, 1.0, 1.0], [false; 3]);
    for (outline, why) in [
        (vec![[0.2, 0.2], [0.8, 0.2]], "2 corners"),
        (vec![[0.2, 0.2], [0.8, 0.8], [0.8, 0.2], [0.2, 0.8]], "crosses itself"),
        (vec![[0.2, 0.2], [0.8, f64::NAN], [0.8, 0.2]], "corner 2"),
        (vec![[0.2, 0.2], [0.2, 0.2], [0.8, 0.2]], "corners 1 and 2"),
        (vec![[1.2, 0.2], [1.8, 0.2], [1.8, 0.8]], "within the domain"),
    ] {
        let fault = Obstacle::outlines(&[outline], &own).unwrap_err().0;
        assert!(fault.contains(why), "{fault}");
    }
}

#[test]
fn sphere_of_triangles_has_its_volume_and_distance() {
    let own = room([1.0, 1.0, 1.0], [false; 3]);
    let (radius, middle) = (0.3, Vector3::new(0.52, 0.47, 0.55));
    let surface: Vec<_> = patches::triangles(8).map(|t| t.map(|x| middle + radius * x)).collect();
    let exact: f64 = surface
        .iter()
        .map(|[a, b, c]| (a - middle).dot(&(b - middle).cross(&(c - middle))) / 6.0)
        .sum();
    let obstacle = Obstacle::surface(&surface, &own).unwrap();
    let (volume, first) = sums(&obstacle, [9, 8, 7]);
    let place = first / volume + Vector3::repeat(0.5);
    assert!((volume - exact).abs() < 1e-8 && (place - middle).norm() < 1e-6, "{volume} {place}");
    let sphere = 4.0 / 3.0 * PI * radius.powi(3);
    assert!((exact / sphere - 1.0).abs() < 0.03);
    for x in [Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.5, 0.5, 0.5)] {
        let off = (x - middle).norm() - radius;
        let found = obstacle.nearest(&(x - Vector3::repeat(0.5))).distance;
        assert!((found - off).abs() < 0.02 * radius, "{found} {off}");
    }
    assert!((obstacle.thickness() - 2.0 * radius).abs() < 0.05 * radius);
}

/// A ramp across a duct: half of it is solid, and only its slope is a wall.
#[test]
fn ramp_in_duct_is_cut_at_sides() {
    let own = room([2.0, 1.0, 1.0], [false, false, true]);
    let corner = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
    let [a, b, c] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]];
    let at = |p: [f64; 2], z: f64| corner(p[0], p[1], z);
    let mut surface = Vec::new();
    for (p, q) in [(a, b), (b, c), (c, a)] {
        // Outside is on the right of the way from p to q, seen from above.
        surface.push([at(p, 0.0), at(q, 0.0), at(q, 1.0)]);
        surface.push([at(p, 0.0), at(q, 1.0), at(p, 1.0)]);
    }
    surface.push([at(a, 1.0), at(b, 1.0), at(c, 1.0)]);
    surface.push([at(a, 0.0), at(c, 0.0), at(b, 0.0)]);
    let obstacle = Obstacle::surface(&surface, &own).unwrap();
    assert!(obstacle.walls().iter().flatten().all(|x| (x.y - 0.5 * x.x).abs() < 1e-12));
    let (volume, _) = sums(&obstacle, [8, 4, 4]);
    assert!((volume - 1.0).abs() < 1e-8, "{volume}");
    let normal = Vector3::new(-1.0, 2.0, 0.0) / 5.0f64.sqrt();
    for z in [-0.499, 0.0, 0.499] {
        let found = obstacle.nearest(&(0.2 * normal + corner(0.0, 0.0, z)));
        assert!((found.distance - 0.2).abs() < 1e-12 && (found.normal - normal).norm() < 1e-9);
    }
}

#[test]
fn solid_reaches_as_far_as_its_outline_beyond_its_walls() {
    // A flat bed: its wall is a line, and all below it is solid.
    let room = Room { size: Vector3::new(2.0, 1.0, 1.0), periodic: [true, false, false] };
    let bed = [[0.0, -1.0], [2.0, -1.0], [2.0, 0.25], [0.0, 0.25]];
    let bed = Obstacle::outlines(&[bed.to_vec()], &room).unwrap();
    let [low, high] = bed.bounds();
    assert_eq!((low.xy().into(), high.xy().into()), ([0.0, 0.0], [2.0, 0.25]));
    assert!((bed.volume() - 0.5).abs() < 1e-9, "{}", bed.volume());
    assert!((bed.extent(&-Vector3::y()) - 0.5).abs() < 1e-12);
}
