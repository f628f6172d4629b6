//! The shapes of bodies behind one seam, [`Shape`]: nothing outside this folder knows what a disc
//! or a sphere is, and nothing but [`Solid`] what others are.
//!
//! ```text
//!        ,-----.            distance s to the surface, negative inside, and the normal n there:
//!                           the surface ([`Shape::distance`])
//!      ,'  own  `.          part of a box that the body fills, and the centroid of it: cells and
//!                           faces ([`Shape::moments`])
//!     |   axes /  |<-- n    volume, moments of inertia: its motion
//!      `.     /  `orientation`
//!                           points with normals and areas: where traction is taken
//!                           ([`Shape::surface`])
//!        `---o------- x
//!          centre
//! ```
//! Places are taken from the body's centre of volume along the axes of the box, and `orientation`
//! brings the body's own axes there: the point `x` of the body's own axes is at `orientation x`. A
//! shape of two dimensions is the section of a cylinder along z, of which a body is a metre.
//!
//! [`fraction`] and [`aperture`] find with a shape what it fills of the grid's cells and covers of
//! its faces.
//!
//! # A new shape
//!
//! that is not round is one file in the crate `mics-shapes`, which [`Solid`] makes a [`Shape`] of.

pub mod aperture;
mod block;
mod circle;
mod disc;
pub mod fraction;
mod octant;
mod planes;
pub(crate) mod round;
mod solid;
mod sphere;
mod tiles;

pub use aperture::{Cut, Cuts, FaceCentroids};
pub use block::{Block, images};
pub use disc::Disc;
pub use fraction::Overlap;
pub use mics_shapes as shapes;
pub use mics_shapes::Nearest;
pub(crate) use planes::Planes;
pub use solid::Solid;
pub use sphere::Sphere;
pub use tiles::{Filled, Tiles};

use nalgebra::{Matrix3, Rotation3, Vector3};
use std::f64::consts::PI;
use std::fmt::Debug;

/// What brings a body's own axes into those of the box.
pub type Orientation = Rotation3<f64>;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// From the centre, in the body's own axes (m).
    pub place: Vector3<f64>,
    /// Outward normal there, of length 1.
    pub normal: Vector3<f64>,
    /// Its part of the surface (m2; m per metre of depth).
    pub area: f64,
}

/// A shape at its place.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a> {
    /// What.
    pub shape: &'a dyn Shape,
    /// Its centre (m).
    pub centre: Vector3<f64>,
    /// How it is turned.
    pub orientation: Orientation,
}

/// The shape of a rigid body, its centre of volume at the origin.
pub trait Shape: Debug + Send + Sync {
    /// 3, or 2 of the section of a cylinder along z, of unit depth.
    fn dimension(&self) -> usize;

    /// Radius of a sphere about the centre that holds all of it (m).
    fn radius(&self) -> f64;

    /// Volume (m3; m2 of a section, per metre of depth).
    fn volume(&self) -> f64;

    /// Moments of inertia about the centre in its own axes (kg m2) for a `mass` (kg), spread
    /// evenly: `sum m (r.r - r r^T)`. Of a section that about z counts.
    fn inertia(&self, mass: f64) -> Matrix3<f64>;

    /// Signed distance of the point at `arm` (m) from the surface (m), negative inside; where
    /// several points of the surface are as near, that to any.
    fn distance(&self, orientation: &Orientation, arm: &Vector3<f64>) -> f64;

    /// Outward normal, of length 1, at the point of the surface nearest to the one at `arm` (m): so
    /// that point is at `arm - distance normal`. At a centre of symmetry any of them.
    fn normal(&self, orientation: &Orientation, arm: &Vector3<f64>) -> Vector3<f64>;

    /// That distance and normal, for shapes that have both at once.
    fn nearest(&self, orientation: &Orientation, arm: &Vector3<f64>) -> (f64, Vector3<f64>) {
        (self.distance(orientation, arm), self.normal(orientation, arm))
    }

    /// A signed distance (m) nearer to zero than that from the surface, of shapes that find one
    /// sooner.
    fn clearance(&self, _orientation: &Orientation, _arm: &Vector3<f64>) -> Option<f64> {
        None
    }

    /// A plane that all of it lies below, of shapes that have one soon: how high the point at `arm`
    /// (m) is above it (m), and its normal, of length 1.
    fn plane(
        &self,
        _orientation: &Orientation,
        _arm: &Vector3<f64>,
    ) -> Option<(f64, Vector3<f64>)> {
        None
    }

    /// The feet of the perpendiculars from a point inside at `arm` (m) on faces between sharp
    /// edges, up to `within` (m) away, as distances and normals; nothing of shapes without edges.
    fn feet(
        &self,
        _orientation: &Orientation,
        _arm: &Vector3<f64>,
        _within: f64,
        feet: &mut Vec<Nearest>,
    ) {
        feet.clear();
    }

    /// Whether cells and faces with their middle at `arm` (m) are its own: where it is one of
    /// several obstacles that touch, each is that of one of them.
    fn owns(&self, _orientation: &Orientation, _arm: &Vector3<f64>) -> bool {
        true
    }

