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
mod held;
mod lattice;
mod level;
mod matrix;
mod merged;
mod multigrid;
pub mod pressure;
mod solves;
mod sweeps;
mod system;
mod whole;

pub use bodies::ModeFace;
pub use matrix::Rows;
pub use solves::SolveRow;
pub use system::{Factor, Origin, OwnSolve, System};

use crate::Result;
use crate::grid::{Boundaries, BoundaryKind, Grid, largest, simd};
use crate::petsc::{Halo, Layout, Operator, Session};
use crate::sharing::Sharing;
use bodies::{Bodies, Frame};
use coefficient::Ends;
use held::HeldMean;
use lattice::{Lattice, exchange};
use multigrid::{Multigrid, Tuning};
use whole::Whole;

/// The operator on this rank's cells, x fastest and without ghosts in what goes in and out.
pub struct Poisson {
    session: Session,
    lattice: Lattice,
    halo: Halo<f64>,
    /// `1/h^2` by axis (1/m2), zero along unused ones.
    inverse_h2: [f64; 3],
    ends: [Ends; 3],
    /// Whether this rank's box ends at the low and high end of each axis.
    at_end: [[bool; 2]; 3],
    whole: Whole,
    singular: bool,
    /// `beta/h^2` on faces.
    g: [Vec<f64>; 3],
    largest: f64,
    x: Vec<f64>,
    bodies: Bodies,
    held: HeldMean,
    frame: Frame,
    /// The smallest spacing (m).
    narrowest: f64,
    /// What the assembled matrix has on its diagonal beyond the operator, cell by cell; empty where
    /// there is no such matrix, or nothing beyond.
    shift: Vec<f64>,
    setups: u32,
    multigrid: Option<Cached>,
}

/// The multigrid and whether it has the present coefficient.
struct Cached {
    made: Multigrid,
    valid: bool,
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
        let ends = std::array::from_fn(|a| match boundaries.kinds.get(a) {
            Some([Some(low), Some(high)]) => {
                let given = [low, high].map(|boundary| matches!(boundary, BoundaryKind::Outflow));
                Ends::Boundaries { given }
            }
            _ => Ends::Periodic,
        });
        let at_end = std::array::from_fn(|a| [0, 1].map(|side| a < D && grid.at_boundary(a, side)));
        let whole = Whole::of_grid(session, layout, grid)?;
        Ok(Poisson {
            session: session.clone(),
            halo: lattice.halo(session, layout.neighbours),
            inverse_h2: std::array::from_fn(|a| {
                if a < D { 1.0 / (grid.h[a] * grid.h[a]) } else { 0.0 }
            }),
            ends,
            at_end,
            singular: !boundaries.fixes_pressure(),
            g: lattice.faces(),
            largest: 0.0,
            x: lattice.field(),
            bodies: Bodies::new(
                session,
                whole.axes,
                std::array::from_fn(|a| grid.h.get(a).map_or(0.0, |h| narrowest / h)),
            ),
            held: HeldMean::default(),
            frame: Frame {
                stride: std::array::from_fn(|a| grid.stride.get(a).copied().unwrap_or(1)),
                stored: layout.stored,
                ghosts: layout.ghosts,
            },
            narrowest,
            shift: Vec::new(),
            setups: 0,
            multigrid: None,
            whole,
            lattice,
        })
    }

    /// Takes the largest extent of a free body (m), which says on which levels of the multigrid
    /// bodies take part. The same on every rank.
    pub fn set_extent(&mut self, across: f64) {
        // A face's cells on both sides, and a body between two faces.
        let cells = |h2: &f64| across * h2.sqrt() + 3.0;
        self.bodies.set_across(self.inverse_h2.iter().map(cells).fold(0.0, f64::max));
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
        if let Some(made) = &mut self.multigrid {
            made.valid = false;
        }
        let scale = 1.0 / (self.narrowest * self.narrowest);
        self.bodies.set((&self.lattice, &self.frame), weights, covered, turning, sharing, scale)
    }

    /// Adds `weight j j^T` to the operator, in place of what the last call added: what the drive
    /// that holds a mean velocity responds to the pressure. `faces` are those of this rank's cells,
    /// along `axis` with the spacing `h` (m), with the parts g that j is made of (m3/kg).
    pub fn set_held(
        &mut self,
        at: (usize, f64),
        faces: impl Iterator<Item = (usize, f64)>,
        weight: f64,
    ) {
        self.held.set(&self.lattice, &self.frame, at, faces, weight);
    }

    /// The multigrid, and the bodies that take part in it.
    fn multigrid(&mut self) -> Result<(&mut Multigrid, &mut Bodies)> {
        let made = match self.multigrid.take() {
            Some(made) => made,
            None => {
                let tuning = Tuning::read(&self.session)?;
                let whole = self.whole.clone();
                let resolving = self.bodies.resolving();
                let made = Multigrid::new(&self.session, whole, self.singular, tuning, resolving);
                Cached { made, valid: false }
            }
        };
        let Cached { made, valid } = self.multigrid.insert(made);
        if !*valid {
            // In single precision the range of the coefficient has to lie around one.
            let scale = 1.0 / self.largest;
            for (to, from) in made.levels[0].g.iter_mut().zip(&self.g) {
                simd(
                    #[inline(always)]
                    || {
                        for (to, from) in to.iter_mut().zip(from) {
                            *to = (scale * from) as f32;
                        }
                    },
                );
            }
            let unit = self.inverse_h2.map(|i| i * self.narrowest * self.narrowest);
            made.rebuild(&mut self.bodies, unit, scale)?;
            self.setups += 1;
            *valid = true;
        }
        Ok((made, &mut self.bodies))
    }
}

