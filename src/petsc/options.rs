//! PETSc's database of options: those of the user, and those of a built-in choice.

use super::failure::check;
use crate::{Error, Result};
use petsc_sys as ffi;
use std::collections::BTreeSet;
use std::ffi::{CStr, CString, c_char};
use std::ptr;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Names of the options that a built-in choice put in, so that they are not taken for the user's.
/// Like PETSc's database, one for the process.
static BUILT_IN: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

pub(super) fn built_in() -> MutexGuard<'static, BTreeSet<String>> {
    BUILT_IN.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn c_string(text: &str) -> Result<CString> {
    CString::new(text)
        .map_err(|_| Error::Usage(format!("a PETSc option holds a NUL character: {text:?}")))
}

/// All options in force, with their values.
pub(super) fn all_pairs() -> Result<Vec<(String, String)>> {
    let mut text: *mut c_char = ptr::null_mut();
    // SAFETY: PETSc allocates the string; it is copied before it is freed with PETSc's own free.
    let all = unsafe {
        check("PetscOptionsGetAll", ffi::PetscOptionsGetAll(ptr::null_mut(), &mut text))?;
        let all = CStr::from_ptr(text).to_string_lossy().into_owned();
        if let Some(free) = ffi::PetscTrFree {
            check("PetscFree", free(text.cast(), 0, ptr::null(), ptr::null()))?;
        }
        all
    };
    Ok(split_pairs(&all))
}

/// The options that nothing has read, with their values.
pub(super) fn unused_pairs() -> Result<Vec<(String, String)>> {
    let mut n = 0;
    let mut names = ptr::null_mut();
    let mut values = ptr::null_mut();
    let text = |s: *mut c_char| match s.is_null() {
        true => String::new(),
        // SAFETY: a NUL-terminated string of PETSc's.
        false => unsafe { CStr::from_ptr(s).to_string_lossy().into_owned() },
    };
    // SAFETY: PETSc fills two arrays of n strings each (a value may be null); copied before they go
    // back.
    unsafe {
        check(
            "PetscOptionsLeftGet",
            ffi::PetscOptionsLeftGet(ptr::null_mut(), &mut n, &mut names, &mut values),
        )?;
        let pair = |k| (text(*names.add(k)), text(*values.add(k)));
        let pairs = (0..n as usize).map(pair).collect();
        check(
            "PetscOptionsLeftRestore",
            ffi::PetscOptionsLeftRestore(ptr::null_mut(), &mut n, &mut names, &mut values),
        )?;
        Ok(pairs)
    }
}

/// The words of the options of a case, of PETSC_OPTIONS and of the command line, in this order:
/// later ones win.
pub(super) fn words(case: &str, command_line: &[String]) -> Vec<String> {
    let environment = std::env::var("PETSC_OPTIONS").unwrap_or_default();
    let words = [case, environment.as_str()];
    // As in a file of options, # begins a comment.
    let words = words.iter().flat_map(|text| text.lines()).map(|line| {
        let comment = line
            .match_indices('#')
            .find(|(at, _)| line[..*at].ends_with(char::is_whitespace) || *at == 0);
        comment.map_or(line, |(at, _)| &line[..at])
    });
    let words = words.flat_map(str::split_whitespace).map(str::to_owned);
    words.chain(command_line.iter().cloned()).collect()
}

/// Splits `-a 1 -b -c x y` into names (without the dash) and values.
fn split_pairs(text: &str) -> Vec<(String, String)> {
    let mut pairs: Vec<(String, String)> = Vec::new();
    for word in text.split_whitespace() {
        match (word.strip_prefix('-').filter(|_| names_option(word)), pairs.last_mut()) {
            (Some(name), _) => pairs.push((name.to_owned(), String::new())),
            (None, Some((_, value))) => *value = format!("{value} {word}").trim_start().to_owned(),
            (None, None) => {}
        }
    }
    pairs
}

/// Whether a word names an option; a dash before a digit is a number.
pub(super) fn names_option(word: &str) -> bool {
    word.strip_prefix('-').is_some_and(|n| n.starts_with(|c: char| c.is_ascii_alphabetic()))
}

/// PETSc passes over words that belong to no option, and so a forgotten dash would change nothing
/// in silence.
pub(super) fn refuse_stray_words(options: &[String]) -> Result<()> {
    let before = std::iter::once(None).chain(options.iter().map(Some));
    let stray = |(word, before): &(&String, Option<&String>)| {
        !names_option(word) && !before.is_some_and(|b| names_option(b))
    };
    match options.iter().zip(before).find(stray) {
        Some((word, _)) => Err(Error::Usage(format!(
            "PETSc option {word:?}: no option and no value of one; options begin with a dash, as \
            in -ksp_type cg"
        ))),
        None => Ok(()),
    }
}
