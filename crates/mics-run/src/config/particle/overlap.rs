//! Bodies that overlap at time 0.
//!
//! Round ones overlap where their centres are too near each other, others where their bounding
//! spheres and then convex parts of theirs do.

use super::*;
use crate::config::fault::{short, unlike};
use mics_shapes::{Core, Part, Pose, closest};
use nalgebra::Vector3;
use std::borrow::Cow;

/// Two bodies that overlap, and by how much.
pub(in crate::config) struct Overlap {
    /// The index of the earlier.
    pub first: usize,
    /// The index of the later.
    pub second: usize,
    /// Distance or depth of the two and its limit, in words.
    pub words: String,
}

/// The first two bodies found that overlap at time 0, periodic images included: a sweep along x
/// over those near enough.
pub(in crate::config) fn overlap(case: &Case) -> Option<Overlap> {
    let bodies = &case.particle;
    let bounding: Vec<f64> = bodies.iter().map(|body| body.shape.bounding_diameter()).collect();
    let widest = bounding.iter().copied().fold(0.0, f64::max);
    let periods = case.periods();
    let there = bodies.iter().enumerate().filter(|(_, body)| body.enter.is_none());
    let mut along_x: Vec<(f64, usize)> = there.map(|(i, body)| (body.position[0], i)).collect();
    if let Some(length) = periods[0] {
        let images = along_x.iter().filter(|(x, _)| *x <= widest).map(|&(x, i)| (x + length, i));
        along_x.extend(images.collect::<Vec<_>>());
    }
    along_x.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (rank, &(x, i)) in along_x.iter().enumerate() {
        for &(_, j) in along_x[rank + 1..]
            .iter()
            .take_while(|(other, _)| other - x <= widest)
            .filter(|(_, j)| *j != i)
        {
            let distance = distance(&bodies[i].position, &bodies[j].position, &periods);
            let pair = [i, j].map(|k| &bodies[k]);
            let slack = slack(case, pair);
            let least = 0.5 * (bounding[i] + bounding[j]) - slack;
            if distance >= least {
                continue;
            }
            let found = |words| Some(Overlap { first: i.min(j), second: i.max(j), words });
            if pair.iter().all(|body| body.shape.is_round()) {
                let [distance, least] = unlike(distance, least);
                return found(format!(
                    "their centres are {distance} m apart, and must be {least} m or more"
                ));
            }
            match depth(pair, &periods) {
                None => return found("one lies in the other: move them apart".to_owned()),
                Some(depth) if depth > slack => {
                    return found(format!(
                        "one reaches {} m into the other, and may {} m: move them apart",
                        short(depth),
                        short(slack)
                    ));
                }
                Some(_) => {}
            }
        }
    }
    None
}

/// Depth of the overlap of two bodies of which one is not round (m); negative where they are apart,
/// `None` where it is more than the rounding of their edges.
fn depth(pair: [&Particle; 2], periods: &[Option<f64>]) -> Option<f64> {
    let [a, b] = pair;
    let mut way = Vector3::zeros();
    for (axis, (from, to)) in a.position.iter().zip(&b.position).enumerate() {
        let d = to - from;
        way[axis] = periods[axis].map_or(d, |l| d - l * (d / l).round());
    }
    let pose =
        |body: &Particle, place| Pose { place, orientation: body.turn().to_rotation_matrix() };
    let poses = [pose(a, Vector3::zeros()), pose(b, way)];
    let [own, other] = pair.map(parts);
    let mut deepest = f64::NEG_INFINITY;
    for first in own.iter() {
        for second in other.iter() {
            let apart = poses[1].place + poses[1].orientation * second.place
                - poses[0].orientation * first.place;
            let near = apart.norm() < first.radius + second.radius;
            let guess = apart.try_normalize(0.0).unwrap_or(Vector3::x());
            if near {
                let found = closest(first, &poses[0], second, &poses[1], &guess)?;
                deepest = deepest.max(-found.distance);
            }
        }
    }
    Some(deepest)
}

/// The convex parts of a body.
fn parts(body: &Particle) -> Cow<'_, [Part]> {
    match body.shape.solid() {
        Some(solid) => Cow::Borrowed(solid.geometry().parts()),
        None => {
            let radius = 0.5 * body.shape.diameter();
            let place = Vector3::zeros();
            let core = Core::Point;
            Cow::Owned(vec![Part { place, core, rounding: radius, radius }])
        }
    }
}

/// Largest allowed overlap of two bodies (m): that of pressed grains where the case has contacts,
/// or where both are held, as they may have settled in another run.
pub(in crate::config) fn slack(case: &Case, pair: [&Particle; 2]) -> f64 {
    let held = pair.iter().all(|body| body.motion != Motion::Free);
    let part = if held || case.contact.is_some() { PRESSED } else { 1e-9 };
    part * pair.iter().map(|body| body.shape.diameter()).fold(f64::INFINITY, f64::min)
}

/// Overlap of pressed grains, as a part of the smaller diameter.
const PRESSED: f64 = 0.02;

/// The distance (m) of two places by the shortest way across the periods.
pub(in crate::config) fn distance(a: &[f64], b: &[f64], periods: &[Option<f64>]) -> f64 {
    let apart = a.iter().zip(b).zip(periods);
    let apart =
        apart.map(|((a, b), period)| period.map_or(a - b, |l| a - b - l * ((a - b) / l).round()));
    apart.map(|d| d * d).sum::<f64>().sqrt()
}
