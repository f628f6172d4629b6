//! An ellipse: the section of an elliptic cylinder along z, of unit depth.

use super::{Core, Geometry, Lattice, Nearest, Part, Patch, Tile, rim};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use std::f64::consts::{PI, TAU};

/// An ellipse (2D).
#[derive(Clone, Debug)]
pub struct Ellipse {
    half: Vector2<f64>,
    parts: [Part; 1],
}

impl Ellipse {
    /// With these axes along x and y (m), whole lengths, both positive.
    pub fn new(axes: [f64; 2]) -> Ellipse {
        let half = Vector2::new(0.5 * axes[0], 0.5 * axes[1]);
        // The sharpest radius of curvature is b^2/a.
        let inset = skin(half.min(), half.min() * half.min() / half.max());
        let core = Core::Ellipsoid { half: Vector3::new(half.x, half.y, 0.0), inset };
        let part = Part { place: Vector3::zeros(), core, rounding: inset, radius: half.max() };
        Ellipse { half, parts: [part] }
    }

    fn point(&self, angle: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (sin, cos) = angle.sin_cos();
        (
            Vector3::new(self.half.x * cos, self.half.y * sin, 0.0),
            Vector3::new(self.half.y * cos, self.half.x * sin, 0.0),
        )
    }

    fn count(&self, spacing: f64) -> usize {
        4 * (0.5 * TAU * self.half.max() / spacing).ceil().max(1.0) as usize
    }
}

/// Thickness of the skin of a curved body (m), by its smallest half width and its smallest radius
/// of curvature (m).
pub fn skin(half: f64, curvature: f64) -> f64 {
    (0.05 * half).min(0.5 * curvature)
}

/// The point of an ellipse or ellipsoid that is nearest to one, with these half axes (m): for a
/// point in the first octant `q_i = a_i^2 p_i/(t + a_i^2)`, with t the largest root of q on the
/// surface (Eberly); `u = t + least a_i^2` keeps its digits where t does not.
pub fn nearest<const D: usize>(half: [f64; D], point: [f64; D]) -> ([f64; D], [f64; D]) {
    let least = half.iter().copied().fold(f64::INFINITY, f64::min);
    let p = point.map(|x| x.abs().max(1e-14 * least));
    let square = half.map(|a| a * a);
    let lowest = least * least;
    let more = square.map(|square| square - lowest);
    // Newton's method for one over the root of the sum, which is concave and nearly straight: it
    // comes from below. Each term by itself is a bound, and so is the whole with all of a_i the
    // least (outside) or the largest one (inside).
    let mut u = 0.0f64;
    let mut norm = 0.0;
    let mut widest = 0.0f64;
    for a in 0..D {
        u = u.max(half[a] * p[a] - more[a]);
        norm += (p[a] / half[a]).powi(2);
        widest = widest.max(square[a]);
    }
    let scale = norm.sqrt() - 1.0;
    u = u.max(lowest + scale * if scale > 0.0 { lowest } else { widest });
    for _ in 0..100 {
        let mut value = 0.0;
        let mut slope = 0.0;
        for a in 0..D {
            let inverse = 1.0 / (u + more[a]);
            let term = half[a] * p[a] * inverse;
            value += term * term;
            slope += term * term * inverse;
        }
        let way = value * (value.sqrt() - 1.0) / slope;
        u += way.max(0.0);
        if way <= 1e-9 * u {
            break;
        }
    }
    let foot = std::array::from_fn(|a| (square[a] * p[a] / (u + more[a])).copysign(point[a]));
    let normal: [f64; D] = std::array::from_fn(|a| foot[a] / square[a]);
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    (foot, normal.map(|x| x / length))
}

impl Geometry for Ellipse {
    fn dimension(&self) -> usize {
        2
    }

    fn radius(&self) -> f64 {
        self.half.max()
    }

    fn volume(&self) -> f64 {
        PI * self.half.x * self.half.y
    }

    fn inertia(&self) -> Matrix3<f64> {
        let square = 0.25 * self.volume() * self.half.component_mul(&self.half);
        Matrix3::from_diagonal(&Vector3::new(square.y, square.x, square.x + square.y))
    }

