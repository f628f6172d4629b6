//! From a checked raw case to values: the defaults that depend on other keys, and one value of keys
//! that exclude each other.

mod bodies;

use super::direction;
use super::fault::Fault;
use super::raw::{self, Side, WallRule, Which};
use super::resolved::{Case, Measure, Motion, Target};

use bodies::{obstacle, particle};
use nalgebra::Vector3;

/// The solid fraction of the top of a bed.
const BED_FRACTION: f64 = 0.1;
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
    let usual = inflow(&raw).unwrap_or(rest.clone());
    let resting = raw.particle.iter().filter(|p| p.motion == raw::Motion::Fixed).count();
    let entrances: Vec<_> = raw.particle.iter().map(|p| p.entrance(&raw)).collect();
    let mut initial = raw.initial;
    if initial.velocity.is_empty() {
        initial.velocity = usual;
    }
    let mut fluid = raw.fluid;
    if fluid.gravity.is_empty() {
        fluid.gravity.clone_from(&rest);
    }
    let mut contact = raw.contact;
    if let Some(contact) = &mut contact {
        contact.fill(smallest(&raw.particle));
    }
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
        contact,
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
    let diameters = particles.iter().map(|p| p.shape.diameter());
    diameters.reduce(f64::min).unwrap_or(0.0)
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
