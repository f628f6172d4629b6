//! The budget of energy of fluid and free bodies; [`crate::method::energy`] closes it.

use crate::Result;
use crate::archive::{Archive, Checkpointed};

/// Where the energy is, and where it has come from and gone to since the start (J; per metre of
/// depth in 2D).
///
/// ```text
///   fluid + bodies + springs  =  start + gravity + drive + boundaries + prescribed - viscous
///                 - contacts - friction - method
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyBudget {
    /// Kinetic energy of the fluid outside the bodies.
    pub fluid: f64,
    /// Kinetic energy of the free bodies, spin included.
    pub bodies: f64,
    /// Energy in the springs of contacts.
    pub springs: f64,
    /// Sum of the three at the start.
    pub start: f64,
    /// Work on fluid and bodies.
    pub work: SuppliedWork,
    /// Losses.
    pub losses: EnergyLosses,
    /// Energy that contacts would have made, and that the bound on their work has kept from them.
    pub bounded: f64,
    /// The largest sum of the start and all work in either direction.
    pub(crate) largest: f64,
    /// Powers that the next step goes on with.
    pub(crate) powers: EnergyPowers,
}

/// Work on fluid and bodies since the start (J).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SuppliedWork {
    /// Work of gravity, less buoyancy, on the free bodies.
    pub gravity: f64,
    /// Work of the drive on fluid and bodies.
    pub drive: f64,
    /// Work of the sides of the box on the fluid: pressure, what flows through them, moving walls;
    /// and on the bodies that these touch.
    pub boundaries: f64,
    /// Work of prescribed bodies on the fluid and on the bodies that they touch.
    pub prescribed: f64,
}

/// Losses of energy since the start (J).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyLosses {
    /// Viscosity, where the grid has the fluid's velocity.
    pub viscous: f64,
    /// Contacts: their dampers, and the fluid in the gaps that substeps carry.
    pub contacts: f64,
    /// Friction.
    pub friction: f64,
    /// The rest: dissipation by the method itself, by upwinding and in the layers of cells at
    /// walls. Negative, the method has made energy.
    pub method: f64,
}

/// Powers as they were last found (W).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct EnergyPowers {
    /// Viscous dissipation when it was last sampled (W), and the time since then (s).
    pub dissipated: f64,
    pub since: f64,
    /// Power of the sides of the box, and of the drive, after the last step (W).
    pub boundaries: f64,
    pub drive: f64,
}

impl EnergyBudget {
    /// Kinetic energy of fluid and free bodies.
    pub fn kinetic(&self) -> f64 {
        self.fluid + self.bodies
    }

    /// All energy now.
    pub fn total(&self) -> f64 {
        self.kinetic() + self.springs
    }

    /// The largest sum that it could have had so far: the start, and all work in either direction.
    pub fn scale(&self) -> f64 {
        self.largest.max(self.moved())
    }

    /// Takes note of the work so far, which may be given back.
    pub(crate) fn take_note(&mut self) {
        self.largest = self.scale();
    }

    /// The start and all work, which may have been given back.
    pub fn supplied(&self) -> f64 {
        let SuppliedWork { gravity, drive, boundaries, prescribed } = self.work;
        self.start + gravity + drive + boundaries + prescribed
    }

    fn moved(&self) -> f64 {
        let SuppliedWork { gravity, drive, boundaries, prescribed } = self.work;
        self.start + gravity.abs() + drive.abs() + boundaries.abs() + prescribed.abs()
    }

    /// Energy that the method has taken (J): supplied, and neither left nor lost to anything else.
    pub(crate) fn missing(&self) -> f64 {
        let EnergyLosses { viscous, contacts, friction, .. } = self.losses;
        self.supplied() - viscous - contacts - friction - self.total()
    }
}

impl Checkpointed for EnergyBudget {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let EnergyBudget { fluid, bodies, springs, start, work, losses, bounded, largest, powers } =
            self;
        let SuppliedWork { gravity, drive, boundaries, prescribed } = work;
        let EnergyLosses { viscous, contacts, friction, method } = losses;
        archive.serialize([fluid, bodies, springs, start])?;
        archive.serialize([drive, &mut powers.drive, bounded, largest])?;
        archive
            .serialize([gravity, boundaries, prescribed, viscous, contacts, friction, method])?;
        archive.serialize([&mut powers.dissipated, &mut powers.boundaries, &mut powers.since])
    }
}
