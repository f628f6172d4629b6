//! An ellipse (2D).

use super::{Described, Reader, axes};
use crate::config::fault::Fault as Refusal;
use mics_shapes::{Fault, Shape as Geometry};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// An ellipse.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ellipse {
    /// Its lengths along its own x and y (m), from end to end.
    pub axes: [f64; 2],
    /// Diameter of the disc of its area (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

impl Described for Ellipse {
    fn dimension(&self) -> Option<usize> {
        Some(2)
    }

    fn read(self, _: &mut Reader, key: &str) -> Result<Ellipse, Refusal> {
        axes(key, &self.axes)?;
        Ok(self)
    }

    fn solid(&self) -> Result<Arc<dyn Geometry>, Fault> {
        Ok(Arc::new(mics_shapes::Ellipse::new(self.axes)))
    }
}
