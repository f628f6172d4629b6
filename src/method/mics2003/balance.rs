//! The balance of momentum over a step: fluid, particles, boundaries.
//!
//! With `M = sum_c rho u dV` over all cells, particles included (kg m/s; per metre of depth in 2D),
//! ```text
//!   M^(n+1) - M^n = gravity + drive + boundary + contacts with walls and held bodies
//!                 - force on held bodies
//! ```
//! What the fields transport of the particles' excess mass and what the mixing takes pass between
//! fluid and particles and cancel. The boundary's impulse is that of flow, viscosity and pressure
//! on the sides of the box, from the fields there in every stage. A part of a particle that a
//! contact lets a little way into a wall has neither cells nor weight, and takes its momentum there
//! with it, which is counted as the contact's. What the two sides of this line differ by is the
//! error.
//!
//! Along a line of cells, with the face's `1/rho = 2/(rho(c-1) + rho(c))`, pressure and body forces
//! (e per volume) give all cells together what the faces between them do and half of what those at
//! the sides do:
//! ```text
//!   sum_c rho_c (a_low + a_high)/2 h = p_first - p_last + sum_c e_c h + [ rho a - e ]_first h/2
//!                 + [ rho a - e ]_last h/2
//! ```

use super::Mics2003;
use super::motion::Departure;
use crate::Result;
use crate::clock::Stage;
use crate::domain::Domain;
use crate::kernels::boundary::Sides;
use crate::method::cells_momentum;
use crate::particles::Body;
use crate::state::{Balance, Exchange, Impulses, State};
use nalgebra::Vector3;

impl<const D: usize> Mics2003<D> {
    /// This rank's momentum (kg m/s), where a balance is kept.
    pub(super) fn momentum(&self, domain: &mut Domain<D>, s: &State<D>) -> Vector3<f64> {
        if s.balance.is_none() {
            return Vector3::zeros();
        }
        let momentum = cells_momentum(&domain.grid, &self.flow.mixture.density, &s.u);
        domain.clock.lap(Stage::Force);
        momentum
    }

    /// Starts the balance, where one is kept. Collective.
    pub(in crate::method) fn balance_from_now(
        &self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
    ) -> Result<()> {
        let mut momentum = self.momentum(domain, s);
        domain.session.sum(momentum.as_mut_slice())?;
        s.balance = s.balance.map(|_| Balance { momentum, ..Balance::default() });
        Ok(())
    }

    /// The drive on this rank's cells (N), as far as they are not solid where it acts on the fluid
    /// alone, where a balance is kept.
    pub(super) fn drive_on_cells(&self, domain: &Domain<D>, s: &State<D>) -> Vector3<f64> {
        let Some(force) = s.drive.filter(|_| s.balance.is_some()) else { return Vector3::zeros() };
        let fluid_in = |row: std::ops::Range<usize>| {
            let solid =
                self.flow.solid.as_ref().map_or(0.0, |solid| solid[row.clone()].iter().sum());
            row.len() as f64 - solid
        };
        domain.grid.cell_volume() * domain.grid.rows().map(fluid_in).sum::<f64>() * force
    }

    /// This rank's part of the force of the pressure on the sides (N), as the cells beside them
    /// have it, where a balance is kept.
    pub(super) fn pressure_of_sides(&self, domain: &Domain<D>, s: &State<D>) -> Vector3<f64> {
        let (grid, flow) = (&domain.grid, &self.flow);
        if s.balance.is_none() {
            return Vector3::zeros();
        }
        let mut force = Vector3::zeros();
        for (axis, side) in (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let (stride, volume, inwards) =
                (grid.stride[axis], grid.cell_volume(), 1.0 - 2.0 * side as f64);
            let area = volume / grid.h[axis];
            let drive = s.drive.map_or(0.0, |force| force[axis]);
            for c in grid.boundary_cells(axis, side) {
                let (face, ghost) =
                    if side == 0 { (c, c - stride) } else { (c + stride, c + stride) };
                if flow.cell_gradient {
                    force[axis] += inwards * area * 0.5 * (s.p[ghost] + s.p[c]);
                    continue;
                }
                let given = flow.force.as_ref().map_or(0.0, |force| force.density[axis][c]);
                let driven = drive * (1.0 - flow.solid.as_ref().map_or(0.0, |solid| solid[c]));
                let pushed = flow.mixture.density.at(c) * flow.acceleration[axis][face];
                force[axis] += inwards * area * s.p[c] + 0.5 * volume * (pushed - given - driven);
            }
        }
        force
    }

