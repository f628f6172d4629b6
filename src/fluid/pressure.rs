//! The pressure iteration, C-HSMAC (13-15): for k = 0, 1, ... solve
//!
//! ```text
//!   div( (1/rho) grad phi ) = D/dt,   p += phi,   U_f -= (dt/rho_f) dphi/dn     until max |D| < D0
//!
//!             phi_N
//!               | b_n            (b_e (phi_E - phi_P) - b_w (phi_P - phi_W))/h_x^2 + ... = D/dt,   b = 1/rho on faces
//!   phi_W -b_w- phi_P -b_e- phi_E
//!               | b_s            closed face: b = 0;  outflow: phi = 0 on the face, 2 b/h^2 on the diagonal
//!             phi_S
//! ```
//! The sign is turned so that the matrix is positive (semi-)definite. The k-th solve is asked for
//! `eps_k = a^k 0.5 D0/max|D|`, relative to the right side: just what is needed, tightening by `a` where it was not.

use super::faces::{self, FaceCoefficient};
use crate::grid::{Border, Boundaries, Grid, VectorField};
use crate::petsc::{Layout, LinearSolver, ModeEntry, Session};
use crate::{Error, Result};

/// The pressure operator and its iteration.
pub struct Projection {
    solver: LinearSolver,
    /// The kinds of every owned cell's faces: low and high along each axis.
    links: Vec<[Link; 6]>,
    /// The matrix's entries, cell by cell: the neighbours' in the order of the links, then the diagonal's.
    values: Vec<f64>,
    session: Session,
    divergence: Vec<f64>,
    phi: Vec<f64>,
    rule: StoppingRule,
    /// Whether no border fixes the pressure.
    singular: bool,
}

/// When C-HSMAC ends.
#[derive(Clone, Copy, Debug)]
pub struct StoppingRule {
    /// D0 (1/s): every cell's |D| has to be below it.
    pub limit: f64,
    /// a in `eps_k = a^k eps`.
    pub tightening: f64,
    /// Iterations after which the run fails.
    pub max_iterations: usize,
}

/// Added to the diagonal, relative to it, where no border fixes the pressure. Without it a multigrid's coarse operators
/// hold nothing but rounding in the direction of the constants, and now and then blow them up until the Krylov method
/// stagnates (seen with BoomerAMG and GAMG at density ratios of 1000). What it changes is far below D0, and C-HSMAC
/// judges by the true divergence.
const SHIFT: f64 = 1e-13;

/// What a cell's face contributes to its row.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Link {
    /// Nothing: the velocity through it is given.
    Closed,
    /// A neighbour.
    Cell,
    /// Zero pressure on the face, half a cell away.
    Outflow,
}

/// Part of D0 below which a step leaves the pressure as it is.
const IDLE: f64 = 1e-3;

/// What moves with the pressure: bodies whose velocity, and with it that of faces, follows it.
pub trait Rider<const D: usize> {
    /// Takes the change `phi` (Pa, ghosts filled) of the pressure over the step `dt` (s) and adds to the velocity of
    /// `faces` (m/s) what follows from it. Collective.
    fn follow(&mut self, grid: &Grid<D>, dt: f64, phi: &[f64], faces: &mut VectorField<D>) -> Result<()>;
}

/// What an iteration took and left.
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
}

impl Projection {
    /// The operator's pattern on `grid`, its solver as PETSc's options say, and the stopping rule: `limit` is D0 (1/s).
    ///
    /// # Errors
    /// When a PETSc option names something unknown.
    pub fn new<const D: usize>(
        session: &Session,
        layout: &Layout,
        grid: &Grid<D>,
        boundaries: &Boundaries<D>,
        rule: StoppingRule,
    ) -> Result<Projection> {
        let (mut rows, mut columns, mut links) = (Vec::new(), Vec::new(), Vec::new());
        for c in grid.rows().flatten() {
            let mut faces = [Link::Closed; 6];
            for (axis, side) in (0..2 * D).map(|f| (f / 2, f % 2)) {
                let s = grid.stride[axis];
                let neighbour = layout.numbers[if side == 0 { c - s } else { c + s }];
                if neighbour >= 0 {
                    faces[2 * axis + side] = Link::Cell;
                    rows.push(layout.numbers[c]);
                    columns.push(neighbour);
                } else if let Some(Border::Outflow) = boundaries.borders[axis][side] {
                    faces[2 * axis + side] = Link::Outflow;
                }
            }
            rows.push(layout.numbers[c]);
            columns.push(layout.numbers[c]);
            links.push(faces);
        }
        let (singular, count) = (!boundaries.fixes_pressure(), rows.len());
        Ok(Projection {
            solver: LinearSolver::new(session, layout, D, rows, columns, singular)?,
            values: vec![0.0; count],
            links,
            singular,
            session: session.clone(),
            divergence: grid.field(),
            phi: grid.field(),
            rule,
        })
    }

