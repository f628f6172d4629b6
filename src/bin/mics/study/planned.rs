//! A run of a study before it starts: what it is to be, or why it is refused.

use mics_run::Error;
use mics_run::config::Case;
use std::path::PathBuf;

/// A run of a study.
pub struct Planned {
    /// The name of its folder.
    pub id: String,
    /// Labels in its columns; empty where it has no such label.
    pub labels: Vec<String>,
    /// Number of ranks.
    pub ranks: usize,
    /// The case file.
    pub case: PathBuf,
    /// Overrides, `key.path=value`.
    pub set: Vec<String>,
    /// The case with them, or why it is refused.
    pub loaded: Result<Case, Refusal>,
    /// The keys of the study file that gave it.
    pub sources: Vec<String>,
}

/// Why a run is refused before it starts.
#[derive(Clone, Debug)]
pub struct Refusal {
    /// In words, the key ahead.
    pub why: String,
    /// Whether a key or a value is unknown, and not only out of range: no run means that.
    pub misspelt: bool,
}

impl Refusal {
    /// The refusal for an error in reading the case, without the place that only `--set` on a
    /// command line has.
    pub fn of(error: &Error) -> Refusal {
        let misspelt = match error {
            Error::Case { message, .. } => message.starts_with("unknown "),
            Error::Override { .. } => true,
            _ => false,
        };
        let why = match error {
            Error::Case { key, message, .. } if !key.is_empty() => format!("{key}: {message}"),
            Error::Override { given, why } => format!("bad override `{given}`: {why}"),
            other => other.to_string(),
        };
        Refusal { why, misspelt }
    }
}
