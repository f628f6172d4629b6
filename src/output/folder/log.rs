//! The log of a run, `log.txt`, and what it shows on the screen.

use super::super::rows::LineFile;
use std::io::Write;

/// Lines for the screen and for `log.txt`.
pub struct Log {
    pub(super) file: Option<LineFile>,
    screen: bool,
}

impl Log {
    /// A log that prints when `screen` is set, and keeps nothing yet.
    pub fn new(screen: bool) -> Log {
        Log { file: None, screen }
    }

    /// Says a line.
    pub fn say(&mut self, line: &str) {
        if self.screen {
            // A closed pipe (`| head`) is no reason to end a run.
            let _ = writeln!(std::io::stdout(), "{line}");
        }
        self.keep(line);
    }

    /// Writes a line to `log.txt` alone: of what is said elsewhere.
    pub fn keep(&mut self, line: &str) {
        if let Some(file) = &mut self.file {
            // A line that the disk does not take is reported when the logs are flushed.
            let _ = file.add(format_args!("{line}"));
        }
    }
}
