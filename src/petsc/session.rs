//! PETSc's life from initialisation to finalisation, its options database and its errors.

use super::Traffic;
use crate::{Error, Result};
use petsc_sys as ffi;
use std::cell::Cell;
use std::collections::BTreeSet;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::rc::Rc;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{env, ptr, slice};

/// A running PETSc. Clones share it; the last one to go finalises it (and prints `-log_view`).
#[derive(Clone)]
pub struct Session(Rc<Inner>);

struct Inner {
    comm: ffi::MPI_Comm,
    rank: usize,
    size: usize,
    /// Whether this session initialised PETSc, and so has to finalise it.
    owner: bool,
    /// What our own calls have told other ranks.
    told: Cell<Traffic>,
}

/// Names of the options that a built-in choice put in, so that they are not taken for the user's.
/// Like PETSc's database, one for the process.
static BUILT_IN: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

fn built_in() -> MutexGuard<'static, BTreeSet<String>> {
    BUILT_IN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What PETSc's error handler heard last: the first message of the newest failure.
static HEARD: Mutex<Option<String>> = Mutex::new(None);

/// Keeps PETSc's message instead of printing it.
unsafe extern "C" fn capture(
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

fn c_string(text: &str) -> Result<CString> {
    CString::new(text)
        .map_err(|_| Error::Usage(format!("a PETSc option holds a NUL character: {text:?}")))
}

impl Session {
    /// Starts PETSc with the options of a case, PETSC_OPTIONS and the command line's, each winning
    /// over those before.
    ///
    /// # Errors
    /// As [`Session::start`].
    pub fn start_by(case: &str, command_line: &[String]) -> Result<Session> {
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
        Session::start(&words.chain(command_line.iter().cloned()).collect::<Vec<_>>())
    }

    /// Initialises PETSc with options in PETSc's own spelling (`-ksp_type`, `cg`, ...); later ones
    /// win, and all win over those that PETSc finds by itself (`PETSC_OPTIONS`, `.petscrc`). Where
    /// the process has a PETSc already, joins it and ignores `options`.
    ///
    /// # Errors
    /// When PETSc or MPI cannot start.
    pub fn start(options: &[String]) -> Result<Session> {
        let mut running: ffi::PetscBool = 0;
        // SAFETY: callable before initialisation; writes one PetscBool.
        check("PetscInitialized", unsafe { ffi::PetscInitialized(&mut running) })?;
        let owner = running == 0;
        if owner {
            let set = quicken_lone_start();
            let started = Self::initialise(options);
            for name in set {
                // SAFETY: as where it was set; MPI has read it, and a process started from here
                // (mpirun) must not.
                unsafe { env::remove_var(name) };
            }
            started?;
        }
        let (mut rank, mut size) = (0, 0);
        // SAFETY: PETSC_COMM_WORLD is set by PetscInitialize, which has returned; both calls write
        // one int.
        let comm = unsafe {
            let comm = ffi::PETSC_COMM_WORLD;
            check("MPI_Comm_rank", ffi::MPI_Comm_rank(comm, &mut rank))?;
            check("MPI_Comm_size", ffi::MPI_Comm_size(comm, &mut size))?;
            comm
        };
        Ok(Session(Rc::new(Inner {
            comm,
            rank: rank as usize,
            size: size as usize,
            owner,
            told: Cell::default(),
        })))
    }

    fn initialise(options: &[String]) -> Result<()> {
        refuse_stray_words(options)?;
        // PETSc takes a name in capitals for the same option, and what looks it up here has to as
        // well.
        let plain =
            |word: &String| if names_option(word) { word.to_lowercase() } else { word.clone() };
        let options: Vec<String> = options.iter().map(plain).collect();
        let words: Vec<CString> = ["mics", "-no_signal_handler"]
            .into_iter()
            .chain(options.iter().map(String::as_str))
            .map(c_string)
            .collect::<Result<_>>()?;
        // PETSc keeps argv for PetscGetArgs, so it lives as long as the process.
        let words = Box::leak(words.into_boxed_slice());
        let mut argv: Vec<*mut c_char> = words.iter().map(|w| w.as_ptr().cast_mut()).collect();
        argv.push(ptr::null_mut());
        let argc = Box::leak(Box::new(words.len() as c_int));
        let argv = Box::leak(Box::new(argv.leak().as_mut_ptr()));
        // SAFETY: argc and argv describe leaked, NUL-terminated strings ending with a null pointer;
        // no help text. `capture` has the signature that PETSc asks for and touches no PETSc state.
        unsafe {
            check(
                "PetscPushErrorHandler",
                ffi::PetscPushErrorHandler(Some(capture), ptr::null_mut()),
            )?;
            check("PetscInitialize", ffi::PetscInitialize(argc, argv, ptr::null(), ptr::null()))
                .map_err(|e| match e {
                    Error::Petsc { message, .. } => {
                        Error::Usage(format!("PETSc does not start with these options: {message}"))
                    }
                    other => other,
                })
        }
    }

    /// What this rank has told others so far, PETSc's messages and ours.
    pub fn traffic(&self) -> Traffic {
        // SAFETY: plain numbers that PETSc's calls count up on this thread, read by value.
        let theirs = unsafe {
            Traffic {
                collectives: ffi::petsc_allreduce_ct + ffi::petsc_gather_ct + ffi::petsc_scatter_ct,
                collective_bytes: 0.0,
                messages: ffi::petsc_isend_ct + ffi::petsc_send_ct,
                message_bytes: ffi::petsc_isend_len + ffi::petsc_send_len,
            }
        };
        self.0.told.get() + theirs
    }

    /// Counts what one of our own calls tells other ranks.
    pub(super) fn tell(&self, more: Traffic) {
        self.0.told.set(self.0.told.get() + more);
    }

    /// This process's rank.
    pub fn rank(&self) -> usize {
        self.0.rank
    }

    /// Number of ranks.
    pub fn size(&self) -> usize {
        self.0.size
    }

    pub(super) fn comm(&self) -> ffi::MPI_Comm {
        self.0.comm
    }

    /// PETSc's version, as `3.18.5`.
    pub fn version(&self) -> String {
        let (mut major, mut minor, mut patch, mut release) = (0, 0, 0, 0);
        // SAFETY: writes four integers.
        let code =
            unsafe { ffi::PetscGetVersionNumber(&mut major, &mut minor, &mut patch, &mut release) };
        if code == 0 { format!("{major}.{minor}.{patch}") } else { "unknown".into() }
    }

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
        Ok(self
            .pairs(Listing::All)?
            .into_iter()
            .find(|(n, _)| format!("-{n}") == name)
            .map(|(_, v)| v))
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
        let (n, v) = (c_string(name)?, c_string(value)?);
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
        let pairs = self.pairs(Listing::All)?;
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
        let left =
            self.pairs(Listing::Unused)?.into_iter().filter(|(n, _)| !late(n) && !ours.contains(n));
        Ok(left.map(|(n, v)| format!("-{n} {v}").trim_end().to_owned()).collect())
    }

    fn pairs(&self, listing: Listing) -> Result<Vec<(String, String)>> {
        match listing {
            Listing::All => {
                let mut text: *mut c_char = ptr::null_mut();
                // SAFETY: PETSc allocates the string; it is copied before it is freed with PETSc's
                // own free.
                let all = unsafe {
                    check(
                        "PetscOptionsGetAll",
                        ffi::PetscOptionsGetAll(ptr::null_mut(), &mut text),
                    )?;
                    let all = CStr::from_ptr(text).to_string_lossy().into_owned();
                    if let Some(free) = ffi::PetscTrFree {
                        check("PetscFree", free(text.cast(), 0, ptr::null(), ptr::null()))?;
                    }
                    all
                };
                Ok(split_pairs(&all))
            }
            Listing::Unused => {
                let (mut n, mut names, mut values) = (0, ptr::null_mut(), ptr::null_mut());
                // SAFETY: PETSc fills two arrays of n strings each (a value may be null); copied
                // before they go back.
                unsafe {
                    check(
                        "PetscOptionsLeftGet",
                        ffi::PetscOptionsLeftGet(ptr::null_mut(), &mut n, &mut names, &mut values),
                    )?;
                    let text = |s: *mut c_char| {
                        if s.is_null() {
                            String::new()
                        } else {
                            CStr::from_ptr(s).to_string_lossy().into_owned()
                        }
                    };
                    let pairs = (0..n as usize)
                        .map(|k| (text(*names.add(k)), text(*values.add(k))))
                        .collect();
                    check(
                        "PetscOptionsLeftRestore",
                        ffi::PetscOptionsLeftRestore(
                            ptr::null_mut(),
                            &mut n,
                            &mut names,
                            &mut values,
                        ),
                    )?;
                    Ok(pairs)
                }
            }
        }
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        if self.owner {
            // SAFETY: the last handle goes, so no PETSc object of ours is left. A failure here has
            // nobody to tell.
            unsafe { ffi::PetscFinalize() };
        }
    }
}

