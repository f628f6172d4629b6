//! This rank's entries of a PETSc vector, lent for the length of a call.

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

/// The entries of a matrix: PETSc's numbers of row (this rank's) and column of each, and through
/// which face of the row's cell its column lies (low and high by axis), none of the diagonal's.
#[derive(Debug, Default)]
pub struct Pattern {
    /// Rows, those of a cell one after another, the cells x fastest.
    pub rows: Vec<i32>,
    /// Columns.
    pub columns: Vec<i32>,
    /// Faces.
    pub faces: Vec<Option<u8>>,
}
