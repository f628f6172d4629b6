//! The paper's method as printed: the mixture's properties (1), the wall (27), and the force on
//! each particle (19), all from one list of overlaps; formulas first, then the step.
//!
//! ```text
//!   rho = rho_f + sum_k alpha_k (rho_k - rho_f)                         (1), viscosity alike
//!   F_k = sum_c alpha_k dV rho_k [ -u.grad u - grad p_f/rho + div tau/rho ]            (19)
//!   T_k = sum_c r x (the summand), in the cells that the body's boundary cuts
//!   m dV/dt = F + (m - m_f) g + contacts,   I domega/dt = T + contacts              (17, 18)
//!   u   = u_f + sum_k alpha_k (v_k - u_f)                              (27), in every touched cell
//!         v_k = V_k, and V_k + omega_k x r where the boundary cuts the cell
//!   p   = p_f + sum_k alpha_k (mean of p in k - p_f)                   (28, 29)
//! ```
//! The force by which (27) acts on the fluid, `sum_c rho alpha_k (u_f - v_k) dV/dt`, is another
//! measure of the force on the particle, and moves nothing. The method does not conserve the
//! momentum of fluid and particles together: `docs/method.md` has its faults.

mod force;
mod impose;
mod motion;
mod properties;

use super::flow::{Flow, NoBodies};
use super::momentum::{Hears, MixtureProperties};
use super::prediction::{Prediction, Walls, Within};
use super::{Method, MethodKind};
use crate::Result;
use crate::clock::Stage;
use crate::contact::Contacts;
use crate::domain::Domain;
use crate::drive::Drive;
use crate::geometry::{Overlap, fraction};
use crate::grid::{Coefficient, Grid, VectorField};
use crate::kernels::faces::FaceCoefficient;
use crate::method::vector;
use crate::particles::{Accelerations, Body, nearest_image};
use crate::petsc::LogStage;
use crate::poisson::pressure::Projected;
use crate::reach::BodyRanks;
use crate::scheme::Scheme;
use crate::state::{Exchange, State};
use crate::sums::{BodySums, Messages};
use nalgebra::Vector3;

/// The method of the paper.
pub struct MixtureMethod<const D: usize> {
    flow: Flow<D>,
    /// The law of contacts, where the case has one and a particle is free.
    contacts: Option<Contacts>,
    /// Per body, the cells of this rank that it touches.
    overlaps: Vec<Vec<Overlap>>,
    /// Scratch of what a body fills.
    planes: [Vec<f64>; 3],
    /// Per overlap, the change of the velocity by (27) (m/s): found for all before any is added.
    velocity_changes: Vec<Vec<Vector3<f64>>>,
    departures: Vec<motion::Departure>,
    accelerations: Vec<Accelerations>,
    sums: Sums,
    /// Which bodies reach which ranks, and where they lay when that was found last.
    reach: BodyRanks,
    places: Vec<Vector3<f64>>,
}

/// The sides of the box, and the observer of the terms of (7).
struct Heard<'a, const D: usize> {
    hears: Hears<'a, D>,
}

impl<const D: usize> Walls<D> for Heard<'_, D> {
    const PRESSURE: f64 = <NoBodies as Walls<D>>::PRESSURE;

    fn finish(
        &mut self,
        domain: &mut Domain<D>,
        s: &State<D>,
        within: Within,
        dt: f64,
        u: &mut VectorField<D>,
    ) -> Result<()> {
        NoBodies.finish(domain, s, within, dt, u)
    }

    fn hears(&mut self) -> Option<Hears<'_, D>> {
        Some(&mut *self.hears)
    }
}

/// Sums over the ranks for each body, and the scratch of their messages.
struct Sums {
    pushes: BodySums<motion::Push>,
    pressures: BodySums<impose::MeanPressure>,
    exchanged: BodySums<Exchange>,
    messages: Messages,
}

impl<const D: usize> Method<D> for MixtureMethod<D> {
    fn kind(&self) -> MethodKind {
        MethodKind::Mixture
    }

