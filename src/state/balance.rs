//! The balance of momentum after a step; [`crate::method`] closes it.

use crate::Result;
use crate::archive::{Archive, Checkpointed};
use nalgebra::Vector3;

/// Impulses on the fluid and the free bodies in the box over a step, or over several (N s; per
/// metre of depth in 2D).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulses {
    /// By the drive, on fluid and bodies.
    pub drive: Vector3<f64>,
    /// By gravity less buoyancy, on the free bodies.
    pub gravity: Vector3<f64>,
    /// By the pressure on the sides of the box.
    pub pressure: Vector3<f64>,
    /// By viscosity there: at walls their shear.
    pub shear: Vector3<f64>,
    /// By what flows through them.
    pub flow: Vector3<f64>,
    /// By contacts with walls and held bodies, on the free ones.
    pub contacts: Vector3<f64>,
    /// By held bodies on the fluid, and by what holds free ones along their locked directions.
    pub held: Vector3<f64>,
}

impl Impulses {
    /// Their names in files, in the order of [`Impulses::vectors`].
    pub const NAMES: [&str; 7] = [
        "drive",
        "gravity",
        "boundary_pressure",
        "boundary_shear",
        "boundary_flow",
        "contacts",
        "held",
    ];

    /// All impulses (N s).
    pub fn vectors(&self) -> [Vector3<f64>; 7] {
        let Impulses { drive, gravity, pressure, shear, flow, contacts, held } = *self;
        [drive, gravity, pressure, shear, flow, contacts, held]
    }

    /// Impulse of the sides of the box (N s).
    pub fn boundary(&self) -> Vector3<f64> {
        self.pressure + self.shear + self.flow
    }

    /// Sum of all impulses (N s).
    pub fn total(&self) -> Vector3<f64> {
        self.vectors().iter().sum()
    }
}

impl std::ops::AddAssign for Impulses {
    fn add_assign(&mut self, more: Impulses) {
        let Impulses { drive, gravity, pressure, shear, flow, contacts, held } = self;
        let sums = [drive, gravity, pressure, shear, flow, contacts, held];
        sums.into_iter().zip(more.vectors()).for_each(|(sum, more)| *sum += more);
    }
}

impl Checkpointed for Impulses {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Impulses { drive, gravity, pressure, shear, flow, contacts, held } = self;
        archive.serialize([drive, gravity, pressure, shear, flow, contacts, held])
    }
}

/// The balance of momentum over a step: fluid, bodies, boundaries. Per metre of depth in 2D.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Momentum of everything in the box before and after the step (kg m/s).
    pub before: Vector3<f64>,
    #[allow(missing_docs)]
    pub momentum: Vector3<f64>,
    /// Impulses over the step.
    pub impulses: Impulses,
    /// Error of the balance of momentum (kg m/s): the change less the impulses.
    pub error: Vector3<f64>,
    /// Error of the balances of angular momentum about the bodies' centres, summed over them (kg
    /// m2/s).
    pub angular_error: f64,
}

impl Balance {
    /// Closes the balance of a step whose two sides are known: their difference is the error.
    pub fn close(
        [before, momentum]: [Vector3<f64>; 2],
        impulses: Impulses,
        angular_error: f64,
    ) -> Balance {
        Balance {
            before,
            momentum,
            impulses,
            error: momentum - before - impulses.total(),
            angular_error,
        }
    }
}

impl Checkpointed for Balance {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Balance { before, momentum, impulses, error, angular_error } = self;
        archive.serialize([before, momentum, error])?;
        impulses.serialize(archive)?;
        angular_error.serialize(archive)
    }
}
