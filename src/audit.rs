//! The balance of momentum over a step: fluid, particles, borders.
//!
//! With `M = sum_c rho u dV` over all cells, particles included (kg m/s; per metre of depth in 2D),
//! ```text
//!   fluid's part of the step      M(u_f) - M(u^n)    = gravity + carried + border
//!   particles' part of the step   M(u^(n+1)) - M(u_f) = -carried + contacts with walls and held bodies - force on held bodies
//! ```
//! `carried` is what the fields transport of the particles' excess mass. The border's impulse is what the first line
//! leaves, less the excess mass that contacts let a little way into a wall: nothing in a box that is periodic all round.
//! The second line has to close by itself, and its error is what `steps.csv` reports, with the first line's where there is
//! no border.
//!
//! With sharp walls the momentum is that of the fluid outside the particles, of the free particles, and what these are still
//! owed of what the fluid lost ([`crate::coupling::sharp`]),
//! ```text
//!   M = sum_c (1 - alpha) rho u dV + sum_k (m_k V_k + owed_k),    M^(n+1) - M^n = gravity + contacts - force on held bodies + border
//! ```
//! and the border's impulse is that of pressure, viscosity and flow on the sides of the box ([`crate::fluid::border`]), taken
//! from the fields there in every stage. What the two sides of this line differ by is the error.

use crate::coupling::Exchange;
use crate::coupling::mixing::Mixing;
use crate::coupling::sharp::Sharp;
use crate::grid::{Coefficient, Grid, VectorField};
use crate::petsc::Session;
use crate::tape::{Lasting, Tape};
use crate::{Result, solids::Body};
use nalgebra::Vector3;

/// The sums of a step.
#[derive(Clone, Debug, Default)]
pub struct Audit {
    before: Vector3<f64>,
    fluid: Vector3<f64>,
    /// Force of this rank's sides on the fluid by viscosity and flow, over the stages of the step so far (N).
    sides: Vector3<f64>,
    /// Momentum of everything in the box after the step (kg m/s).
    pub momentum: Vector3<f64>,
    /// Impulse of the borders over the step (N s).
    pub border: Vector3<f64>,
    /// What is missing in the balance of momentum (kg m/s).
    pub error: Vector3<f64>,
    /// What is missing in the balances of angular momentum about the particles' centres, summed over them (kg m2/s).
    pub angular_error: f64,
}

impl Lasting for Audit {
    fn pass(&mut self, tape: &mut Tape) -> Result<()> {
        // The first three are taken anew in every step.
        let Audit { before: _, fluid: _, sides: _, momentum, border, error, angular_error } = self;
        tape.pass([momentum, border, error, angular_error])
    }
}

/// This rank's momentum.
fn momentum<const D: usize>(grid: &Grid<D>, density: &Coefficient, u: &VectorField<D>) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    for (a, u) in u.iter().enumerate() {
        sum[a] = match density {
            Coefficient::Uniform(rho) => rho * grid.rows().map(|row| u[row].iter().sum::<f64>()).sum::<f64>(),
            Coefficient::Field(rho) => {
                let row_sum = |row: std::ops::Range<usize>| -> f64 {
                    u[row.clone()].iter().zip(&rho[row]).map(|(u, rho)| u * rho).sum()
                };
                grid.rows().map(row_sum).sum()
            }
        };
    }
    sum * grid.cell_volume()
}

/// The momentum of everything in the box with sharp walls (kg m/s). Collective.
fn momentum_with_walls<const D: usize>(
    session: &Session,
    grid: &Grid<D>,
    u: &VectorField<D>,
    walls: &Sharp<D>,
) -> Result<Vector3<f64>> {
    let mut cells = momentum(grid, &Coefficient::Uniform(walls.fluid_density()), u);
    session.sum(cells.as_mut_slice())?;
    Ok(cells + walls.momentum_beside_cells())
}

impl Audit {
    /// Takes the state that a step begins with.
    pub fn begin<const D: usize>(&mut self, grid: &Grid<D>, density: &Coefficient, u: &VectorField<D>) {
        self.before = momentum(grid, density, u);
    }

    /// Takes the state after the fluid's part.
    pub fn after_fluid<const D: usize>(&mut self, grid: &Grid<D>, density: &Coefficient, u: &VectorField<D>) {
        self.fluid = momentum(grid, density, u);
    }

    /// Adds what the sides do in a stage of this `weight`, by a `force` (N) on this rank's fluid.
    pub fn add_sides(&mut self, weight: f64, force: Vector3<f64>) {
        self.sides += weight * force;
    }

    /// Starts the balance with sharp walls. Collective.
    pub fn start_sharp<const D: usize>(
        &mut self,
        session: &Session,
        grid: &Grid<D>,
        u: &VectorField<D>,
        walls: &Sharp<D>,
    ) -> Result<()> {
        *self = Audit::default();
        self.momentum = momentum_with_walls(session, grid, u, walls)?;
        Ok(())
    }

    /// Closes the step `dt` (s) with sharp walls, whose sides push with `pressure` (N) on this rank's fluid. Collective.
    pub fn close_sharp<const D: usize>(
        &mut self,
        session: &Session,
        grid: &Grid<D>,
        u: &VectorField<D>,
        pressure: Vector3<f64>,
        walls: &Sharp<D>,
        dt: f64,
    ) -> Result<()> {
        let mut border = dt * (std::mem::take(&mut self.sides) + pressure);
        session.sum(border.as_mut_slice())?;
        let after = momentum_with_walls(session, grid, u, walls)?;
        let before = std::mem::replace(&mut self.momentum, after);
        self.border = border;
        self.error = after - before - walls.impulse(dt) - border;
        self.angular_error = walls.angular_error(dt);
        Ok(())
    }

    /// Closes the step `dt` (s) with the state after the particles' part. Collective.
    pub fn close<const D: usize>(
        &mut self,
        session: &Session,
        grid: &Grid<D>,
        density: &Coefficient,
        u: &VectorField<D>,
        coupling: &Mixing<D>,
        dt: f64,
    ) -> Result<()> {
        let after = momentum(grid, density, u);
        let mut sums = [0.0; 9];
        for (slot, v) in sums.chunks_exact_mut(3).zip([self.before, self.fluid, after]) {
            slot.copy_from_slice(v.as_slice());
        }
        session.sum(&mut sums)?;
        let [before, fluid, after] = [0, 3, 6].map(|k| Vector3::new(sums[k], sums[k + 1], sums[k + 2]));
        let carried = dt * coupling.carried();
        self.momentum = after;
        self.border = fluid - before - carried - dt * coupling.weight();
        // The whole force on held bodies, and on free ones that along the directions in which they are held.
        let held = |(b, e): (&Body, &Exchange)| b.freedom().map_or(e.held(), |f| e.momentum - f.along(&e.momentum));
        let on_held: Vector3<f64> = coupling.bodies().iter().zip(coupling.exchange()).map(held).sum();
        let beyond = coupling.beyond_walls();
        self.border -= beyond;
        self.error = after - fluid + carried - coupling.impulse() + dt * on_held + beyond;
        if grid.periodic.iter().all(|p| *p) {
            self.error += std::mem::take(&mut self.border);
        }
        self.angular_error = coupling.angular_error();
        Ok(())
    }
}
