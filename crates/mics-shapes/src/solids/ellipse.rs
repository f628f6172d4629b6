//! An ellipse: the section of an elliptic cylinder along z, of unit depth.

use crate::boxes::rim;
use crate::surface::ellipsoid::{nearest, skin};
use crate::{Core, Lattice, Nearest, Part, Shape, SurfacePoint, Tile};
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

impl Shape for Ellipse {
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

    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let count = self.count(spacing);
        let patch = |i: usize| {
            let (place, across) = self.point(TAU * ((i as f64 + 0.5) / count as f64));
            let area = TAU / count as f64 * across.norm();
            SurfacePoint { place, normal: across.normalize(), area }
        };
        (0..count).map(patch).collect()
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        (self.half.x * n.x).hypot(self.half.y * n.y)
    }

    fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        let axes = lattice.orientation.matrix().fixed_view::<2, 2>(0, 0);
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

    #[test]
    fn ellipse_of_equal_axes_has_moment_of_inertia_of_disc() {
        let exact = 0.5 * std::f64::consts::PI * 0.3f64.powi(4);
        let round = crate::Disc { radius: 0.3 };
        let equal = Ellipse::new([0.6; 2]);
        for inertia in [round.inertia(), equal.inertia()] {
            assert!((inertia[(2, 2)] / exact - 1.0).abs() < 1e-14, "{inertia} {exact}");
        }
    }
}
