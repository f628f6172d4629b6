//! Measures: numbers that a run reports, of which a case asks for some. Each has samples in time
//! that become one number ([`Series`]); `kinds.rs` has a line for each kind.

mod kinds;
mod series;
#[cfg(test)]
mod tests;

use crate::contact::BodyOutcome;
use crate::particles::Body;
use crate::state::Exchange;
pub use series::{Series, series};

/// Remark beside a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// Whether the value may not be what its name says.
    pub doubt: bool,
    /// In words that follow on the value.
    pub words: String,
}

/// State after a step, and its forces, as the measures take them.
pub struct Sample<'a> {
    /// Time at its end (s).
    pub time: f64,
    /// Exchange of each particle with the fluid over it.
    pub exchange: &'a [Exchange],
    /// The particles at its end.
    pub bodies: &'a [Body],
    /// Largest speed of the fluid (m/s).
    pub max_speed: f64,
    /// Deepest overlap of contacts (m).
    pub deepest: f64,
    /// Per particle, what contacts did to it; empty without contacts.
    pub contacts: &'a [BodyOutcome],
}
