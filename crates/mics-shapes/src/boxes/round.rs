//! Parts that discs and spheres fill of a lattice of boxes, all in one go: what neighbours share is
//! found once.
//!
//! ```text
//!      +----+----+        a disc by the lines of the lattice across it ([`super::circle`]),
//!      |  ,-|--. |        a sphere by its corners ([`super::octant`]): each box is a sum over
//!      +-/--+---\+        its own
//! ```

use super::circle::{self, Line, Lines, Parts, VECTOR};
use super::octant::Corners;
use super::{Lattice, Tile, make_room};
use nalgebra::Vector3;
use std::cell::RefCell;

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// Planes that are treated in one go.
const AT_ONCE: usize = 3 * VECTOR;

/// Scratch for what is found on the way, used again.
#[derive(Debug, Default)]
struct Scratch {
    /// Squares of the least and the largest distance of each interval between planes from the
    /// centre (m2).
    squares: [Vec<[f64; 2]>; 3],
    corners: Corners,
    /// Radius of the sphere's circle in the planes of each layer of faces (m), and the lines of the
    /// next two axes across it.
    circles: Vec<f64>,
    lines: [Lines; 2],
    /// Lines in x across a disc, and the parts of it below them and a line in y, below them and the
    /// next one, and between.
    across: Lines,
    parts: [Parts; 3],
}

/// Calls with the boxes that a disc of this radius (m) reaches, with moments where faces are asked
/// for.
pub(crate) fn tile_disc(radius: f64, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
    let radius = lattice.factor * radius;
    SCRATCH.with_borrow_mut(|room| {
        pulp::Arch::new().dispatch(
            // A closure that could run twice would be called by a wrapper, without wide vectors.
            #[inline(always)]
            move || {
                let only = found;
                room.of_disc(radius, lattice, only);
            },
        );
    });
}

