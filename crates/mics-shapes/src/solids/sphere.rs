//! A sphere; what it fills of boxes in closed form ([`crate::boxes::octant`]).

use crate::boxes::round;
use crate::surface::patches;
use crate::{Lattice, Nearest, Part, Shape, SurfacePoint, Tile};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

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

    fn inertia(&self) -> Matrix3<f64> {
        self.inertia_of(self.volume())
    }

    fn inertia_of(&self, mass: f64) -> Matrix3<f64> {
        Matrix3::from_diagonal_element(0.4 * mass * self.radius.powi(2))
    }

    fn diameter(&self) -> f64 {
        2.0 * self.radius
    }

    fn thickness(&self) -> f64 {
        2.0 * self.radius
    }

    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        Nearest { distance: self.distance(point), normal: point.normalize() }
    }

    fn distance(&self, point: &Vector3<f64>) -> f64 {
        point.norm() - self.radius
    }

    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let point = |(normal, angle): (Vector3<f64>, f64)| {
            let place = self.radius * normal;
            let area = self.radius * self.radius * angle;
            SurfacePoint { place, normal: place / self.radius, area }
        };
        patches::directions(patches::divisions(self.radius, spacing)).map(point).collect()
    }

    fn surface_moments(&self) -> (f64, Matrix3<f64>) {
        let area = 4.0 * PI * self.radius * self.radius;
        (area, Matrix3::from_diagonal_element(8.0 / 3.0 * PI * self.radius.powi(4)))
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        self.radius * n.norm()
    }

    fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        round::tile_sphere(self.radius, lattice, found);
    }

    /// None: contacts see it as it is.
    fn parts(&self) -> &[Part] {
        &[]
    }

    fn triangles(&self, spacing: f64) -> Vec<[Vector3<f64>; 3]> {
        let larger = |corners: [Vector3<f64>; 3]| corners.map(|corner| self.radius * corner);
        patches::triangles(patches::divisions(self.radius, spacing)).map(larger).collect()
    }
}
