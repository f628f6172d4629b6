//! (27), the wall, and (28, 29), the pressure inside.

use super::{Mics2003, Sums};
use crate::Result;
use crate::domain::Domain;
use crate::method::vector;
use crate::state::{Exchange, State};
use crate::sums::Summed;
use nalgebra::Vector3;

/// What a body's mean pressure is of.
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

impl<const D: usize> Mics2003<D> {
    /// (27): mixes the bodies' rigid motion into the cells they touch, their rotation into those
    /// that their surface cuts, and counts what that removes from the fluid over `dt` (s).
    pub(super) fn impose(&mut self, domain: &Domain<D>, s: &mut State<D>, dt: f64) {
        let density = &self.flow.mixture.density;
        let per_time = domain.grid.cell_volume() / dt;
        let lead = domain.session.rank() == 0;
        for (k, body) in s.bodies.iter().enumerate() {
            let kicks = &mut self.kicks[k];
            let exchange = &mut s.exchange[k];
            kicks.clear();
            if body.freedom().is_none() && lead {
                exchange.driven = body.mass() * (body.velocity - self.departures[k].velocity) / dt;
                exchange.momentum += exchange.driven;
            }
            for o in &self.overlaps[k] {
                let turning = if o.is_cut() { body.spin.cross(&o.arm) } else { Vector3::zeros() };
                let kick = o.fraction * (body.velocity + turning - vector(&s.u, o.cell));
                let df = -(per_time * density.at(o.cell)) * kick;
                exchange.momentum += df;
                exchange.momentum_torque += o.arm.cross(&df);
                kicks.push(kick);
            }
        }
        for (overlaps, kicks) in self.overlaps.iter().zip(&self.kicks) {
            for (o, kick) in overlaps.iter().zip(kicks) {
                for axis in 0..D {
                    s.u[axis][o.cell] += kick[axis];
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
        for ((overlaps, kicks), MeanPressure { sum, weight }) in
            self.overlaps.iter().zip(&mut self.kicks).zip(means)
        {
            kicks.clear();
            kicks.extend(
                overlaps.iter().map(|o| Vector3::x() * (o.fraction * (*sum / *weight - p[o.cell]))),
            );
        }
        for (overlaps, kicks) in self.overlaps.iter().zip(&self.kicks) {
            overlaps.iter().zip(kicks).for_each(|(o, kick)| p[o.cell] += kick.x);
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
