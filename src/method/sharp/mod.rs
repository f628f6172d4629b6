//! The wall where it is: faces of the pressure equation open as far as they are, and the velocity
//! inside a body set from the profile beside it. Nothing is relaxed, so that the time step does not
//! enter.
//!
//! With `H = 1 - m` the open part of a face (m the covered one), `U_b = V + omega x r` a body's
//! motion, `a = -grad p/rho` on faces and `I` the mean of four cells across a free face, of two
//! across a covered one, moved to the centroid of the open part by the derivatives:
//!
//! ```text
//!   faces      q  = I(u*) + (1 - chi) (q^n - I(u^n)) + dt a,   U = H q + m U_b.n,
//!              chi = min(1, dt U_max/(0.2 h) + c nu dt/h^2)
//!   pressure   -div( H grad phi )/rho + sum_k (dV/M_k) j_k (j_k.phi) = -D/dt,       D = div U
//!   bodies     V += (dt/M_k) F_p,   F_p = dV sum_c p_c j_c,   j_c = sum_f m_f n_f/h
//!              (n_f outwards from the cell)
//!   cells      u  = u* + dt (b + (H_w (a_w - b) + H_e (a_e - b))/(1 + (H_w + H_e)/2)),
//!              b: the drive's, beside free bodies
//!   inside     u  = U_b + the profile of the flow beside the wall, continued into the body
//!              ([`stencil`])
//! ```
//! The equation stays symmetric, and its solution holds the added mass of a free body implicitly,
//! whatever its density. The memory `q^n - I(u^n)` keeps dt out of the wall's pressure; it fades as
//! the flow crosses the grid and, since it is as small as the grid, by viscosity: in a creeping
//! flow nothing else takes it, and it would drive the flow; its u^n is that of the cells before the
//! wall was imposed last, c is 0.4 on faces that no body cuts and 0.105 in 2D, 0.25 in 3D on the
//! others, 4 on all where no body moves, h the least spacing, so that what this changes reaches the
//! faces with the next step. In narrow gaps it is all there is of the flow, and stays. A turning
//! disc or sphere displaces nothing.
//!
//! Where no body moves, a step longer than `t = 0.05 h^2/nu` gives the faces
//! `I(u* + (dt - t) a_c) + t a` in place of `I(u*) + dt a`, with a_c the cells' acceleration:
//! `dt (a - I a_c)`, through which a steady flow would leak, is no longer the more the longer the
//! step. Steps that viscosity would bind are made in Legendre stages
//! ([`crate::scheme::legendre`]); the wall is imposed on each.
//!
//! Spin, of which little but fluid is moved where a body is light, with R what the wall's slope
//! resists to a change of it within the step (`motion.rs`), T the fluid's torque and J what
//! contacts give, their own substeps on the moment of inertia I + dt R:
//!
//! ```text
//!   expected   w_e = w + P + J/(I + dt R)                   P: what the fluid did in the last step
//!   responded   (I + dt R) (w_a - w) = dt T(w_e) + dt R (w_e - w) + J
//!                 T is taken with w_e imposed
//!   held       w' = w_e + m (w_a - w_e),   P' = P + w_a - w_e
//!              m = 1/(1 + dt C/(I + dt R)), C: what films resist; 0 where it touches
//! ```
//! One w_e for the wall that the fluid sees, for the torque and for contacts. Without the last line
//! a contact responds to what the fluid made of its impulse with the next step only; a light body
//! that films hold hard then turns to and fro, 1.6 times as fast after each step.
//!
//! In time the force is of second order. Of first order, and small, are cells that change sides, at
//! the end of a step, and the history of faces beside a wall that gathers speed.
//!
//! The force is what the fluid loses. All cells together lose momentum only where the profile is
//! imposed (`du`) and where the gradient of a cut cell differs from the plain mean of its faces';
//! what lies inside the body is no fluid:
//!
//! ```text
//!   F = -(rho dV/dt) sum du - rho dV sum (open - plain gradient) + d/dt( rho dV sum alpha u )
//! ```
//! Each step's F jitters as cells change sides. A body moves by pressure and wall shear, `F_p +
//! F_v`, and takes in what these miss, the residual `X += eps (F - F_p - F_v - X)`, over the time
//! the flow, or viscosity, needs for some cells. What a body has not felt yet is its deferred
//! impulse, a part of the balance of momentum. Advection that loses momentum by itself leaves no
//! such residual: there a body moves by `F_p + F_v` alone.

