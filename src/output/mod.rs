//! What a run leaves: logs, fields, figures, and their readers. Reads the state; the step does not
//! know of it.

use std::io::Write as _;

mod bodies;
pub mod checkpoint;
pub mod compare;
pub mod figure;
mod file;
pub mod film;
mod fit;
mod folder;
pub mod measure;
mod midline;
pub mod plot;
pub mod probe;
pub mod progress;
pub mod report;
mod rows;
pub mod snapshot;
pub mod statistics;
pub mod summary;
pub mod survey;
pub mod vti;
pub mod watch;

pub use file::replace;
pub use folder::{Folder, Log, Marks, StepRow, fields_file, may_use};

/// Prints a line that a command was asked for. A reader that has gone (`| head`) is no error; a
/// full disk is.
pub fn print(line: &str) -> crate::Result<()> {
    match writeln!(std::io::stdout(), "{line}") {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(crate::Error::io("standard output")(e))
        }
        _ => Ok(()),
    }
}

/// The refusal of a folder that holds no run, or not what is looked for.
fn not_a_run(run: &std::path::Path, what: &str) -> crate::Error {
    crate::Error::Usage(format!(
        "{}: not a run's folder ({what}); give a folder that `mics run` wrote",
        run.display()
    ))
}
