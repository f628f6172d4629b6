//! Obstacles against known distances, areas and volumes.

use super::*;
use crate::Orientation;
use crate::boxes::rows;
use std::f64::consts::{PI, TAU};

fn room(size: [f64; 3], periodic: [bool; 3]) -> Extent {
    Extent { size: Vector3::from(size), periodic }
}

/// Sums of what an obstacle fills of the cells of a grid: area or volume, and first moment.
fn sums(obstacle: &Obstacle, n: [usize; 3]) -> (f64, Vector3<f64>) {
    let size = obstacle.room.size;
    let d = obstacle.dimension;
    let h = Vector3::from_fn(|a, _| if a < d { size[a] / n[a] as f64 } else { 0.0 });
    let planes = [0, 1, 2].map(|a| match a {
        _ if a < d => (0..=n[a]).map(|k| k as f64 * h[a] - 0.5 * size[a]).collect(),
        _ => vec![0.0; 2],
    });
    let lattice =
        Lattice { factor: 1.0, orientation: Orientation::identity(), planes: &planes, faces: None };
    let whole = (0..d).map(|a| h[a]).product::<f64>();
    let mut all = 0.0;
    let mut first = Vector3::zeros();
    obstacle.tile(&lattice, &mut |tile| {
        all += whole * tile.part;
        first += whole * tile.moment;
    });
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
    let radius = 0.3;
    let middle = Vector3::new(0.52, 0.47, 0.55);
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

#[test]
fn rays_meet_the_surface_at_edges_and_corners_too() {
    let own = room([1.0, 1.0, 1.0], [false; 3]);
    let at = Vector3::new(0.52, 0.47, 0.55);
    // Corners are those of all triangles at them to the last digit.
    let corner = |x: Vector3<f64>| (at + 0.3 * x).map(|x| (1e9 * x).round() / 1e9);
    let surface: Vec<_> = patches::triangles(8).map(|t| t.map(corner)).collect();
    let obstacle = Obstacle::surface(&surface, &own).unwrap();
    let middle = at - obstacle.centre();
    for [a, b, _] in obstacle.walls() {
        for part in [0.0, 0.3, 0.5] {
            let met = a + part * (b - a);
            let from = middle + 1.37 * (met - middle);
            let inwards = (met - from).normalize();
            let way = (met - from).norm();
            let found = obstacle.meets(&from, &inwards, 1.001 * way).unwrap();
            assert!((found - way).abs() < 1e-12, "{found} {way} at {met}");
            assert_eq!(obstacle.meets(&from, &inwards, 0.999 * way), None);
            assert_eq!(obstacle.meets(&from, &-inwards, 1.0), None);
            assert_eq!(obstacle.meets(&(met + 0.01 * inwards), &-inwards, 1.0), Some(0.0));
        }
    }
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
    assert!(obstacle.walls().flatten().all(|x| (x.y - 0.5 * x.x).abs() < 1e-12));
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
    let room = Extent { size: Vector3::new(2.0, 1.0, 1.0), periodic: [true, false, false] };
    let bed = [[0.0, -1.0], [2.0, -1.0], [2.0, 0.25], [0.0, 0.25]];
    let bed = Obstacle::outlines(&[bed.to_vec()], &room).unwrap();
    let [low, high] = bed.bounds();
    assert_eq!((low.xy().into(), high.xy().into()), ([0.0, 0.0], [2.0, 0.25]));
    assert!((bed.volume() - 0.5).abs() < 1e-9, "{}", bed.volume());
    assert!((bed.extent(&-Vector3::y()) - 0.5).abs() < 1e-12);
}

/// The faces of a box with these ends.
fn cuboid(low: [f64; 3], high: [f64; 3]) -> Vec<[Vector3<f64>; 3]> {
    let at = |k: usize| Vector3::from_fn(|a, _| if k >> a & 1 == 0 { low[a] } else { high[a] });
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let split = |[a, b, c, d]: [usize; 4]| [[at(a), at(b), at(c)], [at(a), at(c), at(d)]];
    faces.into_iter().flat_map(split).collect()
}

fn rectangle(low: [f64; 2], high: [f64; 2]) -> Vec<[f64; 2]> {
    vec![low, [high[0], low[1]], high, [low[0], high[1]]]
}

/// Volume and first moment of the overlap of a box with these ends and one about the origin.
fn overlap(low: &[f64; 3], high: &[f64; 3], half: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let ends = |a: usize| [low[a].max(-half[a]), high[a].min(half[a])];
    let volume = (0..3).map(|a| (ends(a)[1] - ends(a)[0]).max(0.0)).product::<f64>();
    (volume, volume * Vector3::from_fn(|a, _| 0.5 * (ends(a)[0] + ends(a)[1])))
}

#[test]
fn box_in_cell_has_exact_volume_and_moments_flush_faces_among_them() {
    let half = Vector3::new(0.5, 0.4, 0.3);
    let planes = [0, 1, 2].map(|a| vec![-half[a], half[a]]);
    for (low, high) in [
        ([-0.2, -0.1, 0.0], [0.3, 0.2, 0.2]),
        ([-9.0, -9.0, -9.0], [0.1, 0.2, 9.0]),
        ([-9.0, -9.0, -9.0], [9.0, 9.0, 9.0]),
        ([-0.1, -9.0, -9.0], [9.0, 0.1, 0.05]),
        ([1.0, 1.0, 1.0], [2.0, 2.0, 2.0]),
        ([-0.5, -0.4, -0.3], [0.5, 0.4, 0.3]),
        ([-0.5, -0.4, -0.9], [0.0, 0.4, -0.3]),
        ([-1.0, -0.8, -0.6], [1.0, 0.8, 0.0]),
    ] {
        let solid = columns::Columns::new(3, cuboid(low, high));
        let (exact, exact_first) = overlap(&low, &high, &half);
        let whole = 8.0 * half.product();
        let mut found = (0.0, Vector3::zeros());
        rows::tile(&planes, &mut |tile| found = (whole * tile.part, whole * tile.moment), |rows| {
            cuboid(low, high).into_iter().for_each(|face| rows.add_face(&planes, face))
        });
        assert!((found.0 - exact).abs() < 1e-13, "{found:?} {exact}");
        assert!((found.1 - exact_first).norm() < 1e-13, "{found:?}");
        let inside = (0..3).all(|a| low[a] < 0.01 && high[a] > 0.01);
        assert_eq!(solid.has(&Vector3::repeat(0.01)), inside);
    }
}

/// Half of all corners of a lattice lie on each other's edges, faces and corners.
#[test]
fn polygons_on_lattice_fill_what_their_shifted_ones_do() {
    let own = room([8.0, 8.0, 1.0], [false; 3]);
    let drawn = |k: usize| 0.5 + 0.5 * crate::scatter::scatter(k);
    for case in 0..200 {
        // A star about the middle is simple.
        let n = 3 + case % 7;
        let corner = |k: usize, radius: f64| {
            let angle = TAU * k as f64 / n as f64;
            let [x, y] = [angle.cos(), angle.sin()].map(|x| (2.0 * radius * x).round() / 2.0);
            [4.0 + x, 4.0 + y]
        };
        let outline: Vec<_> = (0..n).map(|k| corner(k, 1.5 + 1.5 * drawn(10 * case + k))).collect();
        if outline::area(&outline) <= 0.5 || outline::check(&outline).is_err() {
            continue;
        }
        let obstacle = Obstacle::outlines(std::slice::from_ref(&outline), &own).unwrap();
        let (area, first) = sums(&obstacle, [8, 8, 1]);
        assert!((area - outline::area(&outline)).abs() < 1e-12, "{case}: {area}");
        for shift in [1e-15, -1e-15, 1e-9, -1e-9, 1e-3] {
            let moved = |[x, y]: &[f64; 2]| [x + shift, y + 0.7 * shift];
            let moved = outline.iter().map(moved).collect::<Vec<_>>();
            let moved = Obstacle::outlines(&[moved], &own).unwrap();
            let (near, near_first) = sums(&moved, [8, 8, 1]);
            assert!((near - area).abs() < 1e-12 * area, "{case}: {near} {area}");
            let off = near_first - first - area * shift * Vector3::new(1.0, 0.7, 0.0);
            assert!(off.norm() < 1e-12 * area, "{case}: {off}");
        }
    }
}

/// Eight triangles about the middle, each with a corner on three half axes: simple wherever these
/// are. Many of their edges run through corners of cells.
fn octahedron(corners: &[Vector3<f64>; 6]) -> Vec<[Vector3<f64>; 3]> {
    let face = |sides: usize| {
        let [x, y, z] = [0, 1, 2].map(|a| corners[2 * a + (sides >> a & 1)]);
        if sides.count_ones().is_multiple_of(2) { [x, y, z] } else { [x, z, y] }
    };
    (0..8).map(face).collect()
}

#[test]
fn polyhedra_on_lattice_fill_what_their_shifted_ones_do() {
    let own = room([8.0, 8.0, 8.0], [false; 3]);
    for case in 0..200 {
        let drawn = |k: usize| 0.5 + 0.5 * crate::scatter::scatter(30 * case + k);
        let corners = std::array::from_fn(|k| {
            let way = if k % 2 == 0 { 1.0 } else { -1.0 };
            let place = Vector3::from_fn(|a, _| {
                let beside = 2.0 * drawn(4 * k + a) - 1.0;
                if a == k / 2 { way * (1.5 + 2.0 * drawn(4 * k + a)) } else { beside }
            });
            place.map(|x| 4.0 + (2.0 * x).round() / 2.0)
        });
        let solid = octahedron(&corners);
        let volume = solid.iter().map(|[a, b, c]| a.dot(&b.cross(c)) / 6.0).sum::<f64>();
        let Ok(obstacle) = Obstacle::surface(&solid, &own) else { continue };
        let (filled, first) = sums(&obstacle, [8, 8, 8]);
        assert!((filled - volume).abs() < 1e-11, "{case}: {filled} {volume}");
        for shift in [1e-15, -1e-15, 1e-9, -1e-9, 1e-3] {
            let way = shift * Vector3::new(1.0, 0.7, 0.4);
            let moved: Vec<_> = solid.iter().map(|face| face.map(|x| x + way)).collect();
            let moved = Obstacle::surface(&moved, &own).unwrap();
            let (near, near_first) = sums(&moved, [8, 8, 8]);
            assert!((near - volume).abs() < 1e-11, "{case}: {near} {volume}");
            let off: Vector3<f64> = near_first - first - volume * way;
            assert!(off.norm() < 1e-10, "{case}: {off}");
        }
    }
}

#[test]
fn raster_that_fits_the_grid_fills_its_cells() {
    // Inputs/raster-force: a square of two triangles whose diagonal runs through all cell corners.
    let own = room([1.2, 1.2, 1.0], [true, true, false]);
    let obstacle = Obstacle::surface(&cuboid([0.0, 0.0, -1.0], [1.2, 1.2, 0.0413]), &own).unwrap();
    let (volume, first) = sums(&obstacle, [12, 12, 10]);
    assert!((volume - 1.44 * 0.0413).abs() < 1e-12, "{volume}");
    let middle = first / volume + obstacle.centre();
    assert!((middle - Vector3::new(0.6, 0.6, 0.02065)).norm() < 1e-12, "{middle}");
}

#[test]
fn obstacle_in_a_period_is_its_outline_and_all_images() {
    let own = room([1.0, 1.0, 1.0], [true, false, false]);
    for from in [0.0, 0.7, 0.8, 0.9, 1.0, -0.2, 5.8, -3.0] {
        let block = rectangle([from, 0.2], [from + 0.3, 0.4]);
        let obstacle = Obstacle::outlines(&[block], &own).unwrap();
        let (area, _) = sums(&obstacle, [10, 10, 1]);
        assert!((area - 0.06).abs() < 1e-12, "{from}: {area}");
        let length: f64 = obstacle.surface(0.03).iter().map(|patch| patch.area).sum();
        assert!((length - 1.0).abs() < 0.011, "{from}: {length}");
        let inside: f64 = from + 0.15;
        let middle = inside - inside.floor() - 0.5;
        let found = obstacle.nearest(&Vector3::new(middle, -0.2, 0.0));
        assert!((found.distance + 0.1).abs() < 1e-12, "{from}: {found:?}");
    }
    // One that fills the period with other heights at its ends has a step there.
    // A strip across the box comes in on the other sides.
    let both = room([2.0, 1.0, 1.0], [true, true, false]);
    let strip = [[0.0, 0.56], [2.0, 1.56], [2.0, 2.0], [0.0, 1.0]];
    let strip = Obstacle::outlines(&[strip.to_vec()], &both).unwrap();
    assert!((sums(&strip, [16, 8, 1]).0 - 0.88).abs() < 1e-10);
    let length: f64 = strip.surface(0.03).iter().map(|patch| patch.area).sum();
    assert!((length / (2.0 * 5.0f64.sqrt()) - 1.0).abs() < 0.01, "{length}");
    let steps = [[0.3, 0.0], [1.3, 0.0], [1.3, 0.2], [0.3, 0.4]];
    let obstacle = Obstacle::outlines(&[steps.to_vec()], &own).unwrap();
    assert!((sums(&obstacle, [10, 10, 1]).0 - 0.3).abs() < 1e-12);
    let found = obstacle.nearest(&Vector3::new(0.29 - 0.5, 0.3 - 0.5, 0.0));
    assert!((found.distance - 0.01).abs() < 1e-9, "{found:?}");
    let found = obstacle.nearest(&Vector3::new(0.31 - 0.5, 0.1 - 0.5, 0.0));
    assert!(found.distance < -0.09, "{found:?}");
    // An obstacle longer than a period overlaps with its images, and counts once.
    let longer = Obstacle::outlines(&[rectangle([0.0, 0.2], [3.1, 0.4])], &own).unwrap();
    assert!((sums(&longer, [10, 10, 1]).0 - 0.2).abs() < 1e-10);
    assert!(longer.surface(0.03).iter().all(|patch| patch.normal.x == 0.0));
}

#[test]
fn outlines_that_overlap_or_touch_are_their_union() {
    let own = room([1.0, 1.0, 1.0], [false; 3]);
    for (outlines, area, length) in [
        // They share an edge, cross, lie on each other, touch in a corner.
        ([rectangle([0.2, 0.2], [0.4, 0.4]), rectangle([0.4, 0.2], [0.6, 0.4])], 0.08, 1.2),
        ([rectangle([0.2, 0.2], [0.4, 0.4]), rectangle([0.3, 0.3], [0.5, 0.5])], 0.07, 1.2),
        ([rectangle([0.2, 0.2], [0.4, 0.4]), rectangle([0.2, 0.2], [0.4, 0.4])], 0.04, 0.8),
        ([rectangle([0.2, 0.2], [0.4, 0.4]), rectangle([0.4, 0.4], [0.6, 0.6])], 0.08, 1.6),
    ] {
        let obstacle = Obstacle::outlines(&outlines, &own).unwrap();
        let (found, _) = sums(&obstacle, [10, 10, 1]);
        assert!((found - area).abs() < 1e-10, "{found} {area}");
        let found: f64 = obstacle.surface(0.03).iter().map(|patch| patch.area).sum();
        assert!((found - length).abs() < 1e-10, "{found} {length}");
    }
}

/// A pier set into a bed: each place belongs to one of them, and together they are the union.
#[test]
fn pier_and_bed_are_one_solid_of_two_owners() {
    let own = room([1.0, 1.0, 1.0], [true, true, false]);
    for pier_from in [-0.5, 0.1, 0.3] {
        let mut bed = Obstacle::surface(&cuboid([0.0, 0.0, -1.0], [1.0, 1.0, 0.3]), &own).unwrap();
        let pier = cuboid([0.4, 0.4, pier_from], [0.6, 0.6, 0.8]);
        let mut pier = Obstacle::surface(&pier, &own).unwrap();
        Obstacle::unite(&mut [&mut bed, &mut pier], 0.1).unwrap();
        assert!(bed.is_one_with(&pier));
        let all = [&bed, &pier].map(|obstacle| sums(obstacle, [10, 10, 10]));
        assert!((all[0].0 - 0.3).abs() < 1e-10 && (all[1].0 - 0.02).abs() < 1e-10, "{all:?}");
        assert!((bed.volume() - 0.3).abs() < 1e-10 && (pier.volume() - 0.02).abs() < 1e-10);
        let area = |o: &Obstacle| o.surface(0.05).iter().map(|patch| patch.area).sum::<f64>();
        assert!((area(&bed) - 0.96).abs() < 1e-10, "{}", area(&bed));
        assert!((area(&pier) - 0.44).abs() < 1e-10, "{}", area(&pier));
        for (x, distance) in [([0.5, 0.5, 0.35], -0.1), ([0.5, 0.5, 0.2], -0.1f64.hypot(0.1))] {
            for obstacle in [&bed, &pier] {
                let found = obstacle.nearest(&(Vector3::from(x) - Vector3::repeat(0.5)));
                assert!((found.distance - distance).abs() < 1e-10, "{found:?}");
            }
        }
    }
}

#[test]
fn feet_on_both_sides_of_a_corner_are_found_once_each() {
    let own = room([1.0, 1.0, 1.0], [false; 3]);
    let obstacle = Obstacle::surface(&cuboid([0.2, 0.2, 0.2], [0.6, 0.6, 0.6]), &own).unwrap();
    let mut feet = Vec::new();
    obstacle.feet(&Vector3::repeat(-0.2), 0.15, &mut feet);
    assert_eq!(feet.len(), 3);
    assert!(feet.iter().all(|foot| (foot.distance + 0.1).abs() < 1e-12), "{feet:?}");
    obstacle.feet(&Vector3::new(-0.2, -0.1, 0.05), 0.15, &mut feet);
    assert_eq!(feet.len(), 2, "{feet:?}");
    obstacle.feet(&Vector3::repeat(0.4), 0.15, &mut feet);
    assert!(feet.is_empty());
}

/// Boxes about the faces of a closed side, of a bed that ends there and of one that goes below it.
#[test]
fn bed_goes_on_beyond_a_closed_side() {
    let own = room([4.0, 2.0, 1.0], [true, false, false]);
    for bottom in [-1.0, 0.0] {
        let bed = vec![[0.0, bottom], [4.0, bottom], [4.0, 0.6], [0.0, 0.6]];
        let obstacle = Obstacle::outlines(&[bed], &own).unwrap();
        let along = |n: usize| (0..=n).map(|k| k as f64 - 0.5 * n as f64).collect::<Vec<f64>>();
        let planes = [along(4), vec![-1.5, -0.5, 0.5], vec![0.0; 2]];
        let lattice = Lattice {
            factor: 1.0,
            orientation: Orientation::identity(),
            planes: &planes,
            faces: None,
        };
        let mut count = [0, 0];
        obstacle.tile(&lattice, &mut |tile| {
            let exact = [1.0, 0.1][tile.at[1]];
            let middle = [-1.0, -0.45][tile.at[1]];
            assert!((tile.part - exact).abs() < 1e-14, "{bottom}: {tile:?}");
            assert!((tile.moment.y - exact * middle).abs() < 1e-14, "{bottom}: {tile:?}");
            count[tile.at[1]] += 1;
        });
        assert_eq!(count, [4, 4], "{bottom}");
    }
}
