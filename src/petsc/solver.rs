//! The linear solve: a symmetric matrix whose pattern is fixed, its values refilled straight into PETSc's storage, and
//! a Krylov method that PETSc's options choose. Free bodies add modes to it, which the preconditioner does not see.

use super::modes::{ModeEntry, Modes};
use super::session::{check, read, reason_name, write};
use super::{Layout, Session};
use crate::{Error, Result};
use petsc_sys as ffi;
use std::ptr;

/// A linear system over the owned cells of every rank, and its solver.
pub struct LinearSolver {
    session: Session,
    matrix: ffi::Mat,
    /// What is solved for in place of the matrix, once there have been modes.
    modes: Option<Modes>,
    krylov: ffi::KSP,
    null_space: ffi::MatNullSpace,
    right_side: ffi::Vec,
    solution: ffi::Vec,
    owned: usize,
    /// The user's `-ksp_rtol`, which wins over the caller's.
    fixed_rtol: Option<f64>,
    /// The user's `-ksp_atol` likewise.
    fixed_atol: Option<f64>,
    /// Whether a solve has come through: what PETSc refuses before that, an option asked for.
    proven: bool,
    max_iterations: i32,
    divergence_tolerance: f64,
}

/// What a solve took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Solved {
    /// Krylov iterations, those of a retry included.
    pub iterations: u32,
    /// Whether a first try failed and was repeated from zero with a rebuilt preconditioner.
    pub retried: bool,
}

/// The built-in choice: BCGS with BoomerAMG, on the true residual, with a coarsest solve that a singular matrix allows.
fn default_options(session: &Session, dimension: usize) -> Result<()> {
    session.default_option("-ksp_type", "bcgs")?;
    session.default_option("-ksp_max_it", "500")?;
    // The side on which, or the norm in which, each method tests the true residual.
    match session.option("-ksp_type")?.as_deref() {
        Some("bcgs" | "fbcgs" | "fbcgsr" | "gmres" | "fgmres" | "lgmres" | "gcr" | "tfqmr") => {
            session.default_option("-ksp_pc_side", "right")?
        }
        Some("cg" | "pipecg" | "groppcg" | "fcg" | "cr" | "minres") => {
            session.default_option("-ksp_norm_type", "unpreconditioned")?
        }
        _ => {}
    }
    session.default_option("-pc_type", "hypre")?;
    if session.option("-pc_type")?.as_deref() == Some("hypre") {
        session.default_option("-pc_hypre_type", "boomeramg")?;
        session.default_option("-pc_hypre_boomeramg_relax_type_coarse", "symmetric-SOR/Jacobi")?;
        let threshold = if dimension == 2 { "0.25" } else { "0.5" };
        session.default_option("-pc_hypre_boomeramg_strong_threshold", threshold)?;
    }
    Ok(())
}

impl LinearSolver {
    /// A system with entries at (`rows[k]`, `columns[k]`) in PETSc's numbers; `rows` are this rank's. `singular` says
    /// that constants solve the homogeneous system.
    ///
    /// # Errors
    /// When an option names something that this PETSc does not have.
    pub fn new(
        session: &Session,
        layout: &Layout,
        dimension: usize,
        mut rows: Vec<i32>,
        mut columns: Vec<i32>,
        singular: bool,
    ) -> Result<LinearSolver> {
        default_options(session, dimension)?;
        let owned: usize = layout.local.iter().product();
        let mut solver = LinearSolver {
            session: session.clone(),
            matrix: ptr::null_mut(),
            modes: None,
            krylov: ptr::null_mut(),
            null_space: ptr::null_mut(),
            right_side: ptr::null_mut(),
            solution: ptr::null_mut(),
            owned,
            fixed_rtol: number(session, "-ksp_rtol")?,
            fixed_atol: number(session, "-ksp_atol")?,
            proven: false,
            max_iterations: 0,
            divergence_tolerance: 0.0,
        };
        let (comm, n, any) = (session.comm(), owned as i32, -1);
        // SAFETY: every handle is an output that `solver` owns from then on and destroys when dropped, also when a
        // later call fails; `rows` and `columns` live through the call that reads (and may reorder) them.
        unsafe {
            check("MatCreate", ffi::MatCreate(comm, &mut solver.matrix))?;
            check("MatSetSizes", ffi::MatSetSizes(solver.matrix, n, n, any, any))?;
            check("MatSetType", ffi::MatSetType(solver.matrix, c"aij".as_ptr()))?;
            check("MatSetPreallocationCOO", {
                let count = rows.len() as ffi::PetscCount;
                ffi::MatSetPreallocationCOO(solver.matrix, count, rows.as_mut_ptr(), columns.as_mut_ptr())
            })?;
            check("MatSetOption", ffi::MatSetOption(solver.matrix, ffi::MAT_SYMMETRIC, ffi::PETSC_TRUE))?;
            check("MatCreateVecs", ffi::MatCreateVecs(solver.matrix, &mut solver.solution, &mut solver.right_side))?;
            if singular {
                let space = &mut solver.null_space;
                check("MatNullSpaceCreate", ffi::MatNullSpaceCreate(comm, ffi::PETSC_TRUE, 0, ptr::null(), space))?;
                check("MatSetNullSpace", ffi::MatSetNullSpace(solver.matrix, *space))?;
            }
            check("KSPCreate", ffi::KSPCreate(comm, &mut solver.krylov))?;
            solver.set_operators()?;
            check("KSPSetFromOptions", ffi::KSPSetFromOptions(solver.krylov)).map_err(bad_option)?;
            let (mut r, mut a) = (0.0, 0.0);
            let (d, m) = (&mut solver.divergence_tolerance, &mut solver.max_iterations);
            check("KSPGetTolerances", ffi::KSPGetTolerances(solver.krylov, &mut r, &mut a, d, m))?;
        }
        Ok(solver)
    }

