//! Outlines of bodies that are not round, as a plane cuts them.
//!
//! ```text
//!      /\  triangles of the surface, turned with the body
//!   --o--o------ plane    each that the plane cuts gives a segment, and segments that meet are
//!    /    \               joined to rings
//! ```
//! In 2D the outline is made of segments already.

use mics_run::config::Solid;
use mics_shapes::Core;
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::TAU;

type Point = [f64; 2];

/// Triangles along a body's length.
const ALONG: f64 = 48.0;
/// Largest distance of two ends that meet, relative to the body's size.
const MEETS: f64 = 1e-6;

/// The surface of a solid in its own axes, as figures draw it.
pub enum Surface {
    /// Triangles; in 2D segments (m).
    Triangles(Vec<[Vector3<f64>; 3]>),
    /// Balls that overlap: their centres and radii (m).
    Balls(Vec<(Vector3<f64>, f64)>),
}

impl Surface {
    /// The surface of a solid.
    pub fn of(solid: &Solid) -> Surface {
        let geometry = solid.geometry();
        let balls = geometry
            .parts()
            .iter()
            .map(|part| matches!(part.core, Core::Point).then_some((part.place, part.rounding)));
        match balls.collect::<Option<Vec<_>>>() {
            Some(balls) if !balls.is_empty() => Surface::Balls(balls),
            _ => Surface::Triangles(geometry.triangles(2.0 * geometry.radius() / ALONG)),
        }
    }

    /// The rings that a plane cuts of the surface of a turned body, about its centre: along the
    /// `axes` of the plane, which is across the third and at the distance `off` from the centre
    /// (m); of a body of a `radius` (m) and so many dimensions.
    pub fn rings(
        &self,
        turn: &UnitQuaternion<f64>,
        axes: [usize; 2],
        off: f64,
        dimension: usize,
        radius: f64,
    ) -> Vec<Vec<Point>> {
        let flat = |v: Vector3<f64>| axes.map(|axis| v[axis]);
        let across = 3 - axes[0] - axes[1];
        let segments = match self {
            Surface::Balls(balls) => {
                let circle = |(place, r): &(Vector3<f64>, f64)| {
                    let centre = turn * place;
                    let height = if dimension == 2 { 0.0 } else { centre[across] - off };
                    let square = r * r - height * height;
                    (square > 0.0).then(|| (flat(centre), square.sqrt()))
                };
                union(&balls.iter().filter_map(circle).collect::<Vec<_>>())
            }
            Surface::Triangles(triangles) => {
                let segment = |triangle: &[Vector3<f64>; 3]| {
                    let corners = triangle.map(|corner| turn * corner);
                    if dimension == 2 {
                        return Some([flat(corners[0]), flat(corners[1])]);
                    }
                    cut(&corners, across, off).map(|ends| ends.map(flat))
                };
                triangles.iter().filter_map(segment).collect()
            }
        };
        joined(segments, MEETS * radius)
    }
}

/// The outline of the union of circles, by segments.
fn union(circles: &[(Point, f64)]) -> Vec<[Point; 2]> {
    let mut segments = Vec::new();
    for (k, &(centre, radius)) in circles.iter().enumerate() {
        let others = || circles.iter().enumerate().filter(move |(j, _)| *j != k);
        // Where the others cross it, as angles.
        let mut ends: Vec<f64> =
            others().flat_map(|(_, other)| crossings(centre, radius, other.0, other.1)).collect();
        ends.extend(ends.is_empty().then_some(0.0));
        ends.sort_by(f64::total_cmp);
        let on = |angle: f64| [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()];
        for (i, from) in ends.iter().enumerate() {
            let to = ends.get(i + 1).copied().unwrap_or(ends[0] + TAU);
            let middle = on(0.5 * (from + to));
            let covered = others().any(|(j, (at, r))| {
                let gap = (middle[0] - at[0]).hypot(middle[1] - at[1]) - r;
                // The first counts of two that are the same.
                gap < -1e-9 * r || (gap <= 1e-9 * r && j < k)
            });
            if covered {
                continue;
            }
            let count = ((to - from) / TAU * ALONG).ceil().max(1.0) as usize;
            let at = |n: usize| on(from + (to - from) * n as f64 / count as f64);
            segments.extend((0..count).map(|n| [at(n), at(n + 1)]));
        }
    }
    segments
}

/// The angles on a circle about `a` of radius r at which one about `b` of radius s crosses it.
fn crossings(a: Point, r: f64, b: Point, s: f64) -> Vec<f64> {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let distance = dx.hypot(dy);
    let cosine = (distance * distance + r * r - s * s) / (2.0 * distance * r);
    if cosine.is_nan() || cosine.abs() >= 1.0 {
        return Vec::new();
    }
    let towards = dy.atan2(dx);
    let aside = cosine.acos();
    [towards - aside, towards + aside].map(|angle| angle.rem_euclid(TAU)).to_vec()
}

