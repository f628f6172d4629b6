//! From a checked raw case to values: the defaults that depend on other keys, and one value of keys
//! that exclude each other.

mod bodies;

use super::direction;
use super::fault::Fault;
use super::raw::{self, Side, Stiffness, WallRule, Which};
use super::resolved::{
    Case, Contact, Initial, Loss, Measure, Motion, Pair, PairLaw, Target,
};

use bodies::{obstacle, particle};
use nalgebra::Vector3;

/// Height of the asperities where none is given, of the smallest radius.
const ROUGHNESS: f64 = 2e-4;
/// The solid fraction of the top of a bed.
const BED_FRACTION: f64 = 0.1;
/// The restitution where neither it nor a damping is given.
const RESTITUTION: f64 = 0.5;

/// The meaning of a checked case whose swarms are among its particles.
pub(super) fn resolve(raw: raw::Case) -> Result<Case, Fault> {
    let rest = vec![0.0; raw.dimension()];
    let reference_speed = raw.reference_speed();
    let stream = raw.reference_velocity();
    let directions =
        raw.measure.iter().enumerate().map(|(index, m)| {
            Ok((direction::of(&raw, index, m)?, direction::axis(&raw, index, m)?))
        });
    let directions = directions.collect::<Result<Vec<_>, _>>()?;
    let velocity = raw.initial.velocity.clone().or_else(|| inflow(&raw)).unwrap_or(rest.clone());
    let resting = raw.particle.iter().filter(|p| p.motion == raw::Motion::Fixed).count();
    let entrances: Vec<_> = raw.particle.iter().map(|p| p.entrance(&raw)).collect();
    let initial = initial(raw.initial, velocity);
    let mut fluid = raw.fluid;
    if fluid.gravity.is_empty() {
        fluid.gravity.clone_from(&rest);
    }
    let smallest = smallest(&raw.particle);
    let force = raw.coupling.wall.force();
    let count = raw.particle.len();
    let walls = raw.obstacle.into_iter().enumerate().map(|(k, o)| obstacle(k, o, &rest));
    let obstacle = walls.collect::<Result<Vec<_>, _>>()?;
    let bodies = count + obstacle.len();
    let moves = resting < count || obstacle.iter().any(|o| o.motion != Motion::Fixed);
    let mut time = raw.time;
    time.fill(raw.coupling.wall == WallRule::Mixing && bodies > 0, bodies > 0, moves)?;
    let mut output = raw.output;
    output.fill(count, resting);
    let measures = raw.measure.into_iter().zip(directions);
    let case = Case {
        name: raw.name,
        preset: raw.preset,
        boundary: sides(raw.boundary),
        particle: (raw.particle.into_iter().zip(entrances).enumerate())
            .map(|(index, (p, at))| particle(index, p, at, &fluid, &rest))
            .collect::<Result<_, _>>()?,
        contact: raw.contact.map(|c| contact(c, smallest)).transpose()?,
        time,
        obstacle,
        measure: measures
            .map(|(m, direction)| measure(m, direction, reference_speed, (force, count)))
            .collect(),
        output,
        domain: raw.domain,
        coupling: raw.coupling,
        pressure: raw.pressure,
        petsc: raw.petsc,
        statistics: raw.statistics,
        probe: raw.probe,
        fluid,
        initial,
        drive: raw.drive,
        reference_speed,
        stream,
    };
    Ok(case)
}

/// The conditions at the low and the high face of each axis.
fn sides(raw: raw::Boundary) -> Vec<[Side; 2]> {
    let raw::Boundary { west, east, south, north, bottom, top } = raw;
    let along_z = bottom.zip(top).map(|(bottom, top)| [bottom, top]);
    [[west, east], [south, north]].into_iter().chain(along_z).collect()
}

/// The smallest diameter (m) of a particle; 0 without any.
fn smallest(particles: &[raw::Particle]) -> f64 {
    let diameters = particles.iter().filter_map(|p| Some(p.built()?.diameter()));
    diameters.reduce(f64::min).unwrap_or(0.0)
}

/// What is there at time 0, with this velocity of the fluid (m/s).
fn initial(raw: raw::Initial, velocity: Vec<f64>) -> Initial {
    let raw::Initial { from, inherited, taylor_green, couette, perturbation, .. } = raw;
    let perturbation = perturbation.unwrap_or(0.0);
    Initial { from, inherited, velocity, perturbation, taylor_green, couette }
}

/// The velocity (m/s) of the first inflow, at its middle.
fn inflow(raw: &raw::Case) -> Option<Vec<f64>> {
    let middle = |(face, side): (usize, Option<&Side>)| match side? {
        Side::Inflow(v) | Side::InflowParabola(v) => Some(v.clone()),
        Side::InflowProfile(p) => Some(p.velocity_at(0.5 * raw.domain.size[usize::from(face < 2)])),
        _ => None,
    };
    raw.sides().into_iter().enumerate().find_map(middle)
}