mod acceleration;
mod balance;
mod borders;
mod contact_correction;
mod coupled;
pub mod cut;
mod cut_body;
mod exchanged;
mod faces;
mod gap;
mod image_point;
mod impulsive_start;
mod load;
mod modes;
mod motion;
mod near;
mod openings;
mod profile;
mod shared;
mod stencil;
mod step;

use super::momentum::{Mixture, Momentum};
use super::stabilised::Stabilised;
use crate::contact::{Contacts, Medium};
use crate::domain::Domain;
use crate::geometry::Overlap;
use crate::grid::VectorField;
use crate::kernels::faces::FaceCoefficient;
use crate::numerics::Numerics;
use crate::particles::{Accelerations, Body};
use crate::poisson::pressure::Projected;
use crate::state::{Balance, Exchange, State, WallHistory};
use crate::{Error, Result};
use acceleration::PressureAcceleration;
use cut::CutBodies;
use exchanged::ExchangedMomentum;
pub use gap::reach as gap_reach;
use modes::Modes;
use motion::BodyMotion;
use nalgebra::Vector3;

/// Depth to which the profile is continued into a body (spacings): the fifth-order upwind value of
/// a face at the wall is from cells so far from it.
const PROFILE_DEPTH: f64 = 2.5;

/// Numbers that ranks sum for a body.
const NUMBERS: usize = 12;

/// The method with sharp walls.
pub struct Sharp<const D: usize> {
    mixture: Mixture,
    momentum: Momentum<D>,
    contacts: Option<Contacts>,
    cut: CutBodies<D>,
    acceleration: PressureAcceleration<D>,
    modes: Modes,
    /// Per body, its motion within the step.
    motions: Vec<BodyMotion>,
    /// Force of the fluid (N) in gaps that the grid does not resolve, which walls and held bodies
    /// have in place of free ones.
    passed_on: Vector3<f64>,
    work: Work<D>,
    /// What steps need that viscosity would bind; `None` where the scheme does not have them.
    stabilised: Option<Stabilised<D>>,
}

/// Scratch of a step.
struct Work<const D: usize> {
    /// Velocity that a stage after the first starts from, or that the faces' memory is taken beside
    /// (m/s).
    stage: VectorField<D>,
    /// Velocities inside the bodies that were imposed (m/s).
    inside: Vec<Vector3<f64>>,
    /// What the cells inside had at the start of a step beyond what is imposed at its end (m/s).
    offsets: Vec<Vector3<f64>>,
    accelerations: Vec<Accelerations>,
    exchanged: Vec<ExchangedMomentum>,
    sums: Vec<f64>,
    contacts: contact_correction::Work,
}

/// How far a step goes at the largest face speed.
#[derive(Clone, Copy, Debug)]
struct StepNumbers {
    /// Spacings that the flow crosses.
    courant: f64,
    /// Squared spacings that viscosity crosses.
    diffusion: f64,
    /// What faces keep of their memory that a body cuts.
    keep: f64,
    /// The same where they are all open.
    keep_open: f64,
    /// How much of the last pressure's acceleration they have at once in place of the mean of the
    /// cells'.
    own: f64,
}

impl StepNumbers {
    /// Before the first step.
    const START: StepNumbers =
        StepNumbers { courant: 0.0, diffusion: 0.0, keep: 1.0, keep_open: 1.0, own: 1.0 };
}

/// The spacing that image points count in (m), and the layers of ghosts that they need, on a grid
/// of the spacings `h` (m): no axis may have fewer cells.
pub fn ghost_width(h: &[f64], numerics: &Numerics) -> (f64, usize) {
    let least = h.iter().copied().fold(f64::INFINITY, f64::min);
    let most = h.iter().copied().fold(0.0, f64::max).min(2.0 * least);
    let reach = PROFILE_DEPTH + 2.0 * numerics.image_point;
    (most, 2 + (reach * most / least - 1e-9).ceil() as usize)
}

