//! What bodies fill of the grid's cells and cover of its faces, their periodic images included.
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
    /// What.
    pub shape: &'a dyn Shape,
    /// Where its centre is, and how it is turned.
    pub pose: Pose,
}

impl Placed<'_> {
    /// It as it is turned.
    pub fn turned(&self) -> Turned<'_> {
        self.shape.turned(&self.pose.orientation)
    }
}
