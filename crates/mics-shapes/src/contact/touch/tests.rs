//! Distances and patches of two parts, beside closed forms and beside each other.

use super::*;
use crate::Orientation;
use crate::closest;
use crate::contact::part::{Face, Polytope};

/// Numbers in [-1, 1), the same every time.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self, flat: bool) -> Vector3<f64> {
        Vector3::new(self.roll(), self.roll(), if flat { 0.0 } else { self.roll() })
    }

    fn pose(&mut self, flat: bool, away: f64) -> Pose {
        let turn = if flat { Vector3::z() * 3.0 * self.roll() } else { 3.0 * self.vector(false) };
        let place = away * self.vector(flat).normalize();
        Pose { place, orientation: Orientation::from_scaled_axis(turn) }
    }
}

/// A box with these half edges in all, the third zero of a rectangle.
fn cuboid(half: [f64; 3], rounding: f64) -> Part {
    let inner = Vector3::from(half).map(|h| (h - rounding).max(0.0));
    let flat = half[2] == 0.0;
    let at = |x: f64, y: f64, z: f64| inner.component_mul(&Vector3::new(x, y, z));
    let polytope = if flat {
        let corners = vec![at(-1., -1., 0.), at(1., -1., 0.), at(1., 1., 0.), at(-1., 1., 0.)];
        let normals = [-Vector3::y(), Vector3::x(), Vector3::y(), -Vector3::x()];
        let faces = (0..4)
            .map(|k| Face { normal: normals[k], corners: vec![k as u32, (k as u32 + 1) % 4] });
        Polytope::new(corners, faces.collect())
    } else {
        let sign = |bit: usize| if bit == 1 { 1.0 } else { -1.0 };
        let corners = (0..8).map(|k| at(sign(k & 1), sign(k >> 1 & 1), sign(k >> 2 & 1)));
        let faces = [
            (-Vector3::x(), [0, 4, 6, 2]),
            (Vector3::x(), [1, 3, 7, 5]),
            (-Vector3::y(), [0, 1, 5, 4]),
            (Vector3::y(), [2, 6, 7, 3]),
            (-Vector3::z(), [0, 2, 3, 1]),
            (Vector3::z(), [4, 5, 7, 6]),
        ];
        let faces = faces.map(|(normal, corners)| Face { normal, corners: corners.to_vec() });
        Polytope::new(corners.collect(), faces.to_vec())
    };
    let radius = inner.norm() + rounding;
    Part { place: Vector3::zeros(), core: Core::Polytope(polytope), rounding, radius }
}

fn ellipsoid(half: [f64; 3]) -> Part {
    let half = Vector3::from(half);
    let rounding = 0.05;
    let radius = half.norm();
    Part {
        place: Vector3::zeros(),
        core: Core::Ellipsoid { half, inset: rounding },
        rounding,
        radius,
    }
}

fn superquadric(half: [f64; 3], exponents: [f64; 2]) -> Part {
    let half = Vector3::from(half);
    let core = Core::Superquadric { half, exponents, inset: 0.01 };
    Part { place: Vector3::zeros(), core, rounding: 0.01, radius: half.norm() }
}

fn ball(radius: f64) -> Part {
    Part { place: Vector3::zeros(), core: Core::Point, rounding: radius, radius }
}

fn shapes(flat: bool) -> Vec<Part> {
    let z = if flat { 0.0 } else { 1.0 };
    let mut all =
        vec![ball(0.3), cuboid([0.5, 0.3, 0.4 * z], 0.02), ellipsoid([0.5, 0.3, 0.4 * z])];
    // In 2D there are none.
    if !flat {
        all.push(superquadric([0.5, 0.4, 0.3], [8.0, 8.0]));
    }
    all[0].place = Vector3::new(0.1, 0.2, 0.1 * z);
    all
}

/// Distance of two parts along a direction.
fn along(a: &Part, at: &Pose, b: &Part, to: &Pose, n: &Vector3<f64>) -> f64 {
    let reach = |part: &Part, pose: &Pose, n: &Vector3<f64>| {
        let side = Placed::new(part, pose);
        let own = side.orientation.inverse_transform_vector(n);
        side.at(&part.core.support(&own)).dot(n) + part.rounding
    };
    -reach(b, to, &-n) - reach(a, at, n)
}