impl<const D: usize> Sharp<D> {
    /// The method for bodies in the fluid of a domain, which has the terms `momentum` of (7).
    /// [`Sharp::start`] or [`Sharp::resume`] comes next.
    pub fn new(
        domain: &Domain<D>,
        bodies: &[Body],
        mixture: Mixture,
        momentum: Momentum<D>,
        contacts: Option<Contacts>,
    ) -> Sharp<D> {
        let (n, cut) = (bodies.len(), CutBodies::new(domain, bodies));
        let (fluid, momentum_is_stabilised) =
            (&domain.fluid, momentum.scheme.most_stages.is_some());
        let medium = Medium {
            density: fluid.density,
            viscosity: fluid.viscosity,
            spacing: cut.h,
            ..Medium::default()
        };
        Sharp {
            mixture,
            stabilised: Stabilised::new(&domain.grid, &momentum.scheme),
            momentum,
            contacts: contacts.map(|contacts| contacts.within(medium)),
            acceleration: PressureAcceleration::new(&domain.grid, cut.most_solid()),
            modes: Modes::new(bodies, &cut),
            motions: bodies
                .iter()
                .map(|b| BodyMotion {
                    surface_moments: b.shape().surface_moments(),
                    ..BodyMotion::default()
                })
                .collect(),
            passed_on: Vector3::zeros(),
            work: Work {
                stage: domain.grid.vector_field(),
                inside: Vec::with_capacity(cut.most_inside()),
                offsets: Vec::with_capacity(if momentum_is_stabilised {
                    cut.most_inside()
                } else {
                    0
                }),
                accelerations: vec![Accelerations::default(); n],
                exchanged: vec![ExchangedMomentum::default(); n],
                sums: vec![0.0; n * NUMBERS],
                contacts: contact_correction::Work::new(n),
            },
            cut,
        }
    }

