//! PETSc's Krylov method with its preconditioner, as the options say, and how far a solve goes.

use super::Session;
use super::choice::{bad_option, number, relative_tolerance};
use super::failure::{Ended, check};
use super::layout::Layout;
use super::vector::Vectors;
use crate::Result;
use petsc_sys as ffi;
use std::ptr;

/// A Krylov solver.
pub(super) struct Krylov {
    pub handle: ffi::KSP,
    /// The user's `-ksp_rtol`, which wins over the caller's.
    pub fixed_rtol: Option<f64>,
    /// The user's `-ksp_atol` likewise.
    fixed_atol: Option<f64>,
    /// Whether the method tests the true residual, for which alone the caller's absolute tolerance
    /// is meant.
    tests_true_residual: bool,
    pub max_iterations: i32,
    divergence_tolerance: f64,
    /// Whether a solve has succeeded; before that, a refusal of PETSc's is the fault of an option.
    has_converged_once: bool,
}

impl Krylov {
    /// The solver of `operator`, with a preconditioner that is built `from` that or another matrix.
    /// Collective.
    ///
    /// # Safety
    /// The matrices are alive as long as the solver is used.
    ///
    /// # Errors
    /// When PETSc refuses an option.
    pub unsafe fn new(
        session: &Session,
        layout: &Layout,
        operator: ffi::Mat,
        from: ffi::Mat,
    ) -> Result<Krylov> {
        let on_grid = session.option("-pc_type")?.as_deref() == Some("mg");
        let grid = on_grid.then(|| layout.cell_grid(session)).transpose()?;
        let mut made = Krylov {
            handle: ptr::null_mut(),
            fixed_rtol: relative_tolerance(session)?,
            fixed_atol: number(session, "-ksp_atol")?,
            tests_true_residual: false,
            max_iterations: 0,
            divergence_tolerance: 0.0,
            has_converged_once: false,
        };
        // SAFETY: the handle is an output that `made` owns from then on and destroys when dropped,
        // also when a later call fails; the matrices are alive by the caller's word.
        unsafe {
            check("KSPCreate", ffi::KSPCreate(session.comm(), &mut made.handle))?;
            made.set_operators(operator, from)?;
            if let Some(grid) = &grid {
                check("KSPSetDM", ffi::KSPSetDM(made.handle, grid.dm))?;
                // The DM coarsens the grid, and makes no operator.
                let active = ffi::PETSC_FALSE;
                check("KSPSetDMActive", ffi::KSPSetDMActive(made.handle, active))?;
            }
            check("KSPSetFromOptions", ffi::KSPSetFromOptions(made.handle)).map_err(bad_option)?;
            let mut norm = 0;
            check("KSPGetNormType", ffi::KSPGetNormType(made.handle, &mut norm))
                .map_err(bad_option)?;
            made.tests_true_residual = norm == ffi::KSP_NORM_UNPRECONDITIONED;
            let mut r = 0.0;
            let mut a = 0.0;
            let d = &mut made.divergence_tolerance;
            let m = &mut made.max_iterations;
            check("KSPGetTolerances", ffi::KSPGetTolerances(made.handle, &mut r, &mut a, d, m))?;
        }
        Ok(made)
    }

    /// Sets the operator, and the matrix to build the preconditioner from.
    ///
    /// # Safety
    /// As for [`Krylov::new`].
    pub unsafe fn set_operators(&mut self, operator: ffi::Mat, from: ffi::Mat) -> Result<()> {
        // SAFETY: the caller's word.
        check("KSPSetOperators", unsafe { ffi::KSPSetOperators(self.handle, operator, from) })
    }

    /// The absolute tolerance of a solve that is asked for this one: the user's, or none where the
    /// method does not test the true residual.
    pub fn absolute_tolerance(&self, asked: f64) -> f64 {
        self.fixed_atol.unwrap_or(if self.tests_true_residual { asked } else { 0.0 })
    }

    /// Sets the tolerances and the most iterations of the next solve.
    pub fn set_tolerances(&mut self, rtol: f64, atol: f64, iterations: i32) -> Result<()> {
        let d = self.divergence_tolerance;
        // SAFETY: a handle made in `new`.
        check("KSPSetTolerances", unsafe {
            ffi::KSPSetTolerances(self.handle, rtol, atol, d, iterations)
        })
    }

    /// Sets whether the next solve goes on with a preconditioner of another matrix.
    pub fn keep_preconditioner(&mut self, keep: bool) -> Result<()> {
        let keep = if keep { ffi::PETSC_TRUE } else { ffi::PETSC_FALSE };
        // SAFETY: a handle made in `new`.
        check("KSPSetReusePreconditioner", unsafe {
            ffi::KSPSetReusePreconditioner(self.handle, keep)
        })
    }

    /// Lets the next solve build its preconditioner anew.
    pub fn forget_preconditioner(&mut self) -> Result<()> {
        // SAFETY: handles made in `new`; PCReset forgets the factors, and the next solve sets up
        // anew.
        unsafe {
            let mut pc = ptr::null_mut();
            check("KSPGetPC", ffi::KSPGetPC(self.handle, &mut pc))?;
            check("PCReset", ffi::PCReset(pc))
        }
    }

    /// Solves, as far as the tolerances say. Collective.
    ///
    /// # Errors
    /// When PETSc fails; as long as no solve has succeeded, this is the fault of an option.
    pub fn solve(&mut self, vectors: &mut Vectors) -> Result<Ended> {
        let mut reason = 0;
        let mut iterations = 0;
        // SAFETY: handles that are alive; outputs are two integers.
        unsafe {
            check("KSPSolve", ffi::KSPSolve(self.handle, vectors.right_side, vectors.solution))
                .map_err(|e| if self.has_converged_once { e } else { bad_option(e) })?;
            self.has_converged_once = true;
            check("KSPGetConvergedReason", ffi::KSPGetConvergedReason(self.handle, &mut reason))?;
            check(
                "KSPGetIterationNumber",
                ffi::KSPGetIterationNumber(self.handle, &mut iterations),
            )?;
        }
        Ok(Ended { reason, iterations: iterations.max(0) as u32 })
    }
}

impl Drop for Krylov {
    fn drop(&mut self) {
        // SAFETY: the handle is null or ours.
        unsafe {
            ffi::KSPDestroy(&mut self.handle);
        }
    }
}
