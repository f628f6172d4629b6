//! The sharp-interface method: the pressure equation has faces that are open as far as the body
//! leaves them, and the velocity of the cells inside a body is set by the profile of the flow
//! beside its surface. Nothing is relaxed: the time step does not enter.
//!
//! With `H = 1 - m` the aperture of a face (m its solid fraction), `U_b = V + omega x r` the motion
//! of a body, `a = -grad p/rho` on faces, and `I` the mean of four cells across an open face and of
//! two across a cut one, moved to the centroid of the open part by the derivatives:
//!
//! ```text
//!   faces      q  = I(u*) + (1 - chi) (q^n - I(u^n)) + dt a,   U = H q + m U_b.n,
//!              chi = min(1, dt U_max/(0.2 h) + c nu dt/h^2)
//!   pressure   -div( H grad phi )/rho + sum_k (dV/M_k) j_k (j_k.phi) = -D/dt,       D = div U
//!   bodies     V += (dt/M_k) F_p,   F_p = dV sum_c p_c j_c,   j_c = sum_f m_f n_f/h
//!              (n_f outwards from the cell)
//!   cells      u  = u* + dt (b + (H_w (a_w - b) + H_e (a_e - b))/(1 + (H_w + H_e)/2)),
//!              b: the drive's, beside free bodies
//!   ghosts     u  = U_b + the profile of the flow beside the surface, extrapolated into the body
//!              ([`stencil`])
//! ```
//! The equation is symmetric, and its solution holds the added mass of a free body implicitly at
//! any density ratio.
//!
//! The momentum-interpolation correction `q^n - I(u^n)` keeps dt out of the pressure at the
//! surface. It decays as the flow crosses the grid and by viscosity: in a creeping flow nothing
//! else takes it away, and it would drive the flow. Its u^n is that of the cells before ghost cells
//! were set last. The rate c is 0.4 on faces that no body cuts and 0.105 in 2D, 0.25 in 3D on the
//! others, and 4 on all faces where no body moves; h is the least spacing. In narrow gaps the
//! correction is all that there is of the flow, and stays. A turning disc or sphere displaces
//! nothing.
//!
//! Where no body moves, a step longer than `t = 0.05 h^2/nu` gives the faces `I(u* + (dt - t) a_c)
//! + t a` in place of `I(u*) + dt a`, with a_c the acceleration of the cells: a steady flow would
//! leak through `dt (a - I a_c)` the more the longer the step. Steps that viscosity would bind are
//! made in Legendre stages ([`crate::scheme::legendre`]); ghost cells are set on each.
//!
//! The spin of a light body moves little but fluid. With R the resistance of the surface's slope to
//! a change of spin within the step (`motion.rs`), T the torque of the fluid and J the impulse of
//! contacts, whose substeps have the moment of inertia I + dt R:
//!
//! ```text
//!   expected   w_e = w + P + J/(I + dt R)                   P: what the fluid did in the last step
//!   responded  (I + dt R) (w_a - w) = dt T(w_e) + dt R (w_e - w) + J
//!                 T is taken with ghost cells of w_e
//!   damped     w' = w_e + m (w_a - w_e),   P' = P + w_a - w_e
//!              m = 1/(1 + dt C/(I + dt R)), C: the resistance of lubrication; 0 in contact
//! ```
//! One w_e serves the ghost cells, the torque and contacts. Without the last line a contact
//! responds to the fluid's response to its impulse a step late; a light body that lubrication holds
//! hard then turns to and fro, 1.6 times as fast after each step.
//!
//! In time the force is of second order. Of first order, and small, are cells that change sides at
//! the end of a step, and the history of faces beside a surface that accelerates.
//!
//! The force is what the fluid loses. All cells together lose momentum only in ghost cells (`du`)
//! and where the gradient of a cut cell differs from the plain mean of its faces'; what lies inside
//! the body is no fluid:
//!
//! ```text
//!   F = -(rho dV/dt) sum du - rho dV sum (open - plain gradient) + d/dt( rho dV sum alpha u )
//! ```
//! F of a step jitters as cells change sides. A body moves by pressure and wall shear, `F_p + F_v`,
//! and by the filtered force defect `X += eps (F - F_p - F_v - X)`, over the time in which the
//! flow, or viscosity, crosses some cells. What a body has not felt yet is its undelivered impulse,
//! a part of the balance of momentum. With advection that does not conserve momentum there is no
//! such defect: a body moves by `F_p + F_v` alone.