    /// Refills the matrix from `1/rho` on faces.
    ///
    /// # Errors
    /// When a coefficient is not positive and finite: a zero row would make solvers report success.
    pub fn assemble<const D: usize>(&mut self, grid: &Grid<D>, beta: &FaceCoefficient<D>) -> Result<()> {
        let inverse_h2: [f64; D] = std::array::from_fn(|a| 1.0 / (grid.h[a] * grid.h[a]));
        let definite = if self.singular { 1.0 + SHIFT } else { 1.0 };
        let mut values = self.values.iter_mut();
        let mut put = |v: f64| values.next().into_iter().for_each(|slot| *slot = v);
        for (c, links) in grid.rows().flatten().zip(&self.links) {
            let mut diagonal = 0.0;
            for axis in 0..D {
                for (link, face) in [(links[2 * axis], c), (links[2 * axis + 1], c + grid.stride[axis])] {
                    let weight = inverse_h2[axis] * beta.at(axis, face);
                    match link {
                        Link::Closed => {}
                        Link::Outflow => diagonal += 2.0 * weight,
                        Link::Cell => {
                            diagonal += weight;
                            put(-weight);
                        }
                    }
                }
            }
            put(diagonal * definite);
        }
        let unsound = self.values.iter().any(|v| !v.is_finite() || *v == 0.0);
        if self.session.anywhere(unsound)? {
            return Err(Error::Run("the density of the mixture is not positive and finite on every face".into()));
        }
        self.solver.set_values(&self.values)
    }

    /// Adds `sum_k w_k j_k j_k^T` to the operator, in place of what was added before: the bodies that follow the pressure.
    /// Collective.
    pub fn set_modes(&mut self, weights: &[f64], entries: &[ModeEntry]) -> Result<()> {
        self.solver.set_modes(weights, entries)
    }

    /// Makes the face velocities divergence-free to D0 and adds what that took to the pressure (its ghosts are filled
    /// at the end); `rider` follows every change of it. Collective.
    ///
    /// # Errors
    /// When D0 is not reached, a solve fails twice, or a velocity is not finite.
    #[allow(clippy::too_many_arguments)]
    pub fn project<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        boundaries: &mut Boundaries<D>,
        beta: &FaceCoefficient<D>,
        dt: f64,
        p: &mut [f64],
        velocity: &mut VectorField<D>,
        mut rider: Option<&mut dyn Rider<D>>,
    ) -> Result<Projected> {
        let mut done = Projected::default();
        loop {
            done.divergence_max = self.largest_divergence(grid, velocity)?;
            // A step solves once though the limit is kept already, unless there is next to nothing to solve: pressure that
            // waits until D0 is reached makes the force on a particle jitter.
            let limit = self.rule.limit * if done.outer == 0 { IDLE } else { 1.0 };
            if done.divergence_max < limit {
                break;
            }
            if !done.divergence_max.is_finite() {
                return Err(Error::Run("a velocity is not a finite number".into()));
            }
            if done.outer as usize == self.rule.max_iterations {
                return Err(Error::Run(format!(
                    "C-HSMAC reached max |D| = {:.3e} 1/s in {} iterations, not D0 = {:.3e}: raise \
                     pressure.max_iterations or pressure.divergence_limit (rounding leaves about 1e-14 of \
                     velocity/spacing), or ask another solver",
                    done.divergence_max, self.rule.max_iterations, self.rule.limit
                )));
            }
            let tighter = self.rule.tightening.powi(done.outer as i32);
            let needed = (0.5 * self.rule.limit / done.divergence_max).clamp(1e-13, 0.1);
            let rtol = (tighter * self.solver.fixed_rtol().unwrap_or(needed)).max(1e-14);
            let within = done.divergence_max < self.rule.limit;
            let solved = self.correct(grid, boundaries, beta, dt, (rtol, within), p, velocity)?;
            if let Some(rider) = &mut rider {
                rider.follow(grid, dt, &self.phi, velocity)?;
            }
            done.outer += 1;
            done.krylov += solved.iterations;
            done.retries += u32::from(solved.retried);
        }
        boundaries.fill_pressure(p)?;
        Ok(done)
    }

    fn largest_divergence<const D: usize>(&mut self, grid: &Grid<D>, velocity: &VectorField<D>) -> Result<f64> {
        faces::divergence(grid, velocity, &mut self.divergence);
        let mut largest = [0.0f64];
        for d in grid.rows().flat_map(|row| &self.divergence[row]) {
            // f64::max would lose a NaN.
            largest[0] = if d.is_nan() { f64::INFINITY } else { largest[0].max(d.abs()) };
        }
        self.session.max(&mut largest)?;
        Ok(largest[0])
    }

    #[allow(clippy::too_many_arguments)]
    fn correct<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        boundaries: &mut Boundaries<D>,
        beta: &FaceCoefficient<D>,
        dt: f64,
        (rtol, within): (f64, bool),
        p: &mut [f64],
        velocity: &mut VectorField<D>,
    ) -> Result<crate::petsc::Solved> {
        let divergence = &self.divergence;
        self.solver.set_right_side(|b| {
            for (out, row) in b.chunks_exact_mut(grid.local[0]).zip(grid.rows()) {
                for (b, d) in out.iter_mut().zip(&divergence[row]) {
                    *b = -d / dt;
                }
            }
        })?;
        // A residual whose 2-norm is below this cannot hold a cell above D0/2; it ends no solve before it has begun.
        let atol = if within { 0.0 } else { 0.5 * self.rule.limit / dt };
        let solved = self.solver.solve(rtol, atol)?;
        let phi = &mut self.phi;
        self.solver.solution(|x| {
            for (values, row) in x.chunks_exact(grid.local[0]).zip(grid.rows()) {
                phi[row.clone()].copy_from_slice(values);
                for (p, phi) in p[row].iter_mut().zip(values) {
                    *p += phi;
                }
            }
        })?;
        boundaries.fill_pressure(phi)?;
        // Closed faces keep their velocity: phi's ghosts leave no gradient there.
        faces::add_gradient(grid, beta, -dt, phi, velocity);
        Ok(solved)
    }

    /// The linear solver in use.
    pub fn solver(&self) -> &LinearSolver {
        &self.solver
    }
}
