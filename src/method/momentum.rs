//! The momentum equation (7) without its pressure, of the velocities of the stages of a step:
//!
//! ```text
//!   rate = sum_k w_k [ -div(U u_k) + div( mu (grad u_k + grad u_k^T) )/rho + f/rho ]
//!              f: forces per volume ([`crate::force`])
//! ```

use crate::Result;
use crate::clock::Stage;
use crate::domain::Domain;
use crate::grid::{Coefficient, Grid, VectorField};
use crate::kernels::advection::{self, Carrier, Fluxes};
use crate::kernels::diffusion;

/// Density and viscosity of the fluid or mixture in the cells.
#[derive(Clone, Debug)]
pub struct MixtureProperties {
    /// Density (kg/m3).
    pub density: Coefficient,
    /// Viscosity (Pa s).
    pub viscosity: Coefficient,
}

impl MixtureProperties {
    /// Whether it is one fluid everywhere.
    fn is_uniform(&self) -> bool {
        let uniform = |property: &Coefficient| matches!(property, Coefficient::Uniform(_));
        uniform(&self.density) && uniform(&self.viscosity)
    }
}

/// Advection scheme of the momentum, with the fields that it needs.
pub enum Advection<const D: usize> {
    /// Conservative, of fifth order.
    Upwind5,
    /// Along paths, by axis (QSI).
    Qsi {
        /// The velocity before the sweep of an axis.
        from: VectorField<D>,
        /// The velocity after it.
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

/// Observer of each term of (7), before (-1) and after (1) the rate of the cells (m/s2) has it.
pub type Hears<'a, const D: usize> = &'a mut dyn FnMut(&Grid<D>, Term, f64, &VectorField<D>);

/// A velocity whose rate is taken.
#[derive(Clone, Copy)]
pub struct Rated<'a, const D: usize> {
    /// The velocity (m/s), ghosts filled.
    pub u: &'a VectorField<D>,
    /// The face velocities that carry it.
    pub carrier: &'a Carrier<'a, D>,
    /// The step (s).
    pub dt: f64,
    /// Weight of the rate in the sum of the stages.
    pub weight: f64,
    /// Whether it replaces what was there.
    pub fresh: bool,
}

/// The terms of (7) and their scratch.
pub struct Momentum<const D: usize> {
    advection: Advection<D>,
    /// Weighted sum of the stages' rates (m/s2).
    rate: VectorField<D>,
    fluxes: Fluxes,
    /// Scratch where the viscosity varies.
    scratch: Vec<f64>,
}

impl<const D: usize> Momentum<D> {
    /// The terms by an advection.
    pub fn new(
        grid: &Grid<D>,
        advection: Advection<D>,
        mixture: &MixtureProperties,
    ) -> Momentum<D> {
        let varies = matches!(mixture.viscosity, Coefficient::Field(_));
        Momentum {
            advection,
            rate: grid.vector_field(),
            fluxes: Fluxes::new(grid),
            scratch: if varies { grid.field() } else { Vec::new() },
        }
    }

    /// Whether advection conserves momentum: what it takes of one cell another gets, but for the
    /// sides of the box.
    pub fn keeps_momentum(&self) -> bool {
        matches!(self.advection, Advection::Upwind5)
    }

    /// Exchanges the rate for what is in `kept` (m/s2).
    pub fn swap_rate(&mut self, kept: &mut VectorField<D>) {
        std::mem::swap(&mut self.rate, kept);
    }

    /// Adds the rate of a velocity. Without an observer, and in one fluid, advection and diffusion
    /// are one pass. Collective.
    pub fn add(
        &mut self,
        domain: &mut Domain<D>,
        mixture: &MixtureProperties,
        rated: &Rated<D>,
        hears: Option<Hears<D>>,
    ) -> Result<()> {
        let Rated { u, carrier, weight, fresh, .. } = *rated;
        let in_one_pass =
            hears.is_none() && mixture.is_uniform() && matches!(self.advection, Advection::Upwind5);
        if in_one_pass {
            let nu = mixture.viscosity.at(0) / mixture.density.at(0);
            let rate = &mut self.rate;
            let fluxes = &mut self.fluxes;
            advection::upwind5(&domain.grid, carrier, u, nu, weight, fresh, rate, fluxes);
            domain.clock.lap(Stage::Advection);
        } else {
            let mut nobody = |_: &Grid<D>, _, _, _: &VectorField<D>| ();
            self.add_terms(domain, mixture, rated, hears.unwrap_or(&mut nobody))?;
        }
        if let Some(forces) = &domain.forces {
            forces.add_to(&domain.grid, weight, &mixture.density, &mut self.rate);
            domain.clock.lap(Stage::Update);
        }
        Ok(())
    }

    fn add_terms(
        &mut self,
        domain: &mut Domain<D>,
        mixture: &MixtureProperties,
        rated: &Rated<D>,
        hear: Hears<D>,
    ) -> Result<()> {
        if rated.fresh {
            self.rate.iter_mut().for_each(|f| f.fill(0.0));
        }
        hear(&domain.grid, Term::Convective, -1.0, &self.rate);
        domain.clock.lap(Stage::Force);
        self.add_advection(domain, rated)?;
        domain.clock.lap(Stage::Advection);
        hear(&domain.grid, Term::Convective, 1.0, &self.rate);
        hear(&domain.grid, Term::Viscous, -1.0, &self.rate);
        domain.clock.lap(Stage::Force);
        self.add_diffusion(&domain.grid, mixture, rated);
        domain.clock.lap(Stage::Diffusion);
        hear(&domain.grid, Term::Viscous, 1.0, &self.rate);
        domain.clock.lap(Stage::Force);
        Ok(())
    }

    fn add_advection(&mut self, domain: &mut Domain<D>, rated: &Rated<D>) -> Result<()> {
        let Rated { u, carrier, dt, weight, .. } = *rated;
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

    fn add_diffusion(&mut self, grid: &Grid<D>, mixture: &MixtureProperties, rated: &Rated<D>) {
        let Rated { u, weight, .. } = *rated;
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

    /// Weighted sum of the stages' rates (m/s2).
    pub fn rate(&self) -> &VectorField<D> {
        &self.rate
    }
}
