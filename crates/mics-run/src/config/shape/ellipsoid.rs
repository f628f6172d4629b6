//! An ellipsoid (3D).

use super::{Described, Reader, axes};
use crate::config::fault::Fault as Refusal;
use mics_shapes::{Fault, Shape as Geometry};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// An ellipsoid.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ellipsoid {
    /// Its lengths along its own x, y and z (m), from end to end.
    pub axes: [f64; 3],
    /// Diameter of the sphere of its volume (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

impl Described for Ellipsoid {
    fn dimension(&self) -> Option<usize> {
        Some(3)
    }

    fn read(self, _: &mut Reader, key: &str) -> Result<Ellipsoid, Refusal> {
        axes(key, &self.axes)?;
        Ok(self)
    }

    fn solid(&self) -> Result<Arc<dyn Geometry>, Fault> {
        Ok(Arc::new(mics_shapes::Ellipsoid::new(self.axes)))
    }
}
