//! Outlines of bodies that are not round, as a plane cuts them.
//!
//! ```text
//!      /\  triangles of the surface, turned with the body
//!   --o--o------ plane    each that the plane cuts gives a segment, and segments that meet are
//!    /    \               joined to rings
//! ```
//! In 2D the outline is made of segments already.

use mics_run::config::Solid;
use nalgebra::{UnitQuaternion, Vector3};

type Point = [f64; 2];

/// Triangles along a body's length.
const ALONG: f64 = 48.0;
/// How far apart two ends that meet may be, of a body's size.
const MEETS: f64 = 1e-6;

/// The surface of a solid by triangles in its own axes, in 2D by segments (m), as figures draw it.
pub fn surface(solid: &Solid) -> Vec<[Vector3<f64>; 3]> {
    let geometry = solid.geometry();
    geometry.triangles(2.0 * geometry.radius() / ALONG)
}

/// The rings that a plane cuts of a turned surface, about the body's centre: along the `axes` of
/// the plane, which is across the third and at the distance `off` from the centre (m); of a solid
/// of radius `radius` (m) and so many dimensions.
pub fn rings(
    surface: &[[Vector3<f64>; 3]],
    turn: &UnitQuaternion<f64>,
    axes: [usize; 2],
    off: f64,
    (dimension, radius): (usize, f64),
) -> Vec<Vec<Point>> {
    let flat = |v: Vector3<f64>| axes.map(|axis| v[axis]);
    let segments = surface.iter().filter_map(|triangle| {
        let corners = triangle.map(|corner| turn * corner);
        if dimension == 2 {
            return Some([flat(corners[0]), flat(corners[1])]);
        }
        cut(&corners, 3 - axes[0] - axes[1], off).map(|ends| ends.map(flat))
    });
    joined(segments.collect(), MEETS * radius)
}

/// The segment in which a triangle meets the plane at `off` along an axis.
fn cut(corners: &[Vector3<f64>; 3], axis: usize, off: f64) -> Option<[Vector3<f64>; 2]> {
    let height = corners.map(|corner| corner[axis] - off);
    let mut ends = (0..3).filter_map(|k| {
        let (a, b) = (k, (k + 1) % 3);
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
                    (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (side, u, v);
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
        let size = (3, 3.0_f64.sqrt());
        let of = |turn: UnitQuaternion<f64>, off: f64| rings(&cube(), &turn, [0, 1], off, size);
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
        let across = rings(&cube(), &quarter, [0, 1], 0.0, size);
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
}
