//! Sums over the ranks of what each has of every body: a struct with names for its numbers, not a
//! row of them by position.
//!
//! ```text
//!   rank 0   [ body 0 | body 1 | ... ]
//!   rank 1   [ body 0 | body 1 | ... ]      one reduction for all bodies,
//!              +        +                   in the order in which each struct names its numbers
//! ```

use crate::Result;
use crate::petsc::Session;
use nalgebra::Vector3;

/// Numbers that ranks sum.
pub trait Summed {
    /// Calls `take` with all of them, always in the same order.
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64]));
}

impl Summed for Vector3<f64> {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        take(self.as_mut_slice());
    }
}

/// The scratch of such sums.
#[derive(Debug, Default)]
pub struct Sums {
    buffer: Vec<f64>,
}

impl Sums {
    /// Sums over the ranks each number of each value, in place. Collective: all ranks have as many.
    ///
    /// # Errors
    /// When ranks cannot reach each other.
    pub fn over_ranks<T: Summed>(&mut self, session: &Session, values: &mut [T]) -> Result<()> {
        if session.size() == 1 {
            return Ok(());
        }
        let buffer = &mut self.buffer;
        buffer.clear();
        values.iter_mut().for_each(|value| value.each(&mut |part| buffer.extend_from_slice(part)));
        session.sum(buffer)?;
        let mut sums = buffer.iter();
        for value in values {
            value.each(&mut |part| part.iter_mut().zip(&mut sums).for_each(|(n, sum)| *n = *sum));
        }
        Ok(())
    }
}
