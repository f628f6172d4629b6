//! A sphere; what it fills of boxes in closed form ([`super::octant`]).

use super::tiles::{Filled, Tiles};
use super::{Orientation, Shape, SurfacePoint, octant, round};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// A sphere (3D).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Radius (m).
    pub radius: f64,
}

impl Shape for Sphere {
    fn dimension(&self) -> usize {
        3
    }

    fn is_round(&self) -> bool {
        true
    }

    fn radius(&self) -> f64 {
        self.radius
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.radius.powi(3)
    }

    fn inertia(&self, mass: f64) -> Matrix3<f64> {
        Matrix3::from_diagonal_element(0.4 * mass * self.radius.powi(2))
    }

    fn distance(&self, _: &Orientation, arm: &Vector3<f64>) -> f64 {
        arm.norm() - self.radius
    }

    fn normal(&self, _: &Orientation, arm: &Vector3<f64>) -> Vector3<f64> {
        arm.normalize()
    }

    /// In the middles of equal angles on the faces of a cube, with the areas that these see: as
    /// symmetric as the grid.
    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let n = ((4.0 * PI / 3.0).sqrt() * self.radius / spacing).ceil() as usize;
        let slope = |i: f64| (FRAC_PI_2 * (i / n as f64 - 0.5)).tan();
        // What the origin sees of a rectangle on the face, from its middle to here.
        let seen = |x: f64, y: f64| (x * y / (1.0 + x * x + y * y).sqrt()).atan();
        let point = |k: usize| {
            let face = k / (n * n);
            let i = (k % n) as f64;
            let j = (k / n % n) as f64;
            let [x0, x1] = [slope(i), slope(i + 1.0)];
            let [y0, y1] = [slope(j), slope(j + 1.0)];
            let angle = seen(x1, y1) - seen(x0, y1) - seen(x1, y0) + seen(x0, y0);
            let mut place = Vector3::zeros();
            place[face % 3] = if face < 3 { 1.0 } else { -1.0 };
            place[(face + 1) % 3] = slope(i + 0.5);
            place[(face + 2) % 3] = slope(j + 0.5);
            round::surface_point(
                self.radius * place.normalize(),
                self.radius,
                self.radius * self.radius * angle,
            )
        };
        (0..6 * n * n).map(point).collect()
    }

    fn surface_moments(&self) -> (f64, Matrix3<f64>) {
        let area = 4.0 * PI * self.radius * self.radius;
        (area, Matrix3::from_diagonal_element(8.0 / 3.0 * PI * self.radius.powi(4)))
    }

    fn moments(
        &self,
        _: &Orientation,
        middle: &Vector3<f64>,
        half: &Vector3<f64>,
    ) -> (f64, Vector3<f64>) {
        let filled = octant::of_box(&(middle - half), &(middle + half), self.radius);
        (filled.volume, filled.moment)
    }

    fn tile(
        &self,
        _: &Orientation,
        tiles: &mut Tiles,
        faces: Option<usize>,
        found: &mut dyn FnMut(&Filled),
    ) {
        tiles.of_sphere(self.radius, faces, found);
    }

    fn meets(&self, _: &Orientation, apart: &Vector3<f64>, along: &Vector3<f64>) -> Option<f64> {
        round::meets(apart, along, self.radius)
    }
}
