//! What ranks tell each other: sums, largest values, gatherings.

use super::Session;
use super::failure::check;
use crate::{Error, Result};
use petsc_sys as ffi;
use std::ffi::{c_int, c_void};
use std::ptr;

/// What a rank tells others: how often all ranks had to meet and how many bytes it gave there,
/// messages to single ranks and their bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traffic {
    /// Sums, largest values, gatherings.
    pub collectives: f64,
    /// Bytes given to these; PETSc's own, which are few, are not counted.
    pub collective_bytes: f64,
    /// Messages that a rank sends.
    pub messages: f64,
    /// Their bytes.
    pub message_bytes: f64,
}

impl Traffic {
    /// The four, in their order.
    pub fn numbers(&self) -> [f64; 4] {
        [self.collectives, self.collective_bytes, self.messages, self.message_bytes]
    }

    /// Those of two, one by one.
    fn with(self, other: Traffic, put: fn(f64, f64) -> f64) -> Traffic {
        Traffic {
            collectives: put(self.collectives, other.collectives),
            collective_bytes: put(self.collective_bytes, other.collective_bytes),
            messages: put(self.messages, other.messages),
            message_bytes: put(self.message_bytes, other.message_bytes),
        }
    }

    /// One meeting of all ranks, to which this one brings so many bytes.
    fn meeting(bytes: usize) -> Traffic {
        Traffic { collectives: 1.0, collective_bytes: bytes as f64, ..Traffic::default() }
    }

    /// One message of so many bytes.
    pub(super) fn message(bytes: usize) -> Traffic {
        Traffic { messages: 1.0, message_bytes: bytes as f64, ..Traffic::default() }
    }
}

impl std::ops::Add for Traffic {
    type Output = Traffic;

    fn add(self, other: Traffic) -> Traffic {
        self.with(other, |a, b| a + b)
    }
}

impl std::ops::Sub for Traffic {
    type Output = Traffic;

    fn sub(self, other: Traffic) -> Traffic {
        self.with(other, |a, b| a - b)
    }
}

/// A number that fields hold and messages carry.
pub trait Number: Copy + sealed::Sealed + 'static {
    /// Nothing.
    const ZERO: Self;
    #[doc(hidden)]
    fn datatype() -> ffi::MPI_Datatype;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

impl Number for f32 {
    const ZERO: f32 = 0.0;
    fn datatype() -> ffi::MPI_Datatype {
        (&raw mut ffi::ompi_mpi_float).cast()
    }
}

impl Number for f64 {
    const ZERO: f64 = 0.0;
    fn datatype() -> ffi::MPI_Datatype {
        (&raw mut ffi::ompi_mpi_double).cast()
    }
}

/// Scratch of an exchange with several ranks at once.
#[derive(Debug, Default)]
pub struct Exchange {
    requests: Vec<ffi::MPI_Request>,
}

impl Session {
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

    /// Sums some numbers over the ranks, and finds the largest of others, in place: in one meeting.
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
        // Of zeros and one rank's bytes the sum is those bytes.
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
}
