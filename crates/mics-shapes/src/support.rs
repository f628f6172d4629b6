//! The nearest points of two ellipsoids or balls, and of one and a corner, an edge or a face, by
//! how far an ellipsoid reaches in a direction:
//!
//! ```text
//!        _ n              h(n) = sqrt(n.M n)      M = R diag(a^2) R^T
//!      .'/'.              x(n) = M n/h            the point there
//!     ( o-x-)----->       W(n) = (M - x x^T)/h    how it moves with n: radii of curvature
//!      '._.'   h
//!
//!   distance of two = max over n of  g(n) = n.c - h_A(n) - h_B(n)     c: from middle to middle
//!   Newton's method   (g + W_A + W_B) dn = (c - x_A - x_B)            across n
//! ```
//! That holds also where they overlap, by less than the sum of their radii of curvature.

use crate::ellipse;
use crate::part::Core;
use crate::placed::{Closest, Placed};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Most steps of Newton's method, and a step (rad) that is the last.
const MOST: usize = 40;
const LAST: f64 = 1e-9;
/// The longest step (rad), and one where the function is not concave.
const LONGEST: f64 = 0.5;
const UPHILL: f64 = 0.3;

/// An ellipsoid, an ellipse in 2D or a point about its middle, in the axes of the box.
#[derive(Clone, Copy, Debug)]
struct Support {
    /// M (m2).
    matrix: Matrix3<f64>,
    /// The skin within its surface (m).
    inset: f64,
    /// Whether all of it lies in the plane z = 0.
    flat: bool,
}

impl Support {
    /// That of a core; none of another one.
    fn of(placed: &Placed<'_>) -> Option<Support> {
        match placed.core {
            Core::Point => Some(Support { matrix: Matrix3::zeros(), inset: 0.0, flat: false }),
            Core::Ellipsoid { half, inset } => {
                let turn = placed.orientation.matrix();
                let squares = Matrix3::from_diagonal(&half.component_mul(half));
                let matrix = turn * squares * turn.transpose();
                Some(Support { matrix, inset: *inset, flat: half.z == 0.0 })
            }
            Core::Superquadric { .. } | Core::Polytope(_) => None,
        }
    }

    /// h (m), and x (m).
    fn along(&self, n: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let far = self.matrix * n;
        let reach = far.dot(n).sqrt();
        (reach, if reach > 0.0 { far / reach } else { far })
    }

    /// `s.W t` of two directions across n (m).
    fn bend(&self, (reach, x): &(f64, Vector3<f64>), s: &Vector3<f64>, t: &Vector3<f64>) -> f64 {
        let own = s.dot(&(self.matrix * t)) - x.dot(s) * x.dot(t);
        if *reach > 0.0 { own / reach } else { 0.0 }
    }
}

/// Two of them, seen along a direction.
struct Seen {
    normal: Vector3<f64>,
    /// g (m).
    gap: f64,
    /// h and x of both; the second one's is that along -n, from its middle, with the sign changed.
    sides: [(f64, Vector3<f64>); 2],
}

impl Seen {
    fn along(pair: &[Support; 2], way: &Vector3<f64>, normal: Vector3<f64>) -> Seen {
        let sides = [pair[0].along(&normal), pair[1].along(&normal)];
        Seen { normal, gap: normal.dot(way) - sides[0].0 - sides[1].0, sides }
    }

    /// How far Newton's method turns the normal (rad), and whereto.
    fn turn(&self, pair: &[Support; 2], way: &Vector3<f64>) -> Vector3<f64> {
        let flat = pair[0].flat || pair[1].flat;
        let [s, t] = across(&self.normal, flat);
        let rest = way - self.sides[0].1 - self.sides[1].1;
        let bend = |s: &Vector3<f64>, t: &Vector3<f64>| {
            pair[0].bend(&self.sides[0], s, t) + pair[1].bend(&self.sides[1], s, t)
        };
        let slope = Vector2::new(rest.dot(&s), if flat { 0.0 } else { rest.dot(&t) });
        let (ss, st) = (self.gap + bend(&s, &s), if flat { 0.0 } else { bend(&s, &t) });
        let tt = if flat { 1.0 } else { self.gap + bend(&t, &t) };
        let determinant = ss * tt - st * st;
        let turn = if determinant > 0.0 && ss > 0.0 {
            Matrix2::new(tt, -st, -st, ss) * slope / determinant
        } else {
            slope * (UPHILL / slope.norm().max(f64::MIN_POSITIVE))
        };
        turn.x * s + turn.y * t
    }
}

/// Two directions across a normal, the first of them in the plane of it in 2D.
fn across(n: &Vector3<f64>, flat: bool) -> [Vector3<f64>; 2] {
    let s = if flat || n.z.abs() < 0.9 {
        Vector3::new(-n.y, n.x, 0.0).normalize()
    } else {
        Vector3::new(0.0, -n.z, n.y).normalize()
    };
    [s, n.cross(&s)]
}