/// The distance is that along its normal, and no direction shows the two further apart; both
/// nearest points are on the cores.
#[test]
fn distance_of_all_pairs_is_largest_along_its_normal() {
    let mut dice = Dice(3);
    let mut worst = [0.0f64; 2];
    for flat in [true, false] {
        let shapes = shapes(flat);
        for (a, b) in shapes.iter().flat_map(|a| shapes.iter().map(move |b| (a, b))) {
            for _ in 0..200 {
                let reach = a.radius + b.radius;
                let away = reach * (0.9 + 0.3 * dice.roll());
                let poses = [dice.pose(flat, 0.1), dice.pose(flat, away)];
                let guess = poses[1].place - poses[0].place;
                let Some(found) = closest(a, &poses[0], b, &poses[1], &guess) else { continue };
                let back = closest(b, &poses[1], a, &poses[0], &dice.vector(flat))
                    .unwrap_or_else(|| panic!("{a:?} {b:?} {poses:?} {found:?}"));
                let shown = along(a, &poses[0], b, &poses[1], &found.normal);
                // Cores of ellipsoids may overlap.
                let way = found.points[1] - found.points[0];
                let way = way * (found.distance + a.rounding + b.rounding).signum();
                let apart = [
                    (shown - found.distance).abs().max((back.distance - found.distance).abs()),
                    (way.normalize() - found.normal)
                        .norm()
                        .max((back.normal + found.normal).norm()),
                ];
                assert!(
                    apart[0] < 3e-9 && apart[1] < 1e-6,
                    "{apart:?} {a:?} {b:?} {poses:?} {found:?} {back:?}"
                );
                worst = [worst[0].max(apart[0]), worst[1].max(apart[1])];
                for _ in 0..20 {
                    let n = (found.normal + 0.1 * dice.vector(flat)).normalize();
                    let other = along(a, &poses[0], b, &poses[1], &n);
                    assert!(other <= found.distance + 1e-12, "{other} {found:?} {a:?} {b:?}");
                }
            }
        }
    }
    println!("distance to {:.1e}, normal to {:.1e}", worst[0], worst[1]);
}

/// The force of a potential of the overlap is its slope, for moves and turns of either body.
#[test]
fn overlap_changes_as_place_and_normal_say() {
    let mut dice = Dice(5);
    for flat in [true, false] {
        let shapes = shapes(flat);
        let mut worst = [0.0f64; 2];
        for (a, b) in shapes.iter().flat_map(|a| shapes.iter().map(move |b| (a, b))) {
            let mut tried = 0;
            for _ in 0..4000 {
                let reach = a.radius + b.radius;
                let away = reach * (0.7 + 0.3 * dice.roll());
                let poses = [dice.pose(flat, 0.05), dice.pose(flat, away)];
                let guess = poses[1].place - poses[0].place;
                let Some(found) = touch(a, &poses[0], b, &poses[1], &guess) else { continue };
                if found.overlap <= 1e-4 || found.overlap > 0.018 {
                    continue;
                }
                tried += 1;
                let turn = if flat { Vector3::z() * dice.roll() } else { dice.vector(false) };
                let move_by = dice.vector(flat);
                let h = 1e-8;
                let moved = |h: f64| {
                    let turned = Orientation::from_scaled_axis(h * turn) * poses[0].orientation;
                    let pose = Pose { place: poses[0].place + h * move_by, orientation: turned };
                    touch(a, &pose, b, &poses[1], &guess).unwrap().overlap
                };
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                let velocity = move_by + turn.cross(&(found.place - poses[0].place));
                let expected = found.gain * (velocity + found.couple * turn).dot(&found.normal);
                // The slope of two boxes lacks that of the weights of nearly parallel edges.
                let boxes = [a, b].iter().all(|p| matches!(p.core, Core::Polytope(_))) && !flat;
                let apart = (slope - expected).abs();
                let limit = if boxes { 5e-4 } else { 1e-6 };
                worst[usize::from(boxes)] = worst[usize::from(boxes)].max(apart);
                assert!(apart < limit, "{slope} {expected} {a:?} {b:?} {poses:?}");
            }
            assert!(tried > 10, "{tried}");
        }
        println!("slopes to {:.1e}, of patches {:.1e}", worst[0], worst[1]);
    }
}

