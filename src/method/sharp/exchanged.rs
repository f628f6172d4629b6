//! Momentum that a step gives to the cells of a body beside the flow.

use nalgebra::Vector3;

/// Momentum that ghost cells and the gradient of cut cells have given to this rank's cells in the
/// step.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExchangedMomentum {
    /// Momentum (kg m/s).
    pub linear: Vector3<f64>,
    /// Angular momentum about the body's centre (kg m2/s).
    pub angular: Vector3<f64>,
}

impl ExchangedMomentum {
    /// Adds momentum (kg m/s) at an arm from the centre (m).
    #[inline(always)]
    pub fn add(&mut self, arm: &Vector3<f64>, added: &Vector3<f64>) {
        self.linear += added;
        self.angular += arm.cross(added);
    }
}
