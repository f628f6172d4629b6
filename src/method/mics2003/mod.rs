//! The paper's method: the mixture's properties (1), the wall (27), and the force on each particle
//! (19), all from one list of overlaps; formulas first, then the step.
//!
//! ```text
//!   rho = rho_f + sum_k alpha_k (rho_k - rho_f)                         (1), viscosity alike
//!   u   = u_f + sum_k alpha_k (v_k - u_f),  v_k = V_k + omega_k x r    (27), in every touched cell
//!   F_k = sum_c rho alpha_k (u_f - v_k) dV/dt + m_k dV_k/dt
//!              the momentum that (27) removes, and what a
//!                                                                       held body takes up of it
//!                 as prescribed
//!   F_k = sum_c alpha_k dV sigma_k [ -u.grad u - grad p_f/rho + div tau/rho ]
//!              (19) as printed, its three parts, with
//!                                                                       sigma_k the body's
//!                 density, rho the mixture's
//!   T_k = sum_c r x (the summand), in the cells that the body's boundary cuts
//!              the moment of (18) as printed
//! ```
//! What the mixing takes from the mixture, the particle gets: in the momentum of everything in the
//! box, `sum_c rho u dV`, pressure and stress only pass it on between cells, so that a free
//! particle's rigid motion `v* = V* + omega* x r` follows from
//!
//! ```text
//!   sum rho' alpha' (v* - u_f) dV + b = 0,
//!              b = (rho_k - rho_f) [ sum (alpha' - alpha) u_f - dt sum alpha div(U u) ] dV
//! ```
//! at its new place ('), and likewise from the angular momentum about its centre: the particle
//! moves as the mixture inside it does, and `b` is what the fields carry of its excess mass on
//! their own account. No ratio of densities stands in a denominator. Contacts add their impulse J
//! after that, by shares of mass, `u += sum_k (alpha rho_k/rho) J/m`: the same impulse in the cells
//! and in the particle.
//!
//! What contacts gave a body in the last steps, as far as it lasts, acts in the next one as gravity
//! does, on the same faces (`R`, a force per volume by shares of mass), and only `J - R dt` is
//! added at its end:
//! ```text
//!   a_f = 2/(rho(c-1) + rho(c)) [ mean of sum_k alpha_k ( (rho_k - rho_f) g + rho_k R_k/m_k )
//!                 - dp/dn ]
//! ```
//! so that what lies still leaves the fluid still: gravity on faces against impulses in cells
//! drives a flow around a body at rest, which grows (a disc of 8 cells on a floor: 1 mm/s after
//! 0.01 s, and a spurious energy gain in steps of any length).

mod balance;
mod choices;
mod force;
mod impose;
mod initial_contacts;
mod motion;
mod properties;
mod rigid;

use super::flow::Flow;
use super::momentum::{Mixture, Momentum};
use super::{Kind, Method};
use crate::Result;
use crate::clock::Stage;
use crate::contact::Contacts;
use crate::domain::Domain;
use crate::drive::Drive;
use crate::geometry::{Overlap, Tiles, fraction};
use crate::grid::{Coefficient, Grid};
use crate::kernels::boundary::Sides;
use crate::kernels::faces::{BodyForce, FaceCoefficient};
use crate::method::vector;
use crate::particles::{Accelerations, Body, nearest_image};
use crate::petsc::LogStage;
use crate::poisson::pressure::Projected;
use crate::reach::Reach;
use crate::scheme::Scheme;
use crate::state::{Balance, Exchange, State, Support};
use crate::sums::{BodySums, Messages};
pub use choices::{Choices, Driver};
use nalgebra::Vector3;

/// The method of the paper.
pub struct Mics2003<const D: usize> {
    flow: Flow<D>,
    choices: Choices,
    /// The law of contacts, where the case has one and a particle is free.
    contacts: Option<Contacts>,
    /// Per body, the cells of this rank that it touches.
    overlaps: Vec<Vec<Overlap>>,
    /// Scratch of what a body fills.
    tiles: Tiles,
    /// Per overlap, what the mixing adds to the velocity (m/s): found for all before any is added.
    kicks: Vec<Vec<Vector3<f64>>>,
    departures: Vec<motion::Departure>,
    accelerations: Vec<Accelerations>,
    /// Velocity and spin of the free particles before contacts (m/s, rad/s).
    settled: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// The rigid motion (m/s, rad/s) whose shares of mass carry the impulse of contacts.
    struck: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// The same of weight and of what contacts are expected to give (m/s2, rad/s2).
    pulled: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// What ranks sum of each body: its cells, their mass, its mean pressure.
    cells: BodySums<motion::CellSums>,
    masses: BodySums<rigid::Moments>,
    pressures: BodySums<impose::MeanPressure>,
    exchanged: BodySums<Exchange>,
    messages: Messages,
    /// Which bodies reach which ranks, and where they lay when that was found last.
    reach: Reach,
    places: Vec<Vector3<f64>>,
}

impl<const D: usize> Method<D> for Mics2003<D> {
    fn kind(&self) -> Kind {
        Kind::Mixing
    }

