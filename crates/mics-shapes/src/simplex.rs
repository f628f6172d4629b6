//! The point of a simplex that is nearest to the origin: what the distance algorithm of Gilbert,
//! Johnson and Keerthi (1988, doi 10.1109/56.2083) asks for in each iteration.
//!
//! ```text
//!   v = sum l_k w_k,  sum l_k = 1,  l_k >= 0      w = b - a, of support points of both bodies
//! ```

use nalgebra::{Matrix3, Vector3};

/// A corner: the support points of both bodies, and the numbers of the corners that they are.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Corner {
    /// Of the first and the second body (m).
    pub points: [Vector3<f64>; 2],
    /// Of polytopes; 0 of others.
    pub numbers: [u32; 2],
}

impl Corner {
    /// From the first to the second (m).
    pub fn way(&self) -> Vector3<f64> {
        self.points[1] - self.points[0]
    }
}

/// Up to four corners, and the weights of the point nearest to the origin.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Simplex {
    corners: [Corner; 4],
    weights: [f64; 4],
    count: usize,
}

impl Simplex {
    /// Its corners, with their weights.
    pub fn corners(&self) -> impl Iterator<Item = (&Corner, f64)> {
        self.corners[..self.count].iter().zip(self.weights)
    }

    /// Whether it has a corner of these numbers.
    pub fn contains(&self, numbers: [u32; 2]) -> bool {
        self.corners().any(|(corner, _)| corner.numbers == numbers)
    }

    /// The nearest points of both bodies (m).
    pub fn points(&self) -> [Vector3<f64>; 2] {
        [0, 1].map(|k| self.corners().map(|(corner, weight)| weight * corner.points[k]).sum())
    }

    /// Adds a corner, keeps those that the nearest point needs, and returns that (m).
    pub fn add(&mut self, corner: Corner) -> Vector3<f64> {
        let mut all = self.corners;
        all[self.count] = corner;
        let newest = 1usize << self.count;
        let (mut best, mut nearest) = (f64::INFINITY, corner.way());
        // The nearest point needs the newest corner; the fewest others where several sets do.
        for size in 1..=self.count + 1 {
            let sets = newest..2 * newest;
            for set in sets.filter(|set| set.count_ones() as usize == size) {
                let Some((point, chosen)) = project(&all, set) else { continue };
                if point.norm_squared() < best * (1.0 - 1e-14) {
                    (best, nearest, *self) = (point.norm_squared(), point, chosen);
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
    let (last, n) = (chosen.corners[chosen.count - 1].way(), chosen.count - 1);
    let edges: [Vector3<f64>; 3] =
        std::array::from_fn(
            |k| {
                if k < n { chosen.corners[k].way() - last } else { Vector3::zeros() }
            },
        );
    // Of fewer than three edges the rest of the system says that their weights are zero.
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

/// Up to two directions of length 1, normal to each other.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Directions(pub [Vector3<f64>; 2]);

impl Directions {
    pub fn of(ways: impl Iterator<Item = Vector3<f64>>) -> Directions {
        let (mut all, mut count) = (Directions::default(), 0);
        for way in ways {
            let across = all.across(&all.across(&way));
            if count < 2 && across.norm() > 1e-10 * way.norm() {
                all.0[count] = across.normalize();
                count += 1;
            }
        }
        all
    }

    /// The part of a vector across them.
    pub fn across(&self, v: &Vector3<f64>) -> Vector3<f64> {
        v - self.0.iter().map(|d| v.dot(d) * d).sum::<Vector3<f64>>()
    }
}