    /// Advances by `dt` (s). Collective.
    ///
    /// # Errors
    /// When the divergence cannot be brought below D0, a value is no longer finite, or a contact
    /// fails.
    pub fn step(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<Projected> {
        // (17, 18, 20-26) bodies to their new place, faces open there
        self.predict_positions(domain, s, dt)?;
        let numbers = self.step_numbers(domain, s, dt)?;
        // memory = q - mean(u), at that place
        self.update_memory(domain, s, numbers, dt)?;
        // (7) u* with the last pressure, the wall imposed
        let sides = self.predict_cells(domain, s, dt)?;
        // (17, 18) bodies by all forces but the new pressure
        self.predict_velocities(domain, s, dt)?;
        // (8) U = H q + m U_b.n
        self.predict_faces(domain, s, numbers, dt)?;
        // (13-15) C-HSMAC: |D| < D0, the bodies with it
        let projected = self.project(domain, s, dt)?;
        // (16) u = u* - dt/rho grad p, the wall imposed
        self.correct_cells(domain, s, dt)?;
        // (19) the force: what the fluid lost
        self.find_loads(domain, s, numbers, dt)?;
        self.close_balance(domain, s, sides, dt)?;
        s.count(dt);
        Ok(projected)
    }

    /// A consistent start from the cells' velocity. Collective.
    pub fn start(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        s.touching =
            self.contacts.as_ref().map_or_else(Default::default, |contacts| contacts.untouched());
        s.walls = Some(WallHistory::new(&domain.grid, s.bodies.len()));
        self.settle(domain, &s.bodies)?;
        self.acceleration.clear();
        self.impose(domain, &s.bodies, &mut s.u)?;
        self.cut.interpolate(domain, s, StepNumbers::START, 0.0, &self.acceleration)?;
        domain.boundaries.set_faces(&mut s.faces);
        self.impulsive_start(domain, s, false)?;
        s.drive = domain.drive_at_start(&s.bodies);
        let walls = history(&mut s.walls)?;
        copy(&s.faces, &mut walls.memory);
        walls.before_forcing.reserve(self.cut.most_inside());
        self.begin_bodies(domain, s, |_| true)?;
        s.exchange.fill(Exchange::default());
        s.balance = s.has_free_bodies().then(Balance::default);
        self.start_balance(domain, s)?;
        s.p.fill(0.0);
        self.acceleration.of_pressure(domain, &self.cut, &s.bodies, &s.p, s.drive);
        Ok(())
    }

    /// Finds the acceleration by the pressure as it is.
    pub fn find_acceleration(&mut self, domain: &Domain<D>, s: &State<D>) {
        self.acceleration.of_pressure(domain, &self.cut, &s.bodies, &s.p, s.drive);
    }

    /// Gives bodies that have none a past: what one does first in a fluid at rest, how the fluid's
    /// wall shear begins to turn it, and the momentum inside as it is; ghosts of the velocity
    /// filled. Collective.
    pub fn begin_bodies(
        &mut self,
        domain: &Domain<D>,
        s: &mut State<D>,
        new: impl Fn(usize) -> bool,
    ) -> Result<()> {
        let sums = self.sum_forces(domain, s)?;
        let fluid = &domain.fluid;
        if let Some(contacts) = &mut self.contacts {
            contacts.meet(&s.bodies);
        }
        // The first motion of a lone body; beside others, what contacts may have to hold
        // at its effective mass.
        let begins = |k: usize, body: &Body| {
            let (added, displaced) =
                (body.added_mass(fluid.density), fluid.density * body.volume());
            let driven = s.drive.map_or_else(Vector3::zeros, |force| added / fluid.density * force);
            let pull = (body.mass() - displaced) * fluid.gravity
                + domain.felt(&s.drive, body.volume())
                + driven;
            let beside = self.contacts.as_ref().filter(|contacts| contacts.is_paired(k));
            let mass =
                beside.map_or(body.mass() + added, |contacts| contacts.mass_in_contact(body));
            body.freedom().map_or_else(Vector3::zeros, |freedom| freedom.along(&pull) / mass)
        };
        let all =
            history(&mut s.walls)?.bodies.iter_mut().zip(&s.bodies).zip(sums.chunks_exact(NUMBERS));
        for (k, ((history, body), row)) in
            all.enumerate().filter(|(_, ((_, body), _))| new(body.id))
        {
            let Some(freedom) = body.freedom() else { continue };
            history.accelerations.acceleration = begins(k, body);
            let torque = Vector3::from_column_slice(&row[6..9]);
            history.accelerations.angular = body.inertia().inverse_mass(&torque, &freedom);
        }
        self.work.sums = sums;
        self.take_inside(domain, s, new)
    }

    /// Finds what follows from a state: what the bodies cover, the operator, the acceleration by
    /// the pressure. Collective.
    ///
    /// # Errors
    /// When the state has contacts that are not of this case.
    pub fn resume(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        if let Some(contacts) = &self.contacts {
            contacts.check(&s.touching)?;
        }
        // Ghosts depend on which borders bodies are near to.
        self.settle(domain, &s.bodies)?;
        domain.boundaries.fill_velocity(&mut s.u)?;
        history(&mut s.walls)?.before_forcing.reserve(self.cut.most_inside());
        self.acceleration.of_pressure(domain, &self.cut, &s.bodies, &s.p, s.drive);
        Ok(())
    }

    /// Finds what the bodies cover where they lie now, for readers of the results as well.
    pub fn place(&mut self, domain: &Domain<D>, bodies: &[Body]) {
        self.cut.settle(domain, bodies);
    }

    fn settle(&mut self, domain: &mut Domain<D>, bodies: &[Body]) -> Result<()> {
        self.place(domain, bodies);
        self.cut.straighten_borders(domain, bodies);
        self.set_ghost_layers(domain, bodies);
        domain.projection.assemble(&domain.grid, &self.cut.beta)
    }

    /// Deep ghosts, where something reads them. Returns whether what was filled before does not
    /// reach so far.
    fn set_ghost_layers(&self, domain: &mut Domain<D>, bodies: &[Body]) -> bool {
        let deep = domain.session.size() > 1 || self.cut.near_borders(&domain.grid, bodies);
        domain.boundaries.set_velocity_layers(deep)
    }

    /// The cells of this rank that bodies touch.
    pub fn overlaps(&self) -> impl Iterator<Item = &Overlap> {
        self.cut.bodies.iter().flat_map(|body| &body.solid)
    }

    /// Those of each body.
    pub fn by_body(&self) -> impl Iterator<Item = &[Overlap]> {
        self.cut.bodies.iter().map(|body| &body.solid[..])
    }

    /// The law of contacts, where there is one.
    pub fn contacts(&self) -> Option<&Contacts> {
        self.contacts.as_ref()
    }

    /// The same, to look for contacts.
    pub fn contacts_mut(&mut self) -> Option<&mut Contacts> {
        self.contacts.as_mut()
    }

    /// The fluid.
    pub fn mixture(&self) -> &Mixture {
        &self.mixture
    }

    /// Open part of faces over the fluid's density (m3/kg).
    pub fn beta(&self) -> &FaceCoefficient<D> {
        &self.cut.beta
    }

    /// The terms of (7).
    pub fn momentum(&self) -> &Momentum<D> {
        &self.momentum
    }
}

/// The history of a state that has sharp walls.
///
/// # Errors
/// When it has none: it is another method's.
fn history<const D: usize>(walls: &mut Option<WallHistory<D>>) -> Result<&mut WallHistory<D>> {
    walls.as_mut().ok_or_else(|| {
        Error::Run("the state has no history of sharp walls: start it with them".into())
    })
}

fn copy<const D: usize>(from: &VectorField<D>, to: &mut VectorField<D>) {
    to.iter_mut().zip(from).for_each(|(to, from)| to.copy_from_slice(from));
}
