//! PETSc's failures, in its own words: a handler keeps the message, and a code becomes an error.

use crate::{Error, Result};
use petsc_sys as ffi;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::sync::Mutex;

/// PETSc's last message to its error handler: the first of the newest failure.
static HEARD: Mutex<Option<String>> = Mutex::new(None);

/// Keeps PETSc's message instead of printing it.
pub(super) unsafe extern "C" fn capture(
    _comm: ffi::MPI_Comm,
    line: c_int,
    function: *const c_char,
    file: *const c_char,
    code: ffi::PetscErrorCode,
    kind: ffi::PetscErrorType,
    message: *const c_char,
    _context: *mut c_void,
) -> ffi::PetscErrorCode {
    if kind == ffi::PETSC_ERROR_INITIAL {
        // SAFETY: PETSc hands over null or NUL-terminated strings that live during the call.
        let text = |s: *const c_char| unsafe {
            (!s.is_null()).then(|| CStr::from_ptr(s).to_string_lossy())
        };
        let said = text(message).unwrap_or_default();
        let heard = format!(
            "{} [{} at {}:{line}]",
            said.trim().replace('\n', " "),
            text(function).unwrap_or_default(),
            text(file).unwrap_or_default()
        );
        if let Ok(mut slot) = HEARD.lock() {
            *slot = Some(heard);
        }
    }
    code
}

/// Keeps a message of our own for the failure that PETSc is about to be told of.
pub(super) fn hear(message: &str) {
    if let Ok(mut slot) = HEARD.lock() {
        *slot = Some(message.to_owned());
    }
}

/// Turns a PETSc (or MPI) code into a result with PETSc's own words.
pub(super) fn check(call: &'static str, code: ffi::PetscErrorCode) -> Result<()> {
    if code == 0 {
        return Ok(());
    }
    let heard = HEARD.lock().ok().and_then(|mut slot| slot.take());
    Err(Error::Petsc { call, message: heard.unwrap_or_else(|| format!("error code {code}")) })
}

/// PETSc's table of names for converged reasons, read at `reason`.
pub(super) fn reason_name(reason: ffi::KSPConvergedReason) -> String {
    // SAFETY: KSPConvergedReasons points into a static table that PETSc indexes by negative and
    // positive reasons.
    unsafe {
        let name = *ffi::KSPConvergedReasons.offset(reason as isize);
        if name.is_null() {
            format!("reason {reason}")
        } else {
            CStr::from_ptr(name).to_string_lossy().into_owned()
        }
    }
}

/// PETSc's reason for the end of a solve, positive where it has converged, and its iterations.
#[derive(Clone, Copy)]
pub(super) struct Ended {
    pub reason: ffi::KSPConvergedReason,
    pub iterations: u32,
}

/// PETSc's `KSP_DIVERGED_ITS`: more iterations than `-ksp_max_it` allows.
const TOO_MANY: i32 = -3;

/// Advice in messages on how to see why a solve fails.
const LOOK: &str = "look at it with `-- -ksp_monitor_true_residual -ksp_converged_reason`";

/// PETSc's `KSP_DIVERGED_NANORINF`: a number that is infinite or none.
pub(super) const OVERFLOWN: i32 = -9;

/// The failure of a solve that met a number that is infinite or none: another method cures that
/// where the user chose this one, else no solver does.
pub(super) fn overflown(method: Option<String>) -> Error {
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
pub(super) fn failed_once(ended: Ended, rtol: f64) -> Error {
    let Ended { reason, iterations } = ended;
    Error::Run(format!(
        "the pressure solve failed: {} after {iterations} iterations (relative tolerance \
        {rtol:.1e}); {LOOK}, try another solver (pressure.solver = \"bcgs-boomeramg\", or `-- \
        -ksp_type cg -pc_type gamg`), or relax pressure.divergence_limit",
        reason_name(reason),
    ))
}

/// The failure of two solves, for PETSc's reasons after so many iterations each.
pub(super) fn failed_twice(first: Ended, second: Ended, rtol: f64) -> Error {
    let too_many = second.reason == TOO_MANY;
    Error::Run(format!(
        "the pressure solve failed twice: {} after {} iterations, then, from zero with a \
        rebuilt preconditioner, {} after {} (relative tolerance {rtol:.1e}); {LOOK}, {}take \
        the default solver (pressure.solver = \"auto\", without -ksp_type and -pc_type), or relax \
        pressure.divergence_limit",
        reason_name(first.reason),
        first.iterations,
        reason_name(second.reason),
        second.iterations,
        if too_many { "allow more iterations (`-- -ksp_max_it 5000`), " } else { "" },
    ))
}
