//! A curved body beside what stands fixed: corners, edges and faces, of an obstacle or a polytope.
//!
//! ```text
//!       .---.        corner   its signed distance from the surface, convex over all of space
//!      ( body)       edge     the least along it
//!       '-v-'        face     the height of the point of the body that lies furthest down, where
//!     ----+----               that is above the face, and else the least of its edges
//! ```
//! The nearest point of a polytope is found by going from a face to one beside it as long as that
//! is nearer: a convex function has no other lowest point.

use crate::contact::near::{Foot, around};
use crate::contact::part::{Core, Face, Polytope};
use crate::contact::pose::Placed;
use crate::surface::ellipsoid;
use crate::surface::superquadric::SuperquadricSurface;
use nalgebra::{Matrix2, Vector2, Vector3};

/// Most steps along an edge, the longest of Newton's method (rad), and one that is the last.
const MOST: usize = 40;
const LONGEST: f64 = 0.5;
const LAST: f64 = 1e-9;

/// A curved body at its place.
pub(crate) struct Beside<'a> {
    placed: Placed<'a>,
    kind: Kind,
}

/// Its surface.
enum Kind {
    /// By its half axes (m); that along z zero of an ellipse.
    Ellipsoid(Vector3<f64>),
    Superquadric(SuperquadricSurface),
}

