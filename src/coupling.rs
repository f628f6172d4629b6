//! Where fluid and particles meet: the mixture's properties (1), the wall (27), and the force on each particle (19),
//! all from one list of overlaps.
//!
//! ```text
//!   rho = rho_f + sum_k alpha_k (rho_k - rho_f)                         (1), viscosity alike
//!   u   = u_f + sum_k alpha_k (v_k - u_f),  v_k = V_k + omega_k x r     (27), in every touched cell
//!   F_k = sum_c rho alpha_k (u_f - v_k) dV/dt                           the momentum that (27) removes
//!   F_k = sum_c alpha_k dV [ -rho u.grad u - grad p_f + div tau ]       (19) as printed, its three parts
//! ```
//! A later coupling replaces [`Coupling::face_coefficient`] (openings in the pressure equation),
//! [`Coupling::impose`] (the wall) and the forces; the step calls no others.

use crate::fluid::faces::FaceCoefficient;
use crate::grid::{Boundaries, Coefficient, Grid, VectorField};
use crate::petsc::Session;
use crate::solids::{Body, Motion, Overlap, fraction, nearest_image};
use crate::{Error, Result};
use nalgebra::Vector3;

/// What fluid and one particle exchange over a step. Forces in N (per metre of depth in 2D), torques in N m about the
/// particle's centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange {
    /// Force by the momentum that the mixing (27) removes from the fluid.
    pub momentum: Vector3<f64>,
    /// Its torque.
    pub momentum_torque: Vector3<f64>,
    /// Convective part of (19).
    pub convective: Vector3<f64>,
    /// Pressure part of (19).
    pub pressure: Vector3<f64>,
    /// Viscous part of (19).
    pub viscous: Vector3<f64>,
    /// Torque of the three parts of (19).
    pub literal_torque: Vector3<f64>,
}

/// Numbers in an [`Exchange`].
const PARTS: usize = 18;

impl Exchange {
    /// Force by (19) as printed: the sum of its parts (N).
    pub fn literal(&self) -> Vector3<f64> {
        self.convective + self.pressure + self.viscous
    }

    fn vectors(&mut self) -> [&mut Vector3<f64>; PARTS / 3] {
        [
            &mut self.momentum,
            &mut self.momentum_torque,
            &mut self.convective,
            &mut self.pressure,
            &mut self.viscous,
            &mut self.literal_torque,
        ]
    }
}

/// A part of (19).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// `-rho u.grad u`.
    Convective,
    /// `-grad p`.
    Pressure,
    /// `div tau`.
    Viscous,
}

/// Particles in a fluid by the paper's mixing.
pub struct Coupling<const D: usize> {
    bodies: Vec<Body>,
    overlaps: Vec<Vec<Overlap>>,
    rule: fraction::Rule,
    fluid_density: f64,
    fluid_viscosity: f64,
    exchange: Vec<Exchange>,
    /// Per overlap, what the mixing adds to the velocity (m/s): found for all before any is added.
    kicks: Vec<Vec<Vector3<f64>>>,
    periods: [Option<f64>; 3],
    buffer: Vec<f64>,
    session: Session,
}

impl<const D: usize> Coupling<D> {
    /// Bodies in a fluid of the given density (kg/m3) and viscosity (Pa s).
    pub fn new(
        session: &Session,
        grid: &Grid<D>,
        bodies: Vec<Body>,
        rule: fraction::Rule,
        fluid_density: f64,
        fluid_viscosity: f64,
    ) -> Coupling<D> {
        let room: Vec<usize> = bodies.iter().map(|b| fraction::most_cells(grid, b.radius)).collect();
        let mut coupling = Coupling {
            overlaps: room.iter().map(|&n| Vec::with_capacity(n)).collect(),
            kicks: room.iter().map(|&n| Vec::with_capacity(n)).collect(),
            exchange: vec![Exchange::default(); bodies.len()],
            buffer: vec![0.0; bodies.len() * PARTS],
            periods: std::array::from_fn(|a| (a < D && grid.periodic[a]).then(|| grid.size[a])),
            bodies,
            rule,
            fluid_density,
            fluid_viscosity,
            session: session.clone(),
        };
        coupling.find_overlaps(grid, |_| true);
        coupling
    }

