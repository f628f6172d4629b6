//! What a shape fills of a box, by its distance alone: pieces that the surface may pass are halved
//! along every axis a few times, and then cut by a plane.
//!
//! ```text
//!   +-------+---+---+       the plane of a last piece is at the signed distance s from its middle;
//!                           with w the half width
//!   |       |   |/##|       of the piece along the normal n, it fills
//!   |       +---/---+          (w - s)/(2 w) of it, with the centroid at -(w + s)/2 along n:
//!   |       | /#|###|       exact where n is along an axis
//!   +-------/---+---+
//! ```

use nalgebra::Vector3;

/// Signed distance (m) and normal of the surface nearest to a point.
type Wall<'a> = &'a dyn Fn(&Vector3<f64>) -> (f64, Vector3<f64>);

/// Times that a box is halved.
const TIMES: u32 = 3;

/// Volume filled (m3; m2 of a section), and the integrals of the coordinates over it, of the box
/// with its centre at `middle` (m) and the `half` edges (m); `wall` has the signed distance (m) and
/// the normal of a surface at a point (m).
pub fn moments(
    dimension: usize,
    middle: &Vector3<f64>,
    half: &Vector3<f64>,
    wall: Wall,
) -> (f64, Vector3<f64>) {
    piece(dimension, middle, half, wall, TIMES)
}

fn piece(
    dimension: usize,
    middle: &Vector3<f64>,
    half: &Vector3<f64>,
    wall: Wall,
    times: u32,
) -> (f64, Vector3<f64>) {
    let (distance, normal) = wall(middle);
    let volume: f64 = (0..dimension).map(|a| 2.0 * half[a]).product();
    if distance.abs() >= half.norm() || times == 0 {
        let width = normal.abs().dot(half);
        let distance = distance.clamp(-width, width);
        let filled = volume * 0.5 * (1.0 - distance / width);
        return (filled, filled * (middle - 0.5 * (width + distance) * normal));
    }
    let half = 0.5 * half;
    let (mut filled, mut moment) = (0.0, Vector3::zeros());
    for k in 0..1 << dimension {
        let middle =
            middle + Vector3::from_fn(|a, _| if k >> a & 1 == 0 { -half[a] } else { half[a] });
        let (volume, first) = piece(dimension, &middle, &half, wall, times - 1);
        filled += volume;
        moment += first;
    }
    (filled, moment)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Disc, Orientation, Shape, Sphere};

    /// Largest difference from the closed form, of the box, over boxes of an eighth of the
    /// diameter.
    fn worst(shape: &dyn Shape) -> f64 {
        let (orientation, half) = (
            Orientation::identity(),
            Vector3::new(0.125, 0.125, if shape.dimension() == 3 { 0.125 } else { 0.0 }),
        );
        let whole: f64 = (0..shape.dimension()).map(|a| 2.0 * half[a]).product();
        let mut worst = 0.0f64;
        for k in 0..200 {
            let mut n = Vector3::from_fn(|a, _| (1.7 * k as f64 + 2.3 * a as f64).sin());
            n.z = if shape.dimension() == 3 { n.z } else { 0.0 };
            let middle = (1.0 + 0.1 * (0.9 * k as f64).cos()) * n.normalize();
            let (volume, first) = shape.moments(&orientation, &middle, &half);
            let wall = |at: &Vector3<f64>| {
                (shape.distance(&orientation, at), shape.normal(&orientation, at))
            };
            let (found, moment) = moments(shape.dimension(), &middle, &half, &wall);
            worst = worst.max((found - volume).abs() / whole).max((moment - first).amax() / whole);
        }
        worst
    }

    #[test]
    fn subdivided_overlap_approximates_closed_form() {
        let [flat, space] =
            [&Disc { radius: 1.0 } as &dyn Shape, &Sphere { radius: 1.0 }].map(worst);
        println!("worst of a box: disc {flat:.1e}, sphere {space:.1e}");
        assert!(flat < 3e-3 && space < 4e-3);
    }
}
