//! A superquadric, `(|x/a|^q + |y/b|^q)^(p/q) + |z/c|^p <= 1`: from an ellipsoid (2, 2) to nearly a
//! box.
//!
//! Distances are those from its surface ([`crate::surface::superquadric`]).
//! Boxes see a polyhedron of some 1,200 faces that touch it, shrunk to its volume, which is exact.
//! Its faces are within 0.2 % of the half axes of the true surface, its corners within 2 %.

use crate::boxes::convex::Convex;
use crate::surface::ellipsoid::skin;
use crate::surface::facets::Facets;
use crate::surface::patches;
use crate::surface::superquadric::SuperquadricSurface;
use crate::{Core, Fault, Lattice, Nearest, Part, Shape, SurfacePoint, Tile};
use libm::tgamma;
use nalgebra::{Matrix3, Vector3};

/// Directions of faces along each edge of a cube.
const FACES: usize = 10;

/// Part of the radius that the faces are nowhere further from the surface.
const OFF: f64 = 0.02;

/// A superquadric (3D).
#[derive(Clone, Debug)]
pub struct Superquadric {
    surface: SuperquadricSurface,
    facets: Facets,
    radius: f64,
    volume: f64,
    inertia: Matrix3<f64>,
    parts: [Part; 1],
}

impl Superquadric {
    /// With these axes along x, y and z (m), whole lengths, and the exponents p (along z) and q (in
    /// the section).
    ///
    /// # Errors
    ///
    /// An axis is not positive, or an exponent is not from 2 to 20.
    pub fn new(axes: [f64; 3], exponents: [f64; 2]) -> Result<Superquadric, Fault> {
        if let Some(axis) = axes.iter().find(|axis| !(axis.is_finite() && **axis > 0.0)) {
            return Err(Fault(format!("the axis {axis} m of the superquadric is no length")));
        }
        if let Some(e) = exponents.iter().find(|e| !(2.0..=20.0).contains(*e)) {
            return Err(Fault(format!("the exponent {e} of the superquadric is not from 2 to 20")));
        }
        let half = 0.5 * Vector3::from(axes);
        let [p, q] = exponents;
        let surface = SuperquadricSurface::new(half, exponents);
        let (volume, inertia) = moments(&half, p, q);
        let facets = touching(&surface, volume);
        let inset = skin(half.min(), 0.9 / surface.sharpest());
        let core = Core::Superquadric { half, exponents, inset };
        let reach = patches::directions(48).map(|(n, _)| {
            let x = n.component_mul(&half);
            x.norm() / surface.scale(&x)
        });
        // Between these directions it is no further than they are apart.
        let radius = (1.001 * reach.fold(0.0, f64::max)).max(half.max()).min(half.norm());
        let part = Part { place: Vector3::zeros(), core, rounding: inset, radius };
        Ok(Superquadric { surface, facets, radius, volume, inertia, parts: [part] })
    }
}

/// Volume (m3) and moments of inertia (m5), by Dirichlet's integrals.
fn moments(half: &Vector3<f64>, p: f64, q: f64) -> (f64, Matrix3<f64>) {
    // Integral of x^(m - 1) y^(n - 1) over a quarter of |x|^q + |y|^q < 1.
    let section =
        |m: f64, n: f64| tgamma(m / q) * tgamma(n / q) / (q * q * tgamma(1.0 + (m + n) / q));
    // Integral of z^(m - 1) (1 - z^p)^(n/p) from 0 to 1.
    let along =
        |m: f64, n: f64| tgamma(m / p) * tgamma(n / p + 1.0) / (p * tgamma((m + n) / p + 1.0));
    let whole = 8.0 * half.product();
    let xx = whole * half.x * half.x * section(3.0, 1.0) * along(1.0, 4.0);
    let yy = whole * half.y * half.y * section(1.0, 3.0) * along(1.0, 4.0);
    let zz = whole * half.z * half.z * section(1.0, 1.0) * along(3.0, 2.0);
    let inertia = Matrix3::from_diagonal(&Vector3::new(yy + zz, xx + zz, xx + yy));
    (whole * section(1.0, 1.0) * along(1.0, 2.0), inertia)
}

/// A polyhedron of faces that touch it, spread evenly over places and over directions, shrunk to
/// this volume (m3).
fn touching(surface: &SuperquadricSurface, volume: f64) -> Facets {
    let half = surface.half;
    let axes = (0..6).map(|k| Vector3::ith(k % 3, if k < 3 { 1.0 } else { -1.0 }));
    let even = patches::directions(FACES).map(|(n, _)| n);
    let places = patches::directions(FACES).map(|(n, _)| {
        let x = n.component_mul(&half);
        surface.bend(&(x / surface.scale(&x))).0
    });
    let normals: Vec<Vector3<f64>> = axes.chain(even).chain(places).collect();
    let planes: Vec<(Vector3<f64>, f64)> =
        normals.iter().map(|n| (*n, n.dot(&surface.support(n)))).collect();
    let body = |factor: f64| {
        let mut body = Convex::with_capacity(2 * planes.len() + 8);
        body.set_box(&Vector3::zeros(), &[0, 1, 2].map(|a| Vector3::ith(a, 2.0 * half.max())));
        planes.iter().for_each(|(n, at)| body.cut(n, factor * at));
        body
    };
    let factor = (volume / body(1.0).moments().0).cbrt();
    Facets::new(&body(factor))
}

