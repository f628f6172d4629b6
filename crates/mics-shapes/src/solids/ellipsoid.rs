//! An ellipsoid.

use crate::boxes::stretched;
use crate::surface::ellipsoid::{nearest, skin};
use crate::surface::patches;
use crate::{Core, Lattice, Nearest, Part, Shape, SurfacePoint, Tile};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// An ellipsoid (3D).
#[derive(Clone, Debug)]
pub struct Ellipsoid {
    half: Vector3<f64>,
    /// Area of its surface (m2).
    area: f64,
    parts: [Part; 1],
}

impl Ellipsoid {
    /// With these axes along x, y and z (m), whole lengths, all positive.
    pub fn new(axes: [f64; 3]) -> Ellipsoid {
        let half = 0.5 * Vector3::from(axes);
        let least = half.min();
        let largest = half.max();
        let inset = skin(least, least * least / largest);
        let core = Core::Ellipsoid { half, inset };
        let part = Part { place: Vector3::zeros(), core, rounding: inset, radius: largest };
        let mut body = Ellipsoid { half, area: 1.0, parts: [part] };
        body.area = patches::directions(48)
            .map(|(direction, angle)| body.patch(direction, angle).area)
            .sum();
        body
    }

    /// That over a direction and a solid angle of the sphere of which it is a stretched one.
    fn patch(&self, direction: Vector3<f64>, angle: f64) -> SurfacePoint {
        let slope = direction.component_div(&self.half);
        let place = direction.component_mul(&self.half);
        let length = slope.norm();
        SurfacePoint { place, normal: slope / length, area: self.half.product() * length * angle }
    }
}

impl Shape for Ellipsoid {
    fn dimension(&self) -> usize {
        3
    }

    fn radius(&self) -> f64 {
        self.half.max()
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.half.product()
    }

    fn inertia(&self) -> Matrix3<f64> {
        let square = 0.2 * self.volume() * self.half.component_mul(&self.half);
        Matrix3::from_diagonal(&square.map(|x| square.sum() - x))
    }

    fn thickness(&self) -> f64 {
        2.0 * self.half.min()
    }

    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let (foot, normal) = nearest(self.half.into(), (*point).into());
        let normal = Vector3::from(normal);
        Nearest { distance: (point - Vector3::from(foot)).dot(&normal), normal }
    }

    /// A point stretched with the ellipsoid to a ball moves no faster than by the least half axis.
    fn clearance(&self, point: &Vector3<f64>) -> Option<f64> {
        Some((point.component_div(&self.half).norm() - 1.0) * self.half.min())
    }

    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let n = patches::divisions(self.half.max(), spacing);
        let mut all: Vec<SurfacePoint> =
            patches::directions(n).map(|(direction, angle)| self.patch(direction, angle)).collect();
        let factor = self.area / all.iter().map(|patch| patch.area).sum::<f64>();
        all.iter_mut().for_each(|patch| patch.area *= factor);
        all
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        self.half.component_mul(n).norm()
    }

    fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        stretched::tile(&(lattice.factor * self.half), lattice, found);
    }

    fn parts(&self) -> &[Part] {
        &self.parts
    }

    fn triangles(&self, spacing: f64) -> Vec<[Vector3<f64>; 3]> {
        let n = patches::divisions(self.half.max(), spacing);
        let place = |n: Vector3<f64>| n.component_mul(&self.half);
        patches::triangles(n).map(|corners| corners.map(place)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scatter::{counted, lattice, scatter};

    #[test]
    fn boxes_of_a_turned_lattice_hold_their_parts_of_the_ellipsoid() {
        for axes in [[1.0, 0.8, 0.45], [1.0, 1.0, 1.0], [0.2, 1.0, 0.2]] {
            let body = Ellipsoid::new(axes);
            let sums = lattice(&body);
            let parts = counted(&body, 16);
            println!("{axes:?}: sums {sums:?}, parts {parts:?}");
            assert!(sums.0 < 1e-13 && sums.1 < 1e-13 && parts.0 < 1e-2 && parts.1 < 1e-2);
        }
    }

    #[test]
    fn nearest_points_and_surface_of_an_ellipsoid() {
        let body = Ellipsoid::new([2.0, 1.2, 0.7]);
        let mut worst = 0.0f64;
        for k in 0..1000 {
            let point = Vector3::from_fn(|a, _| 1.5 * scatter(3 * k + a));
            let Nearest { distance, normal } = body.nearest(&point);
            let foot = (point - distance * normal).component_div(&body.half);
            worst = worst.max((foot.norm() - 1.0).abs());
            for (n, _) in patches::directions(3) {
                let place = n.component_mul(&body.half);
                assert!((place - point).norm() > distance.abs() - 1e-12);
            }
            assert_eq!(point.component_div(&body.half).norm() < 1.0, distance < 0.0);
            let clearance = body.clearance(&point).unwrap_or(f64::NAN);
            assert!(clearance * distance >= 0.0 && clearance.abs() <= distance.abs() + 1e-12);
        }
        println!("feet off the ellipsoid: {worst:.1e}");
        assert!(worst < 1e-12, "{worst:e}");
        // Area of a prolate spheroid of the eccentricity e: 2 pi b^2 (1 + a/b asin(e)/e).
        let a = 1.0;
        let b = 0.5;
        let e = (1.0f64 - 0.25).sqrt();
        let exact = 2.0 * PI * b * b * (1.0 + a / b * e.asin() / e);
        let area: f64 = Ellipsoid::new([2.0, 1.0, 1.0]).surface(0.1).iter().map(|p| p.area).sum();
        println!("area: {:.1e} off", area / exact - 1.0);
        assert!((area / exact - 1.0).abs() < 2e-4);
    }

    #[test]
    fn ellipsoid_of_equal_axes_has_moment_of_inertia_of_sphere() {
        let exact = 8.0 / 15.0 * std::f64::consts::PI * 0.3f64.powi(5);
        let round = crate::Sphere { radius: 0.3 };
        let equal = Ellipsoid::new([0.6; 3]);
        for inertia in [round.inertia(), equal.inertia()] {
            assert!((inertia[(2, 2)] / exact - 1.0).abs() < 1e-14, "{inertia} {exact}");
        }
    }
}
