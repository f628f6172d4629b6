//! Contacts of bodies with obstacles: with each region of one ([`mics_shapes::Regions`]) a contact
//! as with a plane wall, which has no mass.
//!
//! ```text
//!    ( o )  ( o )      its spring belongs to the pair of a part and a region; from one step to
//!   --+---+----+---    the next it is known by the face that holds the contact: the region that
//!       faces          has it then goes on with the spring
//! ```

use super::Contacts;
use super::meeting::Meeting;
use super::pair::Pair;
use crate::particles::{Body, nearest_image};
use mics_shapes::{Mesh, Obstacle, Part, Pose, Region, Regions};
use nalgebra::Vector3;

/// A region that was found.
pub(super) struct Found<'a> {
    pub(super) faces: &'a Mesh,
    pub(super) found: &'a Region,
    /// Its number.
    pub(super) number: usize,
}

/// A body as an obstacle, where it is one.
fn obstacle(body: &Body) -> Option<&Obstacle> {
    if body.is_round() { None } else { body.shape().obstacle() }
}

/// Whether a body is an obstacle.
pub(super) fn is_obstacle(body: &Body) -> bool {
    obstacle(body).is_some()
}

/// A part of a body, of a round one itself.
fn part_of(body: &Body, part: usize, take: impl FnOnce(&Part)) {
    match body.parts().get(part) {
        Some(part) => take(part),
        None => take(&Part::ball(Vector3::zeros(), body.radius())),
    }
}

/// A pose as seen from another one.
fn from(pose: &Pose, other: &Pose, periods: &[Option<f64>; 3]) -> Pose {
    let back = other.orientation.inverse();
    Pose {
        place: back * nearest_image(&other.place, &pose.place, periods),
        orientation: back * pose.orientation,
    }
}

fn pose(body: &Body) -> Pose {
    Pose { place: body.centre, orientation: body.orientation() }
}

/// Calls `take` with the parts of a body, the face and the region of an obstacle in reach of each
/// other.
pub(super) fn regions_near(
    body: &Body,
    wall: &Body,
    periods: &[Option<f64>; 3],
    reach: f64,
    regions: &mut Regions,
    mut take: impl FnMut(usize, usize, Found<'_>),
) {
    let Some(faces) = obstacle(wall).map(Obstacle::faces) else { return };
    let own = from(&pose(body), &pose(wall), periods);
    for k in 0..body.parts().len().max(1) {
        part_of(body, k, |part| {
            for number in faces.regions(part, &own, reach, regions) {
                let found = regions.get(number);
                take(k, faces.nearest_of(found), Found { faces, found, number });
            }
        });
    }
}

impl Contacts {
    /// The second of a pair, where it is a body and no obstacle, which is a wall to contacts.
    pub(super) fn other<'a>(&self, pair: &Pair, bodies: &'a [Body]) -> Option<&'a Body> {
        bodies.get(pair.second).filter(|other| !is_obstacle(other))
    }

    /// Whether both of a pair are round, as walls are.
    pub(super) fn are_round(&self, pair: &Pair, bodies: &[Body]) -> bool {
        bodies[pair.first].is_round() && self.other(pair, bodies).is_none_or(Body::is_round)
    }

    /// Where a pair touches in the middle of a substep `h` (s) of which the second is an obstacle.
    pub(super) fn touch_of_obstacle(
        &self,
        pair: &Pair,
        bodies: &[Body],
        wall: &Obstacle,
        h: f64,
    ) -> Meeting {
        let (body, other) = (&bodies[pair.first], &bodies[pair.second]);
        let (pose, its) = (self.pose(pair.first, bodies, h), self.pose(pair.second, bodies, h));
        let own = from(&pose, &its, &self.periods);
        let power = self.law(pair).material.exponent + 1.0;
        let region = self.regions.get(pair.region);
        let touch = |part: &Part| wall.faces().touch(region, part, &own, power);
        let mut touch = match body.parts().get(pair.parts[0]) {
            Some(part) => touch(part),
            None => touch(&Part::ball(Vector3::zeros(), body.radius())),
        };
        // From the centre of the obstacle, along the axes of the box.
        let arm = its.orientation * touch.place;
        touch.normal = its.orientation * touch.normal;
        let arms = [arm - its.orientation * own.place, arm];
        let turning = body.spin.cross(&arms[0]) - other.spin.cross(&arm);
        Meeting::of(&touch, arms, body.velocity - other.velocity, turning)
    }

    /// Finds for the contacts with obstacles that last which faces hold them now.
    pub(super) fn find_faces(&mut self, bodies: &[Body]) {
        if self.obstacles.is_empty() {
            return;
        }
        for p in 0..self.pairs.len() {
            let pair = &self.pairs[p];
            let lasts = pair.spring.is_some() && pair.region != Pair::NO_REGION;
            let wall = bodies.get(pair.second).and_then(obstacle).filter(|_| lasts);
            let Some(wall) = wall else { continue };
            let place = self.closest(pair, bodies, 0.0).arms[1];
            let own = bodies[pair.second].orientation().inverse_transform_vector(&place);
            let region = self.regions.get(pair.region);
            self.pairs[p].parts[1] = wall.faces().face_at(region, &own);
        }
    }
}
