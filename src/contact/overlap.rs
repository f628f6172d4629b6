//! Refusal of overlaps that are too deep, with what would have held them.

use super::Contacts;
use super::law::Kinematics;
use super::pair::Pair;
use crate::Error;
use crate::particles::Body;
use nalgebra::Vector3;

impl Contacts {
    /// A locked axis along which a body of the pair is driven on: its number, the axis, and its
    /// velocity there (m/s).
    pub(super) fn driven_on(
        &self,
        pair: &Pair,
        bodies: &[Body],
        kinematics: &Kinematics,
    ) -> Option<(usize, usize, f64)> {
        let locked = [pair.first, pair.second]
            .into_iter()
            .filter(|&k| k < bodies.len() && self.inverse_masses[k].whole > 0.0);
        let axes = locked
            .flat_map(|k| (0..3).map(move |axis| (k, axis)))
            .filter(|(k, axis)| self.inverse_masses[*k].mass[*axis] == 0.0);
        let along = |(k, axis): (usize, usize)| bodies[k].velocity[axis];
        let fast = axes.filter(|&at| {
            (along(at) * kinematics.normal[at.1]).abs() > 0.5 * kinematics.approach.abs()
        });
        fast.max_by(|&a, &b| along(a).abs().total_cmp(&along(b).abs()))
            .map(|at| (at.0, at.1, along(at)))
    }

    pub(super) fn too_deep(
        &self,
        pair: &Pair,
        bodies: &[Body],
        kinematics: &Kinematics,
        (limit, radius): (f64, f64),
    ) -> Error {
        if let Some((k, axis, velocity)) = self.driven_on(pair, bodies, kinematics) {
            return Error::Run(format!(
                "{} overlap by {:.3e} m, {:.2} of the smaller radius, where {:.2} is the limit: \
                {} goes on along {} at {velocity:.3e} m/s, \
                 which is locked, so that nothing stops it; unlock that axis, give it no velocity \
                 along it, or end the run before",
                self.name(pair),
                kinematics.overlap,
                kinematics.overlap / radius,
                limit / radius,
                self.names[k],
                ["x", "y", "z"][axis],
            ));
        }
        let (overlap, law, mass) =
            (kinematics.overlap, self.law(pair), kinematics.mass_of_overlap());
        let exponent = law.material.exponent;
        // What strikes, or presses by what pushes the two, stopped at a tenth of the limit.
        let accelerations = |k: usize| {
            self.inverse_masses
                .get(k)
                .map_or_else(Vector3::zeros, |inverse_mass| inverse_mass.accelerations.acceleration)
        };
        let (depth, pressed) =
            (0.1 * limit, mass * (accelerations(pair.first) - accelerations(pair.second)).norm());
        let energy = law.stored(overlap) + 0.5 * mass * kinematics.approach.powi(2);
        let enough = ((exponent + 1.0) * energy / depth.powf(exponent + 1.0))
            .max(pressed / depth.powf(exponent));
        Error::Run(format!(
            "{} overlap by {overlap:.3e} m, {:.2} of the smaller radius, where {:.2} is the \
            limit, at {:.3e} m/s: its stiffness is too small for what strikes or presses it; \
            contact.normal_stiffness = {:.1e} would hold it (\"auto\" knows impacts and weights, \
            not the pressure in a passage that a body shuts), or a shorter step; what is \
            prescribed to press them together no stiffness holds",
            self.name(pair),
            overlap / radius,
            limit / radius,
            kinematics.approach.abs(),
            enough.max(2.0 * law.material.normal_stiffness),
        ))
    }
}