impl<'a> Beside<'a> {
    /// The curved body of a core at its place; none of a core that is not curved.
    pub fn new(placed: Placed<'a>) -> Option<Beside<'a>> {
        let kind = match placed.core {
            Core::Ellipsoid { half, .. } => Kind::Ellipsoid(*half),
            Core::Superquadric { half, exponents, .. } => {
                Kind::Superquadric(SuperquadricSurface::new(*half, *exponents))
            }
            Core::Point | Core::Polytope(_) => return None,
        };
        Some(Beside { placed, kind })
    }

    /// The nearest point of a simplex (m), which is that of a face with this outward normal.
    pub fn foot(&self, simplex: &[Vector3<f64>], normal: &Vector3<f64>) -> Foot {
        match simplex {
            [corner] => self.corner(corner),
            [a, b] => self.edge(a, b, normal),
            _ => self.face(simplex.len(), |k| simplex[k], normal),
        }
    }

    /// The nearest point of a face that may be nearer than `best` (m, not negative): `None` where
    /// the body lies that far above its plane, or where what lies below that is out of its reach.
    pub fn nearer(
        &self,
        simplex: &[Vector3<f64>],
        normal: &Vector3<f64>,
        best: f64,
    ) -> Option<Foot> {
        let lowest = self.lowest(normal);
        let gap = (lowest - simplex[0]).dot(normal);
        if gap >= best {
            return None;
        }
        // The body lies within a ball of its largest radius of curvature that touches there.
        let (middle, reach) = around(simplex);
        let cap = (-2.0 * gap * self.flattest()).sqrt();
        let way = lowest - gap * normal - middle;
        (best > 0.0 || way.norm() <= reach + cap).then(|| self.foot(simplex, normal))
    }

    /// The largest radius of curvature (m).
    fn flattest(&self) -> f64 {
        match &self.kind {
            Kind::Ellipsoid(half) => half.max() * half.max() / self.inner(),
            Kind::Superquadric(_) => f64::INFINITY,
        }
    }

    fn corner(&self, place: &Vector3<f64>) -> Foot {
        let turn = self.placed.orientation;
        let own = turn.inverse_transform_vector(&(place - self.placed.place));
        let (foot, normal) = match &self.kind {
            Kind::Ellipsoid(half) if half.z == 0.0 => {
                let (foot, normal) = ellipsoid::nearest([half.x, half.y], [own.x, own.y]);
                let normal = Vector3::new(normal[0], normal[1], 0.0);
                (Vector3::new(foot[0], foot[1], own.z), normal)
            }
            Kind::Ellipsoid(half) => {
                let (foot, normal) = ellipsoid::nearest((*half).into(), own.into());
                (foot.into(), normal.into())
            }
            Kind::Superquadric(surface) => surface.foot(&own, &own),
        };
        Foot { gap: (own - foot).dot(&normal), up: -(turn * normal), place: *place }
    }

    /// The nearest point of a face with these corners, counterclockwise.
    fn face(
        &self,
        count: usize,
        corner: impl Fn(usize) -> Vector3<f64>,
        normal: &Vector3<f64>,
    ) -> Foot {
        let first = corner(0);
        let lowest = self.lowest(normal);
        let gap = (lowest - first).dot(normal);
        let mut best = Foot { gap, up: *normal, place: lowest - gap * normal };
        let foot = best.place;
        let mut beyond = f64::INFINITY;
        for k in 0..count {
            let a = corner(k);
            let b = corner((k + 1) % count);
            if normal.cross(&(b - a)).dot(&(foot - a)) < 0.0 {
                let edge = self.edge(&a, &b, normal);
                if edge.gap < beyond {
                    best = edge;
                    beyond = edge.gap;
                }
            }
        }
        best
    }

    /// The point of the surface that lies furthest against a normal (m).
    fn lowest(&self, normal: &Vector3<f64>) -> Vector3<f64> {
        let own = self.placed.orientation.inverse_transform_vector(&-normal);
        self.placed.at(&match &self.kind {
            Kind::Ellipsoid(half) => {
                let scaled = half.component_mul(&own);
                half.component_mul(&scaled) / scaled.norm()
            }
            Kind::Superquadric(surface) => surface.support(&own),
        })
    }

    /// The nearest point of an edge with these ends (m), of a face with this normal, or zero.
    fn edge(&self, a: &Vector3<f64>, b: &Vector3<f64>, normal: &Vector3<f64>) -> Foot {
        let length = (b - a).norm();
        let along = (b - a) / length;
        let half = match &self.kind {
            Kind::Ellipsoid(half) => half,
            Kind::Superquadric(_) => return self.search(a, &along, length),
        };
        let line = if half.z == 0.0 {
            let lowest = self.lowest(normal) - a;
            Some((lowest.dot(normal), *normal, lowest.dot(&along)))
        } else {
            let middle = a + 0.5 * length * along - self.placed.place;
            let known = normal.norm_squared() > 0.0;
            self.line(half, a, &along, &if known { -normal } else { middle })
        };
        match line {
            Some((gap, up, foot)) if foot > 0.0 && foot < length => {
                Foot { gap, up, place: a + foot * along }
            }
            Some((.., foot)) if foot >= length => self.corner(b),
            _ => self.corner(a),
        }
    }

    /// The least along an edge from a point (m), by its slope, which grows from end to end.
    fn search(&self, a: &Vector3<f64>, along: &Vector3<f64>, length: f64) -> Foot {
        let slope = |foot: &Foot| -foot.up.dot(along);
        let ends = [self.corner(a), self.corner(&(a + length * along))];
        let mut slopes = ends.map(|foot| slope(&foot));
        if slopes[0] >= 0.0 || slopes[1] <= 0.0 {
            return ends[usize::from(slopes[0] < 0.0)];
        }
        let mut from = [0.0, length];
        let mut foot = ends[0];
        let mut before = None;
        for tried in 0..MOST {
            // By its slope, and every third time in the middle.
            let share = if tried % 3 < 2 { slopes[0] / (slopes[0] - slopes[1]) } else { 0.5 };
            let at = from[0] + share * (from[1] - from[0]);
            foot = self.corner(&(a + at * along));
            let steep = slope(&foot);
            if steep.abs() < LAST || from[1] - from[0] < 1e-12 * length {
                break;
            }
            let side = usize::from(steep > 0.0);
            from[side] = at;
            slopes[side] = steep;
            // An end that stays for a second time counts less.
            if before == Some(side) {
                slopes[1 - side] *= 0.5;
            }
            before = Some(side);
        }
        foot
    }

    /// The signed distance (m) of the line through a point (m) along a direction from an ellipsoid,
    /// the direction from it to the surface, and how far from the point along the line it is
    /// nearest (m). Newton's method on the angle of the normal about the line, from a guess of it.
    fn line(
        &self,
        half: &Vector3<f64>,
        point: &Vector3<f64>,
        along: &Vector3<f64>,
        guess: &Vector3<f64>,
    ) -> Option<(f64, Vector3<f64>, f64)> {
        let way = point - self.placed.place;
        let first = (guess - guess.dot(along) * along).try_normalize(1e-300)?;
        let second = along.cross(&first);
        let scaled = [first, second, *along].map(|direction| {
            half.component_mul(&self.placed.orientation.inverse_transform_vector(&direction))
        });
        let [p, q, e] = scaled;
        // The section across the line: h^2 = n.S n.
        let section = Matrix2::new(p.dot(&p), p.dot(&q), p.dot(&q), q.dot(&q));
        let place = Vector2::new(way.dot(&first), way.dot(&second));
        let mut n = Vector2::x();
        for _ in 0..MOST {
            let far = section * n;
            let reach = n.dot(&far).sqrt();
            let side = Vector2::new(-n.y, n.x);
            let slope = side.dot(&(place - far / reach));
            let bend = section.determinant() / reach.powi(3);
            let gap = n.dot(&place) - reach;
            let step = (slope / (gap + bend).max(0.05 * bend)).clamp(-LONGEST, LONGEST);
            n = (n + step * side).normalize();
            if step.abs() < LAST {
                break;
            }
        }
        let reached = n.x * p + n.y * q;
        let normal = n.x * first + n.y * second;
        let foot = reached.dot(&e) / reached.norm() - way.dot(along);
        Some((n.dot(&place) - reached.norm(), -normal, foot))
    }

    /// The point of a polytope in its own axes, in which this body is seen, that is nearest;
    /// `guess` is a direction from the polytope to the body.
    pub fn nearest_of(&self, polytope: &Polytope, guess: &Vector3<f64>) -> Foot {
        let height = |face: &Face, point: &Vector3<f64>| {
            (point - polytope.corners[face.corners[0] as usize]).dot(&face.normal)
        };
        // No other face can be nearer than the one that the body is highest above.
        let mut above = polytope.facing(guess);
        let mut highest = height(above, &self.lowest(&above.normal));
        let inner = self.inner();
        for face in &polytope.faces {
            if height(face, &self.placed.place) - inner > highest {
                let gap = height(face, &self.lowest(&face.normal));
                if gap > highest {
                    above = face;
                    highest = gap;
                }
            }
        }
        let corner =
            |face: &Face, k: usize| polytope.corners[face.corners[k % face.corners.len()] as usize];
        let mut best = match above.corners.len() {
            2 => self.edge(&corner(above, 0), &corner(above, 1), &above.normal),
            count => self.face(count, |k| corner(above, k), &above.normal),
        };
        while let Some(face) = polytope.further(&best.place, &best.up) {
            let feet = (0..face.corners.len()).map(|k| match face.corners.len() {
                2 => self.corner(&corner(face, k)),
                _ => self.edge(&corner(face, k), &corner(face, k + 1), &Vector3::zeros()),
            });
            let next = feet.fold(best, |best, foot| if foot.gap < best.gap { foot } else { best });
            if next.gap >= best.gap - 1e-12 * inner {
                break;
            }
            best = next;
        }
        best
    }

    /// Radius of a ball about the middle that lies within the surface (m).
    fn inner(&self) -> f64 {
        match &self.kind {
            Kind::Ellipsoid(half) if half.z == 0.0 => half.x.min(half.y),
            Kind::Ellipsoid(half) => half.min(),
            Kind::Superquadric(surface) => surface.inner(),
        }
    }
}
