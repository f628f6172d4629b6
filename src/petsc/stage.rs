//! Stages of PETSc's log (`-log_view`) by the names of a step's parts: what PETSc does, and the
//! time that passes, counts for the stage entered last.

use super::Session;
use super::failure::check;
use super::options::c_string;
use crate::Result;
use petsc_sys as ffi;

/// A part of the step in PETSc's log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogStage {
    /// Velocities of cells and faces without the new pressure, (7, 8).
    Prediction,
    /// The operator's coefficients, its matrix, and what free bodies add to it.
    Assembly,
    /// C-HSMAC (13-15), the preconditioner's setup included.
    Pressure,
    /// Velocities of cells with the new pressure, (16).
    Correction,
    /// Motion of the bodies, forces on them, contacts, and what they cover.
    Bodies,
}

/// Names in the log, in the order of [`LogStage`].
const NAMES: [&str; 5] = ["prediction", "assembly", "pressure", "correction", "bodies"];

/// PETSc's numbers of the stages.
pub(super) type Stages = [ffi::PetscLogStage; NAMES.len()];

/// Finds the stages of this process, or makes them.
pub(super) fn register() -> Result<Stages> {
    let mut stages = [-1; NAMES.len()];
    for (stage, name) in stages.iter_mut().zip(NAMES) {
        let name = c_string(name)?;
        // SAFETY: PETSc is running; it copies the name and writes one integer.
        unsafe {
            check("PetscLogStageGetId", ffi::PetscLogStageGetId(name.as_ptr(), stage))?;
            if *stage < 0 {
                check("PetscLogStageRegister", ffi::PetscLogStageRegister(name.as_ptr(), stage))?;
            }
        }
    }
    Ok(stages)
}

/// A stage that has been entered, until it is dropped.
#[must_use]
pub struct Logged {
    /// PETSc ends no earlier.
    pub(super) _session: Session,
}

impl Drop for Logged {
    fn drop(&mut self) {
        // SAFETY: pushed by `log`; the session still runs. A failure here has nobody to tell.
        unsafe { ffi::PetscLogStagePop() };
    }
}