/// The segment in which a triangle meets the plane at `off` along an axis.
pub fn cut(corners: &[Vector3<f64>; 3], axis: usize, off: f64) -> Option<[Vector3<f64>; 2]> {
    let height = corners.map(|corner| corner[axis] - off);
    let mut ends = (0..3).filter_map(|k| {
        let a = k;
        let b = (k + 1) % 3;
        // From below to above, so that two triangles find the same point of the edge they share.
        let (low, high) = if height[a] < height[b] { (a, b) } else { (b, a) };
        ((height[low] < 0.0) && (height[high] >= 0.0)).then(|| {
            let part = height[low] / (height[low] - height[high]);
            corners[low] + part * (corners[high] - corners[low])
        })
    });
    Some([ends.next()?, ends.next()?])
}

/// Joins segments whose ends are less than `near` apart (m) to rings.
fn joined(mut segments: Vec<[Point; 2]>, near: f64) -> Vec<Vec<Point>> {
    let apart = |a: Point, b: Point| (a[0] - b[0]).hypot(a[1] - b[1]);
    segments.retain(|[a, b]| apart(*a, *b) > 1e-3 * near);
    let mut rings = Vec::new();
    while let Some([first, mut end]) = segments.pop() {
        let mut ring = vec![first];
        // The segment that begins or ends nearest to where the ring has come to.
        while apart(end, first) > near {
            let next = segments.iter().enumerate().map(|(k, ends)| {
                let [a, b] = ends.map(|at| apart(at, end));
                if a <= b { (a, k, ends[1]) } else { (b, k, ends[0]) }
            });
            let Some((way, k, far)) = next.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            if way > near {
                break;
            }
            ring.push(end);
            segments.swap_remove(k);
            end = far;
        }
        if ring.len() > 2 {
            rings.push(ring);
        }
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The surface of a cube of 2 m by 12 triangles.
    fn cube() -> Vec<[Vector3<f64>; 3]> {
        let mut all = Vec::new();
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let corner = |u: f64, v: f64| {
                    let mut at = Vector3::zeros();
                    at[axis] = side;
                    at[(axis + 1) % 3] = u;
                    at[(axis + 2) % 3] = v;
                    at
                };
                let [a, b, c, d] =
                    [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                all.extend([[a, b, c], [a, c, d]]);
            }
        }
        all
    }

    fn area(ring: &[Point]) -> f64 {
        let next = ring.iter().cycle().skip(1);
        0.5 * ring.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>().abs()
    }

    #[test]
    fn section_of_turned_cube_is_square_hexagon_or_nothing() {
        let radius = 3.0_f64.sqrt();
        let cube = Surface::Triangles(cube());
        let of = |turn: UnitQuaternion<f64>, off: f64| cube.rings(&turn, [0, 1], off, 3, radius);
        let square = of(UnitQuaternion::identity(), 0.3);
        assert_eq!((square.len(), area(&square[0])), (1, 4.0));
        let up = UnitQuaternion::rotation_between(&Vector3::new(1.0, 1.0, 1.0), &Vector3::z());
        let hexagon = of(up.unwrap(), 0.0);
        // Across the diagonal through its middle: of edge sqrt 2.
        assert_eq!(hexagon.len(), 1);
        assert!((area(&hexagon[0]) - 3.0 * 3.0_f64.sqrt()).abs() < 1e-9, "{hexagon:?}");
        assert!(of(UnitQuaternion::identity(), 1.1).is_empty());
        let quarter =
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.25 * std::f64::consts::PI);
        let across = cube.rings(&quarter, [0, 1], 0.0, 3, radius);
        assert!((area(&across[0]) - 4.0 * 2.0_f64.sqrt()).abs() < 1e-9, "{across:?}");
    }

    #[test]
    fn two_pieces_are_two_rings() {
        let square = |x: f64| {
            let at = move |k: usize| {
                let (i, j) = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)][k % 4];
                [x + i, j]
            };
            (0..4).map(move |k| [at(k), at(k + 1)])
        };
        let rings = joined(square(0.0).chain(square(3.0)).collect(), 1e-6);
        assert_eq!(rings.iter().map(|ring| area(ring)).collect::<Vec<_>>(), [1.0, 1.0]);
    }

    #[test]
    fn section_of_clump_is_outline_of_union() {
        let balls = [(Vector3::zeros(), 1.0), (Vector3::x() * 1.2, 1.0), (Vector3::x() * 0.1, 0.5)];
        let clump = Surface::Balls(balls.to_vec());
        let rings = clump.rings(&UnitQuaternion::identity(), [0, 1], 0.0, 2, 2.0);
        // Two circles less their lens, by polygons of 48 corners.
        let lens = 2.0 * 0.6_f64.acos() - 1.2 * 0.8;
        let exact = TAU - lens;
        assert_eq!(rings.len(), 1);
        assert!((area(&rings[0]) / exact - 1.0).abs() < 4e-3, "{} {exact}", area(&rings[0]));
        // Higher up they part.
        let above = clump.rings(&UnitQuaternion::identity(), [0, 1], 0.9, 3, 2.0);
        assert_eq!(above.len(), 2);
        let turned = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.25 * TAU);
        let end_on = clump.rings(&turned, [0, 1], 0.0, 3, 2.0);
        assert_eq!(end_on.len(), 1);
    }
}