/// A box flat on a box, turned about the normal and moved over the edge, and flat on a plane: as
/// stiff as a corner within a factor.
#[test]
fn flat_patch_is_as_deep_as_its_corners() {
    let small = cuboid([0.5, 0.5, 0.5], 0.02);
    let large = cuboid([1.0, 1.0, 0.5], 0.02);
    let at = |x: f64, z: f64, turn: Vector3<f64>| Pose {
        place: Vector3::new(x, 0.0, z),
        orientation: Orientation::from_scaled_axis(turn),
    };
    let below = at(0.0, 0.0, Vector3::zeros());
    for (x, angle, corners) in
        [(0.0, 0.0, 4.0), (0.2, 0.3, 4.0), (0.8, 0.0, 4.0), (0.8, 0.3, 5.0), (0.5, 0.0, 8.0)]
    {
        let above = at(x, 0.99, Vector3::z() * angle);
        let found = touch(&large, &below, &small, &above, &Vector3::z()).unwrap();
        let most = 0.01 * f64::powf(corners, 1.0 / f64::from(POWER));
        assert!((found.normal - Vector3::z()).norm() < 1e-12);
        assert!(found.overlap > 0.0099 && found.overlap <= 1.001 * most, "{x} {angle}: {found:?}");
        assert!((found.place.z - 0.495).abs() < 1e-12, "{found:?}");
    }
    let tilted = at(0.0, 0.0, Vector3::y() * 1e-3);
    let found = touch_plane(&small, &tilted, &-Vector3::z(), 0.49);
    assert!(found.place.x > 0.1 && found.place.y.abs() < 1e-12, "{found:?}");
}

/// Equal boxes face on face, moved and turned by as little as can be and by much more: as deep as
/// they are, along the normal of the faces.
#[test]
fn equal_boxes_stand_flush_on_each_other() {
    let mut dice = Dice(11);
    let mut small = |from: f64| {
        let size = 10f64.powf(-from - 7.0 * (1.0 + dice.roll()));
        if dice.roll() < -0.4 { 0.0 } else { size * dice.roll().signum() }
    };
    for flat in [true, false] {
        let half = [0.5, 0.5, if flat { 0.0 } else { 0.5 }];
        let part = cuboid(half, 0.025);
        for k in 0..20_000 {
            let [x, z] = [small(2.0), if flat { 0.0 } else { small(2.0) }];
            let mut turn = Vector3::new(small(5.0), small(3.0), small(5.0));
            if flat {
                turn = Vector3::z() * turn.z;
            }
            let depth = 10f64.powf(-2.0 - f64::from(k % 5));
            let quarter = if flat { Vector3::z() } else { Vector3::y() };
            let quarter = quarter * std::f64::consts::FRAC_PI_2 * f64::from(k % 4);
            let orientation =
                Orientation::from_scaled_axis(turn) * Orientation::from_scaled_axis(quarter);
            let below = Pose {
                place: Vector3::new(0.1, 0.2, 0.3 * half[2]),
                orientation: Orientation::identity(),
            };
            let place = below.place + Vector3::new(x, 1.0 - depth, z);
            let above = Pose { place, orientation };
            let found = touch(&part, &below, &part, &above, &(place - below.place)).unwrap();
            let lean = 0.75 * (turn.x.abs() + turn.z.abs());
            let overlap = found.overlap;
            assert!(
                overlap > 0.98 * depth - lean
                    && overlap < 1.6 * (depth + lean)
                    && found.normal.y > 0.9,
                "{found:?} {above:?} {depth}"
            );
        }
    }
}

/// Ellipsoids that overlap by more than their skins are as deep as along their normal.
#[test]
fn ellipsoids_have_a_distance_wherever_they_overlap() {
    let mut dice = Dice(13);
    for flat in [true, false] {
        let z = if flat { 0.0 } else { 1.0 };
        let a = ellipsoid([0.5, 0.3, 0.4 * z]);
        let b = ellipsoid([0.3, 0.25, 0.35 * z]);
        for _ in 0..2000 {
            let poses = [dice.pose(flat, 0.1), dice.pose(flat, 0.45)];
            let guess = poses[1].place - poses[0].place;
            let found = closest(&a, &poses[0], &b, &poses[1], &guess).unwrap();
            let shown = along(&a, &poses[0], &b, &poses[1], &found.normal);
            assert!((shown - found.distance).abs() < 1e-12, "{shown} {found:?}");
            for _ in 0..20 {
                let n = (found.normal + 0.05 * dice.vector(flat)).normalize();
                let other = along(&a, &poses[0], &b, &poses[1], &n);
                assert!(other <= found.distance + 1e-12, "{other} {found:?} {poses:?}");
            }
        }
    }
}
