//! Sections of surfaces: what a plane cuts of a body or an obstacle, as rings.
//!
//! ```text
//!      /\  triangles, counterclockwise seen from outside: each that the plane cuts gives a segment
//!   --o--o------ plane    with the solid on its left, and segments that meet are joined to rings,
//!    /    \               outer ones counterclockwise
//! ```
//! In 2D a surface is made of such segments already. Balls that overlap give a circle each.

use mics_run::bodies::Pose;
use mics_run::config::{Case, Solid, Wall};
use mics_shapes::Core;
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// A point of a plane (m).
pub type Point = [f64; 2];

/// A triangle of a surface (m); in 2D a segment, the second corner twice.
pub type Triangle = [Vector3<f64>; 3];

/// Triangles along a body's length.
pub const ALONG: f64 = 48.0;
/// Largest distance of two ends that meet, relative to the size of the surface.
const MEETS: f64 = 1e-6;

/// A plane across one of the axes.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// The axes in the plane.
    pub axes: [usize; 2],
    /// The place of the plane on the third axis (m).
    pub height: f64,
    /// 2, where the plane holds the whole surface, or 3.
    pub dimension: usize,
}

impl Section {
    fn flat(&self, x: Vector3<f64>) -> Point {
        self.axes.map(|axis| x[axis])
    }

    /// The rings that the plane cuts of a surface of this size (m).
    fn rings(&self, triangles: impl Iterator<Item = Triangle>, size: f64) -> Vec<Vec<Point>> {
        joined(triangles.filter_map(|triangle| self.segment(&triangle)).collect(), MEETS * size)
    }

    /// The segment that the plane cuts of a triangle, the solid on its left.
    fn segment(&self, corners: &Triangle) -> Option<[Point; 2]> {
        if self.dimension == 2 {
            return Some([self.flat(corners[0]), self.flat(corners[1])]);
        }
        let across = 3 - self.axes[0] - self.axes[1];
        let height = corners.map(|corner| corner[across] - self.height);
        let mut ends = (0..3).filter_map(|a| {
            let b = (a + 1) % 3;
            // From below to above, so that two triangles find the same point of a common edge.
            let [low, high] = if height[a] < height[b] { [a, b] } else { [b, a] };
            (height[low] < 0.0 && height[high] >= 0.0).then(|| {
                let part = height[low] / (height[low] - height[high]);
                corners[low] + part * (corners[high] - corners[low])
            })
        });
        let [from, to] = [ends.next()?, ends.next()?].map(|x| self.flat(x));
        let out = self.flat((corners[1] - corners[0]).cross(&(corners[2] - corners[0])));
        let leaves = out[1] * (to[0] - from[0]) - out[0] * (to[1] - from[1]) > 0.0;
        Some(if leaves { [to, from] } else { [from, to] })
    }

    /// The rings of a solid, which is turned, about its centre, which lies in the origin.
    pub fn solid(&self, solid: &Solid, turn: &UnitQuaternion<f64>) -> Vec<Vec<Point>> {
        let geometry = solid.geometry();
        let balls = balls(solid);
        if !balls.is_empty() {
            let circle = |(place, radius)| self.circle(&(turn * place), radius);
            return balls.into_iter().filter_map(circle).collect();
        }
        let triangles = geometry.triangles(2.0 * geometry.radius() / ALONG).into_iter();
        self.rings(triangles.map(|corners| corners.map(|x| turn * x)), geometry.radius())
    }

    /// The circle that the plane cuts of a ball.
    fn circle(&self, centre: &Vector3<f64>, radius: f64) -> Option<Vec<Point>> {
        let across = 3 - self.axes[0] - self.axes[1];
        let off = if self.dimension == 2 { 0.0 } else { centre[across] - self.height };
        let square = radius * radius - off * off;
        let [x, y] = self.flat(*centre);
        let rim = |k: usize| {
            let (sin, cos) = (k as f64 / ALONG * TAU).sin_cos();
            [x + square.sqrt() * cos, y + square.sqrt() * sin]
        };
        (square > 0.0).then(|| (0..ALONG as usize).map(rim).collect())
    }

    /// The rings of an obstacle of a case, where it stands or in a pose, with its images across
    /// periodic sides.
    pub fn obstacle(&self, case: &Case, wall: &Wall, pose: Option<Pose>) -> Vec<Vec<Point>> {
        let size = case.domain.size.iter().copied().fold(0.0, f64::max);
        let images = closed_surfaces(case, wall, pose).into_iter();
        images.flat_map(|surface| self.rings(surface.into_iter(), size)).collect()
    }
}

