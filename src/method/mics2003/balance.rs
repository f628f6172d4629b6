//! The balance of momentum over a step: fluid, particles, borders.
//!
//! With `M = sum_c rho u dV` over all cells, particles included (kg m/s; per metre of depth in 2D),
//! ```text
//!   fluid's part of the step      M(u_f) - M(u^n)    = gravity + drive + carried + border
//!   particles' part of the step   M(u^(n+1)) - M(u_f) = -carried + contacts with walls and held bodies - force on held bodies
//! ```
//! `carried` is what the fields transport of the particles' excess mass. The border's impulse is what the first line
//! leaves, less the excess mass that contacts let a little way into a wall: nothing in a box that is periodic all round.
//! The second line has to close by itself, and its error is what `steps.csv` reports, with the first line's where there is
//! no border.

use super::Mics2003;
use crate::Result;
use crate::clock::Stage;
use crate::domain::Domain;
use crate::method::cells_momentum;
use crate::particles::Body;
use crate::state::{Balance, Exchange, State};
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

    /// Closes the balance of the step `dt` (s), with this rank's momentum at its start and after the fluid's part. Collective.
    pub(super) fn close_balance(
        &self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        [before, fluid]: [Vector3<f64>; 2],
        dt: f64,
    ) -> Result<()> {
        if s.balance.is_none() {
            return Ok(());
        }
        let mut sums = [0.0; 9];
        for (slot, v) in sums.chunks_exact_mut(3).zip([before, fluid, self.momentum(domain, s)]) {
            slot.copy_from_slice(v.as_slice());
        }
        domain.session.sum(&mut sums)?;
        let [before, fluid, after] = [0, 3, 6].map(|k| Vector3::new(sums[k], sums[k + 1], sums[k + 2]));
        let carried = dt * s.exchange.iter().map(|e| e.carried).sum::<Vector3<f64>>();
        // The whole force on held bodies, and on free ones that along the directions in which they are held.
        let held = |(b, e): (&Body, &Exchange)| b.freedom().map_or(e.held(), |f| e.momentum - f.along(&e.momentum));
        let on_held: Vector3<f64> = s.bodies.iter().zip(&s.exchange).map(held).sum();
        let beyond = self.departures.iter().map(|d| d.beyond).sum::<Vector3<f64>>();
        let driven = dt * domain.driving_force(s);
        let mut border = fluid - before - carried - dt * self.weight(domain, s) - driven - beyond;
        let mut error = after - fluid + carried - self.contact_impulse(s) + dt * on_held + beyond;
        if domain.grid.periodic.iter().all(|p| *p) {
            error += std::mem::take(&mut border);
        }
        s.balance = Some(Balance { momentum: after, border, error, angular_error: self.angular_error(s) });
        domain.clock.lap(Stage::Mixing);
        Ok(())
    }

    /// Force of gravity less buoyancy on the free particles, as far as it acts on the mixture (N).
    fn weight(&self, domain: &Domain<D>, s: &State<D>) -> Vector3<f64> {
        let weight = |b: &Body| {
            let excess = (b.density - domain.fluid.density) * b.volume();
            Some(excess * b.freedom()?.along(&self.choices.field_gravity))
        };
        s.bodies.iter().filter_map(weight).sum()
    }

    /// Impulse of contacts on the free particles (N s): pairs of them cancel.
    fn contact_impulse(&self, s: &State<D>) -> Vector3<f64> {
        let Some(contacts) = &self.contacts else { return Vector3::zeros() };
        let bodies = s.bodies.iter().zip(contacts.impulses());
        bodies.filter_map(|(b, i)| Some(b.freedom()?.along(&i.linear))).sum()
    }

    /// What is missing in the balance of angular momentum about the free particles' centres, summed over them (kg m2/s).
    fn angular_error(&self, s: &State<D>) -> f64 {
        let bodies = s.bodies.iter().zip(&self.departures).zip(&s.exchange).enumerate();
        let errors = bodies.filter_map(|(k, ((body, departure), exchange))| {
            let struck = self.contacts.as_ref().map_or(Vector3::zeros(), |c| c.impulses()[k].angular);
            let freedom = body.freedom()?;
            Some(freedom.about(&(exchange.spun + departure.carried.1 - struck)).norm())
        });
        errors.sum()
    }
}
