//! Apertures: how much of each face of a cell a particle covers, and where its covered and its open part lie. Exact.
//!
//! ```text
//!      |                          the plane of the face cuts the particle in a chord (2D) or a disc (3D) of radius
//!   ---+---  y1                   c = sqrt(R^2 - x^2); covered: what of it lies on the face
//!      |##  } open
//!      |#### chord                first moment of the disc X^2 + Y^2 < c^2 over X < x, Y < y, with a = sqrt(c^2 - x^2):
//!   ---+---  y0                   integral of X = [ -a^2 (t + a) + (t^3 + a^3)/3 ]/2,  t = y within [-a, a]
//! ```
//! With the covered part's true centroid the flux of a rigid rotation through it is exact, so that a turning disc or
//! sphere displaces nothing, in every cut cell by itself.

use super::fraction::rectangle_overlap;
use super::reach::{Block, images};
use crate::grid::Grid;
use nalgebra::Vector3;

/// A face that a particle covers, in part or whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// The face's index in a field: the low face of that cell.
    pub face: usize,
    /// Covered part of its area, within (0, 1].
    pub covered: f64,
    /// From the particle's centre (its nearest image) to the centroid of the covered part (m).
    pub arm: Vector3<f64>,
    /// From the face's centre to the centroid of its open part (m); zero where nothing is open.
    pub open: Vector3<f64>,
}

/// Below this a face counts as untouched, and above one less this as covered.
const LEAST: f64 = 1e-12;

/// Fills `cuts` with the faces along `axis` of this rank's cells that a particle (or an image of it) covers; faces at
/// borders of the box are not among them: what flows through those, the border says.
pub fn cuts<const D: usize>(grid: &Grid<D>, axis: usize, centre: &Vector3<f64>, radius: f64, cuts: &mut Vec<Cut>) {
    cuts.clear();
    let mut from = grid.start;
    let mut to: [usize; D] = std::array::from_fn(|a| grid.start[a] + grid.local[a]);
    from[axis] += usize::from(grid.at_border(axis, 0));
    to[axis] += usize::from(!grid.at_border(axis, 1));
    for image in images(grid, centre) {
        let place = |a: usize, x: f64, up: bool| {
            let place = x / grid.h[a];
            if a == axis && up { place.ceil() } else { place.floor() }
        };
        let low = std::array::from_fn(|a| place(a, image[a] - radius, true));
        let high = std::array::from_fn(|a| place(a, image[a] + radius, false));
        for at in Block::between(low, high, from, to) {
            let middle = Vector3::from_fn(|a, _| match a {
                _ if a >= D => 0.0,
                _ if a == axis => at[a] as f64 * grid.h[a] - image[a],
                _ => (at[a] as f64 + 0.5) * grid.h[a] - image[a],
            });
            let Some((covered, centroid)) = section(grid, axis, &middle, radius) else { continue };
            let offset = centroid - middle;
            let open = if covered < 1.0 { -offset * (covered / (1.0 - covered)) } else { Vector3::zeros() };
            let face = (0..D).map(|a| (at[a] - grid.start[a] + grid.ghosts) * grid.stride[a]).sum();
            cuts.push(Cut { face, covered, arm: centroid, open });
        }
    }
}

/// Part of the face with its centre at `middle` (m, from the particle's) that the particle covers, and the centroid of
/// that part (m, likewise); `None` where there is none.
fn section<const D: usize>(
    grid: &Grid<D>,
    axis: usize,
    middle: &Vector3<f64>,
    radius: f64,
) -> Option<(f64, Vector3<f64>)> {
    let square = radius * radius - middle[axis] * middle[axis];
    if square <= 0.0 {
        return None;
    }
    let c = square.sqrt();
    let mut centroid = *middle;
    let edge = |a: usize| [middle[a] - 0.5 * grid.h[a], middle[a] + 0.5 * grid.h[a]];
    let covered = if D == 2 {
        let a = 1 - axis;
        let [low, high] = edge(a);
        let (low, high) = (low.max(-c), high.min(c));
        centroid[a] = 0.5 * (low + high);
        (high - low) / grid.h[a]
    } else {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let (x, y) = (edge(a), edge(b));
        let area = rectangle_overlap(x, y, c);
        if area > 0.0 {
            centroid[a] = rectangle_moment(x, y, c) / area;
            centroid[b] = rectangle_moment(y, x, c) / area;
        }
        area / (grid.h[a] * grid.h[b])
    };
    match covered {
        _ if covered < LEAST => None,
        _ if covered > 1.0 - LEAST => Some((1.0, *middle)),
        _ => Some((covered, centroid)),
    }
}

/// Integral of X over the disc of radius `c` at the origin inside the rectangle `x` by `y` (m3).
fn rectangle_moment(x: [f64; 2], y: [f64; 2], c: f64) -> f64 {
    let quadrant = |i: usize, j: usize| {
        let square = c * c - x[i] * x[i];
        if square <= 0.0 {
            return 0.0;
        }
        let a = square.sqrt();
        let t = y[j].clamp(-a, a);
        0.5 * (-square * (t + a) + (t * t * t + a * a * a) / 3.0)
    };
    quadrant(1, 1) - quadrant(0, 1) - quadrant(1, 0) + quadrant(0, 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_moment_of_a_rectangle_agrees_with_counting_points() {
        let (x, y, c) = ([0.1, 0.75], [-0.2, 0.6], 0.8);
        let n = 1000;
        let at = |s: [f64; 2], k: usize| s[0] + (s[1] - s[0]) * (k as f64 + 0.5) / n as f64;
        let points = (0..n * n).map(|k| (at(x, k % n), at(y, k / n)));
        let sum: f64 = points.filter(|(x, y)| x.hypot(*y) < c).map(|(x, _)| x).sum();
        let counted = sum / (n * n) as f64 * (x[1] - x[0]) * (y[1] - y[0]);
        assert!((rectangle_moment(x, y, c) - counted).abs() < 1e-5);
    }
}
