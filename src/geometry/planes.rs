//! Planes that a convex body lies below: what lies above one of them is outside, without a search
//! for the nearest point of the surface.
//!
//! ```text
//!      . . . . . . .       a point that is found above a plane says that of most of those after it
//!    ---------------  n    on that side of the body; each of the eight sides has its last plane
//!       ,-------.   . .
//!      ( body    )  . .
//! ```

use super::{Nearest, Turned};
use nalgebra::Vector3;

/// Rounding of heights, as a part of the radius.
const SLACK: f64 = 1e-12;

/// The last plane found on each side.
#[derive(Clone, Copy, Debug, Default)]
pub struct Planes {
    /// The outward normal, of length 1, and the plane's distance from the body's centre (m).
    found: [Option<(Vector3<f64>, f64)>; 8],
}

impl Planes {
    /// Whether the box about the point at `arm` (m) with the `half` edges (m) lies more than
    /// `height` (m) above a plane that the body lies below: it is as far outside beyond doubt.
    #[inline]
    pub fn clears(
        &mut self,
        body: &Turned,
        arm: &Vector3<f64>,
        half: &Vector3<f64>,
        height: f64,
    ) -> bool {
        let side = (0..3).map(|a| usize::from(arm[a] > 0.0) << a).sum::<usize>();
        let height = height + SLACK * body.shape.radius();
        let clears = |(normal, offset): &(Vector3<f64>, f64)| {
            normal.dot(arm) - offset - normal.abs().dot(half) > height
        };
        if self.found[side].as_ref().is_some_and(clears) {
            return true;
        }
        let Some(Nearest { distance, normal }) = body.plane(arm) else { return false };
        let plane = (normal, normal.dot(arm) - distance);
        let cleared = clears(&plane);
        if cleared {
            self.found[side] = Some(plane);
        }
        cleared
    }
}

#[cfg(test)]
mod tests {
    use super::super::shapes::Superquadric;
    use super::*;
    use crate::geometry::{Orientation, Shape};

    /// Points that are cleared in the order of rows, with the planes of others, are as far outside.
    #[test]
    fn cleared_points_are_further_outside_than_asked_for() {
        let shape = Superquadric::new([1.0, 0.7, 0.5], [3.0, 2.5]).unwrap();
        let turn = Orientation::from_euler_angles(0.3, -0.8, 1.1);
        let body = (&shape as &dyn Shape).turned(&turn);
        let mut planes = Planes::default();
        let point = Vector3::zeros();
        let mut cleared = 0;
        for k in 0..27_000 {
            let at = [k % 30, k / 30 % 30, k / 900].map(|n| 0.1 * (f64::from(n) - 14.6));
            let arm = Vector3::from(at);
            if planes.clears(&body, &arm, &point, 0.2) {
                cleared += 1;
                assert!(body.distance(&arm) > 0.2, "{arm}");
            }
        }
        assert!(cleared > 15_000, "{cleared}");
    }
}
