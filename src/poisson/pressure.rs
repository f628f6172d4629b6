//! The pressure iteration, C-HSMAC (13-15): for k = 0, 1, ... solve
//!
//! ```text
//!   div( (1/rho) grad phi ) = D/dt,   p += phi,   U_f -= (dt/rho_f) dphi/dn     until max |D| < D0
//!
//!             phi_N
//!               | b_n            (b_e (phi_E - phi_P) - b_w (phi_P - phi_W))/h_x^2 + ... = D/dt,
//!              b = 1/rho on faces
//!   phi_W -b_w- phi_P -b_e- phi_E
//!               | b_s            closed face: b = 0;
//!              outflow: phi = 0 on the face, 2 b/h^2 on the diagonal
//!             phi_S
//! ```
//! The sign is turned so that the matrix is positive (semi-)definite. The k-th solve is asked for
//! `eps_k = a^k 0.5 D0/max|D|`, relative to the right side: just what is needed, tightening by `a`
//! where it was not.

use super::export::Export;
use super::solves::Solves;
use super::{MatrixRows, ModeFace, Poisson, SolveRow, System};
use crate::error::NotFinite;
use crate::grid::{Boundaries, Grid, VectorField, largest, simd, total};
use crate::kernels::faces::{self, FaceCoefficient};
use crate::petsc::{Choice, Layout, LinearSolver, LogStage, Session, Solved};
use crate::sharing::Sharing;
use crate::{Error, Result};
use std::cell::{RefCell, RefMut};
use std::rc::Rc;

/// Part of D0 below which a step leaves the pressure as it is: there is nothing to solve. Half and
/// twice as much change nothing.
const IDLE: f64 = 1e-3;

/// Accuracy of a projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// Iterates until the |D| of every cell is below D0.
    Full,
    /// One solve to this part of the digits that D0 asks for, where velocities change and a further
    /// projection follows.
    Digits(f64),
}

/// The pressure operator and its iteration.
pub struct Projection {
    solver: LinearSolver,
    /// Shared with the solver, which uses it during a solve only.
    operator: Rc<RefCell<Poisson>>,
    /// The operator as a matrix, where the solver needs one.
    rows: Option<MatrixRows>,
    session: Session,
    divergence: Vec<f64>,
    phi: Vec<f64>,
    /// Whether nothing fixes the pressure: only its differences count then, and its mean is zero.
    singular: bool,
    rule: StoppingRule,
    solves: Solves,
    /// The system of a solve that somebody wants.
    export: Option<Export>,
}

/// The divergence of the velocities over all ranks, and what comes by the same message.
struct Divergence {
    /// The largest |D| (1/s).
    largest: f64,
    /// The mean of D (1/s) where nothing fixes the pressure: no more than rounding. No pressure
    /// takes it out.
    mean: f64,
    /// The mean pressure (Pa) where nothing fixes it.
    pressure: f64,
}

/// Stopping rule of C-HSMAC.
#[derive(Clone, Copy, Debug)]
pub struct StoppingRule {
    /// D0 (1/s): every cell's |D| has to be below it.
    pub limit: f64,
    /// a in `eps_k = a^k eps`.
    pub tightening: f64,
    /// Iterations after which the run fails.
    pub max_iterations: usize,
}

/// The velocities through faces, and what is coupled to them and to the pressure: bodies, a drive.
pub trait Coupled<const D: usize> {
    /// The velocities through faces (m/s).
    fn faces(&mut self) -> &mut VectorField<D>;

    /// Changes the velocities to what the step `dt` (s) starts from, before the first solve.
    /// Collective.
    fn begin(&mut self, grid: &Grid<D>, dt: f64) -> Result<()>;

    /// Follows the change `phi` (Pa, ghosts filled) of the pressure over the step `dt` (s), which
    /// the open faces have already. Collective.
    fn follow(&mut self, grid: &Grid<D>, dt: f64, phi: &[f64]) -> Result<()>;
}

/// Faces to which nothing is coupled.
impl<const D: usize> Coupled<D> for VectorField<D> {
    fn faces(&mut self) -> &mut VectorField<D> {
        self
    }

