//! Balls, and what two of them have in common.

use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// A ball, or a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre (m).
    pub centre: Vector3<f64>,
    /// Radius (m).
    pub radius: f64,
}

/// The circle that two spheres have in common.
#[derive(Clone, Copy, Debug)]
pub struct Seam {
    /// Their numbers.
    pub balls: [usize; 2],
    /// Its middle (m).
    pub middle: Vector3<f64>,
    /// The direction from the first ball to the second.
    pub axis: Vector3<f64>,
    /// Its radius (m).
    pub radius: f64,
}

/// A free part of the rim of a disc, counterclockwise, no longer than a third of a turn.
#[derive(Clone, Copy, Debug)]
pub struct Arc {
    /// Number of the disc.
    pub disc: usize,
    /// From its centre.
    pub directions: [Vector2<f64>; 2],
}

/// The plane of equal powers of two balls: the first one's side lies below it.
pub fn radical_plane(one: &Ball, other: &Ball) -> (Vector3<f64>, f64) {
    let way = other.centre - one.centre;
    let distance = way.norm();
    if distance == 0.0 {
        // The smaller ones of balls about one centre have been dropped.
        return (Vector3::x(), f64::MAX);
    }
    let n = way / distance;
    let to = 0.5 * (distance + (one.radius.powi(2) - other.radius.powi(2)) / distance);
    (n, n.dot(&one.centre) + to)
}

/// The circle that two spheres have in common: middle (m), axis, and radius (m).
pub fn circle(one: &Ball, other: &Ball) -> Option<(Vector3<f64>, Vector3<f64>, f64)> {
    let way = other.centre - one.centre;
    let distance = way.norm();
    let to = 0.5 * (distance + (one.radius.powi(2) - other.radius.powi(2)) / distance);
    let square = one.radius.powi(2) - to * to;
    (square >= 0.0 && distance > 0.0)
        .then(|| (one.centre + to / distance * way, way / distance, square.sqrt()))
}

/// The number of a ball that is not joined to the first one.
pub fn unconnected(balls: &[Ball]) -> Option<usize> {
    let mut joined = vec![false; balls.len()];
    let mut next = vec![0];
    joined[0] = true;
    while let Some(k) = next.pop() {
        for j in 0..balls.len() {
            let reach = balls[k].radius + balls[j].radius;
            let apart = (balls[k].centre - balls[j].centre).norm();
            if !joined[j] && apart <= reach * (1.0 + 1e-6) {
                joined[j] = true;
                next.push(j);
            }
        }
    }
    joined.iter().position(|joined| !joined)
}

/// The free arcs of a disc, by the points that it has in common with others.
pub fn arcs_of(balls: &[Ball], disc: usize, seams: &[Seam]) -> Vec<Arc> {
    let centre = balls[disc].centre;
    // From where on and how far it lies in others (rad).
    let covered = seams.iter().filter(|seam| seam.balls.contains(&disc)).map(|seam| {
        let axis = if seam.balls[0] == disc { seam.axis } else { -seam.axis };
        let half = seam.radius.atan2((seam.middle - centre).dot(&axis));
        ((axis.y.atan2(axis.x) - half).rem_euclid(TAU), 2.0 * half)
    });
    let covered: Vec<(f64, f64)> = covered.collect();
    let ends = covered.iter().map(|(from, width)| (from + width).rem_euclid(TAU));
    let mut angles: Vec<f64> = covered.iter().map(|(from, _)| *from).chain(ends).collect();
    angles.extend((0..4).map(|k| f64::from(k) / 3.0 * TAU));
    angles.sort_unstable_by(f64::total_cmp);
    let is_free = |ends: &&[f64]| {
        let middle = 0.5 * (ends[0] + ends[1]);
        let within = |(from, width): &(f64, f64)| (middle - from).rem_euclid(TAU) < *width;
        ends[0] < ends[1] && !covered.iter().any(within)
    };
    let direction = |angle: f64| Vector2::new(angle.cos(), angle.sin());
    let arc = |ends: &[f64]| Arc { disc, directions: [ends[0], ends[1]].map(direction) };
    angles.windows(2).filter(is_free).map(arc).collect()
}