impl Operator for Poisson {
    fn multiply(&mut self, x: &[f64], y: &mut [f64]) -> Result<()> {
        let lattice = self.lattice;
        let nx = self.lattice.n[0];
        for (s, x) in lattice.rows().zip(x.chunks_exact(nx)) {
            self.x[s..][..nx].copy_from_slice(x);
        }
        exchange(&mut self.halo, lattice.axes, &mut self.x)?;
        let g = &self.g;
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
        self.singular || self.bodies.any() || self.held.any()
    }

    fn add_difference(&mut self, x: &[f64], y: &mut [f64]) -> Result<()> {
        for ((y, x), shift) in y.iter_mut().zip(x).zip(&self.shift) {
            *y -= shift * x;
        }
        self.add_low_rank(x, y)
    }

    fn setups(&self) -> u32 {
        self.setups
    }

    fn precondition(&mut self, r: &[f64], z: &mut [f64]) -> Result<()> {
        let most = || {
            simd(
                #[inline(always)]
                || {
                    largest(
                        r.len(),
                        #[inline(always)]
                        |i| r[i].abs(),
                    )
                },
            )
        };
        let mut size = [most()];
        self.session.max(&mut size)?;
        if size[0] == 0.0 {
            z.fill(0.0);
            return Ok(());
        }
        let nx = self.lattice.n[0];
        let most = self.largest;
        let (multigrid, bodies) = self.multigrid()?;
        let down = 1.0 / size[0];
        let up = size[0] / most;
        let finest = &mut multigrid.levels[0];
        let lattice = finest.lattice;
        let b = &mut finest.b;
        simd(
            #[inline(always)]
            || {
                for (s, r) in lattice.rows().zip(r.chunks_exact(nx)) {
                    b[s..][..nx].iter_mut().zip(r).for_each(
                        #[inline(always)]
                        |(b, r)| *b = (down * r) as f32,
                    );
                }
            },
        );
        multigrid.cycle(bodies, true)?;
        let x = &multigrid.levels[0].x;
        simd(
            #[inline(always)]
            || {
                for (s, z) in lattice.rows().zip(z.chunks_exact_mut(nx)) {
                    z.iter_mut().zip(&x[s..][..nx]).for_each(
                        #[inline(always)]
                        |(z, x)| *z = up * f64::from(*x),
                    );
                }
            },
        );
        Ok(())
    }

    fn accept(&self) -> Result<()> {
        Tuning::read(&self.session).map(drop)
    }
}

impl Poisson {
    /// `y += L x`: free bodies and a held mean velocity. Collective.
    fn add_low_rank(&mut self, x: &[f64], y: &mut [f64]) -> Result<()> {
        if self.bodies.any() {
            let nx = self.lattice.n[0];
            self.bodies.respond(|row| row * nx, |cell| x[cell])?;
            for (row, y) in y.chunks_exact_mut(nx).enumerate() {
                self.bodies.terms(row).for_each(|(at, term)| y[at] += term);
            }
        }
        self.held.add_product(&self.session, |row| x[row], |row, term| y[row] += term)
    }
}
