//! The budget of energy over a step.
//!
//! ```text
//!   body     m (V' - V) = F dt + G dt + J      its kinetic energy gains F.<V> dt by the fluid, G.<V> dt by gravity and the rest
//!                                              by contacts; <V> = (V + V')/2, or the way over dt where contacts bend it
//!   fluid    gains -F.<V> dt of free and of prescribed bodies, the work of the sides of the box, less
//!            viscous = dt mu sum over faces |u_c - u_(c-1)|^2/h^2 dV (1 - alpha)
//!   contacts what all bodies gain of them = what springs release and moving walls give, less what dampers, friction, films take
//! ```
//! and likewise for spins and torques. What is missing is the method's own.

use crate::Result;
use crate::contact::{Contacts, Impulse};
use crate::domain::Domain;
use crate::grid::{Grid, VectorField, simd, total};
use crate::kernels::border;
use crate::method::Method;
use crate::particles::{Body, nearest_image};
use crate::state::{EnergyBudget, State};
use nalgebra::Vector3;

/// How a body moved at the start of a step.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    centre: Vector3<f64>,
    velocity: Vector3<f64>,
    spin: Vector3<f64>,
    energy: f64,
}

impl Motion {
    /// That of a body now.
    pub fn of(body: &Body) -> Motion {
        Motion { centre: body.centre, velocity: body.velocity, spin: body.spin, energy: kinetic(body) }
    }
}

/// Starts a budget with the state as it is. Collective.
pub fn start<const D: usize>(domain: &Domain<D>, s: &mut State<D>, method: &Method<D>) -> Result<()> {
    s.energy = EnergyBudget { bodies: of_bodies(&s.bodies), ..EnergyBudget::default() };
    let mut fluid = [of_fluid(domain, &s.u, method).0];
    domain.session.sum(&mut fluid)?;
    s.energy.fluid = fluid[0];
    s.energy.start = s.energy.total();
    Ok(())
}

/// Closes the budget of the last step, at whose start the bodies had the motions `before`. Ghosts of the velocity filled.
/// Collective.
pub fn close<const D: usize>(
    domain: &Domain<D>,
    s: &mut State<D>,
    before: &[Motion],
    method: &Method<D>,
) -> Result<()> {
    let contacts = method.contacts();
    let (dt, last) = (s.dt, s.energy);
    let (fluid, viscous) = of_fluid(domain, &s.u, method);
    let mut sums = [
        fluid,
        dt * viscous,
        dt * border::power(
            &domain.grid,
            &domain.boundaries,
            domain.fluid.density,
            domain.fluid.viscosity,
            &s.u,
            &s.faces,
            &s.p,
        ),
    ];
    domain.session.sum(&mut sums)?;
    let [fluid, viscous, sides] = sums;
    let worked = Work::of(domain, s, before, contacts);
    let springs = contacts.map_or(0.0, |c| c.stored(&s.bodies));
    let walls = contacts.map_or(0.0, Contacts::wall_work);
    let slid = contacts.map_or(0.0, Contacts::slid);
    let mut e = EnergyBudget { fluid, bodies: of_bodies(&s.bodies), springs, ..last };
    e.gravity += worked.gravity;
    e.borders += sides + walls;
    e.prescribed += worked.prescribed;
    e.viscous += viscous;
    e.friction += slid;
    e.contacts += walls - worked.contacts - (springs - last.springs) - slid;
    e.method = e.start + e.gravity + e.borders + e.prescribed - e.viscous - e.contacts - e.friction - e.total();
    s.energy = e;
    Ok(())
}

/// Kinetic energy of a body (J).
fn kinetic(body: &Body) -> f64 {
    0.5 * (body.mass() * body.velocity.norm_squared() + body.spin.dot(&body.inertia().of(&body.spin)))
}

/// Kinetic energy of the free bodies (J).
fn of_bodies(bodies: &[Body]) -> f64 {
    bodies.iter().filter(|b| b.freedom().is_some()).fold(0.0, |sum, body| sum + kinetic(body))
}