    /// Points all over the surface, about `spacing` (m) apart, or closer where it is bent; their
    /// areas sum to the surface's.
    fn surface(&self, spacing: f64) -> Vec<SurfacePoint>;

    /// Whether it looks the same however it turns. Its turning then displaces no fluid, and its
    /// axes mean nothing.
    fn is_round(&self) -> bool {
        false
    }

    /// Diameter of the disc or sphere of its volume (m).
    fn diameter(&self) -> f64 {
        match self.dimension() {
            _ if self.is_round() => 2.0 * self.radius(),
            2 => (4.0 / PI * self.volume()).sqrt(),
            _ => (6.0 / PI * self.volume()).cbrt(),
        }
    }

    /// Area of the surface (m2; m in 2D), and the moments of inertia of the surface in the body's
    /// own axes (m4; m3), as of a shell of a kilogram per area. By default those of its points.
    fn surface_moments(&self) -> (f64, Matrix3<f64>) {
        let mut area = 0.0;
        let mut inertia = Matrix3::zeros();
        for point in self.surface(0.1 * self.radius()) {
            let r = point.place;
            area += point.area;
            inertia +=
                point.area * (Matrix3::from_diagonal_element(r.norm_squared()) - r * r.transpose());
        }
        (area, inertia)
    }

    /// Half edges of the box along the axes that holds all of it (m).
    fn bounds(&self, _turn: &Orientation) -> Vector3<f64> {
        Vector3::repeat(self.radius())
    }

    /// Volume (m3; m2 in 2D) that it fills of the box with its centre at `middle` (m) and the half
    /// edges `half` (m; zero along z in 2D), and the integrals of the coordinates over that (m4;
    /// m3); none of bodies that only contacts see.
    fn moments(
        &self,
        _orientation: &Orientation,
        _middle: &Vector3<f64>,
        _half: &Vector3<f64>,
    ) -> (f64, Vector3<f64>) {
        (0.0, Vector3::zeros())
    }

    /// The parts of the boxes of a lattice that it fills, in the order of their numbers, the first
    /// axis fastest; with `faces`, the axis of those in whose middles they lie, their first moments
    /// and levers as well.
    ///
    /// Where a turning body carries fluid through a face of the grid, its flux through that is
    /// `(spin x lever).n` per area of the face, with the first moment of the box about it as lever,
    /// or, of round bodies, that of the section in the face's own plane.
    fn tile(
        &self,
        _orientation: &Orientation,
        _tiles: &mut Tiles,
        _faces: Option<usize>,
        _found: &mut dyn FnMut(&Filled),
    ) {
    }

    /// How far it is along the `normal` of its own surface, from the point at `foot` (m) of it, to
    /// where that meets the body again (m); `None` of a convex one.
    fn meets_itself(
        &self,
        _orientation: &Orientation,
        _foot: &Vector3<f64>,
        _normal: &Vector3<f64>,
    ) -> Option<f64> {
        None
    }

    /// Its convex parts, as contacts see them; none of a round body, which is its own.
    fn parts(&self) -> &[shapes::Part] {
        &[]
    }

    /// Whether it stands in the domain, its periodic images and its ends at the sides of the
    /// domain in itself.
    fn is_obstacle(&self) -> bool {
        self.obstacle().is_some()
    }

    /// It as an obstacle, where it is one.
    fn obstacle(&self) -> Option<&shapes::Obstacle> {
        None
    }

    /// Area of a polygon in place of [`Shape::moments`], after Ushijima et al. 2003, of shapes that
    /// have one.
    fn polygon(&self, _middle: &Vector3<f64>, _half: &Vector3<f64>) -> Option<f64> {
        None
    }

    /// Its surface by triangles in its own axes (m), about `spacing` (m) wide where it is curved;
    /// in 2D its outline by segments, whose third corner repeats the second. None of a round body.
    fn triangles(&self, _spacing: f64) -> Vec<[Vector3<f64>; 3]> {
        Vec::new()
    }

    /// How far it is to the surface (m) from a point outside, with the centre `apart` from it (m),
    /// in the direction `along`, of length 1; `None` where it is missed, 0 from a point inside.
    fn meets(
        &self,
        orientation: &Orientation,
        apart: &Vector3<f64>,
        along: &Vector3<f64>,
    ) -> Option<f64> {
        // Each step goes as far as nothing can be in the way: to a plane that all of it lies below,
        // or by the distance.
        let least = 1e-9 * self.radius();
        let end = apart.norm() + self.radius();
        let mut way = 0.0;
        for _ in 0..200 {
            let arm = way * along - apart;
            let plane = self.plane(orientation, &arm).filter(|(height, _)| *height > least);
            let free = plane.map_or_else(
                || self.distance(orientation, &arm),
                |(height, normal)| height / (-normal.dot(along)).max(0.0),
            );
            if free < least {
                return Some(way);
            }
            way += free;
            if way > end {
                return None;
            }
        }
        // It grazes the surface.
        None
    }
}
