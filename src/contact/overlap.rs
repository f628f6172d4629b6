//! Refusal of overlaps that are too deep, with what would have held them.

use super::DEEPEST_OVERLAP;
use super::law::Kinematics;
use super::meeting::Layout;
use super::pair::Pair;
use super::response::InverseMass;
use crate::Error;
use crate::particles::Body;
use mics_shapes::Core;
use nalgebra::Vector3;

/// Part of the skins of two parts, together, that an overlap may take: cores are never to meet.
const MOST_OF_SKINS: f64 = 0.9;

/// The deepest overlap that a soft contact may have.
pub(super) struct Deepest {
    /// Deepest overlap (m).
    pub(super) overlap: f64,
    /// The length that it is a part of, and which part, in words for the user.
    cause: &'static str,
}

/// A locked axis along which a body of the pair is driven on: its number, the axis, and its
/// velocity there (m/s).
fn driven_on(layout: &Layout, pair: &Pair, kinematics: &Kinematics) -> Option<(usize, usize, f64)> {
    let Layout { states, bodies, .. } = *layout;
    let free = |k: &usize| states.get(*k).is_some_and(|its| its.response.whole > 0.0);
    let axes = [pair.first, pair.second]
        .into_iter()
        .filter(free)
        .flat_map(|k| (0..3).map(move |axis| (k, axis)))
        .filter(|&(k, axis)| states[k].response.mass[axis] == 0.0);
    let along = |(k, axis): (usize, usize)| bodies[k].velocity[axis];
    let fast = axes.filter(|&at| {
        (along(at) * kinematics.normal[at.1]).abs() > 0.5 * kinematics.approach.abs()
    });
    fast.max_by(|&a, &b| along(a).abs().total_cmp(&along(b).abs()))
        .map(|at| (at.0, at.1, along(at)))
}

/// Deepest overlap that a pair may have as a soft contact.
pub(super) fn deepest_allowed(pair: &Pair, bodies: &[Body]) -> Deepest {
    // Radius, and what an overlap may take of it before cores meet (m).
    let of = |k: usize, part: usize| {
        let Some(body) = bodies.get(k) else { return [f64::INFINITY; 2] };
        if body.is_obstacle() {
            return [f64::INFINITY, 0.0];
        }
        let Some(part) = body.parts().get(part) else { return [body.radius(); 2] };
        [part.radius, if part.core == Core::Point { part.radius } else { part.rounding }]
    };
    let [radius, skin] = of(pair.first, pair.parts[0]);
    let [its_radius, its_skin] = of(pair.second, pair.parts[1]);
    let part = DEEPEST_OVERLAP * radius.min(its_radius);
    let skins = MOST_OF_SKINS * (skin + its_skin);
    if skins < part {
        let cause = "nine tenths of the skins that contacts give bodies with edges or curves, \
                     a twentieth of their half width; `rounding` makes those of edges thicker";
        return Deepest { overlap: skins, cause };
    }
    Deepest { overlap: part, cause: "a fifth of the smaller radius" }
}

/// The error of an overlap that is deeper than `limit`.
pub(super) fn too_deep(
    layout: &Layout,
    pair: &Pair,
    kinematics: &Kinematics,
    limit: &Deepest,
) -> Error {
    let overlap = kinematics.overlap;
    let what = format!(
        "{} overlap by {overlap:.3e} m, where {:.3e} m is the limit ({})",
        layout.setup.name(pair),
        limit.overlap,
        limit.cause
    );
    if let Some((k, axis, velocity)) = driven_on(layout, pair, kinematics) {
        return Error::Run(format!(
            "{what}: {} goes on along {} at {velocity:.3e} m/s, which is locked, so that \
             nothing stops it; unlock that axis, give it no velocity along it, or end the run \
             before",
            layout.setup.names[k],
            ["x", "y", "z"][axis],
        ));
    }
    let law = layout.law(pair);
    let mass = kinematics.mass_of_overlap();
    let exponent = law.material.exponent;
    // The stiffness stops what strikes, or is pressed by accelerations, at a tenth of the limit.
    let acceleration = |response: &InverseMass| response.accelerations.acceleration;
    let (response, its_response) = layout.responses(pair);
    let pushed = acceleration(response) - its_response.map_or_else(Vector3::zeros, acceleration);
    let depth = 0.1 * limit.overlap;
    let pressed = mass * pushed.norm();
    let energy = law.stored(overlap) + 0.5 * mass * kinematics.approach.powi(2);
    let enough = ((exponent + 1.0) * energy / depth.powf(exponent + 1.0))
        .max(pressed / depth.powf(exponent));
    Error::Run(format!(
        "{what}, at {:.3e} m/s: its stiffness is too small for what strikes or presses it; \
        contact.normal_stiffness = {:.1e} would hold it (\"auto\" knows impacts and weights, \
        not the pressure in a passage that a body shuts), or a shorter step; what is \
        prescribed to press them together no stiffness holds",
        kinematics.approach.abs(),
        enough.max(2.0 * law.material.normal_stiffness),
    ))
}
