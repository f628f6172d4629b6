//! How the fluid gives way at once: at the start, and to bodies that come in with a velocity of
//! their own.
//!
//! ```text
//!   U = H q + m U_b.n        div( (1/rho) grad P ) - sum_k (dV/m_k) j_k (j_k.P) = D
//!   U -= H grad P/rho,   q -= grad P/rho,   u -= (grad P/rho of the cell),
//!              V_k += (dV/m_k) sum_c P_c j_c
//! ```
//! P is the impulse of a pressure (Pa s), which then is dropped: that of the flow goes on as it
//! was. At the start bodies have their velocities, and the fluid is set off with them. To one that
//! comes in later the fluid gives way at the cost of its momentum, and the free bodies beside it
//! follow: it goes on with what its mass is of that and the added mass. Left to a step's stages,
//! the jump of its surface would turn a light body back.

use super::exchanged::ExchangedMomentum;
use super::load::cell_momenta;
use super::pressure_step::PressureStep;
use super::{Sharp, history};
use crate::Result;
use crate::domain::Domain;
use crate::grid::VectorField;
use crate::kernels::faces;
use crate::method::Method;
use crate::particles::Load;
use crate::state::{BeforeForcing, State};
use nalgebra::{Matrix3, Vector3};

impl<const D: usize> Sharp<D> {
    /// Lets the fluid give way to the bodies of these numbers, which come in; all free ones follow
    /// the impulse. Collective.
    ///
    /// # Errors
    /// When the projection fails.
    pub fn give_way(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        new: impl Fn(usize) -> bool,
    ) -> Result<()> {
        let p = s.p.clone();
        let drive = s.drive;
        // What the last surface changed of the cells, and the last step of the faces, stays what it
        // was.
        shift(&mut history(&mut s.surfaces)?.before_forcing, -1.0, &s.u);
        add(&mut s.faces_before, -1.0, &s.faces);
        for (k, cut) in self.cut.bodies.each().filter(|(k, _)| new(s.bodies[*k].id)) {
            cut.cover_faces(&s.bodies[k], &mut s.faces);
        }
        domain.boundaries.set_faces(&mut s.faces);
        // No force of a step has made what is inside, before or after.
        self.take_inside(domain, s, |_| true)?;
        for (motion, body) in self.motions.iter_mut().zip(&s.bodies) {
            motion.inertia = body.mass();
            motion.pressure = Load::default();
            motion.turns = body
                .freedom()
                .map_or_else(Matrix3::zeros, |freedom| body.inertia().inverse(&freedom));
        }
        self.find_displaced(domain, &s.bodies)?;
        self.impulsive_start(domain, s, true)?;
        self.defer(domain, s)?;
        add(&mut s.faces_before, 1.0, &s.faces);
        let surfaces = history(&mut s.surfaces)?;
        add(&mut surfaces.correction, 1.0, &self.acceleration.faces);
        shift(&mut surfaces.before_forcing, 1.0, &s.u);
        (s.p, s.drive) = (p, drive);
        self.find_acceleration(domain, s);
        self.take_inside(domain, s, |_| true)
    }

    /// Defers what the fluid lost by an impulse beyond what that gave to the free bodies, as steps
    /// do. Collective.
    fn defer(&mut self, domain: &Domain<D>, s: &mut State<D>) -> Result<()> {
        let momenta =
            cell_momenta(domain, &self.cut, &self.work.exchanged, s, &mut self.work.sums)?;
        let histories = history(&mut s.surfaces)?.bodies.iter_mut().zip(momenta);
        for (((history, momentum), body), motion) in histories
            .zip(&s.bodies)
            .zip(&self.motions)
            .filter(|((_, body), _)| body.freedom().is_some())
        {
            let (inside, _) = momentum.whole(domain.fluid.density, body);
            let lost = inside
                - history.inside.0
                - momentum.exchanged.linear
                - domain.unfelt(&s.drive, body.volume());
            history.undelivered += lost - motion.pressure.force;
        }
        Ok(())
    }

    /// Projects the faces over a second, so that the potential in the pressure's place is its
    /// impulse, which corrects the cells; their ghost cells are set. Bodies keep their velocity,
    /// or `follow`. Collective.
    pub(super) fn impulsive_start(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        follow: bool,
    ) -> Result<()> {
        s.p.fill(0.0);
        // A drive that holds a velocity does so here as well.
        s.drive = domain.drive.filter(|drive| drive.held().is_some()).map(|_| Vector3::zeros());
        if follow {
            let Sharp { cut, modes, motions, work, .. } = self;
            let sums = &mut work.sums;
            PressureStep::new(domain, cut, s, (modes, motions, sums), 1.0)?.solve(None)?;
        } else {
            domain.project(&self.cut.beta, s, 1.0)?;
        }
        // Outflows have no impulse, whatever comes in there.
        domain.boundaries.fill_increment(&mut s.p)?;
        self.acceleration.of_pressure(domain, &mut self.cut, &s.bodies, &s.p, s.drive);
        let Sharp { cut, acceleration, work, .. } = self;
        work.exchanged.fill(ExchangedMomentum::default());
        faces::add_to_cells(&domain.grid, 1.0, &acceleration.faces, &mut s.u);
        cut.add_cut_cells(domain, 1.0, Some(&mut work.exchanged), &mut s.u);
        domain.boundaries.fill_velocity(&mut s.u)?;
        cut.set_ghost_cells(domain, &s.bodies, false, Some(&mut work.exchanged), &mut s.u);
        domain.boundaries.fill_velocity(&mut s.u)
    }
}

/// Adds a multiple of one field to another, which may be empty.
fn add<const D: usize>(to: &mut VectorField<D>, factor: f64, from: &VectorField<D>) {
    to.iter_mut()
        .zip(from)
        .for_each(|(to, from)| to.iter_mut().zip(from).for_each(|(to, from)| *to += factor * from));
}

/// Adds a multiple of the velocity `u` (m/s) of the cells to what they had before the surface.
fn shift<const D: usize>(before_forcing: &mut [BeforeForcing<D>], factor: f64, u: &VectorField<D>) {
    for BeforeForcing { cell, velocity } in before_forcing {
        velocity
            .iter_mut()
            .zip(u)
            .for_each(|(velocity, u)| *velocity += factor * u[*cell as usize]);
    }
}
