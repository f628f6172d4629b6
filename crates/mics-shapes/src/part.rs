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

use nalgebra::{Matrix3, Vector3};

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
            Core::Superquadric { half, exponents: [p, q], inset } => {
                superquadric(half, [*p, *q], n) - *inset * n
            }
            Core::Polytope(polytope) => {
                let best = polytope.corners.iter().max_by(|a, b| a.dot(n).total_cmp(&b.dot(n)));
                best.copied().unwrap_or_default()
            }
        }
    }

    /// How the support point moves with the direction `n` (m): the second derivatives of how far
    /// the core reaches along it, of which those across `n` are its radii of curvature. Zero of
    /// polytopes, where edges are sharp.
    pub fn bend(&self, n: &Vector3<f64>) -> Matrix3<f64> {
        let (half, inset, own) = match self {
            Core::Point | Core::Polytope(_) => return Matrix3::zeros(),
            Core::Ellipsoid { half, inset } => {
                let squares = half.component_mul(half);
                let far = squares.component_mul(n);
                let reach = far.dot(n).sqrt();
                let x = far / reach;
                (half, inset, (Matrix3::from_diagonal(&squares) - x * x.transpose()) / reach)
            }
            Core::Superquadric { half, exponents, inset } => {
                (half, inset, bend_of(half, *exponents, n))
            }
        };
        // In 2D nothing moves along z.
        let mut across = Matrix3::identity() - n * n.transpose();
        if half.z == 0.0 {
            across[(2, 2)] = 0.0;
        }
        own - *inset * across
    }
}

/// Second derivatives of how far a superquadric reaches: of the norm of a norm.
fn bend_of(half: &Vector3<f64>, [p, q]: [f64; 2], n: &Vector3<f64>) -> Matrix3<f64> {
    nested(half, [p / (p - 1.0), q / (q - 1.0)], n).2
}

/// `(|s_x x|^q + |s_y y|^q)^(1/q)` and `|s_z z|` by the norm of the exponent p: that, its gradient
/// and its second derivatives by the place.
pub(crate) fn nested(
    scale: &Vector3<f64>,
    [p, q]: [f64; 2],
    place: &Vector3<f64>,
) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let w = scale.component_mul(place);
    let least = 1e-12 * w.norm();
    let at = w.map(|x| x.abs().max(least));
    // First and second derivatives of `(u^r + v^r)^(1/r)`.
    let norm = |u: f64, v: f64, r: f64| {
        let whole = (u.powf(r) + v.powf(r)).powf(1.0 / r);
        let (a, b) = (u / whole, v / whole);
        let second = (r - 1.0) / whole;
        let mixed = -second * (a * b).powf(r - 1.0);
        let own = |a: f64, b: f64| second * a.powf(r - 2.0) * b.powf(r);
        (whole, [a.powf(r - 1.0), b.powf(r - 1.0)], [own(a, b), mixed, own(b, a)])
    };
    let (section, [sx, sy], [sxx, sxy, syy]) = norm(at.x, at.y, q);
    let (whole, [hs, hz], [hss, hsz, hzz]) = norm(section, at.z, p);
    let slope = Vector3::new(sx, sy, 0.0);
    let mut bend = hss * slope * slope.transpose();
    bend[(0, 0)] += hs * sxx;
    bend[(0, 1)] += hs * sxy;
    bend[(1, 0)] += hs * sxy;
    bend[(1, 1)] += hs * syy;
    for (a, s) in [(0, sx), (1, sy)] {
        bend[(a, 2)] += hsz * s;
        bend[(2, a)] += hsz * s;
    }
    bend[(2, 2)] += hzz;
    let signed = scale.zip_map(place, |scale, x| scale.copysign(x));
    let gradient = Vector3::new(hs * sx, hs * sy, hz).component_mul(&signed);
    (whole, gradient, Matrix3::from_fn(|i, j| signed[i] * bend[(i, j)] * signed[j]))
}

/// Support point of the superquadric `(|x/a|^q + |y/b|^q)^(p/q) + |z/c|^p <= 1`: by Hoelder's
/// inequality, with the dual exponents `p' = p/(p - 1)`, `q' = q/(q - 1)` of the direction scaled
/// by the half axes.
fn superquadric(half: &Vector3<f64>, [p, q]: [f64; 2], n: &Vector3<f64>) -> Vector3<f64> {
    let w = half.component_mul(n);
    // In the section: the unit vector of the q norm along which w is largest, and that value.
    let [dual_p, dual_q] = [p / (p - 1.0), q / (q - 1.0)];
    let power = |x: f64, e: f64| x.abs().powf(e).copysign(x);
    let section = (w.x.abs().powf(dual_q) + w.y.abs().powf(dual_q)).powf(1.0 / dual_q);
    let whole = (section.powf(dual_p) + w.z.abs().powf(dual_p)).powf(1.0 / dual_p);
    let (rho, z) = (power(section / whole, dual_p - 1.0), power(w.z / whole, dual_p - 1.0));
    let along = |x: f64| if section > 0.0 { rho * power(x / section, dual_q - 1.0) } else { 0.0 };
    half.component_mul(&Vector3::new(along(w.x), along(w.y), z))
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
        let (half, [p, q]) = (Vector3::new(1.0, 0.7, 0.4), [4.0, 8.0]);
        for n in directions() {
            let x = superquadric(&half, [p, q], &n).component_div(&half).abs();
            let section = x.x.powf(q) + x.y.powf(q);
            assert!((section.powf(p / q) + x.z.powf(p) - 1.0).abs() < 1e-9, "{x} {section}");
            let point = superquadric(&half, [p, q], &n).component_div(&half);
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
