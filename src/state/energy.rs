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
    /// The three at the start.
    pub start: f64,
    /// Work of gravity, less buoyancy, on the free bodies.
    pub gravity: f64,
    /// Work of the drive on fluid and bodies.
    pub drive: f64,
    /// Work of the sides of the box on the fluid: pressure, what flows through them, moving walls;
    /// and of these on bodies.
    pub boundaries: f64,
    /// Work of prescribed bodies on the fluid and on the bodies that they touch.
    pub prescribed: f64,
    /// What viscosity has taken from the fluid where the grid has its velocity.
    pub viscous: f64,
    /// What contacts have taken: their dampers, and the fluid in the gaps that substeps carry.
    pub contacts: f64,
    /// What friction has taken.
    pub friction: f64,
    /// What is left: the dissipation by the method itself, by upwinding and in the layers of cells
    /// at walls. Negative, it has made energy.
    pub method: f64,
    /// Energy that contacts would have made, and that the bound on their work has kept from them.
    pub bounded: f64,
    /// The largest sum of the start and all work in either direction.
    pub(crate) largest: f64,
    /// What viscosity took (W) when that was last sampled, and how long ago (s).
    pub(crate) dissipated: f64,
    pub(crate) since: f64,
    /// Power of the sides of the box and of the drive after the last step (W).
    pub(crate) given: f64,
    pub(crate) driven: f64,
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

    fn moved(&self) -> f64 {
        self.start
            + self.gravity.abs()
            + self.drive.abs()
            + self.boundaries.abs()
            + self.prescribed.abs()
    }
}

impl Checkpointed for EnergyBudget {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let EnergyBudget {
            fluid,
            bodies,
            springs,
            start,
            gravity,
            drive,
            boundaries,
            prescribed,
            viscous,
            contacts,
            friction,
            method,
            bounded,
            largest,
            dissipated,
            since,
            given,
            driven,
        } = self;
        archive.serialize([fluid, bodies, springs, start])?;
        archive.serialize([drive, driven, bounded, largest])?;
        archive.serialize([
            gravity, boundaries, prescribed, viscous, contacts, friction, method, dissipated,
            given, since,
        ])
    }
}
