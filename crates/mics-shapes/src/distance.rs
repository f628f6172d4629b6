//! The nearest points of two convex parts.
//!
//! ```text
//!   s(n) = min_b n.b - max_a n.a       how far the cores are apart along n, of length 1
//!   distance = max_n s(n)                    over all n: a concave function, its gradient b - a
//!   n' = n + d,  (H_a + H_b + s I) d = (b - a)_t        Newton, H: how the support points move
//! ```
//! The algorithm of Gilbert, Johnson and Keerthi finds which corners, edges or faces of polytopes
//! are nearest, and the direction for smooth cores roughly, which Newton's method makes exact among
//! the directions normal to that edge or face. (parry3d's version of it stops at 5e-8 of the
//! distance, which leaves 3e-4 of the normal near edges, and counts lengths in absolute terms.)

use crate::part::{Core, Part};
use crate::simplex::{Corner, Simplex};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Most iterations of both methods.
const MOST: usize = 100;
/// Distance of cores, of the way between the parts' places, below which they overlap.
const NONE: f64 = 1e-9;

/// Where a body is and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Its centre (m).
    pub place: Vector3<f64>,
    /// What brings its own axes into those of the box.
    pub orientation: Rotation3<f64>,
}

/// The nearest points of two parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// From the first to the second, of length 1.
    pub normal: Vector3<f64>,
    /// Between the surfaces (m), negative where they overlap.
    pub distance: f64,
    /// The nearest points of both cores (m).
    pub points: [Vector3<f64>; 2],
}

/// A core at its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed<'a> {
    pub core: &'a Core,
    pub orientation: &'a Rotation3<f64>,
    /// Of the core's origin (m).
    pub place: Vector3<f64>,
}

impl<'a> Placed<'a> {
    /// The core of a part of a body there.
    pub fn new(part: &'a Part, pose: &'a Pose) -> Placed<'a> {
        let place = pose.place + pose.orientation * part.place;
        Placed { core: &part.core, orientation: &pose.orientation, place }
    }

    /// A point of its own axes in those of the box (m).
    pub fn at(&self, own: &Vector3<f64>) -> Vector3<f64> {
        self.place + self.orientation * own
    }

    /// The point that lies furthest along `n` (m), and its number among the corners of a polytope.
    fn support(&self, n: &Vector3<f64>) -> (Vector3<f64>, u32) {
        let own = self.orientation.inverse_transform_vector(n);
        if let Core::Polytope(polytope) = self.core {
            let mut best = (f64::NEG_INFINITY, 0);
            for (k, corner) in polytope.corners.iter().enumerate() {
                let along = corner.dot(&own);
                if along > best.0 {
                    best = (along, k);
                }
            }
            return (self.at(&polytope.corners[best.1]), best.1 as u32);
        }
        (self.at(&self.core.support(&own)), 0)
    }

    /// How the support point moves with the direction `n` (m).
    fn bend(&self, n: &Vector3<f64>) -> Matrix3<f64> {
        let own = self.orientation.inverse_transform_vector(n);
        let turn = self.orientation.matrix();
        turn * self.core.bend(&own) * turn.transpose()
    }

    fn is_smooth(&self) -> bool {
        matches!(self.core, Core::Ellipsoid { .. } | Core::Superquadric { .. })
    }
}

/// The nearest points of two parts of bodies in these poses; `guess` is a direction from the first
/// to the second, not zero. `None` where their cores overlap.
pub fn closest(
    a: &Part,
    at: &Pose,
    b: &Part,
    to: &Pose,
    guess: &Vector3<f64>,
) -> Option<Closest> {
    let cores = [Placed::new(a, at), Placed::new(b, to)];
    let rounding = a.rounding + b.rounding;
    if let (Core::Point, Core::Point) = (&a.core, &b.core) {
        let way = cores[1].place - cores[0].place;
        let normal = way.try_normalize(0.0)?;
        let points = [cores[0].place, cores[1].place];
        return Some(Closest { normal, distance: way.norm() - rounding, points });
    }
    let found = search(&cores, guess)?;
    let found = match cores.iter().any(Placed::is_smooth) {
        true => refine(&cores, &found),
        false => flat(&found),
    };
    found.map(|found| Closest { distance: found.distance - rounding, ..found })
}