mod acceleration;
mod apertures;
mod balance;
mod body_motion;
mod boundaries;
mod contact_correction;
mod coupled;
pub mod cut;
mod cut_body;
mod face_correction;
mod gap;
mod image_point;
mod impulsive_start;
mod load;
mod local;
mod modes;
mod near;
mod neighbour;
mod normal;
mod places;
mod pressure_step;
mod profile;
mod rigid;
mod seen;
mod shared;
mod shared_cell;
mod stencil;
mod step_numbers;
mod sums;
mod surfaces;
mod traction;

use super::momentum::MixtureProperties;
use super::prediction::Prediction;
use super::{Method, MethodKind, Traction};
use crate::Result;
use crate::clock::Stage;
use crate::contact::{Contacts, Medium};
use crate::domain::Domain;
use crate::geometry::{Cut, Overlap};
use crate::grid::VectorField;
use crate::kernels::boundary::Sides;
use crate::kernels::faces::{self, FaceCoefficient};
use crate::numerics::IMAGE_POINT;
use crate::particles::{Body, RigidVelocity, velocities};
use crate::petsc::LogStage;
use crate::poisson::pressure::{Accuracy, Projected};
use crate::scheme::Scheme;
use crate::state::{Balance, BeforeForcing, BodyHistory, Exchange, State, SurfaceHistory};
use acceleration::PressureAcceleration;
use cut::CutBodies;
pub use gap::reach as gap_reach;
use modes::Modes;
use pressure_step::PressureStep;
use rigid::RigidStep;
use std::any::Any;
use step_numbers::{FaceWeights, StepNumbers};
use surfaces::Surfaces;

/// Depth to which the profile is continued into a body (spacings): the fifth-order upwind value of
/// a face at the surface is from cells so far from it.
const PROFILE_DEPTH: f64 = 2.5;

/// The method with sharp surfaces.
pub struct Sharp<const D: usize> {
    mixture: MixtureProperties,
    prediction: Prediction<D>,
    cut: CutBodies<D>,
    acceleration: PressureAcceleration<D>,
    modes: Modes,
    rigid: RigidStep,
}

/// The spacing that image points count in (m), and the layers of ghosts that they need, on a grid
/// of the spacings `h` (m): no axis may have fewer cells.
pub fn ghost_width(h: &[f64]) -> (f64, usize) {
    let least = h.iter().copied().fold(f64::INFINITY, f64::min);
    let most = h.iter().copied().fold(0.0, f64::max).min(2.0 * least);
    let reach = PROFILE_DEPTH + 2.0 * IMAGE_POINT;
    (most, 2 + (reach * most / least - 1e-9).ceil() as usize)
}

impl<const D: usize> Method<D> for Sharp<D> {
    fn kind(&self) -> MethodKind {
        MethodKind::Sharp
    }

