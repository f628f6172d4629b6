//! `mics check`: the scene in one screen, without running it: sizes, numbers, limits, what is needed and what is not.

mod blocked;
mod layer;

use crate::config::{Case, Contact, Loaded, PairLaw, Step, Substeps};
use crate::contact::Impact;
use crate::output::print;
use crate::output::snapshot::Snapshot;
use crate::particles::Body;
use crate::petsc::Session;
use crate::run::{check_memory, check_step, choose_step, start_petsc};
use crate::scene::{Scene, impact, read_case};
use crate::system::peak_memory;
use crate::{Error, Result, params};
use blocked::{blocked, driven_axes};
use layer::Layer;
use std::path::Path;
use std::time::Instant;

/// Steps that are tried (and thrown away) to tell the cost of one.
const TRIAL_STEPS: u32 = 3;

/// Cells across a particle below which its flow is not resolved.
const RESOLVED: f64 = 4.0;

/// Reads, checks and describes a case; `quiet`, it is not described, and no step is tried. Collective; rank 0 prints.
///
/// # Errors
/// When the case is wrong.
pub fn check(path: &Path, set: &[String], petsc: &[String], quiet: bool) -> Result<()> {
    let loaded = read_case(path, set)?;
    let session = start_petsc(&loaded.case, petsc)?;
    check_memory(&loaded, &session)?;
    if quiet {
        return match loaded.case.dimension() {
            2 => check_step(&loaded, &Scene::<2>::new(&session, &loaded.case)?.limits()?),
            _ => check_step(&loaded, &Scene::<3>::new(&session, &loaded.case)?.limits()?),
        };
    }
    let lines = match loaded.case.dimension() {
        2 => describe::<2>(&session, &loaded),
        _ => describe::<3>(&session, &loaded),
    };
    let lines = lines.map_err(|e| match e {
        e @ (Error::Run(_) | Error::NotFinite(_)) => loaded.error_at("", format!("its first steps fail: {e}")),
        other => other,
    })?;
    let unused = session.unused_options()?;
    let unused = (!unused.is_empty()).then(|| format!("unused       PETSc options: {}", unused.join(", ")));
    if session.rank() == 0 { lines.iter().chain(&unused).try_for_each(|line| print(line)) } else { Ok(()) }
}

fn describe<const D: usize>(session: &Session, loaded: &Loaded) -> Result<Vec<String>> {
    let case = &loaded.case;
    let started = Instant::now();
    let mut scene = Scene::<D>::new(session, case)?;
    let start_up = started.elapsed().as_secs_f64();
    let limits = scene.limits()?;
    check_step(loaded, &limits)?;
    let (dt, choice) = choose_step(case, &limits, None, case.time.end);

    let times = |v: &[f64]| v.iter().map(|x| format!("{x}")).collect::<Vec<_>>().join(" x ");
    let cells = case.domain.cells.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
    let h = scene.domain.grid.h.iter().map(|h| format!("{h:.4e}")).collect::<Vec<_>>().join(" x ");
    let mut lines = vec![
        format!("case         {} ({D}D)", case.name),
        format!("domain       {} m, {cells} cells, h = {h} m", times(&case.domain.size)),
        format!("fluid        density {} kg/m3, viscosity {} Pa s", case.fluid.density, case.fluid.viscosity),
    ];
    let sides = case.sides().map(|(name, side)| format!("{name} {}", side.describe()));
    lines.push(format!("boundary     {}", sides.collect::<Vec<_>>().join(", ")));
    lines.extend(case.drive.as_ref().map(|drive| format!("drive        {}", drive.describe())));
    if let Some(axis) = case.falls_as_a_whole() {
        let x = ["x", "y", "z"][axis];
        lines.push(format!(
            "note         nothing holds this periodic box along {x}: fluid and particles accelerate by the particles' weight; \
             drive.hold_mixture = true carries it"
        ));
    }
    lines.extend(case.initial.from.as_ref().map(|run| format!("begins       where {run} ended")));
    lines.extend(case.describe_particles().into_iter().map(|(label, words)| format!("{label:<13}{words}")));
    let widest = scene.domain.grid.h.iter().copied().fold(0.0, f64::max);
    let smallest = case.particle.iter().map(|p| p.shape.diameter()).fold(f64::INFINITY, f64::min) / widest;
    if smallest < RESOLVED {
        lines.push(format!(
            "warning      a particle of {smallest:.1} cells is not resolved: {RESOLVED} or more are needed"
        ));
    }
    if let (Some(speed), true) = (case.reference_speed, case.fluid.viscosity > 0.0) {
        let nu = case.fluid.viscosity / case.fluid.density;
        let length = case.particle.iter().map(|p| p.shape.diameter()).fold(0.0, f64::max);
        let (length, of) = if length > 0.0 { (length, "largest diameter") } else { (case.domain.size[1], "height") };
        lines.push(format!("Reynolds     {:.4} (speed {speed} m/s, {of} {length} m)", speed * length / nu));
    }
    lines.extend(layer(case, widest));
    lines.extend(shut(case, &scene));
    for (bound, limit) in limits.bounds().into_iter().filter(|b| b.1.is_finite()) {
        lines.push(format!("step limit   {limit:.4e} s, {bound}"));
    }
    lines.push(format!(
        "step         {dt:.4e} s at the start, {choice}; {} {:.0} steps to t = {} s",
        if let Step::Fixed(_) = case.time.step { "about" } else { "at least" },
        (case.time.end / dt).ceil(),
        case.time.end
    ));
    lines.extend(contacts(case, &scene, dt.min(expected_step(case))));
    lines.push(format!("pressure     {}, until |D| < {:e} 1/s", scene.solver()?, case.pressure.divergence_limit));
    for (what, needed, why) in scene.needs() {
        lines.push(format!("{:<13}{what}: {why}", if needed { "needs" } else { "skips" }));
    }
    let trial = Instant::now();
    for _ in 0..TRIAL_STEPS {
        scene.step(dt)?;
    }
    let step = trial.elapsed().as_secs_f64() / f64::from(TRIAL_STEPS);
    // A run holds its fields once more when it writes them.
    let _fields = Snapshot::take(&mut scene)?;
    let mut memory = [peak_memory()];
    session.sum(&mut memory)?;
    lines.push(format!(
        "cost         {:.2} ms a step ({:.2} us a cell; the first {TRIAL_STEPS} steps tried), start-up {start_up:.2} s, \
         memory {:.0} MB",
        1e3 * step,
        1e6 * step / scene.domain.grid.total_cells() as f64,
        memory[0] / 1e6
    ));
    Ok(lines)
}

