//! Free rigid bodies in the pressure equation, `sum_k w_k j_k j_k^T`, applied and never assembled:
//!
//! ```text
//!   s_k = j_k . x     over this rank's entries, then one sum over the ranks for all k
//!   y  += sum_k (w_k s_k) j_k
//! ```

use crate::petsc::Session;
use crate::{Error, Result};

/// One number of one mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeEntry {
    /// Which mode: `k` in `w_k j_k j_k^T`, from 0, the same on every rank.
    pub mode: u32,
    /// The cell, among this rank's own: x fastest, as in the right side.
    pub row: u32,
    /// `j_k` there; entries of the same mode and row add up.
    pub value: f64,
}

/// All modes, as far as they lie on this rank.
pub(super) struct Modes {
    session: Session,
    /// This rank's cells.
    owned: usize,
    weights: Vec<f64>,
    entries: Vec<ModeEntry>,
    /// s_k, then w_k s_k.
    sums: Vec<f64>,
}

impl Modes {
    pub fn new(session: &Session, owned: usize) -> Modes {
        Modes { session: session.clone(), owned, weights: Vec::new(), entries: Vec::new(), sums: Vec::new() }
    }

    /// See [`super::Poisson::set_modes`].
    pub fn set(&mut self, weights: &[f64], entries: &[ModeEntry]) -> Result<()> {
        let unsound = weights.iter().any(|w| !w.is_finite() || *w < 0.0)
            || entries
                .iter()
                .any(|e| e.mode as usize >= weights.len() || e.row as usize >= self.owned || !e.value.is_finite());
        if self.session.anywhere(unsound)? {
            return Err(Error::Run(
                "a free body's mode in the pressure equation is not finite, has a negative weight, or has a cell that \
                 is not its rank's"
                    .into(),
            ));
        }
        self.weights.clear();
        self.weights.extend_from_slice(weights);
        self.entries.clear();
        // Bodies that move cut now more cells, now fewer.
        if self.entries.capacity() < entries.len() {
            self.entries.reserve(2 * entries.len());
        }
        self.entries.extend_from_slice(entries);
        self.sums.resize(weights.len(), 0.0);
        Ok(())
    }

    /// y += sum_k w_k j_k (j_k . x). Collective.
    pub fn add_product(&mut self, x: &[f64], y: &mut [f64]) -> Result<()> {
        if self.weights.is_empty() {
            return Ok(());
        }
        let Modes { session, weights, entries, sums, .. } = self;
        sums.fill(0.0);
        entries.iter().for_each(|e| sums[e.mode as usize] += e.value * x[e.row as usize]);
        session.sum(sums)?;
        sums.iter_mut().zip(weights).for_each(|(s, w)| *s *= *w);
        entries.iter().for_each(|e| y[e.row as usize] += sums[e.mode as usize] * e.value);
        Ok(())
    }
}
