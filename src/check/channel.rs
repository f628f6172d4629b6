//! Channels between obstacles, or between an obstacle and a wall of the box, that have too few
//! cells.
//!
//! ```text
//!   #######################
//!   -----------------------  wall of an obstacle or of the box
//!         ^  n                 rays along the normals of the walls of obstacles to the next wall
//!         |                    that faces them, no further than it takes for enough cells
//!   ------o----------------
//!   #######################
//! ```

use crate::config::{Case, Side};
use crate::particles::Body;
use crate::scene::Scene;
use crate::words::brief;
use nalgebra::Vector3;

/// Cells across a channel below which its flow is not resolved: through two it is 89 % too much.
const ENOUGH: f64 = 4.0;

/// Cosine of the largest angle between two walls that bound a channel: wider ones are a corner.
const FACING: f64 = -0.87;

/// Gaps of fewer spacings are none: the two stand on each other.
const CLOSED: f64 = 1e-6;

/// The narrowest channel of a case: its width (m), what bounds it, and the middle of it (m).
struct Channel {
    width: f64,
    between: [String; 2],
    middle: Vector3<f64>,
}

/// The narrowest channel beside an obstacle, where it has too few cells.
pub fn narrow<const D: usize>(case: &Case, scene: &Scene<D>) -> Option<String> {
    let h = case.widest_spacing();
    let bodies = &scene.state.bodies;
    let obstacles = || bodies.iter().enumerate().filter(|(_, body)| body.shape().is_obstacle());
    let found = obstacles().filter_map(|(k, body)| Channel::beside(case, bodies, k, body, h));
    let Channel { width, between: [one, other], middle } =
        found.min_by(|a, b| a.width.total_cmp(&b.width))?;
    let place: Vec<_> = middle.iter().take(D).map(|x| brief(*x)).collect();
    Some(format!(
        "warning      the channel between {one} and {other} at [{}] m, {} m wide, has {:.1} cells, \
        and {ENOUGH} or more are needed: its flow is too fast, through two cells by 89 %",
        place.join(", "),
        brief(width),
        width / h
    ))
}

impl Channel {
    /// The narrowest beside the walls of the obstacle `k`.
    fn beside(case: &Case, bodies: &[Body], k: usize, body: &Body, h: f64) -> Option<Channel> {
        let orientation = body.orientation();
        let shape = body.shape();
        let mut narrowest: Option<Channel> = None;
        let obstacle = shape.obstacle()?;
        let is_joined =
            |other: &Body| other.shape().obstacle().is_some_and(|o| o.is_one_with(obstacle));
        // Obstacles that are one solid with it have no walls within each other.
        let is_apart = |other: &Body| other.shape().is_obstacle() && !is_joined(other);
        for point in shape.surface(h) {
            let foot = orientation * point.place;
            let n = orientation * point.normal;
            let at = body.centre + foot;
            let most = narrowest.as_ref().map_or(ENOUGH * h * (1.0 - 1e-9), |c| c.width);
            let covered = |other: &Body| {
                let arm = at - other.centre;
                is_apart(other) && other.distance(&arm) < CLOSED * h
            };
            if bodies.iter().any(covered) {
                continue;
            }
            let own = shape.turned(&orientation).meets_itself(&foot, &n).map(|width| {
                let beyond = orientation.inverse() * (foot + (width + CLOSED * h) * n);
                let owner = obstacle.owner(&beyond);
                let is_it = |other: &Body| {
                    is_joined(other)
                        && other.shape().obstacle().is_some_and(|o| o.number() == owner)
                };
                (width, bodies.iter().position(is_it).unwrap_or(k))
            });
            let others = bodies.iter().enumerate().filter_map(|(j, other)| {
                let way = other.centre - at;
                let near = is_apart(other) && other.distance(&-way) < most;
                let width = if near { other.placed().turned().meets(&way, &n, most) } else { None };
                Some((width?, j))
            });
            let facing = |width: f64, j: usize| {
                let other = &bodies[j];
                let arm = at + width * n - other.centre;
                other.placed().turned().nearest(&arm).normal.dot(&n) < FACING
            };
            let met = own.into_iter().chain(others).filter(|(width, j)| facing(*width, *j));
            let walls = met.map(|(width, j)| (width, case.called(j)));
            let sides = sides_along(case, &at, &n);
            let all = walls.chain(sides).filter(|(width, _)| (CLOSED * h..most).contains(width));
            if let Some((width, other)) = all.min_by(|a, b| a.0.total_cmp(&b.0)) {
                let middle = at + 0.5 * width * n;
                narrowest = Some(Channel { width, between: [case.called(k), other], middle });
            }
        }
        narrowest
    }
}

/// The walls of the box that face a point (m) along a normal, and how far they are (m).
fn sides_along(case: &Case, at: &Vector3<f64>, n: &Vector3<f64>) -> Vec<(f64, String)> {
    let wall = |side: &Side| matches!(side, Side::Wall | Side::MovingWall(_));
    let sides = case.sides().enumerate().filter(|(_, (_, side))| wall(side));
    let facing = sides.filter_map(|(face, (name, _))| {
        let axis = face / 2;
        let high = face % 2 == 1;
        let along = if high { n[axis] } else { -n[axis] };
        let distance = if high { case.domain.size[axis] - at[axis] } else { at[axis] };
        (along > -FACING).then(|| (distance / along, format!("the side {name}")))
    });
    facing.collect()
}