enum Listing {
    All,
    Unused,
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
fn names_option(word: &str) -> bool {
    word.strip_prefix('-').is_some_and(|n| n.starts_with(|c: char| c.is_ascii_alphabetic()))
}

/// PETSc passes over words that belong to no option, and so a forgotten dash would change nothing
/// in silence.
fn refuse_stray_words(options: &[String]) -> Result<()> {
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

/// Without mpirun, OpenMPI need not look for a network or a runtime: start-up falls from 0.5 s to
/// 0.1 s. Nor does it need a folder for temporary files: all lone processes would share one, and
/// one that ends removes it while another begins. Returns the variables that it set.
fn quicken_lone_start() -> Vec<&'static str> {
    let launched = ["OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"];
    if launched.iter().any(|name| env::var_os(name).is_some()) {
        return Vec::new();
    }
    let mut set = Vec::new();
    let alone = [
        ("OMPI_MCA_ess_singleton_isolated", "1"),
        ("OMPI_MCA_orte_create_session_dirs", "0"),
        ("OMPI_MCA_pml", "ob1"),
        ("OMPI_MCA_btl", "self"),
    ];
    for (name, value) in alone {
        if env::var_os(name).is_none() {
            // SAFETY: called once, before MPI starts and before this process has a second thread
            // that reads the environment (tests hold a lock here).
            unsafe { env::set_var(name, value) };
            set.push(name);
        }
    }
    set
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

/// Hands this rank's entries of a vector to `take`.
///
/// # Safety
/// `vector` is alive, has `len` entries here, and `take` does not touch it by another way.
pub(super) unsafe fn read<T>(
    vector: ffi::Vec,
    len: usize,
    take: impl FnOnce(&[f64]) -> T,
) -> Result<T> {
    let mut data = ptr::null();
    // SAFETY: PETSc lends the local part, `len` doubles (or null, where there are none), until it
    // is restored.
    unsafe {
        check("VecGetArrayRead", ffi::VecGetArrayRead(vector, &mut data))?;
        let taken = take(if len == 0 { &[] } else { slice::from_raw_parts(data, len) });
        check("VecRestoreArrayRead", ffi::VecRestoreArrayRead(vector, &mut data))?;
        Ok(taken)
    }
}

/// Lets `fill` change this rank's entries of a vector.
///
/// # Safety
/// As for [`read`].
pub(super) unsafe fn write(
    vector: ffi::Vec,
    len: usize,
    fill: impl FnOnce(&mut [f64]),
) -> Result<()> {
    let mut data = ptr::null_mut();
    // SAFETY: as for reading.
    unsafe {
        check("VecGetArray", ffi::VecGetArray(vector, &mut data))?;
        fill(if len == 0 { &mut [] } else { slice::from_raw_parts_mut(data, len) });
        check("VecRestoreArray", ffi::VecRestoreArray(vector, &mut data))
    }
}
