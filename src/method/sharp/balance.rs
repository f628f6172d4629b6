//! The balance of momentum over a step: that of the fluid outside the bodies, of the free bodies,
//! and their undelivered impulses,
//!
//! ```text
//!   M = sum_c (1 - alpha) rho u dV + sum_k (m_k V_k + undelivered_k)
//!   M^(n+1) - M^n = gravity + drive + contacts - force on held bodies + boundary
//! ```
//! The boundary's impulse is that of pressure, viscosity and flow on the sides of the box
//! ([`crate::kernels::boundary`]), taken from the fields there in every stage. What the two sides
//! of this line differ by is the error.

use super::body_motion::BodyMotion;
use super::rigid::RigidStep;
use crate::Result;
use crate::clock::Stage;
use crate::domain::Domain;
use crate::grid::{simd, total};
use crate::kernels::boundary::{self, Sides};
use crate::particles::Body;
use crate::state::{Balance, Impulses, State, SurfaceHistory};
use nalgebra::{Matrix3x4, Vector3};

/// The momentum of the cells of this rank (kg m/s).
fn cells_momentum<const D: usize>(domain: &Domain<D>, s: &State<D>) -> Vector3<f64> {
    let sum = simd(
        #[inline(always)]
        || {
            let mut sum = Vector3::zeros();
            for (a, u) in s.u.iter().enumerate() {
                for row in domain.grid.rows() {
                    let u = &u[row];
                    sum[a] += total(
                        u.len(),
                        #[inline(always)]
                        |i| u[i],
                    );
                }
            }
            sum
        },
    );
    domain.fluid.density * domain.grid.cell_volume() * sum
}

/// The momentum of everything in the box (kg m/s), of which all cells have `cells`.
fn total_momentum<const D: usize>(s: &mut State<D>, cells: Vector3<f64>) -> Result<Vector3<f64>> {
    let histories = &SurfaceHistory::of(&mut s.surfaces)?.bodies;
    let beside = s.bodies.iter().zip(histories).map(|(body, history)| {
        let own =
            if body.freedom().is_some() { body.mass() * body.velocity } else { Vector3::zeros() };
        own + history.undelivered - history.inside.0
    });
    Ok(cells + beside.sum::<Vector3<f64>>())
}

/// Starts the balance, where one is kept. Collective.
///
/// # Errors
/// When messages between ranks fail.
pub fn begin<const D: usize>(domain: &Domain<D>, s: &mut State<D>) -> Result<()> {
    if s.balance.is_some() {
        let mut cells = cells_momentum(domain, s);
        domain.session.sum(cells.as_mut_slice())?;
        let momentum = total_momentum(s, cells)?;
        s.balance = Some(Balance { momentum, ..Balance::default() });
    }
    Ok(())
}

/// Closes the balance of the step `dt` (s), where one is kept, in whose stages the sides of
/// this rank pushed the fluid with the forces `sides`. Collective.
///
/// # Errors
/// When messages between ranks fail.
pub fn close<const D: usize>(
    domain: &mut Domain<D>,
    s: &mut State<D>,
    rigid: &RigidStep,
    sides: Sides,
    dt: f64,
) -> Result<()> {
    let Some(before) = s.balance else { return Ok(()) };
    let pressure = boundary::pressure(&domain.grid, &domain.boundaries, &s.p);
    let [flow, shear] = [0, 1].map(|k| dt * sides.column(k));
    let cells = cells_momentum(domain, s);
    let mut sums = Matrix3x4::from_columns(&[flow, shear, dt * pressure, cells]);
    domain.session.sum(sums.as_mut_slice())?;
    let [flow, shear, pressure, cells] = [0, 1, 2, 3].map(|k| sums.column(k).into_owned());
    let momentum = total_momentum(s, cells)?;
    let impulses = Impulses {
        drive: dt * domain.driving_force(s),
        pressure: pressure - dt * rigid.force_of_filled,
        shear,
        flow,
        ..impulses_of_bodies(domain, s, rigid, dt)
    };
    s.balance = Some(Balance::close(
        [before.momentum, momentum],
        impulses,
        angular_error(s, &rigid.motions, dt),
    ));
    domain.clock.lap(Stage::Force);
    Ok(())
}

/// Impulse over the step `dt` (s) of gravity and contacts on the free bodies, less that of the
/// fluid on held ones, and on free ones along the directions in which they are held (N s).
fn impulses_of_bodies<const D: usize>(
    domain: &Domain<D>,
    s: &State<D>,
    rigid: &RigidStep,
    dt: f64,
) -> Impulses {
    let mut sums = Impulses { contacts: -dt * rigid.gap_force_on_fixed, ..Impulses::default() };
    for (body, exchange) in s.bodies.iter().zip(&s.exchange) {
        let Some(freedom) = body.freedom() else {
            sums.held -= dt * exchange.momentum;
            continue;
        };
        let weight = (body.mass() - domain.fluid.density * body.volume()) * domain.fluid.gravity;
        sums.gravity += freedom.along(&(dt * weight));
        sums.contacts += freedom.along(&(dt * exchange.contact));
        sums.held -= dt * (exchange.momentum - freedom.along(&exchange.momentum));
    }
    sums
}

/// Angular momentum that the fluid lost about the free bodies' centres over the step `dt` (s) less
/// that by the torque, its norm summed over them (kg m2/s).
fn angular_error<const D: usize>(s: &State<D>, motions: &[BodyMotion], dt: f64) -> f64 {
    let bodies = s.bodies.iter().zip(motions);
    let force_defect = |(body, motion): (&Body, &BodyMotion)| {
        body.freedom()
            .map_or(0.0, |f| f.about(&(motion.angular_momentum_lost - dt * motion.torque())).norm())
    };
    bodies.map(force_defect).sum()
}
