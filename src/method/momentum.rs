//! The momentum equation (7) without its pressure, in the stages of a Runge-Kutta scheme:
//!
//! ```text
//!   rate = sum_k w_k [ -div(U u_k) + div( mu (grad u_k + grad u_k^T) )/rho + f/rho ]
//!              f: forces per volume ([`crate::force`])
//!   u_k  = u + dt ( c_k rate + b_k a )
//!              for the stages after the first, a the acceleration by the last pressure
//! ```

use crate::Result;
use crate::clock::Stage;
use crate::domain::Domain;
use crate::grid::{Coefficient, Grid, VectorField};
use crate::kernels::advection::{self, Carrier, Fluxes};
use crate::kernels::{diffusion, faces};
use crate::scheme::Scheme;
use crate::state::State;

/// What fills the cells.
#[derive(Clone, Debug)]
pub struct Mixture {
    /// Density (kg/m3).
    pub density: Coefficient,
    /// Viscosity (Pa s).
    pub viscosity: Coefficient,
}

impl Mixture {
    /// Whether it is one fluid everywhere.
    fn is_uniform(&self) -> bool {
        let uniform = |property: &Coefficient| matches!(property, Coefficient::Uniform(_));
        uniform(&self.density) && uniform(&self.viscosity)
    }
}

/// How momentum is carried, with what that needs.
pub enum Advection<const D: usize> {
    /// Conservative, of fifth order.
    Upwind5,
    /// Along paths, by axis (QSI).
    Qsi {
        /// The velocity before the sweep of an axis.
        from: VectorField<D>,
        /// That after it.
        to: VectorField<D>,
    },
}

/// A term of (7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Term {
    /// `-u.grad u`.
    Convective,
    /// `div tau/rho`.
    Viscous,
}

/// Hears of each term of (7) before (-1) and after (1) the rate of the cells (m/s2) has it.
pub type Listener<'a, const D: usize> = &'a mut dyn FnMut(&Grid<D>, Term, f64, &VectorField<D>);

/// The terms of (7) and their scratch.
pub struct Momentum<const D: usize> {
    /// The time scheme.
    pub scheme: Scheme,
    advection: Advection<D>,
    /// Weighted sum of the stages' rates (m/s2).
    rate: VectorField<D>,
    fluxes: Fluxes,
    /// Scratch where the viscosity varies.
    scratch: Vec<f64>,
}

impl<const D: usize> Momentum<D> {
    /// The terms by a scheme and an advection.
    pub fn new(
        grid: &Grid<D>,
        scheme: Scheme,
        advection: Advection<D>,
        mixture: &Mixture,
    ) -> Momentum<D> {
        let varies = matches!(mixture.viscosity, Coefficient::Field(_));
        Momentum {
            scheme,
            advection,
            rate: grid.vector_field(),
            fluxes: Fluxes::new(grid),
            scratch: if varies { grid.field() } else { Vec::new() },
        }
    }

    /// Whether what advection takes of the momentum of one cell another has, but for the sides of
    /// the box.
    pub fn keeps_momentum(&self) -> bool {
        matches!(self.advection, Advection::Upwind5)
    }

