//! The steps of a run: their limits, their length at the start and later, their number.

use super::estimate::{LargestSpeed, later_step, steps};
use crate::config::{Case, Side};
use crate::method::sharp::gap_reach;
use crate::particles::Body;
use crate::scene::Scene;
use crate::scheme::Limits;
use crate::step_size::choose_step;
use crate::words::{brief, number, whole};

/// The limits, the step at the start and later, and the number of steps, which is returned too.
pub fn describe<const D: usize>(
    case: &Case,
    scene: &Scene<D>,
    limits: &Limits,
) -> (Vec<String>, f64) {
    let (dt, choice) = choose_step(case, limits, None, case.time.end);
    let mut lines = limit_lines(limits);
    let later = later_step(case, limits);
    let count = steps(case, limits, dt, later);
    let stages = limits.scheme.stages_for(later * limits.diffusion_rate);
    let more = if stages > limits.scheme.weights.len() {
        format!(" in {stages} stages")
    } else {
        String::new()
    };
    let differs = !(0.99..1.01).contains(&(later / dt));
    let later_words = LargestSpeed::expected(case).filter(|_| differs).map(|largest| {
        let LargestSpeed { speed, words, .. } = largest;
        format!(", and {later:.1e} s{more} at {} m/s, {words}", brief(speed))
    });
    lines.push(format!(
        "step         {dt:.4e} s at the start, {choice}{}; about {} steps to t = {} s",
        later_words.unwrap_or_default(),
        whole(count),
        number(case.time.end)
    ));
    lines.extend(long_beside_wall(case, scene, later));
    (lines, count)
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

/// A free body that begins beside a wall along which gravity pulls it, in steps that take more
/// stages for viscosity once the wall has slowed it to a third of the speed that it comes to
/// elsewhere: such steps are too long for the flow in the gap. A disc at a gap of 0.02 d, 8 to 16
/// cells a diameter, falls 4 to 5 % faster in four stages than in the two of rk2, which are within
/// 1 % of steps of a seventh.
fn long_beside_wall<const D: usize>(case: &Case, scene: &Scene<D>, later: f64) -> Option<String> {
    let (limits, h) = (scene.limits().ok()?, case.spacings().into_iter().fold(0.0, f64::max));
    let stages = limits.scheme.stages_for(3.0 * later * limits.diffusion_rate);
    let along = |(face, side): (usize, &Side)| {
        matches!(side, Side::Wall | Side::MovingWall(_)) && case.fluid.gravity[face / 2] == 0.0
    };
    let walls = || case.sides().map(|(_, side)| side).enumerate().filter(|wall| along(*wall));
    let distance = |body: &Body, face: usize| {
        let (x, size) = (body.centre[face / 2], case.domain.size[face / 2]);
        if face.is_multiple_of(2) { x } else { size - x }
    };
    let gap = |body: &Body| {
        let bounds = body.shape().bounds(&body.orientation());
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
