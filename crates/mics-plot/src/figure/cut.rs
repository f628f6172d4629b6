//! Particles as a plane cuts them: discs, and rings of points of those that are not round.

use super::trace::{Point, distance};
use std::f64::consts::TAU;

/// A particle as a plane cuts it.
#[derive(Debug, Clone, Default)]
pub struct Disc {
    /// Centre in the plane's own coordinates.
    pub centre: [f64; 2],
    /// Radius of the cut; of what is not round that of a circle that holds it.
    pub radius: f64,
    /// The rings that bound what is not round, from its centre; none of a round one.
    pub outline: Vec<Vec<[f64; 2]>>,
    /// Whether it is an obstacle, whose rings bound it together, and which has a grey of its own.
    pub wall: bool,
    /// Its grey or colour, from 0 (light) to 1 (dark).
    pub shade: f64,
    /// The part of it that is darker and shows how it is turned: where `m[0] x + m[1] y + m[2] >
    /// 0`, from its centre. No mark on one that does not turn.
    pub mark: Option<[f64; 3]>,
    /// Texts that may be written on it, of which the first that there is room for is: its name, its
    /// number; nothing on one that is alone.
    pub label: Vec<String>,
}

impl Disc {
    /// The rings that bound it, in the plane's own coordinates: one of about so many `corners` of a
    /// round one.
    pub fn rings(&self, corners: usize) -> Vec<Vec<Point>> {
        let [x, y] = self.centre;
        if !self.outline.is_empty() {
            let moved = |ring: &Vec<Point>| ring.iter().map(|[a, b]| [x + a, y + b]).collect();
            return self.outline.iter().map(moved).collect();
        }
        let rim = |k: usize| {
            let (sin, cos) = (k as f64 / corners as f64 * TAU).sin_cos();
            [x + self.radius * cos, y + self.radius * sin]
        };
        vec![(0..corners).map(rim).collect()]
    }

    /// Radius of a circle about its centre that has room for writing, up to its outermost edges.
    pub fn room(&self) -> f64 {
        let outer = |(a, b): &(Point, Point)| {
            let middle = [0, 1].map(|k| 0.5 * (a[k] + b[k]));
            // Within the ring that it is an edge of, it is at most once.
            self.outline.iter().filter(|ring| within(std::slice::from_ref(*ring), middle)).count()
                < 2
        };
        let edges = self.outline.iter().flat_map(|ring| edges(ring)).filter(outer);
        edges.map(|(a, b)| to_segment([0.0; 2], a, b)).fold(self.radius, f64::min)
    }

    /// Whether a point is in it.
    pub fn covers(&self, at: Point) -> bool {
        let near = distance(self.centre, at) <= self.radius;
        near && (self.outline.is_empty() || within(&self.outline, self.local(at)))
    }

    /// Whether the way from one point to another touches it.
    pub fn meets(&self, from: Point, to: Point) -> bool {
        if to_segment(self.centre, from, to) > self.radius {
            return false;
        }
        self.outline.is_empty()
            || within(&self.outline, self.local(from))
            || !self.crossings(from, to).is_empty()
    }

    /// The parts of the way from `a` to `b` between which it is in it.
    pub fn covered(&self, a: Point, b: Point) -> Option<(f64, f64)> {
        if !self.outline.is_empty() {
            let inside = |at: Point| within(&self.outline, self.local(at));
            let mut parts = self.crossings(a, b);
            parts.extend(inside(a).then_some(0.0));
            parts.extend(inside(b).then_some(1.0));
            let first = parts.iter().copied().fold(f64::INFINITY, f64::min);
            let last = parts.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            return (last > first).then_some((first, last));
        }
        let [x, y] = self.local(a).map(|d| -d);
        let length = distance(a, b);
        let [dx, dy] = [0, 1].map(|k| (b[k] - a[k]) / length);
        let nearest = x * dx + y * dy;
        let aside = x * dy - y * dx;
        let half = (self.radius * self.radius - aside * aside).sqrt();
        let [enters, leaves] =
            [nearest - half, nearest + half].map(|way| (way / length).clamp(0.0, 1.0));
        (leaves > enters).then_some((enters, leaves))
    }

    fn local(&self, at: Point) -> Point {
        [0, 1].map(|k| at[k] - self.centre[k])
    }

