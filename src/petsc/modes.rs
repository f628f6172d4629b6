//! Free rigid bodies in the pressure equation: the operator `A + sum_k w_k j_k j_k^T`, applied and never assembled.
//!
//! ```text
//!   s_k = j_k . x     over this rank's entries, then one sum over the ranks for all k
//!   y   = A x + sum_k (w_k s_k) j_k
//! ```
//! A mode `j_k` is one direction in which a body moves: non-zero only in the cells that the body's surface cuts, on as
//! many ranks as own some of them. To PETSc the operator is a matrix of its type "shell" that calls back here.

use super::Session;
use super::session::{check, read, write};
use crate::{Error, Result};
use petsc_sys as ffi;
use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::{self, NonNull};

/// One number of one mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeEntry {
    /// Which mode: `k` in `w_k j_k j_k^T`, from 0, the same on every rank.
    pub mode: u32,
    /// The cell, among this rank's own: x fastest, as in the right side.
    pub row: u32,
    /// `j_k` there; entries of the same mode and row add up.
    pub value: f64,
}

/// The operator, as PETSc knows it and as we apply it.
pub(super) struct Modes {
    shell: ffi::Mat,
    /// From a box, freed when dropped: the shell's context, so it may not move.
    state: NonNull<State>,
}

struct State {
    session: Session,
    matrix: ffi::Mat,
    owned: usize,
    weights: Vec<f64>,
    entries: Vec<ModeEntry>,
    /// s_k, then w_k s_k.
    sums: Vec<f64>,
    /// What went wrong in the last product; PETSc passes on a number only.
    failure: Option<Error>,
}

/// PETSC_ERR_LIB, what a failed product tells PETSc.
const FAILED: ffi::PetscErrorCode = 76;

impl Modes {
    /// The operator on top of `matrix`, whose `owned` rows are this rank's, without a mode yet. It uses the matrix's
    /// handle and does not own it.
    pub(super) fn new(
        session: &Session,
        matrix: ffi::Mat,
        owned: usize,
        null_space: ffi::MatNullSpace,
    ) -> Result<Modes> {
        let state = Box::new(State {
            session: session.clone(),
            matrix,
            owned,
            weights: Vec::new(),
            entries: Vec::new(),
            sums: Vec::new(),
            failure: None,
        });
        let mut modes = Modes { shell: ptr::null_mut(), state: NonNull::from(Box::leak(state)) };
        let (n, any) = (owned as i32, -1);
        // SAFETY: the shell is an output that `modes` owns from then on; its context lives as long as `modes`, and
        // `multiply` has the signature that PETSc calls for these two operations.
        unsafe {
            let context = modes.state.as_ptr().cast();
            check("MatCreateShell", ffi::MatCreateShell(session.comm(), n, n, any, any, context, &mut modes.shell))?;
            // PETSc's own scaling of a shell would scale the matrix below once more.
            check("MatShellSetManageScalingShifts", ffi::MatShellSetManageScalingShifts(modes.shell))?;
            for operation in [ffi::MATOP_MULT, ffi::MATOP_MULT_TRANSPOSE] {
                type Multiply = unsafe extern "C" fn(ffi::Mat, ffi::Vec, ffi::Vec) -> ffi::PetscErrorCode;
                let multiply = std::mem::transmute::<Multiply, unsafe extern "C" fn()>(multiply);
                check("MatShellSetOperation", ffi::MatShellSetOperation(modes.shell, operation, Some(multiply)))?;
            }
            check("MatSetOption", ffi::MatSetOption(modes.shell, ffi::MAT_SYMMETRIC, ffi::PETSC_TRUE))?;
            if !null_space.is_null() {
                check("MatSetNullSpace", ffi::MatSetNullSpace(modes.shell, null_space))?;
            }
        }
        Ok(modes)
    }

    /// The operator's handle, valid as long as `self`.
    pub(super) fn shell(&self) -> ffi::Mat {
        self.shell
    }

    /// See [`super::LinearSolver::set_modes`].
    pub(super) fn set(&mut self, weights: &[f64], entries: &[ModeEntry]) -> Result<()> {
        let state = self.state();
        let unsound = weights.iter().any(|w| !w.is_finite() || *w < 0.0)
            || entries
                .iter()
                .any(|e| e.mode as usize >= weights.len() || e.row as usize >= state.owned || !e.value.is_finite());
        if state.session.anywhere(unsound)? {
            return Err(Error::Run(
                "a free body's mode in the pressure equation is not finite, has a negative weight, or has a cell that \
                 is not its rank's"
                    .into(),
            ));
        }
        state.weights.clear();
        state.weights.extend_from_slice(weights);
        state.entries.clear();
        // Bodies that move cut now more cells, now fewer.
        if state.entries.capacity() < entries.len() {
            state.entries.reserve(2 * entries.len());
        }
        state.entries.extend_from_slice(entries);
        state.sums.resize(weights.len(), 0.0);
        Ok(())
    }

    /// What went wrong in a product, once.
    pub(super) fn take_failure(&mut self) -> Option<Error> {
        self.state().failure.take()
    }

    fn state(&mut self) -> &mut State {
        // SAFETY: alive until `self` is dropped; PETSc reaches it too, but only during a product, which nobody calls
        // while this borrow of `self` lasts.
        unsafe { self.state.as_mut() }
    }
}

impl Drop for Modes {
    fn drop(&mut self) {
        // SAFETY: the shell is null or ours; whoever else holds it (the Krylov solver) is gone or multiplies no more.
        // The state came out of a box and is given up here only.
        unsafe {
            ffi::MatDestroy(&mut self.shell);
            drop(Box::from_raw(self.state.as_ptr()));
        }
    }
}

/// The product that PETSc calls, also for the transpose: the operator is symmetric. No panic leaves it.
unsafe extern "C" fn multiply(shell: ffi::Mat, x: ffi::Vec, y: ffi::Vec) -> ffi::PetscErrorCode {
    let mut context: *mut c_void = ptr::null_mut();
    // SAFETY: writes one pointer, the context that `Modes::new` gave this shell and keeps alive, at which nobody else
    // looks during a product.
    let state = unsafe {
        let code = ffi::MatShellGetContext(shell, (&raw mut context).cast());
        if code != 0 {
            return code;
        }
        &mut *context.cast::<State>()
    };
    // SAFETY: PETSc hands over two vectors of the shell's layout.
    let product = catch_unwind(AssertUnwindSafe(|| unsafe { state.multiply(x, y) }));
    match product.unwrap_or_else(|_| Err(Error::Run("the product with the free bodies' modes panicked".into()))) {
        Ok(()) => 0,
        Err(error) => {
            state.failure = Some(error);
            FAILED
        }
    }
}

impl State {
    /// y = (A + sum_k w_k j_k j_k^T) x.
    ///
    /// # Safety
    /// Both vectors are alive, differ, and have `owned` entries here.
    unsafe fn multiply(&mut self, x: ffi::Vec, y: ffi::Vec) -> Result<()> {
        let State { entries, sums, .. } = self;
        // SAFETY: the caller's word; the matrix outlives the Krylov solver, which alone multiplies.
        unsafe {
            check("MatMult", ffi::MatMult(self.matrix, x, y))?;
            sums.fill(0.0);
            read(x, self.owned, |x| entries.iter().for_each(|e| sums[e.mode as usize] += e.value * x[e.row as usize]))?;
            self.session.sum(sums)?;
            sums.iter_mut().zip(&self.weights).for_each(|(s, w)| *s *= w);
            write(y, self.owned, |y| entries.iter().for_each(|e| y[e.row as usize] += sums[e.mode as usize] * e.value))
        }
    }
}
