//! This rank's entries of a PETSc vector, lent for the length of a call, and the vectors of a
//! system.

use super::failure::check;
use crate::Result;
use petsc_sys as ffi;
use std::{ptr, slice};

/// Hands this rank's entries of a vector to `take`.
///
/// # Safety
/// `vector` is alive, has `len` entries here, and `take` does not touch it by another way.
pub(super) unsafe fn read<T>(
    vector: ffi::Vec,
    len: usize,
    take: impl FnOnce(&[f64]) -> T,
) -> Result<T> {
    let mut data = ptr::null();
    // SAFETY: PETSc lends the local part, `len` doubles (or null, where there are none), until it
    // is restored.
    unsafe {
        check("VecGetArrayRead", ffi::VecGetArrayRead(vector, &mut data))?;
        let taken = take(if len == 0 { &[] } else { slice::from_raw_parts(data, len) });
        check("VecRestoreArrayRead", ffi::VecRestoreArrayRead(vector, &mut data))?;
        Ok(taken)
    }
}

/// Lets `fill` change this rank's entries of a vector.
///
/// # Safety
/// As for [`read`].
pub(super) unsafe fn write<T>(
    vector: ffi::Vec,
    len: usize,
    fill: impl FnOnce(&mut [f64]) -> T,
) -> Result<T> {
    let mut data = ptr::null_mut();
    // SAFETY: as for reading.
    unsafe {
        check("VecGetArray", ffi::VecGetArray(vector, &mut data))?;
        let filled = fill(if len == 0 { &mut [] } else { slice::from_raw_parts_mut(data, len) });
        check("VecRestoreArray", ffi::VecRestoreArray(vector, &mut data))?;
        Ok(filled)
    }
}

/// The right side and the solution of a system, with so many entries here.
pub(super) struct Vectors {
    pub right_side: ffi::Vec,
    pub solution: ffi::Vec,
    owned: usize,
}

impl Vectors {
    /// The vectors that an operator of `owned` rows here takes. Collective.
    ///
    /// # Safety
    /// The operator is alive.
    pub unsafe fn new(operator: ffi::Mat, owned: usize) -> Result<Vectors> {
        let mut made = Vectors { right_side: ptr::null_mut(), solution: ptr::null_mut(), owned };
        let x = &mut made.solution;
        let b = &mut made.right_side;
        // SAFETY: outputs that `made` owns from then on and destroys when dropped.
        check("MatCreateVecs", unsafe { ffi::MatCreateVecs(operator, x, b) })?;
        Ok(made)
    }

    /// Lets `fill` write the right side: this rank's cells, x fastest.
    pub fn set_right_side(&mut self, fill: impl FnOnce(&mut [f64])) -> Result<()> {
        // SAFETY: made in `new` with `owned` entries here; `fill` cannot reach it otherwise.
        unsafe { write(self.right_side, self.owned, fill) }
    }

    /// Hands the right side to `take`.
    pub fn take_right_side<T>(&self, take: impl FnOnce(&[f64]) -> T) -> Result<T> {
        // SAFETY: as above.
        unsafe { read(self.right_side, self.owned, take) }
    }

    /// Hands the solution to `take`.
    pub fn take_solution<T>(&self, take: impl FnOnce(&[f64]) -> T) -> Result<T> {
        // SAFETY: as above.
        unsafe { read(self.solution, self.owned, take) }
    }

    /// Sets the solution to zero.
    pub fn forget_solution(&mut self) -> Result<()> {
        // SAFETY: a handle made in `new`.
        check("VecSet", unsafe { ffi::VecSet(self.solution, 0.0) })
    }
}

impl Drop for Vectors {
    fn drop(&mut self) {
        // SAFETY: each handle is null (PETSc then does nothing) or ours.
        unsafe {
            ffi::VecDestroy(&mut self.right_side);
            ffi::VecDestroy(&mut self.solution);
        }
    }
}

/// The entries of a matrix: PETSc's numbers of row (this rank's) and column of each, and the face
/// of the row's cell towards its column (low and high by axis), none for the diagonal's.
#[derive(Debug, Default)]
pub struct Pattern {
    /// Rows, those of a cell one after another, the cells x fastest.
    pub rows: Vec<i32>,
    /// Columns.
    pub columns: Vec<i32>,
    /// Faces.
    pub faces: Vec<Option<u8>>,
}