    /// The bodies, in the case's order.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// What each body exchanged with the fluid in the last step.
    pub fn exchange(&self) -> &[Exchange] {
        &self.exchange
    }

    /// The cells of this rank that each body touches.
    pub fn overlaps(&self) -> &[Vec<Overlap>] {
        &self.overlaps
    }

    /// Density of the fluid (kg/m3).
    pub fn fluid_density(&self) -> f64 {
        self.fluid_density
    }

    /// Viscosity of the fluid (Pa s).
    pub fn fluid_viscosity(&self) -> f64 {
        self.fluid_viscosity
    }

    /// Whether any body changes place.
    pub fn moves(&self) -> bool {
        self.bodies.iter().any(Body::moves)
    }

    /// Moves the prescribed bodies on by `dt` (s) and finds what they touch there.
    ///
    /// # Errors
    /// When one of them reaches another body or the border of the box.
    pub fn advance(&mut self, grid: &Grid<D>, dt: f64) -> Result<()> {
        for body in self.bodies.iter_mut().filter(|b| b.motion == Motion::Prescribed) {
            body.advance(dt, &self.periods);
        }
        self.find_overlaps(grid, Body::moves);
        self.bodies.iter().enumerate().filter(|(_, b)| b.moves()).try_for_each(|(k, _)| self.refuse_meeting(grid, k))
    }

    /// Puts the bodies where `bodies` are (the same ones, at another time).
    pub fn place(&mut self, grid: &Grid<D>, bodies: &[Body]) {
        self.bodies.clone_from_slice(bodies);
        self.find_overlaps(grid, |_| true);
    }

    fn find_overlaps(&mut self, grid: &Grid<D>, wanted: fn(&Body) -> bool) {
        for (body, overlaps) in self.bodies.iter().zip(&mut self.overlaps).filter(|(b, _)| wanted(b)) {
            fraction::overlaps(grid, &body.centre, body.radius, self.rule, overlaps);
        }
    }

    /// A cell holds no more solid than its volume, and a wall is where the box ends.
    fn refuse_meeting(&self, grid: &Grid<D>, mover: usize) -> Result<()> {
        let body = &self.bodies[mover];
        for (a, axis) in ["x", "y", "z"].into_iter().enumerate().take(D).filter(|(a, _)| !grid.periodic[*a]) {
            let inside = body.radius * (1.0 - 1e-9)..=grid.size[a] - body.radius * (1.0 - 1e-9);
            if !inside.contains(&body.centre[a]) {
                return Err(Error::Run(format!(
                    "particle {mover}, moving as prescribed, has reached the border of the box along {axis} (its centre \
                     is at {:.6} m); end the run before, or change its motion",
                    body.centre[a]
                )));
            }
        }
        for (k, other) in self.bodies.iter().enumerate().filter(|(k, _)| *k != mover) {
            let apart = nearest_image(&body.centre, &other.centre, &self.periods);
            let reach = (body.radius + other.radius) * (1.0 - 1e-9);
            if apart.norm_squared() < reach * reach {
                return Err(Error::Run(format!(
                    "particle {mover}, moving as prescribed, has run into particle {k} (their centres are {:.6} m apart); \
                     end the run before, or change its motion",
                    apart.norm()
                )));
            }
        }
        Ok(())
    }

    /// Eq. (1): density and viscosity of the mixture; only fields are written, with their ghosts. Collective.
    pub fn mix_properties(
        &self,
        boundaries: &mut Boundaries<D>,
        density: &mut Coefficient,
        viscosity: &mut Coefficient,
    ) -> Result<()> {
        self.mix(boundaries, density, self.fluid_density, |b| b.density)?;
        self.mix(boundaries, viscosity, self.fluid_viscosity, |b| b.viscosity)
    }

    fn mix(
        &self,
        boundaries: &mut Boundaries<D>,
        property: &mut Coefficient,
        of_fluid: f64,
        of_body: impl Fn(&Body) -> f64,
    ) -> Result<()> {
        let Coefficient::Field(field) = property else { return Ok(()) };
        field.fill(of_fluid);
        for (body, overlaps) in self.bodies.iter().zip(&self.overlaps) {
            for o in overlaps {
                field[o.cell] += o.fraction * (of_body(body) - of_fluid);
            }
        }
        boundaries.fill_property(field)
    }

