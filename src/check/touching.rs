//! The cost of contacts, before anything touches: copies of the bodies are let down one after the
//! other until they touch, and the contacts alone take a part of a step.
//!
//! ```text
//!       o   o          lowest first, along the axis on which gravity pulls the most, a body falls
//!    o    o     -->    onto another body, an obstacle or a wall, and into it by a resting overlap
//!   ___________          __o_o_oo____
//! ```

use super::stiffness::shortest;
use crate::config::{Case, Side, Substeps};
use crate::contact::Contacts;
use crate::geometry::shapes::Part;
use crate::particles::{Accelerations, Body, gap, nearest_image};
use crate::scene::Scene;
use crate::words::whole;
use nalgebra::Vector3;
use std::time::Instant;

/// Time (s) after which no further body is let down.
const LONGEST: f64 = 1.0;
/// Duration of the part of a step, over that of a contact: long enough for the substeps of each.
const CONTACTS: f64 = 4.0;
/// Overlap of a body at rest, over its radius: that of springs that an impact after a fall of a
/// diameter compresses by a fiftieth of it.
const RESTING: f64 = 1e-4;

/// The cost of contacts in a step in which bodies touch.
pub struct Touching {
    /// Number of free bodies that touch.
    touching: usize,
    /// Number of free bodies.
    free: usize,
    /// Substeps in a step.
    substeps: f64,
    /// Time that contacts add to a step (s).
    pub seconds: f64,
}

impl Touching {
    /// Measures it for steps of `dt` (s) on a part of one; `None` where nothing touches.
    pub fn measured<const D: usize>(case: &Case, scene: &Scene<D>, dt: f64) -> Option<Touching> {
        let chosen = case.contact.as_ref().is_some_and(|law| law.substeps == Substeps::Auto);
        let shortest = shortest(scene).filter(|_| chosen).unwrap_or(f64::INFINITY);
        let part = dt.min(CONTACTS * shortest);
        let mut contacts = scene.method.contacts()?.clone();
        let mut bodies = let_down(case, scene);
        let free = bodies.iter().filter(|body| body.freedom().is_some()).count();
        let pulls = pulls(case, &contacts, &bodies);
        let mut springs = contacts.untouched();
        let started = Instant::now();
        let turning = |_: usize, body: &Body| body.inertia();
        let outcome = contacts.advance(&mut bodies, &mut springs, &pulls, turning, part).ok()?;
        let substeps = outcome.substeps as f64 * dt / part;
        let seconds = started.elapsed().as_secs_f64() * dt / part;
        let touched = bodies.iter().zip(&outcome.bodies).filter(|(_, contacts)| contacts.touched);
        let touching = touched.filter(|(body, _)| body.freedom().is_some()).count();
        (touching > 0 && substeps > 0.0).then_some(Touching { touching, free, substeps, seconds })
    }

    /// Describes it in a line.
    pub fn describe(&self) -> String {
        format!(
            "contacts     {} of {} free bodies touch once they are let down: {} substeps a step, \
            {:.2} us each, {:.3} ms together",
            self.touching,
            self.free,
            whole(self.substeps.round()),
            1e6 * self.seconds / self.substeps,
            1e3 * self.seconds
        )
    }
}

/// The weight of a body in the fluid (N).
fn weight(case: &Case, body: &Body) -> Vector3<f64> {
    let mass = body.mass() - case.fluid.density * body.volume();
    Vector3::from_fn(|a, _| mass * case.fluid.gravity.get(a).copied().unwrap_or(0.0))
}

/// The accelerations of bodies by their weight.
fn pulls(case: &Case, contacts: &Contacts, bodies: &[Body]) -> Vec<Accelerations> {
    let pull = |body: &Body| Accelerations {
        acceleration: weight(case, body) / contacts.setup().mass_in_contact(body),
        angular: Vector3::zeros(),
    };
    bodies.iter().map(pull).collect()
}

