//! Impulsive start: the fluid gives way at once, at the start and to bodies that come in with a
//! velocity of their own.
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

use super::acceleration::PressureAcceleration;
use super::cut::CutBodies;
use super::modes::Modes;
use super::pressure_step::PressureStep;
use super::rigid::RigidStep;
use crate::Result;
use crate::domain::Domain;
use crate::grid::VectorField;
use crate::kernels::faces;
use crate::particles::{Impulse, Load, velocities};
use crate::poisson::pressure::Accuracy;
use crate::state::{BeforeForcing, State, SurfaceHistory};
use nalgebra::{Matrix3, Vector3};

/// Lets the fluid give way to the bodies of these numbers, which come in; all free ones follow the
/// impulse. Collective.
///
/// # Errors
/// When the projection fails.
pub fn apply<const D: usize>(
    domain: &mut Domain<D>,
    s: &mut State<D>,
    cut: &mut CutBodies<D>,
    acceleration: &mut PressureAcceleration<D>,
    rigid: &mut RigidStep,
    modes: &mut Modes,
    ids: &[usize],
) -> Result<()> {
    let p = s.p.clone();
    let drive = s.drive;
    // The changes of the cells by the last forcing, and of the faces by the last step, stay what
    // they were.
    shift(&mut SurfaceHistory::of(&mut s.surfaces)?.before_forcing, -1.0, &s.u);
    add(&mut s.faces_before, -1.0, &s.faces);
    for (k, cut) in cut.bodies.each().filter(|(k, _)| ids.contains(&s.bodies[*k].id)) {
        cut.cover_faces(&s.bodies[k], &mut s.faces);
    }
    domain.boundaries.set_faces(&mut s.faces);
    // No force of a step has made what is inside, before or after.
    rigid.take_inside(domain, s, cut, |_| true)?;
    for (motion, body) in rigid.motions.iter_mut().zip(&s.bodies) {
        motion.effective_mass = body.mass();
        motion.pressure = Load::default();
        motion.inverse_inertia =
            body.freedom().map_or_else(Matrix3::zeros, |freedom| body.inertia().inverse(&freedom));
    }
    rigid.find_displaced(domain, &s.bodies, cut)?;
    project(domain, s, cut, acceleration, rigid, Some(modes))?;
    rigid.defer(domain, s, cut)?;
    add(&mut s.faces_before, 1.0, &s.faces);
    let surfaces = SurfaceHistory::of(&mut s.surfaces)?;
    add(&mut surfaces.correction, 1.0, &acceleration.faces);
    shift(&mut surfaces.before_forcing, 1.0, &s.u);
    s.p = p;
    s.drive = drive;
    acceleration.of_pressure(domain, cut, &s.bodies, &s.p, s.drive);
    rigid.take_inside(domain, s, cut, |_| true)
}

/// Projects the faces over a second, so that the potential in the pressure's place is its impulse,
/// which corrects the cells; their ghost cells are set. Bodies keep their velocity, or follow with
/// their modes. Collective.
///
/// # Errors
/// When the projection fails.
pub fn project<const D: usize>(
    domain: &mut Domain<D>,
    s: &mut State<D>,
    cut: &mut CutBodies<D>,
    acceleration: &mut PressureAcceleration<D>,
    rigid: &mut RigidStep,
    follow: Option<&mut Modes>,
) -> Result<()> {
    let RigidStep { motions, sums, exchanged, .. } = rigid;
    s.p.fill(0.0);
    // A drive that holds a velocity does so here as well.
    s.drive = domain.drive.filter(|drive| drive.held().is_some()).map(|_| Vector3::zeros());
    if let Some(modes) = follow {
        PressureStep::new(domain, cut, s, modes, motions, sums, 1.0)?.solve(Accuracy::Full)?;
    } else {
        domain.project(&cut.beta, s, 1.0)?;
    }
    // Outflows have no impulse, whatever comes in there.
    domain.boundaries.fill_increment(&mut s.p)?;
    acceleration.of_pressure(domain, cut, &s.bodies, &s.p, s.drive);
    exchanged.fill(Impulse::default());
    faces::add_to_cells(&domain.grid, 1.0, &acceleration.faces, &mut s.u);
    super::acceleration::add_cut_cells(cut, domain, 1.0, Some(exchanged), &mut s.u);
    domain.boundaries.fill_velocity(&mut s.u)?;
    cut.set_ghost_cells(domain, velocities(&s.bodies), false, Some(exchanged), &mut s.u);
    domain.boundaries.fill_velocity(&mut s.u)
}

/// Adds a multiple of one field to another, which may be empty.
fn add<const D: usize>(to: &mut VectorField<D>, factor: f64, from: &VectorField<D>) {
    to.iter_mut()
        .zip(from)
        .for_each(|(to, from)| to.iter_mut().zip(from).for_each(|(to, from)| *to += factor * from));
}

/// Adds a multiple of the velocity `u` (m/s) of the cells to their velocities before forcing.
fn shift<const D: usize>(before_forcing: &mut [BeforeForcing<D>], factor: f64, u: &VectorField<D>) {
    for BeforeForcing { cell, velocity } in before_forcing {
        velocity
            .iter_mut()
            .zip(u)
            .for_each(|(velocity, u)| *velocity += factor * u[*cell as usize]);
    }
}
