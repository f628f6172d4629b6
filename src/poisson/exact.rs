//! The exact solution of a system that is exported: conjugate gradients with the multigrid, begun
//! anew from the residual in twice the precision until that is rounding.
//!
//! ```text
//!   r = b - A x  (exact)      A d = r  (to 1e-8)      x += d        while |r| falls
//! ```
//! Only the correction is solved for in double precision: x ends as near to the solution as doubles
//! are, whatever the condition of A (N. Higham 2002, Accuracy and stability, ch. 12).

use super::Poisson;
use super::system::{System, norm};
use crate::petsc::Operator;
use crate::{Error, Result};

/// How far a correction is solved for, and within how many iterations.
const PART: f64 = 1e-8;
const ITERATIONS: usize = 300;

/// Corrections at most.
const CORRECTIONS: usize = 30;

/// Residual, as a part of the right side, over which a solution is none.
const LARGEST_RESIDUAL: f64 = 1e-9;

/// The solution of a system of the operator; where constants solve it for b = 0, the one whose mean
/// is zero.
///
/// # Errors
/// When the iteration does not come to it.
pub(super) fn solve(operator: &mut Poisson, system: &System) -> Result<Vec<f64>> {
    let settle = |x: &mut [f64]| {
        if system.singular {
            let mean = x.iter().sum::<f64>() / x.len() as f64;
            x.iter_mut().for_each(|x| *x -= mean);
        }
    };
    let whole = norm(&system.right_side);
    let mut best = (vec![0.0; system.right_side.len()], whole);
    for _ in 0..CORRECTIONS {
        let mut r = system.residual(&best.0);
        settle(&mut r);
        let mut x = correction(operator, &r, &settle)?;
        x.iter_mut().zip(&best.0).for_each(|(d, x)| *d += x);
        settle(&mut x);
        let left = norm(&system.residual(&x));
        let gained = left < 0.5 * best.1;
        if left < best.1 {
            best = (x, left);
        }
        if !gained {
            break;
        }
    }
    let (x, left) = best;
    if left > LARGEST_RESIDUAL * whole {
        return Err(Error::Run(format!(
            "the exact solution of the exported system was not found: a residual of {:.1e} of the \
            right side is left",
            left / whole
        )));
    }
    Ok(x)
}

/// `A d = r`, about; `settle` takes out what A does not see.
fn correction(operator: &mut Poisson, r: &[f64], settle: &dyn Fn(&mut [f64])) -> Result<Vec<f64>> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let n = r.len();
    let (mut r, mut d, mut z, mut q) = (r.to_vec(), vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let (mut p, mut before, mut rz) = (vec![0.0; n], vec![0.0; n], 0.0);
    let enough = PART * norm(&r);
    for iteration in 0..ITERATIONS {
        if norm(&r) <= enough {
            break;
        }
        operator.precondition(&r, &mut z)?;
        settle(&mut z);
        let next = dot(&r, &z);
        // Polak and Ribiere's, since single precision makes the preconditioner another each time.
        let beta = if iteration == 0 { 0.0 } else { (next - dot(&before, &z)) / rz };
        rz = next;
        p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + beta * *p);
        operator.multiply(&p, &mut q)?;
        let alpha = rz / dot(&p, &q);
        if !alpha.is_finite() {
            break;
        }
        before.copy_from_slice(&r);
        d.iter_mut().zip(&p).for_each(|(d, p)| *d += alpha * p);
        r.iter_mut().zip(&q).for_each(|(r, q)| *r -= alpha * q);
        settle(&mut r);
    }
    Ok(d)
}
