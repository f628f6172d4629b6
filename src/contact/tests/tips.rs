//! Stones on sharp corners and thin walls of obstacles: whatever the angle, nothing is pushed out
//! of the far side of a tip.

use super::crowd::Dice;
use super::obstacles::standing;
use super::solids::kinetic;
use super::*;
use mics_shapes::{Ellipse, Extent, Obstacle, Polygon, Polyhedron, Shape};

const SIZE: [f64; 3] = [0.2, 0.2, 0.2];

/// Where the tips are (m).
const TIP: [f64; 2] = [0.1, 0.08];

fn room(dimension: usize) -> Extent {
    let z = if dimension == 2 { 0.0 } else { SIZE[2] };
    Extent { size: vector![SIZE[0], SIZE[1], z], periodic: [false; 3] }
}

/// The corners of a triangle that points upwards with this angle (degrees), leaning to a side.
fn tip(degrees: f64) -> [[f64; 2]; 3] {
    let lean = 0.1;
    let foot = |side: f64| {
        let angle = side * 0.5 * degrees.to_radians() + lean;
        [TIP[0] + 0.08 * angle.sin(), TIP[1] - 0.08 * angle.cos()]
    };
    [foot(-1.0), foot(1.0), TIP]
}

/// A ridge of that section across the box.
fn ridge(degrees: f64) -> Obstacle {
    let [a, b, c] = tip(degrees);
    let at = |[x, y]: [f64; 2], z: f64| vector![x, y, z];
    let near = -0.01;
    let far = SIZE[2] + 0.01;
    let mut triangles =
        vec![[at(a, near), at(c, near), at(b, near)], [at(a, far), at(b, far), at(c, far)]];
    for [from, to] in [[a, b], [b, c], [c, a]] {
        triangles.push([at(from, near), at(to, near), at(to, far)]);
        triangles.push([at(from, near), at(to, far), at(from, far)]);
    }
    Obstacle::surface(&triangles, &room(3)).unwrap()
}

/// A wall that is thinner than the skins of what falls on it.
fn blade(width: f64) -> Obstacle {
    let [left, right] = [TIP[0] - 0.5 * width, TIP[0] + 0.5 * width];
    let outline = vec![[left, 0.02], [right, 0.02], [right, TIP[1]], [left, TIP[1]]];
    Obstacle::outlines(&[outline], &room(2)).unwrap()
}

/// A convex polygon with this many corners, about 1 cm wide.
fn stone(corners: usize, dice: &mut Dice) -> Polygon {
    let points: Vec<[f64; 2]> = (0..corners)
        .map(|k| {
            let angle = 2.0 * PI * (k as f64 + 0.35 * dice.about_zero()) / corners as f64;
            [0.006 * angle.cos(), 0.004 * angle.sin()]
        })
        .collect();
    Polygon::new(&points, 0.0).unwrap()
}

fn free(shape: impl Shape + 'static) -> Body {
    let dimension = shape.dimension();
    let mut body = Body::new(Arc::new(shape), 2650.0, 1.0, Vector3::zeros());
    body.motion = Motion::Free(if dimension == 2 { PLANE } else { FREE });
    body
}

/// Throws a body at a tip from above or from a side: the largest gain of energy, of that at the
/// start, at times when nothing touches, and the deepest overlap (m).
fn throw(body: &Body, wall: &Body, law: Material, steepest: f64, dice: &mut Dice) -> (f64, f64) {
    let dimension = body.shape().dimension();
    let flat = dimension == 2;
    let mut any = |size: f64| {
        let z = if flat { 0.0 } else { dice.about_zero() };
        size * vector![dice.about_zero(), dice.about_zero(), z]
    };
    let v = 0.5;
    let radius = body.radius();
    let aside = any(1.0);
    let turn = any(3.0);
    let slant = (0.3 * PI * aside.x).clamp(-steepest, steepest);
    let down = vector![slant.sin(), -slant.cos(), 0.0];
    let mut all = [body.clone(), wall.clone()];
    let turn = if flat { vector![0.0, 0.0, 3.0 * aside.y] } else { turn };
    all[0].orientation = nalgebra::UnitQuaternion::from_scaled_axis(turn);
    let z = if flat { 0.0 } else { 0.1 };
    let beside = vector![-down.y, down.x, 0.0] * radius * any(0.7).x;
    all[0].centre = vector![TIP[0], TIP[1], z] - 2.0 * radius * down + beside;
    all[0].velocity = v * down + any(0.2 * v);
    let spin = any(v / radius);
    all[0].spin = if flat { vector![0.0, 0.0, spin.x] } else { spin };
    let mut held = contacts(&all, law, SIZE, &[0, 1, 2][..dimension], Substeps::Auto);
    let start = kinetic(&all[..1]);
    let mut most = 0.0f64;
    let mut deepest = 0.0f64;
    for _ in 0..200 {
        held.advance(&mut all, &[Accelerations::default(); 2], 0.02 * radius / v).unwrap();
        if held.outcome().impulse(0).linear == Vector3::zeros() {
            most = most.max(kinetic(&all[..1]) / start - 1.0);
        }
        deepest = deepest.max(held.outcome().deepest);
    }
    (most, deepest)
}

