//! A lattice of boxes that a body is cut by, all in one go: what neighbours share is found once.
//!
//! ```text
//!   planes of an axis    p_0   p_1   p_2   ...      box (i, j, k) from p_i to p_(i+1) along x, and so on
//! ```

use super::block::Block;
use super::octant::{Corner, Pair, Plane, between};
use super::{Shape, Turn};
use nalgebra::Vector3;

/// The planes of a lattice, from a body's centre, and room for what is found on the way.
#[derive(Clone, Debug)]
pub struct Tiles {
    /// Places along each axis, ascending (m); two alike along z in 2D.
    pub planes: [Vec<f64>; 3],
    cuts: [Vec<Plane>; 3],
    /// Of xy, yz, zx, the first axis fastest.
    pairs: [Vec<Pair>; 3],
    /// Of two layers in z.
    corners: [Vec<Option<Corner>>; 2],
}

/// What a body fills of a box.
#[derive(Clone, Copy, Debug)]
pub struct Filled {
    /// Number of the box along each axis.
    pub at: [usize; 3],
    /// Part of its volume.
    pub part: f64,
    /// The box's middle, from the body's centre (m).
    pub middle: Vector3<f64>,
    /// Its half edges (m; zero along z in 2D).
    pub half: Vector3<f64>,
    /// First moment of that part per volume of the box (m), where it was asked for.
    pub moment: Vector3<f64>,
}

impl Tiles {
    /// Room for so many planes along an axis.
    pub fn new(most: usize) -> Tiles {
        Tiles {
            planes: std::array::from_fn(|_| Vec::with_capacity(most)),
            cuts: std::array::from_fn(|_| Vec::with_capacity(most)),
            pairs: std::array::from_fn(|_| Vec::with_capacity(most * most)),
            corners: std::array::from_fn(|_| Vec::with_capacity(most * most)),
        }
    }

    /// Room for the lattices of a body of this radius (m) on a grid of such spacings (m).
    pub fn for_radius(radius: f64, h: &[f64]) -> Tiles {
        let least = h.iter().copied().fold(f64::INFINITY, f64::min);
        Tiles::new((2.0 * radius / least) as usize + 5)
    }

    /// Sets the planes for the boxes of a block, of which number n along an axis lies between the places n and n + 1 (m). Returns the
    /// first box, if there is any.
    pub fn set<const D: usize>(&mut self, block: &Block<D>, place: impl Fn(usize, usize) -> f64) -> Option<[usize; D]> {
        let (first, last) = block.ends()?;
        for (a, planes) in self.planes.iter_mut().enumerate() {
            planes.clear();
            if a < D {
                planes.extend((first[a]..=last[a] + 1).map(|n| place(a, n)));
            } else {
                planes.extend([0.0; 2]);
            }
        }
        Some(first)
    }

    /// The boxes, the first axis fastest: their numbers, middles (m) and half edges (m).
    fn boxes(planes: &[Vec<f64>; 3]) -> impl Iterator<Item = Filled> {
        let [x, y, z] = planes;
        let counts = planes.each_ref().map(|planes| planes.len().saturating_sub(1));
        (0..counts.iter().product()).map(move |n| {
            let at = [n % counts[0], n / counts[0] % counts[1], n / counts[0] / counts[1]];
            let low = Vector3::new(x[at[0]], y[at[1]], z[at[2]]);
            let high = Vector3::new(x[at[0] + 1], y[at[1] + 1], z[at[2] + 1]);
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
            Filled { at, part: 0.0, middle, half, moment: Vector3::zeros() }
        })
    }

    /// Box by box, by a shape's own methods; `moments` where they are wanted.
    pub fn each<S: Shape + ?Sized>(&self, shape: &S, turn: &Turn, moments: bool, found: &mut dyn FnMut(&Filled)) {
        let dimension = shape.dimension();
        for mut one in Tiles::boxes(&self.planes) {
            let whole: f64 = (0..dimension).map(|a| 2.0 * one.half[a]).product();
            (one.part, one.moment) = match shape.whole_or_nothing(turn, &one.middle, &one.half) {
                Some(part) => (part, part * one.middle),
                None if moments => {
                    let (filled, moment) = shape.moments(turn, &one.middle, &one.half);
                    (filled / whole, moment / whole)
                }
                None => (shape.filled(turn, &one.middle, &one.half) / whole, Vector3::zeros()),
            };
            found(&one);
        }
    }

    /// All boxes of a sphere of the given radius (m), with moments.
    pub fn of_sphere(&mut self, radius: f64, whole: impl Fn(&Filled) -> Option<f64>, found: &mut dyn FnMut(&Filled)) {
        for (cuts, planes) in self.cuts.iter_mut().zip(&self.planes) {
            cuts.clear();
            cuts.extend(planes.iter().map(|at| Plane::new(*at, radius)));
        }
        for (a, pairs) in self.pairs.iter_mut().enumerate() {
            let (first, second) = (&self.cuts[a], &self.cuts[(a + 1) % 3]);
            pairs.clear();
            pairs.extend(second.iter().flat_map(|q| first.iter().map(move |p| Pair::new(p, q, radius))));
        }
        let Tiles { planes, cuts, pairs, corners } = self;
        let [nx, ny, nz] = cuts.each_ref().map(Vec::len);
        for layer in corners.iter_mut() {
            layer.clear();
            layer.resize(nx * ny, None);
        }
        let mut layer = 0;
        for mut one in Tiles::boxes(planes) {
            if one.at[2] > layer {
                layer = one.at[2];
                corners.swap(0, 1);
                corners[1].fill(None);
            }
            (one.part, one.moment) = whole(&one).map_or_else(
                || {
                    let filled = between(|high| {
                        let [i, j, k] = std::array::from_fn(|a| one.at[a] + high[a]);
                        *corners[high[2]][i + nx * j].get_or_insert_with(|| {
                            let own = [&pairs[0][i + nx * j], &pairs[1][j + ny * k], &pairs[2][k + nz * i]];
                            Corner::new([&cuts[0][i], &cuts[1][j], &cuts[2][k]], own, radius)
                        })
                    });
                    let volume = 8.0 * one.half.product();
                    (filled.volume / volume, filled.moment / volume)
                },
                |part| (part, part * one.middle),
            );
            found(&one);
        }
    }
}
