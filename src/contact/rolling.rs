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
//! friction at the contact knows of it.
//!
//! Bodies that are not round have no such resistance: their shape is one. A patch of them resists
//! turning about its normal instead, by the same spring, k = ratio k_n s^2 up to mu s F_n, s the
//! radius of the patch: its friction acts at one place.

use super::Contacts;
use super::law::Kinematics;
use super::meeting::Meeting;
use super::pair::Pair;
use crate::numerics::ROLLING_DAMPING;
use crate::particles::Body;
use nalgebra::Vector3;

/// How a contact resists the relative spin of its two.
struct Resistance {
    /// The part of the spin that it resists (rad/s).
    spin: Vector3<f64>,
    /// Spring (N m) and the largest torque (N m).
    stiffness: f64,
    limit: f64,
    /// Inverse moment of inertia that the damper counts with (1/(kg m2)).
    inverse: f64,
}

impl Contacts {
    /// The torque (N m) on the first of a pair in contact with this normal force (N), whose rolling
    /// spring goes on by a substep.
    pub(super) fn resist_turning(
        &self,
        pair: &mut Pair,
        bodies: &[Body],
        kinematics: &Kinematics,
        meeting: &Meeting,
        normal: f64,
    ) -> Vector3<f64> {
        let h = kinematics.h;
        let other = bodies.get(pair.second);
        let round = self.are_round(pair, bodies);
        let lever = if round {
            self.law(pair).material.rolling_friction
        } else {
            self.law(pair).material.friction * meeting.spread
        };
        if lever == 0.0 || normal <= 0.0 {
            return Vector3::zeros();
        }
        // A contact that has hardly begun is as stiff as its spring at the depth of a substep's
        // way.
        let depth =
            kinematics.overlap.max(0.5 * h * kinematics.approach.abs()).max(f64::MIN_POSITIVE);
        let Resistance { spin, stiffness, limit, inverse } = if round {
            self.rolling(pair, bodies, kinematics, meeting, normal, depth)
        } else {
            self.twisting(pair, bodies, meeting, normal, depth)
        };
        let n = kinematics.normal;
        let kept = pair.rolled.dot(&n) * n;
        pair.rolled = h * spin + if round { pair.rolled - kept } else { kept };
        let spring = stiffness * pair.rolled.norm();
        let turns = |body: usize| self.inverse_masses[body].inertia.max();
        let turns = h * (turns(pair.first) + other.map_or(0.0, |_| turns(pair.second)));
        if spring >= limit {
            pair.rolled *= limit / spring;
            let along = pair.rolled / pair.rolled.norm();
            // All of it where that does not turn the spin round.
            let stops = spin.dot(&along) / turns.max(f64::MIN_POSITIVE);
            return -limit.min(stops.max(limit / (1.0 + turns * h * stiffness))) * along;
        }
        let damper =
            if inverse > 0.0 { 2.0 * ROLLING_DAMPING * (stiffness / inverse).sqrt() } else { 0.0 };
        let torque =
            -(stiffness * pair.rolled + damper * spin) / (1.0 + turns * (h * stiffness + damper));
        torque * (limit / torque.norm()).min(1.0)
    }

    /// That of round bodies to rolling.
    fn rolling(
        &self,
        pair: &Pair,
        bodies: &[Body],
        kinematics: &Kinematics,
        meeting: &Meeting,
        normal: f64,
        depth: f64,
    ) -> Resistance {
        let body = &bodies[pair.first];
        let other = bodies.get(pair.second);
        let n = kinematics.normal;
        let spin = body.spin - other.map_or(Vector3::zeros(), |other| other.spin);
        let reduced = 1.0 / (1.0 / meeting.radii[0] + 1.0 / meeting.radii[1]);
        let lever = self.law(pair).material.rolling_friction * reduced;
        let shape = if body.shape().dimension() == 2 { 3.0 } else { 2.25 };
        let part = |k: usize, body: usize| {
            let inverse_mass = &self.inverse_masses[body];
            let mass = inverse_mass.mass.max();
            let inertia = inverse_mass.inertia.max();
            if mass > 0.0 && inertia > 0.0 {
                1.0 / (1.0 / inertia + meeting.arms.to[k].norm_squared() / mass)
            } else {
                0.0
            }
        };
        Resistance {
            spin: spin - spin.dot(&n) * n,
            stiffness: shape * (normal / depth) * lever * lever,
            limit: lever * normal,
            inverse: part(0, pair.first) + other.map_or(0.0, |_| part(1, pair.second)),
        }
    }

    /// That of a patch to turning about its normal.
    fn twisting(
        &self,
        pair: &Pair,
        bodies: &[Body],
        meeting: &Meeting,
        normal: f64,
        depth: f64,
    ) -> Resistance {
        let other = bodies.get(pair.second);
        let n = meeting.normal;
        let spin = bodies[pair.first].spin - other.map_or(Vector3::zeros(), |other| other.spin);
        let material = &self.law(pair).material;
        let response = |body: usize| n.dot(&self.inverse_masses[body].inertia.of(&n));
        Resistance {
            spin: spin.dot(&n) * n,
            stiffness: material.tangential_ratio * (normal / depth) * meeting.spread.powi(2),
            limit: material.friction * meeting.spread * normal,
            inverse: response(pair.first) + other.map_or(0.0, |_| response(pair.second)),
        }
    }
}
