//! A convex polygon, the section of a prism along z, of unit depth; its corners may be rounded.
//!
//! ```text
//!      .---------.      the core is the polygon with its sides moved in by the rounding r, and
//!     ( +-------+ )     the body all that is within r of it: what a disc of the radius r sweeps
//!     | |  core | |     that moves within the polygon. The sides stay where they are. A side that
//!     ( +-------+ )     such a disc does not reach is rounded off.
//!      '---------'
//! ```

use crate::boxes::rim;
use crate::surface::moments::Moments;
use crate::{Core, Face, Fault, Lattice, Nearest, Part, Polytope, Shape, SurfacePoint, Tile};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Part of the depth of the centre that contacts take as the thickness of the skin of a body with
/// sharp edges.
pub const SKIN: f64 = 0.05;

/// A side of the core.
#[derive(Clone, Debug)]
struct Side {
    from: Vector2<f64>,
    along: Vector2<f64>,
    length: f64,
    normal: Vector2<f64>,
    offset: f64,
}

/// A convex polygon (2D).
#[derive(Clone, Debug)]
pub struct Polygon {
    rounding: f64,
    sides: Vec<Side>,
    radius: f64,
    moments: Moments,
    parts: Vec<Part>,
}

impl Polygon {
    /// A polygon of these corners (m), in either order, with corners rounded to this radius (m); it
    /// is moved so that its centre of volume is the origin.
    ///
    /// # Errors
    ///
    /// There are fewer than three corners, one is no place, one is concave, the sides cross, the
    /// area is none, or the rounding leaves nothing.
    pub fn new(points: &[[f64; 2]], rounding: f64) -> Result<Polygon, Fault> {
        let corners = convex_corners(points)?;
        if !(rounding.is_finite() && rounding >= 0.0) {
            return Err(Fault(format!("the rounding {rounding} m is no length")));
        }
        let core = inset(&corners, rounding);
        if core.len() < 3 {
            let why =
                format!("the rounding {rounding} m is as large as the polygon's inner radius");
            return Err(Fault(why));
        }
        let mut body = Polygon::around(&core, rounding);
        let centroid = body.moments.first / body.moments.area;
        let moved: Vec<_> = core.iter().map(|corner| corner - centroid).collect();
        body = Polygon::around(&moved, rounding);
        let inner = body.sides.iter().map(|side| side.offset).fold(f64::INFINITY, f64::min);
        body.finish(inner + rounding);
        Ok(body)
    }

    /// About a core of these corners (m).
    fn around(core: &[Vector2<f64>], rounding: f64) -> Polygon {
        let n = core.len();
        let side = |k: usize| {
            let from = core[k];
            let way = core[(k + 1) % n] - core[k];
            let along = way.normalize();
            let length = way.norm();
            let normal = Vector2::new(along.y, -along.x);
            Side { from, along, length, normal, offset: normal.dot(&from) }
        };
        let sides: Vec<Side> = (0..n).map(side).collect();
        let mut moments = Moments::default();
        for (k, side) in sides.iter().enumerate() {
            let end = core[(k + 1) % n];
            let out = rounding * side.normal;
            moments.add_side(&(side.from + out), &(end + out));
            moments.add_arc(&end, rounding, &side.normal, &sides[(k + 1) % n].normal);
        }
        let reach = core.iter().map(|corner| corner.norm()).fold(0.0, f64::max);
        Polygon { rounding, sides, radius: reach + rounding, moments, parts: Vec::new() }
    }

    /// Finds its part, by the depth of its centre (m).
    fn finish(&mut self, depth: f64) {
        let skin = if self.rounding > 0.0 { self.rounding } else { SKIN * depth };
        let core: Vec<Vector2<f64>> = self.sides.iter().map(|side| side.from).collect();
        let core = if self.rounding > 0.0 { core } else { inset(&core, skin) };
        let flat = Polygon::around(&core, skin);
        let face = |(k, side): (usize, &Side)| Face {
            normal: Vector3::new(side.normal.x, side.normal.y, 0.0),
            corners: vec![k as u32, ((k + 1) % core.len()) as u32],
        };
        let polytope = Polytope::new(
            core.iter().map(|corner| Vector3::new(corner.x, corner.y, 0.0)).collect(),
            flat.sides.iter().enumerate().map(face).collect(),
        );
        let core = Core::Polytope(polytope);
        self.parts =
            vec![Part { place: Vector3::zeros(), core, rounding: skin, radius: flat.radius }];
    }

