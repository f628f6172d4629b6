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
use super::pair::{Pair, crossed};
use crate::geometry::Orientation;
use crate::particles::{Body, nearest_image};
use mics_shapes::{Obstacle, Part, Pose, Reach, Regions};
use nalgebra::Vector3;

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

/// The pose of a body as seen from an obstacle, whose centre is `apart` from its own (m), and how
/// both are turned.
fn seen(body: &Body, apart: &Vector3<f64>, own: &Orientation, its: &Orientation) -> Pose {
    let back = its.inverse();
    let orientation = if body.is_round() { Orientation::identity() } else { back * own };
    Pose { place: -(back * apart), orientation }
}

/// Adds the pairs of the parts of a body with the regions of an obstacle within reach, which go on
/// with those `before`; whether there are any. The image of the obstacle is the nearest one,
/// as it has its images in itself.
pub(super) fn add_pairs(
    [i, o]: [usize; 2],
    bodies: &[Body],
    periods: &[Option<f64>; 3],
    reach: Reach,
    (before, pairs, regions): (&[Pair], &mut Vec<Pair>, &mut Regions),
) -> bool {
    let body = &bodies[i];
    let wall = &bodies[o];
    let begin = pairs.len();
    let Some(faces) = obstacle(wall).map(Obstacle::faces) else { return false };
    let apart = nearest_image(&body.centre, &wall.centre, periods);
    let further = apart - (wall.centre - body.centre);
    let image = Vector3::from_fn(|a, _| periods[a].map_or(0.0, |l| (further[a] / l).round()));
    let image = image - crossed(bodies, i, o, periods);
    let own = seen(body, &apart, &body.orientation(), &wall.orientation());
    for k in 0..body.parts().len().max(1) {
        part_of(body, k, |part| {
            for region in faces.regions(part, &own, reach, regions) {
                let found = regions.get(region);
                let same =
                    |p: &&Pair| p.second == o && p.parts[0] == k && faces.has(found, p.parts[1]);
                let new = || Pair { parts: [k, faces.nearest_of(found)], ..Pair::new(i, o, image) };
                let pair = before.iter().find(same).copied().unwrap_or_else(new);
                pairs.push(Pair { clear: 0.0, region, image, ..pair });
            }
        });
    }
    pairs.len() > begin
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
        let body = &bodies[pair.first];
        let other = &bodies[pair.second];
        let velocity = body.velocity - other.velocity;
        let apart = pair.apart(bodies, &self.periods) - 0.5 * h * velocity;
        let [turn, its] = [pair.first, pair.second].map(|k| self.pose(k, bodies, h).orientation);
        let own = seen(body, &apart, &turn, &its);
        let power = self.law(pair).material.exponent + 1.0;
        let region = self.regions.get(pair.region);
        let touch = |part: &Part| wall.faces().touch(region, part, &own, power);
        let mut touch = match body.parts().get(pair.parts[0]) {
            Some(part) => touch(part),
            None => touch(&Part::ball(Vector3::zeros(), body.radius())),
        };
        // From the centre of the obstacle, along the axes of the box.
        let arm = its * touch.place;
        touch.normal = its * touch.normal;
        Meeting::of(&touch, [arm + apart, arm], velocity, [&body.spin, &other.spin])
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
            let place = self.closest(pair, bodies, 0.0).arms.to[1];
            let own = bodies[pair.second].orientation().inverse_transform_vector(&place);
            let region = self.regions.get(pair.region);
            self.pairs[p].parts[1] = wall.faces().face_at(region, &own);
        }
    }
}
