//! A shape at another size: bodies of many sizes share what one of them has been built of.

use crate::{Core, Lattice, Nearest, Part, Polytope, Shape, SurfacePoint, Tile};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// A shape with all of its lengths multiplied by a factor.
#[derive(Clone, Debug)]
pub struct Scaled {
    base: Arc<dyn Shape>,
    factor: f64,
    parts: Vec<Part>,
}

impl Scaled {
    /// A shape with its lengths times `factor`, which is positive.
    pub fn new(base: Arc<dyn Shape>, factor: f64) -> Scaled {
        let parts = base.parts().iter().map(|part| scaled_part(part, factor)).collect();
        Scaled { base, factor, parts }
    }

    /// The factor to this power.
    fn power(&self, exponent: usize) -> f64 {
        self.factor.powi(exponent as i32)
    }
}

fn scaled_part(part: &Part, factor: f64) -> Part {
    let core = match &part.core {
        Core::Point => Core::Point,
        Core::Ellipsoid { half, inset } => {
            Core::Ellipsoid { half: factor * half, inset: factor * inset }
        }
        Core::Superquadric { half, exponents, inset } => {
            Core::Superquadric { half: factor * half, exponents: *exponents, inset: factor * inset }
        }
        Core::Polytope(Polytope { corners, faces, .. }) => Core::Polytope(Polytope::new(
            corners.iter().map(|corner| factor * corner).collect(),
            faces.clone(),
        )),
    };
    Part {
        place: factor * part.place,
        core,
        rounding: factor * part.rounding,
        radius: factor * part.radius,
    }
}

impl Shape for Scaled {
    fn dimension(&self) -> usize {
        self.base.dimension()
    }

    fn radius(&self) -> f64 {
        self.factor * self.base.radius()
    }

    fn volume(&self) -> f64 {
        self.power(self.dimension()) * self.base.volume()
    }

    fn inertia(&self) -> Matrix3<f64> {
        self.power(self.dimension() + 2) * self.base.inertia()
    }

    fn thickness(&self) -> f64 {
        self.factor * self.base.thickness()
    }

    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let Nearest { distance, normal } = self.base.nearest(&(point / self.factor));
        Nearest { distance: self.factor * distance, normal }
    }

    fn feet(&self, point: &Vector3<f64>, within: f64, feet: &mut Vec<Nearest>) {
        self.base.feet(&(point / self.factor), within / self.factor, feet);
        feet.iter_mut().for_each(|foot| foot.distance *= self.factor);
    }

    fn clearance(&self, point: &Vector3<f64>) -> Option<f64> {
        Some(self.factor * self.base.clearance(&(point / self.factor))?)
    }

    fn plane(&self, point: &Vector3<f64>) -> Option<Nearest> {
        let Nearest { distance, normal } = self.base.plane(&(point / self.factor))?;
        Some(Nearest { distance: self.factor * distance, normal })
    }

    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let area = self.power(self.dimension() - 1);
        let patch = |patch: SurfacePoint| SurfacePoint {
            place: self.factor * patch.place,
            normal: patch.normal,
            area: area * patch.area,
        };
        self.base.surface(spacing / self.factor).into_iter().map(patch).collect()
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        self.factor * self.base.extent(n)
    }

    fn meets_itself(&self, foot: &Vector3<f64>, normal: &Vector3<f64>) -> Option<f64> {
        let way = self.base.meets_itself(&(foot / self.factor), normal)?;
        Some(self.factor * way)
    }

    fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        self.base.tile(&Lattice { factor: lattice.factor * self.factor, ..*lattice }, found);
    }

    fn parts(&self) -> &[Part] {
        &self.parts
    }

    fn triangles(&self, spacing: f64) -> Vec<[Vector3<f64>; 3]> {
        let larger = |corners: [Vector3<f64>; 3]| corners.map(|corner| self.factor * corner);
        self.base.triangles(spacing / self.factor).into_iter().map(larger).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scatter::with_tiles;
    use crate::{Clump, Ellipse, Ellipsoid, Polyhedron};

    /// A shape built at twice and a half its size is the same as that scaled.
    fn same(scaled: &Scaled, built: &dyn Shape) {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{a} {b}");
        near(scaled.radius(), built.radius());
        near(scaled.volume(), built.volume());
        near(scaled.thickness(), built.thickness());
        assert!((scaled.inertia() - built.inertia()).amax() < 1e-12 * built.inertia().amax());
        for k in 0..40 {
            let at = |a: f64| (12.9898 * f64::from(k) + 4.1414 * a).sin() * 43758.5453 % 1.0;
            let flat = if built.dimension() == 2 { 0.0 } else { 1.0 };
            let point = 2.0 * built.radius() * Vector3::new(at(1.0), at(2.0), flat * at(3.0));
            let [a, b] = [scaled.nearest(&point), built.nearest(&point)];
            near(a.distance, b.distance);
            let clearance = |shape: &dyn Shape| shape.clearance(&point).unwrap_or(0.0);
            near(clearance(scaled), clearance(built));
            assert!((a.normal - b.normal).norm() < 1e-6, "{point} {a:?} {b:?}");
            let n = point.normalize();
            near(scaled.extent(&n), built.extent(&n));
        }
        let [a, b] = [scaled, built]
            .map(|shape: &dyn Shape| with_tiles(shape, 7, |_, tiles| tiles.to_vec()));
        for (a, b) in a.iter().zip(&b) {
            near(a.part, b.part);
            assert!((a.moment - b.moment).norm() < 1e-12 && a.at == b.at);
        }
        let area = |shape: &dyn Shape| -> f64 {
            shape.surface(0.1 * shape.radius()).iter().map(|patch| patch.area).sum()
        };
        near(area(scaled), area(built));
        let enclosed = |shape: &dyn Shape| -> f64 {
            let part = |[a, b, c]: [Vector3<f64>; 3]| match shape.dimension() {
                2 => 0.5 * a.cross(&b).z,
                _ => a.dot(&b.cross(&c)) / 6.0,
            };
            shape.triangles(0.213).into_iter().map(part).sum()
        };
        near(enclosed(scaled), enclosed(built));
        for (a, b) in scaled.parts().iter().zip(built.parts()) {
            near(a.radius, b.radius);
            near(a.rounding, b.rounding);
            let n = Vector3::new(0.6, 0.8 * (built.dimension() - 2) as f64, 0.0).normalize();
            assert!((a.core.support(&n) - b.core.support(&n)).norm() < 1e-12);
        }
    }

    #[test]
    fn scaled_shape_equals_shape_built_at_that_size() {
        let f = 2.5;
        same(&Scaled::new(Arc::new(Ellipse::new([2.0, 1.0])), f), &Ellipse::new([2.0 * f, f]));
        let ellipsoid = |f: f64| Ellipsoid::new([f, 0.8 * f, 0.5 * f]);
        same(&Scaled::new(Arc::new(ellipsoid(1.0)), f), &ellipsoid(f));
        let points = |f: f64| {
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .map(|p| [f * Vector3::from(p); 3])
        };
        let polyhedron = |f: f64| Polyhedron::new(&points(f), 0.05 * f).unwrap();
        same(&Scaled::new(Arc::new(polyhedron(1.0)), f), &polyhedron(f));
        let aside = Vector3::new(0.93, 0.37, 0.21);
        let balls = |f: f64| [(Vector3::zeros(), f), (f * aside, 0.7 * f)];
        let clump = |f: f64| Clump::new(3, &balls(f)).unwrap();
        same(&Scaled::new(Arc::new(clump(1.0)), f), &clump(f));
    }
}
