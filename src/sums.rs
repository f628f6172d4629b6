//! Sums over the ranks of the numbers that each has of every body: a struct with names for them,
//! not a row by position.
//!
//! [`BodyRanks`] says which bodies reach which ranks. Who needs the sums of all bodies on all ranks
//! gets them from the owners, the ranks of the bodies' centres.

use crate::Result;
use crate::particles::{Load, RigidVelocity};
use crate::petsc::Session;
use crate::reach::BodyRanks;
use crate::sharing;
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

/// A value per body, summed over the ranks.
#[derive(Debug)]
pub struct BodySums<T> {
    values: Vec<T>,
}

/// Scratch of the messages, one for all sums.
#[derive(Debug, Default)]
pub struct Messages {
    shared: sharing::Messages,
    counts: Vec<i32>,
    starts: Vec<i32>,
}

impl<T: Summed + Clone + Default> BodySums<T> {
    /// Room for so many bodies.
    pub fn with_capacity(n: usize) -> BodySums<T> {
        BodySums { values: Vec::with_capacity(n) }
    }

    /// Sums what `own` gives of each body that reaches this rank, over the ranks that it reaches;
    /// nothing of other bodies. Collective.
    ///
    /// # Errors
    /// When ranks cannot reach each other.
    pub fn sum_here(
        &mut self,
        session: &Session,
        reach: &BodyRanks,
        messages: &mut Messages,
        own: impl FnMut(usize) -> T,
    ) -> Result<&mut [T]> {
        self.take(reach, own);
        let values = &mut self.values;
        reach.sharing().sum(session, &mut messages.shared, width::<T>(), |k, take| {
            values[k].each(take);
        })?;
        Ok(&mut self.values)
    }

    /// As [`BodySums::sum_here`], but all ranks get the sums of all bodies. Collective.
    ///
    /// # Errors
    /// When ranks cannot reach each other.
    pub fn sum_for_all(
        &mut self,
        session: &Session,
        reach: &BodyRanks,
        messages: &mut Messages,
        own: impl FnMut(usize) -> T,
    ) -> Result<&mut [T]> {
        self.sum_here(session, reach, messages, own)?;
        self.hand_out(session, reach, messages)
    }

    /// Gives all ranks what `own` gives on the owner of each body. Collective.
    ///
    /// # Errors
    /// When ranks cannot reach each other.
    pub fn tell_all(
        &mut self,
        session: &Session,
        reach: &BodyRanks,
        messages: &mut Messages,
        own: impl FnMut(usize) -> T,
    ) -> Result<&mut [T]> {
        self.take(reach, own);
        self.hand_out(session, reach, messages)
    }

    fn take(&mut self, reach: &BodyRanks, mut own: impl FnMut(usize) -> T) {
        self.values.clear();
        self.values.resize(reach.bodies(), T::default());
        for k in reach.here() {
            self.values[k] = own(k);
        }
    }

    /// Gives all ranks the owners' values.
    fn hand_out(
        &mut self,
        session: &Session,
        reach: &BodyRanks,
        messages: &mut Messages,
    ) -> Result<&mut [T]> {
        let values = &mut self.values;
        let Messages { shared, counts, starts } = messages;
        let (mine, theirs) = shared.buffers();
        if session.size() > 1 {
            let width = width::<T>();
            mine.clear();
            for k in reach.owned_by(session.rank()) {
                values[k].each(&mut |part| mine.extend_from_slice(part));
            }
            counts.clear();
            starts.clear();
            let mut total = 0;
            for rank in 0..session.size() {
                let count = width * reach.owned_by(rank).len();
                counts.push(count as i32);
                starts.push(total as i32);
                total += count;
            }
            theirs.clear();
            theirs.resize(total, 0.0);
            session.all_gather(mine, theirs, counts, starts)?;
            let mut numbers = theirs.iter();
            for k in (0..session.size()).flat_map(|rank| reach.owned_by(rank)) {
                values[k].each(&mut |part| {
                    for (to, from) in part.iter_mut().zip(&mut numbers) {
                        *to = *from;
                    }
                });
            }
        }
        Ok(values)
    }
}

impl Summed for Load {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        self.force.each(take);
        self.torque.each(take);
    }
}

impl Summed for RigidVelocity {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        self.velocity.each(take);
        self.spin.each(take);
    }
}

/// Count of the numbers in a value.
fn width<T: Summed + Default>() -> usize {
    let mut width = 0;
    T::default().each(&mut |part| width += part.len());
    width
}
