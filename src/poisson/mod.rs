//! The pressure's operator, applied without a matrix, and the preconditioner that it brings along:
//! a geometric multigrid (`multigrid`). PETSc's Krylov methods solve with both ([`crate::petsc`]).
//!
//! ```text
//!   (A x)_c = sum over the faces f of c:  (beta_f/h^2) (x_c - x_beyond f)  +
//!              sum_k w_k j_k,c (j_k . x)
//! ```
//! beta is the coefficient on faces, zero on closed ones and twice as large, with x = 0 beyond,
//! where the boundary gives the pressure. The modes `j_k` are free bodies (`bodies`): one for each
//! direction in which a body moves, and in which pressure turns it, non-zero in the cells that its
//! surface cuts only, on as many ranks as own some of them.

mod bodies;
mod bottom;
mod coefficient;
mod export;
mod frame;
mod held;
mod lattice;
mod level;
mod matrix;
mod merged;
mod multigrid;
mod preconditioner;
pub mod pressure;
mod solves;
mod sweeps;
mod system;
mod whole;

pub use bodies::ModeFace;
pub use matrix::MatrixRows;
pub use solves::SolveRow;
pub use system::{Factor, Origin, OwnSolve, System};

use crate::Result;
use crate::grid::{Boundaries, Grid, simd};
use crate::kernels::faces::FaceCoefficient;
use crate::petsc::{Halo, Layout, Operator, Session};
use crate::sharing::Sharing;
use bodies::Bodies;
use coefficient::Coefficient;
use frame::Frame;
use held::HeldMean;
use lattice::{Lattice, exchange};
use multigrid::Tuning;
use preconditioner::Preconditioner;
use whole::Whole;

/// The operator on this rank's cells, x fastest and without ghosts in what goes in and out.
pub struct Poisson {
    session: Session,
    frame: Frame,
    coefficient: Coefficient,
    bodies: Bodies,
    held: HeldMean,
    /// Excess of the assembled matrix's diagonal over the operator's, cell by cell; empty where
    /// there is no such matrix, or no excess.
    shift: Vec<f64>,
    preconditioner: Preconditioner,
    /// Scratch of a product: x with ghosts, and their exchange.
    x: Vec<f64>,
    halo: Halo<f64>,
}

impl Poisson {
    /// The operator on `grid`, without a coefficient yet. Collective.
    pub fn new<const D: usize>(
        session: &Session,
        layout: &Layout,
        grid: &Grid<D>,
        boundaries: &Boundaries<D>,
    ) -> Result<Poisson> {
        let lattice = Lattice::new(layout.local, D);
        let narrowest = grid.h.iter().copied().fold(f64::INFINITY, f64::min);
        let inverse_h = std::array::from_fn(|a| grid.h.get(a).map_or(0.0, |h| narrowest / h));
        let whole = Whole::of_grid(session, layout, grid)?;
        Ok(Poisson {
            session: session.clone(),
            frame: Frame::new(lattice, layout, grid),
            coefficient: Coefficient::new(lattice, grid, boundaries),
            bodies: Bodies::new(session, whole.axes, inverse_h),
            held: HeldMean::default(),
            shift: Vec::new(),
            preconditioner: Preconditioner::new(session, whole, narrowest),
            x: lattice.field(),
            halo: lattice.halo(session, layout.neighbours),
        })
    }

    /// Takes `beta` on faces. Collective.
    ///
    /// # Errors
    /// When it is not positive and finite on every open face: a zero row would make solvers report
    /// success.
    pub fn set<const D: usize>(&mut self, grid: &Grid<D>, beta: &FaceCoefficient<D>) -> Result<()> {
        self.coefficient.set(&self.session, grid, beta)?;
        self.preconditioner.outdate();
        Ok(())
    }

    /// Takes the largest extent of a free body (m), which says on which levels of the multigrid
    /// bodies take part. The same on every rank.
    pub fn set_extent(&mut self, across: f64) {
        // A face's cells on both sides, and a body between two faces.
        let cells = |h2: &f64| across * h2.sqrt() + 3.0;
        self.bodies.set_across(self.coefficient.inverse_h2.iter().map(cells).fold(0.0, f64::max));
    }

