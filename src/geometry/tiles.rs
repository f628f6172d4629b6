//! A lattice of boxes that a body is cut by, all in one go: what neighbours share is found once.
//!
//! ```text
//!   planes of an axis    p_0   p_1   p_2   ...
//!              box (i, j, k) from p_i to p_(i+1) along x, and so on
//! ```

use super::block::Block;
use super::circle::{self, Line, Lines, Parts};
use super::octant::{Corner, Pair, Plane, end};
use crate::grid::simd;
use nalgebra::Vector3;

/// The planes of a lattice, from a body's centre, and room for what is found on the way.
#[derive(Clone, Debug)]
pub struct Tiles {
    /// Places along each axis, ascending (m); two alike along z in 2D.
    pub planes: [Vec<f64>; 3],
    /// Of each interval between them the squares of its least and its largest distance from the
    /// centre (m2).
    squares: [Vec<[f64; 2]>; 3],
    cuts: [Vec<Plane>; 3],
    /// Of xy, yz, zx, the first axis fastest.
    pairs: [Vec<Pair>; 3],
    /// Of two layers in z.
    corners: [Vec<Option<Corner>>; 2],
    /// Of each layer of faces the radius of the sphere's circle in their planes (m), and the lines
    /// of the next two axes across it.
    circles: Vec<f64>,
    lines: [Vec<Line>; 2],
    /// Of a disc the lines in x, what it has below them and a line in y, and below the next one,
    /// and what it has between.
    across: Lines,
    parts: [Parts; 3],
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
    /// First moment of that part per volume of the box (m), where faces were asked for.
    pub moment: Vector3<f64>,
    /// The lever of the face in its middle (m), where faces were asked for: see
    /// [`super::Shape::tile`].
    pub lever: Vector3<f64>,
}

impl Filled {
    /// Goes to the box of this number along an axis.
    #[inline]
    fn set(&mut self, planes: &[Vec<f64>; 3], axis: usize, at: usize) {
        let low = planes[axis][at];
        let high = planes[axis][at + 1];
        self.at[axis] = at;
        (self.middle[axis], self.half[axis]) = (0.5 * (low + high), 0.5 * (high - low));
    }
}

impl Tiles {
    /// Room for so many planes along an axis.
    pub fn new(most: usize) -> Tiles {
        let square = most * most;
        Tiles {
            planes: std::array::from_fn(|_| Vec::with_capacity(most)),
            squares: std::array::from_fn(|_| Vec::with_capacity(most)),
            cuts: std::array::from_fn(|_| Vec::with_capacity(most)),
            pairs: std::array::from_fn(|_| Vec::with_capacity(square)),
            corners: std::array::from_fn(|_| Vec::with_capacity(square)),
            circles: Vec::with_capacity(most),
            lines: std::array::from_fn(|_| Vec::with_capacity(square)),
            across: Lines::with_capacity(most),
            parts: std::array::from_fn(|_| Parts::with_capacity(most)),
        }
    }

    /// Room for the lattices of a body of this radius (m) on a grid of such spacings (m).
    pub fn for_radius(radius: f64, h: &[f64]) -> Tiles {
        let least = h.iter().copied().fold(f64::INFINITY, f64::min);
        Tiles::new((2.0 * radius / least) as usize + 5)
    }

    /// Sets the planes for the boxes of a block, of which number n along an axis lies between the
    /// places n and n + 1 (m). Returns the first box, if there is any.
    pub fn set<const D: usize>(
        &mut self,
        block: &Block<D>,
        place: impl Fn(usize, usize) -> f64,
    ) -> Option<[usize; D]> {
        let (first, last) = block.ends()?;
        for (a, planes) in self.planes.iter_mut().enumerate() {
            planes.clear();
            if a < D {
                planes.extend((first[a]..=last[a] + 1).map(|n| place(a, n)));
            } else {
                planes.extend([0.0; 2]);
            }
        }
        self.find_squares();
        Some(first)
    }

    fn find_squares(&mut self) {
        for (squares, planes) in self.squares.iter_mut().zip(&self.planes) {
            let square = |low: f64, high: f64| {
                let near = low.max(-high).max(0.0);
                let far = low.abs().max(high.abs());
                [near * near, far * far]
            };
            squares.clear();
            squares.extend(planes.windows(2).map(|ends| square(ends[0], ends[1])));
        }
    }

    /// A box of the lattice, of which nothing is filled.
    pub(super) fn empty(planes: &[Vec<f64>; 3], at: [usize; 3]) -> Filled {
        let end = |n: usize| Vector3::from_fn(|a, _| planes[a][at[a] + n]);
        let low = end(0);
        let high = end(1);
        let middle = 0.5 * (low + high);
        let half = 0.5 * (high - low);
        Filled { at, part: 0.0, middle, half, moment: Vector3::zeros(), lever: Vector3::zeros() }
    }

