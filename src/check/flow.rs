//! The box and its flow: the domain, the fluid, boundaries, drive, Reynolds number, pressure.

use super::layer::{largest_speed, number_of_flow};
use super::particles::{doubled, sticks};
use crate::Result;
use crate::config::{Case, Side};
use crate::scene::Scene;
use crate::words::{brief, number, rounded};

/// Part of a velocity that the divergence left by the pressure may change over the box: a tenth of
/// the best accuracy that forces are found to (0.1 %), so that it is never what limits them.
const EXACT: f64 = 1e-4;
/// How far below that a limit has to be to be worth a word: two digits more than that are a quarter
/// of the iterations.
const TIGHT: f64 = 1e-2;

/// The box, its fluid, what is given at its sides and what drives it.
pub fn describe_box<const D: usize>(case: &Case, h: &[f64; D]) -> Vec<String> {
    let times = |v: &[f64]| v.iter().map(|x| number(*x)).collect::<Vec<_>>().join(" x ");
    let cells = case.domain.cells.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
    let h = h.iter().map(|h| format!("{h:.4e}")).collect::<Vec<_>>().join(" x ");
    let mut lines = vec![
        format!("case         {} ({D}D)", case.name),
        format!("domain       {} m, {cells} cells, h = {h} m", times(&case.domain.size)),
        format!(
            "fluid        density {} kg/m3, viscosity {} Pa s, {}",
            number(case.fluid.density),
            number(case.fluid.viscosity),
            match case.fluid.gravity.iter().all(|g| *g == 0.0) {
                true => "no gravity".to_owned(),
                false => format!("gravity {:?} m/s2", case.fluid.gravity),
            }
        ),
    ];
    let sides = case.sides().map(|(name, side)| format!("{name} {}", side.describe()));
    lines.push(format!("boundary     {}", sides.collect::<Vec<_>>().join(", ")));
    lines.extend(outwards(case).into_iter().chain(sticks(case)));
    lines.extend(case.drive.as_ref().map(|drive| format!("drive        {}", drive.describe())));
    if let Some(axis) = case.falls_as_a_whole() {
        let x = ["x", "y", "z"][axis];
        lines.push(format!(
            "note         nothing holds this periodic box along {x}: fluid and particles \
            accelerate by the particles' weight; drive.mean_velocity = {{ axis = \"{x}\", value = \
            0.0 }} holds it"
        ));
    }
    lines.extend(
        case.initial.from.as_ref().map(|run| format!("begins       where {run} has come to")),
    );
    lines.extend(doubled(case));
    lines
}

/// The Reynolds number of the stream, by the largest particle or the height of the box.
pub fn reynolds(case: &Case) -> Option<String> {
    let speed = case.reference_speed().filter(|_| case.fluid.viscosity > 0.0)?;
    let nu = case.fluid.viscosity / case.fluid.density;
    let diameter = case.particle.iter().map(|p| p.shape.diameter()).fold(0.0, f64::max);
    let (length, of) = match diameter > 0.0 {
        true => (diameter, "largest diameter"),
        false => (case.domain.size[1], "height"),
    };
    Some(format!(
        "Reynolds     {} (speed {} m/s, {of} {} m)",
        number_of_flow(speed * length / nu),
        number(speed),
        rounded(length)
    ))
}

/// What solves for the pressure, how far, and what a step needs beside.
pub fn describe_pressure<const D: usize>(case: &Case, scene: &Scene<D>) -> Result<Vec<String>> {
    let solver = scene.solver()?;
    let limit = case.pressure.divergence_limit;
    let mut lines = vec![format!("pressure     {solver}, until |D| < {limit:e} 1/s")];
    lines.extend(tight_pressure(case));
    for (what, needed, why) in scene.needs() {
        lines.push(format!("{:<13}{what}: {why}", if needed { "needs" } else { "skips" }));
    }
    Ok(lines)
}

/// Inflows that take the fluid away.
pub fn outwards(case: &Case) -> Vec<String> {
    let leaves = |face: usize, side: &Side| {
        let out = [-1.0, 1.0][face % 2];
        side.inflow().iter().map(|v| out * v[face / 2]).sum::<f64>() > 0.0
    };
    let sides = case.sides().enumerate().filter(|(face, (_, side))| leaves(*face, side));
    let words = |(face, (name, _)): (usize, (&str, &Side))| {
        let (x, sign) =
            (["x", "y", "z"][face / 2], if face % 2 == 0 { "positive" } else { "negative" });
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
