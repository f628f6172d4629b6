//! Convex parts of bodies, as contacts see them: a core with a ball swept over it.
//!
//! ```text
//!     .---------.        the surface is at the distance r (`rounding`) from the core:
//!    ( +-------+ )<- r   two parts are apart by  |core_1 - core_2| - r_1 - r_2,
//!    ( |  core | )       a smooth function of their places while the cores are apart, the
//!    ( +-------+ )       potential of the contact force
//!     '---------'
//! ```
//! Of a body with sharp edges, or of a curved one, the core is the body less a thin skin, the
//! rounding: its faces stay where they are, and its edges are rounded.

use crate::surface::superquadric::Surface;
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
                Surface::new(*half, *exponents).support(n) - *inset * n
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
            let x = Surface::new(half, [p, q]).support(&n).component_div(&half).abs();
            let section = x.x.powf(q) + x.y.powf(q);
            assert!((section.powf(p / q) + x.z.powf(p) - 1.0).abs() < 1e-9, "{x} {section}");
            let point = Surface::new(half, [p, q]).support(&n).component_div(&half);
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
