//! The stiffness "auto": as soft as it may be, so that contacts last long and need few substeps.
//!
//! ```text
//!   impact   k d^(g+1)/(g+1) = m v^2/2
//!              v: the largest speed at which anything may meet, m of the heaviest pair
//!   weight   k d^g = N |m - m_f| g
//!              N: bodies one above the other in the highest heap that the box has room for
//!   speed    v^2 = v_0^2 + min( 2 a L, v_t^2 )
//!              of a fall through the box L with a = |m - m_f| g/(m + m_f/2), at most the
//!                                                  terminal speed v_t of a body alone
//! ```
//! with d the deepest overlap allowed: 1 % of the smallest diameter, of parts with a skin less
//! ([`Part::contact_radius`]).

use super::Medium;
use crate::drag::terminal_speed;
use crate::numerics::AUTO_OVERLAP;
use crate::particles::Body;
use mics_shapes::Part;
use nalgebra::Vector3;

/// The hardest impact that bodies may have.
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
    /// The hardest impact among `bodies` in a box of `size` (m), in a fluid that moves at up to
    /// `flow` (m/s), under gravity (m/s2).
    pub fn expected(
        bodies: &[Body],
        size: [f64; 3],
        gravity: &Vector3<f64>,
        fluid: &Medium,
        flow: f64,
    ) -> Impact {
        let &Medium { density, viscosity, .. } = fluid;
        let smallest = bodies.iter().flat_map(contact_radii).fold(f64::INFINITY, f64::min);
        let length =
            (0..3).map(|a| if gravity[a] == 0.0 { 0.0 } else { size[a] }).fold(0.0, f64::max);
        let mut speeds = [0.0f64; 2];
        let depth = 2.0 * AUTO_OVERLAP * smallest;
        let mut impact = Impact { depth, ..Impact::default() };
        let obstacles = bodies.iter().filter(|body| body.shape().is_obstacle()).count();
        let count = bodies.len() - obstacles;
        for body in bodies {
            // An obstacle is a wall.
            if body.shape().is_obstacle() && !body.moves() {
                continue;
            }
            let mut speed = body.velocity.norm().max(body.speed()).max(flow);
            let volume = body.volume();
            if body.freedom().is_some() {
                let weight = (body.mass() - density * volume).abs() * gravity.norm();
                let fall = 2.0 * weight / (body.mass() + 0.5 * density * volume) * length;
                let sphere = body.shape().dimension() == 3;
                let diameter = 2.0 * body.radius();
                let terminal = terminal_speed(
                    sphere,
                    diameter,
                    weight / (density * volume),
                    viscosity / density,
                );
                speed = (speed * speed + fall.min(terminal * terminal)).sqrt();
                let above = (length / (2.0 * body.radius())).min(count as f64).max(1.0);
                impact.weight = impact.weight.max(above * weight);
                impact.mass = impact.mass.max(body.mass() + density * volume);
            }
            if speed > speeds[0] {
                speeds = [speed, speeds[0]];
            } else if speed > speeds[1] {
                speeds[1] = speed;
            }
        }
        impact.speed = speeds[0] + 0.5 * speeds[1];
        impact
    }

    /// The stiffness (N/m^exponent) that holds it.
    pub fn stiffness(&self, exponent: f64) -> f64 {
        let power = exponent + 1.0;
        let of_impact = 0.5 * power * self.mass * self.speed * self.speed / self.depth.powf(power);
        let of_weight = self.weight / self.depth.powf(exponent);
        of_impact.max(of_weight)
    }

    /// Overlap that the impact reaches at this stiffness (m).
    pub fn depth_at(&self, stiffness: f64, exponent: f64) -> f64 {
        let power = exponent + 1.0;
        (0.5 * power * self.mass * self.speed * self.speed / stiffness).powf(1.0 / power)
    }
}

/// Radii that overlaps of a body count in (m): its own, or those of its parts.
fn contact_radii(body: &Body) -> impl Iterator<Item = f64> {
    let round = body.parts().is_empty().then(|| body.radius());
    round.into_iter().chain(body.parts().iter().map(Part::contact_radius))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Sphere;
    use crate::particles::{Freedom, Motion};
    use std::sync::Arc;

    #[test]
    fn auto_stiffness_stops_impact_at_allowed_overlap() {
        let impact = Impact { depth: 1e-4, speed: 0.5, mass: 2.0, weight: 0.0 };
        for exponent in [1.0, 1.5, 3.0] {
            let k = impact.stiffness(exponent);
            assert!((impact.depth_at(k, exponent) / 1e-4 - 1.0).abs() < 1e-12);
            let work = k * 1e-4f64.powf(exponent + 1.0) / (exponent + 1.0);
            assert!((work - 0.5 * 2.0 * 0.25).abs() < 1e-12);
        }
    }

    /// Grains of 1 cm in a box 10 cm high: in oil no faster than its drag lets one fall alone, in
    /// gas as fast as they fall from its top.
    #[test]
    fn expected_impact_speed_from_fall_in_fluid() {
        let sphere = || {
            let mut body =
                Body::new(Arc::new(Sphere { radius: 0.005 }), 2650.0, 1.0, Vector3::zeros());
            body.motion = Motion::Free(Freedom { translation: [true; 3], rotation: [true; 3] });
            body
        };
        let speed = |bodies: &[Body], density: f64, viscosity: f64| {
            let medium = Medium { density, viscosity, spacing: 0.001, roughness: 1e-6 };
            Impact::expected(
                bodies,
                [0.05, 0.1, 0.05],
                &Vector3::new(0.0, -9.81, 0.0),
                &medium,
                0.0,
            )
            .speed
        };
        let one = [sphere()];
        // (2650/1000 - 1) g (2 r)^2/(18 nu) in creeping flow, less by 3 % at Re = 0.16 where Cd =
        // 24/Re (1 + 0.15 Re^0.687).
        let creeping = 1.65 * 9.81 * 0.01 * 0.01 / (18.0 * 5e-3);
        let found = speed(&one, 1000.0, 5.0);
        let re = found * 0.01 / 5e-3;
        assert!(
            (found * (1.0 + 0.15 * re.powf(0.687)) / creeping - 1.0).abs() < 1e-6,
            "{found} of {creeping}"
        );
        let gas = (2.0f64 * 9.81 * 0.1).sqrt();
        assert!((speed(&one, 1e-3, 1e-9) / gas - 1.0).abs() < 1e-5);
        // The second of two that meet counts by half.
        assert!((speed(&[sphere(), sphere()], 1e-3, 1e-9) / (1.5 * gas) - 1.0).abs() < 1e-5);
    }
}
