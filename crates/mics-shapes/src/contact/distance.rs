//! The nearest points of two convex parts.
//!
//! ```text
//!        __                    n, length d
//!       /A \ a o--------o b /\      ellipsoids, balls            [`crate::contact::support`]
//!       \__/               /B \     polytopes                    [`crate::contact::polytope`]
//!                                   a curved body and another    [`crate::contact::beside`]
//!                                   two, one a superquadric      [`crate::contact::smooth`]
//! ```

use super::{smooth, support};
use crate::contact::beside::Beside;
use crate::contact::part::{Core, Part, Polytope};
use crate::contact::polytope::{Feature, meet};
use crate::contact::pose::{Closest, Placed, Pose};
use nalgebra::Vector3;

/// The nearest points of two parts of bodies in these poses; `guess` is a direction from the first
/// to the second, not zero. `None` where cores overlap by more than what is nearest says.
pub fn closest(a: &Part, at: &Pose, b: &Part, to: &Pose, guess: &Vector3<f64>) -> Option<Closest> {
    closest_of([a, b], &[Placed::new(a, at), Placed::new(b, to)], guess)
}

/// The nearest points of two parts at their places; `guess` and `None` as of [`closest`].
pub(crate) fn closest_of(
    [a, b]: [&Part; 2],
    cores: &[Placed<'_>; 2],
    guess: &Vector3<f64>,
) -> Option<Closest> {
    let rounding = a.rounding + b.rounding;
    let found = match (&a.core, &b.core) {
        (Core::Point, Core::Point) => {
            let way = cores[1].place - cores[0].place;
            let normal = way.try_normalize(0.0)?;
            let points = [cores[0].place, cores[1].place];
            return Some(Closest { normal, distance: way.norm() - rounding, points });
        }
        (Core::Polytope(one), Core::Polytope(other)) => {
            let sides = [&cores[0], &cores[1]];
            let (nearest, _) = meet(sides, [one, other], [a.rounding, b.rounding], guess);
            let Feature { distance, normal, points, .. } = nearest;
            apart(cores, a.radius + b.radius, Closest { normal, distance, points })?
        }
        (Core::Polytope(polytope), _) => {
            let found = beside_polytope(polytope, &cores[0], &cores[1], guess)?;
            apart(cores, a.radius + b.radius, found)?
        }
        (_, Core::Polytope(polytope)) => {
            let found = beside_polytope(polytope, &cores[1], &cores[0], &-guess)?;
            apart(cores, a.radius + b.radius, found.turned())?
        }
        (Core::Superquadric { .. }, Core::Point) => beside_point(&cores[0], &cores[1].place)?,
        (Core::Point, Core::Superquadric { .. }) => {
            beside_point(&cores[1], &cores[0].place)?.turned()
        }
        (Core::Superquadric { .. }, _) | (_, Core::Superquadric { .. }) => {
            smooth::closest(cores, guess)?
        }
        _ => support::closest(cores, guess)?,
    };
    Some(Closest { distance: found.distance - rounding, ..found })
}

/// The nearest points of two cores of this size together (m), where they are as far apart along
/// their normal: cores that overlap too much are not.
fn apart(cores: &[Placed<'_>; 2], size: f64, found: Closest) -> Option<Closest> {
    let normal = &found.normal;
    let shown = (cores[1].support(&-normal) - cores[0].support(normal)).dot(normal);
    (found.distance - shown <= 1e-6 * size).then_some(found)
}

/// The nearest points of a polytope and another core.
fn beside_polytope(
    polytope: &Polytope,
    side: &Placed<'_>,
    other: &Placed<'_>,
    guess: &Vector3<f64>,
) -> Option<Closest> {
    let back = side.orientation.inverse();
    let orientation = back * other.orientation;
    let middle = back * (other.place - side.place);
    let (place, up, distance) = match other.inset() {
        0.0 => {
            let (distance, away) = polytope.beside(&middle);
            (middle - distance * away, away, distance)
        }
        inset => {
            let seen = Placed { core: other.core, orientation: &orientation, place: middle };
            let foot = Beside::new(seen)?.nearest_of(polytope, &(back * guess));
            (foot.place, foot.up, foot.gap + inset)
        }
    };
    let normal = side.orientation * up;
    let point = side.at(&place);
    Some(Closest { normal, distance, points: [point, point + distance * normal] })
}

/// The nearest points of a curved body and a point.
fn beside_point(placed: &Placed<'_>, point: &Vector3<f64>) -> Option<Closest> {
    let foot = Beside::new(*placed)?.foot(&[*point], &Vector3::zeros());
    let distance = foot.gap + placed.inset();
    let points = [point + distance * foot.up, *point];
    Some(Closest { normal: -foot.up, distance, points })
}
