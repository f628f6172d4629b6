//! The system of one solve as plain numbers, for others to solve:
//!
//! ```text
//!   A x = b,     A = A_fluid + sum_k w_k j_k j_k^T
//! ```
//! A_fluid has a row for each cell, x fastest: the sum of its faces' `beta/h^2` on the diagonal
//! and `-beta/h^2` beside it, without the shift that preconditioners are given ([`super::Rows`]);
//! the factors are the modes of free bodies, and the mean velocity that a drive holds, whose
//! weight is negative.

use crate::Result;
use crate::petsc::Solved;
use mics_run::sparse::Sparse;

/// The system of a solve, its exact solution, and how the run itself solved it.
#[derive(Clone, Debug)]
pub struct System {
    /// A_fluid (m/kg).
    pub fluid: Sparse,
    /// What is added to it.
    pub factors: Vec<Factor>,
    /// b (1/s2); where the system is singular, without its mean.
    pub right_side: Vec<f64>,
    /// x (Pa); where the system is singular, the one whose mean is zero.
    pub solution: Vec<f64>,
    /// Whether constants solve the system for b = 0.
    pub singular: bool,
    /// How the run itself solved it.
    pub own: OwnSolve,
}

/// How the run solved a system: by its PETSc options, to tolerances that are part of what it
/// needed.
#[derive(Clone, Debug)]
pub struct OwnSolve {
    /// Part of the right side's norm to which the residual was to fall.
    pub rtol: f64,
    /// Residual (1/s2) that was small enough in any case; of a method that tests the true residual
    /// alone.
    pub atol: f64,
    /// What it took, or why it failed.
    pub outcome: Result<Solved, String>,
}

/// A term `w j j^T` of a system's matrix.
#[derive(Clone, Debug)]
pub struct Factor {
    /// What it stands for.
    pub origin: Origin,
    /// w (m/kg for a body, kg/m3 for a held mean).
    pub weight: f64,
    /// j where it is not zero, by cell (1 for a body, m2/kg for a held mean).
    pub entries: Vec<(u32, f64)>,
}

/// What a factor of a system stands for. Bodies are counted among those in the box.
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

impl System {
    /// `b - A x`, as exact as b and A are: products and sums in twice the precision.
    pub fn residual(&self, x: &[f64]) -> Vec<f64> {
        let mut sums: Vec<Double> = self.right_side.iter().map(|b| Double(*b, 0.0)).collect();
        for (row, sum) in sums.iter_mut().enumerate() {
            self.fluid.row(row).for_each(|(column, a)| sum.add_product(-a, x[column]));
        }
        for Factor { weight, entries, .. } in &self.factors {
            let mut moved = Double(0.0, 0.0);
            entries.iter().for_each(|(cell, j)| moved.add_product(*j, x[*cell as usize]));
            for (cell, j) in entries {
                let (high, low) = product(-weight, *j);
                let sum = &mut sums[*cell as usize];
                sum.add_product(high, moved.0);
                sum.add_product(high, moved.1);
                sum.add_product(low, moved.0);
            }
        }
        sums.into_iter().map(|sum| sum.0 + sum.1).collect()
    }

    /// Norm of [`System::residual`] of the solution over that of the right side.
    pub fn relative_residual(&self) -> f64 {
        norm(&self.residual(&self.solution)) / norm(&self.right_side)
    }
}

/// A number as the sum of two doubles (T. Dekker 1971; Ogita, Rump and Oishi 2005).
#[derive(Clone, Copy)]
struct Double(f64, f64);

impl Double {
    fn add_product(&mut self, a: f64, b: f64) {
        let (product, rest) = product(a, b);
        let sum = self.0 + product;
        let part = sum - self.0;
        let lost = (self.0 - (sum - part)) + (product - part);
        *self = Double(sum, self.1 + (lost + rest));
    }
}

/// A product of two doubles and what rounding takes from it.
fn product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

/// The 2-norm.
pub(super) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
