//! The one seam to PETSc and MPI, and the only `unsafe` of the crate.
//!
//! Owns: the session (initialise, options, captured errors, reductions), the decomposition of the
//! grid over ranks (a DMDA) with its halo exchange, and the linear solve (an operator of our own
//! with its preconditioner, assembly straight into storage for the others, Krylov, null space).
//! Every PETSc code becomes a [`crate::Error`]; nothing is printed and no signal handler stays
//! behind.
#![allow(unsafe_code)]

mod choice;
mod failure;
mod halo;
mod history;
mod krylov;
mod layout;
mod matrix;
mod operator;
mod options;
mod ranks;
mod reuse;
mod session;
mod solver;
mod stage;
mod structured;
mod vector;

pub use choice::Choice;
pub use halo::Halo;
pub use history::{Attempt, History};
pub use layout::Layout;
pub use operator::Operator;
pub use ranks::{Exchange, Number, Traffic};
pub use session::Session;
pub use solver::{LinearSolver, Solved};
pub use stage::{LogStage, Logged};
pub use vector::Pattern;
