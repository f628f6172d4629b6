//! The surface of a body with the loads on it: triangles about as wide as the points at which the
//! method has its traction are apart, whose corners have the load of the nearest of these.

use crate::geometry::Shape;
use crate::method::Traction;
use nalgebra::Vector3;
use std::collections::HashMap;

/// Width of triangles of curved surfaces over the distance of points, and the same of the longest
/// edge of any triangle.
const WIDTH: f64 = 1.5;
const LONGEST: f64 = 3.0;

/// Pressure and shear on a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Pressure (Pa).
    pub pressure: f64,
    /// Viscous traction on the body (Pa).
    pub shear: Vector3<f64>,
}

impl Load {
    /// The mean over a surface; zero without points.
    pub fn mean(tractions: &[Traction]) -> Load {
        let area: f64 = tractions.iter().map(|t| t.area).sum();
        let mut mean = Load::default();
        for t in tractions {
            mean.pressure += t.area / area * t.pressure;
            mean.shear += t.area / area * t.shear;
        }
        mean
    }
}

/// The points of a body at which its traction is known, to be found by place.
pub struct Points<'a> {
    tractions: &'a [Traction],
    /// Distance of points from each other (m).
    apart: f64,
    /// Numbers of the points in the boxes of a lattice.
    boxes: HashMap<[i64; 3], Vec<usize>>,
}

impl<'a> Points<'a> {
    /// The points of a body in so many dimensions; `None` of none.
    pub fn new(tractions: &'a [Traction], dimension: usize) -> Option<Points<'a>> {
        let area = tractions.iter().map(|t| t.area).sum::<f64>() / tractions.len() as f64;
        let apart = if dimension == 2 { area } else { area.sqrt() };
        // NaN without points.
        if apart.is_nan() || apart <= 0.0 {
            return None;
        }
        let mut points = Points { tractions, apart, boxes: HashMap::new() };
        for (k, t) in tractions.iter().enumerate() {
            points.boxes.entry(points.place(&t.arm)).or_default().push(k);
        }
        Some(points)
    }

    /// The box that a point lies in, by the way to it from the body's centre (m).
    fn place(&self, arm: &Vector3<f64>) -> [i64; 3] {
        (arm / (2.0 * self.apart)).map(|x| x.floor() as i64).into()
    }

    /// The load at the point that is nearest to a place, by the way to it from the body's centre
    /// (m).
    pub fn load(&self, arm: &Vector3<f64>) -> Load {
        let place = self.place(arm);
        let around = (0..27).flat_map(|n| {
            let beside = [n % 3, n / 3 % 3, n / 9].map(|k| k - 1);
            self.boxes.get(&std::array::from_fn(|a| place[a] + beside[a])).into_iter().flatten()
        });
        let distance = |t: &Traction| (t.arm - arm).norm_squared();
        let nearest = |a: &&Traction, b: &&Traction| distance(a).total_cmp(&distance(b));
        let near = around.map(|k| &self.tractions[*k]).min_by(nearest);
        let found = near.or_else(|| self.tractions.iter().min_by(nearest));
        found.map_or_else(Load::default, |t| Load { pressure: t.pressure, shear: t.shear })
    }

    /// The triangles of a shape's surface; in 2D segments, whose second corner stands twice.
    pub fn triangles(&self, shape: &dyn Shape) -> Vec<[Vector3<f64>; 3]> {
        let mut whole = shape.triangles(WIDTH * self.apart);
        let mut small = Vec::with_capacity(whole.len());
        while let Some([a, b, c]) = whole.pop() {
            let length = |[a, b, _]: &[Vector3<f64>; 3]| (b - a).norm_squared();
            let longest = |one: &[_; 3], other: &[_; 3]| length(one).total_cmp(&length(other));
            let turned = [[a, b, c], [b, c, a], [c, a, b]];
            let Some(longest) = turned.into_iter().max_by(longest) else { continue };
            let [from, to, other] = longest;
            let middle = 0.5 * (from + to);
            // Both triangles at an edge cut it, and in the same place.
            if length(&longest) <= (LONGEST * self.apart).powi(2) {
                small.push([a, b, c]);
            } else if b == c {
                whole.extend([[a, 0.5 * (a + b), 0.5 * (a + b)], [0.5 * (a + b), b, b]]);
            } else {
                whole.extend([[from, middle, other], [middle, to, other]]);
            }
        }
        small
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Disc;
    use mics_shapes::Polyhedron;

    #[test]
    fn surface_is_cut_into_small_triangles_that_fit() {
        let tractions = |area: f64| {
            vec![Traction {
                body: 0,
                arm: Vector3::zeros(),
                area,
                pressure: 1.0,
                shear: Vector3::zeros(),
            }]
        };
        let o = Vector3::zeros();
        let [x, y, z] = [0, 1, 2].map(|axis| Vector3::ith(axis, 1.0));
        let solid = Polyhedron::new(&[[o, y, x], [o, x, z], [o, z, y], [x, y, z]], 0.0).unwrap();
        let own = tractions(0.01);
        let triangles = Points::new(&own, 3).unwrap().triangles(&solid);
        let mut edges: HashMap<[[u64; 3]; 2], i32> = HashMap::new();
        let mut volume = 0.0;
        for [a, b, c] in &triangles {
            volume += a.dot(&b.cross(c)) / 6.0;
            for (from, to) in [(a, b), (b, c), (c, a)] {
                assert!((from - to).norm() < 0.3 + 1e-12);
                let [from, to] = [from, to].map(|x| <[f64; 3]>::from(*x).map(f64::to_bits));
                *edges.entry([from.min(to), from.max(to)]).or_default() +=
                    if from < to { 1 } else { -1 };
            }
        }
        // Each edge is one of two triangles, which run along it in opposite directions.
        assert!(edges.values().all(|count| *count == 0), "{} triangles", triangles.len());
        assert!((volume - 1.0 / 6.0).abs() < 1e-12, "{volume}");
        let own = tractions(0.1);
        let ring = Points::new(&own, 2).unwrap().triangles(&Disc { radius: 1.0 });
        let length: f64 = ring.iter().map(|[a, b, _]| (b - a).norm()).sum();
        assert!((length / std::f64::consts::TAU - 1.0).abs() < 2e-3, "{length}");
        assert!(Points::new(&[], 3).is_none());
    }
}
