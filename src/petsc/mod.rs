//! The one seam to PETSc and MPI, and the only `unsafe` of the crate.
//!
//! Owns: the session (initialise, options, captured errors, reductions), the decomposition of the grid over ranks
//! (a DMDA) with its halo exchange, and the linear solve (assembly straight into storage, the rank-one modes of free
//! bodies on top of it, Krylov, null space).
//! Every PETSc code becomes a [`crate::Error`]; nothing is printed and no signal handler stays behind.
#![allow(unsafe_code)]

mod halo;
mod layout;
mod modes;
mod session;
mod solver;

pub use halo::Halo;
pub use layout::Layout;
pub use modes::ModeEntry;
pub use session::Session;
pub use solver::{LinearSolver, Solved};