    /// Each box that a round body of the given radius (m) reaches, and whether it fills it as a
    /// whole.
    fn for_reached(
        planes: &[Vec<f64>; 3],
        squares: &[Vec<[f64; 2]>; 3],
        radius: f64,
        mut reached: impl FnMut(Filled, bool),
    ) {
        let square = radius * radius;
        let [x, y, z] = squares;
        for (k, z) in z.iter().enumerate() {
            for (j, y) in y.iter().enumerate() {
                let [near, far] = [y[0] + z[0], y[1] + z[1]];
                if near >= square {
                    continue;
                }
                for (i, x) in x.iter().enumerate() {
                    if x[0] + near < square {
                        reached(Tiles::empty(planes, [i, j, k]), x[1] + far <= square);
                    }
                }
            }
        }
    }

    /// The boxes that a disc of the given radius (m) reaches, with moments where faces are asked
    /// for.
    pub fn of_disc(&mut self, radius: f64, faces: Option<usize>, found: &mut dyn FnMut(&Filled)) {
        if let Some(axis) = faces {
            self.find_radii(radius, axis);
        }
        let Tiles { planes, squares, across, parts: [low, high, between], circles, .. } = self;
        let line = |at: f64| Line::new(at, radius);
        across.set(&planes[0], radius);
        let moments = faces.is_some();
        high.set_below(across, &line(planes[1][0]), radius, moments);
        let square = radius * radius;
        let z = squares[2][0];
        let mut one = Tiles::empty(planes, [0; 3]);
        for (j, y) in squares[1].iter().enumerate() {
            let [near, far] = [y[0] + z[0], y[1] + z[1]];
            std::mem::swap(low, high);
            let next = line(planes[1][j + 1]);
            simd(
                #[inline(always)]
                || {
                    high.set_below(across, &next, radius, moments);
                    between.set_between(low, high, moments);
                },
            );
            one.set(planes, 1, j);
            for (i, x) in squares[0].iter().enumerate() {
                if x[0] + near >= square {
                    continue;
                }
                one.set(planes, 0, i);
                (one.part, one.moment) = (1.0, one.middle);
                if x[1] + far > square {
                    let area = 4.0 * one.half.x * one.half.y;
                    one.part = between.area[i] / area;
                    if moments {
                        let [x, y] = [&between.moment[0], &between.moment[1]].map(|m| m[i]);
                        one.moment = Vector3::new(x, y, 0.0) / area;
                    }
                }
                if let Some(axis) = faces {
                    let c = circles[one.at[axis]];
                    one.lever = circle::chord_lever(axis, &one.middle, &one.half, c);
                }
                found(&one);
            }
        }
    }

    /// The boxes that a sphere of the given radius (m) reaches, likewise.
    pub fn of_sphere(&mut self, radius: f64, faces: Option<usize>, found: &mut dyn FnMut(&Filled)) {
        if let Some(axis) = faces {
            self.find_circles(radius, axis);
        }
        self.find_pairs(radius);
        let Tiles { planes, squares, cuts, pairs, corners, circles, lines, .. } = self;
        let [nx, ny, nz] = cuts.each_ref().map(Vec::len);
        for layer in corners.iter_mut() {
            layer.clear();
            layer.resize(nx * ny, None);
        }
        let mut layer = 0;
        let mut last = None;
        Tiles::for_reached(planes, squares, radius, |mut one, whole| {
            // A layer that nothing reaches lies outside of all that are reached.
            if one.at[2] > layer {
                layer = one.at[2];
                corners.swap(0, 1);
                corners[1].fill(None);
            }
            (one.part, one.moment) = (1.0, one.middle);
            if !whole {
                let mut ends = |at: [usize; 3]| {
                    end(|high| {
                        let [i, j, k] = [at[0], at[1] + high[0], at[2] + high[1]];
                        *corners[high[1]][i + nx * j].get_or_insert_with(|| {
                            let own = [
                                &pairs[0][i + nx * j],
                                &pairs[1][j + ny * k],
                                &pairs[2][k + nz * i],
                            ];
                            let planes = [&cuts[0][i], &cuts[1][j], &cuts[2][k]];
                            Corner::new(planes, own, radius, faces.is_some())
                        })
                    })
                };
                // Where the box before it ends.
                let mut filled = match last {
                    Some((at, low)) if at == one.at => low,
                    _ => ends(one.at),
                };
                let next = [one.at[0] + 1, one.at[1], one.at[2]];
                let high = ends(next);
                last = Some((next, high));
                filled.add(-1.0, &high);
                let volume = 8.0 * one.half.product();
                (one.part, one.moment) = (filled.volume / volume, filled.moment / volume);
            }
            if let Some(axis) = faces {
                let layer = one.at[axis];
                let ends = [0, 1].map(|n| {
                    let a = (axis + 1 + n) % 3;
                    let low = layer * planes[a].len() + one.at[a];
                    [&lines[n][low], &lines[n][low + 1]]
                });
                one.lever = circle::lever(axis, &one.middle, ends, circles[layer]);
            }
            found(&one);
        });
    }