    fn step(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<Projected> {
        if s.supports.iter().flatten().any(|support| support.mean_contact_force.0.is_none()) {
            self.find_initial_contacts(domain, s, dt)?;
        }
        self.advance_all(domain, s, dt)
    }

    fn start(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        s.touching =
            self.contacts.as_ref().map_or_else(Default::default, |contacts| contacts.untouched());
        s.balance = s.has_free_bodies().then(Balance::default);
        s.supports = None;
        self.begin_supports(s, |_| true);
        self.find_overlaps(domain, s, |_| true);
        self.mix_fields(domain, s)?;
        self.impose(domain, s, 1.0);
        self.flow.start_velocity(domain, s)?;
        self.impose(domain, s, 1.0);
        s.exchange.fill(Exchange::default());
        self.start_balance(domain, s)?;
        domain.boundaries.fill_velocity(&mut s.u)
    }

    fn resume(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        if let Some(contacts) = &self.contacts {
            contacts.check(&s.touching)?;
        }
        self.find_overlaps(domain, s, |_| true);
        self.mix_fields(domain, s)?;
        self.flow.resume(domain, s)
    }

    fn find_acceleration(&mut self, domain: &Domain<D>, s: &State<D>) {
        self.flow.find_acceleration(domain, s);
    }

    fn mixture(&self) -> &Mixture {
        &self.flow.mixture
    }

    fn beta(&self) -> &FaceCoefficient<D> {
        &self.flow.beta
    }

    fn scheme(&self) -> Scheme {
        self.flow.momentum.scheme
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

    fn start_balance(&self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        self.balance_from_now(domain, s)
    }

    fn mix_in(&mut self, domain: &mut Domain<D>, s: &mut State<D>, ids: &[usize]) -> Result<()> {
        let all = s.bodies.iter().zip(&self.overlaps);
        for (body, overlaps) in all.filter(|(body, _)| ids.contains(&body.id)) {
            for o in overlaps {
                let share = o.fraction * body.density / self.flow.mixture.density.at(o.cell);
                let kick = share * (body.velocity + body.spin.cross(&o.arm) - vector(&s.u, o.cell));
                s.u.iter_mut().enumerate().for_each(|(axis, u)| u[o.cell] += kick[axis]);
            }
        }
        domain.boundaries.fill_velocity(&mut s.u)
    }

    fn begin_bodies(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        ids: &[usize],
    ) -> Result<()> {
        if self.begin_supports(s, |body| ids.contains(&body.id)) {
            self.mix_fields(domain, s)
        } else {
            Ok(())
        }
    }
}

impl<const D: usize> Mics2003<D> {
    /// The method for bodies whose mixture with the fluid has the terms `momentum` of (7).
    /// [`Method::start`] or [`Method::resume`] comes next.
    pub fn new(
        domain: &Domain<D>,
        bodies: &[Body],
        mixture: Mixture,
        momentum: Momentum<D>,
        contacts: Option<Contacts>,
        choices: Choices,
    ) -> Mics2003<D> {
        let (grid, none) = (&domain.grid, (Vector3::zeros(), Vector3::zeros()));
        // Of several ranks a body touches few: there it takes room as it comes.
        let alone = grid.local == grid.cells;
        let room = |b: &Body| if alone { fraction::most_cells(grid, b.radius()) } else { 0 };
        let room: Vec<usize> = bodies.iter().map(room).collect();
        let falls = |b: &Body| b.freedom().is_some() && b.density != domain.fluid.density;
        let g = choices.field_gravity;
        let supports = choices.expects_contacts() && contacts.is_some();
        let force = (supports || g != Vector3::zeros() && bodies.iter().any(falls))
            .then(|| BodyForce { density: grid.vector_field() });
        let mut flow = Flow::new(domain, mixture, force, momentum, choices.cell_gradient);
        flow.solid = matches!(domain.drive, Some(Drive::Fluid(_))).then(|| grid.field());
        Mics2003 {
            flow,
            choices,
            contacts,
            tiles: Tiles::for_radius(bodies.iter().map(Body::radius).fold(0.0, f64::max), &grid.h),
            overlaps: room.iter().map(|&n| Vec::with_capacity(n)).collect(),
            kicks: room.iter().map(|&n| Vec::with_capacity(n)).collect(),
            departures: vec![motion::Departure::default(); bodies.len()],
            accelerations: vec![Accelerations::default(); bodies.len()],
            settled: bodies.iter().map(|b| (b.velocity, b.spin)).collect(),
            struck: vec![none; bodies.len()],
            pulled: vec![none; bodies.len()],
            cells: BodySums::with_capacity(bodies.len()),
            masses: BodySums::with_capacity(bodies.len()),
            pressures: BodySums::with_capacity(bodies.len()),
            exchanged: BodySums::with_capacity(bodies.len()),
            messages: Messages::default(),
            reach: Reach::new(domain.session.rank(), domain.session.size(), bodies.len()),
            places: bodies.iter().map(|b| b.centre).collect(),
        }
    }

    /// The step itself. Collective.
    fn advance_all(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<Projected> {
        let before = self.momentum(domain, s); //
        // (7) u* without pressure
        let sides = self.predict_cells(domain, s, dt)?;
        // (8) U = mean of u* - dt/rho dp^n/dn
        self.flow.predict_faces(domain, s, dt)?;
        // (13-15) C-HSMAC: |D| < D0
        let projected = self.flow.project(domain, s, dt)?;
        // (16) u_f = u* - dt/rho grad p
        self.flow.correct_cells(domain, s, dt)?;
        // (19) the last of its three parts
        self.sum_pressure_force(domain, s);
        let forces = (sides, self.pressure_of_sides(domain, s), self.drive_on_cells(domain, s));
        // (17, 18, 20-26) to the new place, through contacts
        self.move_particles(domain, s, dt)?;
        // (1) there, for the mixing and the next step
        self.mix_properties(domain, s)?;
        // (27) the wall; the momentum it takes is the force
        self.mix_velocity(domain, s, dt)?;
        // (28, 29) as printed, where the case asks for it
        self.mix_pressure(domain, s)?;
        self.close_balance(domain, s, before, forces, dt)?;
        s.count(dt);
        Ok(projected)
    }

    /// Lets what contacts are expected to give begin for `new` bodies, or for all where the state
    /// has none, and end where nothing is expected of them; whether that changes anything.
    fn begin_supports(&mut self, s: &mut State<D>, new: impl Fn(&Body) -> bool) -> bool {
        let Some(contacts) = self.contacts.as_mut().filter(|_| self.choices.expects_contacts())
        else {
            return s.supports.take().is_some();
        };
        let all = s.supports.is_none();
        if !all && !s.bodies.iter().any(&new) {
            return false;
        }
        contacts.meet(&s.bodies);
        let held = contacts.lying(&s.bodies);
        let supports = s.supports.get_or_insert_with(|| vec![Support::new(false); s.bodies.len()]);
        for ((support, body), lies) in
            supports.iter_mut().zip(&s.bodies).zip(held).filter(|((_, b), _)| all || new(b))
        {
            *support = Support::new(lies && body.freedom().is_some());
        }
        true
    }

    /// Finds the cells that the bodies touch, for readers of the results.
    pub fn find_overlaps(&mut self, domain: &Domain<D>, s: &State<D>, wanted: fn(&Body) -> bool) {
        self.find_reach(domain, &s.bodies);
        for (body, overlaps) in s.bodies.iter().zip(&mut self.overlaps).filter(|(b, _)| wanted(b)) {
            fraction::overlaps(
                &domain.grid,
                &body.placed(),
                self.choices.fraction,
                &mut self.tiles,
                overlaps,
            );
        }
    }

    /// Finds which bodies reach which ranks: where they lie, and where they lay before, since what
    /// they exchange in a step is of both.
    fn find_reach(&mut self, domain: &Domain<D>, bodies: &[Body]) {
        let (periods, places) = (domain.periods(), &mut self.places);
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

    /// (7), with the first two parts of (19). Returns the forces of this rank's sides on the fluid,
    /// where a balance is kept. Collective.
    fn predict_cells(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<Sides> {
        let (bodies, mut exchange) =
            (std::mem::take(&mut s.bodies), std::mem::take(&mut s.exchange));
        exchange.fill(Exchange::default());
        let (overlaps, fluid_density) = (&self.overlaps, domain.fluid.density);
        let mut exchanged = |grid: &Grid<D>, term, sign, rate: &_| {
            force::add_force(
                grid,
                fluid_density,
                &bodies,
                overlaps,
                (term, sign, rate),
                &mut exchange,
            );
        };
        let predicted = self.flow.predict_cells(domain, s, dt, Some(&mut exchanged));
        (s.bodies, s.exchange) = (bodies, exchange);
        predicted
    }

    /// Fixed bodies stay, and the fractions of those that only turn. Collective.
    fn move_particles(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<()> {
        let _logged = domain.session.log(LogStage::Bodies)?;
        self.depart(domain, s, dt)?;
        domain.clock.lap(Stage::Particles);
        s.substeps = self.advance(domain, s, dt)?;
        self.expect_contacts(s, dt);
        domain.clock.lap(Stage::Contacts);
        Ok(())
    }

    /// (27). Collective.
    fn mix_velocity(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<()> {
        let _logged = domain.session.log(LogStage::Bodies)?;
        self.settle(domain, s, dt)?;
        self.impose(domain, s, dt);
        self.sum_exchange(domain, s)?;
        domain.clock.lap(Stage::Mixing);
        Ok(())
    }

    /// (28, 29) as printed. Collective.
    fn mix_pressure(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        if !self.choices.mix_pressure {
            return Ok(());
        }
        self.flatten_pressure(domain, s)?;
        domain.boundaries.fill_pressure(&mut s.p)?;
        self.flow.find_acceleration(domain, s);
        domain.clock.lap(Stage::Mixing);
        Ok(())
    }
}
