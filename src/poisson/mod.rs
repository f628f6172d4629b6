//! The pressure's operator, applied without a matrix, and what solves with it: a geometric
//! multigrid (`multigrid`) and, where the coefficient is uniform, transforms (`transform`).
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
mod conjugate;
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
mod transform;
mod whole;

pub use bodies::ModeFace;
pub use matrix::Rows;
pub use solves::SolveRow;
pub use system::{Factor, Origin, OwnSolve, System};

use crate::grid::{Boundaries, BoundaryKind, Grid, largest, simd};
use crate::petsc::{Ended, Goal, Halo, Layout, Operator, OwnPreconditioner, Session};
use crate::sharing::Sharing;
use crate::{Error, Result};
use bodies::{Bodies, Frame};
use coefficient::Coefficient;
use conjugate::Conjugate;
use held::HeldMean;
use lattice::{Lattice, exchange};
use multigrid::{Multigrid, Tuning};
use transform::{Ends, Transform};
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
    coefficient: Coefficient,
    /// `beta/h^2` on faces; empty until something needs it.
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
    multigrid: Option<Cached<Multigrid>>,
    transform: Option<Cached<Transform>>,
    conjugate: Conjugate,
}

/// A preconditioner and whether it has the present coefficient.
struct Cached<T> {
    made: T,
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
            coefficient: Coefficient::Nothing,
            g: Default::default(),
            largest: 0.0,
            x: Vec::new(),
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
            transform: None,
            conjugate: Conjugate::default(),
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
        self.need_faces();
        let made = match self.multigrid.take() {
            Some(made) => made,
            None => {
                let tuning = Tuning::read(&self.session)?;
                let (whole, resolving) = (self.whole.clone(), self.bodies.resolving());
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

    /// One cycle of the multigrid for `A z = r`.
    fn cycle(&mut self, r: &[f64], z: &mut [f64]) -> Result<()> {
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
        let (nx, most) = (self.lattice.n[0], self.largest);
        let (multigrid, bodies) = self.multigrid()?;
        let (down, up) = (1.0 / size[0], size[0] / most);
        let finest = &mut multigrid.levels[0];
        let (lattice, b) = (finest.lattice, &mut finest.b);
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

    fn transform(&mut self) -> Result<&mut Transform> {
        // As part of another preconditioner it comes here unasked.
        self.accept(OwnPreconditioner::Transform)?;
        let mean = match self.coefficient {
            Coefficient::Uniform(value) => self.inverse_h2.map(|i| i * value),
            _ => std::array::from_fn(|axis| {
                if axis < self.lattice.axes { self.mean_of_faces(axis) } else { 0.0 }
            }),
        };
        let (n, axes) = (self.lattice.n, self.lattice.axes);
        let made = match self.transform.take() {
            Some(made) => made,
            None => Cached { made: Transform::new(n, axes, self.ends), valid: false },
        };
        let Cached { made, valid } = self.transform.insert(made);
        if !*valid {
            made.set(mean);
            self.setups += 1;
            *valid = true;
        }
        Ok(made)
    }
}

impl Operator for Poisson {
    fn multiply(&mut self, x: &[f64], y: &mut [f64]) -> Result<()> {
        self.need_faces();
        let (lattice, nx) = (self.lattice, self.lattice.n[0]);
        for (s, x) in lattice.rows().zip(x.chunks_exact(nx)) {
            self.x[s..][..nx].copy_from_slice(x);
        }
        exchange(&mut self.halo, lattice.axes, &mut self.x)?;
        let (g, field) = (&self.g, &self.x);
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

    fn precondition(&mut self, own: OwnPreconditioner, r: &[f64], z: &mut [f64]) -> Result<()> {
        match own {
            OwnPreconditioner::Multigrid => self.cycle(r, z),
            OwnPreconditioner::Transform => {
                self.transform()?.solve(r, z);
                Ok(())
            }
        }
    }

    fn solve(
        &mut self,
        b: &mut [f64],
        x: &mut [f64],
        goal: Goal,
        residuals: Option<&mut Vec<f64>>,
    ) -> Result<(Ended, u32)> {
        self.conjugate_gradients(b, x, goal, residuals)
    }

    fn accept(&self, own: OwnPreconditioner) -> Result<()> {
        match own {
            OwnPreconditioner::Multigrid => Tuning::read(&self.session).map(drop),
            OwnPreconditioner::Transform if self.session.size() > 1 => Err(Error::Usage(
                "the direct solver (-pc_type transform) works on one rank; on several use the \
                multigrid (pressure.solver = \"multigrid\", or -pc_type boxmg)"
                    .into(),
            )),
            OwnPreconditioner::Transform => Ok(()),
        }
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
