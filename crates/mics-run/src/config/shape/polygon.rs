//! A convex polygon (2D), by its corners or a file of them.

use super::outline::{self, Flaw};
use super::{Described, Reader};
use crate::config::fault::{Fault as Refusal, finite, not_negative};
use crate::config::source::{Source, factor, named, one_of};
use mics_shapes::{Fault, Shape as Geometry};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A convex polygon: exactly one of `points` and `file`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Polygon {
    /// Its corners in order (m), either way round.
    pub points: Option<Vec<[f64; 2]>>,
    /// A CSV file of them, relative to the case file, with columns x and y.
    pub file: Option<String>,
    /// Factor on the file's lengths (0.001 for mm), default 1.
    pub scale: Option<f64>,
    /// Radius of its edges (m), within its faces, which stay where they are; default 0: sharp
    /// edges.
    pub rounding: Option<f64>,
    /// Diameter of the disc of its area (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

impl Described for Polygon {
    fn dimension(&self) -> Option<usize> {
        Some(2)
    }

    fn file(&self) -> Option<&str> {
        self.file.as_deref()
    }

    fn read(self, reader: &mut Reader, key: &str) -> Result<Polygon, Refusal> {
        let Polygon { points, file, scale, rounding, .. } = self;
        one_of(key, &[("points", points.is_some()), ("file", file.is_some())])?;
        let factor = factor(key, scale, file.is_some())?;
        not_negative(&format!("{key}.rounding"), rounding, "m")?;
        let points = match file {
            None => {
                let points = points.unwrap_or_default();
                for (k, point) in points.iter().enumerate() {
                    finite(&format!("{key}.points.{k}"), point, "m")?;
                }
                outline::convex(&points).map_err(|Flaw { corner, what }| Refusal {
                    key: format!("{key}.points.{corner}"),
                    message: what,
                })?;
                points
            }
            Some(file) => {
                let path = reader.folder.join(named(&file, key)?);
                let key = format!("{key}.file");
                let source = Source { path: &path, key: &key };
                let rows = source.rows(&["x", "y"], "corners")?;
                let points: Vec<[f64; 2]> =
                    rows.iter().map(|(_, row)| [factor * row[0], factor * row[1]]).collect();
                outline::convex(&points)
                    .map_err(|Flaw { corner, what }| source.refuse_line(rows[corner].0, &what))?;
                points
            }
        };
        Ok(Polygon { points: Some(points), rounding, ..Polygon::default() })
    }

    fn solid(&self) -> Result<Arc<dyn Geometry>, Fault> {
        let points: Vec<_> = self.points.iter().flatten().copied().collect();
        Ok(Arc::new(mics_shapes::Polygon::new(&points, self.rounding.unwrap_or(0.0))?))
    }

    fn detail(&self) -> String {
        format!(" of {} corners", self.points.as_ref().map_or(0, Vec::len))
    }
}
