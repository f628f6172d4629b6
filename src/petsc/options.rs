//! PETSc's database of options: those of the user, and those of a built-in choice.

use super::Session;
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

fn built_in() -> MutexGuard<'static, BTreeSet<String>> {
    BUILT_IN.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn c_string(text: &str) -> Result<CString> {
    CString::new(text)
        .map_err(|_| Error::Usage(format!("a PETSc option holds a NUL character: {text:?}")))
}

impl Session {
    /// Whether somebody set an option (`-ksp_type`).
    pub fn has_option(&self, name: &str) -> Result<bool> {
        let name = c_string(name)?;
        let mut set: ffi::PetscBool = 0;
        // SAFETY: null names the global database and no prefix; writes one PetscBool.
        check("PetscOptionsHasName", unsafe {
            ffi::PetscOptionsHasName(ptr::null_mut(), ptr::null(), name.as_ptr(), &mut set)
        })?;
        Ok(set != 0)
    }

    /// The value of an option in the database, if it is there.
    pub fn option(&self, name: &str) -> Result<Option<String>> {
        let named = all_pairs()?.into_iter().find(|(n, _)| format!("-{n}") == name);
        Ok(named.map(|(_, value)| value))
    }

    /// The value of an option of our own: PETSc no longer counts it as unused.
    pub fn used_option(&self, name: &str) -> Result<Option<String>> {
        if self.has_option(name)? { self.option(name) } else { Ok(None) }
    }

    /// Sets an option of the built-in choice, unless the user has set it.
    pub fn default_option(&self, name: &str, value: &str) -> Result<()> {
        if self.has_option(name)? {
            return Ok(());
        }
        let n = c_string(name)?;
        let v = c_string(value)?;
        // SAFETY: both strings are copied by PETSc.
        check("PetscOptionsSetValue", unsafe {
            ffi::PetscOptionsSetValue(ptr::null_mut(), n.as_ptr(), v.as_ptr())
        })?;
        built_in().insert(name.trim_start_matches('-').to_owned());
        Ok(())
    }

    /// Takes the options of a built-in choice out again, before another is made.
    pub fn forget_default_options(&self) -> Result<()> {
        for name in std::mem::take(&mut *built_in()) {
            let name = c_string(&format!("-{name}"))?;
            // SAFETY: PETSc only reads the string.
            check("PetscOptionsClearValue", unsafe {
                ffi::PetscOptionsClearValue(ptr::null_mut(), name.as_ptr())
            })?;
        }
        Ok(())
    }

    /// Whether the user set an option, and no built-in choice.
    pub fn user_option(&self, name: &str) -> Result<bool> {
        Ok(self.has_option(name)? && !built_in().contains(name.trim_start_matches('-')))
    }

    /// All options in force, as on a command line.
    pub fn options(&self) -> Result<String> {
        let pairs = all_pairs()?;
        let words = pairs.iter().filter(|(n, _)| n != "no_signal_handler");
        Ok(words
            .map(|(n, v)| format!("-{n} {v}").trim_end().to_owned())
            .collect::<Vec<_>>()
            .join(" "))
    }

    /// Options that the user gave and nothing read.
    pub fn unused_options(&self) -> Result<Vec<String>> {
        // These are read while PETSc starts or ends, which its list of unused options does not
        // always know.
        let late = |n: &str| ["no_signal_handler", "log_view", "options_left"].contains(&n);
        let ours = built_in();
        let left = unused_pairs()?.into_iter().filter(|(n, _)| !late(n) && !ours.contains(n));
        Ok(left.map(|(n, v)| format!("-{n} {v}").trim_end().to_owned()).collect())
    }
}

/// All options in force, with their values.
fn all_pairs() -> Result<Vec<(String, String)>> {
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
fn unused_pairs() -> Result<Vec<(String, String)>> {
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
