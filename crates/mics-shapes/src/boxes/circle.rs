//! A circle about the origin against a rectangle: area and first moment, exact by inclusion and
//! exclusion of quadrants.
//!
//! ```text
//!   +------+ (x1, y1)      overlap = Q(x1, y1) - Q(x0, y1) - Q(x1, y0) + Q(x0, y0)
//!   |   ,--|               Q(x, y) = area of the disc between the axes and (x, y), odd in both:
//!   +--/---+                 x y inside of the circle, outside A(x) y' + A(y) x', x' the sign of x
//! ```
//! with `A(x) = [x s + r^2 (atan(x/s) - x' pi/4)]/2`, `s = sqrt(r^2 - x^2)`. The first moment of
//! the disc before the line at `x`, between the axis and `y`, is `t (t^2/3 - s^2)/2` with `t` the
//! `y` within [-s, s].

use super::angle::{angle, sign};
use super::make_room;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_4;

/// A line across the circle, along one of the axes.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Where on the other axis (m).
    at: f64,
    /// Half its chord (m); 0 outside.
    root: f64,
    /// Its share A in the areas of quadrants with their corners outside (m2).
    area: f64,
}

impl Line {
    /// At a place (m), for a circle of the radius `r` (m).
    #[inline(always)]
    pub fn new(at: f64, r: f64) -> Line {
        // Near the rim r^2 - x^2 would lose half of the digits.
        let square = (r - at) * (r + at);
        let root = if square > 0.0 { square.sqrt() } else { 0.0 };
        let angle = angle(at, root) - FRAC_PI_4 * sign(at);
        Line { at, root, area: 0.5 * (at * root + r * r * angle) }
    }
}

/// Lines across circles along one axis, by number.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    at: Vec<f64>,
    root: Vec<f64>,
    area: Vec<f64>,
}

impl Lines {
    /// Takes the lines out, and makes room for this many circles with this many lines each.
    pub fn clear(&mut self, circles: usize, lines: usize) {
        for values in [&mut self.at, &mut self.root, &mut self.area] {
            make_room(values, circles * lines.next_multiple_of(VECTOR), 2);
        }
    }

    /// Adds the lines at these places (m), for a circle of the radius `r` (m), the last one once
    /// more up to a whole number of vectors.
    #[inline(always)]
    pub fn add(&mut self, places: &[f64], r: f64) {
        let Lines { at, root, area } = self;
        let from = at.len();
        let n = places.len().next_multiple_of(VECTOR);
        at.extend_from_slice(places);
        at.resize(from + n, places.last().copied().unwrap_or(0.0));
        root.resize(from + n, 0.0);
        area.resize(from + n, 0.0);
        let at = &at[from..][..n];
        let root = &mut root[from..][..n];
        let area = &mut area[from..][..n];
        for i in 0..n {
            let line = Line::new(at[i], r);
            root[i] = line.root;
            area[i] = line.area;
        }
    }

    /// A line of a circle, both by number, of this many a circle.
    #[inline(always)]
    pub fn get(&self, circle: usize, line: usize, lines: usize) -> Line {
        let i = circle * lines.next_multiple_of(VECTOR) + line;
        Line { at: self.at[i], root: self.root[i], area: self.area[i] }
    }
}

/// Numbers of a vector.
pub const VECTOR: usize = 4;

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

    /// Sets the quadrants of the disc of the radius `r` (m) before each of the lines in x and below
    /// one in y; the integrals where they are asked for.
    #[inline(always)]
    pub fn set_below(&mut self, x: &Lines, y: &Line, r: f64, moments: bool) {
        let n = x.at.len();
        let [area, x_moment, y_moment] = self.resize(n + 1);
        let at = &x.at[..n];
        let root = &x.root[..n];
        let share = &x.area[..n];
        let area = &mut area[..n];
        let x_moment = &mut x_moment[..n];
        let y_moment = &mut y_moment[..n];
        for i in 0..n {
            area[i] = quadrant(&Line { at: at[i], root: 0.0, area: share[i] }, y, r);
        }
        for i in 0..if moments { n } else { 0 } {
            x_moment[i] = moment(root[i], y.at);
            y_moment[i] = moment(y.root, at[i]);
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
        out[i] = (next_high[i] - high[i]) - (next_low[i] - low[i]);
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
#[inline(always)]
pub fn rectangle(x: &[Line; 2], y: &[Line; 2], r: f64) -> CirclePart {
    // The order makes the sum the same in a mirror, to the last bit.
    let sum = |q: &dyn Fn(usize, usize) -> f64| (q(1, 1) - q(0, 1)) - (q(1, 0) - q(0, 0));
    CirclePart {
        area: sum(&|i, j| quadrant(&x[i], &y[j], r)).max(0.0),
        moment: [sum(&|i, j| moment(x[i].root, y[j].at)), sum(&|i, j| moment(y[j].root, x[i].at))],
    }
}

/// Radius of the circle in a plane at a place (m) across a sphere's of the given radius (m).
pub fn radius(sphere: f64, at: f64) -> f64 {
    (sphere * sphere - at * at).max(0.0).sqrt()
}

/// Covered part of a face along `axis` times the arm to its centroid (m): the face with its centre
/// at `middle` (m), between the lines of the two axes that follow, in a circle of the radius `r`
/// (m).
#[inline(always)]
pub fn lever(axis: usize, middle: &Vector3<f64>, lines: &[[Line; 2]; 2], r: f64) -> Vector3<f64> {
    let [x, y] = lines;
    let filled = rectangle(x, y, r);
    let density = 1.0 / ((x[1].at - x[0].at) * (y[1].at - y[0].at));
    let part = density * filled.area;
    if part <= LEAST || part >= 1.0 - LEAST {
        return part * middle;
    }
    let own = part * middle[axis];
    let [next, last] = filled.moment.map(|moment| density * moment);
    match axis {
        0 => Vector3::new(own, next, last),
        1 => Vector3::new(last, own, next),
        _ => Vector3::new(next, last, own),
    }
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

/// Area of the disc between the axes and the lines.
#[inline(always)]
fn quadrant(x: &Line, y: &Line, r: f64) -> f64 {
    let outside = x.area * sign(y.at) + y.area * sign(x.at);
    if x.at * x.at + y.at * y.at < r * r { x.at * y.at } else { outside }
}

/// Integral of X over the part of the disc before a line of the half chord `a` (m), between the
/// axis and `y` (m).
#[inline(always)]
fn moment(a: f64, y: f64) -> f64 {
    let t = if y < -a { -a } else { y };
    let t = if t > a { a } else { t };
    0.5 * t * (t * t / 3.0 - a * a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn part(x: [f64; 2], y: [f64; 2], r: f64) -> CirclePart {
        let [x, y] = [x, y].map(|edges| edges.map(|at| Line::new(at, r)));
        rectangle(&x, &y, r)
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
