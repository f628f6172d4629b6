//! Moments of what an outline of straight sides and arcs encloses, in closed form.
//!
//! ```text
//!      q ,--.         each side spans a triangle with the origin, and so does the chord of an arc,
//!       / `. \ arc     to which what lies between both is added: the sector less the triangle that
//!     o-----. p       the chord spans with the arc's centre
//! ```

use nalgebra::{Matrix2, Vector2};

/// Moments about the origin of what an outline encloses.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moments {
    /// Area (m2).
    pub area: f64,
    /// The integral of the place (m3).
    pub first: Vector2<f64>,
    /// The integral of `x x^T` (m4).
    pub second: Matrix2<f64>,
}

impl Moments {
    /// Adds a side from one point to another (m), the body on its left.
    pub fn add_side(&mut self, p: &Vector2<f64>, q: &Vector2<f64>) {
        let area = 0.5 * p.perp(q);
        let squares = [*p, *q, p + q].map(|x| x * x.transpose()).iter().sum::<Matrix2<f64>>();
        self.area += area;
        self.first += area / 3.0 * (p + q);
        self.second += area / 12.0 * squares;
    }

    /// Adds the arc of a circle (m) counterclockwise between two directions from its centre, less
    /// than half a turn apart.
    pub fn add_arc(
        &mut self,
        centre: &Vector2<f64>,
        radius: f64,
        p: &Vector2<f64>,
        q: &Vector2<f64>,
    ) {
        self.add_side(&(centre + radius * p), &(centre + radius * q));
        let angle = p.perp(q).atan2(p.dot(q));
        // Integrals of cos cos, cos sin and sin sin over the angle.
        let [xx, xy] = [q.x * q.y - p.x * p.y, q.y * q.y - p.y * p.y];
        let mut own = Moments {
            area: 0.5 * angle,
            first: Vector2::new(q.y - p.y, p.x - q.x) / 3.0,
            second: 0.125 * Matrix2::new(angle + xx, xy, xy, angle - xx),
        };
        own.add_side(q, p);
        let area = radius.powi(2) * own.area;
        let first = radius.powi(3) * own.first;
        let cross = centre * first.transpose();
        self.area += area;
        self.first += first + area * centre;
        self.second += radius.powi(4) * own.second + cross + cross.transpose();
        self.second += area * centre * centre.transpose();
    }

    /// Moments of inertia of unit density (m4).
    pub fn inertia(&self) -> nalgebra::Matrix3<f64> {
        let [xx, yy, xy] = [self.second.m11, self.second.m22, self.second.m12];
        nalgebra::Matrix3::new(yy, -xy, 0.0, -xy, xx, 0.0, 0.0, 0.0, xx + yy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn square_and_disc_aside_have_known_moments() {
        let centre = Vector2::new(0.7, -0.4);
        let axes = [Vector2::x(), Vector2::y(), -Vector2::x(), -Vector2::y()];
        let next = |k: usize| axes[(k + 1) % 4];
        let mut square = Moments::default();
        let corner = |k: usize| centre + axes[k % 4] + next(k);
        (0..4).for_each(|k| square.add_side(&corner(k), &corner(k + 1)));
        let mut disc = Moments::default();
        (0..4).for_each(|k| disc.add_arc(&centre, 0.5, &axes[k], &next(k)));
        for (found, area, own) in [(square, 4.0, 4.0 / 3.0), (disc, 0.25 * PI, PI / 64.0)] {
            let second = own * Matrix2::identity() + area * centre * centre.transpose();
            assert!((found.area - area).abs() < 1e-15, "{found:?}");
            assert!((found.first - area * centre).norm() < 1e-15, "{found:?}");
            assert!((found.second - second).norm() < 1e-15, "{found:?}");
        }
    }
}
