//! Shapes of bodies in their own axes: pure geometry, which the case file, the solver and the
//! figures share.
//!
//! ```text
//!        ,-----.        own axes, the centre of volume at the origin
//!      ,'   |   `.      distance and normal   of the nearest point of the surface
//!     |     o--  |      volume, inertia       of unit density
//!      `.       ,'      parts                 convex, for contacts ([`Part`])
//!        `-----'        outline               for figures
//! ```
//! A shape of two dimensions lies in the plane z = 0 and is the section of a cylinder of unit
//! depth. A body's shape is asked in the axes of the box through [`Turned`].
//!
//! # A new shape
//!
//! is one file in `solids` that implements [`Shape`]. Its tools are in `surface` (points and
//! triangles of surfaces, distances from them), `boxes` (parts that it fills of a lattice) and
//! `contact` (parts of bodies, and where they touch).

mod boxes;
mod contact;
#[cfg(test)]
mod scatter;
mod solids;
mod surface;
mod turned;

pub use boxes::Tile;
pub use contact::depths::Touch;
pub use contact::distance::closest;
pub use contact::faces::Mesh;
pub use contact::ground::touch_region;
pub use contact::part::{Core, Edge, Face, Part, Polytope};
pub use contact::pose::{Closest, Pose};
pub use contact::region::{Reach, Region, Regions};
pub use contact::touch::{touch, touch_plane};
pub use solids::clump::Clump;
pub use solids::disc::Disc;
pub use solids::ellipse::Ellipse;
pub use solids::ellipsoid::Ellipsoid;
pub use solids::obstacle::{Extent, Obstacle};
pub use solids::polygon::Polygon;
pub use solids::polyhedron::Polyhedron;
pub use solids::scaled::Scaled;
pub use solids::sphere::Sphere;
pub use solids::superquadric::Superquadric;
pub use surface::stl;
pub use turned::{Turned, meets_ball};

pub use boxes::Lattice;

use nalgebra::{Matrix3, Rotation3, Vector3};
use std::f64::consts::PI;

/// Fault of a shape, in words for the user, without the name of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault(pub String);

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Fault {}

/// The point of a surface that is nearest to another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Signed distance from the surface (m), negative inside.
    pub distance: f64,
    /// Outward normal there, of length 1.
    pub normal: Vector3<f64>,
}

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// From the centre, in the body's own axes (m).
    pub place: Vector3<f64>,
    /// Outward normal there, of length 1.
    pub normal: Vector3<f64>,
    /// Its part of the surface (m2; m per metre of depth in 2D).
    pub area: f64,
}

/// Rotation from a body's own axes to those of the box.
pub type Orientation = Rotation3<f64>;

/// The shape of a rigid body in its own axes, its centre of volume at the origin.
pub trait Shape: std::fmt::Debug + Send + Sync {
    /// 3, or 2 of the section of a cylinder along z, of unit depth.
    fn dimension(&self) -> usize;

    /// Radius of the sphere about the origin that holds all of it (m).
    fn radius(&self) -> f64;

    /// Volume (m3; m2 in 2D).
    fn volume(&self) -> f64;

    /// Moments of inertia about the origin of a body of unit density (m5; m4 in 2D, of which that
    /// about z counts).
    fn inertia(&self) -> Matrix3<f64>;

    /// Moments of inertia of a `mass` (kg) that is spread evenly (kg m2): `sum m (r.r - r r^T)`.
    fn inertia_of(&self, mass: f64) -> Matrix3<f64> {
        mass / self.volume() * self.inertia()
    }

    /// Width of its thinnest part (m): what a grid has to resolve.
    fn thickness(&self) -> f64;

    /// The nearest point of its surface; any of them where there are several.
    fn nearest(&self, point: &Vector3<f64>) -> Nearest;

    /// Signed distance from its surface (m), negative inside.
    fn distance(&self, point: &Vector3<f64>) -> f64 {
        self.nearest(point).distance
    }

