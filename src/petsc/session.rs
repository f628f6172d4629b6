//! PETSc's life from initialisation to finalisation, its options, and communication between ranks
//! meanwhile: sums, largest values, gatherings.

use super::failure::{capture, check};
use super::options::{
    self, all_pairs, built_in, c_string, names_option, refuse_stray_words, unused_pairs,
};
use super::ranks::{Exchange, Number, Traffic};
use super::stage::{self, LogStage, Logged};
use crate::{Error, Result};
use petsc_sys as ffi;
use std::cell::Cell;
use std::ffi::{CString, c_char, c_int, c_void};
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
    /// Traffic of our own calls so far.
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

    /// Traffic of this rank so far, PETSc's messages and ours.
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

    /// Counts the traffic of one of our own calls.
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
        let mut major = 0;
        let mut minor = 0;
        let mut patch = 0;
        let mut release = 0;
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

    /// Sums each number over the ranks, in place.
    pub fn sum(&self, values: &mut [f64]) -> Result<()> {
        self.reduce(values, (&raw mut ffi::ompi_mpi_op_sum).cast())
    }

    /// The largest over the ranks of each number, in place; a NaN counts as infinity, so that none
    /// is lost.
    pub fn max(&self, values: &mut [f64]) -> Result<()> {
        for v in values.iter_mut().filter(|v| v.is_nan()) {
            *v = f64::INFINITY;
        }
        self.reduce(values, (&raw mut ffi::ompi_mpi_op_max).cast())
    }

    /// Sums numbers over the ranks and finds the largest of others, in place, by one gathering.
    pub fn sum_and_max(&self, sums: &mut [f64], largest: &mut [f64]) -> Result<()> {
        for v in largest.iter_mut().filter(|v| v.is_nan()) {
            *v = f64::INFINITY;
        }
        if self.size() == 1 {
            return Ok(());
        }
        let mine = [&*sums, &*largest].concat();
        let mut all = vec![0.0; mine.len() * self.size()];
        let counts = vec![mine.len() as i32; self.size()];
        let starts: Vec<i32> = (0..self.size()).map(|rank| (rank * mine.len()) as i32).collect();
        self.all_gather(&mine, &mut all, &counts, &starts)?;
        sums.fill(0.0);
        for one in all.chunks_exact(mine.len()) {
            let (summed, compared) = one.split_at(sums.len());
            sums.iter_mut().zip(summed).for_each(|(sum, n)| *sum += n);
            largest.iter_mut().zip(compared).for_each(|(most, n)| *most = most.max(*n));
        }
        Ok(())
    }

    fn reduce(&self, values: &mut [f64], op: ffi::MPI_Op) -> Result<()> {
        if self.size() == 1 || values.is_empty() {
            return Ok(());
        }
        self.tell(Traffic::meeting(size_of_val(values)));
        // OpenMPI's MPI_IN_PLACE, a macro that bindgen cannot see.
        let in_place = ptr::without_provenance_mut::<c_void>(1);
        // SAFETY: the buffer holds as many doubles as said, and every rank calls with as many.
        check("MPI_Allreduce", unsafe {
            let double = (&raw mut ffi::ompi_mpi_double).cast();
            ffi::MPI_Allreduce(
                in_place,
                values.as_mut_ptr().cast(),
                values.len() as c_int,
                double,
                op,
                self.comm(),
            )
        })
    }

    /// Sends numbers to one rank while others come from another, or from the same. Ranks make such
    /// calls in pairs, in an order in which they meet.
    pub(crate) fn swap<T: Number>(
        &self,
        send: &[T],
        to: Option<usize>,
        receive: &mut [T],
        from: Option<usize>,
    ) -> Result<()> {
        if to.is_none() && from.is_none() {
            return Ok(());
        }
        // OpenMPI's MPI_PROC_NULL: a message to nobody.
        let rank = |r: Option<usize>| r.map_or(-2, |r| r as c_int);
        if to.is_some() {
            self.tell(Traffic::message(size_of_val(send)));
        }
        // SAFETY: both buffers hold as many numbers as said; messages between two ranks keep their
        // order.
        check("MPI_Sendrecv", unsafe {
            let number = T::datatype();
            let tag = 0;
            let out = send.as_ptr().cast();
            let n = send.len() as c_int;
            let into = receive.as_mut_ptr().cast();
            let room = receive.len() as c_int;
            let to = rank(to);
            let from = rank(from);
            let comm = self.comm();
            let none = ptr::null_mut();
            ffi::MPI_Sendrecv(out, n, number, to, tag, into, room, number, from, tag, comm, none)
        })
    }

    /// Swaps numbers with other ranks, all at once: to and from each of the `partners`, by rank, as
    /// many as said, one partner's after the other's in `send` and in `receive`. The partners make
    /// the same call.
    pub(crate) fn exchange(
        &self,
        partners: impl Iterator<Item = (usize, usize)> + Clone,
        send: &[f64],
        receive: &mut [f64],
        Exchange { requests }: &mut Exchange,
    ) -> Result<()> {
        let total = partners.clone().map(|(_, count)| count).sum::<usize>();
        if total > send.len() || total > receive.len() {
            return Err(Error::Run("an exchange does not fit its buffers".into()));
        }
        requests.clear();
        let double = f64::datatype();
        let comm = self.comm();
        let mut begin = 0;
        for (rank, count) in partners {
            let out = &send[begin..][..count];
            let into = &mut receive[begin..][..count];
            begin += count;
            self.tell(Traffic::message(size_of_val(out)));
            let rank = rank as c_int;
            let n = count as c_int;
            for _ in 0..2 {
                requests.push(ptr::null_mut());
            }
            let [.., receives, sends] = &mut requests[..] else { continue };
            // SAFETY: both parts hold as many numbers as said, and are left alone until all
            // requests have ended below; messages between two ranks keep their order.
            unsafe {
                let into = into.as_mut_ptr().cast();
                check("MPI_Irecv", ffi::MPI_Irecv(into, n, double, rank, 0, comm, receives))?;
                let out = out.as_ptr().cast();
                check("MPI_Isend", ffi::MPI_Isend(out, n, double, rank, 0, comm, sends))?;
            }
        }
        let n = requests.len() as c_int;
        // SAFETY: the requests are those just made; no statuses are asked for (null, OpenMPI's
        // MPI_STATUSES_IGNORE).
        check("MPI_Waitall", unsafe { ffi::MPI_Waitall(n, requests.as_mut_ptr(), ptr::null_mut()) })
    }

    /// Gathers every rank's numbers on all ranks: `counts` of them from `starts` on in `all`, by
    /// rank. Collective.
    pub(crate) fn all_gather<T: Number>(
        &self,
        mine: &[T],
        all: &mut [T],
        counts: &[i32],
        starts: &[i32],
    ) -> Result<()> {
        let fits = counts
            .iter()
            .zip(starts)
            .all(|(n, s)| *n >= 0 && *s >= 0 && (n + s) as usize <= all.len());
        if !fits
            || counts.len() != self.size()
            || starts.len() != self.size()
            || counts[self.rank()] as usize > mine.len()
        {
            return Err(Error::Run("a gathering does not fit its buffers".into()));
        }
        self.tell(Traffic::meeting(size_of_val(&mine[..counts[self.rank()] as usize])));
        // SAFETY: checked above, and every rank makes the same call.
        check("MPI_Allgatherv", unsafe {
            let number = T::datatype();
            let n = counts[self.rank()];
            let to = all.as_mut_ptr().cast();
            let counts = counts.as_ptr();
            let starts = starts.as_ptr();
            ffi::MPI_Allgatherv(
                mine.as_ptr().cast(),
                n,
                number,
                to,
                counts,
                starts,
                number,
                self.comm(),
            )
        })
    }

    /// Whether something holds on any rank. Collective.
    pub fn anywhere(&self, here: bool) -> Result<bool> {
        let mut flag = [f64::from(here)];
        self.max(&mut flag)?;
        Ok(flag[0] > 0.0)
    }

    /// Makes an error on one rank an error on all: those without one get that of the first rank
    /// which has one, with its exit status. Collective.
    pub fn agree<T>(&self, result: Result<T>) -> Result<T> {
        let mut first = [if result.is_err() { -(self.rank() as f64) } else { f64::NEG_INFINITY }];
        self.max(&mut first)?;
        if first[0] == f64::NEG_INFINITY {
            return result;
        }
        let rank = -first[0] as usize;
        let text = match &result {
            Err(e) if rank == self.rank() => e.to_string(),
            _ => String::new(),
        };
        let code =
            result.as_ref().err().filter(|_| rank == self.rank()).map_or(0, Error::exit_code);
        let mut size = [text.len() as f64, f64::from(code)];
        self.max(&mut size)?;
        // The sum of one rank's bytes and zeros from the others is those bytes.
        let mut bytes = vec![0.0; size[0] as usize];
        bytes.iter_mut().zip(text.bytes()).for_each(|(to, from)| *to = f64::from(from));
        self.sum(&mut bytes)?;
        let bytes: Vec<u8> = bytes.into_iter().map(|b| b as u8).collect();
        let text = String::from_utf8_lossy(&bytes);
        result.and(Err(match size[1] as u8 {
            2 => Error::Usage(format!("rank {rank}: {text}")),
            crate::error::INTERRUPTED => Error::Interrupted(text.into_owned()),
            _ => Error::Run(format!("rank {rank}: {text}")),
        }))
    }

    /// Sends this rank's bytes to rank 0, which hands each rank's to `take`, in the order of the
    /// ranks.
    pub fn gather(&self, bytes: &[f64], mut take: impl FnMut(usize, &[f64])) -> Result<()> {
        let double: ffi::MPI_Datatype = (&raw mut ffi::ompi_mpi_double).cast();
        let mut count = bytes.len() as f64;
        if self.rank() != 0 {
            self.tell(Traffic::message(size_of_val(bytes)));
            // SAFETY: both buffers hold what is said; rank 0 receives in the same order.
            unsafe {
                check(
                    "MPI_Send",
                    ffi::MPI_Send((&raw mut count).cast(), 1, double, 0, 0, self.comm()),
                )?;
                let n = bytes.len() as c_int;
                return check(
                    "MPI_Send",
                    ffi::MPI_Send(bytes.as_ptr().cast(), n, double, 0, 1, self.comm()),
                );
            }
        }
        take(0, bytes);
        for from in 1..self.size() {
            let mut buffer = Vec::new();
            // SAFETY: the first message is the length of the second; statuses are ignored (null,
            // OpenMPI's value).
            unsafe {
                let f = from as c_int;
                let none = ptr::null_mut();
                check(
                    "MPI_Recv",
                    ffi::MPI_Recv((&raw mut count).cast(), 1, double, f, 0, self.comm(), none),
                )?;
                buffer.resize(count as usize, 0.0);
                let n = buffer.len() as c_int;
                check(
                    "MPI_Recv",
                    ffi::MPI_Recv(buffer.as_mut_ptr().cast(), n, double, f, 1, self.comm(), none),
                )?;
            }
            take(from, &buffer);
        }
        Ok(())
    }

    /// Enters a stage of PETSc's log; the one before goes on when the value is dropped.
    ///
    /// # Errors
    /// When PETSc refuses.
    pub fn log(&self, stage: LogStage) -> Result<Logged> {
        // SAFETY: a number that PETSc gave, while it is running.
        check("PetscLogStagePush", unsafe {
            ffi::PetscLogStagePush(self.0.stages[stage as usize])
        })?;
        Ok(Logged { _session: self.clone() })
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
