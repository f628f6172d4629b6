//! The rules of measures.

use std::collections::HashSet;

use super::*;
use crate::config::fault::{AXES, Within};
use crate::config::message::unnamed;
use crate::config::particle::printable;

/// Puts indices in place of the names of particles in the measures, swarms turned into particles.
pub(in crate::config) fn name_particles(case: &mut Case) -> Check {
    let names: Vec<Option<&str>> =
        case.particle.iter().map(|particle| particle.name.as_deref()).collect();
    let walls: Vec<Option<&str>> = case.obstacle.iter().map(|o| o.name.as_deref()).collect();
    let found_in = |kind, names: &[Option<&str>], which: &Which, key: &str| match which {
        Which::Id(id) => Ok(vec![*id]),
        Which::Named(name) => {
            let ids: Vec<usize> = (0..names.len()).filter(|id| names[*id] == Some(name)).collect();
            let known = names.iter().flatten().copied();
            ensure!(!ids.is_empty(), key, "{}", unnamed(kind, name, known));
            Ok(ids)
        }
    };
    let found = |which: &Which, key: &str| found_in("particle", &names, which, key);
    let name = |measure: &mut Measure| -> Check {
        if let Some(obstacle) = &measure.obstacle {
            let key = "obstacle";
            let id = found_in("obstacle", &walls, obstacle, key)?[0];
            ensure!(
                id < walls.len(),
                key,
                "there is no obstacle {id}: the case has {}, counted from 0",
                walls.len()
            );
            ensure!(
                measure.particle == Which::default() && measure.particles.is_none(),
                key,
                "stands in place of a particle: remove one of them"
            );
            measure.obstacle = Some(Which::Id(id));
            // As bodies obstacles follow the particles.
            measure.particle = Which::Id(names.len() + id);
            if measure.kind.takes_group() {
                measure.particles = Some(vec![measure.particle.clone()]);
            }
            return Ok(());
        }
        let one = found(&measure.particle, "particle")?;
        let several = "particles have the name: give an index, or a kind that is of several";
        ensure!(one.len() == 1, "particle", "{} {several}", one.len());
        measure.particle = Which::Id(one[0]);
        if let Some(group) = &mut measure.particles {
            let ids =
                group.iter().enumerate().map(|(i, which)| found(which, &format!("particles.{i}")));
            let ids = ids.collect::<Result<Vec<_>, _>>()?.concat();
            let mut once = HashSet::new();
            *group = ids.into_iter().filter(|id| once.insert(*id)).map(Which::Id).collect();
        }
        Ok(())
    };
    for (index, measure) in case.measure.iter_mut().enumerate() {
        name(measure).within(format_args!("measure.{index}"))?;
    }
    Ok(())
}

/// Checks the measures, swarms turned into particles and names into indices.
pub(in crate::config) fn measures(case: &Case) -> Check {
    for (index, measure) in case.measure.iter().enumerate() {
        let own = case.measure[..index].iter().all(|other| other.name != measure.name);
        check(measure, case, own).within(format_args!("measure.{index}"))?;
    }
    Ok(())
}

/// Checks its keys; its name is its `own` where no earlier measure has it.
fn check(measure: &Measure, case: &Case, own: bool) -> Check {
    let Measure { name, kind, from, speed, length, .. } = measure;
    ensure!(!name.is_empty(), "name", "is empty: give each measure a name");
    printable("name", Some(name))?;
    ensure!(own, "name", "\"{name}\" names another measure already: give each its own name");
    not_negative("from", *from, "s")?;
    let end = case.time.end;
    ensure!(
        *from < end,
        "from",
        "must be before time.end: it is {from:?} s, and time.end is {end:?} s; begin the measure \
        earlier, or end the run later"
    );
    positive("speed", *speed, "m/s")?;
    positive("length", *length, "m")?;
    ensure!(
        length.is_none() || kind.needs_speed(),
        "length",
        "is of coefficients of a force and strouhal only"
    );
    ensure!(
        length.is_some() || measure.obstacle.is_none() || !kind.needs_speed(),
        "length",
        "an obstacle has no diameter that a coefficient could refer to: give `length` (m)"
    );
    particles(case, measure)?;
    if let Some(direction) = &measure.direction {
        ensure!(
            kind.has_direction(),
            "direction",
            "is of forces: drag, lift, strouhal, force, torque and force_noise"
        );
        ensure!(
            *kind != MeasureKind::Torque || case.dimension() == 3,
            "direction",
            "is of a torque in 3D only: in 2D it is about z"
        );
        vector("direction", direction, case.dimension(), "of any length")?;
        let some = direction.iter().any(|part| *part != 0.0);
        ensure!(some, "direction", "is nothing but zeros: give a direction, as in [1.0, 0.0]");
    }
    if let Some(about) = &measure.about {
        ensure!(*kind == MeasureKind::Torque, "about", "is of torque only");
        vector("about", about, case.dimension(), "m")?;
    }
    box_keys(case, measure)?;
    needs_of_kind(case, measure)?;
    moment(case, measure)?;
    if kind.needs_speed() {
        let holds = speed.or(case.reference_speed()).is_some();
        ensure!(
            holds,
            "speed",
            "no reference speed, as nothing moves at the start: give `speed` (m/s)"
        );
    }
    reference(measure)
}

