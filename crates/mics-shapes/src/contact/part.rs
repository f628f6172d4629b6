//! Convex parts of bodies, as contacts see them: a core with a ball swept over it.
//!
//! ```text
//!     .---------.        the surface is at the distance r (`rounding`) from the core:
//!    ( +-------+ )<- r   two parts are apart by  |core_1 - core_2| - r_1 - r_2,
//!    ( |  core | )       a smooth function of their places while the cores are apart, the
//!    ( +-------+ )       potential of the contact force
//!     '---------'
//! ```
//! The core of a body with sharp edges, or of a curved one, is the body less a thin skin, the
//! rounding: its faces stay where they are, and its edges are rounded.

use crate::contact::flags::Flags;
use crate::contact::near::nearest_of_segment;
use crate::surface::superquadric::SuperquadricSurface;
use nalgebra::Vector3;

/// Radius of a ball that contacts may press in as deep as into a skin (of its thickness): overlaps
/// are a fiftieth of the radius.
const SKINS: f64 = 20.0;

/// A convex part, in the own axes of its body.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Where the core has its origin (m).
    pub place: Vector3<f64>,
    /// The core.
    pub core: Core,
    /// Radius of the ball that is swept over the core (m), positive.
    pub rounding: f64,
    /// Radius of the sphere about `place` that holds all of the part (m).
    pub radius: f64,
}

impl Part {
    /// A ball about a place (m) of this radius (m); a disc in 2D.
    pub fn ball(place: Vector3<f64>, radius: f64) -> Part {
        Part { place, core: Core::Point, rounding: radius, radius }
    }

    /// Radius of a ball that contacts may press in as deep (m): that of a ball itself, and else
    /// such that its overlaps leave the cores apart.
    pub fn contact_radius(&self) -> f64 {
        let skins = if self.core == Core::Point { 1.0 } else { SKINS };
        (skins * self.rounding).min(self.radius)
    }

    /// The largest arm about the body's centre of a force along a normal of the surface (m), or a
    /// little more.
    pub fn lever(&self) -> f64 {
        let own = match &self.core {
            Core::Point => 0.0,
            // The centres of curvature of the tips and the flanks are nowhere further apart.
            Core::Ellipsoid { half, .. } => {
                let [a, b] = [half.x, half.y];
                let least = if half.z > 0.0 { a.min(b).min(half.z) } else { a.min(b) };
                half.max() - least
            }
            Core::Superquadric { .. } => self.radius,
            // At a corner normals lie between those of its faces.
            Core::Polytope(Polytope { corners, faces, .. }) => {
                let arm = |face: &Face, k: &u32| corners[*k as usize].cross(&face.normal).norm();
                let of =
                    |face: &Face| face.corners.iter().map(|k| arm(face, k)).fold(0.0, f64::max);
                faces.iter().map(of).fold(0.0, f64::max)
            }
        };
        own + self.place.norm()
    }
}

/// A convex core, about its own origin; in 2D all of it lies in the plane z = 0.
#[derive(Clone, Debug, PartialEq)]
pub enum Core {
    /// A point: the part is a ball, a disc in 2D.
    Point,
    /// An ellipsoid with these half axes along x, y, z (m; z zero in 2D) less a skin of `inset`
    /// (m), which is less than its smallest radius of curvature.
    Ellipsoid {
        /// Half axes of the surface (m).
        half: Vector3<f64>,
        /// Thickness of the skin (m).
        inset: f64,
    },
    /// A superquadric `(|x/a|^q + |y/b|^q)^(p/q) + |z/c|^p <= 1` less such a skin.
    Superquadric {
        /// Half axes of the surface, a, b, c (m).
        half: Vector3<f64>,
        /// p (along z) and q (in the section), at least 2.
        exponents: [f64; 2],
        /// Thickness of the skin (m).
        inset: f64,
    },
    /// A convex polygon or polyhedron.
    Polytope(Polytope),
}

