//! The nearest points of two cores of which one is smooth at least, by Newton's method on the
//! surfaces.
//!
//! ```text
//!   r = (y - x)_t,  g = n(x) + m(y)      x, y on both surfaces, n, m outward normals there:
//!              both zero where they are nearest,  d = n.(y - x)
//!   dy = (I + d W) dx - r,   W dx + V dy = -g          W, V: how n and m turn along the surfaces
//!   (W + V + d V W) dx = V r - g
//!              corner y     (I + d W) dx = r
//!              edge e       that across e, and  e.W dx = -e.n
//! ```
//! The places, not the directions, are unknowns: on the flats of a superquadric a place moves a
//! long way as the normal hardly turns. The surfaces are those of the bodies, parallel to their
//! cores.

use crate::part::{Core, nested};
use crate::placed::{Closest, NONE, Placed};
use crate::simplex::{Directions, Simplex};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Most steps, and halvings of one.
const MOST: usize = 40;
/// A change (of the body's width) that is none.
const SAME: f64 = 1e-13;
/// Turning that every surface has (rad, over its width): two flats of which the place is open.
const LEAST_TURN: f64 = 1e-9;

/// The surface of a smooth core before its skin was taken off.
struct Surface<'a> {
    placed: &'a Placed<'a>,
    /// One over the half axes (1/m), zero along those that are none.
    scale: Vector3<f64>,
    exponents: [f64; 2],
    inset: f64,
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
struct Point {
    place: Vector3<f64>,
    normal: Vector3<f64>,
    /// How the normal turns along it (1/m).
    turn: Matrix3<f64>,
}

impl<'a> Surface<'a> {
    fn of(placed: &'a Placed<'a>) -> Option<Surface<'a>> {
        let (half, exponents, inset) = match placed.core {
            Core::Ellipsoid { half, inset } => (half, [2.0, 2.0], *inset),
            Core::Superquadric { half, exponents, inset } => (half, *exponents, *inset),
            Core::Point | Core::Polytope(_) => return None,
        };
        let scale = half.map(|h| if h > 0.0 { 1.0 / h } else { 0.0 });
        Some(Surface { placed, scale, exponents, inset })
    }

    /// The point of it that lies in the direction of another one from the middle.
    fn below(&self, place: &Vector3<f64>) -> Point {
        let own = self.placed.orientation.inverse_transform_vector(&(place - self.placed.place));
        let (size, _, _) = nested(&self.scale, self.exponents, &own);
        let (_, gradient, bend) = nested(&self.scale, self.exponents, &(own / size));
        let turn = self.placed.orientation.matrix();
        Point {
            place: self.placed.at(&(own / size)),
            normal: turn * gradient.normalize(),
            turn: turn * bend * turn.transpose() / gradient.norm(),
        }
    }

    /// The point of the core below a point of the surface.
    fn core(&self, point: &Point) -> Vector3<f64> {
        point.place - self.inset * point.normal
    }
}

/// What lies across from a smooth core.
enum Across<'a> {
    Surface(Surface<'a>),
    /// A corner, edge or face: a point of it, and directions along it.
    Feature(Vector3<f64>, Directions),
}

impl Across<'_> {
    /// The point of it that is nearest to one of the first core, or about as near as another one:
    /// on the surface, and on its core.
    fn point(&self, place: &Vector3<f64>, about: &Vector3<f64>) -> (Point, Vector3<f64>) {
        match self {
            Across::Surface(surface) => {
                let point = surface.below(about);
                (point, surface.core(&point))
            }
            Across::Feature(at, frame) => {
                let way = place - at;
                let foot = at + (way - frame.across(&way));
                (Point { place: foot, normal: Vector3::zeros(), turn: Matrix3::zeros() }, foot)
            }
        }
    }
}

