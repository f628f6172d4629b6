//! A superquadric (3D).

use super::{Described, Reader, axes};
use crate::config::fault::Fault as Refusal;
use mics_shapes::{Fault, Shape as Geometry};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A superquadric.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Superquadric {
    /// Its lengths along its own x, y and z (m), from end to end.
    pub axes: [f64; 3],
    /// p (along z) and q (across z), from 2 to 20.
    pub exponents: [f64; 2],
    /// Diameter of the sphere of its volume (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

impl Described for Superquadric {
    fn dimension(&self) -> Option<usize> {
        Some(3)
    }

    fn read(self, _: &mut Reader, key: &str) -> Result<Superquadric, Refusal> {
        axes(key, &self.axes)?;
        for (k, exponent) in self.exponents.iter().enumerate() {
            ensure!(
                (2.0..=20.0).contains(exponent),
                format!("{key}.exponents.{k}"),
                "must be from 2 (round) to 20 (nearly a box), not {exponent:?}"
            );
        }
        Ok(self)
    }

    fn solid(&self) -> Result<Arc<dyn Geometry>, Fault> {
        Ok(Arc::new(mics_shapes::Superquadric::new(self.axes, self.exponents)?))
    }
}
