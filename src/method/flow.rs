//! The flow of one fluid, or of the mixture, in the order of the paper: the whole step where there
//! are no bodies.
//!
//! ```text
//!   U = I( u* + (1 - t) dt M a ) + t dt a
//!              I: cells to faces, M: faces to cells, a: acceleration by the last pressure
//! ```
//! With `t = 1`, as (8) is printed, a flow loses `dt <a, (1 - I M) a>` of its energy per unit time,
//! of order dt h^2; without bodies t is 0.2 and less, since some of the pressure beyond the means
//! has to fade; I is of four cells there, `(-1, 9, 9, -1)/16`. The pressure at the start is that of
//! the first moment.

use super::momentum::MixtureProperties;
use super::prediction::{Prediction, Walls, Within};
use super::{Method, MethodKind};
use crate::Result;
use crate::clock::Stage;
use crate::domain::Domain;
use crate::force::Forces;
use crate::grid::VectorField;
use crate::kernels::diffusion;
use crate::kernels::faces::{self, FaceCoefficient};
use crate::numerics::PRESSURE_TIME;
use crate::petsc::LogStage;
use crate::poisson::pressure::Projected;
use crate::scheme::Scheme;
use crate::state::State;
use nalgebra::Vector3;

/// Step that finds the first pressure, as a part of the time in which flow or viscosity crosses a
/// cell.
const START: f64 = 0.1;

/// A flow that fills all cells.
pub struct Flow<const D: usize> {
    /// The fluid or mixture that flows.
    pub mixture: MixtureProperties,
    /// `1/rho` on faces (m3/kg).
    pub beta: FaceCoefficient<D>,
    /// (7).
    prediction: Prediction<D>,
    /// Whether cells take (16) as printed.
    pub cell_gradient: bool,
    /// Acceleration by pressure and drive on faces (m/s2), of the pressure at the start of the step
    /// and, after (16), at its end.
    pub acceleration: VectorField<D>,
    /// The largest part of the last pressure's acceleration that faces have at once, in place of
    /// the mean of the cells', which is of four; `None`: all of it, and means of two cells, as (8)
    /// is printed.
    pub own: Option<f64>,
    /// Solid fraction of the cells, ghosts filled; `None` where the drive acts on bodies as well,
    /// or there is none.
    pub solid: Option<Vec<f64>>,
}

/// The sides of the box alone.
pub struct NoBodies;

impl<const D: usize> Walls<D> for NoBodies {
    /// The faces take it by themselves.
    const PRESSURE: f64 = 0.0;

    fn finish(
        &mut self,
        domain: &mut Domain<D>,
        _: &State<D>,
        within: Within,
        _: f64,
        u: &mut VectorField<D>,
    ) -> Result<()> {
        if !matches!(within, Within::End) {
            domain.boundaries.fill_velocity(u)?;
            domain.clock.lap(Stage::Ghosts);
        }
        Ok(())
    }
}

/// The step where there are no bodies.
impl<const D: usize> Method<D> for Flow<D> {
    fn kind(&self) -> MethodKind {
        MethodKind::Flow
    }

    fn step(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<Projected> {
        // (7) u* without pressure
        self.predict_cells(domain, s, dt, &mut NoBodies)?;
        // (8) U = mean of u* - dt/rho dp^n/dn
        self.predict_faces(domain, s, dt)?;
        // (13-15) C-HSMAC: |D| < D0
        let projected = self.project(domain, s, dt)?;
        // (16) u = u* - dt/rho grad p
        self.correct_cells(domain, s, dt)?;
        s.count(dt);
        Ok(projected)
    }

    fn start(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        self.start_velocity(domain, s)?;
        self.start_pressure(domain, s)
    }

    fn resume(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        _: Option<Box<dyn Method<D>>>,
    ) -> Result<()> {
        domain.projection.assemble(&domain.grid, &self.beta)?;
        self.find_acceleration(domain, s);
        Ok(())
    }

    /// The acceleration by pressure and drive on faces, as cells and the next step's
    /// stages use it.
    fn find_acceleration(&mut self, domain: &Domain<D>, s: &State<D>) {
        faces::acceleration(&domain.grid, &self.beta, &s.p, &mut self.acceleration);
        domain.boundaries.extrapolate_to_closed_faces(&mut self.acceleration);
        let Some(force) = s.drive else { return };
        for (axis, a) in
            self.acceleration.iter_mut().enumerate().filter(|(axis, _)| force[*axis] != 0.0)
        {
            for f in domain.grid.face_rows(axis).flatten() {
                let solid = self
                    .solid
                    .as_ref()
                    .map_or(0.0, |x| 0.5 * (x[f - domain.grid.stride[axis]] + x[f]));
                a[f] += (1.0 - solid) * force[axis] * self.beta.at(axis, f);
            }
        }
    }

    fn mixture(&self) -> &MixtureProperties {
        &self.mixture
    }

    fn beta(&self) -> &FaceCoefficient<D> {
        &self.beta
    }

    fn scheme(&self) -> Scheme {
        self.prediction.scheme
    }
}

impl<const D: usize> Flow<D> {
    /// A flow on the grid of a domain. [`Method::start`] or [`Method::resume`] comes next.
    pub fn new(
        domain: &Domain<D>,
        mixture: MixtureProperties,
        prediction: Prediction<D>,
        cell_gradient: bool,
    ) -> Flow<D> {
        let grid = &domain.grid;
        Flow {
            beta: FaceCoefficient::new(grid, &mixture.density),
            mixture,
            prediction,
            cell_gradient,
            acceleration: grid.vector_field(),
            own: None,
            solid: None,
        }
    }

