//! The residuals of solves, iteration by iteration, as PETSc keeps them.
//!
//! ```text
//!   KSPSetResidualHistory: PETSc writes |r_0|, |r_1|, ... of a solve into the buffer
//!   residuals  [ attempt 1 | attempt 2 | ...         ]  since the last `clear`
//! ```
//! Where a method tests no norm, or a preconditioner iterates by itself, PETSc keeps nothing: the
//! true residual before and after the solve stands in its place, an application of the operator.
//! Most methods keep the first residual and one an iteration. Residuals of others (`tfqmr` two,
//! without the first; `bcgsl` one in two) are spread evenly over the iterations; `chebyshev` lacks
//! one, and its last stands at the end.

use super::failure::check;
use crate::Result;
use petsc_sys as ffi;
use std::ops::Range;
use std::ptr;

/// Residuals of a solve that are kept at most, the last one aside.
const MOST: usize = 10_000;

/// PETSc's name of the 2-norm of `b - A x`.
const TRUE_RESIDUAL: &str = "unpreconditioned";

/// A solve with one preconditioner, from its first residual to its last.
#[derive(Clone, Debug)]
pub struct Attempt {
    /// The norm of its residuals: `unpreconditioned` is the 2-norm of `b - A x`, `preconditioned`
    /// that of `B (b - A x)` with the preconditioner B, `natural` the root of `r.B r`.
    pub norm: &'static str,
    /// The residual of a solution of zero, to which the relative tolerance refers.
    pub reference: f64,
    /// The residual below which it ends; `None` where the method tests none.
    pub tolerance: Option<f64>,
    /// Krylov iterations.
    pub iterations: u32,
    residuals: Range<usize>,
}

impl Attempt {
    /// A residual over that of a solution of zero.
    pub fn relative(&self, residual: f64) -> f64 {
        if self.reference > 0.0 { residual / self.reference } else { 0.0 }
    }
}

/// The solves that [`crate::petsc::LinearSolver::record`] asked for.
#[derive(Debug)]
pub struct History {
    recording: bool,
    /// Where PETSc writes the residuals of a solve.
    buffer: Vec<f64>,
    /// Scratch: `b - A x`, made where it is needed.
    defect: ffi::Vec,
    /// Whether the solve under way begins with another solution than zero, and its true residual.
    guess: bool,
    first: f64,
    /// Iterations and their residuals, of all attempts.
    residuals: Vec<(u32, f64)>,
    attempts: Vec<Attempt>,
}

/// A system under solution: handles that are alive.
#[derive(Clone, Copy)]
pub(super) struct System {
    pub krylov: ffi::KSP,
    pub operator: ffi::Mat,
    pub right_side: ffi::Vec,
    pub solution: ffi::Vec,
}

impl Default for History {
    fn default() -> History {
        History {
            recording: false,
            buffer: Vec::new(),
            defect: ptr::null_mut(),
            guess: false,
            first: 0.0,
            residuals: Vec::new(),
            attempts: Vec::new(),
        }
    }
}

impl History {
    /// Forgets all solves, and sets whether the next ones are recorded.
    pub(super) fn clear(&mut self, recording: bool) {
        self.recording = recording;
        self.residuals.clear();
        self.attempts.clear();
    }

    /// The solves, a repeated one twice.
    pub fn attempts(&self) -> &[Attempt] {
        &self.attempts
    }

    /// The residuals of an attempt, each after its Krylov iteration.
    pub fn residuals(&self, attempt: &Attempt) -> &[(u32, f64)] {
        self.residuals.get(attempt.residuals.clone()).unwrap_or_default()
    }

    /// Gets ready for a solve. Collective.
    pub(super) fn begin(&mut self, system: System) -> Result<()> {
        if !self.recording {
            return Ok(());
        }
        let mut r = 0.0;
        let mut a = 0.0;
        let mut d = 0.0;
        let mut most = 0;
        let mut guesses = ffi::PETSC_FALSE;
        // SAFETY: `system` is alive; outputs are numbers.
        unsafe {
            let tolerances =
                ffi::KSPGetTolerances(system.krylov, &mut r, &mut a, &mut d, &mut most);
            check("KSPGetTolerances", tolerances)?;
            let guessed = ffi::KSPGetInitialGuessNonzero(system.krylov, &mut guesses);
            check("KSPGetInitialGuessNonzero", guessed)?;
        }
        self.guess = guesses == ffi::PETSC_TRUE;
        if self.guess {
            self.first = self.defect(system)?;
        }
        // Some methods find one residual more.
        let room = usize::try_from(most).unwrap_or(0).min(MOST) + 2;
        if self.buffer.len() < room {
            self.buffer.resize(room, 0.0);
        }
        let at = self.buffer.as_mut_ptr();
        let room = self.buffer.len() as i32;
        // SAFETY: the buffer outlives the solver, whose owner destroys that first, and is handed
        // over anew after each growth, before the next solve.
        check("KSPSetResidualHistory", unsafe {
            ffi::KSPSetResidualHistory(system.krylov, at, room, ffi::PETSC_TRUE)
        })
    }

