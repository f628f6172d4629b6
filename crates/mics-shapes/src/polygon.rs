//! A convex polygon, the section of a prism along z, of unit depth; its corners may be rounded.
//!
//! ```text
//!      .---------.      the core is the polygon with its sides moved in by the rounding r, and
//!     ( +-------+ )     the body all that is within r of it: what a disc of the radius r sweeps
//!     | |  core | |     that moves within the polygon. The sides stay where they are. A side that
//!     ( +-------+ )     such a disc does not reach is rounded off.
//!      '---------'
//! ```

use super::flat::Flat;
use super::{Core, Face, Fault, Geometry, Nearest, Part, Patch, Polytope, Tile, disc, rim};
use nalgebra::{Matrix2, Matrix3, Rotation3, Vector2, Vector3};
use std::cell::RefCell;

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
    /// Of each corner of the core where the sides beside it meet outside (m).
    tips: Vec<Vector2<f64>>,
    radius: f64,
    area: f64,
    inertia: f64,
    second: Matrix2<f64>,
    parts: Vec<Part>,
}

thread_local! {
    static ROOM: RefCell<Flat> = RefCell::new(Flat::new(Vec::with_capacity(256)));
}

impl Polygon {
    /// Of these corners (m), in either order, with corners rounded to this radius (m); it is moved
    /// so that its centre of volume is the origin.
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
        let far = 4.0 * core.iter().map(|corner| corner.norm()).fold(rounding, f64::max);
        let everything = [0, 1, 2].map(|a| Vector3::ith(a, far));
        let (area, first) = body.filled(&Vector3::zeros(), &everything);
        let centroid = (first / area).xy();
        let moved: Vec<_> = core.iter().map(|corner| corner - centroid).collect();
        body = Polygon::around(&moved, rounding);
        body.area = area;
        let inner = body.sides.iter().map(|side| side.offset).fold(f64::INFINITY, f64::min);
        body.finish(inner + rounding);
        Ok(body)
    }

    /// About a core of these corners (m).
    fn around(core: &[Vector2<f64>], rounding: f64) -> Polygon {
        let n = core.len();
        let side = |k: usize| {
            let (from, way) = (core[k], core[(k + 1) % n] - core[k]);
            let (along, length) = (way.normalize(), way.norm());
            let normal = Vector2::new(along.y, -along.x);
            Side { from, along, length, normal, offset: normal.dot(&from) }
        };
        let sides: Vec<Side> = (0..n).map(side).collect();
        let tip = |k: usize| {
            let [before, after] = [sides[(k + n - 1) % n].normal, sides[k].normal];
            core[k] + rounding / (1.0 + before.dot(&after)) * (before + after)
        };
        let tips = (0..n).map(tip).collect();
        let reach = core.iter().map(|corner| corner.norm()).fold(0.0, f64::max);
        Polygon {
            rounding,
            sides,
            tips,
            radius: reach + rounding,
            area: 0.0,
            inertia: 0.0,
            second: Matrix2::zeros(),
            parts: Vec::new(),
        }
    }

    /// Finds its moments of inertia and its part, by the depth of its centre (m).
    fn finish(&mut self, depth: f64) {
        let mut whole = Flat::new(self.tips.clone());
        let mut second = whole.second_moments();
        for (k, kite) in (0..self.sides.len()).map(|k| (k, self.kite(k))) {
            if self.rounding == 0.0 {
                break;
            }
            whole.set(kite);
            let (from, own) =
                (self.sides[k].from, disc::moments(&kite, &self.sides[k].from, self.rounding));
            let arm = own.1 - own.0 * from;
            let round = disc::second_moments(&kite, &from, self.rounding);
            let cross = from * arm.transpose();
            second += round + cross + cross.transpose() + own.0 * from * from.transpose();
            second -= whole.second_moments();
        }
        (self.second, self.inertia) = (second, second.trace());
        let skin = if self.rounding > 0.0 { self.rounding } else { SKIN * depth };
        let core: Vec<Vector2<f64>> = if self.rounding > 0.0 {
            self.sides.iter().map(|side| side.from).collect()
        } else {
            inset(&self.tips, skin)
        };
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

    /// The corners of what the sides leave beside the corner k of the core, between the feet of its
    /// perpendiculars on them (m).
    fn kite(&self, k: usize) -> [Vector2<f64>; 4] {
        let n = self.sides.len();
        let [before, after] = [&self.sides[(k + n - 1) % n], &self.sides[k]];
        let from = after.from;
        let foot = |side: &Side| from + self.rounding * side.normal;
        [from, foot(before), self.tips[k], foot(after)]
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
    let mut flat = Flat::new(corners.to_vec());
    if way > 0.0 {
        let n = corners.len();
        for k in 0..n {
            let along = (corners[(k + 1) % n] - corners[k]).normalize();
            let normal = Vector2::new(along.y, -along.x);
            flat.cut(&normal, normal.dot(&corners[k]) - way);
        }
    }
    flat.merge(1e-9 * size);
    flat.corners().to_vec()
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
    let mut flat = Flat::new(all.iter().map(|corner| corner - first).collect());
    flat.merge(1e-9 * size);
    let mut corners = flat.corners().to_vec();
    let area = flat.moments().0;
    if corners.len() < 3 || area.abs() <= 1e-9 * size * size {
        let why =
            format!("a polygon needs three corners that are no line, and has {}", points.len());
        return Err(Fault(why));
    }
    if area < 0.0 {
        corners.reverse();
    }
    let (n, mut turned) = (corners.len(), 0.0);
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

impl Geometry for Polygon {
    fn dimension(&self) -> usize {
        2
    }

    fn radius(&self) -> f64 {
        self.radius
    }

    fn volume(&self) -> f64 {
        self.area
    }

    fn inertia(&self) -> Matrix3<f64> {
        let s = &self.second;
        let (xx, yy, xy) = (s[(0, 0)], s[(1, 1)], s[(0, 1)]);
        Matrix3::new(yy, -xy, 0.0, -xy, xx, 0.0, 0.0, 0.0, self.inertia)
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

    fn surface(&self, spacing: f64) -> Vec<Patch> {
        let mut all = Vec::new();
        let flat = |x: Vector2<f64>| Vector3::new(x.x, x.y, 0.0);
        let n = self.sides.len();
        for (k, side) in self.sides.iter().enumerate() {
            let count = (2.0 * side.length / spacing).ceil().max(1.0) as usize;
            for i in 0..count {
                let t = (i as f64 + 0.5) / count as f64 * side.length;
                let place = flat(side.from + t * side.along + self.rounding * side.normal);
                let area = side.length / count as f64;
                all.push(Patch { place, normal: flat(side.normal), area });
            }
            let before = self.sides[(k + n - 1) % n].normal;
            let angle = before.perp(&side.normal).atan2(before.dot(&side.normal));
            let length = angle * self.rounding;
            let count = (2.0 * length / spacing).ceil().max(1.0) as usize;
            for i in (0..count).filter(|_| length > 0.0) {
                let (sin, cos) = ((i as f64 + 0.5) / count as f64 * angle).sin_cos();
                let normal = cos * before + sin * Vector2::new(-before.y, before.x);
                let place = flat(side.from + self.rounding * normal);
                all.push(Patch { place, normal: flat(normal), area: length / count as f64 });
            }
        }
        all
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        let reach = self.sides.iter().map(|side| side.from.dot(&n.xy()));
        reach.fold(f64::NEG_INFINITY, f64::max) + self.rounding * n.xy().norm()
    }

    /// Exact: the sides cut the box, and of each corner only what its disc fills counts.
    fn filled(&self, middle: &Vector3<f64>, half: &[Vector3<f64>; 3]) -> (f64, Vector3<f64>) {
        let [at, a, b] = [middle.xy(), half[0].xy(), half[1].xy()];
        let reach = (a.norm_squared() + b.norm_squared()).sqrt();
        ROOM.with_borrow_mut(|room| {
            room.set_box(middle, half);
            for side in &self.sides {
                let offset = side.offset + self.rounding;
                if side.normal.dot(&at) + reach > offset {
                    room.cut(&side.normal, offset);
                }
            }
            let (mut area, mut first) = room.moments();
            for k in (0..self.sides.len()).filter(|_| self.rounding > 0.0) {
                let kite = self.kite(k);
                let from = kite[0];
                if (from - at).norm() > reach + (self.tips[k] - from).norm() {
                    continue;
                }
                room.set_box(middle, half);
                for i in 0..4 {
                    let along = kite[(i + 1) % 4] - kite[i];
                    let normal = Vector2::new(along.y, -along.x);
                    room.cut(&normal, normal.dot(&kite[i]));
                }
                let (whole, inside) =
                    (room.moments(), disc::moments(room.corners(), &from, self.rounding));
                area += inside.0 - whole.0;
                first += inside.1 - whole.1;
            }
            (area, Vector3::new(first.x, first.y, 0.0))
        })
    }

    fn tile(
        &self,
        factor: f64,
        turn: &Rotation3<f64>,
        planes: &[Vec<f64>; 3],
        found: &mut dyn FnMut(&Tile),
    ) -> bool {
        let turn = turn.matrix().fixed_view::<2, 2>(0, 0);
        let (n, rounding) = (self.sides.len(), factor * self.rounding);
        rim::tile(planes, found, |rim, planes| {
            for (k, side) in self.sides.iter().enumerate() {
                let next = &self.sides[(k + 1) % n];
                let [from, to] = [side, next].map(|side| turn * (factor * side.from));
                let normals = [side, next].map(|side| turn * side.normal);
                let out = rounding * normals[0];
                rim.add_side(planes, &(from + out), &(to + out));
                if rounding > 0.0 {
                    let round = rim::Stretched::new(to, Matrix2::from_diagonal_element(rounding));
                    rim.add_arc(planes, &round, &normals[0], &normals[1]);
                }
            }
        });
        true
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
