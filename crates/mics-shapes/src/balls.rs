//! Balls, and what two of them have in common.

use nalgebra::Vector3;

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

/// The plane of equal powers of two balls: the first one's side lies below it.
pub fn radical_plane(one: &Ball, other: &Ball) -> (Vector3<f64>, f64) {
    let way = other.centre - one.centre;
    let distance = way.norm();
    if distance == 0.0 {
        // Of balls about one centre the smaller ones have been dropped.
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
