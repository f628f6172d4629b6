//! Contacts of bodies with obstacles: with each region of one ([`mics_shapes::Regions`]) a contact
//! as with a plane wall, which has no mass.
//!
//! ```text
//!    ( o )  ( o )      its spring belongs to the pair of a part and a region; from one step to
//!   --+---+----+---    the next it is known by the face that holds the contact: the region that
//!       faces          has it then goes on with the spring
//! ```

use crate::geometry::Orientation;
use crate::particles::Body;
use mics_shapes::{Part, Pose};
use nalgebra::Vector3;

/// Result of `take` for a part of a body, or for a round body itself.
pub(super) fn with_part<T>(body: &Body, part: usize, take: impl FnOnce(&Part) -> T) -> T {
    match body.parts().get(part) {
        Some(part) => take(part),
        None => take(&Part::ball(Vector3::zeros(), body.radius())),
    }
}

/// The pose of a body as seen from an obstacle, whose centre is `apart` from its own (m), and how
/// both are turned: it does not matter how a round one is.
pub(super) fn seen(apart: &Vector3<f64>, own: Option<&Orientation>, its: &Orientation) -> Pose {
    let back = its.inverse();
    let orientation = own.map_or_else(Orientation::identity, |own| back * own);
    Pose { place: -(back * apart), orientation }
}