    /// New values, in the order of the pattern; the preconditioner follows at the next solve.
    pub fn set_values(&mut self, values: &[f64]) -> Result<()> {
        // SAFETY: `values` has the pattern's length, which the caller made.
        check("MatSetValuesCOO", unsafe { ffi::MatSetValuesCOO(self.matrix, values.as_ptr(), ffi::INSERT_VALUES) })
    }

    /// Adds `sum_k w_k j_k j_k^T` to the operator of the solves to come, in place of what the last call added; the
    /// preconditioner stays the matrix's own. Every rank gives all `weights` (w_k >= 0, the same everywhere) and its
    /// own `entries` of the vectors `j_k`, in any order (by mode is fastest). `w_k j_k j_k^T` has the matrix's unit. In
    /// a singular system every `j_k` has to sum to zero over all ranks, as the matrix's rows do. Allocates only to grow.
    /// Collective.
    ///
    /// # Errors
    /// When a weight is negative, a number not finite, or a mode or row not there; and when the method is `preonly`,
    /// which would solve without the modes.
    pub fn set_modes(&mut self, weights: &[f64], entries: &[ModeEntry]) -> Result<()> {
        if self.modes.is_none() {
            if self.session.option("-ksp_type")?.as_deref() == Some("preonly") {
                return Err(Error::Usage(
                    "-ksp_type preonly solves with the preconditioner alone, which knows nothing of the motion of free \
                     bodies; use cg, bcgs or gmres"
                        .into(),
                ));
            }
            self.modes = Some(Modes::new(&self.session, self.matrix, self.owned, self.null_space)?);
            self.set_operators()?;
        }
        self.modes.iter_mut().try_for_each(|modes| modes.set(weights, entries))
    }

    /// Tells the Krylov solver what to solve for, and what to build the preconditioner from.
    fn set_operators(&mut self) -> Result<()> {
        let operator = self.modes.as_ref().map_or(self.matrix, Modes::shell);
        // SAFETY: handles of `self`.
        check("KSPSetOperators", unsafe { ffi::KSPSetOperators(self.krylov, operator, self.matrix) })
    }

    /// Lets `fill` write the right side: this rank's cells, x fastest.
    pub fn set_right_side(&mut self, fill: impl FnOnce(&mut [f64])) -> Result<()> {
        // SAFETY: made in `new` with `owned` entries here; `fill` cannot reach it otherwise.
        unsafe { write(self.right_side, self.owned, fill) }
    }

    /// Hands the solution to `take`: this rank's cells, x fastest.
    pub fn solution<T>(&self, take: impl FnOnce(&[f64]) -> T) -> Result<T> {
        // SAFETY: as for the right side.
        unsafe { read(self.solution, self.owned, take) }
    }

    /// Whether the user fixed the relative tolerance by `-ksp_rtol`.
    pub fn fixed_rtol(&self) -> Option<f64> {
        self.fixed_rtol
    }

