//! Contacts with obstacles, beside those with walls of the box and closed forms.

mod moving;

use super::crowd::Dice;
use super::solids::{self, Parts, free, kinetic};
use super::*;
use mics_shapes::{Extent, Obstacle};
use std::f64::consts::FRAC_1_SQRT_2;

const G: f64 = 9.81;
const SIZE: [f64; 3] = [0.4, 0.25, 0.2];
/// Height of flat beds (m).
const BED: f64 = 0.05;

fn room(size: [f64; 3]) -> Extent {
    Extent { size: Vector3::from(size), periodic: [false; 3] }
}

/// A body that stands in a box of this size (m).
pub fn standing(obstacle: Obstacle, size: [f64; 3]) -> Body {
    let middle = 0.5 * Vector3::from(size);
    Body::new(Arc::new(obstacle), 1.0, 1.0, middle)
}

/// A bed of two triangles a cell, `n` cells along x and z, that goes on beyond the box, with its
/// corners moved about along it and its `height` over x and z (m).
fn bed(n: usize, height: impl Fn(f64, f64) -> f64) -> Obstacle {
    let mut dice = Dice(5);
    let at = |i: usize, j: usize, dice: &mut Dice| {
        let [x, z] = [i, j].map(|k| (k as f64 + 0.3 * dice.about_zero()) / n as f64);
        let x = 0.6 * x - 0.1;
        let z = 0.4 * z - 0.1;
        vector![x, height(x, z), z]
    };
    let corners: Vec<_> = (0..=n)
        .flat_map(|j| (0..=n).map(move |i| (i, j)))
        .map(|(i, j)| at(i, j, &mut dice))
        .collect();
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let [a, b, c, d] =
            [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(i, j)| corners[j * (n + 1) + i]);
        triangles.extend([[a, d, b], [a, c, d]]);
    }
    Obstacle::surface(&triangles, &room(SIZE)).unwrap()
}

/// A flat line of uneven segments (2D), the solid below.
fn line(height: f64) -> Obstacle {
    let mut dice = Dice(5);
    let mut outline = vec![[-0.1, -0.1], [0.5, -0.1], [0.5, height]];
    outline.extend(
        (1..30).rev().map(|k| [0.6 * (k as f64 + 0.4 * dice.about_zero()) / 30.0 - 0.1, height]),
    );
    outline.push([-0.1, height]);
    Obstacle::outlines(&[outline], &room([0.4, 0.25, 0.0])).unwrap()
}

/// Steps of a body over a wall of the box, or over a flat obstacle: its place over that, and its
/// turning.
fn path(
    body: &Body,
    law: Material,
    obstacle: Option<Obstacle>,
    slope: f64,
    steps: usize,
) -> Vec<[f64; 4]> {
    let flat = body.shape().dimension() == 2;
    let size = if flat { [0.4, 0.25, 0.0] } else { SIZE };
    let mut all = vec![body.clone()];
    let lift = if obstacle.is_some() { BED } else { 0.0 };
    all[0].centre.y += lift;
    all.extend(obstacle.map(|o| standing(o, size)));
    let mut held =
        contacts(&all, law, size, &[0, 1, 2][..body.shape().dimension()], Substeps::Auto);
    let push = vec![accelerations(G * slope.sin(), -G * slope.cos()); all.len()];
    let one = |_| {
        held.advance(&mut all, &push, 1e-3).unwrap();
        let Body { centre, spin, .. } = &all[0];
        [centre.x, centre.y - lift, centre.z, spin.z]
    };
    (0..steps).map(one).collect()
}