/// Calls with the boxes that a sphere of this radius (m) reaches, likewise.
pub(crate) fn tile_sphere(radius: f64, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
    let radius = lattice.factor * radius;
    SCRATCH.with_borrow_mut(|room| {
        pulp::Arch::new().dispatch(
            #[inline(always)]
            move || {
                let only = found;
                room.of_sphere(radius, lattice, only);
            },
        );
    });
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

    #[inline(always)]
    fn of_disc(&mut self, radius: f64, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        let Lattice { planes, faces, .. } = *lattice;
        self.find_squares(planes);
        if let Some(axis) = faces {
            self.find_radii(radius, planes, axis);
        }
        let Scratch { squares, across, parts: [low, high, between], circles, .. } = self;
        across.clear(1, planes[0].len());
        across.add(&planes[0], radius);
        let moments = faces.is_some();
        high.set_below(across, &Line::new(planes[1][0], radius), radius, moments);
        let square = radius * radius;
        let z = squares[2][0];
        let mut one = Tile::empty(planes, [0; 3]);
        for (j, y) in squares[1].iter().enumerate() {
            let [near, far] = [y[0] + z[0], y[1] + z[1]];
            std::mem::swap(low, high);
            let next = Line::new(planes[1][j + 1], radius);
            high.set_below(across, &next, radius, moments);
            between.set_between(low, high, moments);
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

    #[inline(always)]
    fn of_sphere(&mut self, radius: f64, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        let Lattice { planes, faces, .. } = *lattice;
        self.find_squares(planes);
        if let Some(axis) = faces {
            self.find_circles(radius, planes, axis);
        }
        let Scratch { squares: [x, y, z], corners, circles, lines, .. } = self;
        corners.set(planes, radius);
        let square = radius * radius;
        let mut one = Tile::empty(planes, [0; 3]);
        for (k, z) in z.iter().enumerate() {
            one.set(planes, 2, k);
            for (j, y) in y.iter().enumerate() {
                let [near, far] = [y[0] + z[0], y[1] + z[1]];
                if near >= square {
                    continue;
                }
                one.set(planes, 1, j);
                let [y_middle, z_middle] = [one.middle.y, one.middle.z];
                // The planes in x before this one have their sums, where they are needed.
                let mut known = 0;
                for (i, x) in x.iter().enumerate() {
                    if x[0] + near >= square {
                        continue;
                    }
                    one.set(planes, 0, i);
                    let x_middle = 0.5 * (planes[0][i] + planes[0][i + 1]);
                    one.moment = Vector3::new(x_middle, y_middle, z_middle);
                    one.lever = Vector3::new(x_middle, y_middle, z_middle);
                    one.part = 1.0;
                    if x[1] + far > square {
                        if i + 1 >= known {
                            let from = known.max(i - i % VECTOR);
                            known = (from + AT_ONCE).min(corners.count());
                            corners.find([j, k], from..known, faces.is_some());
                        }
                        let (filled, moment) = corners.part(i);
                        let density = 0.125 / one.half.product();
                        one.part = density * filled;
                        one.moment = density * moment;
                        if let Some(axis) = faces {
                            let layer = one.at[axis];
                            let ends = [0, 1].map(|n| {
                                let a = (axis + 1 + n) % 3;
                                let line = |at: usize| lines[n].get(layer, at, planes[a].len());
                                [line(one.at[a]), line(one.at[a] + 1)]
                            });
                            one.lever = circle::lever(axis, &one.middle, &ends, circles[layer]);
                        }
                    }
                    found(&one);
                }
            }
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
    #[inline(always)]
    fn find_circles(&mut self, radius: f64, planes: &[Vec<f64>; 3], axis: usize) {
        self.find_radii(radius, planes, axis);
        let Scratch { circles, lines, .. } = self;
        for (n, lines) in lines.iter_mut().enumerate() {
            let across = &planes[(axis + 1 + n) % 3];
            lines.clear(circles.len(), across.len());
            for radius in circles.iter() {
                lines.add(across, *radius);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::ball;
    use super::super::convex::Convex;
    use super::*;
    use crate::Orientation;
    use crate::scatter::scatter;
    use crate::{Disc, Shape, Sphere};

    const H: [f64; 3] = [0.13, 0.1, 0.11];

    fn lattice<'a>(planes: &'a [Vec<f64>; 3], faces: usize) -> Lattice<'a> {
        Lattice { factor: 1.0, orientation: Orientation::identity(), planes, faces: Some(faces) }
    }

    /// A box by itself: what a disc or a sphere fills of it, and its first moment.
    fn single(shape: &dyn Shape, one: &Tile) -> (f64, Vector3<f64>) {
        if shape.dimension() == 3 {
            let mut body = Convex::default();
            body.set_box(&one.middle, &[0, 1, 2].map(|a| Vector3::ith(a, one.half[a])));
            return ball::moments(&body, &Vector3::zeros(), shape.radius());
        }
        let ends = |a: usize| [one.middle[a] - one.half[a], one.middle[a] + one.half[a]];
        let [x, y] = [0, 1].map(|a| ends(a).map(|at| Line::new(at, shape.radius())));
        let filled = circle::rectangle(&x, &y, shape.radius());
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
        circle::lever(axis, middle, &lines, radius)
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
                println!("{shape:?} along {faces}: {parts:.1e}, {moments:.1e}");
                assert!(
                    parts < 1e-12 && moments < 1e-12,
                    "{shape:?} along {faces}: {parts:.1e}, {moments:.1e}"
                );
            }
        }
    }

    /// Planes of a lattice about a sphere of radius 1, some of which touch it, go through its
    /// centre or have corners on it.
    fn drawn(k: usize) -> [Vec<f64>; 3] {
        const SPECIAL: [f64; 9] = [0.0, 1.0, -1.0, 0.6, -0.6, 0.8, -0.8, 2.0 / 3.0, -1.0 / 3.0];
        [0, 1, 2].map(|a| {
            let place = |n: usize| {
                let drawn = scatter(100 * k + 10 * a + n);
                if (k + n).is_multiple_of(2) {
                    SPECIAL[(4.5 * (1.0 + drawn)) as usize]
                } else {
                    1.3 * drawn
                }
            };
            let mut places: Vec<f64> = (0..6).map(place).collect();
            places.sort_by(f64::total_cmp);
            places.dedup();
            places
        })
    }

    #[test]
    fn sphere_in_boxes_equals_sum_over_their_faces() {
        let shape = Sphere { radius: 1.0 };
        let mut worst = [0.0f64; 2];
        for k in 0..500 {
            let planes = drawn(k);
            let mut sum = 0.0;
            shape.tile(&lattice(&planes, 0), &mut |one| {
                let (filled, moment) = single(&shape, one);
                let volume = 8.0 * one.half.product();
                worst[0] = worst[0].max((volume * one.part - filled).abs());
                worst[1] = worst[1].max((volume * one.moment - moment).amax());
                sum += volume * one.part;
            });
            let [low, high] = [0, 5].map(|n| planes.each_ref().map(|p| p[n.min(p.len() - 1)]));
            let whole =
                single(&shape, &Tile::empty(&[0, 1, 2].map(|a| vec![low[a], high[a]]), [0; 3]));
            assert!((sum - whole.0).abs() < 1e-14, "{sum} {whole:?}");
        }
        println!("volume and moment: {worst:?}");
        assert!(worst.iter().all(|worst| *worst < 1e-14), "{worst:?}");
    }

    #[test]
    fn sphere_in_mirrored_boxes_is_same_to_the_last_bit() {
        let shape = Sphere { radius: 1.0 };
        for (k, axis) in (0..60).flat_map(|k| (0..3).map(move |axis| (k, axis))) {
            let planes = drawn(k);
            let mut other = planes.clone();
            other[axis] = planes[axis].iter().rev().map(|at| -at).collect();
            let mut mirrored = Vec::new();
            shape.tile(&lattice(&other, 1), &mut |one| mirrored.push(*one));
            shape.tile(&lattice(&planes, 1), &mut |one| {
                let mut at = one.at;
                at[axis] = planes[axis].len() - 2 - at[axis];
                let other = mirrored.iter().find(|other| other.at == at).expect("the box");
                let mut turn = Vector3::repeat(1.0);
                turn[axis] = -1.0;
                assert_eq!(one.part, other.part);
                assert_eq!(one.moment, turn.component_mul(&other.moment));
                assert_eq!(one.lever, turn.component_mul(&other.lever));
            });
        }
    }
}
