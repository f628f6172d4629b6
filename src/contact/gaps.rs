//! Forces of the fluid in the gap of a pair; [`super::lubrication`] has formulas.

use super::WallSide;
use super::arms::PairImpulse;
use super::lubrication::Lubrication;
use super::meeting::Layout;
use super::pair::{Meeting, Pair, Partner};
use nalgebra::Vector3;

/// Part of a gap by which it may change before its resistance is found anew.
const SAME_GAP: f64 = 1e-3;

/// Gap that counts as none (of the radius).
const TOUCHING: f64 = 1e-9;

/// Resistance of the fluid in a pair's gap, between these radii of curvature (m), as the gap goes
/// from `gap` to `next` (m): the one found last, where it has hardly changed.
pub(super) fn lubrication(
    layout: &Layout,
    pair: &Pair,
    [radius, other]: [f64; 2],
    gap: f64,
    next: f64,
) -> Lubrication {
    let body = &layout.bodies[pair.first];
    let medium = &layout.setup.medium;
    let last = &pair.film.lubrication;
    // Bodies put down to touch the two sides of a box have gaps that differ by rounding.
    let rounding = TOUCHING * body.radius();
    let [gap, next] = [gap, next].map(|g| if g < rounding { g.min(0.0) } else { g });
    let near = |g: f64| (g - last.gap).abs() <= SAME_GAP * last.gap;
    if (gap <= 0.0 && next <= 0.0 && last.gap == 0.0) || (gap > 0.0 && near(gap) && near(next)) {
        return *last;
    }
    let dimension = body.shape().dimension();
    let side = layout.setup.side(pair);
    if side == Some(WallSide::Inflow) {
        return Lubrication { gap: gap.max(0.0), normal: 0.0, sliding: 0.0, rolling: 0.0 };
    }
    // At a plane of symmetry the lubrication layer is half of that between the body and its
    // mirror image. The two approach alike, turn against each other and go along the plane
    // together: they roll on each other and never slide.
    let mirrored = side == Some(WallSide::Slip);
    let between = |g0: f64, g1: f64| {
        if mirrored {
            2.0 * medium.resistance(dimension, radius, radius, 2.0 * g0, 2.0 * g1)
        } else {
            medium.resistance(dimension, radius, other, g0, g1)
        }
    };
    // A substep that goes through the end of the gap is in it for a part of its time only.
    let touches = (gap <= 0.0) != (next <= 0.0);
    let normal = if touches {
        let wide = gap.max(next);
        let outside = gap.max(next) / (gap - next).abs();
        outside * between(wide, f64::MIN_POSITIVE) + (1.0 - outside) * between(0.0, 0.0)
    } else {
        between(gap, next.max(0.0))
    };
    let [sliding, rolling] = if mirrored {
        [0.0, medium.shear_resistance(dimension, radius, radius, 2.0 * gap)[1]]
    } else {
        medium.shear_resistance(dimension, radius, other, gap)
    };
    Lubrication { gap: if touches { f64::NAN } else { gap.max(0.0) }, normal, sliding, rolling }
}

/// The impulse of the fluid in a pair's gap, with this resistance over a substep (N s^2/m), to
/// surfaces that roll on each other and slide at the speed `slip` (m/s).
pub(super) fn rolling_impulse(
    layout: &Layout,
    pair: &Pair,
    meeting: &Meeting,
    slip: &Vector3<f64>,
    resistance: f64,
) -> PairImpulse {
    let n = meeting.normal;
    let to = &meeting.arms.to;
    // From the centre of the first to that of the second.
    let apart = to[0] - to[1];
    // Distances of the contact from both centres along the normal (m).
    let [arm, its_arm] = [to[0].dot(&n), -to[1].dot(&n)];
    let (body, second) = layout.two(pair);
    let (response, its_response) = layout.responses(pair);
    let other = second.filter(|_| pair.partner == Partner::Body);
    let its_response = its_response.filter(|_| pair.partner == Partner::Body);
    // An obstacle turns the line of centres with it.
    let wall = second.filter(|_| pair.partner == Partner::Obstacle);
    let spin = body.spin - wall.map_or(Vector3::zeros(), |wall| wall.spin);
    if layout.setup.side(pair) == Some(WallSide::Slip) {
        // The mirror image turns the other way, at the same arm.
        let inverse = 0.5 * arm * arm * response.inertia.max();
        let impulse =
            -0.5 * resistance / (1.0 + resistance * inverse) * (arm * body.spin).cross(&n);
        return PairImpulse {
            linear: Vector3::zeros(),
            turns: [arm * n.cross(&impulse), Vector3::zeros()],
        };
    }
    let (spun, lever) = match other {
        Some(other) => (arm * spin - its_arm * other.spin, (arm - its_arm) / (arm + its_arm)),
        None => (arm * spin, -1.0),
    };
    let own = arm * spin + other.map_or(Vector3::zeros(), |other| its_arm * other.spin);
    let moved = slip - own.cross(&n);
    let speed = 0.5 * (spun.cross(&n) + lever * moved);
    let turning = arm * arm * response.inertia.max()
        + its_response.map_or(0.0, |its| its_arm * its_arm * its.inertia.max());
    let masses = response.mass.max() + its_response.map_or(0.0, |its| its.mass.max());
    let inverse = 0.25 * (lever * lever * masses + turning);
    let impulse = -0.5 * resistance / (1.0 + resistance * inverse) * speed;
    let turn = n.cross(&impulse);
    let linear = lever * impulse;
    // The reaction on an obstacle is about its own centre.
    let reaction = match wall {
        Some(_) => apart.cross(&linear) - arm * turn,
        None => -its_arm * turn,
    };
    PairImpulse { linear, turns: [arm * turn, reaction] }
}
