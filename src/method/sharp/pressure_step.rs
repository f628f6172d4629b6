//! The bodies while the pressure is found (13-15): they and the faces respond to each change of it.
//!
//! ```text
//!   F_k = dV sum_c phi_c j_c,   V_k += (dt/M_k) F_k          U += m dV.n on the faces it covers
//!   turned by pressure, where a body is not round:            omega += dt B T
//! ```
//! The operator has been told of the bodies ([`super::modes`]) before the first solve: whoever
//! holds a [`PressureStep`] need not know of that order.

use super::body_motion::BodyMotion;
use super::coupled::CoupledFaces;
use super::cut::CutBodies;
use super::modes::{self, Modes};
use super::sums::{Response, Sums};
use crate::Result;
use crate::contact::{Impulse, Impulses};
use crate::domain::Domain;
use crate::drive::Driving;
use crate::grid::{Boundaries, Grid, VectorField};
use crate::particles::Body;
use crate::petsc::Session;
use crate::poisson::pressure::{Accuracy, Coupled, Projected, Projection};
use crate::state::State;
use nalgebra::Vector3;

/// The solves of a step: all that may change the pressure, the faces or a body's velocity
/// meanwhile.
pub struct PressureStep<'a, const D: usize> {
    grid: &'a Grid<D>,
    boundaries: &'a mut Boundaries<D>,
    projection: &'a mut Projection,
    p: &'a mut [f64],
    dt: f64,
    following: Following<'a, D>,
}

impl<'a, const D: usize> PressureStep<'a, D> {
    /// Tells the operator of the bodies and of a drive that holds a mean velocity, for a step `dt`
    /// (s) in which the bodies have these motions. Collective.
    ///
    /// # Errors
    /// When the solver would pass over the bodies.
    pub fn new(
        domain: &'a mut Domain<D>,
        cut: &'a CutBodies<D>,
        s: &'a mut State<D>,
        modes: &'a mut Modes,
        motions: &'a mut [BodyMotion],
        sums: &'a mut Sums,
        dt: f64,
    ) -> Result<PressureStep<'a, D>> {
        modes.set(domain, cut, &s.bodies, motions)?;
        let inverse_density = modes::hold(domain, cut, &s.bodies, motions)?;
        let Domain { session, grid, boundaries, projection, drive, .. } = domain;
        let session = &*session;
        let beta = &cut.beta;
        let drive = drive.as_ref().zip(s.drive.as_mut());
        let driving =
            drive.map(|(drive, force)| Driving { drive, force, beta, inverse_density, session });
        let coupled = CoupledFaces::new(cut, &mut s.faces, &mut s.bodies);
        let oblong = modes.oblong();
        let following = Following { session, coupled, driving, oblong, motions, sums };
        Ok(PressureStep { grid, boundaries, projection, p: &mut s.p, dt, following })
    }

    /// C-HSMAC (13-15), the bodies with it; `accuracy` as in [`Projection::project`]. Collective.
    ///
    /// # Errors
    /// As there.
    pub fn solve(&mut self, accuracy: Accuracy) -> Result<Projected> {
        let PressureStep { grid, boundaries, projection, p, dt, following } = self;
        let beta = &following.coupled.cut().beta;
        let projected = projection.project(grid, boundaries, beta, *dt, p, following, accuracy)?;
        following.tell()?;
        Ok(projected)
    }

    /// The bodies.
    pub fn bodies(&self) -> &[Body] {
        self.following.coupled.bodies()
    }

    /// Their motions.
    pub fn motions(&self) -> &[BodyMotion] {
        self.following.motions
    }

    /// The step (s).
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Gives all free bodies, and their faces, impulses of contacts.
    pub fn apply(&mut self, impulses: &Impulses, given: &[Impulse]) {
        let Following { coupled, motions, .. } = &mut self.following;
        for (k, impulse) in given.iter().enumerate() {
            let Some(freedom) = coupled.bodies()[k].freedom() else { continue };
            let change = freedom.along(&impulse.linear) / motions[k].effective_mass;
            coupled.change(k, &change, &impulses.turned_by(k, &impulse.angular));
        }
    }
}

