//! The budget of energy over a step.
//!
//! ```text
//!   body     m (V' - V) = F dt + G dt + J
//!              its kinetic energy gains F.<V> dt by the fluid, G.<V> dt by gravity and the rest
//!                                              by contacts; <V> = (V + V')/2,
//!                 or the way over dt where contacts bend it
//!   fluid    gains -F.<V> dt of free and of prescribed bodies, the work of the drive and of the
//!            sides of the box, less
//!            viscous = dt mu ( sum over faces |u_c - u_(c-1)|^2/h^2 dV (1 - alpha)
//!                 + 2 sum of w^2 V )
//!              (alpha: the solid fraction of the volume about the face, of round bodies the mean
//!              of both cells')
//!   contacts what all bodies gain of them = what springs release and moving walls give,
//!                 less what dampers, friction, lubrication take
//! ```
//! and likewise for spins and torques. The remainder is the error of the method. Viscosity takes
//! `mu int 2 D:D dV`, D the symmetric part of grad u: more than `mu int |grad u|^2 dV` by what lies
//! on the surfaces of bodies, `mu n.(u.grad)u`, which is 2 w^2 mu of each volume V that turns with
//! w, and nothing at flat walls. In the mixture method torques are those of grad u alone.

use crate::Result;
use crate::contact::{Contacts, Impulse};
use crate::domain::{Domain, Fluid};
use crate::geometry::{Cut, Overlap};
use crate::grid::{Coefficient, Grid, VectorField, simd, total};
use crate::kernels::boundary;
use crate::method::Method;
use crate::particles::{Body, nearest_image};
use crate::state::{EnergyBudget, State};
use nalgebra::Vector3;

/// Motion of a body at the start of a step.
#[derive(Clone, Copy, Debug)]
pub struct BodyBefore {
    centre: Vector3<f64>,
    velocity: Vector3<f64>,
    spin: Vector3<f64>,
    energy: f64,
}

impl BodyBefore {
    /// Motion of a body now.
    pub fn of(body: &Body) -> BodyBefore {
        BodyBefore {
            centre: body.centre,
            velocity: body.velocity,
            spin: body.spin,
            energy: kinetic(body),
        }
    }
}

/// Steps between two samples of what viscosity takes, which cost a sweep; every one at the start,
/// and where the kinetic energy changes by more than [`FAST`] of it in a step, as after an impact.
const SAMPLED_EVERY: u64 = 8;
const FAST: f64 = 0.01;

/// Finds which bodies are in contact as they lie, and what their springs hold (J).
fn find_springs<const D: usize>(method: &mut dyn Method<D>, s: &State<D>) -> f64 {
    method.contacts_mut().map_or(0.0, |contacts| {
        contacts.meet(&s.bodies);
        contacts.stored(&s.bodies, |k| s.displacement(k))
    })
}

/// Starts a budget with the state as it is. Collective.
pub fn start<const D: usize>(
    domain: &mut Domain<D>,
    s: &mut State<D>,
    method: &mut dyn Method<D>,
) -> Result<()> {
    let fluid = of_fluid(domain, &s.u, method)?;
    let springs = find_springs(method, s);
    s.energy =
        EnergyBudget { fluid, bodies: of_bodies(&s.bodies), springs, ..EnergyBudget::default() };
    s.energy.start = s.energy.total();
    s.energy.powers.drive = domain.driving_power(s)?;
    // The pressure at the start is no sample.
    let Powers { shear, dissipated, .. } = Powers::of(domain, s, method, true)?;
    s.energy.powers.boundaries = shear;
    s.energy.powers.dissipated = dissipated;
    Ok(())
}

/// The power of the forces that vary on the fluid outside the bodies (W). Collective.
///
/// # Errors
/// When ranks cannot sum.
pub fn power_of_forces<const D: usize>(
    domain: &Domain<D>,
    u: &VectorField<D>,
    method: &dyn Method<D>,
) -> Result<f64> {
    let Some(forces) = &domain.forces else { return Ok(0.0) };
    let mut power = [forces.power(&domain.grid, u, &mut method.overlaps())];
    domain.session.sum(&mut power)?;
    Ok(power[0])
}

