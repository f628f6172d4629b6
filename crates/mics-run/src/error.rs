//! The one error type: what went wrong, where, and what to do about it.

use std::fmt;
use std::path::{Path, PathBuf};

/// The exit status after an interruption.
pub const INTERRUPTED: u8 = 130;

/// Every failure that a user can cause or meet.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The case file is wrong; nothing has been written. Rendered as `file:line: key: message`.
    #[error("{}{}", render_place(.file, *.line, .key, .message), .given.describe())]
    Case {
        /// The case file as the user named it.
        file: PathBuf,
        /// One-based line of the offending key, where one is known.
        line: Option<usize>,
        /// Dotted path of the offending key (`particle.0.density`), empty where the whole file is
        /// meant.
        key: String,
        /// The fault, and what would be right.
        message: String,
        /// Origin of the key.
        given: Given,
    },
    /// The command line is wrong; nothing has been written.
    #[error("{0}")]
    Usage(String),
    /// PETSc or MPI reported an error.
    #[error("PETSc: {message} ({call})")]
    Petsc {
        /// The call of ours that failed.
        call: &'static str,
        /// PETSc's own message, with its file and line.
        message: String,
    },
    /// An override is wrong; nothing has been written.
    #[error("bad --set `{given}`: {why}")]
    Override {
        /// The override as it was given.
        given: String,
        /// The fault in it.
        why: String,
    },
    /// The run failed: a promise (divergence below D0, say) could not be kept.
    #[error("{0}")]
    Run(String),
    /// The run diverged.
    #[error("{0}")]
    NotFinite(NotFinite),
    /// Somebody asked the run to stop; it has written a checkpoint.
    #[error("{0}")]
    Interrupted(String),
    /// `mics validate` ran, and values fall short of their references; or `mics study` ran, and
    /// some of its runs are not done.
    #[error("{0}")]
    Short(String),
    /// A file could not be read or written.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
}

/// A quantity of the state that is infinite or not a number.
#[derive(Clone, Debug, PartialEq)]
pub enum NotFinite {
    /// A velocity of the fluid; who holds the fields can say where.
    Velocity,
    /// The kinetic energy, of velocities that are finite.
    Energy,
    /// A field in a cell.
    Cell {
        /// The field.
        field: &'static str,
        /// The cell, counted from 0 along each axis.
        cell: Vec<usize>,
        /// Its centre (m).
        at: Vec<f64>,
    },
    /// The place, velocity or spin of a particle (its index in the case).
    Particle(usize),
}

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            NotFinite::Velocity => write!(f, "a velocity is not a finite number"),
            NotFinite::Energy => write!(
                f,
                "the kinetic energy is not a finite number: the flow is too fast to square"
            ),
            NotFinite::Cell { field, cell, at } => {
                let cell: Vec<String> = cell.iter().map(usize::to_string).collect();
                let at: Vec<String> = at.iter().map(|x| format!("{x:.6}")).collect();
                write!(
                    f,
                    "{field} is not a finite number in cell ({}) at ({}) m",
                    cell.join(", "),
                    at.join(", ")
                )
            }
            NotFinite::Particle(index) => {
                write!(
                    f,
                    "the place, velocity or spin of particle {index} is not a finite number: \
                    shorten the step"
                )
            }
        }
    }
}

/// Origin of a key of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Given {
    /// The case file, or nothing.
    File,
    /// `--set` on the command line.
    Set,
    /// The case's preset.
    Preset,
}

impl Given {
    fn describe(self) -> &'static str {
        match self {
            Given::File => "",
            Given::Set => " (given by --set)",
            Given::Preset => " (given by preset)",
        }
    }
}

/// The result of anything that can fail in this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// The process's exit status: 1 when values fall short of their references or runs of a study
    /// are not done, 2 when the case or the command line is wrong, 3 when the run failed, 130 when
    /// it was interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Short(_) => 1,
            Error::Case { .. } | Error::Usage(_) | Error::Override { .. } => 2,
            Error::Petsc { .. } | Error::Run(_) | Error::NotFinite(_) | Error::Io { .. } => 3,
            Error::Interrupted(_) => INTERRUPTED,
        }
    }

    /// Wraps a system error with the path it happened at: `.map_err(Error::io(path))`.
    pub fn io(path: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.as_ref().to_owned();
        move |source| Error::Io { path, source }
    }
}

fn render_place(file: &Path, line: Option<usize>, key: &str, message: &str) -> String {
    let mut text = file.display().to_string();
    if let Some(line) = line {
        text += &format!(":{line}");
    }
    if !key.is_empty() {
        text += &format!(": {key}");
    }
    text + ": " + message
}
