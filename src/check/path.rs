//! Paths of prescribed bodies, and of free ones along locked axes. A run ends where one reaches the
//! boundary of the box, another one or a fixed one; how they are told to move says when.

use crate::config::{AXES, Case, SIDES, Side};
use crate::method::collision::refuse_collisions;
use crate::particles::{Accelerations, Body};
use crate::scene::Scene;
use crate::words::{brief, number};

/// Way of the fastest of them between two looks, over the smallest radius.
const LOOK: f64 = 0.01;

/// The most pairs that are looked at: what comes later is left to the run.
const PAIRS: f64 = 1e7;

/// Says when and where the first of them ends the run.
pub fn run_into<const D: usize>(case: &Case, scene: &Scene<D>) -> Option<String> {
    let state = &scene.state;
    let periods = scene.domain.periods();
    let mut bodies: Vec<Body> =
        state.bodies.iter().filter(|body| body.freedom().is_none()).cloned().collect();
    let movers: Vec<usize> = (0..bodies.len()).filter(|k| bodies[*k].moves()).collect();
    let fastest = movers.iter().map(|k| bodies[*k].top_speed()).fold(0.0, f64::max);
    let smallest = movers.iter().map(|k| bodies[*k].radius()).fold(f64::INFINITY, f64::min);
    if movers.is_empty() {
        return None;
    }
    let left = case.time.end - state.time;
    let dt = LOOK * smallest / fastest;
    let looks = (left / dt).ceil().min(PAIRS / (movers.len() * bodies.len()) as f64);
    let dt = dt.min(left / looks);
    (1..=looks as usize).find_map(|look| {
        movers.iter().for_each(|k| bodies[*k].advance(dt, &Accelerations::default(), &periods));
        let refused = refuse_collisions(&scene.domain, &bodies, case.contact.is_some()).err()?;
        let time = state.time + look as f64 * dt;
        Some(format!(
            "warning      the run will end at t = {} s of {} s: {refused}",
            brief(time),
            number(case.time.end)
        ))
    })
}

/// Says when and where the first free body that moves along a locked axis reaches a boundary that
/// it cannot leave through.
pub fn locked_into<const D: usize>(case: &Case, scene: &Scene<D>) -> Option<String> {
    let state = &scene.state;
    let size = &scene.domain.grid.size;
    let ends = |body: &Body| -> Vec<(f64, usize, usize, usize, f64)> {
        let Some(freedom) = body.freedom() else { return Vec::new() };
        let locked =
            (0..D).filter(|&axis| !freedom.translation[axis] && body.velocity[axis] != 0.0);
        let stopped = |axis: usize, end: usize| {
            let side = case.boundary.side(2 * axis + end);
            !matches!(side, Some(Side::Periodic | Side::Outflow))
        };
        locked
            .map(|axis| (axis, usize::from(body.velocity[axis] > 0.0)))
            .filter(|(axis, end)| stopped(*axis, *end))
            .map(|(axis, end)| {
                let speed = body.velocity[axis].abs();
                let way = if end == 1 { size[axis] - body.centre[axis] } else { body.centre[axis] }
                    - body.reach()[axis];
                (state.time + way / speed, body.id, axis, end, speed)
            })
            .collect()
    };
    let first =
        state.bodies.iter().flat_map(ends).min_by(|one, other| one.0.total_cmp(&other.0))?;
    let (time, id, axis, end, speed) = first;
    (time < case.time.end).then(|| {
        format!(
            "warning      the run will end soon after t = {} s of {} s: particle {id} goes on \
            along {} at {} m/s, which is locked, into the {} boundary; unlock that axis, give it \
            no velocity along it, or end the run before",
            brief(time),
            number(case.time.end),
            AXES[axis],
            brief(speed),
            SIDES[2 * axis + end]
        )
    })
}
