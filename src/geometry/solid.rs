//! Bodies that are not round: a shape of the crate `mics-shapes` behind [`Shape`].

use super::tiles::{Filled, Tiles};
use super::{Orientation, Planes, Shape, SurfacePoint};
use mics_shapes::{Geometry, Nearest, Obstacle, Part};
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

    /// The half edges of a box (m) in its own axes.
    fn own_edges(orientation: &Orientation, half: &Vector3<f64>) -> [Vector3<f64>; 3] {
        // The rows of the rotation are the axes of the box.
        let axes = orientation.matrix();
        [0, 1, 2].map(|a| half[a] * axes.row(a).transpose())
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
        let edges = Solid::own_edges(orientation, half);
        let own = orientation.inverse_transform_vector(middle);
        let (volume, first) = self.0.filled(&own, &edges);
        (volume, orientation * first)
    }

    /// All together, or row by row: a box far from the surface says that of those after it.
    fn tile(
        &self,
        orientation: &Orientation,
        tiles: &mut Tiles,
        faces: Option<usize>,
        found: &mut dyn FnMut(&Filled),
    ) {
        let together = self.0.tile(1.0, orientation, &tiles.planes, &mut |tile| {
            let mut one = Tiles::empty(&tiles.planes, tile.at);
            (one.part, one.moment, one.lever) = (tile.part, tile.moment, tile.moment);
            found(&one);
        });
        if together {
            return;
        }
        let edges = |half: &Vector3<f64>| Solid::own_edges(orientation, half);
        // How far along the row what was found last holds, and what that is.
        let (mut known, mut inside) = (f64::NEG_INFINITY, false);
        let (dimension, mut row, mut planes) = (self.dimension(), None, Planes::default());
        let joined = self.0.obstacle().is_some_and(Obstacle::is_joined);
        for mut one in tiles.boxes() {
            if row != Some([one.at[1], one.at[2]]) {
                (row, known) = (Some([one.at[1], one.at[2]]), f64::NEG_INFINITY);
            }
            let mut own = None;
            if one.middle.x > known {
                if planes.clears(self, orientation, &one.middle, &one.half, 0.0) {
                    continue;
                }
                let middle = orientation.inverse_transform_vector(&one.middle);
                let near = || self.0.nearest(&middle).distance;
                let distance = self.0.clearance(&middle).unwrap_or_else(near);
                let free = distance.abs() - one.half.norm();
                if free >= 0.0 {
                    (known, inside) = (one.middle.x + free, distance < 0.0);
                } else {
                    own = Some(middle);
                }
            }
            if joined && !self.0.owns(&orientation.inverse_transform_vector(&one.middle)) {
                continue;
            }
            if let Some(own) = own {
                let whole: f64 = (0..dimension).map(|a| 2.0 * one.half[a]).product();
                let (filled, first) = self.0.filled(&own, &edges(&one.half));
                one.part = filled / whole;
                if faces.is_some() {
                    one.moment = orientation * (first / whole);
                }
            } else if inside {
                (one.part, one.moment) = (1.0, one.middle);
            } else {
                continue;
            }
            one.lever = one.moment;
            found(&one);
        }
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
