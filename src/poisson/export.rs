//! Keeps the system of one solve of a step, where somebody wants it ([`super::system`]).

use super::Poisson;
use super::system::{OwnSolve, System};
use crate::petsc::{LinearSolver, Operator, Solved};
use crate::{Error, Result};

/// The solve whose system is wanted, and the system once it was there.
pub(super) struct Export {
    /// Counted from 1.
    wanted: u64,
    /// Solves so far.
    pub seen: u64,
    pub system: Option<System>,
}

impl Export {
    /// Waits for the system of the solve of number `wanted`, counted from 1.
    pub fn of(wanted: u64) -> Export {
        Export { wanted, seen: 0, system: None }
    }

    /// Keeps the system of a solve to these tolerances that has just ended so, where it is the one
    /// that is wanted.
    ///
    /// # Errors
    /// When there are several ranks, or the exact solution is not found.
    pub fn see(
        &mut self,
        operator: &mut Poisson,
        solver: &LinearSolver,
        rtol: f64,
        atol: f64,
        ended: &Result<Solved>,
    ) -> Result<()> {
        self.seen += 1;
        if self.seen != self.wanted {
            return Ok(());
        }
        if operator.session.size() > 1 {
            return Err(Error::Usage("a system is exported by one rank".into()));
        }
        let outcome = match ended {
            Ok(solved) => Ok(*solved),
            // The error is about an option: the solve has not failed.
            Err(Error::Usage(_)) => return Ok(()),
            Err(failed) => Err(failed.to_string()),
        };
        let right_side = solver.right_side(<[f64]>::to_vec)?;
        let singular = operator.coefficient.singular;
        let (solution, residual) = solve_to_rounding(operator, singular, &right_side)?;
        self.system = Some(System {
            fluid: operator.coefficient.matrix(),
            factors: operator.factors(),
            right_side,
            solution,
            residual,
            singular,
            own: OwnSolve { rtol, atol: solver.absolute_tolerance(atol), outcome },
        });
        Ok(())
    }
}

/// Most iterations of the solve to rounding, and most of them without gain.
const ITERATIONS: usize = 1000;
const IDLE: usize = 20;

/// Residual, relative to the right side, above which a solution is rejected.
const LARGEST_RESIDUAL: f64 = 1e-9;

/// The solution x of `A x = b` as near as rounding lets it come (where constants solve it for
/// b = 0, the one whose mean is zero), and the norm of `b - A x` over that of b: conjugate
/// gradients with the multigrid, whose residual is taken anew from x in each iteration.
fn solve_to_rounding(
    operator: &mut impl Operator,
    singular: bool,
    b: &[f64],
) -> Result<(Vec<f64>, f64)> {
    let settle = |x: &mut [f64]| {
        let mean = if singular { x.iter().sum::<f64>() / x.len() as f64 } else { 0.0 };
        x.iter_mut().for_each(|x| *x -= mean);
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let zeros = vec![0.0; b.len()];
    let mut x = zeros.clone();
    let mut best = (zeros.clone(), f64::INFINITY);
    let mut r = b.to_vec();
    let mut z = zeros.clone();
    let mut p = zeros.clone();
    let mut ap = zeros;
    let mut pap = 1.0;
    let mut idle = 0;
    for _ in 0..ITERATIONS {
        operator.precondition(&r, &mut z)?;
        settle(&mut z);
        // The last direction itself gives beta: in single precision the preconditioner is another
        // each time.
        let beta = dot(&z, &ap) / pap;
        p.iter_mut().zip(&z).for_each(|(p, z)| *p = z - beta * *p);
        operator.multiply(&p, &mut ap)?;
        pap = dot(&p, &ap);
        let alpha = dot(&r, &p) / pap;
        x.iter_mut().zip(&p).for_each(|(x, p)| *x += alpha * p);
        settle(&mut x);
        operator.multiply(&x, &mut r)?;
        r.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
        let left = (dot(&r, &r) / dot(b, b)).sqrt();
        idle += 1;
        if left < best.1 {
            best = (x.clone(), left);
            idle = 0;
        }
        if idle == IDLE || !left.is_finite() {
            break;
        }
    }
    if best.1 <= LARGEST_RESIDUAL {
        return Ok(best);
    }
    Err(Error::Run(format!(
        "the exported system was not solved: a residual of {:.1e} of the right side is left",
        best.1
    )))
}