    /// A signed distance (m) nearer to zero than that from the surface, of shapes that find one
    /// sooner: what lies further from the surface beyond doubt.
    fn clearance(&self, _point: &Vector3<f64>) -> Option<f64> {
        None
    }

    /// A plane that all of it lies below, and all that [`Shape::tile`] sees of it, of convex shapes
    /// that have one soon: the height of the point above it (m), and its normal.
    fn plane(&self, _point: &Vector3<f64>) -> Option<Nearest> {
        None
    }

    /// Points all over the surface, about `spacing` (m) apart, or closer where it is bent; their
    /// areas sum to the surface's.
    fn surface(&self, spacing: f64) -> Vec<SurfacePoint>;

    /// Area of the surface (m2; m in 2D), and the moments of inertia of the surface (m4; m3), as of
    /// a shell of a kilogram per area. By default those of its points.
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

    /// Extent from the origin in the direction `n`, of length 1 (m): the largest `x.n` of its
    /// points.
    fn extent(&self, n: &Vector3<f64>) -> f64;

    /// Calls with the boxes of a lattice that it reaches, the first axis fastest.
    fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile));

    /// The feet of the perpendiculars from a point inside on faces between sharp edges, up to
    /// `within` (m) away, each face once; nothing of shapes without edges.
    fn feet(&self, _point: &Vector3<f64>, _within: f64, feet: &mut Vec<Nearest>) {
        feet.clear();
    }

    /// Whether cells and faces of the grid with their middle at a point are its own: where it is
    /// one of several that touch, each is that of one of them.
    fn owns(&self, _point: &Vector3<f64>) -> bool {
        true
    }

    /// Distance (m) from a point outside in the direction `along`, of length 1, to the surface;
    /// none beyond `within` (m), 0 from a point inside.
    fn meets(&self, point: &Vector3<f64>, along: &Vector3<f64>, within: f64) -> Option<f64> {
        // Each step goes as far as nothing can be in the way: to a plane that all of it lies below,
        // or by the distance.
        let least = 1e-9 * self.radius();
        let end = within.min(point.norm() + self.radius());
        let mut way = 0.0;
        for _ in 0..200 {
            let place = point + way * along;
            let plane = self.plane(&place).filter(|plane| plane.distance > least);
            let free = plane.map_or_else(
                || self.distance(&place),
                |plane| plane.distance / (-plane.normal.dot(along)).max(0.0),
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

    /// Distance (m) from a point of the surface, along the normal there, to where the ray meets the
    /// body again; none where it does not, as of any convex one.
    fn meets_itself(&self, _foot: &Vector3<f64>, _normal: &Vector3<f64>) -> Option<f64> {
        None
    }

    /// It as an obstacle, which stands in the domain and has its periodic images and its ends at
    /// the sides of the domain in itself, where it is one.
    fn obstacle(&self) -> Option<&Obstacle> {
        None
    }

    /// Whether it is an obstacle.
    fn is_obstacle(&self) -> bool {
        self.obstacle().is_some()
    }

    /// Whether it looks the same however it turns. Its turning then displaces no fluid, and its
    /// axes mean nothing.
    fn is_round(&self) -> bool {
        false
    }

    /// Diameter of the disc or sphere of its volume (m).
    fn diameter(&self) -> f64 {
        match self.dimension() {
            2 => (4.0 / PI * self.volume()).sqrt(),
            _ => (6.0 / PI * self.volume()).cbrt(),
        }
    }

    /// Its convex parts; their union is the solid, as contacts see it.
    fn parts(&self) -> &[Part];

    /// Its surface by triangles, corners counterclockwise seen from outside (m), about `spacing`
    /// (m) wide where it is curved; in 2D the outline by segments, whose third corner repeats the
    /// second.
    fn triangles(&self, spacing: f64) -> Vec<[Vector3<f64>; 3]>;
}

impl dyn Shape + '_ {
    /// It as it is turned by an orientation.
    pub fn turned<'a>(&'a self, orientation: &'a Orientation) -> Turned<'a> {
        Turned { shape: self, orientation }
    }
}
