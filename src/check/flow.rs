//! The box and its flow: the domain, the fluid, boundaries, drive, Reynolds number, pressure.

use super::layer::{largest_speed, number_of_flow};
use super::particles::{doubled, sticks};
use crate::Result;
use crate::config::{AXES, Case, Particle, Side, Stream, stream};
use crate::scene::{self, Scene};

use crate::words::{brief, rounded};
use mics_run::summary::Need;

/// Part of a velocity that the divergence left by the pressure may change over the box: a tenth of
/// the best accuracy that forces are found to (0.1 %), so that it is never what limits them.
const EXACT: f64 = 1e-4;
/// Part of `EXACT` below which a limit is reported as too tight: two digits more than `EXACT` are a
/// quarter of the iterations.
const TIGHT: f64 = 1e-2;

/// The box, its fluid, what is given at its sides and what drives it, with what may be wrong there.
pub fn describe_box(case: &Case) -> Vec<String> {
    let mut lines = Vec::new();
    for line in case.describe_box() {
        lines.push(line.to_string());
        if line.label == "boundary" {
            lines.extend(outwards(case).into_iter().chain(sticks(case)));
            lines.extend(falls_as_a_whole(case));
        }
    }
    lines.extend(doubled(case));
    lines
}

/// The Reynolds number of the stream, by the largest particle or the height of the box.
pub fn reynolds(case: &Case) -> Option<String> {
    let Stream { speed, length, of, reynolds } = stream(case)?;
    Some(format!(
        "Reynolds     {} (speed {} m/s, {of} {} m)",
        number_of_flow(reynolds),
        rounded(speed),
        rounded(length)
    ))
}

/// Lines about the pressure: its solver, its limit, and what a step needs beside.
pub fn describe_pressure<const D: usize>(case: &Case, scene: &Scene<D>) -> Result<Vec<String>> {
    let mut lines = vec![case.describe_pressure(&scene.solver()?).to_string()];
    lines.extend(tight_pressure(case));
    for Need { what, needed, why } in scene::needs(scene) {
        lines.push(format!("{:<13}{what}: {why}", if needed { "needs" } else { "skips" }));
    }
    Ok(lines)
}

/// A periodic box of free bodies, which accelerates as a whole along gravity where nothing holds
/// it.
fn falls_as_a_whole(case: &Case) -> Option<String> {
    let free = case.particle.iter().all(Particle::is_free);
    let heavy = case.particle.iter().any(|p| p.density() != case.fluid.density);
    let boxed = (0..case.dimension()).all(|axis| case.periodic(axis));
    let x = AXES[case.fluid.gravity.iter().position(|g| *g != 0.0)?];
    (free && heavy && boxed && case.drive.is_none()).then(|| {
        format!(
            "note         nothing holds this periodic box along {x}: fluid and particles \
            accelerate by the particles' weight; drive.mean_velocity = {{ axis = \"{x}\", value = \
            0.0 }} holds it"
        )
    })
}

/// Inflows that take the fluid away.
pub fn outwards(case: &Case) -> Vec<String> {
    let leaves = |face: usize, side: &Side| {
        let out = [-1.0, 1.0][face % 2];
        side.inflow().iter().map(|v| out * v[face / 2]).sum::<f64>() > 0.0
    };
    let sides = case.sides().enumerate().filter(|(face, (_, side))| leaves(*face, side));
    let words = |(face, (name, _)): (usize, (&str, &Side))| {
        let x = AXES[face / 2];
        let sign = if face % 2 == 0 { "positive" } else { "negative" };
        format!(
            "warning      the inflow at {name} leaves the box there; one that enters it has a \
            {sign} velocity along {x}"
        )
    };
    sides.map(words).collect()
}

/// A limit on the divergence that is tighter than what the flow is resolved to, by orders. A
/// divergence below D0 in all cells changes a velocity by D0 L over the length L of the box at the
/// most, where all cells err to the same side.
fn tight_pressure(case: &Case) -> Option<String> {
    let speed = largest_speed(case);
    let limit = case.pressure.divergence_limit;
    let length = case.domain.size.iter().copied().fold(0.0, f64::max);
    let part = limit * length / speed;
    let enough = EXACT * speed / length;
    // A power of ten, rounded down.
    let enough = 10f64.powf(enough.log10().floor());
    (speed > 0.0 && part < TIGHT * EXACT && enough > limit).then(|| {
        format!(
            "note         pressure.divergence_limit = {limit:e} 1/s is tighter than this flow \
            needs: over the whole box it changes a velocity by at most {part:.0e} of {} m/s; \
            {enough:e} keeps that below {EXACT:e}, and saves iterations",
            brief(speed)
        )
    })
}
