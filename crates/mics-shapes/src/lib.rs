//! Shapes of bodies that are not round, in their own axes: pure geometry, which the case file, the
//! solver and the figures share.
//!
//! ```text
//!        ,-----.        own axes, the centre of volume at the origin
//!      ,'   |   `.      distance and normal   of the nearest point of the surface
//!     |     o--  |      volume, inertia       of unit density
//!      `.       ,'      parts                 convex, for contacts ([`Part`])
//!        `-----'        outline               for figures
//! ```
//! A shape of two dimensions lies in the plane z = 0 and is the section of a cylinder of unit
//! depth.

mod ball;
mod balls;
mod beside;
mod clump;
mod convex;
mod depths;
mod distance;
mod ellipse;
mod ellipsoid;
mod facets;
mod flags;
mod flat;
mod foot;
mod ground;
mod lattice;
mod mesh;
mod near;
mod obstacle;
mod outline;
mod part;
mod patches;
mod placed;
mod polygon;
mod polyhedron;
mod polytope;
mod region;
mod rim;
mod rows;
mod scaled;
#[cfg(test)]
mod scatter;
mod simplex;
mod smooth;
pub mod stl;
mod superquadric;
mod support;
mod touch;

pub use clump::Clump;
pub use depths::Touch;
pub use distance::closest;
pub use ellipse::Ellipse;
pub use ellipsoid::Ellipsoid;
pub use mesh::Mesh;
pub use obstacle::{Obstacle, Room};
pub use part::{Core, Edge, Face, Part, Polytope};
pub use placed::{Closest, Pose};
pub use polygon::Polygon;
pub use polyhedron::Polyhedron;
pub use region::{Reach, Region, Regions};
pub use scaled::Scaled;
pub use superquadric::Superquadric;
pub use touch::{touch, touch_plane};

use nalgebra::{Matrix3, Rotation3, Vector3};

/// What is wrong with a shape, in words for the user, without the name of the file.
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

/// A part of a surface about a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// The point, in own axes (m).
    pub place: Vector3<f64>,
    /// Outward normal there, of length 1.
    pub normal: Vector3<f64>,
    /// Area (m2; m per metre of depth in 2D).
    pub area: f64,
}

/// A lattice of boxes, and how a body lies in it, the body's centre at its origin.
#[derive(Clone, Copy, Debug)]
pub struct Lattice<'a> {
    /// How much larger than its geometry the body is.
    pub factor: f64,
    /// What brings the body's own axes into those of the lattice.
    pub turn: Rotation3<f64>,
    /// The planes between the boxes along each axis, ascending (m); two alike along z in 2D.
    pub planes: &'a [Vec<f64>; 3],
}

impl Lattice<'_> {
    /// Where a point of the body's geometry (m) is (m).
    fn place(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.factor * (self.turn * point)
    }

    /// The middle of a box and its half edges in the axes of the body's geometry (m).
    fn own_box(&self, at: [usize; 3]) -> (Vector3<f64>, [Vector3<f64>; 3]) {
        let end = |a: usize, n: usize| self.planes[a][at[a] + n];
        let own = |x: Vector3<f64>| self.turn.inverse_transform_vector(&x) / self.factor;
        let middle = own(Vector3::from_fn(|a, _| 0.5 * (end(a, 0) + end(a, 1))));
        (middle, [0, 1, 2].map(|a| own(Vector3::ith(a, 0.5 * (end(a, 1) - end(a, 0))))))
    }
}

/// What a body fills of a box of a lattice.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    /// Number of the box along each axis.
    pub at: [usize; 3],
    /// Part of its volume.
    pub part: f64,
    /// First moment of that part about the body's centre, along the axes of the lattice, per volume
    /// of the box (m).
    pub moment: Vector3<f64>,
}

/// A solid in its own axes, its centre of volume at the origin.
pub trait Geometry: std::fmt::Debug + Send + Sync {
    /// 2 or 3.
    fn dimension(&self) -> usize;

    /// Radius of the sphere about the origin that holds all of it (m).
    fn radius(&self) -> f64;

    /// Volume (m3; m2 in 2D).
    fn volume(&self) -> f64;

    /// Moments of inertia about the origin of a body of unit density (m5; m4 in 2D, about z).
    fn inertia(&self) -> Matrix3<f64>;

    /// Width of its thinnest part (m): what a grid has to resolve.
    fn thickness(&self) -> f64;

    /// The nearest point of its surface; any of them where there are several.
    fn nearest(&self, point: &Vector3<f64>) -> Nearest;

    /// A signed distance (m) nearer to zero than that from the surface, of shapes that find one
    /// sooner: what lies further from the surface beyond doubt.
    fn clearance(&self, _point: &Vector3<f64>) -> Option<f64> {
        None
    }

    /// A plane that all of it lies below, and all that [`Geometry::tile`] sees of it, of convex
    /// shapes that have one soon: the height of the point above it (m), and its normal.
    fn plane(&self, _point: &Vector3<f64>) -> Option<Nearest> {
        None
    }

    /// Points all over the surface, about `spacing` (m) apart, or closer where it is bent; their
    /// areas sum to the surface's.
    fn surface(&self, spacing: f64) -> Vec<Patch>;

    /// How far it reaches from the origin in the direction `n`, of length 1 (m): the largest `x.n`
    /// of its points.
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

    /// How far a ray from a point of the surface, along the normal there, goes until it meets the
    /// body again (m); none where it does not, as of any convex one.
    fn meets_itself(&self, _foot: &Vector3<f64>, _normal: &Vector3<f64>) -> Option<f64> {
        None
    }

    /// It as an obstacle, which stands in the domain and has its periodic images and its ends at
    /// the sides of the domain in itself, where it is one.
    fn obstacle(&self) -> Option<&Obstacle> {
        None
    }

    /// Its convex parts; their union is the solid, as contacts see it.
    fn parts(&self) -> &[Part];

    /// Its surface by triangles, corners counterclockwise seen from outside (m), about `spacing`
    /// (m) wide where it is curved; in 2D the outline by segments, whose third corner repeats the
    /// second.
    fn triangles(&self, spacing: f64) -> Vec<[Vector3<f64>; 3]>;
}