    fn begin(&mut self, _: &Grid<D>, _: f64) -> Result<()> {
        Ok(())
    }

    fn follow(&mut self, _: &Grid<D>, _: f64, _: &[f64]) -> Result<()> {
        Ok(())
    }
}

/// Outcome of a pressure iteration: its numbers of iterations, and the divergence that is left.
#[derive(Clone, Copy, Debug, Default)]
pub struct Projected {
    /// C-HSMAC iterations.
    pub outer: u32,
    /// Krylov iterations in all of them.
    pub krylov: u32,
    /// The largest |D| over all cells at the end (1/s).
    pub divergence_max: f64,
    /// Solves that had to be repeated.
    pub retries: u32,
    /// Setups of the preconditioner.
    pub setups: u32,
}

impl Projected {
    /// Counts another iteration that followed.
    pub fn add(&mut self, next: Projected) {
        self.outer += next.outer;
        self.krylov += next.krylov;
        self.retries += next.retries;
        self.setups += next.setups;
        self.divergence_max = next.divergence_max;
    }
}

impl Projection {
    /// The operator on `grid`, its solver as PETSc's options say, or as chosen where they say
    /// nothing, and the stopping rule. Collective.
    ///
    /// # Errors
    /// When a PETSc option names something unknown.
    pub fn new<const D: usize>(
        session: &Session,
        layout: &Layout,
        grid: &Grid<D>,
        boundaries: &Boundaries<D>,
        rule: StoppingRule,
        choice: Choice,
    ) -> Result<Projection> {
        let operator = Rc::new(RefCell::new(Poisson::new(session, layout, grid, boundaries)?));
        let singular = !boundaries.fixes_pressure();
        let mut rows = None;
        let pattern = || {
            let (made, pattern) = MatrixRows::new(layout, grid);
            rows = Some(made);
            pattern
        };
        let solver =
            LinearSolver::new(session, choice, layout, operator.clone(), singular, pattern)?;
        Ok(Projection {
            solver,
            operator,
            rows,
            session: session.clone(),
            divergence: grid.field(),
            phi: grid.field(),
            singular,
            rule,
            solves: Solves::default(),
            export: None,
        })
    }