/// Takes bodies that have come or gone into the budget: what they brought or took is the work of
/// the boundaries. Collective.
pub fn reopen<const D: usize>(
    domain: &mut Domain<D>,
    s: &mut State<D>,
    method: &mut dyn Method<D>,
) -> Result<()> {
    let before = s.energy.total();
    s.energy.fluid = of_fluid(domain, &s.u, method)?;
    s.energy.bodies = of_bodies(&s.bodies);
    s.energy.springs = find_springs(method, s);
    s.energy.work.boundaries += s.energy.total() - before;
    // Samples of the dissipation from now on say nothing about the steps before.
    s.energy.powers.since = 0.0;
    Ok(())
}

/// Closes the budget of the last step, at whose start the bodies had the motions `before` and after
/// which all cells have the energy `all_cells` and what lies inside bodies `inside` (J, see
/// [`inside`]). Collective.
pub fn close<const D: usize>(
    domain: &mut Domain<D>,
    s: &mut State<D>,
    before: &[BodyBefore],
    method: &dyn Method<D>,
    [all_cells, inside]: [f64; 2],
) -> Result<()> {
    let contacts = method.contacts();
    let mut e = s.energy;
    let worked = WorkOnBodies::of(domain, s, before, contacts);
    let springs = contacts.map_or(0.0, |c| c.stored(&s.bodies, |k| s.displacement(k)));
    let walls = contacts.map_or(0.0, |c| c.outcome().wall_work);
    let slid = contacts.map_or(0.0, |c| c.outcome().friction_loss);
    e.fluid = match method.mixture().density {
        Coefficient::Uniform(_) => all_cells - inside,
        Coefficient::Field(_) => of_fluid(domain, &s.u, method)?,
    };
    e.bodies = of_bodies(&s.bodies);
    e.work.gravity += worked.gravity;
    let driven = domain.driving_power(s)?;
    e.work.drive += 0.5 * s.dt * (e.powers.drive + driven);
    e.powers.drive = driven;
    e.work.boundaries += walls;
    e.work.prescribed += worked.prescribed;
    e.losses.friction += slid;
    e.losses.contacts += walls - worked.contacts - (springs - e.springs) - slid;
    e.springs = springs;
    let [was, is] = [s.energy, e].map(|e| e.kinetic());
    sample(domain, s, method, (is - was).abs() > FAST * is.max(was), &mut e)?;
    e.losses.method = e.missing();
    e.take_note();
    s.energy = e;
    Ok(())
}

/// Counts the work of viscosity and of the sides of the box over the last step, by the trapezium
/// rule: viscosity by its last sample, which a new one corrects; the sides in every step, since an
/// impact's pressure lasts for one. Collective.
fn sample<const D: usize>(
    domain: &mut Domain<D>,
    s: &mut State<D>,
    method: &dyn Method<D>,
    fast: bool,
    e: &mut EnergyBudget,
) -> Result<()> {
    let due = fast || s.steps <= SAMPLED_EVERY || s.steps.is_multiple_of(SAMPLED_EVERY);
    e.powers.since += s.dt;
    e.losses.viscous += s.dt * e.powers.dissipated;
    if !due && !domain.sides_work {
        return Ok(());
    }
    let Powers { flow, shear, dissipated } = Powers::of(domain, s, method, due)?;
    e.work.boundaries += 0.5 * s.dt * (e.powers.boundaries + flow + shear);
    let first = s.steps <= 1;
    if first {
        e.work.boundaries += 0.5 * s.dt * flow;
    }
    e.powers.boundaries = flow + shear;
    if due {
        let before = e.powers.dissipated;
        // The vortex sheet beside a body that is set off is gone at once.
        let was = if first { before.min(dissipated) } else { before };
        e.losses.viscous += e.powers.since * (0.5 * (was + dissipated) - before);
        e.powers.dissipated = dissipated;
        e.powers.since = 0.0;
    }
    Ok(())
}

/// Work per time (W).
struct Powers {
    /// Power of the sides of the box on the fluid: by what flows through them with their pressure,
    /// and by viscosity.
    flow: f64,
    shear: f64,
    /// Power that viscosity takes, where it is asked for.
    dissipated: f64,
}