/// A driven channel that bodies shut.
pub(crate) fn shut<const D: usize>(case: &Case, scene: &Scene<D>) -> Option<String> {
    let whole = scene.domain.session.size() == 1;
    let axis = driven_axes(case).into_iter().find(|axis| whole && blocked(scene, *axis))?;
    Some(format!(
        "warning      the particles shut the channel along {}, as far as this grid shows gaps between them: what is driven through it has \
         no meaning; open it, or use more cells",
        ["x", "y", "z"][axis]
    ))
}

/// The boundary layer that the grid has to resolve, beside its spacing `h` (m).
fn layer(case: &Case, h: f64) -> Vec<String> {
    let Some(layer) = Layer::thinnest(case) else { return Vec::new() };
    let Layer { particle, falls, speed, reynolds, thickness, diameter } = layer;
    let meets = if falls { "comes to" } else { "meets a flow of" };
    let by = if falls { ", by its drag," } else { "," };
    let mut line = format!("layer        {} {meets} {speed:.3} m/s{by} Re = {reynolds:.0}", case.called(particle));
    if thickness.is_infinite() {
        return vec![line + ": no boundary layer"];
    }
    line += &format!(": a boundary layer of {thickness:.3e} m, {:.2} h", thickness / h);
    let warning = format!(
        "warning      that layer is thinner than a spacing: {:.0} cells a diameter would put one into it, and there are {:.1}",
        layer.cells_needed(),
        diameter / h
    );
    [Some(line), (thickness < h).then_some(warning)].into_iter().flatten().collect()
}

/// The step (s) that `time.cfl` gives at the speeds that bodies come to; infinite where nothing is known of them.
fn expected_step(case: &Case) -> f64 {
    let (Step::Courant(number), Some(layer)) = (case.time.step, Layer::thinnest(case)) else { return f64::INFINITY };
    number * case.spacings().into_iter().fold(f64::INFINITY, f64::min) / layer.speed
}

/// Substeps in a contact below which its restitution is no longer the one asked for.
const COARSE: f64 = 20.0;

/// The stiffnesses that are given and do not hold the impacts to be expected.
fn too_soft(case: &Case, law: &Contact, bodies: &[Body]) -> Option<String> {
    let bound = impact(case, bodies);
    // The speed that a fall comes to by its drag, where that is known.
    let speed = Layer::thinnest(case).map_or(bound.speed, |layer| layer.speed.min(bound.speed));
    let (impact, radius) =
        (Impact { speed, ..bound }, bodies.iter().fold(0.0f64, |most, body| most.max(body.radius())));
    let laws = [&law.law].into_iter().chain(law.pair.iter().map(|pair| &pair.law));
    let depth = |pair: &PairLaw| Some((impact.depth_at(pair.normal_stiffness.given()?, pair.exponent), pair.exponent));
    let (deepest, exponent) = laws.filter_map(depth).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (deepest > params::deepest_overlap() * radius).then(|| {
        format!(
            "warning      contact.normal_stiffness is too small: an impact at {:.3} m/s would go {deepest:.2e} m deep, {:.2} of the \
             radius, and {} ends the run; \"auto\" takes {:.1e}",
            impact.speed,
            deepest / radius,
            params::deepest_overlap(),
            bound.stiffness(exponent),
        )
    })
}

/// The time of a contact beside the substep.
fn contacts<const D: usize>(case: &Case, scene: &Scene<D>, dt: f64) -> Vec<String> {
    let (Some(contacts), Some(law)) = (scene.method.contacts(), &case.contact) else { return Vec::new() };
    // An impact after a fall of a diameter, for springs whose time depends on the speed.
    let bodies = &scene.state.bodies;
    let fall =
        bodies.iter().map(|b| (4.0 * b.radius() * scene.largest_fall()).sqrt() + b.top_speed()).fold(1e-12, f64::max);
    let time = contacts.contact_time(bodies, fall);
    let mut lines = Vec::new();
    let soft = too_soft(case, law, bodies);
    let Substeps::Count(n) = law.substeps else {
        lines.push(format!("contact      shortest {time:.3e} s; substeps chosen by it, where two are in reach"));
        lines.extend(soft);
        return lines;
    };
    let (substep, ratio) = (dt / n as f64, time * n as f64 / dt);
    lines.push(format!("contact      shortest {time:.3e} s, substep {substep:.3e} s: {ratio:.1} substeps a contact"));
    lines.extend(soft);
    if ratio < COARSE {
        lines.push(format!(
            "warning      {ratio:.1} substeps a contact are too few (below {COARSE}): raise contact.substeps to {:.0}, or \
             \"auto\"",
            (COARSE * dt / time).ceil()
        ));
    }
    lines
}