    /// The distance of a point from the core, and the normal there.
    fn core_distance(&self, point: &Vector2<f64>) -> (f64, Vector2<f64>) {
        let mut inside = (f64::NEG_INFINITY, Vector2::x());
        let mut outside = (f64::INFINITY, Vector2::x());
        for side in &self.sides {
            let above = side.normal.dot(point) - side.offset;
            if above > inside.0 {
                inside = (above, side.normal);
            }
            if above > 0.0 {
                let t = side.along.dot(&(point - side.from)).clamp(0.0, side.length);
                let arm = point - side.from - t * side.along;
                let square = arm.norm_squared();
                if square < outside.0 {
                    let length = square.sqrt();
                    let exact = t > 0.0 && t < side.length;
                    let normal = if exact || length == 0.0 { side.normal } else { arm / length };
                    outside = (square, normal);
                }
            }
        }
        if inside.0 <= 0.0 { inside } else { (outside.0.sqrt(), outside.1) }
    }
}

/// The corners of a polygon with its sides moved in (m); fewer than three where nothing is left.
fn inset(corners: &[Vector2<f64>], way: f64) -> Vec<Vector2<f64>> {
    let size = corners.iter().map(|corner| corner.norm()).fold(0.0, f64::max);
    let mut left = corners.to_vec();
    if way > 0.0 {
        let n = corners.len();
        for k in 0..n {
            let along = (corners[(k + 1) % n] - corners[k]).normalize();
            let normal = Vector2::new(along.y, -along.x);
            left = cut(&left, &normal, normal.dot(&corners[k]) - way);
        }
    }
    merged(left, 1e-9 * size)
}

/// The part of a convex polygon (m) below a line, `n.x <= offset`.
fn cut(corners: &[Vector2<f64>], n: &Vector2<f64>, offset: f64) -> Vec<Vector2<f64>> {
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (k, to) in corners.iter().enumerate() {
        let from = corners[(k + corners.len() - 1) % corners.len()];
        let [below, next] = [from, *to].map(|x| n.dot(&x) - offset);
        if (below <= 0.0) != (next <= 0.0) {
            kept.push(from + below / (below - next) * (to - from));
        }
        if next <= 0.0 {
            kept.push(*to);
        }
    }
    kept
}

/// The corners (m) without those that lie on the one before (closer than `distance`, m).
fn merged(mut corners: Vec<Vector2<f64>>, distance: f64) -> Vec<Vector2<f64>> {
    let mut last = corners.last().copied().unwrap_or_default();
    corners.retain(|corner| {
        let is_apart = (corner - last).norm() > distance;
        last = if is_apart { *corner } else { last };
        is_apart
    });
    corners
}

/// The corners of a convex polygon, counterclockwise, without those on straight sides.
fn convex_corners(points: &[[f64; 2]]) -> Result<Vec<Vector2<f64>>, Fault> {
    for (k, [x, y]) in points.iter().enumerate() {
        if !(x.is_finite() && y.is_finite()) {
            return Err(Fault(format!("corner {} of the polygon, ({x}, {y}), is no place", k + 1)));
        }
    }
    let all: Vec<Vector2<f64>> = points.iter().map(|p| Vector2::new(p[0], p[1])).collect();
    let Some(first) = all.first() else {
        return Err(Fault("a polygon needs three corners".to_owned()));
    };
    let size = all.iter().map(|corner| (corner - first).norm()).fold(0.0, f64::max);
    let mut corners = merged(all.iter().map(|corner| corner - first).collect(), 1e-9 * size);
    let next = |k: usize| corners[(k + 1) % corners.len()];
    let area = (0..corners.len()).map(|k| 0.5 * corners[k].perp(&next(k))).sum::<f64>();
    if corners.len() < 3 || area.abs() <= 1e-9 * size * size {
        let why =
            format!("a polygon needs three corners that are no line, and has {}", points.len());
        return Err(Fault(why));
    }
    if area < 0.0 {
        corners.reverse();
    }
    let n = corners.len();
    let mut turned = 0.0;
    let turn = |k: usize| {
        let way = |k: usize| (corners[(k + 1) % n] - corners[k % n]).normalize();
        let [before, after] = [way(k + n - 1), way(k)];
        before.perp(&after).atan2(before.dot(&after))
    };
    let turns: Vec<f64> = (0..n).map(turn).collect();
    for (corner, turn) in corners.iter().zip(&turns) {
        turned += turn;
        if *turn < -1e-7 {
            let place = corner + first;
            let why = format!(
                "the polygon is not convex: its corner ({}, {}) points inwards; make a clump of \
                 convex bodies of it, or take its hull",
                place.x, place.y
            );
            return Err(Fault(why));
        }
    }
    if turned > 1.5 * std::f64::consts::TAU {
        return Err(Fault("the sides of the polygon cross".to_owned()));
    }
    let kept = corners.iter().zip(&turns).filter(|(_, turn)| **turn > 1e-7);
    Ok(kept.map(|(corner, _)| corner + first).collect())
}

impl Shape for Polygon {
    fn dimension(&self) -> usize {
        2
    }

    fn radius(&self) -> f64 {
        self.radius
    }

    fn volume(&self) -> f64 {
        self.moments.area
    }

    fn inertia(&self) -> Matrix3<f64> {
        self.moments.inertia()
    }

