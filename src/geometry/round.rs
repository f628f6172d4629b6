//! What discs and spheres share: all follows from the distance from their centre.

use super::SurfacePoint;
use nalgebra::Vector3;

/// Whether all (1) or nothing (0) of a box lies inside.
pub fn whole_or_nothing(middle: &Vector3<f64>, half: &Vector3<f64>, radius: f64) -> Option<f64> {
    if (middle.abs() + half).norm() <= radius {
        return Some(1.0);
    }
    ((middle.abs() - half).map(|x| x.max(0.0)).norm() >= radius).then_some(0.0)
}

/// How far it is to the surface, the centre `apart`, in the direction `along`.
pub fn meets(apart: &Vector3<f64>, along: &Vector3<f64>, radius: f64) -> Option<f64> {
    let ahead = apart.dot(along);
    let under = ahead * ahead - apart.norm_squared() + radius * radius;
    (ahead > 0.0 && under > 0.0).then(|| (ahead - under.sqrt()).max(0.0))
}

/// The point of the surface at `place`, on the radius.
pub fn surface_point(place: Vector3<f64>, radius: f64, area: f64) -> SurfacePoint {
    SurfacePoint { place, normal: place / radius, area }
}