    /// Closes the balance of the step `dt` (s), with this rank's momentum at its start and the
    /// forces on its cells in it (N): of the sides by flow and viscosity, and by pressure, and of
    /// the drive. Collective.
    pub(super) fn close_balance(
        &self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        before: Vector3<f64>,
        (sides, pressure, drive): (Sides, Vector3<f64>, Vector3<f64>),
        dt: f64,
    ) -> Result<()> {
        if s.balance.is_none() {
            return Ok(());
        }
        let [flow, shear] = [0, 1].map(|k| dt * sides.column(k));
        let mut sums = [0.0; 18];
        let vectors = [before, self.momentum(domain, s), flow, shear, dt * pressure, dt * drive];
        for (slot, v) in sums.chunks_exact_mut(3).zip(vectors) {
            slot.copy_from_slice(v.as_slice());
        }
        domain.session.sum(&mut sums)?;
        let [before, after, flow, shear, pressure, drive] =
            std::array::from_fn(|k| Vector3::from_column_slice(&sums[3 * k..3 * k + 3]));
        // The whole force on held bodies, and on free ones that along the directions in which they
        // are held.
        let held = |(b, e): (&Body, &Exchange)| {
            b.freedom().map_or(e.held(), |f| e.momentum - f.along(&e.momentum))
        };
        let on_held: Vector3<f64> = s.bodies.iter().zip(&s.exchange).map(held).sum();
        let beyond = self.departures.iter().map(|departure| departure.beyond).sum::<Vector3<f64>>();
        let impulses = Impulses {
            drive,
            gravity: dt * self.weight(domain, s),
            pressure,
            shear,
            flow,
            contacts: self.contact_impulse(s) - beyond,
            held: -dt * on_held,
        };
        s.balance = Some(Balance::close([before, after], impulses, self.angular_error(s, dt)));
        domain.clock.lap(Stage::Mixing);
        Ok(())
    }

    /// Force of gravity less buoyancy on the free particles, as far as it acts on the mixture in
    /// the box (N).
    fn weight(&self, domain: &Domain<D>, s: &State<D>) -> Vector3<f64> {
        let weight = |(b, departure): (&Body, &Departure)| {
            let excess = (b.density - domain.fluid.density) * departure.volume;
            Some(excess * b.freedom()?.along(&self.choices.field_gravity))
        };
        s.bodies.iter().zip(&self.departures).filter_map(weight).sum()
    }

    /// Impulse of contacts on the free particles (N s): pairs of them cancel.
    fn contact_impulse(&self, s: &State<D>) -> Vector3<f64> {
        let Some(contacts) = &self.contacts else { return Vector3::zeros() };
        let bodies = s.bodies.iter().zip(contacts.impulses());
        bodies.filter_map(|(b, i)| Some(b.freedom()?.along(&i.linear))).sum()
    }

    /// What is missing in the balance of angular momentum about the free particles' centres, summed
    /// over them (kg m2/s).
    fn angular_error(&self, s: &State<D>, dt: f64) -> f64 {
        let bodies = s.bodies.iter().zip(&self.departures).zip(&s.exchange).enumerate();
        let errors = bodies.filter_map(|(k, ((body, departure), exchange))| {
            let (struck, freedom) = (self.unexpected(k, dt).angular, body.freedom()?);
            Some(freedom.about(&(exchange.spun + departure.excess_momentum.1 - struck)).norm())
        });
        errors.sum()
    }
}