impl Shape for Superquadric {
    fn dimension(&self) -> usize {
        3
    }

    fn radius(&self) -> f64 {
        self.radius
    }

    fn volume(&self) -> f64 {
        self.volume
    }

    fn inertia(&self) -> Matrix3<f64> {
        self.inertia
    }

    fn thickness(&self) -> f64 {
        2.0 * self.surface.half.min()
    }

    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let Nearest { distance, normal } = self.facets.nearest(point);
        let (foot, normal) = self.surface.foot(point, &(point - distance * normal));
        Nearest { distance: (point - foot).dot(&normal), normal }
    }

    fn clearance(&self, point: &Vector3<f64>) -> Option<f64> {
        let distance = self.facets.nearest(point).distance;
        Some((distance.abs() - OFF * self.radius).max(0.0).copysign(distance))
    }

    fn plane(&self, point: &Vector3<f64>) -> Option<Nearest> {
        let Nearest { distance, normal } = self.facets.plane(point);
        Some(Nearest { distance: distance - OFF * self.radius, normal })
    }

    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let mut all = self.facets.patches(spacing);
        for patch in &mut all {
            let Nearest { distance, normal } = self.nearest(&patch.place);
            patch.place -= distance * normal;
            patch.normal = normal;
        }
        all
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        self.surface.support(n).dot(n)
    }

    /// Accurate to second order, see the top; the whole volume is exact.
    fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        self.facets.tile(lattice, found);
    }

    fn parts(&self) -> &[Part] {
        &self.parts
    }

    fn triangles(&self, _: f64) -> Vec<[Vector3<f64>; 3]> {
        self.facets.triangles()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ellipsoid;
    use crate::scatter::{counted, feet, lattice, scatter};

    #[test]
    fn exponents_of_two_are_an_ellipsoid() {
        let axes = [1.0, 0.7, 0.5];
        let body = Superquadric::new(axes, [2.0; 2]).unwrap();
        let exact = Ellipsoid::new(axes);
        assert!((body.volume / exact.volume() - 1.0).abs() < 1e-14);
        assert!((body.inertia - exact.inertia()).norm() < 1e-14);
        let mut worst = [0.0f64; 2];
        for k in 0..2000 {
            let point = 0.6 * Vector3::from_fn(|a, _| scatter(3 * k + a));
            let [own, other] = [body.nearest(&point), exact.nearest(&point)];
            // In the middle any of several.
            if other.distance > -0.1 {
                worst[0] = worst[0].max((own.distance - other.distance).abs());
                worst[1] = worst[1].max((own.normal - other.normal).norm());
            }
        }
        let parts = counted(&body, 16);
        println!("distance, normal: {worst:?}, parts of boxes: {parts:?}");
        assert!(worst[0] < 1e-9 && worst[1] < 1e-7 && parts.0 < 1e-2 && parts.1 < 1e-2);
    }

    #[test]
    fn superquadrics_have_volume_feet_and_moments() {
        for (axes, exponents) in [
            ([1.0; 3], [2.0, 2.0]),
            ([1.0; 3], [5.0, 5.0]),
            ([1.0; 3], [10.0, 10.0]),
            ([1.0, 0.7, 0.4], [8.0, 3.0]),
            ([1.0, 0.6, 0.8], [2.0, 20.0]),
            ([1.0, 0.6, 0.8], [20.0, 2.0]),
        ] {
            let body = Superquadric::new(axes, exponents).unwrap();
            let (volume, first) = lattice(&body);
            let feet = feet(&body, 1.2);
            let big =
                body.facets.depth() / (0.5 * axes.iter().copied().fold(f64::INFINITY, f64::min));
            println!(
                "{axes:?} {exponents:?}: {volume:.1e}, {first:.1e}, feet {feet:.1e}, {}, {big:.4}",
                body.facets.faces().len()
            );
            assert!(volume < 1e-12 && first < 1e-12 && feet < 1e-8);
            // Touching faces are further out before they are shrunk.
            assert!((0.995..1.0).contains(&big), "{big}");
            for (k, corner) in body.facets.corners().iter().enumerate() {
                let way = body.nearest(corner).distance;
                assert!(way.abs() < OFF * body.radius, "{way}");
                let point = body.radius * Vector3::from_fn(|a, _| scatter(3 * k + a));
                let near = body.clearance(&point).unwrap_or(f64::NAN);
                let exact = body.nearest(&point).distance;
                assert!(near * exact >= 0.0 && near.abs() <= exact.abs(), "{near} {exact}");
            }
            let [part] = body.parts() else { panic!() };
            assert!(part.rounding > 0.0);
            let area: Vector3<f64> = body.surface(0.05).iter().map(|p| p.area * p.normal).sum();
            assert!(area.norm() < 1e-3, "{area}");
        }
        assert!(Superquadric::new([1.0; 3], [1.5, 2.0]).unwrap_err().0.contains("1.5"));
        assert!(Superquadric::new([1.0, 0.0, 1.0], [2.0; 2]).unwrap_err().0.contains('0'));
    }
}