/// Copies of the bodies, the free ones at rest and let down.
fn let_down<const D: usize>(case: &Case, scene: &Scene<D>) -> Vec<Body> {
    let mut bodies = scene.state.bodies.clone();
    let mut falling = Vec::new();
    for (k, body) in bodies.iter_mut().enumerate().filter(|(_, body)| body.freedom().is_some()) {
        body.velocity = Vector3::zeros();
        body.spin = Vector3::zeros();
        let weight = weight(case, body);
        let axis = weight.iamax();
        if weight[axis] != 0.0 {
            falling.push((k, weight[axis].signum() * Vector3::ith(axis, 1.0)));
        }
    }
    let depth = |(k, down): &(usize, Vector3<f64>)| bodies[*k].centre.dot(down);
    falling.sort_by(|a, b| depth(b).total_cmp(&depth(a)));
    let begun = Instant::now();
    let periods = scene.domain.periods();
    for (k, down) in falling {
        if begun.elapsed().as_secs_f64() > LONGEST {
            break;
        }
        let way = way_down(case, &bodies, k, &down, &periods);
        bodies[k].displace(&(way * down), &periods);
    }
    bodies
}

/// Distance (m) that a body falls until it overlaps what is below by its resting overlap; to the
/// end of the box where nothing is below.
fn way_down(
    case: &Case,
    bodies: &[Body],
    k: usize,
    down: &Vector3<f64>,
    periods: &[Option<f64>; 3],
) -> f64 {
    let body = &bodies[k];
    let axis = down.iamax();
    let resting = RESTING * body.radius();
    let size = case.domain.size[axis];
    let high = down[axis] > 0.0;
    let to_side = if high { size - body.centre[axis] } else { body.centre[axis] };
    let to_side = to_side - extent(body, down);
    let room = match case.boundary.side(2 * axis + usize::from(high)) {
        Some(Side::Periodic) => size,
        Some(Side::Outflow) => to_side,
        _ => to_side + resting,
    };
    let beside = |other: &Body| {
        let apart = nearest_image(&body.centre, &other.centre, periods);
        (apart - apart.dot(down) * down).norm() < body.radius() + other.radius()
    };
    let others = bodies.iter().enumerate().filter(|(j, other)| *j != k && beside(other));
    let others: Vec<&Body> = others.map(|(_, other)| other).collect();
    let mut way = 0.0;
    for _ in 0..100 {
        let from = body.centre + way * down;
        let free = |other: &&Body| {
            free_way(body, other, &nearest_image(&from, &other.centre, periods), down)
        };
        let free = others.iter().map(free).fold(f64::INFINITY, f64::min);
        if way + free >= room {
            return room.max(0.0);
        }
        if free < 0.01 * resting {
            return way + resting;
        }
        way += free;
    }
    way
}

/// Distance (m) that a body can surely move along `down` before it meets another one, whose centre
/// is `apart` from its own (m).
fn free_way(body: &Body, other: &Body, apart: &Vector3<f64>, down: &Vector3<f64>) -> f64 {
    let spheres = apart.norm() - body.radius() - other.radius();
    if spheres > 0.1 * body.radius() {
        return spheres;
    }
    let (normal, gap) = gap(body, other, apart);
    let convex = |body: &Body| body.parts().len() <= 1 && !body.is_obstacle();
    // Between convex bodies lies a plane.
    let part = if convex(body) && convex(other) { normal.dot(down) } else { 1.0 };
    if part > 0.0 { gap / part } else { f64::INFINITY }
}

/// Extent of a body from its centre in a direction (m).
fn extent(body: &Body, n: &Vector3<f64>) -> f64 {
    if body.is_round() {
        return body.radius();
    }
    let own = body.orientation().inverse_transform_vector(n);
    let reach = |part: &Part| (part.place + part.core.support(&own)).dot(&own) + part.rounding;
    body.parts().iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
}