/// Sphere, cube, disc and square fall on a flat obstacle of 200 triangles (30 segments) that lie at
/// random, bounce, come to rest, and roll or slide down a slope as on a wall of the box.
#[test]
fn flat_obstacle_is_wall_of_box() {
    let r = 0.01;
    let sphere = body(Shape::Sphere, r, vector![0.05, 1.3 * r, 0.09], Vector3::zeros());
    let cube = free(&solids::cuboid([r; 3], 5e-4), sphere.centre, Vector3::zeros());
    let tilted =
        free(&solids::cuboid([r; 3], 5e-4), vector![0.05, 1.8 * r, 0.09], vector![0.3, 0.2, 0.5]);
    let stone = free(
        &solids::ellipsoid([r, 0.8 * r, 0.6 * r], 5e-4),
        sphere.centre,
        vector![0.3, 0.2, 0.5],
    );
    let disc = body(Shape::Disc, r, vector![0.05, 1.3 * r, 0.0], Vector3::zeros());
    let square =
        free(&solids::rectangle([r, r], 5e-4), vector![0.05, 1.5 * r, 0.0], Vector3::z() * 0.3);
    for (name, body) in [
        ("sphere", sphere),
        ("cube", cube),
        ("tilted cube", tilted),
        ("ellipsoid", stone),
        ("disc", disc),
        ("square", square),
    ] {
        let flat = body.shape().dimension() == 2;
        for (e, friction, slope, steps) in
            [(1.0, 0.0, 0.0, 300), (0.5, 0.3, 0.0, 300), (0.5, 0.5, 0.3, 400)]
        {
            let law = Material {
                normal_stiffness: if flat { 1e7 } else { 1e5 },
                rolling_friction: 1e-3,
                ..material(1.0, e, friction)
            };
            let obstacle = if flat { line(BED) } else { bed(10, |_, _| BED) };
            let [wall, found] = [None, Some(obstacle)].map(|o| path(&body, law, o, slope, steps));
            let off = wall
                .iter()
                .zip(&found)
                .map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max));
            // Each impact of a cube that tumbles multiplies rounding by ten and more.
            let steps = if name == "tilted cube" { 100 } else { steps };
            let worst = off.take(steps).fold(0.0, f64::max);
            println!(
                "{name}, e {e}, mu {friction}, slope {slope}: {worst:.1e} m apart after {:.3} m",
                wall[steps - 1][0] - 0.05
            );
            assert!(worst < 1e-6, "{worst:e}");
        }
    }
}

/// A sphere rolls down a slope of triangles at 5/7 g sin.
#[test]
fn sphere_rolls_down_obstacle_without_slip() {
    let r = 0.01;
    let mut sphere = body(Shape::Sphere, r, vector![0.05, r, 0.09], Vector3::zeros());
    let law = Material { normal_stiffness: 1e5, ..material(1.0, 0.5, 0.5) };
    let slope = 0.3f64;
    sphere.centre.y -= sphere.mass() * G * slope.cos() / 1e5;
    let found = path(&sphere, law, Some(bed(10, |_, _| BED)), slope, 500);
    let gained = (found[499][3] - found[99][3]).abs() * r / 0.4;
    let exact = 5.0 / 7.0 * G * slope.sin();
    println!("{gained:.6} of {exact:.6} m/s2");
    assert!((gained / exact - 1.0).abs() < 1e-3);
    let heights = found[50..].iter().map(|at| at[1]);
    let (low, high) = heights.fold((1.0f64, 0.0f64), |(l, h), y| (l.min(y), h.max(y)));
    assert!(high - low < 1e-9, "{:e}", high - low);
}

/// A trough along x with walls at 45 degrees, its bottom at the middle of the box.
fn groove() -> Obstacle {
    bed_of(|_, z| 0.02 + (z - 0.1).abs())
}

/// A bed of strips along x with a straight edge at the middle.
fn bed_of(height: impl Fn(f64, f64) -> f64) -> Obstacle {
    let mut triangles = Vec::new();
    for [z, w] in [[-0.1, 0.1], [0.1, 0.3]] {
        for k in 0..6 {
            let [x, y] = [k, k + 1].map(|k| 0.1 * k as f64 - 0.1);
            let at = |x: f64, z: f64| vector![x, height(x, z), z];
            let [a, b, c, d] = [at(x, z), at(y, z), at(x, w), at(y, w)];
            triangles.extend([[a, d, b], [a, c, d]]);
        }
    }
    Obstacle::surface(&triangles, &room(SIZE)).unwrap()
}

