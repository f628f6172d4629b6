//! Drive of the fluid besides its boundaries.

use super::{Case, OverTime};
use crate::config::fault::{AXES, Check, finite, vector};
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Drive of the fluid besides its boundaries: a force, gravity or a mean velocity that is held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Drive {
    /// A force on the fluid only (N/m3), a number for each axis.
    Force(DrivingForce),
    /// `gravity = true`: `fluid.gravity` drives the fluid along periodic axes, a slope. Along
    /// others the hydrostatic pressure carries it.
    Gravity(bool),
    /// Mean velocity of fluid and bodies along a periodic axis (m/s), held by a pressure gradient
    /// found in every step. Without it a periodic box of falling bodies accelerates as a whole.
    MeanVelocity(MeanVelocity),
}

/// A force per volume, and how it varies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a force is a number for each axis (N/m3), as in [1.0, 0.0], or one that varies, { \
                 value = [1.0, 0.0], over_time = { time = [...], factor = [...] } }"
)]
pub enum DrivingForce {
    /// The same at all times (N/m3).
    Steady(Vec<f64>),
    /// One that varies.
    Varying(VaryingForce),
}

/// A force per volume that varies: `value` times a factor over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VaryingForce {
    /// The force (N/m3) at a factor of 1.
    pub value: Vec<f64>,
    /// Its factor over time; a step has that of its middle.
    pub over_time: OverTime,
}

impl DrivingForce {
    /// The force at a factor of 1 (N/m3).
    pub fn vector(&self) -> &[f64] {
        match self {
            DrivingForce::Steady(value) => value,
            DrivingForce::Varying(varying) => &varying.value,
        }
    }

    /// Its factor over time; `None` where it is steady.
    pub fn over_time(&self) -> Option<&OverTime> {
        if let DrivingForce::Varying(varying) = self { Some(&varying.over_time) } else { None }
    }

    fn check(&self, dimension: usize) -> Check {
        let steady = matches!(self, DrivingForce::Steady(_));
        let key = if steady { "force" } else { "force.value" };
        vector(key, self.vector(), dimension, "N/m3")
    }
}

/// A mean velocity that is held.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeanVelocity {
    /// Its axis.
    pub axis: Axis,
    /// The velocity (m/s): flow rate, bodies included, over the whole cross-section of the box.
    pub value: f64,
    /// Its factor over time; default 1 at all times.
    pub over_time: Option<OverTime>,
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
    /// Its factor over time; `None` where it is steady.
    pub fn over_time(&self) -> Option<&OverTime> {
        match self {
            Drive::Force(force) => force.over_time(),
            Drive::Gravity(_) => None,
            Drive::MeanVelocity(held) => held.over_time.as_ref(),
        }
    }

    /// That factor, and the name of the kind.
    pub(in crate::config) fn over_time_mut(&mut self) -> Option<(&'static str, &mut OverTime)> {
        match self {
            Drive::Force(DrivingForce::Varying(varying)) => Some(("force", &mut varying.over_time)),
            Drive::MeanVelocity(held) => Some(("mean_velocity", held.over_time.as_mut()?)),
            _ => None,
        }
    }

    /// The largest size of its factor over time.
    pub fn largest_factor(&self) -> f64 {
        self.over_time().map_or(1.0, OverTime::largest)
    }

    /// Its force on the fluid (N/m3) along the periodic axes of its case, at a factor of 1; `None`
    /// where it is found in every step.
    pub fn push(&self, case: &Case) -> Option<Vector3<f64>> {
        let along = |of: &[f64], a: usize| {
            let periodic = a < case.dimension() && case.periodic(a);
            of.get(a).copied().filter(|_| periodic).unwrap_or(0.0)
        };
        let density = case.fluid.density;
        match self {
            Drive::Force(force) => Some(Vector3::from_fn(|a, _| along(force.vector(), a))),
            Drive::Gravity(_) => {
                Some(Vector3::from_fn(|a, _| density * along(&case.fluid.gravity, a)))
            }
            Drive::MeanVelocity(_) => None,
        }
    }

    /// Checks it as a part of its case.
    pub(in crate::config) fn check(&self, case: &Case) -> Check {
        match self {
            Drive::Force(force) => force.check(case.dimension()),
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
    fn check(&self, case: &Case) -> Check {
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
