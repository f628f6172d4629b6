//! Solid fractions: bodies' parts of the grid's cells and of its faces, periodic images included.
//!
//! ```text
//!        ,-----.            part of a box that the body fills, and the centroid of it: cells
//!     ,'        `.          ([`fraction`]) and faces ([`aperture`]), by the lattice of boxes about
//!     |     o    |          its centre ([`mics_shapes::Shape::tile`])
//!      `.______,'
//! ```
//! The shapes themselves are those of the crate `mics-shapes`.

pub mod aperture;
mod block;
pub mod fraction;
mod planes;

pub use aperture::{Cut, Cuts, FaceCentroids};
pub use block::{Block, images};
pub use fraction::Overlap;
pub use mics_shapes as shapes;
pub use mics_shapes::{Disc, Nearest, Orientation, Pose, Shape, Sphere, SurfacePoint, Turned};
pub(crate) use planes::Planes;

/// A shape at its place.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a> {
    /// The shape.
    pub shape: &'a dyn Shape,
    /// Its centre (m) and its orientation.
    pub pose: Pose,
}

impl Placed<'_> {
    /// The shape in its orientation.
    pub fn turned(&self) -> Turned<'_> {
        self.shape.turned(&self.pose.orientation)
    }
}