/// A ball in a groove rests on both walls, which each bear `m g/sqrt(2)`, and does not roll along
/// it: friction acts at both.
#[test]
fn ball_in_groove_touches_both_walls() {
    let r = 0.01;
    let mut ball = body(Shape::Sphere, r, vector![0.1, 0.0, 0.1], Vector3::zeros());
    let load = ball.mass() * G * FRAC_1_SQRT_2;
    ball.centre.y = 0.02 + (r - load / 1e5) / FRAC_1_SQRT_2;
    let mut all = [ball, standing(groove(), SIZE)];
    let law = |friction| Material { normal_stiffness: 1e5, ..material(1.0, 0.5, friction) };
    let mut held = contacts(&all, law(0.0), SIZE, &[0, 1, 2], Substeps::Auto);
    for _ in 0..200 {
        held.advance(&mut all, &[accelerations(0.0, -G); 2], 1e-3).unwrap();
    }
    assert_eq!(held.pairs.list.len(), 2, "{:?}", held.pairs.list);
    for pair in &held.pairs.list {
        let kinematics = held.layout(&all).kinematics(pair, 0.0).0;
        assert!((kinematics.overlap / (load / 1e5) - 1.0).abs() < 1e-6, "{}", kinematics.overlap);
        assert!((kinematics.normal.y + FRAC_1_SQRT_2).abs() < 1e-9);
    }
    let weight = all[0].mass() * G * 1e-3;
    assert!((held.outcome().impulse(0).linear.y / weight - 1.0).abs() < 1e-6);
    assert!(
        (held.outcome().impulse(1).linear + held.outcome().impulse(0).linear).norm()
            < 1e-12 * weight
    );
    let mut held = contacts(&all, law(0.3), SIZE, &[0, 1, 2], Substeps::Auto);
    // A force of 0.9 of the friction of both walls along the groove slides nothing.
    let along = 0.9 * 0.3 * 2.0 * FRAC_1_SQRT_2 * G;
    all[0].motion = Motion::Free(Freedom { rotation: [false; 3], ..FREE });
    let from = all[0].centre.x;
    for _ in 0..200 {
        held.advance(&mut all, &[accelerations(along, -G); 2], 1e-3).unwrap();
    }
    assert!((all[0].centre.x - from).abs() < 1e-5, "{}", all[0].centre.x - from);
}

/// A ball that falls on a ridge beside its middle leaves as from the plane through the edge, across
/// the line of the edge and the centre.
#[test]
fn ball_bounces_off_convex_edge() {
    let r = 0.01;
    for aside in [0.0f64, 0.2, 0.4, 0.6] {
        let at = vector![0.1, 0.1 + r, 0.1 + aside * r];
        let ridge = bed_of(|_, z| 0.1 - (z - 0.1).abs());
        let mut all = [body(Shape::Sphere, r, at, vector![0.0, -1.0, 0.0]), standing(ridge, SIZE)];
        let law = Material { normal_stiffness: 1e8, ..material(1.0, 1.0, 0.0) };
        let mut held = contacts(&all, law, SIZE, &[0, 1, 2], Substeps::Auto);
        for _ in 0..40 {
            held.advance(&mut all, &[Accelerations::default(); 2], 1e-4).unwrap();
        }
        let n = vector![0.0, (1.0 - aside * aside).sqrt(), aside];
        let exact = vector![0.0, -1.0, 0.0] + 2.0 * n.y * n;
        println!("{aside}: {:?} of {exact:?}", all[0].velocity);
        assert!((all[0].velocity - exact).norm() < 0.01, "{} {exact}", all[0].velocity);
    }
}

/// An elastic impact of a body on an obstacle: the largest gain of energy on the way, of that at
/// the start; `None` where it misses.
fn impact(shape: &Parts, wall: &Body, law: Material, dice: &mut Dice) -> Option<f64> {
    let mut any =
        |size: f64| size * vector![dice.about_zero(), dice.about_zero(), dice.about_zero()];
    let v = 0.5;
    let turn = any(3.0);
    let mut one = free(
        shape,
        vector![0.2, 0.11, 0.1] + any(1.0).component_mul(&vector![0.1, 0.0, 0.05]),
        turn,
    );
    let radius = one.radius();
    one.velocity = vector![0.0, -v, 0.0] + any(0.4 * v);
    one.spin = any(0.5 * v / radius);
    let mut all = [one, wall.clone()];
    let mut held = contacts(&all, law, SIZE, &[0, 1, 2], Substeps::Auto);
    let start = kinetic(&all[..1]);
    let mut touched = false;
    let mut most = 0.0f64;
    for _ in 0..400 {
        held.advance(&mut all, &[Accelerations::default(); 2], 0.02 * radius / v).unwrap();
        let touches = held.outcome().impulse(0).linear != Vector3::zeros();
        touched |= touches;
        most = most.max(kinetic(&all[..1]) / start - 1.0);
        if touched && !touches && all[0].velocity.y > 0.0 {
            break;
        }
    }
    touched.then_some(most)
}

