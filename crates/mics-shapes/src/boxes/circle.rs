//! A circle about the origin against a rectangle: area and first moment, exact by inclusion and
//! exclusion of quadrants.
//!
//! ```text
//!   +------+ (x1, y1)      overlap = Q(x1, y1) - Q(x0, y1) - Q(x1, y0) + Q(x0, y0)
//!   |   ,--|               Q(x, y) = area of the disc where X < x and Y < y
//!   +--/---+
//! ```
//! The first moment of a disc of radius `r` over X < x, Y < y, with `a = sqrt(r^2 - x^2)` and `t`
//! the `y` within [-a, a], is `[ -a^2 (t + a) + (t^3 + a^3)/3 ]/2`.

use super::make_room;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI};

/// A line across the circle, along one of the axes.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Where on the other axis (m).
    at: f64,
    /// Half its chord (m); 0 outside.
    root: f64,
    /// Area of the disc below it (m2).
    below: f64,
}

impl Line {
    /// At a place (m), for a circle of the radius `r` (m).
    pub fn new(at: f64, r: f64) -> Line {
        if at.abs() >= r {
            return Line { at, root: 0.0, below: if at > 0.0 { PI * r * r } else { 0.0 } };
        }
        // Near the rim asin and r^2 - x^2 would lose half of the digits.
        let root = ((r - at) * (r + at)).sqrt();
        Line { at, root, below: r * r * (FRAC_PI_2 + at.atan2(root)) + at * root }
    }
}

/// Lines across the circle along one axis, by number.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    at: Vec<f64>,
    root: Vec<f64>,
    below: Vec<f64>,
}

impl Lines {
    /// Sets the lines at these places (m), for a circle of the radius `r` (m), the last one once
    /// more up to a whole number of vectors.
    pub fn set(&mut self, places: &[f64], r: f64) {
        let Lines { at, root, below } = self;
        for values in [&mut *at, root, below] {
            make_room(values, places.len() + VECTOR, 1);
        }
        for line in places.iter().map(|at| Line::new(*at, r)) {
            at.push(line.at);
            root.push(line.root);
            below.push(line.below);
        }
        let whole = at.len().next_multiple_of(VECTOR);
        for values in [at, root, below] {
            let last = values.last().copied().unwrap_or(0.0);
            values.resize(whole, last);
        }
    }
}

/// Numbers of a vector.
const VECTOR: usize = 4;

/// Areas (m2) and integrals of both coordinates (m3) over many regions, by number.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    /// Area of each.
    pub area: Vec<f64>,
    /// Integrals of x and y over each.
    pub moment: [Vec<f64>; 2],
}

impl Parts {
    fn resize(&mut self, n: usize) -> [&mut [f64]; 3] {
        let [x, y] = &mut self.moment;
        [&mut self.area, x, y].map(|values| {
            if n > values.capacity() {
                values.reserve(2 * n);
            }
            values.resize(n, 0.0);
            &mut values[..]
        })
    }

    /// Sets the parts of the disc of the radius `r` (m) below each of the lines in x and one in y:
    /// the quadrants of [`rectangle`], with no branch; the integrals where they are asked for.
    #[inline(always)]
    pub fn set_below(&mut self, x: &Lines, y: &Line, r: f64, moments: bool) {
        let n = x.at.len();
        let square = r * r;
        let whole = PI * r * r;
        let [area, x_moment, y_moment] = self.resize(n + 1);
        let at = &x.at[..n];
        let root = &x.root[..n];
        let below = &x.below[..n];
        let above = y.at >= 0.0;
        let y_square = y.at * y.at;
        let area = &mut area[..n];
        let x_moment = &mut x_moment[..n];
        let y_moment = &mut y_moment[..n];
        for i in 0..n {
            let x = at[i];
            let line = below[i];
            let right = at[i] >= 0.0;
            let within = 0.5 * (line + y.below) + x * y.at - 0.25 * whole;
            let sum = if above { line } else { 0.0 } + if right { y.below } else { 0.0 };
            let outside = sum - if above && right { whole } else { 0.0 };
            area[i] = if x * x + y_square < square { within } else { outside };
        }
        for i in 0..if moments { n } else { 0 } {
            x_moment[i] = moment_within(root[i], y.at);
            y_moment[i] = moment_within(y.root, at[i]);
        }
    }

