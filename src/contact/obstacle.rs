//! Contacts of bodies with obstacles: with each region of one ([`mics_shapes::Regions`]) a contact
//! as with a plane wall, which has no mass.
//!
//! ```text
//!    ( o )  ( o )      its spring belongs to the pair of a part and a region; from one step to
//!   --+---+----+---    the next it is known by the face that holds the contact: the region that
//!       faces          has it then goes on with the spring
//! ```

use super::body::Form;
use super::pair::crossed;
use super::pairs::Found;
use crate::geometry::Orientation;
use crate::particles::{Body, nearest_image};
use mics_shapes::{Obstacle, Part, Pose, Reach, Regions};
use nalgebra::Vector3;

/// What `take` makes of a part of a body, of a round one itself.
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

/// Adds the pairs of the parts of a body with the regions of an obstacle within reach. The image of
/// the obstacle is the nearest one, as it has its images in itself.
pub(super) fn add_pairs(found: &mut Found, o: usize, reach: Reach, regions: &mut Regions) {
    let Found { setup, states, bodies, first: i, .. } = *found;
    let body = &bodies[i];
    let wall = &bodies[o];
    let periods = &setup.periods;
    let Some(faces) = wall.shape().obstacle().map(Obstacle::faces) else { return };
    let apart = nearest_image(&body.centre, &wall.centre, periods);
    let further = apart - (wall.centre - body.centre);
    let image = Vector3::from_fn(|a, _| periods[a].map_or(0.0, |l| (further[a] / l).round()));
    let image = image - crossed(bodies, i, o, periods);
    let orientation = body.orientation();
    let turns = states[i].form != Form::Round;
    let own = seen(&apart, turns.then_some(&orientation), &wall.orientation());
    for k in 0..body.parts().len().max(1) {
        with_part(body, k, |part| {
            for region in regions.find(faces, part, &own, reach) {
                found.add_region(o, image, k, region, regions.get(region));
            }
        });
    }
}
