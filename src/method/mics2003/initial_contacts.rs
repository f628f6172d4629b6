//! What contacts give bodies that lie on something before their first step: x, force and torque of
//! each. A step with x on the faces finds f more, and x that it finds itself is wanted,
//!
//! ```text
//!   f(x) = 0         x, f in parts of sqrt(m), sqrt(I): sums of squares are energies over the step
//!   x' = x + f - (dX + dF) c,
//!              c so that |f - dF c| is least; dX, dF: the changes of x and f in the last rounds
//! ```
//! (D. G. Anderson, J. ACM 12, 1965). Taken alone, f leaves `m_a/(m + m_a)` of what was missing,
//! m_a the fluid that goes along: in twelve rounds most of it, where a row of discs shuts a pipe,
//! or where they are light.

use super::Mics2003;
use crate::Result;
use crate::domain::Domain;
use crate::method::Method;
use crate::state::State;
use nalgebra::{DMatrix, DVector};
use std::collections::VecDeque;

/// Most rounds. With 12 plain ones a row of discs that shuts a pipe carries 0.6 of its weight.
const MOST_ROUNDS: usize = 40;

/// Part of what contacts give that may be missing at the end: rounding.
const TOLERANCE: f64 = 1e-9;

/// Rounds that are remembered.
const MEMORY: usize = 5;

/// Changes that are less than this part of the largest one are rounding's.
const LEAST_CHANGE: f64 = 1e-10;

impl<const D: usize> Mics2003<D> {
    /// Finds what contacts give bodies that lie on something before their first step of `dt` (s),
    /// by taking it until that is what was expected. Collective.
    ///
    /// # Errors
    /// As [`Mics2003::step`].
    pub(super) fn find_initial_contacts(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<()> {
        let start = s.clone();
        let mut rounds = Rounds::default();
        for _ in 0..MOST_ROUNDS {
            let x = expected(s);
            self.advance_all(domain, s, dt)?;
            let found = expected(&std::mem::replace(s, start.clone()));
            let missing = &found - &x;
            let done = missing.norm() <= TOLERANCE * found.norm();
            expect(s, &if done { found } else { rounds.next(x, missing) });
            self.resume(domain, s)?;
            if done {
                break;
            }
        }
        Ok(())
    }
}

/// What contacts are expected to give all bodies.
fn expected<const D: usize>(s: &State<D>) -> DVector<f64> {
    let mut x = DVector::zeros(6 * s.bodies.len());
    for (k, (support, body)) in s.supports.iter().flatten().zip(&s.bodies).enumerate() {
        let [force, turn] = scales(body.mass(), body.radius());
        x.fixed_rows_mut::<3>(6 * k).copy_from(&(force * support.force));
        x.fixed_rows_mut::<3>(6 * k + 3).copy_from(&(turn * support.torque));
    }
    x
}

/// Lets that be expected.
fn expect<const D: usize>(s: &mut State<D>, x: &DVector<f64>) {
    for (k, (support, body)) in s.supports.iter_mut().flatten().zip(&s.bodies).enumerate() {
        let [force, turn] = scales(body.mass(), body.radius());
        support.force = x.fixed_rows::<3>(6 * k) / force;
        support.torque = x.fixed_rows::<3>(6 * k + 3) / turn;
    }
}

/// What makes of a force and of a torque on a body of this mass (kg) and radius (m) the root of an
/// energy over the step: `1/sqrt(m)`, and about `1/sqrt(I)`.
fn scales(mass: f64, radius: f64) -> [f64; 2] {
    [1.0, 1.0 / radius].map(|length| length / mass.sqrt())
}

/// What the last rounds found.
#[derive(Default)]
struct Rounds {
    last: Option<(DVector<f64>, DVector<f64>)>,
    /// dX and dF.
    changes: VecDeque<(DVector<f64>, DVector<f64>)>,
}

impl Rounds {
    /// The next x, after one of which f is missing.
    fn next(&mut self, x: DVector<f64>, f: DVector<f64>) -> DVector<f64> {
        if let Some((x_before, f_before)) = self.last.take() {
            if self.changes.len() == MEMORY {
                self.changes.pop_front();
            }
            self.changes.push_back((&x - x_before, &f - f_before));
        }
        let mut next = &x + &f;
        if !self.changes.is_empty() {
            let [of_x, of_f] = [0, 1].map(|which| {
                let columns: Vec<_> = self
                    .changes
                    .iter()
                    .map(|change| [&change.0, &change.1][which].clone())
                    .collect();
                DMatrix::from_columns(&columns)
            });
            let parts = of_f.clone().svd(true, true);
            let least = LEAST_CHANGE * parts.singular_values.max();
            // Without a part of it the next x is the plain one.
            if let Ok(c) = parts.solve(&f, least) {
                next -= (of_x + of_f) * c;
            }
        }
        self.last = Some((x, f));
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a linear `f = A (x* - x)` as many rounds find all as A has values, and plain ones hardly
    /// begin.
    #[test]
    fn initial_contact_force_iterations_equal_kinds_of_bodies() {
        let share = DVector::from_vec(vec![0.9, 0.05, 0.05, 0.01]);
        let wanted = DVector::from_vec(vec![1.0, -2.0, 3.0, 4.0]);
        let (mut x, mut rounds) = (DVector::zeros(4), Rounds::default());
        for _ in 0..5 {
            let f = share.component_mul(&(&wanted - &x));
            x = rounds.next(x, f);
        }
        assert!((&x - &wanted).norm() < 1e-9 * wanted.norm(), "{x}");
    }
}
