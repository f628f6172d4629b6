//! The solids that shapes are, by the constructors of `mics-shapes`.

use super::{Ball, Clump, Polygon, Polyhedron, Superquadric, Typed};
use mics_shapes::stl::{self, Surface};
use mics_shapes::{Fault, Shape as Geometry};
use nalgebra::Vector3;
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

/// Part by which a hull may be larger than its surface before that is said.
const FILLED: f64 = 0.05;

/// The corners (m) of the convex hull of the surface in an STL file, whose lengths are multiplied
/// by `factor`, and what is to be said of it.
///
/// # Errors
/// When it is not a closed surface, in words, without the name of the file.
pub(super) fn hull(path: &Path, factor: f64) -> Result<(Vec<[f64; 3]>, Vec<String>), String> {
    let words = |fault: Fault| fault.0;
    let mesh = stl::read(path, factor).map_err(words)?;
    let Surface { triangles, mut notes } = stl::closed(mesh).map_err(words)?;
    let solid = mics_shapes::Polyhedron::new(&triangles, 0.0).map_err(words)?;
    let excess = solid.hull_excess();
    if excess > FILLED {
        notes.push(format!(
            "its convex hull, which is what is computed, is {:.0} % larger than the surface",
            100.0 * excess
        ));
    }
    let mut corners: Vec<[f64; 3]> = Vec::new();
    let mut known = HashSet::new();
    for corner in solid.triangles(2.0 * solid.radius()).into_iter().flatten() {
        let corner: [f64; 3] = corner.into();
        if known.insert(corner.map(f64::to_bits)) {
            corners.push(corner);
        }
    }
    Ok((corners, notes))
}

/// The solid that it is in its own axes: of a shape that is not round, has nothing in other
/// files and is not scaled.
///
/// # Errors
/// When it is none, in words.
pub(in crate::config) fn geometry(typed: &Typed) -> Result<Arc<dyn Geometry>, String> {
    let words = |fault: Fault| fault.0;
    let balls = |balls: &Option<Vec<Ball>>| -> Vec<(Vector3<f64>, f64)> {
        let ball = |ball: &Ball| {
            let at = Vector3::from_fn(|a, _| ball.at.get(a).copied().unwrap_or(0.0));
            (at, 0.5 * ball.diameter)
        };
        balls.iter().flatten().map(ball).collect()
    };
    Ok(match typed {
        Typed::Ellipse(ellipse) => Arc::new(mics_shapes::Ellipse::new(ellipse.axes)),
        Typed::Ellipsoid(ellipsoid) => Arc::new(mics_shapes::Ellipsoid::new(ellipsoid.axes)),
        Typed::Superquadric(Superquadric { axes, exponents, .. }) => {
            Arc::new(mics_shapes::Superquadric::new(*axes, *exponents).map_err(words)?)
        }
        Typed::Polygon(Polygon { points, rounding, .. }) => {
            let points: Vec<_> = points.iter().flatten().copied().collect();
            let rounding = rounding.unwrap_or(0.0);
            Arc::new(mics_shapes::Polygon::new(&points, rounding).map_err(words)?)
        }
        Typed::Polyhedron(Polyhedron { points, rounding, .. }) => {
            // Its hull counts, whatever the triangles that have its corners.
            let points: Vec<_> = points.iter().flatten().map(|p| [Vector3::from(*p); 3]).collect();
            let rounding = rounding.unwrap_or(0.0);
            Arc::new(mics_shapes::Polyhedron::new(&points, rounding).map_err(words)?)
        }
        Typed::Clump(Clump { discs: listed @ Some(_), .. }) => {
            Arc::new(mics_shapes::Clump::new(2, &balls(listed)).map_err(words)?)
        }
        Typed::Clump(Clump { spheres, .. }) => {
            Arc::new(mics_shapes::Clump::new(3, &balls(spheres)).map_err(words)?)
        }
        Typed::Disc(_) | Typed::Sphere(_) | Typed::Like(_) => {
            return Err(format!("a {} is no solid", typed.key()));
        }
    })
}