    /// Solves, from zero unless an option says otherwise, until the true residual is below `rtol` times the right side's norm, or below `atol`
    /// (2-norms). A solve that fails is repeated once, from zero, with a rebuilt preconditioner. Collective.
    ///
    /// # Errors
    /// When the second try fails too, with both of PETSc's reasons.
    pub fn solve(&mut self, rtol: f64, atol: f64) -> Result<Solved> {
        // SAFETY: handles made in `new`.
        unsafe {
            if !self.null_space.is_null() {
                check("MatNullSpaceRemove", ffi::MatNullSpaceRemove(self.null_space, self.right_side))?;
            }
            let atol = self.fixed_atol.unwrap_or(atol);
            let (d, m) = (self.divergence_tolerance, self.max_iterations);
            check("KSPSetTolerances", ffi::KSPSetTolerances(self.krylov, rtol, atol, d, m))?;
        }
        let (first, mut iterations) = self.attempt()?;
        if first > 0 {
            return Ok(Solved { iterations, retried: false });
        }
        // SAFETY: as above; PCReset forgets the factors, and the next solve sets up anew.
        unsafe {
            let mut pc = ptr::null_mut();
            check("KSPGetPC", ffi::KSPGetPC(self.krylov, &mut pc))?;
            check("PCReset", ffi::PCReset(pc))?;
            self.set_operators()?;
            // With `-ksp_initial_guess_nonzero` the first try's result would be the guess.
            check("VecSet", ffi::VecSet(self.solution, 0.0))?;
        }
        let (second, more) = self.attempt()?;
        iterations += more;
        if second > 0 {
            return Ok(Solved { iterations, retried: true });
        }
        Err(Error::Run(format!(
            "the pressure solve failed twice: {} after {} iterations, then, from zero with a rebuilt preconditioner, {} \
             after {more} (relative tolerance {rtol:.1e}); look at it with `-- -ksp_monitor_true_residual \
             -ksp_converged_reason`, try another solver (`-- -ksp_type cg -pc_type gamg`), or relax \
             pressure.divergence_limit",
            reason_name(first),
            iterations - more,
            reason_name(second),
        )))
    }

    fn attempt(&mut self) -> Result<(ffi::KSPConvergedReason, u32)> {
        let (mut reason, mut iterations) = (0, 0);
        // SAFETY: handles made in `new`; outputs are two integers.
        unsafe {
            check("KSPSolve", ffi::KSPSolve(self.krylov, self.right_side, self.solution)).map_err(|e| {
                let ours = self.modes.as_mut().and_then(Modes::take_failure);
                ours.unwrap_or_else(|| if self.proven { e } else { bad_option(e) })
            })?;
            self.proven = true;
            check("KSPGetConvergedReason", ffi::KSPGetConvergedReason(self.krylov, &mut reason))?;
            check("KSPGetIterationNumber", ffi::KSPGetIterationNumber(self.krylov, &mut iterations))?;
            if !self.null_space.is_null() {
                // Whatever constant the solver left: the solution has a mean of zero.
                check("MatNullSpaceRemove", ffi::MatNullSpaceRemove(self.null_space, self.solution))?;
            }
        }
        Ok((reason, iterations.max(0) as u32))
    }

    /// The method and the preconditioner in use, as `bcgs + hypre`.
    pub fn describe(&self) -> Result<String> {
        let name = |n: &str| Ok::<_, Error>(self.session.option(n)?.unwrap_or_else(|| "?".into()));
        Ok(format!("{} + {}", name("-ksp_type")?, name("-pc_type")?))
    }
}

impl Drop for LinearSolver {
    fn drop(&mut self) {
        // SAFETY: each handle is null (PETSc then does nothing) or ours; `session` outlives them all.
        unsafe {
            ffi::KSPDestroy(&mut self.krylov);
            ffi::VecDestroy(&mut self.right_side);
            ffi::VecDestroy(&mut self.solution);
            ffi::MatNullSpaceDestroy(&mut self.null_space);
            ffi::MatDestroy(&mut self.matrix);
        }
    }
}

/// What PETSc refuses here, the user asked for.
fn bad_option(error: Error) -> Error {
    match error {
        Error::Petsc { message, .. } => Error::Usage(format!("PETSc refuses an option: {message}")),
        other => other,
    }
}

/// A numeric option of the user's.
fn number(session: &Session, name: &str) -> Result<Option<f64>> {
    let Some(text) = session.option(name)? else { return Ok(None) };
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(Some(value)),
        _ => Err(Error::Usage(format!("PETSc option {name}: {text:?} is not a tolerance; give a number such as 1e-8"))),
    }
}
