//! (27), the wall, and (28, 29), the pressure inside.

use super::{MixtureMethod, Sums};
use crate::Result;
use crate::domain::Domain;
use crate::method::vector;
use crate::state::{Exchange, State};
use crate::sums::Summed;
use nalgebra::Vector3;

/// Sums whose ratio is a body's mean pressure.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MeanPressure {
    /// `sum alpha p` (Pa).
    sum: f64,
    /// `sum alpha`.
    weight: f64,
}

impl Summed for MeanPressure {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        take(std::slice::from_mut(&mut self.sum));
        take(std::slice::from_mut(&mut self.weight));
    }
}

impl<const D: usize> MixtureMethod<D> {
    /// (27): mixes the bodies' rigid motion into the cells they touch, their rotation into those
    /// that their surface cuts, and counts what that removes from the fluid over `dt` (s).
    pub(super) fn impose(&mut self, domain: &Domain<D>, s: &mut State<D>, dt: f64) {
        let density = &self.flow.mixture.density;
        let per_time = domain.grid.cell_volume() / dt;
        let lead = domain.session.rank() == 0;
        for (k, body) in s.bodies.iter().enumerate() {
            let velocity_changes = &mut self.velocity_changes[k];
            let exchange = &mut s.exchange[k];
            velocity_changes.clear();
            if body.freedom().is_none() && lead {
                exchange.driven = body.mass() * (body.velocity - self.departures[k].velocity) / dt;
                exchange.momentum += exchange.driven;
            }
            for o in &self.overlaps[k] {
                let turning = if o.is_cut() { body.spin.cross(&o.arm) } else { Vector3::zeros() };
                let change = o.fraction * (body.velocity + turning - vector(&s.u, o.cell));
                let df = -(per_time * density.at(o.cell)) * change;
                exchange.momentum += df;
                exchange.momentum_torque += o.arm.cross(&df);
                velocity_changes.push(change);
            }
        }
        for (overlaps, velocity_changes) in self.overlaps.iter().zip(&self.velocity_changes) {
            for (o, change) in overlaps.iter().zip(velocity_changes) {
                for axis in 0..D {
                    s.u[axis][o.cell] += change[axis];
                }
            }
        }
    }

    /// (28, 29): mixes each body's mean pressure into the cells it touches, `p += sum_k alpha_k
    /// (p_k - p)` with `p_k = sum alpha p / sum alpha`. Collective.
    pub(super) fn flatten_pressure(&mut self, domain: &Domain<D>, s: &mut State<D>) -> Result<()> {
        let p = &mut s.p;
        let own = |k: usize| MeanPressure {
            sum: self.overlaps[k].iter().map(|o| o.fraction * p[o.cell]).sum(),
            weight: self.overlaps[k].iter().map(|o| o.fraction).sum(),
        };
        let Sums { pressures, messages, .. } = &mut self.sums;
        let means = pressures.sum_here(&domain.session, &self.reach, messages, own)?;
        for ((overlaps, velocity_changes), MeanPressure { sum, weight }) in
            self.overlaps.iter().zip(&mut self.velocity_changes).zip(means)
        {
            velocity_changes.clear();
            velocity_changes.extend(
                overlaps.iter().map(|o| Vector3::x() * (o.fraction * (*sum / *weight - p[o.cell]))),
            );
        }
        for (overlaps, velocity_changes) in self.overlaps.iter().zip(&self.velocity_changes) {
            overlaps.iter().zip(velocity_changes).for_each(|(o, change)| p[o.cell] += change.x);
        }
        Ok(())
    }

    /// Sums the step's forces over the ranks. Collective.
    pub(super) fn sum_exchange(&mut self, domain: &Domain<D>, s: &mut State<D>) -> Result<()> {
        let own = |k: usize| s.exchange[k];
        let Sums { exchanged, messages, .. } = &mut self.sums;
        let sums = exchanged.sum_for_all(&domain.session, &self.reach, messages, own)?;
        for (exchange, sum) in s.exchange.iter_mut().zip(sums) {
            *exchange = Exchange { contact: exchange.contact, ..*sum };
        }
        Ok(())
    }
}