    /// `1/rho` on faces, for predictor, pressure equation and correction alike.
    pub fn face_coefficient(&self, grid: &Grid<D>, density: &Coefficient, beta: &mut FaceCoefficient<D>) {
        beta.update(grid, density);
    }

    /// Starts the step's sums of forces.
    pub fn start_tally(&mut self) {
        self.exchange.fill(Exchange::default());
    }

    /// Adds `sign` times the force of a field of accelerations (m/s2) on the cells to a part of (19): called before
    /// with -1 and after with 1, it books what a term added.
    pub fn tally(&mut self, grid: &Grid<D>, part: Part, sign: f64, density: &Coefficient, rate: &VectorField<D>) {
        let volume = sign * grid.cell_volume();
        for (overlaps, exchange) in self.overlaps.iter().zip(&mut self.exchange) {
            let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
            for o in overlaps {
                let df = (volume * o.fraction * density.at(o.cell)) * vector(rate, o.cell);
                force += df;
                torque += o.arm.cross(&df);
            }
            match part {
                Part::Convective => exchange.convective += force,
                Part::Pressure => exchange.pressure += force,
                Part::Viscous => exchange.viscous += force,
            }
            exchange.literal_torque += torque;
        }
    }

    /// Adds the pressure part of (19) from the accelerations on faces (m/s2), averaged to cells as (16) does.
    pub fn tally_pressure(&mut self, grid: &Grid<D>, density: &Coefficient, acceleration: &VectorField<D>) {
        for (overlaps, exchange) in self.overlaps.iter().zip(&mut self.exchange) {
            for o in overlaps {
                let mut a = Vector3::zeros();
                for axis in 0..D {
                    let face = &acceleration[axis];
                    a[axis] = 0.5 * (face[o.cell] + face[o.cell + grid.stride[axis]]);
                }
                let df = (grid.cell_volume() * o.fraction * density.at(o.cell)) * a;
                exchange.pressure += df;
                exchange.literal_torque += o.arm.cross(&df);
            }
        }
    }

    /// Eq. (27): mixes the bodies' rigid motion into the cells they touch, and books what that removes over `dt` (s).
    pub fn impose(&mut self, grid: &Grid<D>, density: &Coefficient, dt: f64, u: &mut VectorField<D>) {
        let per_time = grid.cell_volume() / dt;
        let bodies = self.bodies.iter().zip(&self.overlaps).zip(&mut self.kicks).zip(&mut self.exchange);
        for (((body, overlaps), kicks), exchange) in bodies {
            kicks.clear();
            for o in overlaps {
                let kick = o.fraction * (body.velocity_at(&o.arm) - vector(u, o.cell));
                let df = -(per_time * density.at(o.cell)) * kick;
                exchange.momentum += df;
                exchange.momentum_torque += o.arm.cross(&df);
                kicks.push(kick);
            }
        }
        for (overlaps, kicks) in self.overlaps.iter().zip(&self.kicks) {
            for (o, kick) in overlaps.iter().zip(kicks) {
                for axis in 0..D {
                    u[axis][o.cell] += kick[axis];
                }
            }
        }
    }

    /// Sums the step's forces over the ranks. Collective.
    pub fn finish_tally(&mut self) -> Result<()> {
        let rows = self.buffer.chunks_exact_mut(PARTS);
        for (row, exchange) in rows.zip(&mut self.exchange) {
            for (slot, v) in row.chunks_exact_mut(3).zip(exchange.vectors()) {
                slot.copy_from_slice(v.as_slice());
            }
        }
        self.session.sum(&mut self.buffer)?;
        let rows = self.buffer.chunks_exact(PARTS);
        for (row, exchange) in rows.zip(&mut self.exchange) {
            for (slot, v) in row.chunks_exact(3).zip(exchange.vectors()) {
                v.copy_from_slice(slot);
            }
        }
        Ok(())
    }
}

fn vector<const D: usize>(field: &VectorField<D>, cell: usize) -> Vector3<f64> {
    Vector3::from_fn(|a, _| if a < D { field[a][cell] } else { 0.0 })
}
