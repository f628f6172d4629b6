//! How far two bodies are apart.

use super::Body;
use mics_shapes::{Part, Pose, closest};
use nalgebra::Vector3;

/// The direction from a body to another one, whose centre is `apart` from its own (m), and the gap
/// between them (m), negative where they overlap: of bodies that are not round where their parts
/// are nearest, and of such as have no parts that of the spheres about them.
pub fn gap(body: &Body, other: &Body, apart: &Vector3<f64>) -> (Vector3<f64>, f64) {
    let distance = apart.norm();
    let spheres = (apart / distance, distance - body.radius() - other.radius());
    if body.parts().is_empty() && other.parts().is_empty() {
        return spheres;
    }
    let (ball, its_ball) =
        (Part::ball(Vector3::zeros(), body.radius()), Part::ball(Vector3::zeros(), other.radius()));
    let parts = |body: &'_ Body| body.parts().len().max(1);
    let (own, its) = (
        Pose { place: Vector3::zeros(), orientation: body.orientation() },
        Pose { place: *apart, orientation: other.orientation() },
    );
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
