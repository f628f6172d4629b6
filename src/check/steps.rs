//! The steps of a run: their limits, their length at the start and at the largest speed that is to
//! be expected, and how many of that length there are.

use super::layer::{fall_speed, largest_speed};
use crate::config::{Case, Scheme, Side, Step};
use crate::method::sharp::gap_reach;
use crate::particles::Body;
use crate::scene::Scene;
use crate::scheme::Limits;
use crate::step_size::choose_step;
use crate::words::{brief, number, whole};

/// The limits, the steps, and the number of the shorter ones, which is returned too.
pub fn describe<const D: usize>(
    case: &Case,
    scene: &Scene<D>,
    limits: &Limits,
) -> (Vec<String>, f64) {
    let (dt, choice) = choose_step(case, limits, None, case.time.end);
    let later = later_step(case, limits);
    let count = |dt: f64| (case.time.end / dt * (1.0 - 1e-9)).ceil();
    let at = if let Step::Courant(_) = case.time.length() { " at the start" } else { "" };
    let speed = brief(largest_speed(case));
    let shorter = (later < 0.99 * dt)
        .then(|| format!(", {} of {later:.1e} s at {speed} m/s", whole(count(later))));
    let mut lines = limit_lines(limits);
    lines.push(format!(
        "step         {dt:.4e} s{at}, {choice}; {} steps of this length to t = {} s{}",
        whole(count(dt)),
        number(case.time.end),
        shorter.unwrap_or_default()
    ));
    lines.extend(steps_of_crowd(case));
    lines.extend(long_beside_wall(case, scene, limits));
    (lines, count(dt.min(later)))
}

/// The step (s) at the largest speed to be expected, in all stages that viscosity asks for.
pub fn later_step(case: &Case, limits: &Limits) -> f64 {
    step_at(case, limits, largest_speed(case))
}

/// The step (s) among bodies that fall together: the fluid between them is twice as fast.
pub fn step_among_bodies(case: &Case, limits: &Limits) -> f64 {
    step_at(case, limits, 2.0 * largest_speed(case))
}

/// The step (s) at a speed (m/s), or at that of now where it is larger.
fn step_at(case: &Case, limits: &Limits, speed: f64) -> f64 {
    let spacings = case.spacings().into_iter();
    // Where there are no bodies, the flow goes along the longest edges of the cells.
    let bodies = case.has_bodies();
    let h =
        if bodies { spacings.fold(f64::INFINITY, f64::min) } else { spacings.fold(0.0, f64::max) };
    let courant_rate = limits.courant_rate.max(speed / h);
    let limits = Limits { courant_rate, courant_growth: 0.0, ..*limits };
    choose_step(case, &limits, Some(f64::INFINITY), case.time.end).0
}

/// The limits that stability sets, in all stages and in those that the first step goes by.
fn limit_lines(limits: &Limits) -> Vec<String> {
    let mut lines = Vec::new();
    let explicit = Limits { scheme: limits.scheme.explicit(), ..*limits };
    for ((bound, limit), (_, first)) in
        limits.bounds().into_iter().zip(explicit.bounds()).filter(|b| b.0.1.is_finite())
    {
        let stages = limits.scheme.most_stages.filter(|_| first < limit);
        let stages = stages.map_or(String::new(), |most| {
            format!(
                ", in {most} stages; {first:.4e} s in {}, which the first step goes by",
                limits.scheme.weights.len()
            )
        });
        lines.push(format!("step limit   {limit:.4e} s, {bound}{stages}"));
    }
    lines
}

/// The long steps of a crowd, whose error is that of its means.
fn steps_of_crowd(case: &Case) -> Option<String> {
    let crowding = case.crowding();
    let long = crowding > 1.0 && case.time.scheme() == Scheme::Rkl3;
    long.then(|| {
        format!(
            "note         free particles are a crowd, with {crowding:.1} times the least \
            cross-section of the box: steps of rkl3 keep its means; for the paths of single \
            particles time.cfl = 0.4 takes rkl2"
        )
    })
}

/// A free body that begins beside a wall along which gravity pulls it, in steps that take more
/// stages for viscosity once the wall has slowed it to a third of the speed that it comes to
/// elsewhere: such steps are too long for the flow in the gap. A disc at a gap of 0.02 d, 8 to 16
/// cells a diameter, falls 4 to 5 % faster in four stages than in the two of rk2, which are within
/// 1 % of steps of a seventh.
fn long_beside_wall<const D: usize>(
    case: &Case,
    scene: &Scene<D>,
    limits: &Limits,
) -> Option<String> {
    let h = case.widest_spacing();
    let fastest = case.particle.iter().map(|p| fall_speed(case, p)).fold(0.0, f64::max);
    let dt = step_at(case, limits, fastest / 3.0);
    let stages = limits.scheme.stages_for(dt * limits.diffusion_rate);
    let along = |(face, side): (usize, &Side)| {
        matches!(side, Side::Wall | Side::MovingWall(_)) && case.fluid.gravity[face / 2] == 0.0
    };
    let walls = || case.sides().map(|(_, side)| side).enumerate().filter(|wall| along(*wall));
    let distance = |body: &Body, face: usize| {
        let x = body.centre[face / 2];
        let size = case.domain.size[face / 2];
        if face.is_multiple_of(2) { x } else { size - x }
    };
    let gap = |body: &Body| {
        let bounds = body.reach();
        let gap = |(face, _): (usize, &Side)| distance(body, face) - bounds[face / 2];
        walls().map(gap).fold(f64::INFINITY, f64::min)
    };
    let falls = case.fluid.gravity.iter().any(|g| *g != 0.0);
    let long = falls && stages > limits.scheme.weights.len();
    let free = |body: &&Body| body.freedom().is_some() && gap(body) < gap_reach(false) * h;
    let first = scene.state.bodies.iter().find(free).filter(|_| long)?;
    Some(format!(
        "warning      {} begins {} spacings from a wall, where steps of {stages} stages are too \
        long: its speed along the wall may be off by 5 %; time.scheme = \"rk2\" is within 1 % of \
        short steps",
        case.called(first.id),
        brief(gap(first).max(0.0) / h)
    ))
}
