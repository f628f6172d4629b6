//! History of sharp surfaces ([`crate::method::sharp`] has the formulas).

use crate::archive::{Archive, Checkpointed};
use crate::grid::{Grid, VectorField};
use crate::particles::{Accelerations, Load};
use crate::{Error, Result};
use nalgebra::{UnitQuaternion, Vector3};

/// History of sharp surfaces, which lasts from step to step.
#[derive(Clone, Debug)]
pub struct SurfaceHistory<const D: usize> {
    /// The ghost cells that were set last, with their velocity before; that of all other cells is
    /// unchanged.
    pub before_forcing: Vec<BeforeForcing<D>>,
    /// Momentum-interpolation correction of the faces: their velocity beyond the mean of the cells'
    /// (m/s).
    pub correction: VectorField<D>,
    /// History of each body.
    pub bodies: Vec<BodyHistory>,
}

/// Velocity of a cell before it was set as a ghost cell.
#[derive(Clone, Copy, Debug)]
pub struct BeforeForcing<const D: usize> {
    /// Its index in a field.
    pub cell: u32,
    /// Its velocity then (m/s), or its present one where another entry of the same cell has that.
    pub velocity: [f64; D],
}

/// History of a body in a fluid with sharp surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyHistory {
    /// Acceleration by fluid and gravity in the last step (m/s2, rad/s2).
    pub accelerations: Accelerations,
    /// Correction of the position, which the next step begins with (m).
    pub displacement: Vector3<f64>,
    /// Load by wall shear a step before.
    pub shear: Option<Load>,
    /// Filtered force defect (N): the part of the fluid's loss of momentum that pressure and wall
    /// shear miss, taken in slowly.
    pub filtered_defect: Vector3<f64>,
    /// Undelivered impulse (N s): the part of the fluid's loss that the body has not felt yet.
    pub undelivered: Vector3<f64>,
    /// Momentum (kg m/s) and angular momentum (kg m2/s) of the cells inside the body.
    pub inside: (Vector3<f64>, Vector3<f64>),
    /// Where the body is cut, near to where it is; none where the next step cuts it anew anyway.
    pub cut_at: Option<CutAt>,
}

/// Where a body is cut.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CutAt {
    /// Its centre there (m).
    pub centre: Vector3<f64>,
    /// Its orientation there.
    pub orientation: UnitQuaternion<f64>,
}

impl<const D: usize> SurfaceHistory<D> {
    /// The history in a state that has sharp surfaces.
    ///
    /// # Errors
    /// When it has none: it is another method's.
    pub fn of(surfaces: &mut Option<SurfaceHistory<D>>) -> Result<&mut SurfaceHistory<D>> {
        surfaces.as_mut().ok_or_else(|| {
            Error::Run("the state has no history of sharp surfaces: start it with them".into())
        })
    }

    /// The empty history of so many bodies.
    pub fn new(grid: &Grid<D>, bodies: usize) -> SurfaceHistory<D> {
        SurfaceHistory {
            before_forcing: Vec::new(),
            correction: grid.vector_field(),
            bodies: vec![BodyHistory::default(); bodies],
        }
    }

    /// Writes or reads all of it, beside the velocity `u` of the cells (m/s). Collective.
    ///
    /// # Errors
    /// When the archive holds another case.
    pub fn serialize(
        &mut self,
        grid: &Grid<D>,
        u: &VectorField<D>,
        archive: &mut Archive,
    ) -> Result<()> {
        let SurfaceHistory { before_forcing, correction, bodies } = self;
        archive.each("histories", bodies)?;
        archive.faces(grid, correction)?;
        archive.label("velocity before the wall")?;
        let mut before = u.clone();
        for BeforeForcing { cell, velocity } in before_forcing.iter() {
            for ((before, u), velocity) in before.iter_mut().zip(u).zip(velocity) {
                if *velocity != u[*cell as usize] {
                    before[*cell as usize] = *velocity;
                }
            }
        }
        archive.cells(grid, &mut before)?;
        before_forcing.clear();
        let at = |field: &VectorField<D>, cell: usize| -> [f64; D] {
            std::array::from_fn(|a| field[a][cell])
        };
        let changed = grid.rows().flatten().filter(|&cell| at(&before, cell) != at(u, cell));
        before_forcing.extend(
            changed.map(|cell| BeforeForcing { cell: cell as u32, velocity: at(&before, cell) }),
        );
        Ok(())
    }
}

impl Checkpointed for BodyHistory {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let BodyHistory {
            accelerations,
            displacement,
            shear,
            filtered_defect,
            undelivered,
            inside,
            cut_at,
        } = self;
        archive.serialize([
            accelerations,
            displacement,
            shear,
            filtered_defect,
            undelivered,
            inside,
            cut_at,
        ])
    }
}

impl Checkpointed for CutAt {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        archive.serialize([&mut self.centre, &mut self.orientation])
    }
}