    fn step(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<Projected> {
        // (7) u* without pressure, with the first two parts of (19)
        self.predict_cells(domain, s, dt)?;
        // (8) U = mean of u* - dt/rho dp^n/dn
        self.flow.predict_faces(domain, s, dt)?;
        // (13-15) C-HSMAC: |D| < D0
        let projected = self.flow.project(domain, s, dt)?;
        // (16) u_f = u* - dt/rho grad p
        self.flow.correct_cells(domain, s, dt)?;
        // (19) the last of its three parts
        self.sum_pressure_force(domain, s);
        // (17, 18, 20-26) to the new place, through contacts
        self.move_particles(domain, s, dt)?;
        // (1) there, for the mixing and the next step
        self.mix_properties(domain, s)?;
        // (27) the wall
        self.mix_velocity(domain, s, dt)?;
        // (28, 29)
        self.mix_pressure(domain, s)?;
        s.count(dt);
        Ok(projected)
    }

    fn start(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        s.touching =
            self.contacts.as_ref().map_or_else(Default::default, |contacts| contacts.untouched());
        self.find_overlaps(domain, s, |_| true);
        self.mix_fields(domain, s)?;
        self.impose(domain, s, 1.0);
        self.flow.start_velocity(domain, s)?;
        self.impose(domain, s, 1.0);
        s.exchange.fill(Exchange::default());
        domain.boundaries.fill_velocity(&mut s.u)
    }

    fn resume(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        _: Option<Box<dyn Method<D>>>,
    ) -> Result<()> {
        if let Some(contacts) = &self.contacts {
            contacts.setup().check(&s.touching)?;
        }
        self.find_overlaps(domain, s, |_| true);
        self.mix_fields(domain, s)?;
        self.flow.resume(domain, s, None)
    }

    fn find_acceleration(&mut self, domain: &Domain<D>, s: &State<D>) {
        self.flow.find_acceleration(domain, s);
    }

    fn mixture(&self) -> &MixtureProperties {
        &self.flow.mixture
    }

    fn beta(&self) -> &FaceCoefficient<D> {
        &self.flow.beta
    }

    fn scheme(&self) -> Scheme {
        self.flow.scheme()
    }

    fn place(&mut self, domain: &Domain<D>, s: &State<D>) {
        self.find_overlaps(domain, s, |_| true);
    }

    fn contacts(&self) -> Option<&Contacts> {
        self.contacts.as_ref()
    }

    fn contacts_mut(&mut self) -> Option<&mut Contacts> {
        self.contacts.as_mut()
    }

    fn overlaps_of(&self, k: usize) -> Option<&[Overlap]> {
        self.overlaps.get(k).map(Vec::as_slice)
    }

    fn impose_inserted(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        ids: &[usize],
    ) -> Result<()> {
        let all = s.bodies.iter().zip(&self.overlaps);
        for (body, overlaps) in all.filter(|(body, _)| ids.contains(&body.id)) {
            for o in overlaps {
                let share = o.fraction * body.density / self.flow.mixture.density.at(o.cell);
                let change =
                    share * (body.velocity + body.spin.cross(&o.arm) - vector(&s.u, o.cell));
                s.u.iter_mut().enumerate().for_each(|(axis, u)| u[o.cell] += change[axis]);
            }
        }
        domain.boundaries.fill_velocity(&mut s.u)
    }
}

impl<const D: usize> MixtureMethod<D> {
    /// The method for bodies whose mixture with the fluid has the terms `momentum` of (7).
    /// [`Method::start`] or [`Method::resume`] comes next.
    pub fn new(
        domain: &Domain<D>,
        bodies: &[Body],
        mixture: MixtureProperties,
        prediction: Prediction<D>,
        contacts: Option<Contacts>,
    ) -> MixtureMethod<D> {
        let grid = &domain.grid;
        // A body touches few of several ranks: there it takes room as it comes.
        let alone = grid.local == grid.cells;
        let room = |b: &Body| if alone { fraction::most_cells(grid, b.radius()) } else { 0 };
        let room: Vec<usize> = bodies.iter().map(room).collect();
        let mut flow = Flow::new(domain, mixture, prediction, true);
        flow.solid = matches!(domain.drive, Some(Drive::Fluid(_))).then(|| grid.field());
        MixtureMethod {
            flow,
            contacts,
            planes: std::array::from_fn(|_| Vec::new()),
            overlaps: room.iter().map(|&n| Vec::with_capacity(n)).collect(),
            velocity_changes: room.iter().map(|&n| Vec::with_capacity(n)).collect(),
            departures: vec![motion::Departure::default(); bodies.len()],
            accelerations: vec![Accelerations::default(); bodies.len()],
            sums: Sums {
                pushes: BodySums::with_capacity(bodies.len()),
                pressures: BodySums::with_capacity(bodies.len()),
                exchanged: BodySums::with_capacity(bodies.len()),
                messages: Messages::default(),
            },
            reach: BodyRanks::new(domain.session.rank(), domain.session.size(), bodies.len()),
            places: bodies.iter().map(|b| b.centre).collect(),
        }
    }