    fn step(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<Projected> {
        // (17, 18, 20-26) bodies to their new place, faces open there
        let rebuilt = self.predict_positions(domain, s, dt)?;
        let numbers = StepNumbers::find(domain, s, &self.cut, dt)?;
        // correction = q - mean(u), at that place
        self.update_face_correction(domain, s, numbers, rebuilt, dt)?;
        // (7) u* with the last pressure, ghost cells set
        let sides = self.predict_cells(domain, s, dt)?;
        // (17, 18) bodies by all forces but the new pressure
        self.rigid.predict_velocities(domain, s, &self.cut, dt)?;
        // (8) U = H q + m U_b.n
        self.predict_faces(domain, s, numbers, dt)?;
        // (13-15) C-HSMAC: |D| < D0, the bodies with it
        let projected = self.project(domain, s, dt)?;
        // (16) u = u* - dt/rho grad p, ghost cells set
        self.correct_cells(domain, s, dt)?;
        // (19) the force: what the fluid lost
        self.rigid.find_loads(domain, s, &self.cut, numbers, dt)?;
        balance::close(domain, s, &self.rigid, sides, dt)?;
        s.count(dt);
        Ok(projected)
    }

    fn start(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        s.touching = self
            .rigid
            .contacts
            .as_ref()
            .map_or_else(Default::default, |contacts| contacts.untouched());
        s.surfaces = Some(SurfaceHistory::new(&domain.grid, s.bodies.len()));
        self.settle(domain, &s.bodies, &[], None)?;
        self.acceleration.clear();
        self.set_ghost_cells(domain, &s.bodies, &mut s.u)?;
        face_correction::interpolate(
            &mut self.cut,
            domain,
            s,
            FaceWeights::START,
            0.0,
            &self.acceleration,
        )?;
        domain.boundaries.set_faces(&mut s.faces);
        let Sharp { cut, acceleration, rigid, .. } = self;
        impulsive_start::project(domain, s, cut, acceleration, rigid, None)?;
        s.drive = domain.drive_at_start();
        let surfaces = SurfaceHistory::of(&mut s.surfaces)?;
        copy(&s.faces, &mut surfaces.correction);
        surfaces.before_forcing.reserve(self.cut.most_ghost_cells());
        self.rigid.initialise_history(domain, s, &self.cut, |_| true)?;
        self.cut.places.keep(&mut SurfaceHistory::of(&mut s.surfaces)?.bodies);
        s.exchange.fill(Exchange::default());
        s.balance = s.has_free_bodies().then(Balance::default);
        self.start_balance(domain, s)?;
        s.p.fill(0.0);
        self.acceleration.of_pressure(domain, &mut self.cut, &s.bodies, &s.p, s.drive);
        Ok(())
    }

    fn resume(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        before: Option<Box<dyn Method<D>>>,
    ) -> Result<()> {
        let before = before.and_then(|before| (before as Box<dyn Any>).downcast().ok());
        if let Some(contacts) = &self.rigid.contacts {
            contacts.setup().check(&s.touching)?;
        }
        // Ghosts depend on which boundaries bodies are near to.
        let surfaces = SurfaceHistory::of(&mut s.surfaces)?;
        self.settle(
            domain,
            &s.bodies,
            &surfaces.bodies,
            before.map(|before: Box<Self>| before.cut),
        )?;
        domain.boundaries.fill_velocity(&mut s.u)?;
        surfaces.before_forcing.reserve(self.cut.most_ghost_cells());
        self.acceleration.of_pressure(domain, &mut self.cut, &s.bodies, &s.p, s.drive);
        Ok(())
    }

    fn find_acceleration(&mut self, domain: &Domain<D>, s: &State<D>) {
        self.acceleration.of_pressure(domain, &mut self.cut, &s.bodies, &s.p, s.drive);
    }

    fn mixture(&self) -> &MixtureProperties {
        &self.mixture
    }

    fn beta(&self) -> &FaceCoefficient<D> {
        &self.cut.beta
    }

    fn scheme(&self) -> Scheme {
        self.prediction.scheme
    }

    fn place(&mut self, domain: &Domain<D>, s: &State<D>) {
        self.cut.settle(domain, &s.bodies, &[], None);
    }

    fn contacts(&self) -> Option<&Contacts> {
        self.rigid.contacts.as_ref()
    }

    fn contacts_mut(&mut self) -> Option<&mut Contacts> {
        self.rigid.contacts.as_mut()
    }

    fn overlaps_of(&self, k: usize) -> Option<&[Overlap]> {
        (k < self.cut.bodies.count()).then(|| self.cut.bodies[k].solid.as_slice())
    }

    fn covered_faces(&self, k: usize, axis: usize) -> Option<&[Cut]> {
        (k < self.cut.bodies.count()).then(|| self.cut.bodies[k].faces.cuts[axis].iter().as_slice())
    }

    fn tractions(&self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<Vec<Traction>> {
        traction::find(&self.cut, domain, s)
    }

    fn start_balance(&self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        balance::begin(domain, s)
    }

    fn impose_inserted(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        ids: &[usize],
    ) -> Result<()> {
        if ids.is_empty() {
            return Ok(());
        }
        let Sharp { cut, acceleration, modes, rigid, .. } = self;
        impulsive_start::apply(domain, s, cut, acceleration, rigid, modes, ids)
    }

    fn begin_bodies(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        ids: &[usize],
    ) -> Result<()> {
        if ids.is_empty() {
            return Ok(());
        }
        self.rigid.initialise_history(domain, s, &self.cut, |id| ids.contains(&id))
    }
}

impl<const D: usize> Sharp<D> {
    /// The method for bodies in the fluid of a domain, with its `prediction` (7).
    /// [`Method::start`] or [`Method::resume`] comes next.
    pub fn new(
        domain: &Domain<D>,
        bodies: &[Body],
        mixture: MixtureProperties,
        prediction: Prediction<D>,
        contacts: Option<Contacts>,
    ) -> Sharp<D> {
        let cut = CutBodies::new(domain, bodies);
        let fluid = &domain.fluid;
        let medium = Medium {
            density: fluid.density,
            viscosity: fluid.viscosity,
            spacing: cut.h,
            ..Medium::default()
        };
        let contacts = contacts.map(|contacts| contacts.within(medium));
        Sharp {
            mixture,
            acceleration: PressureAcceleration::new(&domain.grid),
            modes: Modes::new(bodies),
            rigid: RigidStep::new(bodies, contacts, prediction.keeps_momentum()),
            prediction,
            cut,
        }
    }

    /// (17, 18, 20-26): moves the bodies on by `dt` (s), and opens the faces there. Returns whether
    /// any were cut anew. Collective.
    fn predict_positions(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<bool> {
        let _logged = domain.session.log(LogStage::Bodies)?;
        let Sharp { cut, rigid, .. } = self;
        rigid.begin(domain, s, cut.h, dt)?;
        s.substeps = 0;
        let mut rebuilt = false;
        if s.bodies.iter().any(Body::moves) {
            rigid.advance(domain, s, cut.h, dt)?;
            rebuilt = cut.rebuild_moved(domain, &s.bodies, dt);
            cut.places.keep(&mut SurfaceHistory::of(&mut s.surfaces)?.bodies);
        }
        if rebuilt {
            boundaries::cover_boundaries(cut, domain);
        }
        if self.set_ghost_layers(domain, &s.bodies) {
            domain.boundaries.fill_velocity(&mut s.u)?;
        }
        domain.clock.lap(Stage::Particles);
        Ok(rebuilt)
    }

    /// Sets the velocity of the cells inside the bodies. Collective.
    fn set_ghost_cells(
        &mut self,
        domain: &mut Domain<D>,
        bodies: &[Body],
        u: &mut VectorField<D>,
    ) -> Result<()> {
        domain.boundaries.fill_velocity(u)?;
        self.cut.set_ghost_cells(domain, velocities(bodies), false, None, u);
        domain.boundaries.fill_velocity(u)
    }

    /// Updates the momentum-interpolation correction of the faces: what their velocity was beyond
    /// that of the cells with ghost cells set at the present place; nothing where nothing will be
    /// kept of it. Collective.
    fn update_face_correction(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        numbers: StepNumbers,
        rebuilt: bool,
        dt: f64,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Prediction)?;
        if rebuilt {
            domain.projection.assemble(&domain.grid, &self.cut.beta)?;
            domain.clock.lap(Stage::Assembly);
        }
        if numbers.weights.cut_correction > 0.0 || numbers.crowded {
            let surfaces = SurfaceHistory::of(&mut s.surfaces)?;
            let stage = &mut self.prediction.stage;
            copy(&s.u, stage);
            if s.bodies.iter().any(Body::moves) {
                // The drive has not accelerated the fluid of this step yet, nor the bodies beside
                // it.
                let acceleration = &self.acceleration;
                let undriven = |k: usize| {
                    let body = &s.bodies[k];
                    let velocity = body.velocity - dt * acceleration.driven(body);
                    RigidVelocity { velocity, spin: body.spin }
                };
                self.cut.set_ghost_cells(domain, undriven, true, None, stage);
            }
            // Faces have yet to see what ghost cells changed after the projection.
            for BeforeForcing { cell, velocity } in &surfaces.before_forcing {
                let cell = *cell as usize;
                for ((stage, u), before) in stage.iter_mut().zip(&s.u).zip(velocity) {
                    stage[cell] += before - u[cell];
                }
            }
            domain.boundaries.fill_stencils(stage)?;
            face_correction::update_face_correction(
                &self.cut,
                domain,
                stage,
                s.dt,
                &self.acceleration,
                &mut surfaces.correction,
            );
        }
        if rebuilt {
            self.acceleration.find_cut_changes(domain, &mut self.cut, &s.bodies);
        }
        domain.clock.lap(Stage::Mixing);
        Ok(())
    }

    /// (7): ghost cells are set on every stage and on their sum, which has the last pressure; the
    /// bodies are at the step's end already. Returns the forces of this
    /// rank's sides on the fluid, where a balance is kept. Collective.
    fn predict_cells(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<Sides> {
        let _logged = domain.session.log(LogStage::Prediction)?;
        self.rigid.exchanged.fill(Default::default());
        if let Some(forces) = &mut domain.forces {
            let bodies = &self.cut.bodies;
            let exchanged = &mut self.rigid.exchanged;
            let bodies = bodies.each().map(|(k, body)| (k, &body.solid[..]));
            forces.share(&domain.session, &domain.grid, bodies, |k, arm, force| {
                exchanged[k].add(arm, &(dt * force));
            })?;
        }
        self.cut.find_cubic(domain, velocities(&s.bodies), &s.u);
        let Sharp { mixture, prediction, cut, acceleration, rigid, .. } = self;
        if prediction.is_long(domain, dt) {
            cut.find_targets(domain, velocities(&s.bodies), true, &s.u);
            cut.find_offsets(&s.u);
        }
        let mut walls = Surfaces { cut, exchanged: &mut rigid.exchanged };
        let sides = prediction.predict(domain, s, mixture, &acceleration.faces, dt, &mut walls)?;
        domain.boundaries.fill_velocity(&mut s.u)?;
        let now = velocities(&s.bodies);
        cut.set_ghost_cells(domain, now, true, Some(&mut rigid.exchanged), &mut s.u);
        domain.boundaries.fill_imposed(&mut s.u)?;
        domain.clock.lap(Stage::Mixing);
        Ok(sides)
    }

    /// (8), from the cells without the last pressure. Collective.
    fn predict_faces(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        numbers: StepNumbers,
        dt: f64,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Prediction)?;
        self.acceleration.add_to(domain, &self.cut, -numbers.weights.face_gradient * dt, &mut s.u);
        domain.boundaries.fill_stencils(&mut s.u)?;
        domain.clock.lap(Stage::Ghosts);
        if !s.faces_before[0].is_empty() {
            std::mem::swap(&mut s.faces, &mut s.faces_before);
        }
        let weights = numbers.weights;
        face_correction::interpolate(&mut self.cut, domain, s, weights, dt, &self.acceleration)?;
        domain.boundaries.set_faces(&mut s.faces);
        if weights.face_gradient < 1.0 {
            self.acceleration.add_to(domain, &self.cut, -weights.in_cells(dt), &mut s.u);
        }
        domain.clock.lap(Stage::Faces);
        Ok(())
    }

    /// (13-15), the free bodies and the impulses of their contacts with it. Collective.
    fn project(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<Projected> {
        let _logged = domain.session.log(LogStage::Pressure)?;
        let Sharp { cut, modes, rigid, .. } = self;
        let RigidStep { contacts, motions, sums, correction, .. } = rigid;
        let in_contact = contacts.as_mut().filter(|contacts| contacts.gave(&s.bodies, dt));
        let mut step = PressureStep::new(domain, cut, s, modes, motions, sums, dt)?;
        let (projected, taken) = match in_contact {
            Some(contacts) => {
                contact_correction::solve(&mut contacts.impulses(), &mut step, correction)?
            }
            None => (step.solve(Accuracy::Full)?, 0.0),
        };
        s.energy.bounded += taken;
        domain.clock.lap(Stage::Pressure);
        Ok(projected)
    }

    /// (16), ghost cells set. Collective.
    fn correct_cells(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<()> {
        let _logged = domain.session.log(LogStage::Correction)?;
        let Sharp { cut, acceleration, rigid, .. } = self;
        acceleration.of_pressure(domain, cut, &s.bodies, &s.p, s.drive);
        faces::add_to_cells(&domain.grid, dt, &acceleration.faces, &mut s.u);
        acceleration::add_cut_cells(cut, domain, dt, Some(&mut rigid.exchanged), &mut s.u);
        domain.clock.lap(Stage::Faces);
        domain.boundaries.fill_velocity(&mut s.u)?;
        let before_forcing = &mut SurfaceHistory::of(&mut s.surfaces)?.before_forcing;
        cut.take_before_forcing(&s.u, before_forcing);
        let now = velocities(&s.bodies);
        cut.set_ghost_cells(domain, now, false, Some(&mut rigid.exchanged), &mut s.u);
        domain.boundaries.fill_imposed(&mut s.u)?;
        domain.clock.lap(Stage::Mixing);
        Ok(())
    }

    /// As [`CutBodies::settle`], with the boundaries and the operator. Collective.
    fn settle(
        &mut self,
        domain: &mut Domain<D>,
        bodies: &[Body],
        histories: &[BodyHistory],
        before: Option<CutBodies<D>>,
    ) -> Result<()> {
        self.cut.settle(domain, bodies, histories, before);
        self.modes.make_room(&self.cut);
        boundaries::straighten_boundaries(&self.cut, domain, bodies);
        boundaries::cover_boundaries(&self.cut, domain);
        self.set_ghost_layers(domain, bodies);
        domain.projection.assemble(&domain.grid, &self.cut.beta)
    }

    /// Deep ghosts, where something reads them. Returns whether what was filled before does not
    /// reach so far.
    fn set_ghost_layers(&self, domain: &mut Domain<D>, bodies: &[Body]) -> bool {
        let deep = domain.session.size() > 1 || self.cut.near_boundaries(&domain.grid, bodies);
        domain.boundaries.set_velocity_layers(deep)
    }
}

fn copy<const D: usize>(from: &VectorField<D>, to: &mut VectorField<D>) {
    to.iter_mut().zip(from).for_each(|(to, from)| to.copy_from_slice(from));
}
