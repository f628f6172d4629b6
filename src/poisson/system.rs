//! The system of one solve as plain numbers, for others to solve:
//!
//! ```text
//!   A x = b,     A = A_fluid + sum_k w_k j_k j_k^T
//! ```
//! A_fluid has a row for each cell, x fastest: the sum of its faces' `beta/h^2` on the diagonal
//! and `-beta/h^2` beside it, without the shift of preconditioners ([`super::MatrixRows`]); the
//! factors are the modes of free bodies, and the mean velocity that a drive holds, whose weight is
//! negative.

use crate::Result;
use crate::petsc::Solved;
use mics_run::sparse::Sparse;

/// The system of a solve, its solution, and how the run itself solved it.
#[derive(Clone, Debug)]
pub struct System {
    /// A_fluid (m/kg).
    pub fluid: Sparse,
    /// Terms that are added to it.
    pub factors: Vec<Factor>,
    /// b (1/s2); where the system is singular, without its mean.
    pub right_side: Vec<f64>,
    /// x (Pa); where the system is singular, the one whose mean is zero.
    pub solution: Vec<f64>,
    /// The norm of `b - A x` over that of b.
    pub residual: f64,
    /// Whether constants solve the system for b = 0.
    pub singular: bool,
    /// The run's own solve of it.
    pub own: OwnSolve,
}

/// The run's own solve of a system: by its PETSc options, to tolerances that are part of what it
/// needed.
#[derive(Clone, Debug)]
pub struct OwnSolve {
    /// Part of the right side's norm to which the residual was to fall.
    pub rtol: f64,
    /// Residual (1/s2) that was small enough in any case; of a method that tests the true residual
    /// alone.
    pub atol: f64,
    /// Its iterations and setups, or why it failed.
    pub outcome: Result<Solved, String>,
}

/// A term `w j j^T` of a system's matrix.
#[derive(Clone, Debug)]
pub struct Factor {
    /// Its origin: a motion of a body, or a mean velocity that is held.
    pub origin: Origin,
    /// w (m/kg for a body, kg/m3 for a held mean).
    pub weight: f64,
    /// j where it is not zero, by cell (1 for a body, m2/kg for a held mean).
    pub entries: Vec<(u32, f64)>,
}

/// Origin of a factor of a system. Bodies are counted among those in the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A free body that moves along an axis.
    Translation {
        /// The body.
        body: usize,
        /// The axis.
        axis: usize,
    },
    /// A free body that pressure turns, about an axis of its response to torque.
    Rotation {
        /// The body.
        body: usize,
        /// Which of these axes.
        mode: usize,
    },
    /// A mean velocity that is held.
    HeldMean,
}