/// The work of a step on and by the bodies (J).
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    gravity: f64,
    prescribed: f64,
    /// On all of them.
    contacts: f64,
}

impl Work {
    fn of<const D: usize>(domain: &Domain<D>, s: &State<D>, before: &[Motion], contacts: Option<&Contacts>) -> Work {
        let mut work = Work::default();
        for (k, (body, before)) in s.bodies.iter().zip(before).enumerate() {
            let impulse = contacts.map(|c| c.impulses()[k]).unwrap_or_default();
            let struck = impulse != Impulse::default();
            let way = if struck {
                nearest_image(&before.centre, &body.centre, &domain.periods())
            } else {
                0.5 * s.dt * (before.velocity + body.velocity)
            };
            let turn = 0.5 * s.dt * (before.spin + body.spin);
            let fluid = s.exchange[k].held().dot(&way) + s.exchange[k].momentum_torque.dot(&turn);
            if body.freedom().is_some() {
                let weight = (body.mass() - domain.fluid.density * body.volume()) * domain.fluid.gravity;
                work.gravity += weight.dot(&way);
                if struck {
                    work.contacts += kinetic(body) - before.energy - fluid - weight.dot(&way);
                }
            } else {
                let given = (impulse.linear.dot(&way) + impulse.angular.dot(&turn)) / s.dt;
                work.contacts += given;
                work.prescribed -= fluid + given;
            }
        }
        work
    }
}

/// This rank's kinetic energy of the fluid outside the bodies (J), and what viscosity takes of it (W).
fn of_fluid<const D: usize>(domain: &Domain<D>, u: &VectorField<D>, method: &Method<D>) -> (f64, f64) {
    let grid = &domain.grid;
    let (mut squares, mut slopes) = sums(grid, u);
    method.with_overlaps(|overlaps| {
        for o in overlaps {
            squares -= o.fraction * u.iter().map(|u| u[o.cell] * u[o.cell]).sum::<f64>();
            let own = |axis: usize| u.iter().map(|u| slope(u, o.cell, grid.stride[axis], grid.h[axis])).sum::<f64>();
            slopes -= o.fraction * (0..D).map(own).sum::<f64>();
        }
    });
    // A face of the border belongs to half a cell; of the high borders no cell has had it yet.
    for (axis, side) in (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]) {
        if domain.boundaries.borders[axis][side].is_none() {
            continue;
        }
        let (s, sign) = (grid.stride[axis], 2.0 * side as f64 - 1.0);
        for cell in grid.border_cells(axis, side) {
            let face = if side == 0 { cell } else { cell + s };
            slopes += 0.5 * sign * u.iter().map(|u| slope(u, face, s, grid.h[axis])).sum::<f64>();
        }
    }
    let volume = grid.cell_volume();
    (0.5 * domain.fluid.density * volume * squares, domain.fluid.viscosity * volume * slopes)
}

/// `((u_c - u_(c-1))/h)^2` at the low face of a cell.
#[inline(always)]
fn slope(u: &[f64], cell: usize, stride: usize, h: f64) -> f64 {
    ((u[cell] - u[cell - stride]) / h).powi(2)
}

/// Over this rank's cells, the sums of the squared velocity and of the squared slopes at their low faces.
fn sums<const D: usize>(grid: &Grid<D>, u: &VectorField<D>) -> (f64, f64) {
    simd(
        #[inline(always)]
        || {
            let (mut squares, mut slopes) = (0.0, 0.0);
            for row in grid.rows() {
                for u in u {
                    let here = &u[row.clone()];
                    squares += total(
                        row.len(),
                        #[inline(always)]
                        |i| here[i] * here[i],
                    );
                    for axis in 0..D {
                        let below = &u[row.start - grid.stride[axis]..][..row.len()];
                        slopes += total(
                            row.len(),
                            #[inline(always)]
                            |i| (here[i] - below[i]) * (here[i] - below[i]),
                        ) / (grid.h[axis] * grid.h[axis]);
                    }
                }
            }
            (squares, slopes)
        },
    )
}