    /// Takes the largest right side (1/s2) of the next solves, by which the preconditioner scales.
    /// The same on every rank.
    pub fn set_size(&mut self, size: f64) {
        self.preconditioner.set_size(size);
    }

    /// Adds `sum_k w_k j_k j_k^T` to the operator, in place of what the last call added; the
    /// weights (m3/kg) are the same on every rank, and as many for each body as there are axes,
    /// then as many for each of the bodies that are `turning`. `covered` are the faces of this
    /// rank's cells that each body covers, body by body, and then again of those that turn;
    /// `sharing` lists the bodies that may have faces on several ranks.
    /// Allocates only to grow. Collective.
    ///
    /// # Errors
    /// When a weight is negative, a number not finite, a face not there, or the bodies out of
    /// order.
    pub fn set_modes(
        &mut self,
        weights: &[f64],
        covered: &[ModeFace],
        turning: &[u32],
        sharing: &Sharing,
    ) -> Result<()> {
        self.preconditioner.outdate();
        let scale = self.coefficient.finest();
        self.bodies.set(&self.frame, weights, covered, turning, sharing, scale)
    }

    /// Adds `weight j j^T` to the operator, in place of what the last call added: the response to
    /// the pressure of the drive that holds a mean velocity. `faces` are those of this rank's
    /// cells, along `axis` with the spacing `h` (m), with the parts g that j is made of (m3/kg).
    pub fn set_held(
        &mut self,
        axis: usize,
        h: f64,
        faces: impl Iterator<Item = (usize, f64)>,
        weight: f64,
    ) {
        self.held.set(&self.frame, axis, h, faces, weight);
    }

    /// `y += L x`: free bodies and a held mean velocity. Collective.
    fn add_low_rank(&mut self, x: &[f64], y: &mut [f64]) -> Result<()> {
        if self.bodies.any() {
            let nx = self.coefficient.lattice.n[0];
            self.bodies.respond(|row| row * nx, |cell| x[cell])?;
            for (row, y) in y.chunks_exact_mut(nx).enumerate() {
                self.bodies.terms(row).for_each(|(at, term)| y[at] += term);
            }
        }
        self.held.add_product(&self.session, |row| x[row], |row, term| y[row] += term)
    }

    /// The terms of low rank, one by one.
    fn factors(&self) -> Vec<Factor> {
        self.bodies.factors().into_iter().chain(self.held.factor()).collect()
    }
}

impl Operator for Poisson {
    fn multiply(&mut self, x: &[f64], y: &mut [f64]) -> Result<()> {
        let lattice = self.coefficient.lattice;
        let nx = lattice.n[0];
        for (s, x) in lattice.rows().zip(x.chunks_exact(nx)) {
            self.x[s..][..nx].copy_from_slice(x);
        }
        exchange(&mut self.halo, lattice.axes, &mut self.x)?;
        let g = &self.coefficient.g;
        let field = &self.x;
        simd(
            #[inline(always)]
            || {
                for (s, y) in lattice.rows().zip(y.chunks_exact_mut(nx)) {
                    lattice.for_row(
                        g,
                        field,
                        s,
                        y,
                        #[inline(always)]
                        |_, _, flux| -flux,
                    );
                }
            },
        );
        self.add_low_rank(x, y)
    }

    fn differs_from_matrix(&self) -> bool {
        self.coefficient.singular || self.bodies.any() || self.held.any()
    }

    fn add_difference(&mut self, x: &[f64], y: &mut [f64]) -> Result<()> {
        for ((y, x), shift) in y.iter_mut().zip(x).zip(&self.shift) {
            *y -= shift * x;
        }
        self.add_low_rank(x, y)
    }

    fn setups(&self) -> u32 {
        self.preconditioner.setups
    }

    fn precondition(&mut self, r: &[f64], z: &mut [f64]) -> Result<()> {
        self.preconditioner.apply(&self.coefficient, &mut self.bodies, r, z)
    }

    fn accept(&self) -> Result<()> {
        Tuning::read(&self.session).map(drop)
    }
}
