//! Communication between ranks: the kinds of numbers, and counts of messages and bytes.

use petsc_sys as ffi;

/// Traffic of a rank: the number of collective operations and the bytes that it gave to them, the
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

    /// Combines the numbers of two, one by one.
    fn with(self, other: Traffic, put: fn(f64, f64) -> f64) -> Traffic {
        Traffic {
            collectives: put(self.collectives, other.collectives),
            collective_bytes: put(self.collective_bytes, other.collective_bytes),
            messages: put(self.messages, other.messages),
            message_bytes: put(self.message_bytes, other.message_bytes),
        }
    }

    /// One collective operation, to which this rank gives so many bytes.
    pub(super) fn meeting(bytes: usize) -> Traffic {
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
    /// Zero.
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
    pub(super) requests: Vec<ffi::MPI_Request>,
}
