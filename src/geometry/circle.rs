//! A circle about the origin against a rectangle: area and first moment, exact by inclusion and exclusion of quadrants.
//!
//! ```text
//!   +------+ (x1, y1)      overlap = Q(x1, y1) - Q(x0, y1) - Q(x1, y0) + Q(x0, y0)
//!   |   ,--|               Q(x, y) = area of the disc where X < x and Y < y
//!   +--/---+
//! ```
//! The first moment of a disc of radius `c` over X < x, Y < y, with `a = sqrt(c^2 - x^2)` and `t` the `y` within [-a, a], is
//! `[ -a^2 (t + a) + (t^3 + a^3)/3 ]/2`.

use std::f64::consts::PI;

/// Area of the disc of `radius` at the origin inside the rectangle `x` by `y` (m2).
pub fn rectangle_overlap(x: [f64; 2], y: [f64; 2], radius: f64) -> f64 {
    // Where no arc passes there is nothing to find: most slices of a sphere.
    let far = |edges: [f64; 2]| edges[0].abs().max(edges[1].abs());
    let near = |edges: [f64; 2]| edges[0].max(-edges[1]).max(0.0);
    let square = |f: &dyn Fn([f64; 2]) -> f64| f(x) * f(x) + f(y) * f(y);
    if square(&far) <= radius * radius {
        return (x[1] - x[0]) * (y[1] - y[0]);
    }
    if square(&near) >= radius * radius {
        return 0.0;
    }
    let [half_x, half_y] = [x, y].map(|edges| edges.map(|edge| half_plane(edge, radius)));
    let q = |i: usize, j: usize| quadrant((x[i], half_x[i]), (y[j], half_y[j]), radius);
    (q(1, 1) - q(0, 1) - q(1, 0) + q(0, 0)).max(0.0)
}

/// Area of the disc where X < x.
fn half_plane(x: f64, r: f64) -> f64 {
    if x.abs() >= r {
        return if x > 0.0 { PI * r * r } else { 0.0 };
    }
    // Near the rim asin and r^2 - x^2 would lose half of the digits.
    let half_chord = ((r - x) * (r + x)).sqrt();
    r * r * (0.5 * PI + x.atan2(half_chord)) + x * half_chord
}

/// Area of the disc where X < x and Y < y; each with its half plane's.
fn quadrant((x, half_x): (f64, f64), (y, half_y): (f64, f64), r: f64) -> f64 {
    if x * x + y * y < r * r {
        return 0.5 * (half_x + half_y) + x * y - 0.25 * PI * r * r;
    }
    match (x >= 0.0, y >= 0.0) {
        (true, true) => half_x + half_y - PI * r * r,
        (false, true) => half_x,
        (true, false) => half_y,
        (false, false) => 0.0,
    }
}

/// Integral of X over the disc of radius `c` at the origin inside the rectangle `x` by `y` (m3).
pub fn rectangle_moment(x: [f64; 2], y: [f64; 2], c: f64) -> f64 {
    let quadrant = |i: usize, j: usize| {
        let square = c * c - x[i] * x[i];
        if square <= 0.0 {
            return 0.0;
        }
        let a = square.sqrt();
        let t = y[j].clamp(-a, a);
        0.5 * (-square * (t + a) + (t * t * t + a * a * a) / 3.0)
    };
    quadrant(1, 1) - quadrant(0, 1) - quadrant(1, 0) + quadrant(0, 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_around_the_disc_holds_all_of_it_and_its_quarters_a_quarter_each() {
        let r = 0.7;
        assert!((rectangle_overlap([-1.0, 1.0], [-1.0, 1.0], r) - PI * r * r).abs() < 1e-14);
        assert!((rectangle_overlap([0.0, 1.0], [-1.0, 0.0], r) - PI * r * r / 4.0).abs() < 1e-14);
        assert_eq!(rectangle_overlap([0.7, 1.0], [-1.0, 1.0], r), 0.0);
    }

    #[test]
    fn the_exact_overlap_agrees_with_counting_points() {
        let (x, y, r) = ([0.1, 0.75], [-0.2, 0.6], 0.8);
        let n = 2000;
        let at = |s: [f64; 2], k: usize| s[0] + (s[1] - s[0]) * (k as f64 + 0.5) / n as f64;
        let inside = (0..n * n).filter(|k| at(x, k % n).hypot(at(y, k / n)) < r).count();
        let counted = inside as f64 / (n * n) as f64 * (x[1] - x[0]) * (y[1] - y[0]);
        assert!((rectangle_overlap(x, y, r) - counted).abs() < 1e-5);
    }

    #[test]
    fn the_moment_of_a_rectangle_agrees_with_counting_points() {
        let (x, y, c) = ([0.1, 0.75], [-0.2, 0.6], 0.8);
        let n = 1000;
        let at = |s: [f64; 2], k: usize| s[0] + (s[1] - s[0]) * (k as f64 + 0.5) / n as f64;
        let points = (0..n * n).map(|k| (at(x, k % n), at(y, k / n)));
        let sum: f64 = points.filter(|(x, y)| x.hypot(*y) < c).map(|(x, _)| x).sum();
        let counted = sum / (n * n) as f64 * (x[1] - x[0]) * (y[1] - y[0]);
        assert!((rectangle_moment(x, y, c) - counted).abs() < 1e-5);
    }
}