/// A convex polygon or polyhedron.
#[derive(Clone, Debug, PartialEq)]
pub struct Polytope {
    /// Corners (m).
    pub corners: Vec<Vector3<f64>>,
    /// Faces; in 2D its edges.
    pub faces: Vec<Face>,
    /// Its edges; none in 2D.
    pub edges: Vec<Edge>,
}

impl Polytope {
    /// A polytope of these corners (m) and faces.
    pub fn new(corners: Vec<Vector3<f64>>, faces: Vec<Face>) -> Polytope {
        let mut sides: Vec<([u32; 2], u32)> = Vec::new();
        for (k, face) in faces.iter().enumerate().filter(|(_, face)| face.corners.len() > 2) {
            let next = face.corners.iter().cycle().skip(1);
            let ends = face.corners.iter().zip(next).map(|(a, b)| [*a.min(b), *a.max(b)]);
            sides.extend(ends.map(|ends| (ends, k as u32)));
        }
        sides.sort_unstable();
        let two = sides.chunk_by(|one, other| one.0 == other.0);
        let edges =
            two.map(|two| Edge { corners: two[0].0, faces: [two[0].1, two[two.len() - 1].1] });
        Polytope { edges: edges.collect(), corners, faces }
    }

    /// A corner by its number (m).
    pub(crate) fn corner(&self, k: u32) -> Vector3<f64> {
        self.corners[k as usize]
    }

    /// The ends of an edge or of a face in 2D (m).
    pub(crate) fn ends(&self, edge: &[u32]) -> [Vector3<f64>; 2] {
        [self.corner(edge[0]), self.corner(edge[1])]
    }

    /// Height of a point above a face (m).
    pub(crate) fn above(&self, face: &Face, point: &Vector3<f64>) -> f64 {
        (point - self.corner(face.corners[0])).dot(&face.normal)
    }

    /// Lower bound of the signed distance of a point (m).
    pub(crate) fn height(&self, point: &Vector3<f64>) -> f64 {
        let heights = self.faces.iter().map(|face| self.above(face, point));
        heights.fold(f64::NEG_INFINITY, f64::max)
    }

    /// The signed distance of a point (m), and the direction away from the nearest point; own axes.
    pub(crate) fn beside(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let mut height = f64::NEG_INFINITY;
        let mut highest = &self.faces[0];
        let mut seen = Flags::none();
        for (k, face) in self.faces.iter().enumerate() {
            let above = self.above(face, point);
            if above > height {
                height = above;
                highest = face;
            }
            if above > 0.0 {
                seen.add(k);
            }
        }
        if height <= 0.0 || self.is_above(highest, point) {
            return (height, highest.normal);
        }
        let mut nearest = (f64::INFINITY, Vector3::zeros());
        let mut take = |way: Vector3<f64>| {
            let square = way.norm_squared();
            if square < nearest.0 {
                nearest = (square, way);
            }
        };
        if self.edges.is_empty() {
            self.corners.iter().for_each(|corner| take(point - corner));
        }
        for edge in self.edges.iter().filter(|edge| edge.faces.iter().any(|k| seen.may(*k))) {
            let [a, b] = self.ends(&edge.corners);
            take(point - nearest_of_segment(&a, &b, point));
        }
        let distance = nearest.0.sqrt();
        (distance, nearest.1 / distance)
    }

    /// Whether the foot of a point on the plane of a face is in the face.
    pub(crate) fn is_above(&self, face: &Face, point: &Vector3<f64>) -> bool {
        let n = face.corners.len();
        if n == 2 {
            let [a, b] = self.ends(&face.corners);
            let edge = b - a;
            let along = (point - a).dot(&edge);
            return along >= 0.0 && along <= edge.norm_squared();
        }
        (0..n).all(|k| {
            let [a, b] = self.ends(&[face.corners[k], face.corners[(k + 1) % n]]);
            face.normal.cross(&(b - a)).dot(&(point - a)) >= 0.0
        })
    }

