//! Exchange of momentum between fluid and particles over a step.

use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::sums::Summed;
use nalgebra::Vector3;

/// Exchange of momentum between fluid and one particle over a step. Forces in N (per metre of depth
/// in 2D), torques in N m about the particle's centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange {
    /// Force by the momentum that the fluid around the body loses: what (27) of the mixture method
    /// removes, the body's own inertia apart, or what sharp surfaces take.
    pub momentum: Vector3<f64>,
    /// Its torque.
    pub momentum_torque: Vector3<f64>,
    /// Remainder of the force: the convective part of (19) in the mixture method, the force defect
    /// of a sharp surface.
    pub remainder: Vector3<f64>,
    /// Pressure part of (19).
    pub pressure: Vector3<f64>,
    /// Viscous part of (19).
    pub viscous: Vector3<f64>,
    /// Torque of the three parts of (19).
    pub literal_torque: Vector3<f64>,
    /// Mean force of contacts over the step.
    pub contact: Vector3<f64>,
    /// Force that accelerates the mass of a held body as prescribed, `m dV/dt`: the mixture takes
    /// it up, and nobody around it.
    pub(crate) driven: Vector3<f64>,
}

impl Exchange {
    /// Force on the support of a body that is held in its motion (N): the fluid's force less what
    /// the motion itself takes.
    pub fn held(&self) -> Vector3<f64> {
        self.momentum - self.driven
    }

    /// Force by (19) as printed: the sum of its parts (N).
    pub fn literal(&self) -> Vector3<f64> {
        self.remainder + self.pressure + self.viscous
    }

    /// All vectors that ranks sum.
    fn vectors(&mut self) -> [&mut Vector3<f64>; 7] {
        [
            &mut self.momentum,
            &mut self.momentum_torque,
            &mut self.remainder,
            &mut self.pressure,
            &mut self.viscous,
            &mut self.literal_torque,
            &mut self.driven,
        ]
    }
}

impl Summed for Exchange {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        self.vectors().into_iter().for_each(|v| v.each(take));
    }
}

impl Checkpointed for Exchange {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        // `contact` is the only one that ranks do not sum.
        self.contact.serialize(archive)?;
        self.vectors().into_iter().try_for_each(|v| v.serialize(archive))
    }
}