/// Finds the nearest corners, edges or faces of two cores, with a tolerance of the distance where
/// they are smooth.
fn search(cores: &[Placed<'_>; 2], guess: &Vector3<f64>) -> Option<Simplex> {
    let smooth = cores.each_ref().map(|core| core.is_smooth());
    let flat = cores.each_ref().map(|core| matches!(core.core, Core::Polytope(_)));
    let tolerance = match (smooth, flat) {
        ([false, false], _) => 1e-14,
        // The feature of the polytope has to be right.
        (_, [true, _] | [_, true]) => 1e-11,
        _ => 1e-2,
    };
    let mut simplex = Simplex::default();
    let mut way = guess.try_normalize(0.0).unwrap_or_else(Vector3::x);
    let mut length = f64::INFINITY;
    for _ in 0..MOST {
        let ((p, i), (q, j)) = (cores[0].support(&way), cores[1].support(&-way));
        let corner = Corner { points: [p, q], numbers: [i, j] };
        let known = !smooth[0] && !smooth[1] && simplex.contains(corner.numbers);
        let close = length - corner.way().dot(&way) <= tolerance * length;
        if length.is_finite() && (known || close) {
            break;
        }
        let next = simplex.add(corner);
        let scale = corner.way().norm();
        if next.norm() <= NONE * scale {
            return None;
        }
        if next.norm() >= length * (1.0 - 1e-15) {
            break;
        }
        length = next.norm();
        way = next / length;
    }
    length.is_finite().then_some(simplex)
}

/// Two polytopes: the simplex is exact, its normal that of the corners that it has.
fn flat(simplex: &Simplex) -> Option<Closest> {
    let mut corners = simplex.corners().map(|(corner, _)| corner.way());
    let first = corners.next()?;
    let frame = Directions::of(corners.map(|way| way - first));
    let way = frame.across(&frame.across(&first));
    let distance = way.norm();
    Some(Closest { normal: way.try_normalize(0.0)?, distance, points: simplex.points() })
}

/// Up to two directions of length 1, normal to each other.
#[derive(Clone, Copy, Debug, Default)]
struct Directions([Vector3<f64>; 2]);

impl Directions {
    fn of(ways: impl Iterator<Item = Vector3<f64>>) -> Directions {
        let (mut all, mut count) = (Directions::default(), 0);
        for way in ways {
            let across = all.across(&all.across(&way));
            if count < 2 && across.norm() > 1e-10 * way.norm() {
                all.0[count] = across.normalize();
                count += 1;
            }
        }
        all
    }

    /// The part of a vector across them.
    fn across(&self, v: &Vector3<f64>) -> Vector3<f64> {
        v - self.0.iter().map(|d| v.dot(d) * d).sum::<Vector3<f64>>()
    }
}

/// Smooth cores, or one and a feature of a polytope, while the direction is sought.
struct Refined<'a, 'b> {
    cores: &'a [Placed<'b>; 2],
    /// A point of the feature of each core that is not smooth.
    fixed: [Option<Vector3<f64>>; 2],
    /// Along the feature.
    frame: Directions,
}

impl Refined<'_, '_> {
    /// The support points along `n`.
    fn points(&self, n: &Vector3<f64>) -> [Vector3<f64>; 2] {
        [0, 1].map(|k| {
            let along = if k == 0 { *n } else { -n };
            self.fixed[k].unwrap_or_else(|| self.cores[k].support(&along).0)
        })
    }

    /// The step of Newton's method from `n`, with the way between the support points there.
    fn step(&self, n: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let [a, b] = self.points(n);
        let (way, turn) = (b - a, |v: &Vector3<f64>| {
            let v = self.frame.across(v);
            v - v.dot(n) * n
        });
        let tangent = turn(&way);
        let mut bend = Matrix3::from_diagonal_element(way.dot(n).max(1e-3 * way.norm()));
        for k in [0, 1].into_iter().filter(|k| self.fixed[*k].is_none()) {
            let own = self.cores[k].bend(&if k == 0 { *n } else { -n });
            let half = Matrix3::from_columns(&[0, 1, 2].map(|c| turn(&own.column(c).into())));
            let rows = half.transpose();
            bend += Matrix3::from_columns(&[0, 1, 2].map(|c| turn(&rows.column(c).into())));
        }
        (way, bend.try_inverse().map_or(tangent, |inverse| turn(&(inverse * tangent))))
    }

    /// How far along a step the cores are furthest apart.
    fn furthest(&self, n: &Vector3<f64>, step: &Vector3<f64>) -> f64 {
        let slope = |x: f64| {
            let m = (n + x * step).normalize();
            let [a, b] = self.points(&m);
            (b - a).dot(&(step - step.dot(&m) * m))
        };
        let (mut low, mut high) = (0.0, 1.0);
        if slope(high) >= 0.0 {
            return high;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if slope(middle) > 0.0 { &mut low } else { &mut high }) = middle;
            if high - low < 1e-3 * high {
                break;
            }
        }
        if low > 0.0 { low } else { high }
    }
}

/// The nearest points of two cores of which one is smooth, from about the simplex.
fn refine(cores: &[Placed<'_>; 2], simplex: &Simplex) -> Option<Closest> {
    let (first, _) = simplex.corners().next()?;
    let fixed = [0, 1].map(|k| (!cores[k].is_smooth()).then_some(first.points[k]));
    let edges = simplex.corners().skip(1).flat_map(|(corner, _)| {
        [0, 1].into_iter().filter(|k| fixed[*k].is_some()).map(|k| corner.points[k] - first.points[k])
    });
    let refined =
        Refined { cores, fixed, frame: Directions::of(edges.filter(|way| way.norm() > 0.0)) };
    let [p, q] = simplex.points();
    let mut n = refined.frame.across(&(q - p)).try_normalize(0.0)?;
    for _ in 0..MOST {
        let (way, step) = refined.step(&n);
        if step.norm() < 1e-14 {
            break;
        }
        let next = (n + step).normalize();
        let [a, b] = refined.points(&next);
        // The distance along n is the largest at the end: else the step was too long.
        n = if (b - a).dot(&next) >= way.dot(&n) - 1e-15 * way.norm() {
            next
        } else {
            (n + refined.furthest(&n, &step) * step).normalize()
        };
        if step.norm() < 1e-9 {
            break;
        }
    }
    let [a, b] = refined.points(&n);
    let distance = (b - a).dot(&n);
    // Of two smooth cores the one that is more bent says where.
    let flatter = || cores[0].bend(&n).trace() > cores[1].bend(&-n).trace();
    let points = match refined.fixed {
        [Some(_), _] => [b - distance * n, b],
        [None, None] if flatter() => [b - distance * n, b],
        _ => [a, a + distance * n],
    };
    (distance > NONE * (cores[1].place - cores[0].place).norm())
        .then_some(Closest { normal: n, distance, points })
}
