//! Parts that discs and spheres fill of a lattice of boxes, all in one go: what neighbours share is
//! found once.
//!
//! ```text
//!      +----+----+        a disc by the lines of the lattice across it ([`super::circle`]),
//!      |  ,-|--. |        a sphere by its corners ([`super::octant`]): each box is a sum over
//!      +-/--+---\+        its own
//! ```

use super::circle::{self, Line, Lines, Parts};
use super::octant::{Corner, Pair, Plane, end};
use super::{Lattice, Tile, make_room};
use nalgebra::Vector3;
use std::cell::RefCell;

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// Scratch for what is found on the way, used again.
#[derive(Debug, Default)]
struct Scratch {
    /// Squares of the least and the largest distance of each interval between planes from the
    /// centre (m2).
    squares: [Vec<[f64; 2]>; 3],
    cuts: [Vec<Plane>; 3],
    /// Pairs of planes normal to xy, yz, zx, the first axis fastest.
    pairs: [Vec<Pair>; 3],
    /// Corners in two layers in z.
    corners: [Vec<Option<Corner>>; 2],
    /// Radius of the sphere's circle in the planes of each layer of faces (m), and the lines of the
    /// next two axes across it.
    circles: Vec<f64>,
    lines: [Vec<Line>; 2],
    /// Lines in x across a disc, and the parts of it below them and a line in y, below them and the
    /// next one, and between.
    across: Lines,
    parts: [Parts; 3],
}

/// Calls with the boxes that a disc of this radius (m) reaches, with moments where faces are asked
/// for.
pub(crate) fn tile_disc(radius: f64, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
    let radius = lattice.factor * radius;
    SCRATCH.with_borrow_mut(|room| room.of_disc(radius, lattice, found));
}

/// Calls with the boxes that a sphere of this radius (m) reaches, likewise.
pub(crate) fn tile_sphere(radius: f64, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
    let radius = lattice.factor * radius;
    SCRATCH.with_borrow_mut(|room| room.of_sphere(radius, lattice, found));
}

/// Each box that a round body of the given radius (m) reaches, and whether it fills it as a whole.
fn for_reached(
    planes: &[Vec<f64>; 3],
    squares: &[Vec<[f64; 2]>; 3],
    radius: f64,
    mut reached: impl FnMut(Tile, bool),
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
                    reached(Tile::empty(planes, [i, j, k]), x[1] + far <= square);
                }
            }
        }
    }
}

impl Scratch {
    fn find_squares(&mut self, planes: &[Vec<f64>; 3]) {
        for (squares, planes) in self.squares.iter_mut().zip(planes) {
            let square = |low: f64, high: f64| {
                let near = low.max(-high).max(0.0);
                let far = low.abs().max(high.abs());
                [near * near, far * far]
            };
            make_room(squares, planes.len(), 1);
            squares.extend(planes.windows(2).map(|ends| square(ends[0], ends[1])));
        }
    }

