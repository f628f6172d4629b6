//! The keys that a case leaves out, where their defaults depend on others.

use super::{Case, Motion, Side, WallRule, direction};
use crate::config::fault::{Check, Within};

impl Case {
    /// Fills in the keys that are not given, of a checked case whose swarms are among its
    /// particles.
    pub(in crate::config) fn fill(&mut self) -> Check {
        self.fill_measures()?;
        let rest = vec![0.0; self.dimension()];
        if self.initial.velocity.is_empty() {
            self.initial.velocity = self.inflow().unwrap_or_else(|| rest.clone());
        }
        if self.fluid.gravity.is_empty() {
            self.fluid.gravity = rest;
        }
        for particle in &mut self.particle {
            particle.fill(&self.fluid);
        }
        if let Some(contact) = &mut self.contact {
            let diameters = self.particle.iter().map(|p| p.shape.diameter());
            contact.fill(diameters.reduce(f64::min).unwrap_or(0.0));
        }
        let count = self.particle.len();
        let resting = self.particle.iter().filter(|p| p.motion == Motion::Fixed).count();
        self.output.fill(count, resting);
        let some = self.has_bodies();
        let moves = resting < count || self.obstacle.iter().any(|o| o.motion != Motion::Fixed);
        self.time.fill(self.coupling.wall == WallRule::Mixing && some, some, moves)
    }

    fn fill_measures(&mut self) -> Check {
        let mut measures = self.measure.clone();
        for (index, measure) in measures.iter_mut().enumerate() {
            let key = format!("measure.{index}");
            let direction = direction::of(self, measure).within(&key)?;
            let axis = direction::axis(self, measure).within(&key)?;
            measure.fill(self, direction, axis);
        }
        self.measure = measures;
        Ok(())
    }

    /// The velocity (m/s) of the first inflow, at its middle.
    fn inflow(&self) -> Option<Vec<f64>> {
        (0..6).find_map(|face| match self.boundary.side(face)? {
            Side::Inflow(v) | Side::InflowParabola(v) => Some(v.clone()),
            Side::InflowProfile(p) => {
                Some(p.velocity_at(0.5 * self.domain.size[usize::from(face < 2)]))
            }
            _ => None,
        })
    }
}