/// Checks that the particles of a measure are there.
fn particles(case: &Case, measure: &Measure) -> Check {
    let kind = measure.kind;
    let count = case.particle.len();
    if measure.obstacle.is_some() {
        ensure!(
            kind.has_direction() || kind == MeasureKind::BedShearStress,
            "obstacle",
            "is for forces: drag, lift, strouhal, force, torque, force_noise, bed_shear_stress"
        );
        return Ok(());
    }
    let missing = |id| format!("there is no particle {id}: the case has {count}, counted from 0");
    if kind.needs_particle() {
        let id = measure.particle.id();
        ensure!(id < count, "particle", "{}", missing(id));
    }
    if kind.is_of_group() {
        ensure!(count > 0, "kind", "is of particles, and the case has none");
    }
    if let Some(group) = &measure.particles {
        ensure!(
            kind.takes_group(),
            "particles",
            "is for mean_height, height_rank, fastest_particle, mean_speed, rms_speed, \
            transport_rate, bedload_rate, einstein, bed_shear_stress, shields and force only"
        );
        ensure!(!group.is_empty(), "particles", "is empty: list some, or leave it out for all");
        let unknown = group.iter().map(Which::id).find(|id| *id >= count);
        ensure!(unknown.is_none(), "particles", "{}", missing(unknown.unwrap_or_default()));
    }
    Ok(())
}

/// Checks that the case has what the kind of a measure needs: gravity, a swing, dimensions.
fn needs_of_kind(case: &Case, measure: &Measure) -> Check {
    let kind = measure.kind;
    if kind.needs_gravity() {
        let falls = case.fluid.gravity.iter().any(|g| *g != 0.0);
        ensure!(falls, "kind", "needs fluid.gravity, which says what is high");
    }
    if kind.is_of_grains() {
        let all = || case.particle.iter().filter(|particle| particle.motion != Motion::Fixed);
        let some = measure.particles.is_some() || all().next().is_some();
        ensure!(some, "kind", "is of grains that move, and the case has none: give `particles`");
        let listed = measure.group().map(|id| &case.particle[id]);
        let mut grains = all().filter(|_| measure.particles.is_none()).chain(listed);
        let fluid = case.fluid.density;
        let heavy = grains.all(|grain| grain.density.unwrap_or(fluid) > fluid);
        ensure!(
            heavy || !kind.needs_heavy(),
            "particles",
            "are of grains heavier than the fluid: give them such a `density`, or leave others out"
        );
    }
    if kind.fits_morison() {
        let swings = |motion: &Motion| {
            let Motion::Prescribed(Prescribed { oscillation: Some(o), .. }) = motion else {
                return false;
            };
            o.amplitude.iter().any(|a| *a != 0.0)
        };
        let cure = "give it motion = { prescribed = { oscillation = { amplitude = [...], frequency \
            = ... } } }";
        ensure!(
            swings(&case.particle[measure.particle.id()].motion),
            "kind",
            "is of a particle that swings: {cure}"
        );
    }
    let flat = case.dimension() == 2 || !kind.is_of_line();
    ensure!(flat, "kind", "is for 2D only; in 3D look into the fields");
    let along_z = matches!(kind, MeasureKind::PositionZ | MeasureKind::VelocityZ);
    ensure!(
        case.dimension() == 3 || !along_z,
        "kind",
        "is for 3D only; in 2D measure along x or y"
    );
    Ok(())
}

