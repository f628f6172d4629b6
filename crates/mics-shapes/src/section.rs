//! What a region, given by its outline, fills of a rectangle, exactly, from the segments of the
//! outline that are near it.
//!
//! ```text
//!    +----x--------+    the outline runs with the region on its left. Where it leaves the
//!    |  ./         |    rectangle (x), the region begins along the rectangle's boundary,
//!    | /  region   |    counterclockwise, and it ends where the outline next enters (o).
//!    o------------ +
//! ```
//! Area and first moments follow by Green's theorem from the clipped segments and from these parts
//! of the boundary. The rectangle is narrower by 1e-10 than asked, so that no outline along the
//! lines of a grid lies on its sides.

use nalgebra::Vector2;

/// Part by which the rectangle is narrower, by side.
const NARROWER: [f64; 4] = [1.0e-10, 1.3e-10, 1.7e-10, 1.1e-10];

/// Area and first moments about the middle of a rectangle, as triangles are added.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    area: f64,
    first: Vector2<f64>,
}

impl Sum {
    /// Adds the triangle of the middle and two points, with a sign.
    fn add(&mut self, p: &Vector2<f64>, q: &Vector2<f64>) {
        let area = 0.5 * p.perp(q);
        self.area += area;
        self.first += area / 3.0 * (p + q);
    }
}

/// A rectangle about the origin that is asked what a region fills of it, in room that is used
/// again.
#[derive(Clone, Debug, Default)]
pub struct Section {
    low: Vector2<f64>,
    high: Vector2<f64>,
    sum: Sum,
    /// Where the outline leaves (true) or enters, along the boundary from its lower left corner:
    /// the side's number plus the part of the side.
    events: Vec<(f64, bool)>,
}

impl Section {
    /// Begins with the rectangle of these half edges (m) about the origin.
    pub fn begin(&mut self, half: &Vector2<f64>) {
        let size = half.x.max(half.y);
        self.low = Vector2::new(NARROWER[3] * size - half.x, NARROWER[0] * size - half.y);
        self.high = Vector2::new(half.x - NARROWER[1] * size, half.y - NARROWER[2] * size);
        self.sum = Sum::default();
        self.events.clear();
    }

    /// Adds a segment of the outline (m), the region on its left.
    pub fn add(&mut self, from: &Vector2<f64>, to: &Vector2<f64>) {
        let way = to - from;
        // Parameters and sides at which the segment enters and leaves.
        let (mut enter, mut leave) = ((0.0, None), (1.0, None));
        let sides = [
            (from.y - self.low.y, way.y, 0),
            (self.high.x - from.x, -way.x, 1),
            (self.high.y - from.y, -way.y, 2),
            (from.x - self.low.x, way.x, 3),
        ];
        for (inside, rate, side) in sides {
            // It is inside of this side where `inside + t rate >= 0`.
            if rate == 0.0 {
                if inside < 0.0 {
                    return;
                }
                continue;
            }
            let t = -inside / rate;
            if rate > 0.0 && t > enter.0 {
                enter = (t, Some(side));
            } else if rate < 0.0 && t < leave.0 {
                leave = (t, Some(side));
            }
        }
        if enter.0 >= leave.0 {
            return;
        }
        let (p, q) = (from + enter.0 * way, from + leave.0 * way);
        self.sum.add(&p, &q);
        for (point, at, leaves) in [(p, enter.1, false), (q, leave.1, true)] {
            if let Some(side) = at {
                self.events.push((side as f64 + self.along(side, &point), leaves));
            }
        }
    }

    /// How far along a side a point is, from 0 to 1.
    fn along(&self, side: usize, point: &Vector2<f64>) -> f64 {
        let part = (point - self.low).component_div(&(self.high - self.low));
        let part = [part.x, part.y, 1.0 - part.x, 1.0 - part.y][side];
        part.clamp(0.0, 1.0 - f64::EPSILON)
    }

    /// The point of the boundary at a place along it.
    fn on_boundary(&self, place: f64) -> Vector2<f64> {
        let (side, t) = ((place.floor() as usize) % 4, place.fract());
        let (low, way) = (self.low, self.high - self.low);
        match side {
            0 => Vector2::new(low.x + t * way.x, low.y),
            1 => Vector2::new(self.high.x, low.y + t * way.y),
            2 => Vector2::new(self.high.x - t * way.x, self.high.y),
            _ => Vector2::new(low.x, self.high.y - t * way.y),
        }
    }

