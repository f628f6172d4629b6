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

/// A value per body, summed over the ranks, and the scratch of that.
#[derive(Debug)]
pub struct BodySums<T> {
    values: Vec<T>,
    buffer: Vec<f64>,
}

impl<T: Summed> BodySums<T> {
    /// Room for so many bodies.
    pub fn with_capacity(n: usize) -> BodySums<T> {
        BodySums { values: Vec::with_capacity(n), buffer: Vec::new() }
    }

    /// Sums over the ranks what `own` gives of each body. Collective.
    ///
    /// # Errors
    /// When ranks cannot reach each other.
    pub fn sum(&mut self, session: &Session, own: impl Iterator<Item = T>) -> Result<&mut [T]> {
        self.values.clear();
        self.values.extend(own);
        over_ranks(session, &mut self.values, &mut self.buffer)?;
        Ok(&mut self.values)
    }
}

/// Sums over the ranks each number of each value, in place; in `buffer` is scratch. Collective: all
/// ranks have as many.
///
/// # Errors
/// When ranks cannot reach each other.
pub fn over_ranks<T: Summed>(
    session: &Session,
    values: &mut [T],
    buffer: &mut Vec<f64>,
) -> Result<()> {
    if session.size() == 1 {
        return Ok(());
    }
    buffer.clear();
    values.iter_mut().for_each(|value| value.each(&mut |part| buffer.extend_from_slice(part)));
    session.sum(buffer)?;
    let mut sums = buffer.iter();
    for value in values {
        value.each(&mut |part| part.iter_mut().zip(&mut sums).for_each(|(n, sum)| *n = *sum));
    }
    Ok(())
}