/// A hundred random elastic impacts of each shape on a lumpy bed bring no energy.
#[test]
fn random_impacts_on_lumpy_obstacle_bring_no_energy() {
    let r = 0.01;
    let mut dice = Dice(9);
    let bumps: Vec<f64> = (0..400).map(|_| dice.about_zero()).collect();
    let lumpy = bed(16, |x, z| {
        let k = ((x * 1e3) as i64 * 31 + (z * 1e3) as i64 * 17).rem_euclid(400);
        0.06 + 0.008 * bumps[k as usize]
    });
    let wall = standing(lumpy, SIZE);
    let ball = solids::clump(3, r, 1, 0.0);
    let shapes = [
        ("sphere", ball),
        ("cube", solids::cuboid([r, 0.8 * r, 0.6 * r], 0.04 * r)),
        ("clump", solids::clump(3, 0.5 * r, 3, 0.6 * r)),
        ("ellipsoid", solids::ellipsoid([r, 0.8 * r, 0.6 * r], 0.05 * r)),
    ];
    for (name, shape) in shapes {
        for friction in [0.0, 0.3] {
            let law = Material { normal_stiffness: 1e6, ..material(1.0, 1.0, friction) };
            let mut worst = 0.0f64;
            let mut count = 0;
            while count < 100 {
                let Some(most) = impact(&shape, &wall, law, &mut dice) else { continue };
                worst = worst.max(most);
                count += 1;
            }
            println!("{name}, mu {friction}: energy rises by {worst:.1e} at most");
            assert!(worst < 1e-3, "{worst:e}");
        }
    }
}

/// A slab with a coefficient of friction of 1 stays on an obstacle that slopes by 44 degrees, and
/// slides down one of 46 at `g (sin - mu cos)`.
#[test]
fn slab_slides_on_sloping_obstacle_beyond_angle_of_friction() {
    let h = 0.01;
    for (degrees, slides) in [(44.0, false), (46.0, true)] {
        let slope = f64::to_radians(degrees);
        let ramp = bed(10, |x, _| 0.22 - x.min(0.2) * slope.tan());
        let n = vector![slope.sin(), slope.cos(), 0.0];
        let law = Material { normal_stiffness: 1e5, ..material(1.0, 0.3, 1.0) };
        let slab =
            free(&solids::cuboid([h, 0.3 * h, h], 5e-4), Vector3::zeros(), Vector3::z() * -slope);
        let mut all = [slab, standing(ramp, SIZE)];
        let sink = all[0].mass() * G * slope.cos() / 1e5 / 4.0f64.powf(0.25);
        all[0].centre = vector![0.05, 0.22 - 0.05 * slope.tan(), 0.09] + (0.3 * h - sink) * n;
        let mut held = contacts(&all, law, SIZE, &[0, 1, 2], Substeps::Auto);
        let mut speeds = Vec::new();
        for _ in 0..200 {
            held.advance(&mut all, &[accelerations(0.0, -G); 2], 1e-3).unwrap();
            speeds.push(all[0].velocity.norm());
        }
        let gained = (speeds[199] - speeds[99]) / 0.1;
        let exact = G * (slope.sin() - slope.cos());
        println!(
            "{degrees} degrees: {gained:.5} m/s2, {exact:.5} without stick; {:.1e} m/s",
            speeds[199]
        );
        if slides {
            assert!((gained / exact - 1.0).abs() < 0.01, "{gained} {exact}");
        } else {
            assert!(speeds[199] < 1e-6, "{}", speeds[199]);
        }
    }
}
