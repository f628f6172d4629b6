//! How the method of the paper is read where it leaves a choice.

use crate::geometry::fraction;
use nalgebra::Vector3;

/// What moves a free particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Driver {
    /// The momentum that the mixing takes from the fluid.
    #[default]
    Momentum,
    /// Eq. (19) as printed.
    Literal,
}

/// The choices of a case.
#[derive(Clone, Copy, Debug)]
pub struct Choices {
    /// How fractions are found.
    pub fraction: fraction::Rule,
    /// What moves free particles.
    pub driver: Driver,
    /// Whether the rotation in (27) acts in boundary cells only, as printed.
    pub rotation_at_boundary: bool,
    /// Whether the pressure is mixed too, (28, 29).
    pub mix_pressure: bool,
    /// Whether cells take (16) as printed.
    pub cell_gradient: bool,
    /// Gravity (m/s2) that acts on the mixture, by reduced gravity on faces.
    pub field_gravity: Vector3<f64>,
    /// Gravity (m/s2) that acts on particles alone, less their buoyancy: (17) as printed.
    pub own_gravity: Vector3<f64>,
}

impl Choices {
    /// Whether what contacts give is expected of the next step as well: where particles move by the
    /// momentum of a mixture that has gravity itself.
    pub fn expects_contacts(&self) -> bool {
        self.driver == Driver::Momentum && self.own_gravity == Vector3::zeros()
    }
}