/// The contacts of a case whose smallest particle has this diameter (m).
fn contact(raw: raw::Contact, smallest: f64) -> Result<Contact, Fault> {
    let law = PairLaw {
        normal_stiffness: raw.normal_stiffness,
        exponent: raw.exponent,
        tangential_ratio: raw.tangential_ratio,
        friction: raw.friction,
        rolling_friction: raw.rolling_friction,
        loss: loss(raw.restitution, raw.damping).unwrap_or(Loss::Restitution(RESTITUTION)),
    };
    let pair = |(index, raw): (usize, &raw::Pair)| {
        let law = PairLaw {
            normal_stiffness: raw.normal_stiffness.map_or(law.normal_stiffness, Stiffness::Given),
            exponent: raw.exponent.unwrap_or(law.exponent),
            tangential_ratio: raw.tangential_ratio.unwrap_or(law.tangential_ratio),
            friction: raw.friction.unwrap_or(law.friction),
            rolling_friction: raw.rolling_friction.unwrap_or(law.rolling_friction),
            loss: loss(raw.restitution, raw.damping).unwrap_or(law.loss),
        };
        Ok(Pair { between: raw.materials(index)?.map(str::to_owned), law })
    };
    Ok(Contact {
        law,
        pair: raw.pair.iter().enumerate().map(pair).collect::<Result<_, _>>()?,
        roughness: raw.roughness.unwrap_or(0.5 * ROUGHNESS * smallest),
        substeps: raw.substeps,
        tangential_damping: raw.tangential_damping,
    })
}

fn loss(restitution: Option<f64>, damping: Option<raw::Damping>) -> Option<Loss> {
    restitution.map(Loss::Restitution).or(damping.map(Loss::Damping))
}

/// A measure along this direction and axis of a case with this reference speed (m/s), this force of
/// its method and so many particles.
fn measure(
    raw: raw::Measure,
    (direction, axis): (Option<Vector3<f64>>, usize),
    reference_speed: Option<f64>,
    (force, count): (raw::ForceRule, usize),
) -> Measure {
    let raw::Measure { name, kind, particle, particles, from, when, speed, force: own, .. } = raw;
    let raw::Measure { reference, tolerance, source, region, threshold, length, .. } = raw;
    let all = || (0..count).collect();
    let listed = |particles: Vec<Which>| particles.iter().map(Which::id).collect();
    let group = if kind.is_of_group() { particles.map_or_else(all, listed) } else { Vec::new() };
    let target = |reference| Target { reference, tolerance: tolerance.unwrap_or(0.0), source };
    Measure {
        name,
        kind,
        particle: particle.id(),
        particles: group,
        axis,
        region: region.map(|region| [region.min, region.max]),
        threshold: threshold.unwrap_or(BED_FRACTION),
        direction,
        from,
        when,
        speed: speed.or(reference_speed.filter(|_| kind.needs_speed())),
        length,
        force: own.filter(|_| kind.is_of_force()).unwrap_or(force),
        target: reference.map(target),
    }
}

#[cfg(test)]
mod tests {
    use super::super::WALL;
    use super::*;
    use crate::config::Damping;

    fn resolved(keys: &str) -> Contact {
        let raw = toml::from_str(&format!("normal_stiffness = 1e5\n{keys}")).unwrap();
        contact(raw, 0.1).unwrap_or_else(|fault| panic!("{}: {}", fault.key, fault.message))
    }

    #[test]
    fn contact_law_without_pairs_has_table_defaults() {
        let expected = PairLaw {
            normal_stiffness: Stiffness::Given(1e5),
            exponent: 1.0,
            tangential_ratio: 2.0 / 7.0,
            friction: 0.0,
            rolling_friction: 0.0,
            loss: Loss::Restitution(0.5),
        };
        assert_eq!(resolved("").between("steel", WALL), expected);
    }

    #[test]
    fn contact_pair_overrides_its_keys_only() {
        let contact = resolved(
            "damping = { normal = 1.0, tangential = 2.0 }\nfriction = 0.1\n\
            pair = [{ between = [\"steel\", \"wall\"], friction = 0.4, restitution = 0.9 }]",
        );
        let pair = contact.between(WALL, "steel");
        let rest = contact.between("steel", "steel");
        assert_eq!((pair.friction, pair.loss), (0.4, Loss::Restitution(0.9)));
        assert_eq!(pair, contact.between("steel", WALL));
        assert_eq!(
            (rest.friction, rest.loss),
            (0.1, Loss::Damping(Damping { normal: 1.0, tangential: 2.0 }))
        );
        assert_eq!(pair.normal_stiffness, rest.normal_stiffness);
    }
}
