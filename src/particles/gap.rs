//! The gap between two bodies.

use super::Body;
use mics_shapes::{Obstacle, Part, Pose, closest};
use nalgebra::Vector3;

/// The direction from a body to another one, whose centre is `apart` from its own (m), and the gap
/// between them (m), negative where they overlap: between the nearest parts of bodies that are not
/// round, to the surface of an obstacle, and between the enclosing spheres of bodies without parts.
pub fn gap(body: &Body, other: &Body, apart: &Vector3<f64>) -> (Vector3<f64>, f64) {
    if let Some(wall) = other.shape().obstacle() {
        return gap_to(body, other, wall, apart);
    }
    if let Some(wall) = body.shape().obstacle() {
        let (normal, gap) = gap_to(other, body, wall, &-apart);
        return (-normal, gap);
    }
    let distance = apart.norm();
    let spheres = (apart / distance, distance - body.radius() - other.radius());
    if body.parts().is_empty() && other.parts().is_empty() {
        return spheres;
    }
    let ball = Part::ball(Vector3::zeros(), body.radius());
    let its_ball = Part::ball(Vector3::zeros(), other.radius());
    let parts = |body: &'_ Body| body.parts().len().max(1);
    let own = Pose { place: Vector3::zeros(), orientation: body.orientation() };
    let its = Pose { place: *apart, orientation: other.orientation() };
    let mut nearest: Option<(Vector3<f64>, f64)> = None;
    for k in 0..parts(body) {
        let part = body.parts().get(k).unwrap_or(&ball);
        for l in 0..parts(other) {
            let its_part = other.parts().get(l).unwrap_or(&its_ball);
            let guess = apart + its.orientation * its_part.place - own.orientation * part.place;
            let found = closest(part, &own, its_part, &its, &guess)
                // Cores that overlap.
                .map_or((spheres.0, -part.rounding - its_part.rounding), |found| {
                    (found.normal, found.distance)
                });
            if nearest.is_none_or(|nearest| found.1 < nearest.1) {
                nearest = Some(found);
            }
        }
    }
    nearest.unwrap_or(spheres)
}

/// Direction to an obstacle, whose centre is `apart` from the body's (m), and the gap to it (m).
fn gap_to(body: &Body, other: &Body, wall: &Obstacle, apart: &Vector3<f64>) -> (Vector3<f64>, f64) {
    let turn = other.orientation();
    let back = turn.inverse();
    let pose = Pose { place: -(back * apart), orientation: back * body.orientation() };
    let ball = [Part::ball(Vector3::zeros(), body.radius())];
    let parts = if body.parts().is_empty() { &ball[..] } else { body.parts() };
    let gaps = parts.iter().map(|part| wall.gap(part, &pose));
    let nearest = gaps.min_by(|one, other| one.1.total_cmp(&other.1));
    nearest.map_or((apart.normalize(), f64::INFINITY), |(normal, gap)| (turn * normal, gap))
}