    /// The face that faces a direction most.
    pub(crate) fn facing(&self, n: &Vector3<f64>) -> &Face {
        let along = |face: &&Face| face.normal.dot(n);
        let best = self.faces.iter().max_by(|a, b| along(a).total_cmp(&along(b)));
        best.unwrap_or(&self.faces[0])
    }

    /// A face through a point of the surface that reaches further in the direction `up` than the
    /// point does, if there is one.
    pub(crate) fn further(&self, point: &Vector3<f64>, up: &Vector3<f64>) -> Option<&Face> {
        let slack = 1e-12 * point.amax().max(self.corners[0].amax());
        let beyond = |face: &Face| {
            let ahead = |k: &u32| (self.corner(*k) - point).dot(up);
            face.corners.iter().map(ahead).fold(0.0, f64::max)
        };
        let through =
            |face: &&Face| (point - self.corner(face.corners[0])).dot(&face.normal).abs() <= slack;
        let best = self.faces.iter().filter(through).map(|face| (beyond(face), face));
        let best = best.max_by(|a, b| a.0.total_cmp(&b.0));
        best.filter(|(beyond, _)| *beyond > slack).map(|(_, face)| face)
    }
}

/// An edge between two faces of a polyhedron.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Its corners, by number.
    pub corners: [u32; 2],
    /// The faces beside it, by number.
    pub faces: [u32; 2],
}

/// A flat face of a polytope.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Outward normal, of length 1.
    pub normal: Vector3<f64>,
    /// Its corners, by number, counterclockwise seen from outside; coplanar triangles are one face.
    pub corners: Vec<u32>,
}

impl Core {
    /// The point that lies furthest in the direction `n` (m), of length 1.
    pub fn support(&self, n: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Core::Point => Vector3::zeros(),
            Core::Ellipsoid { half, inset } => {
                let scaled = half.component_mul(n);
                half.component_mul(&scaled) / scaled.norm() - *inset * n
            }
            Core::Superquadric { half, exponents, inset } => {
                SuperquadricSurface::new(*half, *exponents).support(n) - *inset * n
            }
            Core::Polytope(polytope) => {
                let best = polytope.corners.iter().max_by(|a, b| a.dot(n).total_cmp(&b.dot(n)));
                best.copied().unwrap_or_default()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions() -> impl Iterator<Item = Vector3<f64>> {
        (0..200).map(|k| {
            let at = |a: f64| (12.9898 * k as f64 + 4.1414 * a).sin() * 43758.5453 % 1.0;
            Vector3::new(at(1.0), at(2.0), at(3.0)).normalize()
        })
    }

    #[test]
    fn superquadric_support_lies_on_surface_with_that_normal() {
        let half = Vector3::new(1.0, 0.7, 0.4);
        let [p, q] = [4.0, 8.0];
        for n in directions() {
            let x = SuperquadricSurface::new(half, [p, q]).support(&n).component_div(&half).abs();
            let section = x.x.powf(q) + x.y.powf(q);
            assert!((section.powf(p / q) + x.z.powf(p) - 1.0).abs() < 1e-9, "{x} {section}");
            let point = SuperquadricSurface::new(half, [p, q]).support(&n).component_div(&half);
            let outer = section.powf(p / q - 1.0);
            let slope = |x: f64, e: f64| x.abs().powf(e - 1.0).copysign(x);
            let gradient = Vector3::new(
                outer * slope(point.x, q),
                outer * slope(point.y, q),
                slope(point.z, p),
            )
            .component_div(&half);
            assert!(gradient.normalize().cross(&n).norm() < 1e-6, "{gradient} {n}");
        }
    }

    #[test]
    fn superquadric_of_exponents_two_is_ellipsoid() {
        let half = Vector3::new(1.0, 0.7, 0.4);
        let ellipsoid = Core::Ellipsoid { half, inset: 0.05 };
        let superquadric = Core::Superquadric { half, exponents: [2.0, 2.0], inset: 0.05 };
        for n in directions() {
            assert!((ellipsoid.support(&n) - superquadric.support(&n)).norm() < 1e-12);
        }
    }
}
