//! The cost of contacts, before anything touches: copies of the bodies are let down one after the
//! other until they touch, and the contacts alone take a step.
//!
//! ```text
//!       o   o          lowest first, along the axis on which gravity pulls the most, a body falls
//!    o    o     -->    onto another body, an obstacle or a wall, and into it by a resting overlap
//!   ___________          __o_o_oo____
//! ```
//! Long steps are not tried where short ones take long already: a step takes a time of its own, and
//! one that is proportional to its substeps.

use super::stiffness::shortest;
use crate::config::{Case, Side, Substeps};
use crate::contact::Contacts;
use crate::geometry::shapes::Part;
use crate::particles::{Accelerations, Body, gap, nearest_image};
use crate::scene::Scene;
use crate::words::whole;
use nalgebra::Vector3;
use std::time::Instant;

/// Time (s) after which no further body is let down, and no further step tried but the second.
const LONGEST: f64 = 1.0;
/// Overlap of a body at rest, of its radius: that of springs that an impact after a fall of a
/// diameter compresses by a fiftieth of it.
const RESTING: f64 = 1e-4;

/// What a step costs in which bodies touch.
pub struct Touching {
    /// Free bodies that touch, and all.
    touching: usize,
    free: usize,
    /// Substeps in a step.
    substeps: f64,
    /// Time that contacts add to a step (s).
    pub seconds: f64,
}

impl Touching {
    /// Measures it with steps of `dt` (s), or of parts of it; `None` where nothing can touch.
    pub fn measured<const D: usize>(case: &Case, scene: &Scene<D>, dt: f64) -> Option<Touching> {
        let contacts = scene.method.contacts()?;
        let bodies = let_down(case, scene);
        let free = bodies.iter().filter(|body| body.freedom().is_some()).count();
        let begun = Instant::now();
        let mut last = None;
        let mut found = None;
        for halvings in (0..=halvings(case, scene, dt)).rev() {
            let parts = 2f64.powi(halvings);
            let Some(one) = try_step(case, contacts, &bodies, dt / parts) else { continue };
            let Tried { seconds, taken, touching } = one;
            // What a step takes beside its substeps is in both.
            let substep =
                last.filter(|last: &Tried| last.taken < taken).map_or(seconds / taken, |last| {
                    ((seconds - last.seconds) / (taken - last.taken)).max(0.0)
                });
            let seconds = seconds + (parts - 1.0) * taken * substep;
            found = Some(Touching { touching, free, substeps: parts * taken, seconds });
            if last.replace(one).is_some() && begun.elapsed().as_secs_f64() > LONGEST {
                break;
            }
        }
        found
    }

    /// Says it, beside a step (s) without contacts.
    pub fn describe(&self, step: f64) -> String {
        format!(
            "contacts     {} of {} free bodies touch once they are let down: {} substeps a step, \
            {:.0} us each; {:.2} ms a step without contacts, {:.2} ms with them",
            self.touching,
            self.free,
            whole(self.substeps),
            1e6 * self.seconds / self.substeps,
            1e3 * step,
            1e3 * (step + self.seconds)
        )
    }
}

/// How often a step `dt` (s) is to be halved until it has the fewest substeps that the fluid
/// between two asks for, by the shortest contact.
fn halvings<const D: usize>(case: &Case, scene: &Scene<D>, dt: f64) -> i32 {
    let chosen = case.contact.as_ref().is_some_and(|law| law.substeps == Substeps::Auto);
    let contacts = shortest(scene).filter(|_| chosen).map_or(0.0, |time| dt / time);
    (2.0 * contacts).max(1.0).log2() as i32
}

/// A step that was tried: its time (s), its substeps, and the free bodies that touched.
#[derive(Clone, Copy)]
struct Tried {
    seconds: f64,
    taken: f64,
    touching: usize,
}

/// Moves copies of the bodies on by `h` (s) through contacts, pulled by their weight; `None` where
/// none touches, or the step fails.
fn try_step(case: &Case, contacts: &Contacts, bodies: &[Body], h: f64) -> Option<Tried> {
    let mut contacts = contacts.clone();
    let mut bodies = bodies.to_vec();
    let mut touching = contacts.untouched();
    let pulled = |body: &Body| Accelerations {
        acceleration: weight(case, body) / contacts.mass_in_contact(body),
        angular: Vector3::zeros(),
    };
    let pulled: Vec<Accelerations> = bodies.iter().map(pulled).collect();
    let started = Instant::now();
    let taken =
        contacts.advance(&mut bodies, &mut touching, &pulled, |_, body| body.inertia(), h).ok()?;
    let seconds = started.elapsed().as_secs_f64();
    let free = bodies.iter().zip(contacts.touched()).filter(|(body, _)| body.freedom().is_some());
    let touching = free.filter(|(_, touched)| **touched).count();
    (touching > 0 && taken > 0).then_some(Tried { seconds, taken: taken as f64, touching })
}

/// The weight of a body in the fluid (N).
fn weight(case: &Case, body: &Body) -> Vector3<f64> {
    let mass = body.mass() - case.fluid.density * body.volume();
    Vector3::from_fn(|a, _| mass * case.fluid.gravity.get(a).copied().unwrap_or(0.0))
}

/// Copies of the bodies, at rest, the free ones let down.
fn let_down<const D: usize>(case: &Case, scene: &Scene<D>) -> Vec<Body> {
    let mut bodies = scene.state.bodies.clone();
    for body in bodies.iter_mut().filter(|body| body.freedom().is_some()) {
        (body.velocity, body.spin) = (Vector3::zeros(), Vector3::zeros());
    }
    let down = |body: &Body| {
        let weight = weight(case, body);
        let axis = weight.iamax();
        weight[axis].signum() * Vector3::ith(axis, 1.0)
    };
    let falls = |body: &Body| body.freedom().is_some() && weight(case, body) != Vector3::zeros();
    let mut order: Vec<usize> = (0..bodies.len()).filter(|k| falls(&bodies[*k])).collect();
    let depth = |k: &usize| bodies[*k].centre.dot(&down(&bodies[*k]));
    order.sort_by(|a, b| depth(b).total_cmp(&depth(a)));
    let begun = Instant::now();
    let periods = scene.domain.periods();
    for k in order {
        if begun.elapsed().as_secs_f64() > LONGEST {
            break;
        }
        let down = down(&bodies[k]);
        let way = way_down(case, &bodies, k, &down, &periods);
        bodies[k].displace(&(way * down), &periods);
    }
    bodies
}

/// How far a body falls until it lies in what is below it by its resting overlap (m); to the end of
/// the box where nothing is.
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
    let room = match &case.boundary[axis][usize::from(high)] {
        Side::Periodic => size,
        side => {
            let place = if high { size - body.centre[axis] } else { body.centre[axis] };
            let into = if matches!(side, Side::Outflow) { 0.0 } else { resting };
            place - extent(body, down) + into
        }
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
        if free < 0.01 * resting || way + free >= room {
            return if way + free >= room { room.max(0.0) } else { way + resting };
        }
        way += free;
    }
    way
}

/// How far a body may go along `down` beyond doubt until it meets another one, whose centre is
/// `apart` from its own (m).
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

/// How far a body reaches from its centre in a direction (m).
fn extent(body: &Body, n: &Vector3<f64>) -> f64 {
    if body.is_round() {
        return body.radius();
    }
    let own = body.orientation().inverse_transform_vector(n);
    let reach = |part: &Part| (part.place + part.core.support(&own)).dot(&own) + part.rounding;
    body.parts().iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
}