    fn thickness(&self) -> f64 {
        2.0 * self.half.min()
    }

    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let (foot, normal) = nearest([self.half.x, self.half.y], [point.x, point.y]);
        let normal = Vector3::new(normal[0], normal[1], 0.0);
        let distance = (point - Vector3::new(foot[0], foot[1], point.z)).dot(&normal);
        Nearest { distance, normal }
    }

    /// A point stretched with the ellipse to a disc moves no faster than by the least half axis.
    fn clearance(&self, point: &Vector3<f64>) -> Option<f64> {
        Some((point.xy().component_div(&self.half).norm() - 1.0) * self.half.min())
    }

    /// That which touches it on the way from the point to the centre.
    fn plane(&self, point: &Vector3<f64>) -> Option<Nearest> {
        let scaled = point.xy().component_div(&self.half);
        let norm = scaled.norm();
        let slope = scaled.component_div(&self.half);
        let normal = slope.try_normalize(0.0)?;
        let distance = (norm - 1.0) * norm / slope.norm();
        Some(Nearest { distance, normal: normal.push(0.0) })
    }

    fn surface(&self, spacing: f64) -> Vec<Patch> {
        let count = self.count(spacing);
        let patch = |i: usize| {
            let (place, across) = self.point(TAU * ((i as f64 + 0.5) / count as f64));
            let area = TAU / count as f64 * across.norm();
            Patch { place, normal: across.normalize(), area }
        };
        (0..count).map(patch).collect()
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        (self.half.x * n.x).hypot(self.half.y * n.y)
    }

    fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        let axes = lattice.turn.matrix().fixed_view::<2, 2>(0, 0);
        let axes = axes * Matrix2::from_diagonal(&(lattice.factor * self.half));
        let whole = rim::Stretched::new(Vector2::zeros(), axes);
        rim::tile(lattice.planes, found, |rim, planes| rim.add_ellipse(planes, &whole));
    }

    fn parts(&self) -> &[Part] {
        &self.parts
    }

    fn triangles(&self, spacing: f64) -> Vec<[Vector3<f64>; 3]> {
        let count = self.count(spacing);
        let at = |i: usize| self.point(TAU * i as f64 / count as f64).0;
        (0..count).map(|i| [at(i), at(i + 1), at(i + 1)]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scatter::{counted, lattice, scatter};

    #[test]
    fn boxes_of_a_turned_lattice_hold_their_parts_of_the_ellipse() {
        for axes in [[2.0, 0.7], [0.2, 1.0], [1.0, 1.0]] {
            let sums = lattice(&Ellipse::new(axes));
            let parts = counted(&Ellipse::new(axes), 40);
            println!("{axes:?}: sums {sums:?}, parts {parts:?}");
            assert!(sums.0 < 1e-13 && sums.1 < 1e-13 && parts.0 < 1e-2 && parts.1 < 1e-2);
        }
    }

    #[test]
    fn planes_and_clearances_are_no_further_than_the_surface() {
        let body = Ellipse::new([2.0, 0.7]);
        for k in 0..2000 {
            let point = Vector3::new(1.5 * scatter(2 * k), scatter(2 * k + 1), 0.0);
            let near = body.nearest(&point);
            let plane = body.plane(&point).unwrap();
            let clearance = body.clearance(&point).unwrap();
            assert!(clearance.abs() <= near.distance.abs() + 1e-15);
            assert!(clearance * near.distance >= 0.0);
            assert!(plane.distance <= near.distance + 1e-15);
            let offset = plane.normal.dot(&point) - plane.distance;
            assert!((offset - body.extent(&plane.normal)).abs() < 1e-12);
        }
    }

    #[test]
    fn nearest_points_lie_on_the_ellipse_with_its_normal() {
        let body = Ellipse::new([2.0, 0.7]);
        let mut worst = 0.0f64;
        for k in 0..2000 {
            let point = Vector3::new(1.5 * scatter(2 * k), scatter(2 * k + 1), 0.0);
            let Nearest { distance, normal } = body.nearest(&point);
            let foot = point - distance * normal;
            let scaled = foot.xy().component_div(&body.half);
            worst = worst.max((scaled.norm() - 1.0).abs());
            // No point of the rim is nearer.
            for i in 0..64 {
                let (place, _) = body.point(TAU * f64::from(i) / 64.0);
                assert!((place - point).norm() > distance.abs() - 1e-12);
            }
            let inside = point.xy().component_div(&body.half).norm() < 1.0;
            assert_eq!(inside, distance < 0.0);
        }
        for point in [Vector3::zeros(), Vector3::x(), 0.35 * Vector3::y(), 0.9 * Vector3::x()] {
            let Nearest { distance, normal } = body.nearest(&point);
            let foot = (point - distance * normal).xy().component_div(&body.half);
            worst = worst.max((foot.norm() - 1.0).abs());
        }
        println!("feet off the ellipse: {worst:.1e}");
        assert!(worst < 1e-12, "{worst:e}");
    }
}
