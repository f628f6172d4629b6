//! What moves the fluid besides its boundaries.

use super::Case;
use crate::config::fault::{AXES, Check, finite, vector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What moves the fluid besides its boundaries: exactly one of the keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Drive {
    /// A force on the fluid only (N/m3), a number for each axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<Vec<f64>>,
    /// `fluid.gravity` drives the fluid along periodic axes: a slope. Along others the hydrostatic
    /// pressure carries it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub gravity: bool,
    /// Mean velocity of fluid and bodies along a periodic axis (m/s), held by a pressure gradient
    /// found in every step. Without it a periodic box of falling bodies accelerates as a whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_velocity: Option<MeanVelocity>,
}

/// A mean velocity that is held.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeanVelocity {
    /// Its axis.
    pub axis: Axis,
    /// The velocity (m/s): flow rate, bodies included, over the whole cross-section of the box.
    pub value: f64,
}

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// From west to east.
    X,
    /// From south to north.
    Y,
    /// From bottom to top, 3D only.
    Z,
}

impl Axis {
    /// Its number, from 0.
    pub fn index(self) -> usize {
        self as usize
    }

    /// Checks that a case has it.
    pub(in crate::config) fn check(self, key: &str, dimension: usize) -> Check {
        ensure!(
            self.index() < dimension,
            key,
            "\"z\" is for 3D only, and domain.size has two numbers"
        );
        Ok(())
    }
}

impl Drive {
    /// Checks it as a part of its case.
    pub(in crate::config) fn check(&self, case: &Case) -> Check {
        let dimension = case.dimension();
        let given = [self.force.is_some(), self.gravity, self.mean_velocity.is_some()];
        let count = given.iter().filter(|given| **given).count();
        let ways = "force = [...], gravity = true, mean_velocity = { axis = \"x\", value = ... }";
        ensure!(count == 1, "drive", "give exactly one of {ways}; there are {count}");
        if let Some(force) = &self.force {
            vector("drive.force", force, dimension, "N/m3")?;
        }
        if let Some(MeanVelocity { axis, value }) = self.mean_velocity {
            axis.check("drive.mean_velocity.axis", dimension)?;
            finite("drive.mean_velocity.value", &[value], "m/s")?;
            let x = AXES[axis.index()];
            let axis = axis.index();
            let cure = "make both of its faces \"periodic\", or drive the flow by an inflow";
            ensure!(case.periodic(axis), "drive.mean_velocity.axis", "{x} is not periodic: {cure}");
        }
        let gravity = case.fluid.gravity.as_deref().unwrap_or_default();
        let along = (0..dimension)
            .any(|axis| case.periodic(axis) && gravity.get(axis).is_some_and(|g| *g != 0.0));
        let cure = "give fluid.gravity a part along a periodic axis, as in [9.81e-3, -9.81]";
        ensure!(
            !self.gravity || along,
            "drive.gravity",
            "no periodic axis has any gravity: {cure}"
        );
        Ok(())
    }
}
