//! Resistance to rolling by an elastic-plastic spring and a dashpot (model C of Ai, Chen, Rotter &
//! Ooi 2011, Powder Technology 206, 269):
//!
//! ```text
//!   M = -(k_r theta + c_r omega),  |k_r theta| <= mu_r R F_n
//!              theta' = omega, the relative spin across the line of centres
//!   k_r = 3 k_n (mu_r R)^2 (2D), 2.25 k_n (mu_r R)^2 (3D)         R = r_i r_j/(r_i + r_j),
//!              k_n = F_n/overlap
//!   c_r = 2 eta sqrt(I k_r) while the spring is below its limit
//!              1/I = 1/(I_i + m_i r_i^2) + 1/(I_j + m_j r_j^2)
//!
//!   M = -(k_r theta' + c_r omega)/(1 + h (h k_r + c_r)/I_0)       theta' = theta + h omega,
//!              1/I_0 = 1/I_i + 1/I_j
//! ```
//! Over a substep h the torque is the one that the spin at its end asks for (Euler's backward
//! scheme): it turns a body by its own inertia alone, which is next to none of a light one, before
//! friction at the contact knows of it. Bodies that are not round have none: their shape resists.

use super::Contacts;
use super::law::Kinematics;
use super::pair::Pair;
use crate::particles::Body;
use nalgebra::Vector3;

impl Contacts {
    /// The torque (N m) on the first of a pair in contact with this normal force (N), whose rolling
    /// spring goes on by a substep.
    pub(super) fn resist_rolling(
        &self,
        pair: &mut Pair,
        bodies: &[Body],
        kinematics: &Kinematics,
        arms: [Vector3<f64>; 2],
        normal: f64,
    ) -> Vector3<f64> {
        let friction = self.law(pair).material.rolling_friction;
        let (body, other, h, n) =
            (&bodies[pair.first], bodies.get(pair.second), kinematics.h, kinematics.normal);
        let round = body.is_round() && other.is_none_or(Body::is_round);
        if friction == 0.0 || normal <= 0.0 || !round {
            return Vector3::zeros();
        }
        let spin = body.spin - other.map_or(Vector3::zeros(), |other| other.spin);
        let rolling = spin - spin.dot(&n) * n;
        let reduced = 1.0 / (1.0 / body.radius() + other.map_or(0.0, |other| 1.0 / other.radius()));
        let lever = friction * reduced;
        let shape = if body.shape().dimension() == 2 { 3.0 } else { 2.25 };
        // A contact that has hardly begun is as stiff as its spring at the depth of a substep's
        // way.
        let depth =
            kinematics.overlap.max(0.5 * h * kinematics.approach.abs()).max(f64::MIN_POSITIVE);
        let stiffness = shape * (normal / depth) * lever * lever;
        pair.rolled += h * rolling - pair.rolled.dot(&n) * n;
        let limit = lever * normal;
        let spring = stiffness * pair.rolled.norm();
        let turns = |body: usize| self.inverse_masses[body].inertia.max();
        let turns = h * (turns(pair.first) + other.map_or(0.0, |_| turns(pair.second)));
        if spring >= limit {
            pair.rolled *= limit / spring;
            let along = pair.rolled / pair.rolled.norm();
            // All of it where that does not turn the spin round.
            let stops = rolling.dot(&along) / turns.max(f64::MIN_POSITIVE);
            return -limit.min(stops.max(limit / (1.0 + turns * h * stiffness))) * along;
        }
        let part = |k: usize, body: usize| {
            let inverse_mass = &self.inverse_masses[body];
            let (mass, inertia) = (inverse_mass.mass.max(), inverse_mass.inertia.max());
            if mass > 0.0 && inertia > 0.0 {
                1.0 / (1.0 / inertia + arms[k].norm_squared() / mass)
            } else {
                0.0
            }
        };
        let inverse = part(0, pair.first) + other.map_or(0.0, |_| part(1, pair.second));
        let damper = if inverse > 0.0 {
            2.0 * self.numerics.rolling_damping * (stiffness / inverse).sqrt()
        } else {
            0.0
        };
        let torque = -(stiffness * pair.rolled + damper * rolling)
            / (1.0 + turns * (h * stiffness + damper));
        torque * (limit / torque.norm()).min(1.0)
    }
}