    /// What a sphere of the given radius (m) has beyond each plane and each two of them.
    fn find_pairs(&mut self, radius: f64) {
        for (cuts, planes) in self.cuts.iter_mut().zip(&self.planes) {
            cuts.clear();
            cuts.extend(planes.iter().map(|at| Plane::new(*at, radius)));
        }
        for (a, pairs) in self.pairs.iter_mut().enumerate() {
            let first = &self.cuts[a];
            let second = &self.cuts[(a + 1) % 3];
            pairs.clear();
            pairs.extend(
                second.iter().flat_map(|q| first.iter().map(move |p| Pair::new(p, q, radius))),
            );
        }
    }

    /// Radii of the circles, or half the chords, of a round body of the given radius (m) in the
    /// planes of faces (m).
    fn find_radii(&mut self, radius: f64, axis: usize) {
        let Tiles { planes, circles, .. } = self;
        let middle = |ends: &[f64]| 0.5 * (ends[0] + ends[1]);
        circles.clear();
        circles.extend(planes[axis].windows(2).map(|ends| circle::radius(radius, middle(ends))));
    }

    /// The circles of a sphere of the given radius (m) in the planes of faces, and the lines across
    /// them.
    fn find_circles(&mut self, radius: f64, axis: usize) {
        self.find_radii(radius, axis);
        let Tiles { planes, circles, lines, .. } = self;
        for (n, lines) in lines.iter_mut().enumerate() {
            let across = &planes[(axis + 1 + n) % 3];
            lines.clear();
            lines.extend(
                circles.iter().flat_map(|radius| across.iter().map(|at| Line::new(*at, *radius))),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Disc, Orientation, Shape, Sphere};

    /// The lever of a face of a disc or a sphere.
    fn lever(shape: &dyn Shape, axis: usize, one: &Filled) -> Vector3<f64> {
        let Filled { middle, half, .. } = one;
        let radius = circle::radius(shape.radius(), middle[axis]);
        if shape.dimension() == 2 {
            return circle::chord_lever(axis, middle, half, radius);
        }
        let lines = [1, 2].map(|n| {
            let a = (axis + n) % 3;
            [middle[a] - half[a], middle[a] + half[a]].map(|at| Line::new(at, radius))
        });
        circle::lever(axis, middle, lines.each_ref().map(|[low, high]| [low, high]), radius)
    }

    /// All that a lattice finds of a shape, box by box as by its own methods; the largest
    /// differences of parts, and of moments and levers over the spacing.
    fn worst(shape: &dyn Shape, faces: usize) -> (f64, f64) {
        let orientation = Orientation::identity();
        let mut tiles = Tiles::for_radius(shape.radius(), &[0.13, 0.1, 0.11]);
        let three = shape.dimension() == 3;
        let mut differences = (0.0f64, 0.0f64);
        for shift in [0.0, 0.013, 0.05, 0.0999] {
            for (a, planes) in tiles.planes.iter_mut().enumerate() {
                let h = [0.13, 0.1, 0.11][a];
                let n = (shape.radius() / h) as i32 + 2;
                planes.clear();
                planes.extend(
                    (-n..=n).map(|k| if a < 2 || three { f64::from(k) * h + shift } else { 0.0 }),
                );
                planes.truncate(if a < 2 || three { planes.len() } else { 2 });
            }
            tiles.find_squares();
            let mut one_by_one = Vec::new();
            let mut sum = 0.0;
            let counts = tiles.planes.each_ref().map(|planes| planes.len() - 1);
            for k in 0..counts.iter().product() {
                let at = [k % counts[0], k / counts[0] % counts[1], k / counts[0] / counts[1]];
                let mut one = Tiles::empty(&tiles.planes, at);
                let whole: f64 = (0..shape.dimension()).map(|a| 2.0 * one.half[a]).product();
                let (filled, moment) = shape.moments(&orientation, &one.middle, &one.half);
                (one.part, one.moment) = (filled / whole, moment / whole);
                one.lever = lever(shape, faces, &one);
                one_by_one.push(one);
            }
            let mut rest = one_by_one.iter();
            shape.tile(&orientation, &mut tiles, Some(faces), &mut |one| {
                let Some(own) = rest.find(|own| own.at == one.at || own.part > 1e-9) else {
                    panic!("{one:?} is no box")
                };
                assert_eq!(one.at, own.at, "passed over: {own:?}");
                differences.0 = differences.0.max((one.part - own.part).abs());
                let apart = (one.moment - own.moment).amax().max((one.lever - own.lever).amax());
                differences.1 = differences.1.max(apart / 0.1);
                sum += one.part;
            });
            let whole: f64 = (0..shape.dimension()).map(|a| [0.13, 0.1, 0.11][a]).product();
            assert!((sum * whole / shape.volume() - 1.0).abs() < 1e-12, "{sum}");
        }
        differences
    }

    #[test]
    fn tiled_lattice_fractions_equal_single_boxes() {
        for shape in [&Disc { radius: 0.5 } as &dyn Shape, &Sphere { radius: 0.5 }] {
            for faces in 0..shape.dimension() {
                let (parts, moments) = worst(shape, faces);
                assert!(
                    parts < 1e-11 && moments < 1e-10,
                    "{shape:?} along {faces}: {parts:.1e}, {moments:.1e}"
                );
            }
        }
    }
}
