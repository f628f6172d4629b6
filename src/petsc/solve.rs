//! One solve after another: how far each goes, what a failed one tries again, and with which
//! preconditioner.
//!
//! ```text
//!   solve:  an older preconditioner, if it is worth a try  ->  one of this matrix
//!                                       -> anew, from zero  ->  failure, with both reasons
//! ```

use super::choice::bad_option;
use super::failure::{check, reason_name};
use super::solver::{LinearSolver, Solved};
use crate::{Error, Result};
use petsc_sys as ffi;
use std::ptr;

/// PETSc's `KSP_DIVERGED_ITS`: more iterations than `-ksp_max_it` allows.
const TOO_MANY: i32 = -3;

/// How to see why a solve fails.
const LOOK: &str = "look at it with `-- -ksp_monitor_true_residual -ksp_converged_reason`";

/// PETSc's `KSP_DIVERGED_NANORINF`: a number that is infinite or none.
const OVERFLOWN: i32 = -9;

/// The failure of a solve that met a number that is infinite or none: another method cures that
/// where the user chose this one, else no solver does.
fn overflown(method: Option<String>) -> Error {
    let broke_down = method.map_or(String::new(), |method| {
        format!("the method broke down (take another -ksp_type than {method}, such as cg), or ")
    });
    Error::Run(format!(
        "the pressure solve met a number that is infinite or none: {broke_down}a density, a \
        viscosity, a length or a velocity of the case is too large or too small for double \
        precision, or the flow has grown beyond it; look at their exponents and units"
    ))
}

/// The failure of a solve with a preconditioner of our own, for PETSc's reason.
fn failed_once(reason: ffi::KSPConvergedReason, iterations: u32, rtol: f64) -> Error {
    Error::Run(format!(
        "the pressure solve failed: {} after {iterations} iterations (relative tolerance \
        {rtol:.1e}); {LOOK}, try another solver (pressure.solver = \"bcgs-boomeramg\", or `-- \
        -ksp_type cg -pc_type gamg`), or relax pressure.divergence_limit",
        reason_name(reason),
    ))
}

/// The failure of two solves, for PETSc's reasons after so many iterations each.
fn failed_twice(
    (first, before): (ffi::KSPConvergedReason, u32),
    (second, more): (ffi::KSPConvergedReason, u32),
    rtol: f64,
) -> Error {
    Error::Run(format!(
        "the pressure solve failed twice: {} after {before} iterations, then, from zero with a \
        rebuilt preconditioner, {} after {more} (relative tolerance {rtol:.1e}); {LOOK}, {}take \
        the default solver (pressure.solver = \"auto\", without -ksp_type and -pc_type), or relax \
        pressure.divergence_limit",
        reason_name(first),
        reason_name(second),
        if second == TOO_MANY { "allow more iterations (`-- -ksp_max_it 5000`), " } else { "" },
    ))
}

impl LinearSolver {
    /// Solves, from zero unless an option says otherwise, until the true residual is below `rtol`
    /// times the right side's norm, or below `atol` (2-norms; a method that knows another norm only
    /// goes by `rtol` in that). A solve that fails is repeated once, from zero, with a rebuilt
    /// preconditioner, unless that is the operator's own, which would be the same again.
    /// Collective.
    ///
    /// # Errors
    /// When the last try fails, with PETSc's reason for each.
    pub fn solve(&mut self, rtol: f64, atol: f64) -> Result<Solved> {
        let before = self.setups()?;
        self.choose_operator()?;
        let solved = self.solve_or_retry(rtol, atol)?;
        Ok(Solved { setups: self.setups()? - before, ..solved })
    }

    /// The method, where the user chose it.
    fn chosen_method(&self) -> Result<Option<String>> {
        let chosen = self.session.user_option("-ksp_type")?;
        if chosen { self.session.option("-ksp_type") } else { Ok(None) }
    }

    /// How often the preconditioner was set up so far.
    fn setups(&self) -> Result<u32> {
        if self.own { self.operator.setups() } else { Ok(self.reuse.setups) }
    }

    /// Lets the matrix be the operator as long as that is all.
    fn choose_operator(&mut self) -> Result<()> {
        let differs = self.operator.differs_from_matrix()?;
        if self.is_assembled() && std::mem::replace(&mut self.differs, differs) != differs {
            self.set_operators()?;
        }
        Ok(())
    }