    /// Area of the region within (m2) and the integral of the place over that (m3); `inside` says
    /// whether the region has a point, asked where no outline crosses the rectangle's boundary.
    pub fn end(&mut self, inside: impl FnOnce(&Vector2<f64>) -> bool) -> (f64, Vector2<f64>) {
        self.events.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut sum = self.sum;
        let Some(begin) = self.events.iter().position(|(_, leaves)| *leaves) else {
            if inside(&self.low) {
                (0..4).for_each(|k| {
                    sum.add(&self.on_boundary(k as f64), &self.on_boundary(k as f64 + 1.0));
                });
            }
            return (sum.area, sum.first);
        };
        // From where it leaves to where it next enters.
        let n = self.events.len();
        let mut left = None;
        for k in 0..=n {
            let (place, leaves) = self.events[(begin + k) % n];
            let place = if begin + k >= n { place + 4.0 } else { place };
            match (left, leaves) {
                (None, true) => left = Some(place),
                (Some(from), false) => {
                    self.add_boundary(&mut sum, from, place);
                    left = None;
                }
                _ => {}
            }
        }
        (sum.area, sum.first)
    }

    /// Adds the boundary from one place along it to a later one.
    fn add_boundary(&self, sum: &mut Sum, from: f64, to: f64) {
        let (mut at, mut point) = (from, self.on_boundary(from));
        while at < to {
            let next = (at.floor() + 1.0).min(to);
            let end = self.on_boundary(next);
            sum.add(&point, &end);
            (at, point) = (next, end);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(outline: &[[f64; 2]], half: [f64; 2], corner: bool) -> (f64, Vector2<f64>) {
        let mut section = Section::default();
        section.begin(&Vector2::from(half));
        for k in 0..outline.len() {
            let [p, q] = [k, (k + 1) % outline.len()].map(|k| Vector2::from(outline[k]));
            section.add(&p, &q);
        }
        section.end(|_| corner)
    }

    #[test]
    fn region_of_half_plane_corner_and_hole() {
        // Below y = 0.25 x.
        let below = [[-5.0, -5.0], [5.0, -5.0], [5.0, 1.25], [-5.0, -1.25]];
        let (area, first) = filled(&below, [1.0, 1.0], true);
        assert!((area - 2.0).abs() < 1e-9 && (first.x - 2.0 * 0.25 / 3.0).abs() < 1e-9, "{first}");
        // A concave corner at the origin: all but the first quadrant.
        let notched = [[-5.0, -5.0], [5.0, -5.0], [5.0, 0.0], [0.0, 0.0], [0.0, 5.0], [-5.0, 5.0]];
        let (area, first) = filled(&notched, [1.0, 0.5], true);
        assert!((area - 1.5).abs() < 1e-9 && (first - Vector2::new(-0.25, -0.125)).norm() < 1e-9);
        // A square within it, and a hole.
        let square = [[-0.1, -0.2], [0.3, -0.2], [0.3, 0.2], [-0.1, 0.2]];
        let (area, first) = filled(&square, [1.0, 1.0], false);
        assert!((area - 0.16).abs() < 1e-12 && (first.x - 0.016).abs() < 1e-12);
        let hole = [[-0.1, 0.2], [0.3, 0.2], [0.3, -0.2], [-0.1, -0.2]];
        assert!((filled(&hole, [1.0, 1.0], true).0 - 3.84).abs() < 1e-8);
        // Along the rectangle's own side nothing jumps.
        let flush = [[-5.0, -5.0], [5.0, -5.0], [5.0, -1.0], [-5.0, -1.0]];
        assert!(filled(&flush, [1.0, 1.0], false).0.abs() < 1e-8);
        let whole = [[-5.0, -5.0], [5.0, -5.0], [5.0, 1.0], [-5.0, 1.0]];
        assert!((filled(&whole, [1.0, 1.0], true).0 - 4.0).abs() < 1e-8);
    }
}