    /// Sets the parts of the disc in the rectangles between neighbouring lines in x and two in y,
    /// by those below these; up to a whole number of vectors.
    #[inline(always)]
    pub fn set_between(&mut self, low: &Parts, high: &Parts, moments: bool) {
        let n = low.area.len().saturating_sub(1);
        let [area, x, y] = self.resize(n);
        between(&low.area, &high.area, area);
        area.iter_mut().for_each(|area| *area = if *area > 0.0 { *area } else { 0.0 });
        if moments {
            between(&low.moment[0], &high.moment[0], x);
            between(&low.moment[1], &high.moment[1], y);
        }
    }
}

#[inline(always)]
fn between(low: &[f64], high: &[f64], out: &mut [f64]) {
    let n = out.len();
    let next_low = &low[1..n + 1];
    let next_high = &high[1..n + 1];
    let low = &low[..n];
    let high = &high[..n];
    for i in 0..n {
        out[i] = next_high[i] - high[i] - next_low[i] + low[i];
    }
}

/// The part of a disc in a region.
#[derive(Clone, Copy, Debug, Default)]
pub struct CirclePart {
    /// Area (m2).
    pub area: f64,
    /// Integrals of both coordinates over it (m3).
    pub moment: [f64; 2],
}

/// The part of the disc of the radius `r` (m) in the rectangle between two lines in x and two in y.
pub fn rectangle(x: [&Line; 2], y: [&Line; 2], r: f64) -> CirclePart {
    // Where no arc passes there is nothing to find.
    let far = |edges: [&Line; 2]| edges[0].at.abs().max(edges[1].at.abs());
    let near = |edges: [&Line; 2]| edges[0].at.max(-edges[1].at).max(0.0);
    let square = |f: &dyn Fn([&Line; 2]) -> f64| f(x) * f(x) + f(y) * f(y);
    if square(&far) <= r * r {
        let area = (x[1].at - x[0].at) * (y[1].at - y[0].at);
        return CirclePart {
            area,
            moment: [x, y].map(|edges| 0.5 * area * (edges[0].at + edges[1].at)),
        };
    }
    if square(&near) >= r * r {
        return CirclePart::default();
    }
    let sum = |q: &dyn Fn(usize, usize) -> f64| q(1, 1) - q(0, 1) - q(1, 0) + q(0, 0);
    CirclePart {
        area: sum(&|i, j| quadrant(x[i], y[j], r)).max(0.0),
        moment: [sum(&|i, j| moment(x[i], y[j])), sum(&|i, j| moment(y[j], x[i]))],
    }
}

/// Radius of the circle in a plane at a place (m) across a sphere's of the given radius (m).
pub fn radius(sphere: f64, at: f64) -> f64 {
    (sphere * sphere - at * at).max(0.0).sqrt()
}

/// Covered part of a face along `axis` times the arm to its centroid (m): the face with its centre
/// at `middle` (m), between the lines of the two axes that follow, in a circle of the radius `r`
/// (m).
pub fn lever(axis: usize, middle: &Vector3<f64>, lines: [[&Line; 2]; 2], r: f64) -> Vector3<f64> {
    let [x, y] = lines;
    let filled = rectangle(x, y, r);
    let whole = (x[1].at - x[0].at) * (y[1].at - y[0].at);
    let part = filled.area / whole;
    let mut lever = part * middle;
    if part > LEAST && part < 1.0 - LEAST {
        lever[(axis + 1) % 3] = filled.moment[0] / whole;
        lever[(axis + 2) % 3] = filled.moment[1] / whole;
    }
    lever
}