    fn solve_or_retry(&mut self, rtol: f64, atol: f64) -> Result<Solved> {
        if !self.null_space.is_null() {
            // SAFETY: handles made in `new`.
            check("MatNullSpaceRemove", unsafe {
                ffi::MatNullSpaceRemove(self.null_space, self.right_side)
            })?;
        }
        let atol = self.absolute_tolerance(atol);
        let (done, spent) = self.attempt_with_old_preconditioner(rtol, atol)?;
        if done {
            return Ok(Solved { iterations: spent, ..Solved::default() });
        }
        self.prepare(rtol, atol, false, self.max_iterations)?;
        let (first, iterations) = self.attempt()?;
        if first > 0 {
            self.judge(iterations, rtol);
            return Ok(Solved { iterations: spent + iterations, ..Solved::default() });
        }
        if self.own {
            return Err(match first {
                OVERFLOWN => overflown(self.chosen_method()?),
                _ => failed_once(first, iterations, rtol),
            });
        }
        self.forget_preconditioner()?;
        self.reuse.build();
        self.forget_guess()?;
        let (second, more) = self.attempt()?;
        if second > 0 {
            self.judge(more, rtol);
            let iterations = spent + iterations + more;
            return Ok(Solved { iterations, retried: true, ..Solved::default() });
        }
        Err(match (first, second) {
            (OVERFLOWN, OVERFLOWN) => overflown(self.chosen_method()?),
            _ => failed_twice((first, iterations), (second, more), rtol),
        })
    }

    /// Solves with the preconditioner of an older matrix, where that is worth a try. Returns
    /// whether it is solved, and the iterations.
    fn attempt_with_old_preconditioner(&mut self, rtol: f64, atol: f64) -> Result<(bool, u32)> {
        let reuse = self.reuse;
        if !reuse.is_stale() {
            return Ok((false, 0));
        }
        let mut spent = 0;
        if reuse.keeps() {
            self.prepare(rtol, atol, true, reuse.patience(rtol).min(self.max_iterations))?;
            let (reason, iterations) = self.attempt()?;
            if reason > 0 {
                self.judge(iterations, rtol);
                return Ok((true, iterations));
            }
            spent = iterations;
            self.reuse.fail();
            self.forget_guess()?;
        }
        self.reuse.build();
        Ok((false, spent))
    }

    /// Lets the next solve build its preconditioner anew.
    fn forget_preconditioner(&mut self) -> Result<()> {
        // SAFETY: handles made in `new`; PCReset forgets the factors, and the next solve sets up
        // anew.
        unsafe {
            let mut pc = ptr::null_mut();
            check("KSPGetPC", ffi::KSPGetPC(self.krylov, &mut pc))?;
            check("PCReset", ffi::PCReset(pc))?;
        }
        self.set_operators()
    }

    /// Says how far the next attempt goes, and whether it goes on with a preconditioner of another
    /// matrix.
    fn prepare(&mut self, rtol: f64, atol: f64, keep: bool, iterations: i32) -> Result<()> {
        // SAFETY: handles made in `new`.
        unsafe {
            let d = self.divergence_tolerance;
            check(
                "KSPSetTolerances",
                ffi::KSPSetTolerances(self.krylov, rtol, atol, d, iterations),
            )?;
            if !self.reuse.reuses() {
                return Ok(());
            }
            let keep = if keep { ffi::PETSC_TRUE } else { ffi::PETSC_FALSE };
            check("KSPSetReusePreconditioner", ffi::KSPSetReusePreconditioner(self.krylov, keep))
        }
    }

    /// With `-ksp_initial_guess_nonzero` a failed attempt's result would be the next one's guess.
    fn forget_guess(&mut self) -> Result<()> {
        // SAFETY: a handle made in `new`.
        check("VecSet", unsafe { ffi::VecSet(self.solution, 0.0) })
    }

    fn judge(&mut self, iterations: u32, rtol: f64) {
        self.reuse.judge(iterations, rtol);
    }

    fn attempt(&mut self) -> Result<(ffi::KSPConvergedReason, u32)> {
        let mut reason = 0;
        let mut iterations = 0;
        let system = self.system();
        self.history.begin(system)?;
        // SAFETY: handles made in `new`; outputs are two integers.
        unsafe {
            check("KSPSolve", ffi::KSPSolve(self.krylov, self.right_side, self.solution)).map_err(
                |e| {
                    let ours = self.operator.take_failure();
                    ours.unwrap_or_else(|| if self.proven { e } else { bad_option(e) })
                },
            )?;
            self.proven = true;
            check("KSPGetConvergedReason", ffi::KSPGetConvergedReason(self.krylov, &mut reason))?;
            check(
                "KSPGetIterationNumber",
                ffi::KSPGetIterationNumber(self.krylov, &mut iterations),
            )?;
            if !self.null_space.is_null() {
                // Whatever constant the solver left: the solution has a mean of zero.
                check(
                    "MatNullSpaceRemove",
                    ffi::MatNullSpaceRemove(self.null_space, self.solution),
                )?;
            }
        }
        self.history.end(system, iterations.max(0) as u32)?;
        Ok((reason, iterations.max(0) as u32))
    }
}
