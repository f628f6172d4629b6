//! The nearest points of two ellipsoids, or of one and a ball, by how far an ellipsoid reaches in a
//! direction:
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

use crate::contact::part::Core;
use crate::contact::pose::{Closest, Placed};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Most steps of Newton's method, and a step (rad) that is the last: what is left is about its
/// square.
const MOST: usize = 40;
const LAST: f64 = 1e-5;
/// The longest step (rad), and one where the function is not concave.
const LONGEST: f64 = 0.5;
const UPHILL: f64 = 0.3;

/// An ellipsoid, an ellipse in 2D or a point about its middle, in the axes of the box.
#[derive(Clone, Copy, Debug)]
struct Support {
    /// B = R diag(a) (m).
    axes: Matrix3<f64>,
    /// The skin within its surface (m).
    inset: f64,
    /// Whether all of it lies in the plane z = 0.
    flat: bool,
}

/// One along a direction: h (m), and x (m).
#[derive(Clone, Copy, Debug)]
struct Reached {
    height: f64,
    point: Vector3<f64>,
}

impl Support {
    /// The support of a core that is a point or an ellipsoid; none of another one.
    fn of(placed: &Placed<'_>) -> Option<Support> {
        match placed.core {
            Core::Point => Some(Support { axes: Matrix3::zeros(), inset: 0.0, flat: false }),
            Core::Ellipsoid { half, inset } => {
                let mut axes = *placed.orientation.matrix();
                for k in 0..3 {
                    axes.column_mut(k).scale_mut(half[k]);
                }
                Some(Support { axes, inset: *inset, flat: half.z == 0.0 })
            }
            Core::Superquadric { .. } | Core::Polytope(_) => None,
        }
    }

    fn along(&self, n: &Vector3<f64>) -> Reached {
        let own = self.axes.tr_mul(n);
        let height = own.norm();
        let point = self.axes * own;
        Reached { height, point: if height > 0.0 { point / height } else { point } }
    }

    /// `s.W s`, `s.W t` and `t.W t` of two directions across n (m); the first alone in 2D.
    fn bends(&self, at: &Reached, [s, t]: &[Vector3<f64>; 2], flat: bool) -> [f64; 3] {
        if at.height == 0.0 {
            return [0.0; 3];
        }
        let own = self.axes.tr_mul(s);
        let along = at.point.dot(s);
        let ss = own.norm_squared() - along * along;
        if flat {
            return [ss / at.height, 0.0, 0.0];
        }
        let other = self.axes.tr_mul(t);
        let across = at.point.dot(t);
        let st = own.dot(&other) - along * across;
        let tt = other.norm_squared() - across * across;
        [ss, st, tt].map(|bend| bend / at.height)
    }
}

/// Two of them, seen along a direction.
struct Seen {
    normal: Vector3<f64>,
    /// g (m).
    gap: f64,
    /// The second one's is that along -n, from its middle, with the sign changed.
    sides: [Reached; 2],
}

impl Seen {
    fn along(pair: &[Support; 2], way: &Vector3<f64>, normal: Vector3<f64>) -> Seen {
        let sides = [pair[0].along(&normal), pair[1].along(&normal)];
        Seen { normal, gap: normal.dot(way) - sides[0].height - sides[1].height, sides }
    }

    /// Change of the normal by a step of Newton's method (rad).
    fn turn(&self, pair: &[Support; 2], way: &Vector3<f64>) -> Vector3<f64> {
        let flat = pair[0].flat || pair[1].flat;
        let tangents = across(&self.normal, flat);
        let rest = way - self.sides[0].point - self.sides[1].point;
        let one = pair[0].bends(&self.sides[0], &tangents, flat);
        let other = pair[1].bends(&self.sides[1], &tangents, flat);
        let [s, t] = tangents;
        let ss = self.gap + one[0] + other[0];
        let slope = rest.dot(&s);
        if flat {
            let turn = if ss > 0.0 { slope / ss } else { UPHILL.copysign(slope) };
            return turn * s;
        }
        let st = one[1] + other[1];
        let tt = self.gap + one[2] + other[2];
        let slope = Vector2::new(slope, rest.dot(&t));
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

/// The nearest points of two cores; `guess` is a direction from the first to the second. `None` of
/// others than ellipsoids and points, and without a direction.
pub(crate) fn closest(cores: &[Placed<'_>; 2], guess: &Vector3<f64>) -> Option<Closest> {
    let pair = [Support::of(&cores[0])?, Support::of(&cores[1])?];
    let way = cores[1].place - cores[0].place;
    let mut seen = Seen::along(&pair, &way, guess.try_normalize(0.0)?);
    // Deeper than soft contacts go: the guess may be far off.
    if seen.gap < -pair[0].inset - pair[1].inset {
        let centres = Seen::along(&pair, &way, way.try_normalize(0.0)?);
        seen = if centres.gap > seen.gap { centres } else { seen };
    }
    for _ in 0..MOST {
        let whole = seen.turn(&pair, &way);
        let size = whole.norm();
        let mut turn = whole * (LONGEST / size.max(LONGEST));
        let least = seen.gap - 1e-15 * (seen.sides[0].height + seen.sides[1].height);
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
    let Seen { normal, gap, sides: [x, y] } = seen;
    let points = [
        cores[0].place + x.point - pair[0].inset * normal,
        cores[1].place - y.point + pair[1].inset * normal,
    ];
    Some(Closest { normal, distance: gap + pair[0].inset + pair[1].inset, points })
}
