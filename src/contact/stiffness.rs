//! Stiffness for those who do not care about it: as soft as it may be, so that contacts last long and ask for few substeps.
//!
//! ```text
//!   impact   k d^(g+1)/(g+1) = m v^2/2             v: the largest speed at which anything may meet, m of the heaviest pair
//!   weight   k d^g = N |m - m_f| g                 N: bodies one above the other in the highest heap that the box has room for
//!   speed    v^2 = v_0^2 + min( 2 a L, v_t^2 )     of a fall through the box L with a = |m - m_f| g/(m + m_f/2), at most the
//!                                                  terminal speed v_t of a body alone
//! ```
//! with d the deepest overlap allowed: 1 % of the smallest diameter or 0.1 spacing, whichever is less.

use super::Medium;
use crate::params;
use crate::particles::{Body, terminal_speed};
use nalgebra::Vector3;

/// What bodies may meet with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impact {
    /// Deepest overlap allowed (m).
    pub depth: f64,
    /// Largest speed of approach (m/s).
    pub speed: f64,
    /// Mass of the heaviest pair (kg), its fluid included.
    pub mass: f64,
    /// Weight that a contact may have to bear (N).
    pub weight: f64,
}

impl Impact {
    /// Among `bodies` in a box of `size` (m), in a fluid that moves at up to `flow` (m/s), under gravity (m/s2).
    pub fn expected(bodies: &[Body], size: [f64; 3], gravity: &Vector3<f64>, fluid: &Medium, flow: f64) -> Impact {
        let &Medium { density, viscosity, spacing, .. } = fluid;
        let smallest = bodies.iter().fold(f64::INFINITY, |least, b| least.min(2.0 * b.radius()));
        let length = (0..3).map(|a| if gravity[a] == 0.0 { 0.0 } else { size[a] }).fold(0.0, f64::max);
        let (mut speeds, mut impact) = ([0.0f64; 2], Impact::default());
        impact.depth = (params::auto_overlap() * smallest).min(params::auto_overlap_spacing() * spacing);
        for body in bodies {
            let (mut speed, volume) = (body.velocity.norm().max(body.pace()).max(flow), body.volume());
            if body.freedom().is_some() {
                let weight = (body.mass() - density * volume).abs() * gravity.norm();
                let fall = 2.0 * weight / (body.mass() + 0.5 * density * volume) * length;
                let (sphere, diameter) = (body.shape().dimension() == 3, 2.0 * body.radius());
                let terminal = terminal_speed(sphere, diameter, weight / (density * volume), viscosity / density);
                speed = (speed * speed + fall.min(terminal * terminal)).sqrt();
                let above = (length / (2.0 * body.radius())).min(bodies.len() as f64).max(1.0);
                impact.weight = impact.weight.max(above * weight);
                impact.mass = impact.mass.max(body.mass() + density * volume);
            }
            if speed > speeds[0] {
                speeds = [speed, speeds[0]];
            } else if speed > speeds[1] {
                speeds[1] = speed;
            }
        }
        impact.speed = if bodies.len() == 1 { speeds[0] } else { speeds[0] + 0.5 * speeds[1] };
        impact
    }

    /// The stiffness (N/m^exponent) that holds it.
    pub fn stiffness(&self, exponent: f64) -> f64 {
        let power = exponent + 1.0;
        let of_impact = 0.5 * power * self.mass * self.speed * self.speed / self.depth.powf(power);
        let of_weight = self.weight / self.depth.powf(exponent);
        of_impact.max(of_weight)
    }

    /// How deep an impact goes at this stiffness (m).
    pub fn depth_at(&self, stiffness: f64, exponent: f64) -> f64 {
        let power = exponent + 1.0;
        (0.5 * power * self.mass * self.speed * self.speed / stiffness).powf(1.0 / power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stiffness_of_an_impact_stops_it_at_the_allowed_depth() {
        let impact = Impact { depth: 1e-4, speed: 0.5, mass: 2.0, weight: 0.0 };
        for exponent in [1.0, 1.5, 3.0] {
            let k = impact.stiffness(exponent);
            assert!((impact.depth_at(k, exponent) / 1e-4 - 1.0).abs() < 1e-12);
            let work = k * 1e-4f64.powf(exponent + 1.0) / (exponent + 1.0);
            assert!((work - 0.5 * 2.0 * 0.25).abs() < 1e-12);
        }
    }
}