    /// Finds the cells that the bodies touch, for readers of the results.
    pub fn find_overlaps(&mut self, domain: &Domain<D>, s: &State<D>, wanted: fn(&Body) -> bool) {
        self.find_reach(domain, &s.bodies);
        let bodies = s.bodies.iter().zip(&mut self.overlaps);
        for (body, overlaps) in bodies.filter(|(body, _)| wanted(body)) {
            let rule = fraction::Rule::Polygon;
            fraction::overlaps(&domain.grid, &body.placed(), rule, &mut self.planes, overlaps);
        }
    }

    /// Finds which bodies reach which ranks: where they lie, and where they lay before, since what
    /// they exchange in a step is of both.
    fn find_reach(&mut self, domain: &Domain<D>, bodies: &[Body]) {
        let periods = domain.periods();
        let places = &mut self.places;
        let spacing = domain.grid.h.iter().copied().fold(0.0, f64::max);
        self.reach.find(&domain.grid, bodies, |k| {
            let way = nearest_image(&places[k], &bodies[k].centre, &periods).norm();
            Vector3::repeat(bodies[k].radius() + way + spacing)
        });
        places.iter_mut().zip(bodies).for_each(|(place, body)| *place = body.centre);
    }

    /// (1). Where nothing has moved, nothing changes. Collective.
    fn mix_properties(&mut self, domain: &mut Domain<D>, s: &State<D>) -> Result<()> {
        let _logged = domain.session.log(LogStage::Bodies)?;
        if !s.bodies.iter().any(Body::moves) {
            return Ok(());
        }
        self.mix_fields(domain, s)?;
        if let Coefficient::Field(_) = self.flow.mixture.density {
            domain.projection.assemble(&domain.grid, &self.flow.beta)?;
            domain.clock.lap(Stage::Assembly);
        }
        if matches!(self.flow.mixture.density, Coefficient::Field(_)) || self.flow.solid.is_some() {
            self.flow.find_acceleration(domain, s);
        }
        Ok(())
    }

    /// (7), with the first two parts of (19). Collective.
    fn predict_cells(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<()> {
        let bodies = std::mem::take(&mut s.bodies);
        let mut exchange = std::mem::take(&mut s.exchange);
        exchange.fill(Exchange::default());
        let overlaps = &self.overlaps;
        let mut exchanged = |grid: &Grid<D>, term, sign, rate: &_| {
            force::add_force(grid, &bodies, overlaps, term, sign, rate, &mut exchange);
        };
        let mut walls = Heard { hears: &mut exchanged };
        let predicted = self.flow.predict_cells(domain, s, dt, &mut walls);
        s.bodies = bodies;
        s.exchange = exchange;
        predicted
    }

    /// Moves the bodies: fixed ones stay, and the fractions of those that only turn. Collective.
    fn move_particles(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<()> {
        let _logged = domain.session.log(LogStage::Bodies)?;
        self.depart(domain, s)?;
        domain.clock.lap(Stage::Particles);
        s.substeps = self.advance(domain, s, dt)?;
        self.settle(s, dt);
        domain.clock.lap(Stage::Contacts);
        Ok(())
    }

    /// (27). Collective.
    fn mix_velocity(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<()> {
        let _logged = domain.session.log(LogStage::Bodies)?;
        self.impose(domain, s, dt);
        self.sum_exchange(domain, s)?;
        domain.clock.lap(Stage::Mixing);
        Ok(())
    }

    /// (28, 29). Collective.
    fn mix_pressure(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        self.flatten_pressure(domain, s)?;
        domain.boundaries.fill_pressure(&mut s.p)?;
        self.flow.find_acceleration(domain, s);
        domain.clock.lap(Stage::Mixing);
        Ok(())
    }
}
