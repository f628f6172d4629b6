//! The nearest points of two convex parts.
//!
//! ```text
//!        __                 n, length d          v = b - a of cores, by the algorithm of Gilbert,
//!       /A \ a o--------o b /\                   Johnson and Keerthi: which corners, edges or
//!       \__/               /B \                  faces of polytopes are nearest
//! ```
//! For smooth cores that is the start of Newton's method ([`crate::smooth`]). (parry3d's version of
//! the algorithm stops at 5e-8 of the distance, which leaves 3e-4 of the normal near edges, and
//! counts lengths in absolute terms.)

use crate::part::{Core, Part};
use crate::placed::{Closest, NONE, Placed, Pose};
use crate::simplex::{Corner, Directions, Simplex};
use crate::smooth::refine;
use crate::support;
use nalgebra::Vector3;

/// Most iterations.
const MOST: usize = 100;

/// The nearest points of two parts of bodies in these poses; `guess` is a direction from the first
/// to the second, not zero. `None` where their cores overlap.
pub fn closest(a: &Part, at: &Pose, b: &Part, to: &Pose, guess: &Vector3<f64>) -> Option<Closest> {
    let cores = [Placed::new(a, at), Placed::new(b, to)];
    let rounding = a.rounding + b.rounding;
    if let (Core::Point, Core::Point) = (&a.core, &b.core) {
        let way = cores[1].place - cores[0].place;
        let normal = way.try_normalize(0.0)?;
        let points = [cores[0].place, cores[1].place];
        return Some(Closest { normal, distance: way.norm() - rounding, points });
    }
    if support::is_known(&cores) {
        let found = support::closest(&cores, guess)?;
        return Some(Closest { distance: found.distance - rounding, ..found });
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
        (_, [true, _] | [_, true]) => 3e-14,
        _ => 1e-6,
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
        let before = simplex;
        let next = simplex.add(corner);
        let scale = corner.way().norm();
        if next.norm() <= NONE * scale {
            return None;
        }
        if next.norm() >= length * (1.0 - 1e-15) {
            if next.norm() > length {
                simplex = before;
            }
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