    fn of_disc(&mut self, radius: f64, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        let Lattice { planes, faces, .. } = *lattice;
        self.find_squares(planes);
        if let Some(axis) = faces {
            self.find_radii(radius, planes, axis);
        }
        let Scratch { squares, across, parts: [low, high, between], circles, .. } = self;
        let line = |at: f64| Line::new(at, radius);
        across.set(&planes[0], radius);
        let moments = faces.is_some();
        high.set_below(across, &line(planes[1][0]), radius, moments);
        let square = radius * radius;
        let z = squares[2][0];
        let mut one = Tile::empty(planes, [0; 3]);
        for (j, y) in squares[1].iter().enumerate() {
            let [near, far] = [y[0] + z[0], y[1] + z[1]];
            std::mem::swap(low, high);
            let next = line(planes[1][j + 1]);
            pulp::Arch::new().dispatch(
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
                one.part = 1.0;
                one.moment = one.middle;
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

    fn of_sphere(&mut self, radius: f64, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        let Lattice { planes, faces, .. } = *lattice;
        self.find_squares(planes);
        if let Some(axis) = faces {
            self.find_circles(radius, planes, axis);
        }
        self.find_pairs(radius, planes);
        let Scratch { squares, cuts, pairs, corners, circles, lines, .. } = self;
        let [nx, ny, nz] = cuts.each_ref().map(Vec::len);
        for layer in corners.iter_mut() {
            make_room(layer, nx * ny, 2);
            layer.resize(nx * ny, None);
        }
        let mut layer = 0;
        let mut last = None;
        for_reached(planes, squares, radius, |mut one, whole| {
            // A layer that nothing reaches lies outside of all that are reached.
            if one.at[2] > layer {
                layer = one.at[2];
                corners.swap(0, 1);
                corners[1].fill(None);
            }
            one.part = 1.0;
            one.moment = one.middle;
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
                one.part = filled.volume / volume;
                one.moment = filled.moment / volume;
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

    /// Finds the parts of a sphere of the given radius (m) beyond each plane and each two of them.
    fn find_pairs(&mut self, radius: f64, planes: &[Vec<f64>; 3]) {
        for (cuts, planes) in self.cuts.iter_mut().zip(planes) {
            make_room(cuts, planes.len(), 1);
            cuts.extend(planes.iter().map(|at| Plane::new(*at, radius)));
        }
        for (a, pairs) in self.pairs.iter_mut().enumerate() {
            let first = &self.cuts[a];
            let second = &self.cuts[(a + 1) % 3];
            make_room(pairs, first.len() * second.len(), 2);
            pairs.extend(
                second.iter().flat_map(|q| first.iter().map(move |p| Pair::new(p, q, radius))),
            );
        }
    }

    /// Radii of the circles, or half the chords, of a round body of the given radius (m) in the
    /// planes of faces (m).
    fn find_radii(&mut self, radius: f64, planes: &[Vec<f64>; 3], axis: usize) {
        let circles = &mut self.circles;
        let middle = |ends: &[f64]| 0.5 * (ends[0] + ends[1]);
        make_room(circles, planes[axis].len(), 1);
        circles.extend(planes[axis].windows(2).map(|ends| circle::radius(radius, middle(ends))));
    }

    /// The circles of a sphere of the given radius (m) in the planes of faces, and the lines across
    /// them.
    fn find_circles(&mut self, radius: f64, planes: &[Vec<f64>; 3], axis: usize) {
        self.find_radii(radius, planes, axis);
        let Scratch { circles, lines, .. } = self;
        for (n, lines) in lines.iter_mut().enumerate() {
            let across = &planes[(axis + 1 + n) % 3];
            make_room(lines, circles.len() * across.len(), 2);
            lines.extend(
                circles.iter().flat_map(|radius| across.iter().map(|at| Line::new(*at, *radius))),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::octant;
    use super::*;
    use crate::Orientation;
    use crate::{Disc, Shape, Sphere};

    const H: [f64; 3] = [0.13, 0.1, 0.11];

    fn lattice<'a>(planes: &'a [Vec<f64>; 3], faces: usize) -> Lattice<'a> {
        Lattice { factor: 1.0, orientation: Orientation::identity(), planes, faces: Some(faces) }
    }

    /// A box by itself: what a disc or a sphere fills of it, and its first moment.
    fn single(shape: &dyn Shape, one: &Tile) -> (f64, Vector3<f64>) {
        let [low, high] = [one.middle - one.half, one.middle + one.half];
        if shape.dimension() == 3 {
            let filled = octant::of_box(&low, &high, shape.radius());
            return (filled.volume, filled.moment);
        }
        let [x, y] = [0, 1].map(|a| [low[a], high[a]].map(|at| Line::new(at, shape.radius())));
        let filled = circle::rectangle([&x[0], &x[1]], [&y[0], &y[1]], shape.radius());
        (filled.area, Vector3::new(filled.moment[0], filled.moment[1], 0.0))
    }

    /// The lever of a face of a disc or a sphere.
    fn lever(shape: &dyn Shape, axis: usize, one: &Tile) -> Vector3<f64> {
        let Tile { middle, half, .. } = one;
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

    /// All that a lattice finds of a shape against box by box; the largest differences of parts,
    /// and of moments and levers over the spacing.
    fn worst(shape: &dyn Shape, faces: usize) -> (f64, f64) {
        let dimension = shape.dimension();
        let mut differences = (0.0f64, 0.0f64);
        for shift in [0.0, 0.013, 0.05, 0.0999] {
            let planes = [0, 1, 2].map(|a| {
                let n = (shape.radius() / H[a]) as i32 + 2;
                let places = (-n..=n).map(|k| f64::from(k) * H[a] + shift);
                if a < dimension { places.collect() } else { vec![0.0; 2] }
            });
            let mut one_by_one = Vec::new();
            let mut sum = 0.0;
            let counts = planes.each_ref().map(|planes| planes.len() - 1);
            for k in 0..counts.iter().product() {
                let at = [k % counts[0], k / counts[0] % counts[1], k / counts[0] / counts[1]];
                let mut one = Tile::empty(&planes, at);
                let whole: f64 = (0..dimension).map(|a| 2.0 * one.half[a]).product();
                let (filled, moment) = single(shape, &one);
                one.part = filled / whole;
                one.moment = moment / whole;
                one.lever = lever(shape, faces, &one);
                one_by_one.push(one);
            }
            let mut rest = one_by_one.iter();
            shape.tile(&lattice(&planes, faces), &mut |one| {
                let Some(own) = rest.find(|own| own.at == one.at || own.part > 1e-9) else {
                    panic!("{one:?} is no box")
                };
                assert_eq!(one.at, own.at, "passed over: {own:?}");
                differences.0 = differences.0.max((one.part - own.part).abs());
                let apart = (one.moment - own.moment).amax().max((one.lever - own.lever).amax());
                differences.1 = differences.1.max(apart / 0.1);
                sum += one.part;
            });
            let whole: f64 = H.iter().take(dimension).product();
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