    /// The parts of the way between two points at which it crosses the outline.
    fn crossings(&self, from: Point, to: Point) -> Vec<f64> {
        let a = self.local(from);
        let b = self.local(to);
        let way = [b[0] - a[0], b[1] - a[1]];
        let crossing = |(c, d): (Point, Point)| {
            let along = [d[0] - c[0], d[1] - c[1]];
            let gap = [c[0] - a[0], c[1] - a[1]];
            let cross = |u: Point, v: Point| u[0] * v[1] - u[1] * v[0];
            let across = cross(way, along);
            let part = cross(gap, along) / across;
            let other = cross(gap, way) / across;
            ((0.0..=1.0).contains(&part) && (0.0..=1.0).contains(&other)).then_some(part)
        };
        self.outline.iter().flat_map(|ring| edges(ring)).filter_map(crossing).collect()
    }
}

/// The edges of a ring.
fn edges(ring: &[Point]) -> impl Iterator<Item = (Point, Point)> {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

/// Whether a point lies within rings: a ray from it crosses them more often one way than the other.
pub fn within(rings: &[Vec<Point>], at: Point) -> bool {
    let crosses = |(a, b): (Point, Point)| {
        let right = a[0] + (at[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
        match [a[1] > at[1], b[1] > at[1]] {
            _ if at[0] >= right => 0,
            [false, true] => 1,
            [true, false] => -1,
            _ => 0,
        }
    };
    rings.iter().flat_map(|ring| edges(ring)).map(crosses).sum::<i32>() != 0
}

/// Area within a ring, negative where it runs clockwise.
pub fn area(ring: &[Point]) -> f64 {
    edges(ring).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum()
}

/// The part of a ring and of the plane's edges that bounds what of it is in the plane.
pub fn in_plane(ring: Vec<Point>, size: [f64; 2]) -> Vec<Point> {
    [[1.0, 0.0, 0.0], [-1.0, 0.0, size[0]], [0.0, 1.0, 0.0], [0.0, -1.0, size[1]]]
        .into_iter()
        .fold(ring, clipped)
}

/// The part of a polygon where `m[0] x + m[1] y + m[2] > 0`.
pub fn clipped(ring: Vec<Point>, m: [f64; 3]) -> Vec<Point> {
    let depth = |point: Point| m[0] * point[0] + m[1] * point[1] + m[2];
    let sides = ring.iter().zip(ring.iter().cycle().skip(1)).flat_map(|(&a, &b)| {
        let inside = depth(a) > 0.0;
        let crosses = (depth(a) > 0.0) != (depth(b) > 0.0);
        let part = depth(a) / (depth(a) - depth(b));
        let crossing = [0, 1].map(|k| a[k] + part * (b[k] - a[k]));
        [inside.then_some(a), crosses.then_some(crossing)]
    });
    sides.flatten().collect()
}

/// Distance of a point from a segment.
fn to_segment(at: Point, from: Point, to: Point) -> f64 {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let [x, y] = [at[0] - from[0], at[1] - from[1]];
    let part = ((x * dx + y * dy) / (dx * dx + dy * dy).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    distance(at, [from[0] + part * dx, from[1] + part * dy])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The right angle with a quarter left out, about (1, 1).
    fn corner() -> Disc {
        let ring = [[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [-1.0, 1.0]];
        let outline = vec![ring.to_vec()];
        let radius = 2.0_f64.sqrt();
        Disc { centre: [1.0, 1.0], radius, outline, ..Disc::default() }
    }

    #[test]
    fn outline_covers_what_is_within_it() {
        let corner = corner();
        for (at, covered) in
            [([0.5, 0.5], true), ([1.5, 1.5], false), ([1.5, 0.5], true), ([3.0, 0.5], false)]
        {
            assert_eq!(corner.covers(at), covered, "{at:?}");
        }
        assert!(corner.meets([-1.0, 0.5], [3.0, 0.5]) && !corner.meets([1.2, 1.9], [1.9, 1.2]));
        assert_eq!(corner.covered([-1.0, 1.5], [3.0, 1.5]), Some((0.25, 0.5)));
        assert_eq!(corner.covered([0.5, 0.5], [0.5, 3.0]), Some((0.0, 0.6)));
        assert_eq!(corner.covered([1.5, 1.5], [1.8, 1.8]), None);
        assert!((corner.room() - 0.0).abs() < 1e-12);
    }

    #[test]
    fn rings_of_round_one_lie_on_its_rim() {
        let disc = Disc { centre: [0.3, 0.4], radius: 0.1, ..Disc::default() };
        let rings = disc.rings(20);
        assert_eq!((rings.len(), rings[0].len()), (1, 20));
        assert!(rings[0].iter().all(|at| (distance(*at, [0.3, 0.4]) - 0.1).abs() < 1e-12));
        assert_eq!(disc.room(), 0.1);
    }
}