/// Throws many stones at a wall, and checks energy and overlap; `name` says which throws.
fn throw_all(
    name: &str,
    degrees: f64,
    wall: Obstacle,
    count: usize,
    mut stone: impl FnMut(&mut Dice) -> Body,
) {
    let flat = wall.dimension() == 2;
    let wall = standing(wall, [SIZE[0], SIZE[1], if flat { 0.0 } else { SIZE[2] }]);
    let steepest = 0.6 * 0.5 * (180.0 - degrees).to_radians();
    let mut dice = Dice(23);
    let mut worst = 0.0f64;
    let mut deepest = 0.0f64;
    for k in 0..count {
        let body = stone(&mut dice);
        let stiffness = if body.shape().dimension() == 2 { 3e8 } else { 3e6 };
        let law = Material {
            normal_stiffness: stiffness,
            ..material(1.0, 1.0, if k % 2 == 0 { 0.0 } else { 0.3 })
        };
        let (most, depth) = throw(&body, &wall, law, steepest, &mut dice);
        worst = worst.max(most);
        deepest = deepest.max(depth / body.radius());
    }
    println!("{name}: energy rises by {worst:.1e} at most, {deepest:.1e} of the radius deep");
    assert!(deepest > 0.0 && worst < 1.5e-3, "{name}: {worst:e} {deepest:e}");
}

#[test]
fn stones_bounce_off_corners_of_any_angle() {
    for degrees in [20.0, 40.0, 60.0, 90.0, 120.0, 160.0] {
        for corners in 3..=8 {
            let wall = Obstacle::outlines(&[tip(degrees).to_vec()], &room(2)).unwrap();
            let name = format!("{corners} corners on {degrees} degrees");
            throw_all(&name, degrees, wall, 34, |dice| free(stone(corners, dice)));
        }
        let wall = Obstacle::outlines(&[tip(degrees).to_vec()], &room(2)).unwrap();
        let ellipse = || free(Ellipse::new([0.014, 0.006]));
        let name = format!("ellipses on {degrees} degrees");
        throw_all(&name, degrees, wall, 34, |_| ellipse());
    }
}

#[test]
fn polyhedra_bounce_off_edges_of_any_angle() {
    for degrees in [20.0, 40.0, 60.0, 90.0, 130.0] {
        let name = format!("polyhedra on {degrees} degrees");
        throw_all(&name, degrees, ridge(degrees), 60, |dice| {
            let mut at =
                || 0.006 * vector![dice.about_zero(), dice.about_zero(), dice.about_zero()];
            let corners: Vec<_> = (0..9).map(|_| at()).collect();
            let triangles: Vec<_> =
                corners.windows(3).map(|three| [three[0], three[1], three[2]]).collect();
            free(Polyhedron::new(&triangles, 0.0).unwrap())
        });
    }
}

#[test]
fn stones_bounce_off_walls_thinner_than_their_skins() {
    for width in [2e-3, 5e-4, 1e-4, 2e-5] {
        for corners in [3, 4, 6] {
            let name = format!("{corners} corners on {width} m");
            throw_all(&name, 0.0, blade(width), 40, |dice| free(stone(corners, dice)));
        }
    }
}