impl Powers {
    /// Powers of the state as it is. Collective.
    fn of<const D: usize>(
        domain: &mut Domain<D>,
        s: &mut State<D>,
        method: &dyn Method<D>,
        all: bool,
    ) -> Result<Powers> {
        domain.boundaries.fill_velocity(&mut s.u)?;
        let Fluid { density, viscosity, .. } = domain.fluid;
        let [flow, shear] = boundary::power(
            &domain.grid,
            &domain.boundaries,
            density,
            viscosity,
            &s.u,
            &s.faces,
            &s.p,
        );
        let mut powers =
            [flow, shear, if all { viscosity * slopes(domain, s, method) } else { 0.0 }];
        domain.session.sum(&mut powers)?;
        let [flow, shear, mut dissipated] = powers;
        if let (true, Coefficient::Uniform(_)) = (all, &method.mixture().density) {
            dissipated += 2.0
                * viscosity
                * s.bodies.iter().map(|b| b.volume() * b.spin.norm_squared()).sum::<f64>();
        }
        Ok(Powers { flow, shear, dissipated })
    }
}

/// Kinetic energy of a body (J).
fn kinetic(body: &Body) -> f64 {
    0.5 * (body.mass() * body.velocity.norm_squared()
        + body.spin.dot(&body.inertia().of(&body.spin)))
}

/// Kinetic energy of the free bodies (J).
fn of_bodies(bodies: &[Body]) -> f64 {
    bodies.iter().filter(|b| b.freedom().is_some()).fold(0.0, |sum, body| sum + kinetic(body))
}

/// The work of a step on and by the bodies (J).
#[derive(Clone, Copy, Debug, Default)]
struct WorkOnBodies {
    gravity: f64,
    prescribed: f64,
    /// Work of contacts on all bodies.
    contacts: f64,
}

