//! The nearest points of a superquadric and another curved body, by Newton's method on both
//! surfaces.
//!
//! ```text
//!   r = (y - x)_t,  g = n(x) + m(y)      x, y on both surfaces, n, m outward normals there:
//!              both zero where they are nearest,  d = n.(y - x)
//!   dy = (I + d W) dx - r,   W dx + V dy = -g          W, V: how n and m turn along the surfaces
//!   (W + V + d V W) dx = V r - g
//! ```
//! The places, not the directions, are unknowns: on the flats of a superquadric a place moves a
//! long way as the normal hardly turns. The surfaces are those of the bodies, parallel to their
//! cores. It starts from what lies furthest along a guessed normal, where both are nearest if that
//! is known from a moment before, and else from the algorithm of Gilbert, Johnson and Keerthi
//! ([`crate::contact::simplex`]).

use crate::contact::part::Core;
use crate::contact::pose::{Closest, Placed};
use crate::contact::simplex::{self, NONE};
use crate::surface::superquadric::SuperquadricSurface;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Most steps, and halvings of one.
const MOST: usize = 40;
/// A change (of the body's width) that is none.
const SAME: f64 = 1e-13;
/// Turning that every surface has (rad, over its width): two flats of which the place is open.
const LEAST_TURN: f64 = 1e-9;
/// Angle (rad) between the normals, and between them and the way, of points that are nearest.
const NEAREST: f64 = 1e-7;

/// The surface of a curved body before its skin was taken off.
struct Side<'a> {
    placed: &'a Placed<'a>,
    surface: SuperquadricSurface,
    width: f64,
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
struct Point {
    place: Vector3<f64>,
    normal: Vector3<f64>,
    /// Derivative of the normal along it (1/m).
    turn: Matrix3<f64>,
    /// The point of the core below it (m).
    core: Vector3<f64>,
}

impl<'a> Side<'a> {
    fn of(placed: &'a Placed<'a>) -> Option<Side<'a>> {
        let (half, exponents) = match placed.core {
            Core::Ellipsoid { half, .. } => (*half, [2.0; 2]),
            Core::Superquadric { half, exponents, .. } => (*half, *exponents),
            Core::Point | Core::Polytope(_) => return None,
        };
        Some(Side { placed, surface: SuperquadricSurface::new(half, exponents), width: half.min() })
    }

    /// The point of it that lies in the direction of another one from the middle.
    fn below(&self, place: &Vector3<f64>) -> Point {
        let own = self.placed.orientation.inverse_transform_vector(&(place - self.placed.place));
        let own = own / self.surface.scale(&own);
        let (normal, bend) = self.surface.bend(&own);
        let turn = self.placed.orientation.matrix();
        let place = self.placed.at(&own);
        let normal = turn * normal;
        let core = place - self.placed.inset() * normal;
        Point { place, normal, turn: turn * bend * turn.transpose(), core }
    }

    /// The point of it that lies furthest along a direction.
    fn furthest(&self, n: &Vector3<f64>) -> Point {
        self.below(&(self.placed.support(n) + self.placed.inset() * n))
    }
}

/// The nearest points of two curved cores; `guess` is a direction from the first to the second.
/// `None` where they overlap.
pub(crate) fn closest(cores: &[Placed<'_>; 2], guess: &Vector3<f64>) -> Option<Closest> {
    let sides = [Side::of(&cores[0])?, Side::of(&cores[1])?];
    let guess = guess.try_normalize(0.0)?;
    let warm = newton(&sides, [sides[0].furthest(&guess), sides[1].furthest(&-guess)]);
    warm.or_else(|| {
        let [x, y] = simplex::search(cores, &guess)?;
        newton(&sides, [sides[0].below(&x), sides[1].below(&y)])
    })
}

/// The nearest points from about two others, where it comes to them.
fn newton(sides: &[Side<'_>; 2], start: [Point; 2]) -> Option<Closest> {
    let width = sides[0].width.max(sides[1].width);
    let [mut one, mut its] = start;
    for _ in 0..MOST {
        let (dx, dy) = step(&one, &its, width);
        let square = (its.core - one.core).norm_squared();
        // The way between the cores is the shortest at the end.
        let mut part = 1.0;
        (one, its) = loop {
            let next = sides[0].below(&(one.place + part * dx));
            let point = sides[1].below(&(its.place + part * dy));
            let shorter = (point.core - next.core).norm_squared() <= square * (1.0 + 1e-14);
            if shorter || part < 1e-3 {
                break (next, point);
            }
            part *= 0.5;
        };
        if dx.norm().max(dy.norm()) < SAME * width {
            break;
        }
    }
    let way = its.core - one.core;
    let apart = sides[1].placed.place - sides[0].placed.place;
    let distance = way.norm();
    if distance <= NONE * apart.norm() {
        return None;
    }
    let normal = way / distance;
    let off = (one.normal - normal).norm().max((its.normal + normal).norm());
    let points = [one.core, its.core];
    (off < NEAREST).then_some(Closest { normal, distance, points })
}

/// The steps of both points.
fn step(one: &Point, its: &Point, width: f64) -> (Vector3<f64>, Vector3<f64>) {
    let n = one.normal;
    let about = if n.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
    let second = (about - about.dot(&n) * n).normalize();
    let tangents = [second.cross(&n), second];
    let flat = |m: &Matrix3<f64>| Matrix2::from_fn(|i, j| tangents[i].dot(&(m * tangents[j])));
    let along = |v: &Vector3<f64>| Vector2::new(tangents[0].dot(v), tangents[1].dot(v));
    let way = its.place - one.place;
    let r = along(&way);
    let d = way.dot(&n);
    let turn = flat(&one.turn);
    let other = flat(&its.turn);
    let least = Matrix2::from_diagonal_element(LEAST_TURN / width);
    let matrix = turn + other + d * other * turn + least;
    let given = other * r - along(&(n + its.normal));
    let moved = matrix.try_inverse().map_or_else(Vector2::zeros, |inverse| inverse * given);
    let moved = moved * (0.3 * width / moved.norm()).min(1.0);
    let its_moved = moved + d * turn * moved - r;
    let whole = |v: Vector2<f64>| v[0] * tangents[0] + v[1] * tangents[1];
    (whole(moved), whole(its_moved))
}
