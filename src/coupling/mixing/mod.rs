//! The paper's coupling: the mixture's properties (1), the wall (27), and the force on each particle (19), all from one
//! list of overlaps.
//!
//! ```text
//!   rho = rho_f + sum_k alpha_k (rho_k - rho_f)                         (1), viscosity alike
//!   u   = u_f + sum_k alpha_k (v_k - u_f),  v_k = V_k + omega_k x r     (27), in every touched cell
//!   F_k = sum_c rho alpha_k (u_f - v_k) dV/dt + m_k dV_k/dt             the momentum that (27) removes, and what a
//!                                                                       held body takes up of it as prescribed
//!   F_k = sum_c alpha_k dV sigma_k [ -u.grad u - grad p_f/rho + div tau/rho ]   (19) as printed, its three parts, with
//!                                                                       sigma_k the body's density, rho the mixture's
//!   T_k = sum_c r x (the summand), in the cells that the body's boundary cuts    the moment of (18) as printed
//! ```
//! What the mixing takes from the mixture, the particle gets: in the momentum of everything in the box,
//! `sum_c rho u dV`, pressure and stress only pass it on between cells, so that a free particle's rigid motion
//! `v* = V* + omega* x r` follows from
//!
//! ```text
//!   sum rho' alpha' (v* - u_f) dV + b = 0,    b = (rho_k - rho_f) [ sum (alpha' - alpha) u_f - dt sum alpha div(U u) ] dV
//! ```
//! at its new place ('), and likewise from the angular momentum about its centre: the particle moves as the mixture inside
//! it does, and `b` is what the fields carry of its excess mass on their own account. No ratio of densities stands in a
//! denominator. Contacts add their impulse J after that, by shares of mass, `u += sum_k (alpha rho_k/rho) J/m`: the same
//! impulse in the cells and in the particle.

mod flight;
mod rigid;
mod state;

use super::{Exchange, vector};
use crate::Result;
use crate::fluid::faces::{self, FaceCoefficient, Gravity};
use crate::geometry::{Overlap, fraction};
use crate::grid::{Boundaries, Coefficient, Grid, VectorField};
use crate::petsc::Session;
use crate::solids::Body;
use crate::solids::contact::{Contacts, Push};
use nalgebra::Vector3;

/// A part of (19) that is summed as the fluid's terms are; [`Mixing::tally_pressure`] adds that of the pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// `-u.grad u`.
    Convective,
    /// `div tau/rho`.
    Viscous,
}

/// What moves a free particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Driver {
    /// The momentum that the mixing takes from the fluid.
    #[default]
    Momentum,
    /// Eq. (19) as printed.
    Literal,
}

/// How particles are coupled.
#[derive(Clone, Copy, Debug)]
pub struct Choices {
    /// How fractions are found.
    pub fraction: fraction::Rule,
    /// What moves free particles.
    pub driver: Driver,
    /// Whether the rotation in (27) acts in boundary cells only, as printed.
    pub rotation_at_boundary: bool,
    /// Gravity (m/s2) that acts on the mixture, by reduced gravity on faces.
    pub field_gravity: Vector3<f64>,
    /// Gravity (m/s2) that acts on particles alone, less their buoyancy: (17) as printed.
    pub own_gravity: Vector3<f64>,
}

/// Particles in a fluid by the paper's mixing.
pub struct Mixing<const D: usize> {
    bodies: Vec<Body>,
    overlaps: Vec<Vec<Overlap>>,
    choices: Choices,
    fluid_density: f64,
    fluid_viscosity: f64,
    exchange: Vec<Exchange>,
    /// Per overlap, what the mixing adds to the velocity (m/s): found for all before any is added.
    kicks: Vec<Vec<Vector3<f64>>>,
    /// The law of contacts, where the case has one and a particle is free.
    contacts: Option<Contacts>,
    departures: Vec<flight::Departure>,
    push: Vec<Push>,
    /// Velocity and spin of the free particles before contacts (m/s, rad/s).
    settled: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// The rigid motion (m/s, rad/s) whose shares of mass carry the impulse of contacts.
    struck: Vec<(Vector3<f64>, Vector3<f64>)>,
    periods: [Option<f64>; 3],
    buffer: Vec<f64>,
    session: Session,
}

