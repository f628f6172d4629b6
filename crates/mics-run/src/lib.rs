//! Cases and the files of runs: the case file, checked and filled in, and the files of a run's
//! folder with their readers. The solver writes these files, figures and reports read them; neither
//! knows of the other, and this crate knows neither.

pub mod bodies;
pub mod compare;
pub mod config;
#[cfg(test)]
mod cpu;
pub mod drag;
pub mod error;
pub mod file;
pub mod folder;
pub mod interrupt;
pub mod progress;
pub mod snapshot;
pub mod sparse;
pub mod summary;
pub mod vti;
pub mod words;

pub use error::{Error, Result};

use std::io::Write as _;

/// Prints a line that a command was asked for. A reader that has gone (`| head`) is no error; a
/// full disk is.
pub fn print(line: &str) -> Result<()> {
    match writeln!(std::io::stdout(), "{line}") {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::io("standard output")(e))
        }
        _ => Ok(()),
    }
}

/// The refusal of a folder that holds no run, or not what is looked for.
pub fn not_a_run(run: &std::path::Path, what: &str) -> Error {
    Error::Usage(format!(
        "{}: not a run's folder ({what}); give a folder that `mics run` wrote",
        run.display()
    ))
}