    /// (7) with the last pressure in the stages and not in u*. Collective.
    pub fn predict_cells(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
        walls: &mut impl Walls<D>,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Prediction)?;
        domain.boundaries.fill_velocity(&mut s.u)?;
        domain.clock.lap(Stage::Ghosts);
        let Flow { prediction, mixture, acceleration, .. } = self;
        prediction.predict(domain, s, mixture, acceleration, dt, walls)?;
        Ok(())
    }

    /// (8). Collective.
    pub fn predict_faces(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Prediction)?;
        // Time (s) over which the cells keep the last pressure's acceleration meanwhile.
        let kept = (1.0 - self.own_part(domain, dt)) * dt;
        if kept > 0.0 {
            faces::add_to_cells(&domain.grid, kept, &self.acceleration, &mut s.u);
        }
        domain.boundaries.fill_velocity(&mut s.u)?;
        domain.clock.lap(Stage::Ghosts);
        if !s.faces_before[0].is_empty() {
            std::mem::swap(&mut s.faces, &mut s.faces_before);
        }
        faces::predict(
            &domain.grid,
            &s.u,
            self.own.is_some(),
            dt - kept,
            &self.acceleration,
            &mut s.faces,
        );
        domain.boundaries.set_faces(&mut s.faces);
        if kept > 0.0 {
            faces::add_to_cells(&domain.grid, -kept, &self.acceleration, &mut s.u);
        }
        domain.clock.lap(Stage::Faces);
        Ok(())
    }

    /// Part of the last pressure's acceleration that faces have at once in a step of `dt` (s), in
    /// place of the mean of the cells'.
    fn own_part(&self, domain: &Domain<D>, dt: f64) -> f64 {
        let Some(most) = self.own else { return 1.0 };
        let h = domain.grid.h.iter().copied().fold(f64::INFINITY, f64::min);
        let diffusion = domain.fluid.viscosity / domain.fluid.density * dt / (h * h);
        (PRESSURE_TIME / diffusion).min(most)
    }

    /// (13-15). Collective.
    pub fn project(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<Projected> {
        let projected = domain.project(&self.beta, s, dt)?;
        domain.clock.lap(Stage::Pressure);
        Ok(projected)
    }

    /// (16).
    pub fn correct_cells(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Correction)?;
        self.find_acceleration(domain, s);
        if self.cell_gradient {
            faces::add_cell_gradient(&domain.grid, &self.mixture.density, dt, &s.p, &mut s.u);
            self.drive_cells(domain, s, dt);
        } else {
            faces::add_to_cells(&domain.grid, dt, &self.acceleration, &mut s.u);
        }
        domain.clock.lap(Stage::Faces);
        Ok(())
    }

    /// Adds what the drive gives the cells over `dt` (s) where they take (16) as printed.
    fn drive_cells(&self, domain: &Domain<D>, s: &mut State<D>, dt: f64) {
        let Some(force) = s.drive else { return };
        for (axis, u) in s.u.iter_mut().enumerate().filter(|(axis, _)| force[*axis] != 0.0) {
            for c in domain.grid.rows().flatten() {
                let fluid = 1.0 - self.solid.as_ref().map_or(0.0, |solid| solid[c]);
                u[c] += dt * fluid * force[axis] / self.mixture.density.at(c);
            }
        }
    }

    /// Makes the velocities through faces divergence-free to D0, from the cells' `u`, and takes
    /// what that needs out of these. The pressure is left zero. Collective.
    pub fn start_velocity(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        domain.projection.assemble(&domain.grid, &self.beta)?;
        s.p.fill(0.0);
        domain.boundaries.fill_velocity(&mut s.u)?;
        self.acceleration.iter_mut().for_each(|f| f.fill(0.0));
        faces::predict(
            &domain.grid,
            &s.u,
            self.own.is_some(),
            0.0,
            &self.acceleration,
            &mut s.faces,
        );
        domain.boundaries.set_faces(&mut s.faces);
        // Over a second, so that the potential is the pressure's impulse; it corrects the cells and
        // is dropped, and so is that of a drive which holds a velocity.
        let drive = domain.drive.filter(|drive| drive.held().is_some());
        s.drive = drive.map(|_| Vector3::zeros());
        domain.project(&self.beta, s, 1.0)?;
        self.find_acceleration(domain, s);
        faces::add_to_cells(&domain.grid, 1.0, &self.acceleration, &mut s.u);
        s.p.fill(0.0);
        s.drive = domain.drive_at_start();
        self.find_acceleration(domain, s);
        domain.boundaries.fill_velocity(&mut s.u)
    }

    /// The pressure that [`Flow::start_velocity`] left zero, from a short step whose velocities are
    /// dropped. Collective.
    ///
    /// # Errors
    /// When that step fails.
    fn start_pressure(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        let mut fastest = [faces::courant_rate(&domain.grid, &s.faces, false)];
        domain.session.max(&mut fastest)?;
        let viscous = diffusion::limit_rate(
            &domain.grid.h,
            domain.fluid.viscosity / domain.fluid.density,
            false,
        );
        let mut driven = [domain.forces.as_ref().map_or(0.0, Forces::largest)];
        domain.session.max(&mut driven)?;
        let driven = s.drive.map_or(driven[0], |force| driven[0].max(force.norm()));
        let rate = fastest[0].max(viscous);
        if rate == 0.0 || driven == 0.0 && fastest[0] == 0.0 {
            // Nothing moves yet.
            return Ok(());
        }
        let dt = START / rate;
        let kept = (s.u.clone(), s.faces.clone(), s.faces_before.clone());
        self.predict_cells(domain, s, dt, &mut NoBodies)?;
        self.predict_faces(domain, s, dt)?;
        self.project(domain, s, dt)?;
        (s.u, s.faces, s.faces_before) = kept;
        domain.set_time(s.time);
        self.find_acceleration(domain, s);
        Ok(())
    }
}