/// Checks the moment at which a measure is taken.
fn moment(case: &Case, measure: &Measure) -> Check {
    let Some(when) = measure.when else { return Ok(()) };
    ensure!(
        measure.kind.has_moments(),
        "when",
        "is of position_x, velocity_x (y, z), spin and angle only: remove it or change the kind"
    );
    let (at, most, unit) = match when {
        When::Contact => (0.0, 0.0, ""),
        When::X(at) => (at, case.domain.size[0], "m"),
        When::Y(at) => (at, case.domain.size[1], "m"),
        When::Z(at) => (at, case.domain.size.get(2).copied().unwrap_or(0.0), "m"),
        // A measure at a time that is never reached has no value.
        When::Time(at) => (at, f64::INFINITY, "s"),
    };
    ensure!((0.0..=most).contains(&at), "when", "must be from 0 to {most:?} {unit}, not {at:?}");
    Ok(())
}

/// Checks the keys of measures of the whole box.
fn box_keys(case: &Case, measure: &Measure) -> Check {
    let Measure { kind, axis, region, threshold, .. } = measure;
    ensure!(
        axis.is_none() || kind.has_axis(),
        "axis",
        "is of flow_rate, pressure_drop and the like only"
    );
    if let Some(axis) = axis {
        axis.check("axis", case.dimension())?;
    }
    ensure!(
        threshold.is_none() || kind.has_threshold(),
        "threshold",
        "is of bed_height, bed_shear_stress and shields only"
    );
    positive("threshold", *threshold, "a solid fraction, such as 0.1")?;
    ensure!(
        threshold.is_none_or(|t| t < 1.0),
        "threshold",
        "is a solid fraction: it must be below 1"
    );
    if let Some(Region { min, max }) = region {
        ensure!(
            *kind == MeasureKind::SolidFraction || kind.is_of_shear(),
            "region",
            "is of solid_fraction, bed_shear_stress and shields only"
        );
        vector("region.min", min, case.dimension(), "m")?;
        vector("region.max", max, case.dimension(), "m")?;
        let holds = min.iter().zip(max).all(|(min, max)| min < max);
        ensure!(holds, "region", "its max must be above its min along every axis");
        for (axis, (size, cells)) in case.domain.size.iter().zip(&case.domain.cells).enumerate() {
            let h = size / *cells as f64;
            // The centres of cells from the first above its min to the last below its max.
            let [first, last] =
                [(min[axis] / h - 0.5).ceil().max(0.0), (max[axis] / h - 0.5).floor()];
            let holds = first <= last.min(*cells as f64 - 1.0);
            let x = AXES[axis];
            ensure!(
                holds,
                "region",
                "has no centre of a cell in it along {x}, {h:?} m apart in the box: make it wider"
            );
        }
    }
    let driven = case.drive.is_some() || *kind != MeasureKind::DriveForce;
    ensure!(driven, "kind", "is of a drive, and the case has none: give [drive]");
    Ok(())
}

/// Checks the reference of a measure and its tolerance.
fn reference(measure: &Measure) -> Check {
    let given = measure.reference.is_some();
    ensure!(
        given || measure.tolerance.is_none(),
        "tolerance",
        "is of a reference: give `reference` or remove it"
    );
    ensure!(
        given || measure.source.is_none(),
        "source",
        "is that of a reference: give `reference` or remove it"
    );
    match measure.reference {
        None => return Ok(()),
        Some(Reference::Value(value)) => {
            let holds = value.is_finite() && value != 0.0;
            ensure!(
                holds,
                "reference",
                "must be finite and not 0; around 0 give a band [low, high], not {value:?}"
            );
            let cure = "a number needs a tolerance, as a part of it: tolerance = 0.02 is 2 %";
            ensure!(measure.tolerance.is_some(), "tolerance", "is missing: {cure}");
        }
        Some(Reference::Band([low, high])) => {
            let holds = low.is_finite() && high.is_finite() && low <= high;
            ensure!(
                holds,
                "reference",
                "a band is [low, high], both finite, not [{low:?}, {high:?}]"
            );
        }
    }
    not_negative("tolerance", measure.tolerance, "a part of the reference")
}
