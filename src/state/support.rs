//! Sustained part of the contact force on a body: the rest is of impacts.

use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::numerics::{MEAN_FORCE_WEIGHT, SUSTAINED_FORCE};
use nalgebra::Vector3;

/// Mean force of a body's contacts over the last steps for as long as there are any (N); `None` for
/// one that lay on something before its first step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanContactForce(pub Option<Vector3<f64>>);

impl MeanContactForce {
    /// Sustained share of a contact force (N), which is none of an impact, by the mean of the steps
    /// before.
    pub fn sustained(&self, force: &Vector3<f64>) -> f64 {
        let mean = mean_force(&self.0.unwrap_or_default(), force);
        let mean = mean.norm();
        let size = force.norm();
        if size > SUSTAINED_FORCE * mean { SUSTAINED_FORCE * mean / size } else { 1.0 }
    }

    /// Takes note of the contact force (N) over a step. Returns its sustained share: 1 where the
    /// body lay there before its first step.
    pub fn press(&mut self, force: &Vector3<f64>) -> f64 {
        let sustained = self.0.map_or(1.0, |_| self.sustained(force));
        self.0 = Some(self.0.map_or(*force, |mean| mean_force(&mean, force)));
        sustained
    }
}

/// The mean force of contacts after a step with this one (N).
fn mean_force(mean: &Vector3<f64>, force: &Vector3<f64>) -> Vector3<f64> {
    if *force == Vector3::zeros() { *force } else { mean + MEAN_FORCE_WEIGHT * (force - mean) }
}

impl Checkpointed for MeanContactForce {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        self.0.serialize(archive)
    }
}
