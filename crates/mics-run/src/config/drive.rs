//! Drive of the fluid besides its boundaries.

use super::Case;
use crate::config::fault::{AXES, Check, finite, vector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Drive of the fluid besides its boundaries: a force, gravity or a mean velocity that is held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Drive {
    /// A force on the fluid only (N/m3), a number for each axis.
    Force(Vec<f64>),
    /// `gravity = true`: `fluid.gravity` drives the fluid along periodic axes, a slope. Along
    /// others the hydrostatic pressure carries it.
    Gravity(bool),
    /// Mean velocity of fluid and bodies along a periodic axis (m/s), held by a pressure gradient
    /// found in every step. Without it a periodic box of falling bodies accelerates as a whole.
    MeanVelocity(MeanVelocity),
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
        match self {
            Drive::Force(force) => vector("force", force, case.dimension(), "N/m3"),
            Drive::MeanVelocity(held) => held.check(case),
            Drive::Gravity(drives) => {
                ensure!(*drives, "gravity", "is true, or the table [drive] is left out");
                let gravity = &case.fluid.gravity;
                let along = |axis: usize| gravity.get(axis).is_some_and(|g| *g != 0.0);
                let slopes = (0..case.dimension()).any(|axis| case.periodic(axis) && along(axis));
                ensure!(
                    slopes,
                    "gravity",
                    "no periodic axis has any gravity: give fluid.gravity a part along a periodic \
                    axis, as in [9.81e-3, -9.81]"
                );
                Ok(())
            }
        }
    }
}

impl MeanVelocity {
    fn check(self, case: &Case) -> Check {
        let key = "mean_velocity.axis";
        self.axis.check(key, case.dimension())?;
        finite("mean_velocity.value", &[self.value], "m/s")?;
        let axis = self.axis.index();
        let x = AXES[axis];
        let cure = "make both of its faces \"periodic\", or drive the flow by an inflow";
        ensure!(case.periodic(axis), key, "{x} is not periodic: {cure}");
        Ok(())
    }
}