    fn thickness(&self) -> f64 {
        let width = |side: &Side| {
            let n = Vector3::new(side.normal.x, side.normal.y, 0.0);
            self.extent(&n) + self.extent(&-n)
        };
        self.sides.iter().map(width).fold(f64::INFINITY, f64::min)
    }

    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let (distance, normal) = self.core_distance(&point.xy());
        let normal = Vector3::new(normal.x, normal.y, 0.0);
        Nearest { distance: distance - self.rounding, normal }
    }

    /// Inside exact.
    fn clearance(&self, point: &Vector3<f64>) -> Option<f64> {
        self.plane(point).map(|plane| plane.distance)
    }

    /// The side that it is furthest above.
    fn plane(&self, point: &Vector3<f64>) -> Option<Nearest> {
        let above = |side: &Side| side.normal.dot(&point.xy()) - side.offset;
        let side = self.sides.iter().max_by(|a, b| above(a).total_cmp(&above(b)))?;
        Some(Nearest { distance: above(side) - self.rounding, normal: side.normal.push(0.0) })
    }

    fn feet(&self, point: &Vector3<f64>, within: f64, feet: &mut Vec<Nearest>) {
        feet.clear();
        for side in &self.sides {
            let distance = side.normal.dot(&point.xy()) - side.offset - self.rounding;
            let along = side.along.dot(&(point.xy() - side.from));
            let slack = 1e-9 * side.length;
            if distance < 0.0
                && -distance <= within
                && (-slack..=side.length + slack).contains(&along)
            {
                feet.push(Nearest { distance, normal: side.normal.push(0.0) });
            }
        }
    }

    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let mut all = Vec::new();
        let flat = |x: Vector2<f64>| Vector3::new(x.x, x.y, 0.0);
        let n = self.sides.len();
        for (k, side) in self.sides.iter().enumerate() {
            let count = (2.0 * side.length / spacing).ceil().max(1.0) as usize;
            for i in 0..count {
                let t = (i as f64 + 0.5) / count as f64 * side.length;
                let place = flat(side.from + t * side.along + self.rounding * side.normal);
                let area = side.length / count as f64;
                all.push(SurfacePoint { place, normal: flat(side.normal), area });
            }
            let before = self.sides[(k + n - 1) % n].normal;
            let angle = before.perp(&side.normal).atan2(before.dot(&side.normal));
            let length = angle * self.rounding;
            let count = (2.0 * length / spacing).ceil().max(1.0) as usize;
            for i in (0..count).filter(|_| length > 0.0) {
                let (sin, cos) = ((i as f64 + 0.5) / count as f64 * angle).sin_cos();
                let normal = cos * before + sin * Vector2::new(-before.y, before.x);
                let place = flat(side.from + self.rounding * normal);
                all.push(SurfacePoint { place, normal: flat(normal), area: length / count as f64 });
            }
        }
        all
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        let reach = self.sides.iter().map(|side| side.from.dot(&n.xy()));
        reach.fold(f64::NEG_INFINITY, f64::max) + self.rounding * n.xy().norm()
    }

    fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        let Lattice { factor, orientation: turn, planes, .. } = lattice;
        let turn = turn.matrix().fixed_view::<2, 2>(0, 0);
        let n = self.sides.len();
        let rounding = factor * self.rounding;
        rim::tile(planes, found, |rim, planes| {
            for (k, side) in self.sides.iter().enumerate() {
                let next = &self.sides[(k + 1) % n];
                let [from, to] = [side, next].map(|side| turn * (*factor * side.from));
                let normals = [side, next].map(|side| turn * side.normal);
                let out = rounding * normals[0];
                rim.add_side(planes, &(from + out), &(to + out));
                if rounding > 0.0 {
                    let round = rim::Stretched::new(to, Matrix2::from_diagonal_element(rounding));
                    rim.add_arc(planes, &round, &normals[0], &normals[1]);
                }
            }
        });
    }

    fn parts(&self) -> &[Part] {
        &self.parts
    }

    fn triangles(&self, spacing: f64) -> Vec<[Vector3<f64>; 3]> {
        let flat = |x: Vector2<f64>| Vector3::new(x.x, x.y, 0.0);
        let mut round = Vec::new();
        let n = self.sides.len();
        for (k, side) in self.sides.iter().enumerate() {
            let before = self.sides[(k + n - 1) % n].normal;
            let angle = before.perp(&side.normal).atan2(before.dot(&side.normal));
            let count = (angle * self.rounding / spacing).ceil() as usize;
            for i in 0..=count {
                let (sin, cos) = (angle * i as f64 / count.max(1) as f64).sin_cos();
                let normal = cos * before + sin * Vector2::new(-before.y, before.x);
                round.push(flat(side.from + self.rounding * normal));
            }
        }
        let next = |k: usize| round[(k + 1) % round.len()];
        (0..round.len()).map(|k| [round[k], next(k), next(k)]).collect()
    }
}

#[cfg(test)]
mod tests;