    /// Takes the residuals of a solve that took so many iterations. Collective.
    pub(super) fn end(&mut self, system: System, iterations: u32) -> Result<()> {
        if !self.recording {
            return Ok(());
        }
        let mut rtol = 0.0;
        let mut atol = 0.0;
        let mut d = 0.0;
        let mut most = 0;
        let mut kind = 0;
        let mut count = 0;
        let mut last = 0.0;
        // SAFETY: `system` is alive; outputs are numbers.
        unsafe {
            let tolerances =
                ffi::KSPGetTolerances(system.krylov, &mut rtol, &mut atol, &mut d, &mut most);
            check("KSPGetTolerances", tolerances)?;
            check("KSPGetNormType", ffi::KSPGetNormType(system.krylov, &mut kind))?;
            let counted = ffi::KSPGetResidualHistory(system.krylov, ptr::null_mut(), &mut count);
            check("KSPGetResidualHistory", counted)?;
            check("KSPGetResidualNorm", ffi::KSPGetResidualNorm(system.krylov, &mut last))?;
        }
        let kept = usize::try_from(count).unwrap_or(0).min(self.buffer.len());
        let norm = match kind {
            ffi::KSP_NORM_NONE => None,
            _ if kept == 0 => None,
            ffi::KSP_NORM_PRECONDITIONED => Some("preconditioned"),
            ffi::KSP_NORM_NATURAL => Some("natural"),
            _ => Some(TRUE_RESIDUAL),
        };
        let of_zero = self.norm_of_right_side(system)?;
        let first = if self.guess { self.first } else { of_zero };
        let begin = self.residuals.len();
        if norm.is_some() {
            self.take(kept, iterations, last, (norm == Some(TRUE_RESIDUAL)).then_some(first));
        } else {
            let last = self.defect(system)?;
            self.residuals.extend([(0, first), (iterations, last)]);
        }
        let tested = norm.is_some();
        let norm = norm.unwrap_or(TRUE_RESIDUAL);
        // PETSc does not say to which norm of the right side it refers, where that is another one.
        let first = self.residuals.get(begin).map_or(0.0, |first| first.1);
        let reference = if norm == TRUE_RESIDUAL && self.guess { of_zero } else { first };
        self.attempts.push(Attempt {
            norm,
            reference,
            tolerance: tested.then(|| atol.max(rtol * reference)),
            iterations,
            residuals: begin..self.residuals.len(),
        });
        Ok(())
    }

    /// Takes the residuals that PETSc has kept of a solve, and the last of it, after so many
    /// iterations; the `first` one too, where it is known and the method does not keep it.
    fn take(&mut self, kept: usize, iterations: u32, last: f64, first: Option<f64>) {
        let History { buffer, residuals, .. } = self;
        let all = &buffer[..kept];
        let count = iterations as usize;
        let cut = kept == buffer.len() && count >= kept;
        let lacks = |first: &f64| (all[0] - first).abs() > 1e-6 * first;
        let first = first.filter(|first| !cut && kept != count + 1 && lacks(first));
        residuals.extend(first.map(|first| (0, first)));
        let before = usize::from(first.is_some());
        let end = kept.saturating_sub(1);
        let spread = f64::from(iterations) / (before + end).max(1) as f64;
        let number = |k: usize| match k {
            _ if cut => k as u32,
            _ if k == end && kept > 1 => iterations,
            _ if kept == count || kept == count + 1 => k as u32,
            _ => ((before + k) as f64 * spread).round() as u32,
        };
        residuals.extend(all.iter().enumerate().map(|(k, residual)| (number(k), *residual)));
        let ended = residuals.last().is_some_and(|residual| residual.0 == iterations);
        residuals.extend((!ended).then_some((iterations, last)));
    }

    /// The 2-norm of the right side. Collective.
    fn norm_of_right_side(&self, system: System) -> Result<f64> {
        let mut norm = 0.0;
        // SAFETY: `system` is alive; the output is a number.
        check("VecNorm", unsafe { ffi::VecNorm(system.right_side, ffi::NORM_2, &mut norm) })?;
        Ok(norm)
    }

    /// The 2-norm of `b - A x`. Collective.
    fn defect(&mut self, system: System) -> Result<f64> {
        let mut norm = 0.0;
        // SAFETY: `system` is alive; the scratch vector is ours, made once and destroyed when
        // dropped.
        unsafe {
            if self.defect.is_null() {
                check("VecDuplicate", ffi::VecDuplicate(system.right_side, &mut self.defect))?;
            }
            check("MatMult", ffi::MatMult(system.operator, system.solution, self.defect))?;
            check("VecAYPX", ffi::VecAYPX(self.defect, -1.0, system.right_side))?;
            check("VecNorm", ffi::VecNorm(self.defect, ffi::NORM_2, &mut norm))?;
        }
        Ok(norm)
    }
}

impl Drop for History {
    fn drop(&mut self) {
        // SAFETY: the vector is null (PETSc then does nothing) or ours.
        unsafe {
            ffi::VecDestroy(&mut self.defect);
        }
    }
}