/// Covered part of a face in 2D times the arm to its centroid (m): the face of half edges `half`
/// (m), with half the chord `c` (m) in its plane.
pub fn chord_lever(
    axis: usize,
    middle: &Vector3<f64>,
    half: &Vector3<f64>,
    c: f64,
) -> Vector3<f64> {
    let a = 1 - axis;
    let low = (middle[a] - half[a]).max(-c);
    let high = (middle[a] + half[a]).min(c);
    let mut centroid = *middle;
    if high > low {
        centroid[a] = 0.5 * (low + high);
    }
    (high - low).max(0.0) / (2.0 * half[a]) * centroid
}

/// Part of a face below which, as above one less it, the covered one's centroid is the face's own.
const LEAST: f64 = 1e-9;

/// Area of the disc where X < x and Y < y.
fn quadrant(x: &Line, y: &Line, r: f64) -> f64 {
    if x.at * x.at + y.at * y.at < r * r {
        return 0.5 * (x.below + y.below) + x.at * y.at - 0.25 * PI * r * r;
    }
    match (x.at >= 0.0, y.at >= 0.0) {
        (true, true) => x.below + y.below - PI * r * r,
        (false, true) => x.below,
        (true, false) => y.below,
        (false, false) => 0.0,
    }
}

/// Integral of X over that part.
fn moment(x: &Line, y: &Line) -> f64 {
    moment_within(x.root, y.at)
}

/// Integral of X over the part of the disc before a line of the half chord `a` (m), below `y` (m).
#[inline(always)]
fn moment_within(a: f64, y: f64) -> f64 {
    let t = if y < -a { -a } else { y };
    let t = if t > a { a } else { t };
    0.5 * (-a * a * (t + a) + (t * t * t + a * a * a) / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(x: [f64; 2], y: [f64; 2], r: f64) -> CirclePart {
        let [x, y] = [x, y].map(|edges| edges.map(|at| Line::new(at, r)));
        rectangle([&x[0], &x[1]], [&y[0], &y[1]], r)
    }

    #[test]
    fn disc_rectangle_overlap_whole_and_quarters() {
        let r = 0.7;
        assert!((part([-1.0, 1.0], [-1.0, 1.0], r).area - PI * r * r).abs() < 1e-14);
        assert!((part([0.0, 1.0], [-1.0, 0.0], r).area - PI * r * r / 4.0).abs() < 1e-14);
        assert_eq!(part([0.7, 1.0], [-1.0, 1.0], r).area, 0.0);
    }

    #[test]
    fn disc_rectangle_overlap_matches_point_count() {
        let x = [0.1, 0.75];
        let y = [-0.2, 0.6];
        let r = 0.8;
        let n = 2000;
        let at = |s: [f64; 2], k: usize| s[0] + (s[1] - s[0]) * (k as f64 + 0.5) / n as f64;
        let inside = (0..n * n).filter(|k| at(x, k % n).hypot(at(y, k / n)) < r).count();
        let counted = inside as f64 / (n * n) as f64 * (x[1] - x[0]) * (y[1] - y[0]);
        assert!((part(x, y, r).area - counted).abs() < 1e-5);
    }

    #[test]
    fn disc_rectangle_moment_matches_point_count() {
        let x = [0.1, 0.75];
        let y = [-0.2, 0.6];
        let c = 0.8;
        let n = 1000;
        let at = |s: [f64; 2], k: usize| s[0] + (s[1] - s[0]) * (k as f64 + 0.5) / n as f64;
        let points = (0..n * n).map(|k| (at(x, k % n), at(y, k / n)));
        let sum: f64 = points.filter(|(x, y)| x.hypot(*y) < c).map(|(x, _)| x).sum();
        let counted = sum / (n * n) as f64 * (x[1] - x[0]) * (y[1] - y[0]);
        assert!((part(x, y, c).moment[0] - counted).abs() < 1e-5);
    }
}
