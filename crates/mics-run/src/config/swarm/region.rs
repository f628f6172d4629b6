//! A part of the box in which bodies are put down.

use super::placement;
use crate::config::Case;
use crate::config::fault::{AXES, Check, short, vector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A part of the box, its edges along the axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Its lowest corner (m).
    pub min: Vec<f64>,
    /// Its highest corner (m).
    pub max: Vec<f64>,
}

impl Region {
    /// Checks it: it has to have room for a body of this diameter (m) with this gap (m) around it.
    pub(in crate::config) fn check(&self, case: &Case, diameter: f64, gap: f64) -> Check {
        vector("min", &self.min, case.dimension(), "m")?;
        vector("max", &self.max, case.dimension(), "m")?;
        for (axis, &size) in case.domain.size.iter().enumerate() {
            let low = self.min[axis];
            let high = self.max[axis];
            let x = AXES[axis];
            for (end, at) in [("min", low), ("max", high)] {
                let holds = (0.0..=size).contains(&at);
                let key = format!("{end}.{axis}");
                ensure!(
                    holds,
                    key,
                    "{x} = {at:?} m is outside the domain: choose 0 <= {x} <= {size:?} m"
                );
            }
            let room = placement::room(case, self, gap, axis, diameter);
            let width = short(high - low);
            let message = format!(
                "{width} m along {x} have no room for a diameter of {diameter:?} m with a gap of \
                {gap:?} m"
            );
            ensure!(room.is_some(), "", "{message}: widen it, or choose smaller ones");
        }
        Ok(())
    }

    /// Range of the centre of a body of this diameter (m) in it, by axis: start and length (m);
    /// `None` without room.
    pub(in crate::config) fn room(
        &self,
        case: &Case,
        gap: f64,
        diameter: f64,
    ) -> Option<Vec<(f64, f64)>> {
        (0..case.dimension()).map(|axis| placement::room(case, self, gap, axis, diameter)).collect()
    }
}
