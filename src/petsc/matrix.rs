//! The matrix that a preconditioner is built from, its values refilled straight into PETSc's
//! storage, and the constants that a singular one has in its null space.

use super::Session;
use super::failure::check;
use super::layout::Layout;
use super::structured::Structured;
use super::vector::Pattern;
use crate::Result;
use petsc_sys as ffi;
use std::ptr;

/// A matrix of a pattern's entries.
pub(super) struct Matrix {
    pub handle: ffi::Mat,
    /// The matrix in hypre's structured form, where that is needed.
    structured: Option<Structured>,
}

impl Matrix {
    /// The matrix with the entries of a pattern, in the form that `-pc_type` needs. Collective.
    pub fn new(session: &Session, layout: &Layout, pattern: Pattern) -> Result<Matrix> {
        if let Some("pfmg" | "smg") = session.option("-pc_type")?.as_deref() {
            let structured = Structured::new(session, layout, &pattern)?;
            return Ok(Matrix { handle: structured.matrix, structured: Some(structured) });
        }
        let Pattern { mut rows, mut columns, .. } = pattern;
        let mut made = Matrix { handle: ptr::null_mut(), structured: None };
        let n = layout.local.iter().product::<usize>() as i32;
        let any = -1;
        let count = rows.len() as ffi::PetscCount;
        // SAFETY: the handle is an output that `made` owns from then on and destroys when dropped,
        // also when a later call fails; `rows` and `columns` live through the call that reads (and
        // may reorder) them.
        unsafe {
            check("MatCreate", ffi::MatCreate(session.comm(), &mut made.handle))?;
            check("MatSetSizes", ffi::MatSetSizes(made.handle, n, n, any, any))?;
            check("MatSetType", ffi::MatSetType(made.handle, c"aij".as_ptr()))?;
            let i = rows.as_mut_ptr();
            let j = columns.as_mut_ptr();
            check("MatSetPreallocationCOO", ffi::MatSetPreallocationCOO(made.handle, count, i, j))?;
            let symmetric = ffi::MAT_SYMMETRIC;
            check("MatSetOption", ffi::MatSetOption(made.handle, symmetric, ffi::PETSC_TRUE))?;
        }
        Ok(made)
    }

    /// Whether products with it may be taken: not in hypre's structured form.
    pub fn multiplies(&self) -> bool {
        self.structured.is_none()
    }

    /// Takes new values, in the order of the pattern. Collective.
    pub fn set_values(&self, values: &[f64]) -> Result<()> {
        if let Some(structured) = &self.structured {
            return structured.set_values(values);
        }
        // SAFETY: `values` has the pattern's length, which the caller made.
        check("MatSetValuesCOO", unsafe {
            ffi::MatSetValuesCOO(self.handle, values.as_ptr(), ffi::INSERT_VALUES)
        })
    }
}

impl Drop for Matrix {
    fn drop(&mut self) {
        // SAFETY: the handle is null (PETSc then does nothing) or ours.
        unsafe {
            ffi::MatDestroy(&mut self.handle);
        }
    }
}

/// The constants, where they solve the homogeneous system.
pub(super) struct Constants {
    space: ffi::MatNullSpace,
}

impl Constants {
    /// Collective.
    pub fn new(session: &Session) -> Result<Constants> {
        let mut made = Constants { space: ptr::null_mut() };
        let space = &mut made.space;
        // SAFETY: an output that `made` owns from then on and destroys when dropped.
        check("MatNullSpaceCreate", unsafe {
            ffi::MatNullSpaceCreate(session.comm(), ffi::PETSC_TRUE, 0, ptr::null(), space)
        })?;
        Ok(made)
    }

    /// Lets a matrix know that they are in its null space.
    ///
    /// # Safety
    /// The matrix is alive.
    pub unsafe fn give_to(&self, matrix: ffi::Mat) -> Result<()> {
        // SAFETY: the caller's word; the matrix keeps its own reference to the space.
        check("MatSetNullSpace", unsafe { ffi::MatSetNullSpace(matrix, self.space) })
    }
}

impl Drop for Constants {
    fn drop(&mut self) {
        // SAFETY: the handle is null or ours.
        unsafe {
            ffi::MatNullSpaceDestroy(&mut self.space);
        }
    }
}
