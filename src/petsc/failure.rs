//! PETSc's failures, in its own words: a handler keeps the message, and a code becomes an error.

use crate::{Error, Result};
use petsc_sys as ffi;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::sync::Mutex;

/// What PETSc's error handler heard last: the first message of the newest failure.
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

/// Takes a message of our own for the failure that PETSc is about to be told of.
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