/// The bodies while the pressure is found.
struct Following<'a, const D: usize> {
    session: &'a Session,
    coupled: CoupledFaces<'a, D>,
    driving: Option<Driving<'a, D>>,
    oblong: &'a [u32],
    motions: &'a mut [BodyMotion],
    sums: &'a mut Sums,
}

impl<const D: usize> Coupled<D> for Following<'_, D> {
    fn faces(&mut self) -> &mut VectorField<D> {
        self.coupled.faces()
    }

    fn begin(&mut self, grid: &Grid<D>, dt: f64) -> Result<()> {
        let Some(driving) = &mut self.driving else { return Ok(()) };
        let change = driving.follow(grid, dt, self.coupled.faces())?;
        if change == Vector3::zeros() {
            return Ok(());
        }
        let drive = driving.drive;
        for k in 0..self.motions.len() {
            let force =
                drive.on_body(&change, 1.0).component_mul(&self.motions[k].displaced_volume);
            apply_force(&mut self.coupled, &mut self.motions[k], k, &force, dt);
        }
        Ok(())
    }

    fn follow(&mut self, grid: &Grid<D>, dt: f64, phi: &[f64]) -> Result<()> {
        let cut = self.coupled.cut();
        let own = |k: usize| super::load::pressure_force(cut, grid, k, phi);
        let Sums { vectors, messages, .. } = &mut *self.sums;
        let forces = vectors.sum_here(self.session, &cut.reach, messages, own)?;
        for k in cut.reach.here() {
            apply_force(&mut self.coupled, &mut self.motions[k], k, &forces[k], dt);
        }
        if !self.oblong.is_empty() {
            self.follow_turning(grid, dt, phi)?;
        }
        self.begin(grid, dt)
    }
}

impl<const D: usize> Following<'_, D> {
    /// Gives the bodies that pressure turns its torque over the step `dt` (s).
    fn follow_turning(&mut self, grid: &Grid<D>, dt: f64, phi: &[f64]) -> Result<()> {
        let cut = self.coupled.cut();
        let bodies = self.coupled.bodies();
        let own = |k: usize| super::load::pressure_torque(cut, grid, &bodies[k], k, phi);
        let Sums { vectors, messages, .. } = &mut *self.sums;
        let torques = vectors.sum_here(self.session, &cut.reach, messages, own)?;
        for k in self.oblong.iter().map(|k| *k as usize) {
            let torque = torques[k];
            let motion = &mut self.motions[k];
            motion.pressure.torque += torque;
            if self.coupled.bodies()[k].freedom().is_some() {
                self.coupled.change(
                    k,
                    &Vector3::zeros(),
                    &(motion.inverse_inertia * (dt * torque)),
                );
            }
        }
        Ok(())
    }
}

impl<const D: usize> Following<'_, D> {
    /// Sends the velocities of the bodies after the solve, and their loads by pressure, from the
    /// ranks that bodies reach to all ranks. Collective.
    fn tell(&mut self) -> Result<()> {
        if self.session.size() == 1 {
            return Ok(());
        }
        let Following { session, coupled, motions, sums, .. } = self;
        let reach = &coupled.cut().reach;
        let bodies = coupled.bodies();
        let own = |k: usize| Response {
            motion: bodies[k].rigid_velocity(),
            pressure: motions[k].pressure,
        };
        let Sums { responses, messages, .. } = &mut **sums;
        let responses = responses.tell_all(session, reach, messages, own)?;
        for (k, response) in responses.iter().enumerate() {
            coupled.set(k, &response.motion);
            motions[k].pressure = response.pressure;
        }
        Ok(())
    }
}

/// Gives a body another force by pressure (N) over the step `dt` (s).
fn apply_force<const D: usize>(
    coupled: &mut CoupledFaces<D>,
    motion: &mut BodyMotion,
    k: usize,
    force: &Vector3<f64>,
    dt: f64,
) {
    motion.pressure.force += force;
    if let Some(freedom) = coupled.bodies()[k].freedom() {
        let change = freedom.along(force) * (dt / motion.effective_mass);
        coupled.change(k, &change, &Vector3::zeros());
    }
}
