//! Bodies that are not round: a shape of the crate `mics-shapes` behind [`Shape`].

use super::tiles::{Filled, Tiles};
use super::{Orientation, Shape, SurfacePoint};
use mics_shapes::{Geometry, Lattice, Nearest, Obstacle, Part};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// A shape that many bodies may share.
#[derive(Clone, Debug)]
pub struct Solid(pub Arc<dyn Geometry>);

impl Solid {
    /// Of a shape that no other body has yet.
    pub fn new(shape: impl Geometry + 'static) -> Solid {
        Solid(Arc::new(shape))
    }
}

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
        self.0.nearest(&orientation.inverse_transform_vector(arm)).distance
    }

    fn normal(&self, orientation: &Orientation, arm: &Vector3<f64>) -> Vector3<f64> {
        orientation * self.0.nearest(&orientation.inverse_transform_vector(arm)).normal
    }

    fn nearest(&self, orientation: &Orientation, arm: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let near = self.0.nearest(&orientation.inverse_transform_vector(arm));
        (near.distance, orientation * near.normal)
    }

    fn clearance(&self, orientation: &Orientation, arm: &Vector3<f64>) -> Option<f64> {
        self.0.clearance(&orientation.inverse_transform_vector(arm))
    }

    fn plane(&self, orientation: &Orientation, arm: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let Nearest { distance, normal } =
            self.0.plane(&orientation.inverse_transform_vector(arm))?;
        Some((distance, orientation * normal))
    }

    fn feet(
        &self,
        orientation: &Orientation,
        arm: &Vector3<f64>,
        within: f64,
        feet: &mut Vec<Nearest>,
    ) {
        self.0.feet(&orientation.inverse_transform_vector(arm), within, feet);
        feet.iter_mut().for_each(|foot| foot.normal = orientation * foot.normal);
    }

    fn owns(&self, orientation: &Orientation, arm: &Vector3<f64>) -> bool {
        self.0.owns(&orientation.inverse_transform_vector(arm))
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
        let axes = orientation.matrix();
        Vector3::from_fn(|a, _| {
            if a >= self.dimension() {
                return 0.0;
            }
            let n = axes.row(a).transpose();
            self.0.extent(&n).max(self.0.extent(&-n))
        })
    }

    fn moments(
        &self,
        orientation: &Orientation,
        middle: &Vector3<f64>,
        half: &Vector3<f64>,
    ) -> (f64, Vector3<f64>) {
        let ends = |a: usize| vec![middle[a] - half[a], middle[a] + half[a]];
        let whole = (0..self.dimension()).map(|a| 2.0 * half[a]).product::<f64>();
        let mut filled = (0.0, Vector3::zeros());
        let lattice = Lattice { factor: 1.0, turn: *orientation, planes: &[0, 1, 2].map(ends) };
        self.0.tile(&lattice, &mut |tile| filled = (whole * tile.part, whole * tile.moment));
        filled
    }

    fn tile(
        &self,
        orientation: &Orientation,
        tiles: &mut Tiles,
        _: Option<usize>,
        found: &mut dyn FnMut(&Filled),
    ) {
        let planes = &tiles.planes;
        self.0.tile(&Lattice { factor: 1.0, turn: *orientation, planes }, &mut |tile| {
            let mut one = Tiles::empty(planes, tile.at);
            (one.part, one.moment, one.lever) = (tile.part, tile.moment, tile.moment);
            found(&one);
        });
    }

    fn meets_itself(
        &self,
        orientation: &Orientation,
        foot: &Vector3<f64>,
        normal: &Vector3<f64>,
    ) -> Option<f64> {
        let own = |x: &Vector3<f64>| orientation.inverse_transform_vector(x);
        self.0.meets_itself(&own(foot), &own(normal))
    }

    fn obstacle(&self) -> Option<&Obstacle> {
        self.0.obstacle()
    }

    fn parts(&self) -> &[Part] {
        self.0.parts()
    }
}
