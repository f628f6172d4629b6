//! PETSc's life from initialisation to finalisation.

use super::Traffic;
use super::failure::{capture, check};
use super::options::{self, c_string, names_option, refuse_stray_words};
use super::stage;
use crate::{Error, Result};
use petsc_sys as ffi;
use std::cell::Cell;
use std::ffi::{CString, c_char, c_int};
use std::rc::Rc;
use std::{env, ptr};

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
    /// PETSc's numbers of the stages of its log.
    stages: stage::Stages,
}

impl Session {
    /// Starts PETSc with the options of a case, PETSC_OPTIONS and the command line's, each winning
    /// over those before.
    ///
    /// # Errors
    /// As [`Session::start`].
    pub fn start_by(case: &str, command_line: &[String]) -> Result<Session> {
        Session::start(&options::words(case, command_line))
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
            let set = quicken_start_without_mpirun();
            let started = Self::initialise(options);
            for name in set {
                // SAFETY: as where it was set; MPI has read it, and a process started from here
                // (mpirun) must not.
                unsafe { env::remove_var(name) };
            }
            started?;
        }
        let mut rank = 0;
        let mut size = 0;
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
            stages: stage::register()?,
        })))
    }

    /// Starts PETSc in this process.
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

    pub(super) fn stage(&self, index: usize) -> ffi::PetscLogStage {
        self.0.stages[index]
    }

    pub(super) fn comm(&self) -> ffi::MPI_Comm {
        self.0.comm
    }

    /// PETSc's version, as `3.18.5`.
    pub fn version(&self) -> String {
        let mut major = 0;
        let mut minor = 0;
        let mut patch = 0;
        let mut release = 0;
        // SAFETY: writes four integers.
        let code =
            unsafe { ffi::PetscGetVersionNumber(&mut major, &mut minor, &mut patch, &mut release) };
        if code == 0 { format!("{major}.{minor}.{patch}") } else { "unknown".into() }
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

/// Without mpirun, OpenMPI need not look for a network or a runtime: start-up falls from 0.5 s to
/// 0.1 s. Nor does it need a folder for temporary files: all such processes would share one, and
/// one that ends removes it while another begins. Returns the variables that it set.
fn quicken_start_without_mpirun() -> Vec<&'static str> {
    let launched = ["OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"];
    if launched.iter().any(|name| env::var_os(name).is_some()) {
        return Vec::new();
    }
    let mut set = Vec::new();
    let isolated = [
        ("OMPI_MCA_ess_singleton_isolated", "1"),
        ("OMPI_MCA_orte_create_session_dirs", "0"),
        ("OMPI_MCA_pml", "ob1"),
        ("OMPI_MCA_btl", "self"),
    ];
    for (name, value) in isolated {
        if env::var_os(name).is_none() {
            // SAFETY: called once, before MPI starts and before this process has a second thread
            // that reads the environment (tests hold a lock here).
            unsafe { env::set_var(name, value) };
            set.push(name);
        }
    }
    set
}