/// The nearest points of two cores, from about the simplex; the first or the second is smooth.
pub(crate) fn refine(cores: &[Placed<'_>; 2], simplex: &Simplex) -> Option<Closest> {
    let first = usize::from(!cores[0].is_smooth());
    let own = Surface::of(&cores[first])?;
    let other = &cores[1 - first];
    let corner = simplex.corners().next()?.0.points[1 - first];
    let edges = simplex.corners().map(|(c, _)| c.points[1 - first] - corner);
    let across = match Surface::of(other) {
        Some(surface) => Across::Surface(surface),
        None => Across::Feature(corner, Directions::of(edges.filter(|way| way.norm() > 0.0))),
    };
    let points = simplex.points();
    let (x, y) = nearest(&own, &across, points[first], points[1 - first])?;
    let distance = (y - x).norm();
    if distance <= NONE * (cores[1].place - cores[0].place).norm() {
        return None;
    }
    let (normal, points) =
        if first == 0 { ((y - x) / distance, [x, y]) } else { ((x - y) / distance, [y, x]) };
    Some(Closest { normal, distance, points })
}

/// The nearest points of a smooth core and what lies across, from about two others.
fn nearest(
    own: &Surface<'_>,
    across: &Across<'_>,
    x: Vector3<f64>,
    y: Vector3<f64>,
) -> Option<(Vector3<f64>, Vector3<f64>)> {
    if let Across::Feature(at, Directions([e, f])) = across
        && *f != Vector3::zeros()
    {
        // A face says the normal.
        let normal = e.cross(f);
        let normal = normal * (y - own.placed.place).dot(&normal).signum();
        let x = own.placed.support(&normal).0;
        return Some((x, x + (at - x).dot(&normal) * normal));
    }
    let width = 1.0 / own.scale.max();
    let mut one = own.below(&x);
    let (mut its, mut core) = across.point(&own.core(&one), &y);
    for _ in 0..MOST {
        let (dx, dy) = step(across, &one, &its, width);
        let square = (core - own.core(&one)).norm_squared();
        // The way between the cores is the shortest at the end.
        let mut part = 1.0;
        let next = loop {
            let next = own.below(&(one.place + part * dx));
            let (point, below) = across.point(&own.core(&next), &(its.place + part * dy));
            let shorter = (below - own.core(&next)).norm_squared() <= square * (1.0 + 1e-14);
            if shorter || part < 1e-3 {
                break (next, point, below);
            }
            part *= 0.5;
        };
        (one, its, core) = next;
        if dx.norm().max(dy.norm()) < SAME * width {
            break;
        }
    }
    Some((own.core(&one), core))
}

/// The steps of both points.
fn step(across: &Across<'_>, one: &Point, its: &Point, width: f64) -> (Vector3<f64>, Vector3<f64>) {
    let n = one.normal;
    let edge = match across {
        Across::Feature(_, Directions([e, _])) if *e != Vector3::zeros() => Some(*e),
        _ => None,
    };
    // Tangents; the second along the edge, or out of the plane in 2D.
    let about = edge.unwrap_or(if n.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() });
    let second = (about - about.dot(&n) * n).normalize();
    let tangents = [second.cross(&n), second];
    let flat = |m: &Matrix3<f64>| Matrix2::from_fn(|i, j| tangents[i].dot(&(m * tangents[j])));
    let along = |v: &Vector3<f64>| Vector2::new(tangents[0].dot(v), tangents[1].dot(v));
    let (way, turn) = (its.place - one.place, flat(&one.turn));
    let (r, d) = (along(&way), way.dot(&n));
    let (matrix, given) = match across {
        Across::Surface(_) => {
            let other = flat(&its.turn);
            let least = Matrix2::from_diagonal_element(LEAST_TURN / width);
            (turn + other + d * other * turn + least, other * r - along(&(n + its.normal)))
        }
        Across::Feature(..) => {
            let mut matrix = Matrix2::identity() + d * turn;
            let mut given = r;
            if edge.is_some() {
                matrix
                    .set_row(1, &(turn.row(1) + Matrix2::identity().row(1) * (LEAST_TURN / width)));
                given[1] = -about.dot(&n) / about.dot(&second);
            }
            (matrix, given)
        }
    };
    let moved = matrix.try_inverse().map_or_else(Vector2::zeros, |inverse| inverse * given);
    let moved = moved * (0.3 * width / moved.norm()).min(1.0);
    let its_moved = moved + d * turn * moved - r;
    let whole = |v: Vector2<f64>| v[0] * tangents[0] + v[1] * tangents[1];
    match across {
        Across::Surface(_) => (whole(moved), whole(its_moved)),
        Across::Feature(..) => (whole(moved), Vector3::zeros()),
    }
}
