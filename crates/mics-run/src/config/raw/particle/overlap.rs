//! Bodies that overlap at time 0.

use super::*;
use crate::config::fault::unlike;

/// Two bodies that overlap, and by how much.
pub(in crate::config::raw) struct Overlap {
    /// The index of the earlier.
    pub first: usize,
    /// The index of the later.
    pub second: usize,
    /// How far their centres are apart, and would have to be, in words.
    pub words: String,
}

/// The first two bodies found that overlap at time 0, periodic images included: a sweep along x
/// over those near enough.
pub(in crate::config::raw) fn overlap(case: &Case) -> Option<Overlap> {
    let bodies = &case.particle;
    let widest = bodies.iter().map(|body| body.shape.diameter()).fold(0.0, f64::max);
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
            let reach = 0.5 * pair.iter().map(|body| body.shape.diameter()).sum::<f64>();
            let least = reach - slack(case, pair);
            if distance < least {
                let [distance, least] = unlike(distance, least);
                let words =
                    format!("their centres are {distance} m apart, and must be {least} m or more");
                return Some(Overlap { first: i.min(j), second: i.max(j), words });
            }
        }
    }
    None
}

/// How far two bodies may overlap (m): as grains do that press on each other, where contacts say
/// how, and where both are held: they may have settled in another run.
pub(super) fn slack(case: &Case, pair: [&Particle; 2]) -> f64 {
    let held = pair.iter().all(|body| body.motion != Motion::Free);
    let part = if held || case.contact.is_some() { PRESSED } else { 1e-9 };
    part * pair.iter().map(|body| body.shape.diameter()).fold(f64::INFINITY, f64::min)
}

/// Overlap of grains that press on each other, of the smaller diameter.
const PRESSED: f64 = 0.02;

/// The distance (m) of two places by the shortest way across the periods.
pub(in crate::config::raw) fn distance(a: &[f64], b: &[f64], periods: &[Option<f64>]) -> f64 {
    let apart = a.iter().zip(b).zip(periods);
    let apart =
        apart.map(|((a, b), period)| period.map_or(a - b, |l| a - b - l * ((a - b) / l).round()));
    apart.map(|d| d * d).sum::<f64>().sqrt()
}
