//! Keeps the system of one solve of a step, where somebody wants it ([`super::system`]).

use super::Poisson;
use super::coefficient::Ends;
use super::exact;
use super::system::{Factor, OwnSolve, System};
use crate::petsc::{LinearSolver, Solved};
use crate::{Error, Result};
use mics_run::sparse::Sparse;

/// The solve whose system is wanted, and the system once it was there.
pub(super) struct Export {
    /// Counted from 1.
    wanted: usize,
    /// Solves so far.
    pub seen: usize,
    pub system: Option<System>,
}

impl Export {
    /// Wants that of the solve of this number, counted from 1.
    pub fn of(wanted: usize) -> Export {
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
        (rtol, atol): (f64, f64),
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
            // Of an option, and no failure to solve.
            Err(Error::Usage(_)) => return Ok(()),
            Err(failed) => Err(failed.to_string()),
        };
        let mut system = System {
            fluid: operator.fluid_matrix(),
            factors: operator.factors(),
            right_side: solver.right_side(<[f64]>::to_vec)?,
            solution: Vec::new(),
            singular: operator.singular,
            own: OwnSolve { rtol, atol: solver.absolute_tolerance(atol), outcome },
        };
        system.solution = exact::solve(operator, &system)?;
        self.system = Some(system);
        Ok(())
    }
}

impl Poisson {
    /// The part of the fluid, where one rank has all cells. A face that closes a period is one.
    fn fluid_matrix(&mut self) -> Sparse {
        let (lattice, g) = (self.lattice, &self.g);
        let [nx, ny, nz] = lattice.n;
        let steps = [1, nx, nx * ny];
        let mut matrix = Sparse::new(nx * ny * nz);
        let mut row = Vec::with_capacity(2 * lattice.axes + 1);
        let places = lattice.rows().flat_map(|s| s..s + nx);
        for (cell, place) in places.enumerate() {
            let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
            let mut diagonal = 0.0;
            row.clear();
            for axis in 0..lattice.axes {
                let (n, step, stride) = (lattice.n[axis], steps[axis], lattice.stride[axis]);
                let closes = matches!(self.ends[axis], Ends::Periodic);
                let low = g[axis][place];
                let high = match closes && at[axis] + 1 == n {
                    true => g[axis][place - (n - 1) * stride],
                    false => g[axis][place + stride],
                };
                let around = (n - 1) * step;
                let below = match at[axis] {
                    0 => closes.then_some(cell + around),
                    _ => Some(cell - step),
                };
                let above = match at[axis] + 1 == n {
                    true => closes.then(|| cell - around),
                    false => Some(cell + step),
                };
                for (beyond, each) in [(below, low), (above, high)] {
                    diagonal += each;
                    row.extend(beyond.map(|beyond| (beyond as u32, -each)));
                }
            }
            row.push((cell as u32, diagonal));
            matrix.push_row(&mut row);
        }
        matrix
    }

    /// What is added to it.
    fn factors(&self) -> Vec<Factor> {
        self.bodies.factors().into_iter().chain(self.held.factor()).collect()
    }
}
