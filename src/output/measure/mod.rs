//! Measures: numbers that a run reports. Those that a case asks for are samples in time that become
//! one number ([`Series`]; `kinds.rs` has a line for each); a library's user adds others through
//! the trait [`Measure`].

mod kinds;
mod series;
#[cfg(test)]
mod tests;

use crate::Result;
use crate::particles::Body;
use crate::scene::Scene;
use crate::state::Exchange;
use mics_run::compare::Comparison;
pub use series::{Series, series};

/// A number that a run reports in `summary.json`.
pub trait Measure<const D: usize> {
    /// Its name there.
    fn name(&self) -> &str;

    /// Its unit; empty where it has none.
    fn unit(&self) -> &str {
        ""
    }

    /// Takes the state after a step, in which the fluid's largest speed was this (m/s). Collective.
    ///
    /// # Errors
    /// When ranks cannot sum: the run ends.
    fn take(&mut self, scene: &Scene<D>, largest_speed: f64) -> Result<()>;

    /// The value so far; `None` where there is none yet. The same on all ranks.
    fn value(&self) -> Option<f64>;

    /// The value beside a reference, where there is one.
    fn comparison(&self) -> Option<Comparison> {
        None
    }

    /// What a reader has to know of the value.
    fn remark(&self) -> Option<Remark> {
        None
    }

    /// What a run that goes on from a checkpoint needs of it, in any words; the same on all ranks.
    /// [`Series`] are in checkpoints by themselves.
    fn kept(&self) -> String {
        String::new()
    }

    /// Goes on with what [`Measure::kept`] gave.
    ///
    /// # Errors
    /// When it is not that of such a measure.
    fn go_on(&mut self, _kept: &str) -> Result<()> {
        Ok(())
    }
}

/// What is to be said of a value beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// Whether the value may not be what its name says.
    pub doubt: bool,
    /// In words that follow on the value.
    pub words: String,
}

/// What a step gives to the measures.
pub struct Sample<'a> {
    /// Time at its end (s).
    pub time: f64,
    /// What each particle exchanged with the fluid over it.
    pub exchange: &'a [Exchange],
    /// The particles at its end.
    pub bodies: &'a [Body],
    /// Largest speed of the fluid (m/s).
    pub max_speed: f64,
    /// Deepest overlap of contacts (m).
    pub deepest: f64,
    /// Per particle, whether it touched something; empty without contacts.
    pub touched: &'a [bool],
}