/// The closed surface of an obstacle of a case, where it stands or in a pose, and those of its
/// images across periodic sides that reach into the box.
pub fn closed_surfaces(case: &Case, wall: &Wall, pose: Option<Pose>) -> Vec<Vec<Triangle>> {
    let own = |a: usize| wall.centre().get(a).copied().unwrap_or(0.0);
    let centre = pose.map_or_else(|| Vector3::from_fn(|a, _| own(a)), |pose| pose.centre.into());
    let turn = pose.and_then(|pose| pose.orientation).unwrap_or_default();
    let surface: Vec<Triangle> =
        wall.geometry().closed().map(|corners| corners.map(|x| centre + turn * x)).collect();
    let size = Vector3::from_fn(|a, _| case.domain.size.get(a).copied().unwrap_or(0.0));
    let ends = surface.iter().flatten().fold(
        [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)],
        |[low, high], x| [low.inf(x), high.sup(x)],
    );
    let images = |a: usize| {
        let reaches = move |k: &i32| {
            let way = f64::from(*k) * size[a];
            let room = MEETS * size[a];
            ends[0][a] + way < size[a] - room && ends[1][a] + way > room
        };
        let periodic = a < case.dimension() && case.periodic(a);
        (-1..=1).filter(move |k| *k == 0 || periodic && reaches(k))
    };
    let steps = images(0)
        .flat_map(|i| images(1).flat_map(move |j| images(2).map(move |k| Vector3::new(i, j, k))));
    let image = |step: Vector3<i32>| {
        let way = size.component_mul(&step.map(f64::from));
        surface.iter().map(|corners| corners.map(|x| x + way)).collect()
    };
    steps.map(image).collect()
}

/// The centres and radii (m) of the balls that a solid is made of; none of another one.
pub fn balls(solid: &Solid) -> Vec<(Vector3<f64>, f64)> {
    let parts = solid.geometry().parts();
    let all = parts.iter().all(|part| matches!(part.core, Core::Point));
    let balls = parts.iter().filter(|_| all);
    balls.map(|ball| (ball.place, ball.rounding)).collect()
}

