//! Bodies that overlap are moved apart, pair by pair, until none does (force-biased packing, Jodrey
//! & Tory 1985, without their shrinking of the bodies):
//!
//! `x_i += s n`, `x_j -= s n`, `2 s = (1 + EXCESS) (reach - |x_i - x_j|)` with `n` from the one to
//! the other, where the distance is below their reach, `(d_i + d_j)/2 + gap`; a body that is not
//! the swarm's stays, and the other takes it all.

use super::Taken;
use mics_shapes::Nearest;
use nalgebra::Vector3;

/// Sweeps over all pairs, and the part of the overlap before them that may be left after them; with
/// more the swarm does not fit. Packings near the densest need hundreds.
const PATIENCE: (usize, f64) = (100, 0.8);

/// Most visits of bodies in all sweeps together: about a minute's.
const MOST_VISITS: usize = 10_000_000;

/// Excess of the distance by which bodies are moved apart, as parts of their overlap and of their
/// reach: without it the last overlaps would decay without end.
const EXCESS: [f64; 2] = [0.2, 1e-6];

/// Moves the bodies from `first` on apart, each within its room (from, and how far along each axis,
/// m), and says whether none overlaps any more.
pub(super) fn part(taken: &mut Taken, first: usize, rooms: &[Vec<(f64, f64)>]) -> bool {
    let (sweeps, part) = PATIENCE;
    let mut before = f64::INFINITY;
    for _ in 0..(MOST_VISITS / taken.bodies.len().max(1) / sweeps).max(4) {
        let mut overlap = 0.0;
        for _ in 0..sweeps {
            overlap = sweep(taken, first, rooms);
            if overlap == 0.0 {
                return true;
            }
        }
        if overlap > part * before {
            return false;
        }
        before = overlap;
    }
    false
}

/// One sweep over all pairs; returns the sum of their overlaps, each as a part of its reach.
fn sweep(taken: &mut Taken, first: usize, rooms: &[Vec<(f64, f64)>]) -> f64 {
    let bodies = std::mem::take(&mut taken.bodies);
    taken.near.iter_mut().for_each(Vec::clear);
    for (body, (diameter, place)) in bodies.iter().enumerate() {
        taken.list(body as u32, *diameter, place);
    }
    taken.bodies = bodies;
    let mut overlap = 0.0;
    for i in first..taken.bodies.len() {
        overlap += bring_off_walls(taken, i, &rooms[i - first]);
        let cell = taken.cell(&taken.bodies[i].1);
        for k in 0..taken.near[cell].len() {
            let j = taken.near[cell][k] as usize;
            // Each pair of the swarm's own once.
            if j < first || j > i {
                overlap += separate(taken, [i, j], first, rooms);
            }
        }
    }
    overlap
}

/// Moves a body off the obstacles, and says by how much of its reach it was too near.
fn bring_off_walls(taken: &mut Taken, body: usize, room: &[(f64, f64)]) -> f64 {
    let mut overlap = 0.0;
    for k in 0..taken.walls.len() {
        let (diameter, place) = &taken.bodies[body];
        let reach = 0.5 * diameter + taken.gap;
        let Nearest { distance, normal } = taken.walls[k].nearest(place);
        if distance < reach {
            overlap += (1.0 - distance / reach).min(2.0);
            let step = (1.0 + EXCESS[0]) * (reach - distance) + EXCESS[1] * reach;
            shift(&mut taken.bodies[body].1, step * normal, room, &taken.periods);
        }
    }
    overlap
}

/// Moves a place by a step within its room (m).
fn shift(place: &mut [f64], step: Vector3<f64>, room: &[(f64, f64)], periods: &[Option<f64>]) {
    for (axis, x) in place.iter_mut().enumerate() {
        let (low, length) = room[axis];
        let to = *x + step[axis];
        *x = match periods[axis] {
            // The whole of a period: across its end.
            Some(period) if low == 0.0 && length == period => {
                let inside = to.rem_euclid(period);
                if inside >= period { 0.0 } else { inside }
            }
            _ => to.clamp(low, low + length),
        };
    }
}

/// Moves two bodies apart where they overlap, and says by how much of their reach they did.
fn separate(taken: &mut Taken, [i, j]: [usize; 2], first: usize, rooms: &[Vec<(f64, f64)>]) -> f64 {
    let [(d_i, x_i), (d_j, x_j)] = [&taken.bodies[i], &taken.bodies[j]];
    let reach = 0.5 * (d_i + d_j) + taken.gap;
    let apart = x_i.iter().zip(x_j).zip(&taken.periods);
    let mut line: Vec<f64> = apart
        .map(|((a, b), period)| period.map_or(a - b, |l| a - b - l * ((a - b) / l).round()))
        .collect();
    let distance = line.iter().map(|d| d * d).sum::<f64>().sqrt();
    if distance >= reach {
        return 0.0;
    }
    match distance > 0.0 {
        true => line.iter_mut().for_each(|d| *d /= distance),
        false => line[0] = 1.0,
    }
    let step = (1.0 + EXCESS[0]) * (reach - distance) + EXCESS[1] * reach;
    let [share_i, share_j] = if j < first { [step, 0.0] } else { [0.5 * step, 0.5 * step] };
    for (body, share) in [(i, share_i), (j, -share_j)] {
        if share == 0.0 {
            continue;
        }
        let way = Vector3::from_fn(|a, _| line.get(a).map_or(0.0, |d| share * d));
        shift(&mut taken.bodies[body].1, way, &rooms[body - first], &taken.periods);
    }
    1.0 - distance / reach
}