impl<const D: usize> Mixing<D> {
    /// Bodies in a fluid of the given density (kg/m3) and viscosity (Pa s).
    pub fn new(
        session: &Session,
        grid: &Grid<D>,
        bodies: Vec<Body>,
        contacts: Option<Contacts>,
        choices: Choices,
        fluid_density: f64,
        fluid_viscosity: f64,
    ) -> Mixing<D> {
        let none = (Vector3::zeros(), Vector3::zeros());
        let room: Vec<usize> = bodies.iter().map(|b| fraction::most_cells(grid, b.radius())).collect();
        let mut coupling = Mixing {
            overlaps: room.iter().map(|&n| Vec::with_capacity(n)).collect(),
            kicks: room.iter().map(|&n| Vec::with_capacity(n)).collect(),
            exchange: vec![Exchange::default(); bodies.len()],
            departures: vec![flight::Departure::default(); bodies.len()],
            push: vec![Push::default(); bodies.len()],
            settled: bodies.iter().map(|b| (b.velocity, b.spin)).collect(),
            struck: vec![none; bodies.len()],
            contacts,
            buffer: vec![0.0; bodies.len() * Exchange::NUMBERS.max(flight::NUMBERS)],
            periods: std::array::from_fn(|a| (a < D && grid.periodic[a]).then(|| grid.size[a])),
            bodies,
            choices,
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

    /// The law of contacts, where there is one.
    pub fn contacts(&self) -> Option<&Contacts> {
        self.contacts.as_ref()
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

    /// Puts the bodies where `bodies` are (the same ones, at another time).
    pub fn place(&mut self, grid: &Grid<D>, bodies: &[Body]) {
        self.bodies.clone_from_slice(bodies);
        self.find_overlaps(grid, |_| true);
    }

    fn find_overlaps(&mut self, grid: &Grid<D>, wanted: fn(&Body) -> bool) {
        for (body, overlaps) in self.bodies.iter().zip(&mut self.overlaps).filter(|(b, _)| wanted(b)) {
            fraction::overlaps(grid, &body.placed(), self.choices.fraction, overlaps);
        }
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
        // Where bodies in contact overlap, a cell holds more than its volume of what is less than the fluid.
        let least = self.bodies.iter().map(&of_body).fold(of_fluid, f64::min);
        for o in self.overlaps.iter().flatten() {
            field[o.cell] = field[o.cell].max(least);
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
    pub fn tally(&mut self, grid: &Grid<D>, part: Part, sign: f64, rate: &VectorField<D>) {
        let volume = sign * grid.cell_volume();
        for ((body, overlaps), exchange) in self.bodies.iter().zip(&self.overlaps).zip(&mut self.exchange) {
            let (mut flux, mut swirl, mut swirl_at_boundary) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
            for o in overlaps {
                let a = (volume * o.fraction) * vector(rate, o.cell);
                let turn = o.arm.cross(&a);
                flux += a;
                swirl += turn;
                if o.is_cut() {
                    swirl_at_boundary += turn;
                }
            }
            match part {
                Part::Convective => {
                    let excess = body.density - self.fluid_density;
                    exchange.convective += body.density * flux;
                    exchange.carried += excess * flux;
                    exchange.carried_torque += excess * swirl;
                }
                Part::Viscous => exchange.viscous += body.density * flux,
            }
            exchange.literal_torque += body.density * swirl_at_boundary;
        }
    }

    /// Adds the pressure part of (19), the gradient taken at cells as (16) takes it: by the mean of the accelerations on a
    /// cell's faces (m/s2), less gravity, which they contain, or from `cell_pressure` (Pa, its ghosts filled) where that is
    /// given.
    pub fn tally_pressure(
        &mut self,
        grid: &Grid<D>,
        density: &Coefficient,
        beta: &FaceCoefficient<D>,
        gravity: Option<&Gravity<D>>,
        acceleration: &VectorField<D>,
        cell_pressure: Option<&[f64]>,
    ) {
        let volume = grid.cell_volume();
        for ((body, overlaps), exchange) in self.bodies.iter().zip(&self.overlaps).zip(&mut self.exchange) {
            for o in overlaps {
                let a = Vector3::from_fn(|axis, _| match cell_pressure {
                    _ if axis >= D => 0.0,
                    Some(p) => faces::cell_gradient(grid, axis, o.cell, p) / -density.at(o.cell),
                    None => {
                        let own = |f: usize| acceleration[axis][f] - gravity.map_or(0.0, |g| g.at(grid, beta, axis, f));
                        0.5 * (own(o.cell) + own(o.cell + grid.stride[axis]))
                    }
                });
                let df = (volume * o.fraction * body.density) * a;
                exchange.pressure += df;
                if o.is_cut() {
                    exchange.literal_torque += o.arm.cross(&df);
                }
            }
        }
    }

    /// Eq. (27): mixes the bodies' rigid motion into the cells they touch, and books what that removes over `dt` (s) from
    /// the fluid around held bodies; [`Mixing::settle`] books that of free ones.
    pub fn impose(&mut self, grid: &Grid<D>, density: &Coefficient, dt: f64, u: &mut VectorField<D>) {
        let volume = grid.cell_volume();
        let per_time = volume / dt;
        let lead = self.session.rank() == 0;
        for (k, body) in self.bodies.iter().enumerate() {
            let (kicks, exchange) = (&mut self.kicks[k], &mut self.exchange[k]);
            let freedom = body.freedom();
            // Along free directions the momentum is booked already: it is what the particle settled by.
            let settled = freedom.filter(|_| self.choices.driver == Driver::Momentum);
            // What contacts change follows by shares of mass; as printed, (27) mixes the final motion in.
            let (v, w) = if settled.is_some() { self.settled[k] } else { (body.velocity, body.spin) };
            let (struck_v, struck_w) = self.struck[k];
            kicks.clear();
            if freedom.is_none() && lead {
                exchange.driven = body.mass() * (body.velocity - self.departures[k].velocity) / dt;
                exchange.momentum += exchange.driven;
            }
            for o in &self.overlaps[k] {
                let rho = density.at(o.cell);
                let turns = !self.choices.rotation_at_boundary || o.is_cut();
                let rigid = if turns { v + w.cross(&o.arm) } else { v };
                let kick = o.fraction * (rigid - vector(u, o.cell));
                let df = -(per_time * rho) * kick;
                let turn = o.arm.cross(&df);
                exchange.momentum += settled.map_or(df, |f| df - f.along(&df));
                exchange.momentum_torque += settled.map_or(turn, |f| turn - f.about(&turn));
                let kick = kick + (o.fraction * body.density / rho) * (struck_v + struck_w.cross(&o.arm));
                exchange.spun += (volume * rho) * o.arm.cross(&kick);
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

    /// Gravity (m/s2), wherever it acts.
    pub fn gravity(&self) -> Vector3<f64> {
        self.choices.field_gravity + self.choices.own_gravity
    }

    /// Force of gravity less buoyancy on the free particles, as far as it acts on the mixture (N).
    pub fn weight(&self) -> Vector3<f64> {
        let weight = |b: &Body| {
            let excess = (b.density - self.fluid_density) * b.volume();
            Some(excess * b.freedom()?.along(&self.choices.field_gravity))
        };
        self.bodies.iter().filter_map(weight).sum()
    }

    /// What the fields carried of the particles' excess mass in the last step, per time (N).
    pub fn carried(&self) -> Vector3<f64> {
        self.exchange.iter().map(|e| e.carried).sum()
    }

    /// Impulse of contacts on the free particles in the last step (N s): pairs of them cancel.
    pub fn impulse(&self) -> Vector3<f64> {
        let Some(contacts) = &self.contacts else { return Vector3::zeros() };
        let bodies = self.bodies.iter().zip(contacts.impulses());
        bodies.filter_map(|(b, i)| Some(b.freedom()?.along(&i.linear))).sum()
    }

    /// Density above the fluid's (kg/m3) of what is free to fall along each axis that gravity has, with ghosts.
    /// Collective.
    pub fn mix_excess(&self, boundaries: &mut Boundaries<D>, gravity: &mut Gravity<D>) -> Result<()> {
        for (axis, excess) in gravity.excess.iter_mut().enumerate().filter(|(_, e)| !e.is_empty()) {
            excess.fill(0.0);
            let falls = |b: &Body| b.freedom().is_some_and(|f| f.translation[axis]);
            for (body, overlaps) in self.bodies.iter().zip(&self.overlaps).filter(|(b, _)| falls(b)) {
                for o in overlaps {
                    excess[o.cell] += o.fraction * (body.density - self.fluid_density);
                }
            }
            boundaries.fill_property(excess)?;
        }
        Ok(())
    }

    /// Eq. (28, 29): mixes each body's mean pressure into the cells it touches, `p += sum_k alpha_k (p_k - p)` with
    /// `p_k = sum alpha p / sum alpha`. Collective.
    pub fn flatten_pressure(&mut self, p: &mut [f64]) -> Result<()> {
        let sums = &mut self.buffer[..2 * self.bodies.len()];
        for (overlaps, sum) in self.overlaps.iter().zip(sums.chunks_exact_mut(2)) {
            sum[0] = overlaps.iter().map(|o| o.fraction * p[o.cell]).sum();
            sum[1] = overlaps.iter().map(|o| o.fraction).sum();
        }
        self.session.sum(sums)?;
        for ((overlaps, kicks), sum) in self.overlaps.iter().zip(&mut self.kicks).zip(sums.chunks_exact(2)) {
            kicks.clear();
            kicks.extend(overlaps.iter().map(|o| Vector3::x() * (o.fraction * (sum[0] / sum[1] - p[o.cell]))));
        }
        for (overlaps, kicks) in self.overlaps.iter().zip(&self.kicks) {
            overlaps.iter().zip(kicks).for_each(|(o, kick)| p[o.cell] += kick.x);
        }
        Ok(())
    }

    /// Sums the step's forces over the ranks. Collective.
    pub fn finish_tally(&mut self) -> Result<()> {
        let rows = self.buffer.chunks_exact_mut(Exchange::NUMBERS);
        for (row, exchange) in rows.zip(&mut self.exchange) {
            for (slot, v) in row.chunks_exact_mut(3).zip(exchange.vectors()) {
                slot.copy_from_slice(v.as_slice());
            }
        }
        self.session.sum(&mut self.buffer)?;
        let rows = self.buffer.chunks_exact(Exchange::NUMBERS);
        for (row, exchange) in rows.zip(&mut self.exchange) {
            for (slot, v) in row.chunks_exact(3).zip(exchange.vectors()) {
                v.copy_from_slice(slot);
            }
        }
        Ok(())
    }
}