/// Joins segments, each to one that begins where it ends, up to a distance (m), to rings.
fn joined(mut segments: Vec<[Point; 2]>, near: f64) -> Vec<Vec<Point>> {
    let apart = |a: Point, b: Point| (a[0] - b[0]).hypot(a[1] - b[1]);
    segments.retain(|[a, b]| apart(*a, *b) > 1e-3 * near);
    let mut rings = Vec::new();
    while let Some(first) = segments.pop() {
        let mut ring = VecDeque::from(first);
        while apart(ring[0], ring[ring.len() - 1]) > near {
            let begin = ring[0];
            let end = ring[ring.len() - 1];
            if let Some(k) = segments.iter().position(|[a, _]| apart(*a, end) <= near) {
                ring.push_back(segments.swap_remove(k)[1]);
            } else if let Some(k) = segments.iter().position(|[_, b]| apart(*b, begin) <= near) {
                ring.push_front(segments.swap_remove(k)[0]);
            } else {
                break;
            }
        }
        ring.pop_back();
        if ring.len() > 2 {
            rings.push(ring.into());
        }
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::area;

    fn case(dimension: usize, more: &str) -> Case {
        let [size, sides] = match dimension {
            2 => ["[2.0, 1.0]", ""],
            _ => ["[2.0, 1.0, 1.0]", "bottom = \"wall\"\ntop = \"wall\"\n"],
        };
        let cells = size.replace(".0", "00");
        mics_run::config::written(&format!(
            "name = \"t\"\ntime.end = 1.0\ndomain = {{ size = {size}, cells = {cells} }}\n\
            fluid = {{ density = 1.0, viscosity = 0.1 }}\n[boundary]\nwest = \"periodic\"\n\
            east = \"periodic\"\nsouth = \"wall\"\nnorth = \"wall\"\n{sides}{more}\n"
        ))
        .unwrap()
    }

    /// Number of the rings of a shape in 3D that is turned, and their areas together.
    fn of_shape(shape: &str, turn: UnitQuaternion<f64>, height: f64) -> (usize, f64) {
        let more = format!("[[particle]]\nshape = {{ {shape} }}\nposition = [1.0, 0.5, 0.5]");
        let case = case(3, &more);
        let section = Section { axes: [0, 1], height, dimension: 3 };
        let rings = section.solid(case.particle[0].shape.solid().unwrap(), &turn);
        (rings.len(), rings.iter().map(|ring| area(ring)).sum())
    }

    #[test]
    fn section_of_turned_cube_is_square_hexagon_or_nothing() {
        let corners: Vec<String> = (0..8)
            .map(|k| format!("{:?}", [0, 1, 2].map(|a| 0.1 * f64::from(2 * (k >> a & 1) - 1))))
            .collect();
        let cube = format!("polyhedron = {{ points = [{}] }}", corners.join(", "));
        let of = |turn: UnitQuaternion<f64>, height: f64| of_shape(&cube, turn, height);
        let (count, square) = of(UnitQuaternion::identity(), 0.03);
        assert!(count == 1 && (square - 0.04).abs() < 1e-12, "{square}");
        let up = UnitQuaternion::rotation_between(&Vector3::new(1.0, 1.0, 1.0), &Vector3::z());
        // Across the diagonal through its middle: of edge sqrt 2.
        let (count, hexagon) = of(up.unwrap(), 0.0);
        assert!(count == 1 && (hexagon - 0.03 * 3.0_f64.sqrt()).abs() < 1e-12, "{hexagon}");
        assert_eq!(of(UnitQuaternion::identity(), 0.11).0, 0);
    }

    #[test]
    fn section_of_every_curved_shape_runs_counterclockwise() {
        let turn = UnitQuaternion::from_euler_angles(0.4, -0.3, 0.9);
        for (shape, exact) in [
            ("ellipsoid = { axes = [0.2, 0.2, 0.2] }", 0.25 * std::f64::consts::PI * 0.04),
            ("superquadric = { axes = [0.2, 0.2, 0.2], exponents = [2.0, 2.0] }", 0.0314),
        ] {
            let (count, area) = of_shape(shape, turn, 0.0);
            assert!(count == 1 && (area / exact - 1.0).abs() < 0.02, "{shape}: {count}, {area}");
        }
        let two = "clump = { spheres = [{ at = [0, 0, 0], diameter = 0.2 }, \
            { at = [0.12, 0, 0], diameter = 0.2 }] }";
        assert_eq!(of_shape(two, UnitQuaternion::identity(), 0.05).0, 2);
    }

    #[test]
    fn solid_of_obstacle_is_that_of_outlines_and_surfaces() {
        let solid = |dimension: usize, obstacle: &str, axes: [usize; 2], height: f64| {
            let case = case(dimension, &format!("[[obstacle]]\n{obstacle}"));
            let section = Section { axes, height, dimension };
            let rings = section.obstacle(&case, case.obstacle[0].wall(), None);
            rings.iter().map(|ring| area(ring)).sum::<f64>()
        };
        let hole = "polygon = { outlines = [[[0, 0], [2, 0], [2, 1], [0, 1]], \
            [[0.5, 0.25], [1.5, 0.25], [1.5, 0.75], [0.5, 0.75]]] }";
        assert!((solid(2, hole, [0, 1], 0.0) - 1.5).abs() < 1e-9);
        // It passes the periodic side: what is beyond comes in on the other one.
        let passes = "polygon = { points = [[1.5, 0.2], [2.5, 0.2], [2.5, 0.6], [1.5, 0.6]] }";
        assert!((solid(2, passes, [0, 1], 0.0) - 0.8).abs() < 1e-9);
        let wedge = "surface = { points = [[0, -1, 0], [2, -1, 0], [2, 2, 0], [0, 2, 0], \
            [0, -1, 0.5], [0, 2, 0.5], [2, -1, 0.5], [2, 2, 0.5]], \
            triangles = [[0, 2, 1], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 1, 6], [0, 6, 4], \
            [3, 7, 2], [3, 5, 7], [0, 4, 5], [0, 5, 3], [1, 2, 7], [1, 7, 6]] }";
        // Whole: it goes on beyond the box along y.
        for (axes, height, exact) in [([0, 2], 0.5, 1.0), ([1, 2], 0.7, 1.5), ([0, 1], 0.3, 6.0)] {
            let area = solid(3, wedge, axes, height);
            assert!((area - exact).abs() < 1e-9, "{axes:?} {area}");
        }
        assert_eq!(solid(3, wedge, [0, 1], 0.7), 0.0);
    }
}
