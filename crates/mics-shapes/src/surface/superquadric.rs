//! The surface of a superquadric, `(|x/a|^q + |y/b|^q)^(p/q) + |z/c|^p = 1`.
//!
//! ```text
//!      .-------.        distances by Newton's method on the surface, x: with the residual r from x
//!     /    n ^  \       to the point, its part s along the normal, the curvatures K,
//!    |       x---|-->     (1 + s K) step = the part of r along the surface
//!     \         /       and back to the surface along the ray from the centre, which is exact
//!      '-------'
//! ```

use super::patches;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Its surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SuperquadricSurface {
    /// Half axes (m).
    pub half: Vector3<f64>,
    p: f64,
    q: f64,
}

/// A number of at least zero to a power, soon where that is whole.
fn power(x: f64, exponent: f64) -> f64 {
    if exponent.fract() == 0.0 { x.powi(exponent as i32) } else { x.powf(exponent) }
}

impl SuperquadricSurface {
    /// With these half axes (m) and the exponents p and q.
    pub(crate) fn new(half: Vector3<f64>, [p, q]: [f64; 2]) -> SuperquadricSurface {
        SuperquadricSurface { half, p, q }
    }

    /// The point that lies furthest in the direction `n` (m): by Hoelder's inequality, with the
    /// dual exponents `p' = p/(p - 1)`, `q' = q/(q - 1)` of the direction scaled by the half axes.
    pub(crate) fn support(&self, n: &Vector3<f64>) -> Vector3<f64> {
        let w = self.half.component_mul(n);
        // In the section: the unit vector of the q norm along which w is largest, and that value.
        let dual_p = self.p / (self.p - 1.0);
        let dual_q = self.q / (self.q - 1.0);
        let power = |x: f64, e: f64| x.abs().powf(e).copysign(x);
        let section = (w.x.abs().powf(dual_q) + w.y.abs().powf(dual_q)).powf(1.0 / dual_q);
        let whole = (section.powf(dual_p) + w.z.abs().powf(dual_p)).powf(1.0 / dual_p);
        let rho = power(section / whole, dual_p - 1.0);
        let z = power(w.z / whole, dual_p - 1.0);
        let along =
            |x: f64| if section > 0.0 { rho * power(x / section, dual_q - 1.0) } else { 0.0 };
        self.half.component_mul(&Vector3::new(along(w.x), along(w.y), z))
    }

    /// Radius of the ball about the middle that touches it from within (m).
    pub(crate) fn inner(&self) -> f64 {
        self.half.min()
    }

    /// Mean of both radii of curvature where its normal is `n` (m).
    pub(crate) fn radius(&self, n: &Vector3<f64>) -> f64 {
        let own = in_plane(n, &self.bend(&self.support(n)).1).0;
        0.5 * own.trace() / own.determinant()
    }

    /// The factor by which a point is further out than the surface.
    pub(crate) fn scale(&self, x: &Vector3<f64>) -> f64 {
        let x = x.component_div(&self.half).abs();
        // By the largest one, so that high powers do not vanish.
        let most = x.amax();
        if most == 0.0 {
            return 0.0;
        }
        let x = x / most;
        let section = power(x.x, self.q) + power(x.y, self.q);
        most * power(power(section, self.p / self.q) + power(x.z, self.p), 1.0 / self.p)
    }

    /// Outward normal at a point of the surface and the curvatures there (1/m).
    pub(crate) fn bend(&self, x: &Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
        let p = self.p;
        let q = self.q;
        let at = x.component_div(&self.half);
        let part = at.abs();
        let section = power(power(part.x, q) + power(part.y, q), 1.0 / q);
        // Place in the section over its size; where that is zero, one with equal parts.
        let even = 0.5f64.powf(1.0 / q);
        let u = if section > 0.0 {
            Vector2::new(part.x, part.y) / section
        } else {
            Vector2::repeat(even)
        };
        let lower = power(section, p - 2.0);
        let z = power(part.z, p - 2.0);
        let lean = u.map(|u| power(u, q - 2.0));
        let sign = at.map(|x| 1f64.copysign(x));
        let slope = Vector3::new(
            lower * section * lean.x * u.x,
            lower * section * lean.y * u.y,
            z * part.z,
        );
        let slope = slope.component_mul(&sign);
        let mut hessian = Matrix3::from_diagonal(&Vector3::new(
            lower * ((p - q) * (lean.x * u.x).powi(2) + (q - 1.0) * lean.x),
            lower * ((p - q) * (lean.y * u.y).powi(2) + (q - 1.0) * lean.y),
            (p - 1.0) * z,
        ));
        let mixed = lower * (p - q) * lean.x * u.x * lean.y * u.y * sign.x * sign.y;
        hessian[(0, 1)] = mixed;
        hessian[(1, 0)] = mixed;
        let inverse = Matrix3::from_diagonal(&self.half.map(|a| 1.0 / a));
        let gradient = inverse * slope;
        let length = gradient.norm();
        (gradient / length, inverse * hessian * inverse / length)
    }

    /// Largest curvature over directions (1/m).
    pub(crate) fn sharpest(&self) -> f64 {
        let bend = |n: Vector3<f64>| {
            let (n, bend) = self.bend(&self.support(&n));
            let (own, _) = in_plane(&n, &bend);
            own.symmetric_eigenvalues().max()
        };
        let normals = patches::directions(24).map(|(n, _)| bend(n));
        let places = patches::directions(24).map(|(n, _)| {
            let x = n.component_mul(&self.half);
            let (n, bend) = self.bend(&(x / self.scale(&x)));
            in_plane(&n, &bend).0.symmetric_eigenvalues().max()
        });
        normals.chain(places).fold(0.0, f64::max)
    }

    /// The nearest point of the surface, from one that is near that.
    pub(crate) fn foot(
        &self,
        point: &Vector3<f64>,
        from: &Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let onto = |x: Vector3<f64>| x / self.scale(&x).max(1e-300);
        let mut x = onto(*from);
        let (mut n, mut bend) = self.bend(&x);
        for _ in 0..20 {
            let rest = point - x;
            let s = rest.dot(&n);
            let (own, [u, v]) = in_plane(&n, &bend);
            let across = Vector2::new(rest.dot(&u), rest.dot(&v));
            if across.norm() < 1e-9 * self.half.max() {
                break;
            }
            // Deeper than the centre of curvature there is no nearest point.
            let s = s.max(-0.9 / own.trace().max(1e-300));
            let system = Matrix2::identity() + s * own;
            let step = system.try_inverse().map_or(across, |inverse| inverse * across);
            let step = step.x * u + step.y * v;
            let mut part = 1.0;
            let better = loop {
                let next = onto(x + part * step);
                if (point - next).norm_squared() < rest.norm_squared() {
                    break Some(next);
                }
                part *= 0.5;
                if part < 0.01 {
                    break None;
                }
            };
            let Some(next) = better else { break };
            x = next;
            (n, bend) = self.bend(&x);
        }
        (x, n)
    }
}

/// Two directions normal to n, and the part of a matrix along these.
fn in_plane(n: &Vector3<f64>, bend: &Matrix3<f64>) -> (Matrix2<f64>, [Vector3<f64>; 2]) {
    let u = n.cross(&Vector3::ith(n.iamin(), 1.0)).normalize();
    let v = n.cross(&u);
    let mixed = u.dot(&(bend * v));
    (Matrix2::new(u.dot(&(bend * u)), mixed, mixed, v.dot(&(bend * v))), [u, v])
}