impl WorkOnBodies {
    fn of<const D: usize>(
        domain: &Domain<D>,
        s: &State<D>,
        before: &[BodyBefore],
        contacts: Option<&Contacts>,
    ) -> WorkOnBodies {
        let mut work = WorkOnBodies::default();
        for (k, (body, before)) in s.bodies.iter().zip(before).enumerate() {
            let impulse = contacts.map(|c| c.outcome().impulse(k)).unwrap_or_default();
            let struck = impulse != Impulse::default();
            let way = if struck {
                nearest_image(&before.centre, &body.centre, &domain.periods())
            } else {
                0.5 * s.dt * (before.velocity + body.velocity)
            };
            let turn = 0.5 * s.dt * (before.spin + body.spin);
            let fluid = s.exchange[k].held().dot(&way) + s.exchange[k].momentum_torque.dot(&turn);
            if let Some(freedom) = body.freedom() {
                let weight =
                    (body.mass() - domain.fluid.density * body.volume()) * domain.fluid.gravity;
                // Work of what keeps the velocity along locked directions against all forces.
                let holds = |free: [bool; 3], load: Vector3<f64>, way: &Vector3<f64>| {
                    -(0..3).filter(|a| !free[*a]).map(|a| load[a] * way[a]).sum::<f64>()
                };
                let force = s.exchange[k].held() + weight + impulse.linear / s.dt;
                let torque = s.exchange[k].momentum_torque + impulse.angular / s.dt;
                let lock = holds(freedom.translation, force, &way)
                    + holds(freedom.rotation, torque, &turn);
                work.gravity += weight.dot(&way);
                work.prescribed += lock;
                if let Some(exact) = contacts
                    .and_then(|contacts| contacts.work_on(k, body, &before.velocity, &way, s.dt))
                {
                    work.contacts += exact;
                } else if struck {
                    work.contacts +=
                        kinetic(body) - before.energy - fluid - weight.dot(&way) - lock;
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

/// This rank's part of the kinetic energy (J) of what lies inside the bodies, as cells have it with
/// the fluid's density.
pub fn inside<const D: usize>(
    domain: &Domain<D>,
    u: &VectorField<D>,
    method: &dyn Method<D>,
) -> f64 {
    let square = |o: &Overlap| o.fraction * u.iter().map(|u| u[o.cell] * u[o.cell]).sum::<f64>();
    let squares = method.overlaps().map(square).fold(0.0, std::ops::Add::add);
    0.5 * domain.fluid.density * domain.grid.cell_volume() * squares
}

/// Kinetic energy of the fluid outside the bodies (J). Collective.
fn of_fluid<const D: usize>(
    domain: &Domain<D>,
    u: &VectorField<D>,
    method: &dyn Method<D>,
) -> Result<f64> {
    let density = domain.fluid.density;
    let squares = simd(
        #[inline(always)]
        || {
            let mut squares = 0.0;
            for row in domain.grid.rows() {
                for u in u {
                    let u = &u[row.clone()];
                    squares += total(
                        u.len(),
                        #[inline(always)]
                        |i| u[i] * u[i],
                    );
                }
            }
            squares
        },
    );
    let all_cells = 0.5 * density * domain.grid.cell_volume() * squares;
    let mut sums = [all_cells, inside(domain, u, method)];
    domain.session.sum(&mut sums)?;
    Ok(sums[0] - sums[1])
}

/// This rank's part of `sum |grad u|^2 dV` over the fluid outside the bodies, by the faces of the
/// cells; ghosts filled.
fn slopes<const D: usize>(domain: &Domain<D>, s: &State<D>, method: &dyn Method<D>) -> f64 {
    let grid = &domain.grid;
    let u = &s.u;
    let mut slopes = low_slopes(grid, u);
    let at = |axis: usize, face: usize| {
        u.iter().map(|u| slope(u, face, grid.stride[axis], grid.h[axis])).sum::<f64>()
    };
    for (k, (body, cells)) in s.bodies.iter().zip(method.overlaps_by_body()).enumerate() {
        if !body.is_round() && method.covered_faces(k, 0).is_some() {
            // Half of each cell would count the slope a cell deep inside a flat wall for fluid: in
            // a channel of three cells half of all dissipation.
            for axis in 0..D {
                let cuts = method.covered_faces(k, axis).unwrap_or_default();
                let solid = |cut: &Cut| cut.solid_fraction * at(axis, cut.face as usize);
                slopes -= cuts.iter().filter(|cut| cut.owned).map(solid).sum::<f64>();
            }
            continue;
        }
        for o in cells {
            // Half of what each of its two cells has of a body is taken from a face, so that
            // mirrored flows lose the same.
            let own = |axis: usize| at(axis, o.cell) + at(axis, o.cell + grid.stride[axis]);
            slopes -= 0.5 * o.fraction * (0..D).map(own).sum::<f64>();
        }
    }
    // A face of the boundary belongs to what lies between it and the cell; of the high boundaries
    // no cell has had it yet.
    for (axis, side) in (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]) {
        if domain.boundaries.kinds[axis][side].is_none() {
            continue;
        }
        let s = grid.stride[axis];
        let h = grid.h[axis];
        for cell in grid.boundary_cells(axis, side) {
            let ghost = if side == 0 { cell - s } else { cell + s };
            for (i, u) in u.iter().enumerate() {
                let all = u[cell] - u[ghost];
                let at_side = domain.boundaries.velocity_at(axis, side, i, u, ghost, cell);
                let counted = if side == 0 { all } else { 0.0 };
                slopes += (u[cell] - at_side - counted) * all / (h * h);
            }
        }
    }
    slopes * grid.cell_volume()
}

/// `((u_c - u_(c-1))/h)^2` at the low face of a cell.
#[inline(always)]
fn slope(u: &[f64], cell: usize, stride: usize, h: f64) -> f64 {
    ((u[cell] - u[cell - stride]) / h).powi(2)
}

/// Sum over this rank's cells of [`slope`] of all components along all axes.
fn low_slopes<const D: usize>(grid: &Grid<D>, u: &VectorField<D>) -> f64 {
    simd(
        #[inline(always)]
        || {
            let mut slopes = 0.0;
            for row in grid.rows() {
                for (u, axis) in u.iter().flat_map(|u| (0..D).map(move |axis| (u, axis))) {
                    let here = &u[row.clone()];
                    let below = &u[row.start - grid.stride[axis]..][..row.len()];
                    slopes += total(
                        row.len(),
                        #[inline(always)]
                        |i| (here[i] - below[i]) * (here[i] - below[i]),
                    ) / (grid.h[axis] * grid.h[axis]);
                }
            }
            slopes
        },
    )
}