    /// The face velocities that carry in a step of `dt` (s): in the middle of it, for schemes of
    /// second order, which keep those of the step before.
    pub fn carrier<'a>(&self, s: &'a State<D>, dt: f64) -> Carrier<'a, D> {
        let extrapolates = !s.faces_before[0].is_empty() && s.dt > 0.0;
        let before = extrapolates.then(|| (&s.faces_before, 0.5 * dt / s.dt));
        Carrier { now: &s.faces, before }
    }

    /// The velocity `u` (m/s) that the stage `k`, not the first, of a step of `dt` (s) starts from.
    pub fn start_stage(
        &self,
        domain: &mut Domain<D>,
        k: usize,
        start: &VectorField<D>,
        acceleration: &VectorField<D>,
        dt: f64,
        u: &mut VectorField<D>,
    ) {
        let (of_rate, of_pressure) = self.scheme.stages[k - 1];
        let rate = (dt * of_rate, &self.rate);
        let acceleration = (dt * of_pressure, acceleration);
        faces::step_cells(&domain.grid, Some(start), rate, acceleration, u);
        domain.clock.lap(Stage::Update);
    }

    /// Adds the stage `k` with its velocity `u` (m/s), ghosts filled; the first stage replaces what
    /// was there. Collective.
    #[allow(clippy::too_many_arguments)]
    pub fn add_stage(
        &mut self,
        domain: &mut Domain<D>,
        k: usize,
        mixture: &Mixture,
        carrier: &Carrier<D>,
        u: &VectorField<D>,
        dt: f64,
        listener: Option<Listener<D>>,
    ) -> Result<()> {
        self.add_weighted(
            domain,
            (self.scheme.weights[k], k == 0),
            mixture,
            carrier,
            u,
            dt,
            listener,
        )
    }

    /// Exchanges the rate for what is in `kept` (m/s2).
    pub fn swap_rate(&mut self, kept: &mut VectorField<D>) {
        std::mem::swap(&mut self.rate, kept);
    }

    /// Adds the rate of the velocity `u` (m/s), ghosts filled, times a weight; a fresh one replaces
    /// what was there. Without a listener and in one fluid, advection and diffusion are one pass.
    /// Collective.
    #[allow(clippy::too_many_arguments)]
    pub fn add_weighted(
        &mut self,
        domain: &mut Domain<D>,
        (weight, fresh): (f64, bool),
        mixture: &Mixture,
        carrier: &Carrier<D>,
        u: &VectorField<D>,
        dt: f64,
        listener: Option<Listener<D>>,
    ) -> Result<()> {
        let in_one_pass = listener.is_none()
            && mixture.is_uniform()
            && matches!(self.advection, Advection::Upwind5);
        if in_one_pass {
            let nu = mixture.viscosity.at(0) / mixture.density.at(0);
            let rate = &mut self.rate;
            let fluxes = &mut self.fluxes;
            advection::upwind5(&domain.grid, carrier, u, nu, weight, fresh, rate, fluxes);
            domain.clock.lap(Stage::Advection);
        } else {
            let mut nobody = |_: &Grid<D>, _, _, _: &VectorField<D>| ();
            let hear = listener.unwrap_or(&mut nobody);
            self.add_terms(domain, (weight, fresh), mixture, carrier, u, dt, hear)?;
        }
        if let Some(forces) = &domain.forces {
            forces.add_to(&domain.grid, weight, &mixture.density, &mut self.rate);
            domain.clock.lap(Stage::Update);
        }
        Ok(())
    }

    #[allow(clippy::too_many_arguments)]
    fn add_terms(
        &mut self,
        domain: &mut Domain<D>,
        (weight, fresh): (f64, bool),
        mixture: &Mixture,
        carrier: &Carrier<D>,
        u: &VectorField<D>,
        dt: f64,
        hear: Listener<D>,
    ) -> Result<()> {
        if fresh {
            self.rate.iter_mut().for_each(|f| f.fill(0.0));
        }
        hear(&domain.grid, Term::Convective, -1.0, &self.rate);
        domain.clock.lap(Stage::Force);
        self.add_advection(domain, weight, carrier, u, dt)?;
        domain.clock.lap(Stage::Advection);
        hear(&domain.grid, Term::Convective, 1.0, &self.rate);
        hear(&domain.grid, Term::Viscous, -1.0, &self.rate);
        domain.clock.lap(Stage::Force);
        self.add_diffusion(&domain.grid, weight, mixture, u);
        domain.clock.lap(Stage::Diffusion);
        hear(&domain.grid, Term::Viscous, 1.0, &self.rate);
        domain.clock.lap(Stage::Force);
        Ok(())
    }

    fn add_advection(
        &mut self,
        domain: &mut Domain<D>,
        weight: f64,
        carrier: &Carrier<D>,
        u: &VectorField<D>,
        dt: f64,
    ) -> Result<()> {
        let grid = &domain.grid;
        let rate = &mut self.rate;
        match &mut self.advection {
            Advection::Upwind5 => {
                advection::upwind5(grid, carrier, u, 0.0, weight, false, rate, &mut self.fluxes)
            }
            Advection::Qsi { from, to } => {
                from.iter_mut().zip(u).for_each(|(from, u)| from.copy_from_slice(u));
                for axis in 0..D {
                    domain.boundaries.fill_velocity(from)?;
                    for (q, out) in from.iter().zip(to.iter_mut()) {
                        advection::qsi_sweep(grid, axis, &u[axis], dt, q, out);
                    }
                    std::mem::swap(from, to);
                }
                for ((rate, end), start) in rate.iter_mut().zip(from.iter()).zip(u) {
                    for c in grid.rows().flatten() {
                        rate[c] += weight * (end[c] - start[c]) / dt;
                    }
                }
            }
        }
        Ok(())
    }

    fn add_diffusion(
        &mut self,
        grid: &Grid<D>,
        weight: f64,
        mixture: &Mixture,
        u: &VectorField<D>,
    ) {
        match &mixture.viscosity {
            Coefficient::Uniform(0.0) => {}
            Coefficient::Uniform(mu) => {
                for (q, rate) in u.iter().zip(&mut self.rate) {
                    diffusion::laplacian(grid, *mu, &mixture.density, q, weight, rate);
                }
            }
            Coefficient::Field(mu) => {
                for (i, rate) in self.rate.iter_mut().enumerate() {
                    diffusion::stress(
                        grid,
                        mu,
                        &mixture.density,
                        u,
                        i,
                        weight,
                        rate,
                        &mut self.scratch,
                    );
                }
            }
        }
    }

    /// The sum of the stages (m/s2).
    pub fn rate(&self) -> &VectorField<D> {
        &self.rate
    }
}
