//! The solids that shapes are.

use super::Shape;
use mics_shapes::Geometry;
use std::path::Path;
use std::sync::Arc;

/// The corners (m) of the convex hull of the surface in an STL file.
pub(super) fn hull(_path: &Path, _factor: f64) -> Result<Vec<[f64; 3]>, String> {
    Err("polyhedra are not there yet".to_owned())
}

impl Shape {
    /// The solid that it is in its own axes, all lengths times `factor`: of a shape that is not
    /// round and has nothing in other files.
    pub(in crate::config) fn geometry(&self, _factor: f64) -> Result<Arc<dyn Geometry>, String> {
        Err(format!("a {} is not there yet", self.key()))
    }
}
