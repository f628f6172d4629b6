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
//! scheme): it turns a body against its own inertia alone, which is next to none of a light one,
//! before friction at the contact responds.
//!
//! Bodies that are not round have no such resistance: their shape is one. A patch of them resists
//! turning about its normal instead, by the same spring, k = ratio k_n s^2 up to mu s F_n, s the
//! radius of the patch: its friction acts at one place.

use super::law::Kinematics;
use super::meeting::Layout;
use super::pair::{Meeting, Pair};
use super::response::InverseMass;
use crate::numerics::ROLLING_DAMPING;
use nalgebra::Vector3;

/// Resistance of a contact to the relative spin of its two.
struct Resistance {
    /// The part of the spin that it resists (rad/s).
    spin: Vector3<f64>,
    /// Spring (N m) and the largest torque (N m).
    stiffness: f64,
    limit: f64,
    /// Inverse moment of inertia that the damper counts with (1/(kg m2)).
    inverse: f64,
}

/// The torque (N m) on the first of a pair in contact with this normal force (N), whose rolling
/// spring goes on by a substep.
pub(super) fn resist_turning(
    layout: &Layout,
    pair: &mut Pair,
    kinematics: &Kinematics,
    meeting: &Meeting,
    normal: f64,
) -> Vector3<f64> {
    let h = kinematics.h;
    let material = &layout.law(pair).material;
    let lever =
        if pair.round { material.rolling_friction } else { material.friction * meeting.spread };
    if lever == 0.0 || normal <= 0.0 {
        return Vector3::zeros();
    }
    // A contact that has hardly begun is as stiff as its spring at the depth of a substep's
    // way.
    let depth = kinematics.overlap.max(0.5 * h * kinematics.approach.abs()).max(f64::MIN_POSITIVE);
    let Resistance { spin, stiffness, limit, inverse } = if pair.round {
        Resistance::to_rolling(layout, pair, meeting, normal, depth)
    } else {
        Resistance::to_twisting(layout, pair, meeting, normal, depth)
    };
    let n = kinematics.normal;
    let rolled = &mut pair.springs.rolling;
    let kept = rolled.dot(&n) * n;
    *rolled = h * spin + if pair.round { *rolled - kept } else { kept };
    let spring = stiffness * rolled.norm();
    let (response, its_response) = layout.responses(pair);
    let turns = response.inertia.max() + its_response.map_or(0.0, |its| its.inertia.max());
    let turns = h * turns;
    let rolled = &mut pair.springs.rolling;
    if spring >= limit {
        *rolled *= limit / spring;
        let along = *rolled / rolled.norm();
        // The whole limit, where that does not reverse the spin.
        let stops = spin.dot(&along) / turns.max(f64::MIN_POSITIVE);
        return -limit.min(stops.max(limit / (1.0 + turns * h * stiffness))) * along;
    }
    let damper =
        if inverse > 0.0 { 2.0 * ROLLING_DAMPING * (stiffness / inverse).sqrt() } else { 0.0 };
    let torque = -(stiffness * *rolled + damper * spin) / (1.0 + turns * (h * stiffness + damper));
    torque * (limit / torque.norm()).min(1.0)
}

impl Resistance {
    /// The resistance of round bodies to rolling.
    fn to_rolling(
        layout: &Layout,
        pair: &Pair,
        meeting: &Meeting,
        normal: f64,
        depth: f64,
    ) -> Resistance {
        let (body, other) = layout.two(pair);
        let n = meeting.normal;
        let spin = body.spin - other.map_or(Vector3::zeros(), |other| other.spin);
        let reduced = 1.0 / (1.0 / meeting.radii[0] + 1.0 / meeting.radii[1]);
        let lever = layout.law(pair).material.rolling_friction * reduced;
        let shape = if body.shape().dimension() == 2 { 3.0 } else { 2.25 };
        let part = |response: &InverseMass, arm: &Vector3<f64>| {
            let mass = response.mass.max();
            let inertia = response.inertia.max();
            if mass > 0.0 && inertia > 0.0 {
                1.0 / (1.0 / inertia + arm.norm_squared() / mass)
            } else {
                0.0
            }
        };
        let [arm, its_arm] = &meeting.arms.to;
        let (response, its_response) = layout.responses(pair);
        Resistance {
            spin: spin - spin.dot(&n) * n,
            stiffness: shape * (normal / depth) * lever * lever,
            limit: lever * normal,
            inverse: part(response, arm) + its_response.map_or(0.0, |its| part(its, its_arm)),
        }
    }

    /// The resistance of a patch to turning about its normal.
    fn to_twisting(
        layout: &Layout,
        pair: &Pair,
        meeting: &Meeting,
        normal: f64,
        depth: f64,
    ) -> Resistance {
        let (body, other) = layout.two(pair);
        let n = meeting.normal;
        let spin = body.spin - other.map_or(Vector3::zeros(), |other| other.spin);
        let material = &layout.law(pair).material;
        let about = |response: &InverseMass| n.dot(&response.inertia.of(&n));
        let (response, its_response) = layout.responses(pair);
        Resistance {
            spin: spin.dot(&n) * n,
            stiffness: material.tangential_ratio * (normal / depth) * meeting.spread.powi(2),
            limit: material.friction * meeting.spread * normal,
            inverse: about(response) + its_response.map_or(0.0, about),
        }
    }
}
