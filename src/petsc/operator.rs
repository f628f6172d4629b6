//! An operator of our own to PETSc: applied without a matrix, and preconditioned by what it brings
//! along.
//!
//! ```text
//!   KSP --- A: a matrix of type "shell" ------------------- multiply ----+
//!       \-- PC "boxmg" (type "shell") --------------- precondition ------+--- the Operator
//!           or any other, with P: an assembled matrix, which carries the Operator with it
//! ```
//! Where a matrix P is assembled, products are taken with it: `A x = P x + (A - P) x`. The
//! difference is what free bodies and a held mean velocity add, terms of low rank that are applied
//! body by body, and what keeps P definite in a closed box. Without these the matrix is the
//! operator itself.
//!
//! `-pc_type boxmg` is registered with PETSc and works wherever PETSc takes a preconditioner for
//! the whole system.

use super::Session;
use super::failure::{check, hear};
use super::vector::{read, write};
use crate::{Error, Result};
use petsc_sys as ffi;
use std::cell::RefCell;
use std::ffi::{CStr, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::{self, NonNull};
use std::rc::Rc;

/// A symmetric operator over this rank's cells, x fastest.
pub trait Operator {
    /// `y = A x`. Collective.
    fn multiply(&mut self, x: &[f64], y: &mut [f64]) -> Result<()>;

    /// Whether it is another than its matrix P; the same on every rank.
    fn differs_from_matrix(&self) -> bool;

    /// `y += (A - P) x`. Collective.
    fn add_difference(&mut self, x: &[f64], y: &mut [f64]) -> Result<()>;

    /// Setups of its own preconditioner so far.
    fn setups(&self) -> u32;

    /// Sets `z` to about the solution of `A z = r`, by a symmetric and positive map. Collective.
    fn precondition(&mut self, r: &[f64], z: &mut [f64]) -> Result<()>;

    /// Whether its preconditioner's options are sound, before anything is solved.
    ///
    /// # Errors
    /// When one is not.
    fn accept(&self) -> Result<()>;
}

/// The operator, as PETSc knows it and as we apply it.
pub(super) struct Shell {
    pub matrix: ffi::Mat,
    /// From a box, freed when dropped: the context of the shell and of what carries it, so it may
    /// not move.
    state: NonNull<State>,
}

struct State {
    operator: Rc<RefCell<dyn Operator>>,
    owned: usize,
    /// The assembled part of the operator, where the product is taken with that; else null.
    assembled: ffi::Mat,
    /// Error of the last call; PETSc passes on a number only.
    failure: Option<Error>,
}

/// PETSC_ERR_LIB, what a failed call tells PETSc.
const FAILED: ffi::PetscErrorCode = 76;

/// PETSC_ERR_SUP, for operations that are not supported.
const UNSUPPORTED: ffi::PetscErrorCode = 56;

/// The name of the operator's own preconditioner among PETSc's: `-pc_type boxmg`.
pub(super) const BOXMG: &CStr = c"boxmg";

/// Name under which matrices carry the operator.
const CARRIED: &CStr = c"mics_operator";

impl Shell {
    /// The operator of which `owned` rows are this rank's.
    pub fn new(
        session: &Session,
        operator: Rc<RefCell<dyn Operator>>,
        owned: usize,
    ) -> Result<Shell> {
        let state = Box::new(State { operator, owned, assembled: ptr::null_mut(), failure: None });
        let mut shell = Shell { matrix: ptr::null_mut(), state: NonNull::from(Box::leak(state)) };
        let n = owned as i32;
        let any = -1;
        // SAFETY: the matrix is an output that `shell` owns from then on; its context lives as long
        // as `shell`, and `multiply` has the signature that PETSc calls for these two operations.
        // `create` likewise; the names are static.
        unsafe {
            let context = shell.state.as_ptr().cast();
            check(
                "MatCreateShell",
                ffi::MatCreateShell(session.comm(), n, n, any, any, context, &mut shell.matrix),
            )?;
            for operation in [ffi::MATOP_MULT, ffi::MATOP_MULT_TRANSPOSE] {
                type Multiply =
                    unsafe extern "C" fn(ffi::Mat, ffi::Vec, ffi::Vec) -> ffi::PetscErrorCode;
                let multiply = std::mem::transmute::<Multiply, unsafe extern "C" fn()>(multiply);
                check(
                    "MatShellSetOperation",
                    ffi::MatShellSetOperation(shell.matrix, operation, Some(multiply)),
                )?;
            }
            check(
                "MatSetOption",
                ffi::MatSetOption(shell.matrix, ffi::MAT_SYMMETRIC, ffi::PETSC_TRUE),
            )?;
            shell.go_with(session, shell.matrix)?;
            check("PCRegister", ffi::PCRegister(BOXMG.as_ptr(), Some(create)))?;
        }
        Ok(shell)
    }

    /// Lets `matrix` carry the operator to preconditioners that are given it.
    ///
    /// # Safety
    /// The matrix is alive, and not used after `self` is dropped.
    pub unsafe fn go_with(&self, session: &Session, matrix: ffi::Mat) -> Result<()> {
        let mut container = ptr::null_mut();
        // SAFETY: the container is an output that is given up below; the matrix keeps its own
        // reference to it.
        unsafe {
            check(
                "PetscContainerCreate",
                ffi::PetscContainerCreate(session.comm(), &mut container),
            )?;
            let set = check(
                "PetscContainerSetPointer",
                ffi::PetscContainerSetPointer(container, self.state.as_ptr().cast()),
            )
            .and_then(|()| {
                check(
                    "PetscObjectCompose",
                    ffi::PetscObjectCompose(matrix.cast(), CARRIED.as_ptr(), container.cast()),
                )
            });
            check("PetscContainerDestroy", ffi::PetscContainerDestroy(&mut container))?;
            set
        }
    }

    /// Takes products with a matrix from now on, and adds the operator's terms beyond it.
    ///
    /// # Safety
    /// The matrix is alive as long as the shell is multiplied.
    pub unsafe fn multiply_by(&mut self, assembled: ffi::Mat) {
        // SAFETY: alive until `self` is dropped, and no solve runs while this borrow lasts.
        unsafe { self.state.as_mut().assembled = assembled }
    }

    /// Whether the operator is another than its matrix.
    pub fn differs_from_matrix(&self) -> Result<bool> {
        // SAFETY: as above; nothing changes it while this borrow lasts.
        let operator = unsafe { &self.state.as_ref().operator };
        Ok(operator.try_borrow().map_err(|_| in_use())?.differs_from_matrix())
    }

    /// Setups of the operator's own preconditioner so far.
    pub fn setups(&self) -> Result<u32> {
        // SAFETY: as above.
        let operator = unsafe { &self.state.as_ref().operator };
        Ok(operator.try_borrow().map_err(|_| in_use())?.setups())
    }

    /// Takes the error of a call out, if there is one.
    pub fn take_failure(&mut self) -> Option<Error> {
        // SAFETY: alive until `self` is dropped; PETSc reaches it too, but only during a solve,
        // which nobody runs while this borrow of `self` lasts.
        unsafe { self.state.as_mut().failure.take() }
    }
}

/// The failure of a call that finds the operator in use: a fault of the program.
fn in_use() -> Error {
    Error::Run("the pressure's operator is in use while PETSc asks for it".into())
}

impl Drop for Shell {
    fn drop(&mut self) {
        // SAFETY: the matrix is null or ours; whoever else holds it (the Krylov solver) is gone or
        // multiplies no more. The state came out of a box and is given up here only.
        unsafe {
            ffi::MatDestroy(&mut self.matrix);
            drop(Box::from_raw(self.state.as_ptr()));
        }
    }
}

/// The product that PETSc calls, also for the transpose: the operator is symmetric. No panic leaves
/// it.
unsafe extern "C" fn multiply(shell: ffi::Mat, x: ffi::Vec, y: ffi::Vec) -> ffi::PetscErrorCode {
    let mut context: *mut c_void = ptr::null_mut();
    // SAFETY: writes one pointer, the context that `Shell::new` gave this matrix and keeps alive,
    // at which nobody else looks during a call. PETSc hands over two vectors of the shell's layout.
    unsafe {
        let code = ffi::MatShellGetContext(shell, (&raw mut context).cast());
        if code != 0 {
            return code;
        }
        let state = &mut *context.cast::<State>();
        if state.assembled.is_null() {
            return state.call(x, y, |operator, x, y| operator.multiply(x, y));
        }
        let code = ffi::MatMult(state.assembled, x, y);
        if code != 0 {
            return code;
        }
        state.call(x, y, |operator, x, y| operator.add_difference(x, y))
    }
}

/// Makes a preconditioner the operator's own: a shell by the name of `boxmg`.
unsafe extern "C" fn create(pc: ffi::PC) -> ffi::PetscErrorCode {
    // SAFETY: PETSc hands over the preconditioner that is to become one; the name is copied, and
    // `apply` has the signature asked for.
    unsafe {
        let calls = [
            ffi::PCSetType(pc, c"shell".as_ptr()),
            ffi::PCShellSetName(pc, BOXMG.as_ptr()),
            ffi::PCShellSetApply(pc, Some(apply)),
            ffi::PCShellSetApplyTranspose(pc, Some(apply)),
        ];
        calls.into_iter().find(|code| *code != 0).unwrap_or(0)
    }
}

unsafe extern "C" fn apply(pc: ffi::PC, r: ffi::Vec, z: ffi::Vec) -> ffi::PetscErrorCode {
    let mut a = ptr::null_mut();
    let mut p = ptr::null_mut();
    let mut carried: ffi::PetscObject = ptr::null_mut();
    let mut context: *mut c_void = ptr::null_mut();
    // SAFETY: each call writes one pointer; what a matrix carries under our name is a container of
    // ours, whose state lives as long as the matrix is used, and at which nobody else looks during
    // a call.
    unsafe {
        let code = ffi::PCGetOperators(pc, &mut a, &mut p);
        if code != 0 {
            return code;
        }
        let code = ffi::PetscObjectQuery(p.cast(), CARRIED.as_ptr(), &mut carried);
        if code != 0 {
            return code;
        }
        if carried.is_null() {
            hear(
                "boxmg preconditions the whole system only, not a part of it (as in bjacobi or \
                asm)",
            );
            return UNSUPPORTED;
        }
        let code = ffi::PetscContainerGetPointer(carried.cast(), &mut context);
        if code != 0 {
            return code;
        }
        (*context.cast::<State>()).call(r, z, |operator, r, z| operator.precondition(r, z))
    }
}

impl State {
    /// Lets the operator make `y` from `x`.
    ///
    /// # Safety
    /// Both vectors are alive, differ, and have `owned` entries here.
    unsafe fn call(
        &mut self,
        x: ffi::Vec,
        y: ffi::Vec,
        act: impl FnOnce(&mut dyn Operator, &[f64], &mut [f64]) -> Result<()>,
    ) -> ffi::PetscErrorCode {
        let operator = &self.operator;
        let owned = self.owned;
        let called = catch_unwind(AssertUnwindSafe(|| {
            let Ok(mut operator) = operator.try_borrow_mut() else {
                return Err(in_use());
            };
            let mut acted = Ok(());
            // SAFETY: the caller's word.
            unsafe { read(x, owned, |x| write(y, owned, |y| acted = act(&mut *operator, x, y)))?? }
            acted
        }));
        match called.unwrap_or_else(|_| Err(Error::Run("the pressure's operator panicked".into())))
        {
            Ok(()) => 0,
            Err(error) => {
                self.failure = Some(error);
                FAILED
            }
        }
    }
}
