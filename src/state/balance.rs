//! The balance of momentum after a step; [`crate::method`] closes it.

use crate::Result;
use crate::archive::{Archive, Checkpointed};
use nalgebra::Vector3;

/// The balance of momentum over a step: fluid, bodies, borders. Per metre of depth in 2D.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Momentum of everything in the box after the step (kg m/s).
    pub momentum: Vector3<f64>,
    /// Impulse of the borders over the step (N s).
    pub border: Vector3<f64>,
    /// What is missing in the balance of momentum (kg m/s).
    pub error: Vector3<f64>,
    /// What is missing in the balances of angular momentum about the bodies' centres, summed over them (kg m2/s).
    pub angular_error: f64,
}

impl Checkpointed for Balance {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Balance { momentum, border, error, angular_error } = self;
        archive.serialize([momentum, border, error, angular_error])
    }
}