/// Whether the nearest points of two cores are found here.
pub(crate) fn is_known(cores: &[Placed<'_>; 2]) -> bool {
    cores.iter().all(|core| matches!(core.core, Core::Point | Core::Ellipsoid { .. }))
}

/// The nearest points of two cores; `guess` is a direction from the first to the second. `None` of
/// others than ellipsoids and points, and without a direction.
pub(crate) fn closest(cores: &[Placed<'_>; 2], guess: &Vector3<f64>) -> Option<Closest> {
    let pair = [Support::of(&cores[0])?, Support::of(&cores[1])?];
    let way = cores[1].place - cores[0].place;
    let mut seen = Seen::along(&pair, &way, guess.try_normalize(0.0)?);
    for _ in 0..MOST {
        let whole = seen.turn(&pair, &way);
        let size = whole.norm();
        let mut turn = whole * (LONGEST / size.max(LONGEST));
        let least = seen.gap - 1e-15 * (seen.sides[0].0 + seen.sides[1].0);
        seen = loop {
            let next = Seen::along(&pair, &way, (seen.normal + turn).normalize());
            if next.gap >= least || turn.norm() < 1e-12 {
                break next;
            }
            turn *= 0.5;
        };
        if size < LAST {
            break;
        }
    }
    let Seen { normal, gap, sides: [(_, x), (_, y)] } = seen;
    let points =
        [cores[0].place + x - pair[0].inset * normal, cores[1].place - y + pair[1].inset * normal];
    Some(Closest { normal, distance: gap + pair[0].inset + pair[1].inset, points })
}

/// An ellipsoid at its place, beside a fixed surface.
pub(crate) struct Beside<'a> {
    pub placed: &'a Placed<'a>,
    /// Half axes of its surface (m); that along z zero in 2D.
    pub half: &'a Vector3<f64>,
}

impl Beside<'_> {
    /// The signed distance of a point (m) from its surface (m), and the direction from the point
    /// to it.
    pub fn corner(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let half = self.half;
        let own = self.placed.orientation.inverse_transform_vector(&(point - self.placed.place));
        let (foot, normal) = if half.z == 0.0 {
            let (foot, normal) = ellipse::nearest([half.x, half.y], [own.x, own.y]);
            (Vector3::new(foot[0], foot[1], own.z), Vector3::new(normal[0], normal[1], 0.0))
        } else {
            let (foot, normal) = ellipse::nearest((*half).into(), own.into());
            (foot.into(), normal.into())
        };
        ((own - foot).dot(&normal), -(self.placed.orientation * normal))
    }

    /// The point of the surface (m) that lies furthest along `n`.
    pub fn furthest(&self, n: &Vector3<f64>) -> Vector3<f64> {
        let own = self.half.component_mul(&self.placed.orientation.inverse_transform_vector(n));
        self.placed.place + self.placed.orientation * (self.half.component_mul(&own) / own.norm())
    }

    /// The signed distance (m) of the line through a point (m) along a direction, the direction
    /// from it to the surface, and how far from the point along the line it is nearest (m); 3D.
    /// Newton's method on the angle of the normal about the line, from a guess of it.
    pub fn line(
        &self,
        point: &Vector3<f64>,
        along: &Vector3<f64>,
        guess: &Vector3<f64>,
    ) -> Option<(f64, Vector3<f64>, f64)> {
        let way = point - self.placed.place;
        let first = (guess - guess.dot(along) * along).try_normalize(1e-300)?;
        let second = along.cross(&first);
        let scaled = [first, second, *along].map(|direction| {
            self.half.component_mul(&self.placed.orientation.inverse_transform_vector(&direction))
        });
        let [p, q, e] = scaled;
        // The section across the line: h^2 = n.S n.
        let section = Matrix2::new(p.dot(&p), p.dot(&q), p.dot(&q), q.dot(&q));
        let place = Vector2::new(way.dot(&first), way.dot(&second));
        let mut n = Vector2::x();
        for _ in 0..MOST {
            let far = section * n;
            let reach = n.dot(&far).sqrt();
            let side = Vector2::new(-n.y, n.x);
            let slope = side.dot(&(place - far / reach));
            let bend = section.determinant() / reach.powi(3);
            let gap = n.dot(&place) - reach;
            let step = (slope / (gap + bend).max(0.05 * bend)).clamp(-LONGEST, LONGEST);
            n = (n + step * side).normalize();
            if step.abs() < LAST {
                break;
            }
        }
        let reached = n.x * p + n.y * q;
        let normal = n.x * first + n.y * second;
        let foot = reached.dot(&e) / reached.norm() - way.dot(along);
        Some((n.dot(&place) - reached.norm(), -normal, foot))
    }
}