    /// Takes `1/rho` on faces for the operator. Collective.
    ///
    /// # Errors
    /// When a coefficient is not positive and finite: a zero row would make solvers report success.
    pub fn assemble<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        beta: &FaceCoefficient<D>,
    ) -> Result<()> {
        let _logged = self.session.log(LogStage::Assembly)?;
        let Projection { operator, rows, solver, .. } = self;
        let mut operator = borrow(operator)?;
        operator.set(grid, beta)?;
        rows.as_mut().map_or(Ok(()), |rows| solver.set_values(rows.fill(&mut operator)))
    }

    /// Adds `sum_k w_k j_k j_k^T` to the operator, in place of what was added before: the bodies
    /// that follow the pressure ([`Poisson::set_modes`]). Collective.
    ///
    /// # Errors
    /// When they are unsound, or the solver would pass over them.
    pub fn set_modes(
        &mut self,
        weights: &[f64],
        covered: &[ModeFace],
        turning: &[u32],
        sharing: &Sharing,
    ) -> Result<()> {
        let _logged = self.session.log(LogStage::Assembly)?;
        self.solver.refuse_without_low_rank()?;
        borrow(&self.operator)?.set_modes(weights, covered, turning, sharing)
    }

    /// Takes the largest extent (m) of a body that follows the pressure ([`Poisson::set_extent`]);
    /// the same on every rank.
    ///
    /// # Errors
    /// When the operator is in use.
    pub fn set_extent(&mut self, across: f64) -> Result<()> {
        borrow(&self.operator)?.set_extent(across);
        Ok(())
    }

    /// Gives the operator the response to the pressure of a drive that holds a mean velocity
    /// ([`Poisson::set_held`]).
    ///
    /// # Errors
    /// When the operator is in use, or the solver would pass over this.
    pub fn set_held(
        &mut self,
        axis: usize,
        h: f64,
        faces: impl Iterator<Item = (usize, f64)>,
        weight: f64,
    ) -> Result<()> {
        self.solver.refuse_without_low_rank()?;
        borrow(&self.operator)?.set_held(axis, h, faces, weight);
        Ok(())
    }

    /// Makes the face velocities divergence-free to D0 and adds the increments to the pressure (its
    /// ghosts are filled at the end); what is `coupled` follows every change of it. With
    /// [`Accuracy::Digits`] there is one solve alone, for a caller that then changes velocities and
    /// projects again. Collective.
    ///
    /// # Errors
    /// When D0 is not reached, a solve fails for good, or a velocity is not finite.
    #[allow(clippy::too_many_arguments)]
    pub fn project<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        boundaries: &mut Boundaries<D>,
        beta: &FaceCoefficient<D>,
        dt: f64,
        p: &mut [f64],
        coupled: &mut dyn Coupled<D>,
        accuracy: Accuracy,
    ) -> Result<Projected> {
        let _logged = self.session.log(LogStage::Pressure)?;
        let mut done = Projected::default();
        coupled.begin(grid, dt)?;
        loop {
            let divergence = self.find_divergence(grid, coupled.faces(), p)?;
            if self.singular {
                lower(grid, divergence.pressure, p);
            }
            done.divergence_max = divergence.largest;
            if done.outer > 0 {
                self.solves.end(done.divergence_max);
            }
            // A step solves once though the limit is kept already, unless there is next to nothing
            // to solve: pressure that waits until D0 is reached makes the force on a particle
            // jitter.
            let limit = self.rule.limit * if done.outer == 0 { IDLE } else { 1.0 };
            if done.divergence_max < limit {
                break;
            }
            if !done.divergence_max.is_finite() {
                return Err(Error::NotFinite(NotFinite::Velocity));
            }
            if done.outer as usize == self.rule.max_iterations {
                return Err(Error::Run(format!(
                    "C-HSMAC reached max |D| = {:.3e} 1/s in {} iterations, not D0 = {:.3e}: raise \
                    pressure.max_iterations or pressure.divergence_limit (rounding leaves about \
                    1e-14 of velocity/spacing), or ask another solver",
                    done.divergence_max, self.rule.max_iterations, self.rule.limit
                )));
            }
            let attempts = self.solver.history().attempts().len();
            self.solves.begin(done.outer == 0, done.divergence_max, attempts);
            let (rtol, atol) = self.tolerances(&done, dt, accuracy);
            let solved = self.solve(grid, dt, &divergence, rtol, atol)?;
            self.correct(grid, boundaries, beta, dt, p, coupled.faces())?;
            coupled.follow(grid, dt, &self.phi)?;
            done.outer += 1;
            done.krylov += solved.iterations;
            done.retries += u32::from(solved.retried);
            done.setups += solved.setups;
            if accuracy != Accuracy::Full {
                break;
            }
        }
        boundaries.fill_pressure(p)?;
        Ok(done)
    }

    /// The relative and the absolute tolerance (1/s2) of the solve that comes next.
    fn tolerances(&self, done: &Projected, dt: f64, accuracy: Accuracy) -> (f64, f64) {
        let tighter = self.rule.tightening.powi(done.outer as i32);
        let digits = match accuracy {
            Accuracy::Full => 1.0,
            Accuracy::Digits(part) => part,
        };
        let needed = (0.5 * self.rule.limit / done.divergence_max).clamp(1e-13, 0.1).powf(digits);
        let rtol = (tighter * self.solver.fixed_rtol().unwrap_or(needed)).max(1e-14);
        // A residual whose 2-norm is below this cannot hold a cell above D0/2; it ends no solve
        // before it has begun, and none whose tolerance the user has fixed.
        let within = done.divergence_max < self.rule.limit;
        let fixed = self.solver.fixed_rtol().is_some();
        let atol = if within || fixed { 0.0 } else { 0.5 * self.rule.limit / dt };
        (rtol, atol)
    }

    /// The divergence of the velocities, and the mean pressure. Collective.
    fn find_divergence<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        velocity: &VectorField<D>,
        p: &[f64],
    ) -> Result<Divergence> {
        faces::divergence(grid, velocity, &mut self.divergence);
        let divergence = &self.divergence;
        let mut most = [0.0f64];
        let mut sums = [0.0; 2];
        simd(
            #[inline(always)]
            || {
                for row in grid.rows() {
                    let d = &divergence[row.clone()];
                    most[0] = most[0].max(largest(
                        d.len(),
                        #[inline(always)]
                        |i| d[i].abs(),
                    ));
                    if self.singular {
                        for (sum, values) in sums.iter_mut().zip([d, &p[row]]) {
                            *sum += total(
                                values.len(),
                                #[inline(always)]
                                |i| values[i],
                            );
                        }
                    }
                }
            },
        );
        self.session.sum_and_max(&mut sums, &mut most)?;
        let [mean, pressure] = sums.map(|sum| sum / grid.total_cells() as f64);
        Ok(Divergence { largest: most[0], mean, pressure })
    }

    /// Solves for the increment phi that takes the divergence out over the step `dt` (s).
    fn solve<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        dt: f64,
        Divergence { largest, mean, .. }: &Divergence,
        rtol: f64,
        atol: f64,
    ) -> Result<Solved> {
        borrow(&self.operator)?.set_size(largest / dt);
        let divergence = &self.divergence;
        self.solver.set_right_side(|b| {
            for (out, row) in b.chunks_exact_mut(grid.local[0]).zip(grid.rows()) {
                for (b, d) in out.iter_mut().zip(&divergence[row]) {
                    *b = (mean - d) / dt;
                }
            }
        })?;
        let ended = self.solver.solve(rtol, atol);
        if let Some(export) = &mut self.export {
            export.see(&mut *borrow(&self.operator)?, &self.solver, rtol, atol, &ended)?;
        }
        ended
    }

    /// Adds the solution to the pressure, and its gradient to the velocities through open faces.
    fn correct<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        boundaries: &mut Boundaries<D>,
        beta: &FaceCoefficient<D>,
        dt: f64,
        p: &mut [f64],
        velocity: &mut VectorField<D>,
    ) -> Result<()> {
        let phi = &mut self.phi;
        self.solver.solution(|x| {
            for (values, row) in x.chunks_exact(grid.local[0]).zip(grid.rows()) {
                phi[row.clone()].copy_from_slice(values);
                for (p, phi) in p[row].iter_mut().zip(values) {
                    *p += phi;
                }
            }
        })?;
        boundaries.fill_increment(phi)?;
        // Closed faces keep their velocity: phi's ghosts leave no gradient there.
        faces::add_gradient(grid, beta, -dt, phi, velocity);
        Ok(())
    }

    /// Forgets the recorded solves, and sets whether the next ones are recorded.
    pub fn record(&mut self, recording: bool) {
        self.solves.clear(recording);
        self.solver.record(recording);
    }

    /// The iterations of all solves since [`Projection::record`].
    pub fn solves(&self) -> impl Iterator<Item = SolveRow> {
        self.solves.rows(self.solver.history())
    }

    /// Keeps the system of the solve of this number (from 1), counted from now on. On one rank.
    pub fn keep_system_of(&mut self, solve: u64) {
        self.export = Some(Export::of(solve));
    }

    /// Number of solves since [`Projection::keep_system_of`], and the system of the wanted one,
    /// where it was among them. Nothing is kept from then on.
    pub fn take_system(&mut self) -> (u64, Option<System>) {
        self.export.take().map_or((0, None), |export| (export.seen, export.system))
    }

    /// The linear solver in use.
    pub fn solver(&self) -> &LinearSolver {
        &self.solver
    }
}

/// Lowers the pressure of this rank's cells by so much (Pa).
fn lower<const D: usize>(grid: &Grid<D>, much: f64, p: &mut [f64]) {
    grid.rows().for_each(|row| p[row].iter_mut().for_each(|p| *p -= much));
}

/// The operator, which the solver holds during a solve only.
fn borrow(operator: &RefCell<Poisson>) -> Result<RefMut<'_, Poisson>> {
    operator.try_borrow_mut().map_err(|_| Error::Run("the pressure's operator is in use".into()))
}
