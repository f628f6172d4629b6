//! About where two convex cores are nearest, by the algorithm of Gilbert, Johnson and Keerthi
//! (1988, doi 10.1109/56.2083): in each iteration the point of a simplex that is nearest to the
//! origin.
//!
//! ```text
//!   v = sum l_k w_k,  sum l_k = 1,  l_k >= 0      w = b - a, of support points of both bodies
//! ```

use crate::contact::pose::Placed;
use nalgebra::{Matrix3, Vector3};

/// Most iterations, and the part of the distance to which it is found.
const MOST: usize = 100;
const TOLERANCE: f64 = 1e-6;
/// Distance of cores, of the way between their middles, below which they overlap.
pub(crate) const NONE: f64 = 1e-9;

/// A corner: the support points of both bodies.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    /// Points of the first and the second body (m).
    points: [Vector3<f64>; 2],
}

impl Corner {
    /// From the first to the second (m).
    fn way(&self) -> Vector3<f64> {
        self.points[1] - self.points[0]
    }
}

/// Up to four corners, and the weights of the point nearest to the origin.
#[derive(Clone, Copy, Debug, Default)]
struct Simplex {
    corners: [Corner; 4],
    weights: [f64; 4],
    count: usize,
}

impl Simplex {
    /// Its corners, with their weights.
    fn corners(&self) -> impl Iterator<Item = (&Corner, f64)> {
        self.corners[..self.count].iter().zip(self.weights)
    }

    /// The nearest points of both bodies (m).
    fn points(&self) -> [Vector3<f64>; 2] {
        [0, 1].map(|k| self.corners().map(|(corner, weight)| weight * corner.points[k]).sum())
    }

    /// Adds a corner, keeps those that the nearest point needs, and returns that (m).
    fn add(&mut self, corner: Corner) -> Vector3<f64> {
        let mut all = self.corners;
        all[self.count] = corner;
        let newest = 1usize << self.count;
        let mut best = f64::INFINITY;
        let mut nearest = corner.way();
        // The nearest point needs the newest corner; the fewest others where several sets do.
        for size in 1..=self.count + 1 {
            let sets = newest..2 * newest;
            for set in sets.filter(|set| set.count_ones() as usize == size) {
                let Some((point, chosen)) = project(&all, set) else { continue };
                if point.norm_squared() < best * (1.0 - 1e-14) {
                    best = point.norm_squared();
                    nearest = point;
                    *self = chosen;
                }
            }
        }
        nearest
    }
}

/// The point of the flat through a set of corners, the bits of `set`, that is nearest to the
/// origin, with its weights; `None` where it lies beyond the corners, or these span less.
fn project(all: &[Corner; 4], set: usize) -> Option<(Vector3<f64>, Simplex)> {
    let mut chosen = Simplex::default();
    for corner in (0..4).filter(|k| set >> k & 1 == 1).map(|k| all[k]) {
        chosen.corners[chosen.count] = corner;
        chosen.count += 1;
    }
    let last = chosen.corners[chosen.count - 1].way();
    let n = chosen.count - 1;
    let edges: [Vector3<f64>; 3] =
        std::array::from_fn(
            |k| {
                if k < n { chosen.corners[k].way() - last } else { Vector3::zeros() }
            },
        );
    // The rest of the system says that the weights of edges beyond the first n are zero.
    let gram = Matrix3::from_fn(|i, j| match i < n && j < n {
        true => edges[i].dot(&edges[j]),
        false => f64::from(u8::from(i == j)),
    });
    let product = gram[(0, 0)] * gram[(1, 1)] * gram[(2, 2)];
    if gram.determinant() <= 1e-15 * product {
        return None;
    }
    let weights = gram.try_inverse()? * Vector3::from_fn(|k, _| -edges[k].dot(&last));
    let rest = 1.0 - weights.iter().take(n).sum::<f64>();
    chosen.weights = std::array::from_fn(|k| if k < n { weights[k] } else { 0.0 });
    chosen.weights[n] = rest;
    if chosen.weights[..=n].iter().any(|weight| *weight < 0.0) {
        return None;
    }
    let point = last + (0..n).map(|k| weights[k] * edges[k]).sum::<Vector3<f64>>();
    Some((point, chosen))
}

/// About where two cores are nearest (m); `way` is a direction from the first to the second.
/// `None` where they overlap.
pub(crate) fn search(cores: &[Placed<'_>; 2], way: &Vector3<f64>) -> Option<[Vector3<f64>; 2]> {
    let mut simplex = Simplex::default();
    let mut way = *way;
    let mut length = f64::INFINITY;
    for _ in 0..MOST {
        let corner = Corner { points: [cores[0].support(&way), cores[1].support(&-way)] };
        if length.is_finite() && length - corner.way().dot(&way) <= TOLERANCE * length {
            break;
        }
        // Four corners about the origin.
        if simplex.count == 4 {
            return None;
        }
        let mut next = simplex;
        let nearest = next.add(corner).norm();
        if nearest <= NONE * corner.way().norm() {
            return None;
        }
        // Rounding: it comes no nearer.
        if nearest >= length * (1.0 - 1e-15) {
            break;
        }
        simplex = next;
        length = nearest;
        way = {
            let [x, y] = simplex.points();
            y - x
        } / length;
    }
    length.is_finite().then(|| simplex.points())
}
