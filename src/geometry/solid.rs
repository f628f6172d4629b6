//! A solid of `mics-shapes` as the shape of a body.

use super::{Orientation, Shape, SurfacePoint};
use mics_shapes::Geometry;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// A solid of `mics-shapes`.
#[derive(Clone, Debug)]
pub struct Solid(pub Arc<dyn Geometry>);

impl Shape for Solid {
    fn dimension(&self) -> usize {
        self.0.dimension()
    }

    fn radius(&self) -> f64 {
        self.0.radius()
    }

    fn volume(&self) -> f64 {
        self.0.volume()
    }

    fn inertia(&self, mass: f64) -> Matrix3<f64> {
        mass / self.0.volume() * self.0.inertia()
    }

    fn distance(&self, orientation: &Orientation, arm: &Vector3<f64>) -> f64 {
        self.0.nearest(&(orientation.inverse() * arm)).distance
    }

    fn normal(&self, orientation: &Orientation, arm: &Vector3<f64>) -> Vector3<f64> {
        orientation * self.0.nearest(&(orientation.inverse() * arm)).normal
    }

    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let point = |patch: mics_shapes::Patch| SurfacePoint {
            place: patch.place,
            normal: patch.normal,
            area: patch.area,
        };
        self.0.surface(spacing).into_iter().map(point).collect()
    }

    fn triangles(&self, spacing: f64) -> Vec<[Vector3<f64>; 3]> {
        self.0.triangles(spacing)
    }

    fn bounds(&self, orientation: &Orientation) -> Vector3<f64> {
        let own = orientation.inverse();
        Vector3::from_fn(|axis, _| {
            let along = own * Vector3::ith(axis, 1.0);
            self.0.extent(&along).max(self.0.extent(&-along))
        })
    }
}
