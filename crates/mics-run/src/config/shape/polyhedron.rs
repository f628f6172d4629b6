//! A convex polyhedron (3D): the hull of points, or of the surface in an STL file.

use super::{Described, Reader};
use crate::config::fault::{Fault as Refusal, finite, not_negative};
use crate::config::source::{Source, factor, named, one_of};
use mics_shapes::stl::{self, ClosedSurface};
use mics_shapes::{Fault, Shape as Geometry};
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

/// Part by which a hull may be larger than its surface without a note.
const FILLED: f64 = 0.05;

/// The corners (m) of the convex hull of the surface in an STL file, whose lengths are multiplied
/// by `factor`, and notes on it.
///
/// # Errors
/// When it is not a closed surface, in words, without the name of the file.
fn hull(path: &Path, factor: f64) -> Result<(Vec<[f64; 3]>, Vec<String>), String> {
    let words = |fault: Fault| fault.0;
    let mesh = stl::read(path, factor).map_err(words)?;
    let ClosedSurface { triangles, mut notes } = stl::closed(mesh).map_err(words)?;
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

/// A convex polyhedron: exactly one of `file` and `points`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Polyhedron {
    /// An STL file, binary or ASCII, relative to the case file, of a closed surface.
    pub file: Option<String>,
    /// Factor on the file's lengths (0.001 for mm), default 1.
    pub scale: Option<f64>,
    /// Its corners (m), in any order.
    pub points: Option<Vec<[f64; 3]>>,
    /// Radius of its edges (m), within its faces, which stay where they are; default 0: sharp
    /// edges.
    pub rounding: Option<f64>,
    /// Diameter of the sphere of its volume (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

impl Described for Polyhedron {
    fn dimension(&self) -> Option<usize> {
        Some(3)
    }

    fn file(&self) -> Option<&str> {
        self.file.as_deref()
    }

    fn read(self, reader: &mut Reader, key: &str) -> Result<Polyhedron, Refusal> {
        let Polyhedron { file, scale, points, rounding, .. } = self;
        one_of(key, &[("file", file.is_some()), ("points", points.is_some())])?;
        let factor = factor(key, scale, file.is_some())?;
        not_negative(&format!("{key}.rounding"), rounding, "m")?;
        let points = match file {
            None => {
                let points = points.unwrap_or_default();
                for (k, point) in points.iter().enumerate() {
                    finite(&format!("{key}.points.{k}"), point, "m")?;
                }
                points
            }
            Some(file) => {
                let path = reader.folder.join(named(&file, key)?);
                let key = format!("{key}.file");
                let source = Source { path: &path, key: &key };
                source.exists()?;
                let (corners, notes) = hull(&path, factor).map_err(|what| source.refuse(&what))?;
                let said = notes
                    .into_iter()
                    .map(|note| format!("note         {key}: {}: {note}", path.display()));
                reader.notes.extend(said);
                corners
            }
        };
        Ok(Polyhedron { points: Some(points), rounding, ..Polyhedron::default() })
    }

    fn solid(&self) -> Result<Arc<dyn Geometry>, Fault> {
        // Its hull counts, whatever the triangles that have its corners.
        let points: Vec<_> = self.points.iter().flatten().map(|p| [Vector3::from(*p); 3]).collect();
        Ok(Arc::new(mics_shapes::Polyhedron::new(&points, self.rounding.unwrap_or(0.0))?))
    }

    fn detail(&self) -> String {
        format!(" of {} corners", self.points.as_ref().map_or(0, Vec::len))
    }
}
