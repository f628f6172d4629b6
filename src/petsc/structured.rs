//! The matrix in hypre's structured form, for its preconditioners on boxes, `pfmg` and `smg`:
//!
//! ```text
//!          n                  one row a cell, entries by their place in the stencil;
//!        w c e                a plane is a box of one layer, since this PETSc has the form
//!          s                  in three dimensions alone
//! ```

use super::Session;
use super::failure::check;
use super::layout::Layout;
use super::vector::Pattern;
use crate::{Error, Result};
use petsc_sys as ffi;
use std::ptr;

/// A matrix in the structured form, and the places of its entries.
pub(super) struct Structured {
    /// The caller's to destroy.
    pub matrix: ffi::Mat,
    rows: Vec<ffi::MatStencil>,
    /// Row by row, as many as `counts` says.
    columns: Vec<ffi::MatStencil>,
    counts: Vec<i32>,
}

impl Structured {
    /// The matrix with the entries of a pattern, on the grid of a layout. Collective.
    ///
    /// # Errors
    /// When the grid closes a period, which this PETSc does not hand on to hypre.
    pub fn new(session: &Session, layout: &Layout, pattern: &Pattern) -> Result<Structured> {
        if layout.whole.iter().any(|(_, periodic)| *periodic) {
            return Err(Error::Usage(
                "PETSc options -pc_type pfmg and smg: this PETSc has hypre's structured matrices \
                for boxes without periodic sides alone; take -pc_type mg, hypre or boxmg"
                    .into(),
            ));
        }
        let grid = layout.box_grid(session)?;
        let mut matrix = ptr::null_mut();
        // SAFETY: the grid outlives these calls, and the matrix keeps its own reference to it; the
        // matrix is an output that becomes the caller's.
        unsafe {
            check("DMSetMatType", ffi::DMSetMatType(grid.dm, c"hyprestruct".as_ptr()))?;
            check("DMCreateMatrix", ffi::DMCreateMatrix(grid.dm, &mut matrix))?;
        }
        let cell = |n: usize| -> [i32; 3] {
            let [x, y, _] = layout.local;
            let at = [n % x, n / x % y, n / (x * y)];
            std::array::from_fn(|a| (layout.start[a] + at[a]) as i32)
        };
        let stencil = |[i, j, k]: [i32; 3]| ffi::MatStencil { k, j, i, c: 0 };
        let mut rows = Vec::new();
        let mut columns = Vec::new();
        let mut counts = Vec::new();
        let mut last = None;
        for (row, face) in pattern.rows.iter().zip(&pattern.faces) {
            if last.replace(row) != Some(row) {
                rows.push(stencil(cell(rows.len())));
                counts.push(0);
            }
            let mut at = cell(rows.len() - 1);
            if let Some(face) = face {
                at[usize::from(face / 2)] += if face % 2 == 0 { -1 } else { 1 };
            }
            columns.push(stencil(at));
            *counts.last_mut().unwrap_or(&mut 0) += 1;
        }
        Ok(Structured { matrix, rows, columns, counts })
    }

    /// Sets the values, in the order of the pattern. Collective.
    pub fn set_values(&self, values: &[f64]) -> Result<()> {
        let mut first = 0;
        for (row, count) in self.rows.iter().zip(&self.counts) {
            let columns = self.columns[first..].as_ptr();
            let values = values[first..].as_ptr();
            let insert = ffi::INSERT_VALUES;
            // SAFETY: one row, and as many columns and values as said from there on.
            check("MatSetValuesStencil", unsafe {
                ffi::MatSetValuesStencil(self.matrix, 1, row, *count, columns, values, insert)
            })?;
            first += *count as usize;
        }
        // SAFETY: a matrix with values set.
        unsafe {
            let whole = ffi::MAT_FINAL_ASSEMBLY;
            check("MatAssemblyBegin", ffi::MatAssemblyBegin(self.matrix, whole))?;
            check("MatAssemblyEnd", ffi::MatAssemblyEnd(self.matrix, whole))
        }
    }
}
