//! (27), the wall, and (28, 29), the pressure inside.

use super::{Driver, Mics2003};
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
    /// (27): mixes the bodies' rigid motion into the cells they touch, and counts what that removes
    /// over `dt` (s) from the fluid around held bodies as the force on them; that on free ones
    /// comes of their motion.
    pub(super) fn impose(&mut self, domain: &Domain<D>, s: &mut State<D>, dt: f64) {
        let volume = domain.grid.cell_volume();
        let (density, per_time) = (&self.flow.mixture.density, volume / dt);
        let lead = domain.session.rank() == 0;
        for (k, body) in s.bodies.iter().enumerate() {
            let (kicks, exchange) = (&mut self.kicks[k], &mut s.exchange[k]);
            let freedom = body.freedom();
            // Along free directions the momentum is counted already: it is what the particle
            // settled by.
            let settled = freedom.filter(|_| self.choices.driver == Driver::Momentum);
            // What contacts change follows by shares of mass; as printed, (27) mixes the final
            // motion in.
            let (v, w) =
                if settled.is_some() { self.settled[k] } else { (body.velocity, body.spin) };
            let (struck_v, struck_w) = self.struck[k];
            kicks.clear();
            if freedom.is_none() && lead {
                exchange.driven = body.mass() * (body.velocity - self.departures[k].velocity) / dt;
                exchange.momentum += exchange.driven;
            }
            for o in &self.overlaps[k] {
                let rho = density.at(o.cell);
                let turns = !self.choices.rotation_at_boundary || o.is_cut();
                let rigid = if turns { v + w.cross(&o.arm) } else { v };
                let kick = o.fraction * (rigid - vector(&s.u, o.cell));
                let turn = o.arm.cross(&(-(per_time * rho) * kick));
                let kick =
                    kick + (o.fraction * body.density / rho) * (struck_v + struck_w.cross(&o.arm));
                let df = -(per_time * rho) * kick;
                exchange.momentum += settled.map_or(df, |f| df - f.along(&df));
                exchange.momentum_torque += settled.map_or(turn, |f| turn - f.about(&turn));
                exchange.spun += (volume * rho) * o.arm.cross(&kick);
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
        let messages = &mut self.messages;
        let means = self.pressures.sum_here(&domain.session, &self.reach, messages, own)?;
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
        let messages = &mut self.messages;
        let sums = self.exchanged.sum_for_all(&domain.session, &self.reach, messages, own)?;
        for (exchange, sum) in s.exchange.iter_mut().zip(sums) {
            *exchange = Exchange { contact: exchange.contact, ..*sum };
        }
        Ok(())
    }
}
