//! `mics check`: the scene in one screen, without running it: sizes, numbers, limits, what is
//! needed and what is not.

mod blocked;
mod disk;
mod layer;
mod memory;
mod pace;
mod path;
mod stiffness;

use crate::config::{Cadence, Case, Checkpoints, Contact, Loaded, Particle, Side, WallRule};
use crate::method::sharp::gap_reach;
use crate::particles::Body;
use crate::petsc::Session;
use crate::scene::{Scene, read_case};
use crate::scheme::Limits;
use crate::step_size::{check_step, choose_step};
use crate::system::peak_memory;
use crate::words::{brief, minutes, number, size, whole};
use crate::{Error, Result};
use blocked::{refuse_shut, shut};
use disk::Disk;
use layer::{Layer, Walls};
pub use memory::check_memory;
use mics_run::print;
pub use pace::expected_rest;
use pace::{Pace, later_step, steps};
use path::{locked_into, run_into};
use std::path::Path;
use std::time::Instant;
use stiffness::{contacts, refuse_too_stiff};

/// Steps that are tried (and thrown away) to tell the cost of one.
const TRIAL_STEPS: u32 = 3;

/// Reynolds number beyond which the units are in doubt.
const DOUBTFUL: f64 = 1e6;

/// Cells across a particle below which its flow is not resolved, and below which its forces are off
/// by many per cent.
const RESOLVED: f64 = 4.0;
const GOOD: f64 = 8.0;

/// Density ratios of particles in contact for which contacts hold.
const IN_CONTACT: std::ops::RangeInclusive<f64> = 0.5..=1e4;
/// Largest ratio of the diameters of two particles in contact for which contacts hold.
const MOST_SIZE_RATIO: f64 = 10.0;
/// Part of a velocity that the divergence left by the pressure may change over the box: a tenth of
/// the best accuracy that forces are found to (0.1 %), so that it is never what limits them.
const EXACT: f64 = 1e-4;
/// How far below that a limit has to be to be worth a word: two digits more than that are a quarter
/// of the iterations.
const TIGHT: f64 = 1e-2;
/// Density ratios beyond which a unit may be wrong.
const USUAL: std::ops::Range<f64> = 0.01..100.0;

/// Reads, checks and describes a case; `quiet`, it is not described, and no step is tried.
/// Collective; rank 0 prints.
///
/// # Errors
/// When the case is wrong.
pub fn check(path: &Path, set: &[String], petsc: &[String], quiet: bool) -> Result<()> {
    let loaded = read_case(path, set)?;
    let session = Session::start_by(&loaded.case.petsc.options, petsc)?;
    check_memory(&loaded, &session)?;
    if quiet {
        return match loaded.case.dimension() {
            2 => refuse(&loaded, &Scene::<2>::new(&session, &loaded.case)?),
            _ => refuse(&loaded, &Scene::<3>::new(&session, &loaded.case)?),
        };
    }
    let lines = match loaded.case.dimension() {
        2 => describe::<2>(&session, &loaded),
        _ => describe::<3>(&session, &loaded),
    };
    let lines = lines.map_err(|e| match e {
        e @ (Error::Run(_) | Error::NotFinite(_)) => {
            loaded.error_at("", format!("its first steps fail: {e}"))
        }
        other => other,
    })?;
    let lines = [lines, loaded.notes.clone()].concat();
    let unused = session.unused_options()?;
    let unused =
        (!unused.is_empty()).then(|| format!("unused       PETSc options: {}", unused.join(", ")));
    if session.rank() == 0 {
        lines.iter().chain(&unused).try_for_each(|line| print(line))
    } else {
        Ok(())
    }
}

/// Refuses a scene before its first step: a step over a limit, a shut channel, free particles that
/// no cell resolves, contacts that are too stiff for the steps.
pub(crate) fn refuse<const D: usize>(loaded: &Loaded, scene: &Scene<D>) -> Result<()> {
    check_step(loaded, &scene.limits()?)?;
    refuse_shut(loaded, scene)?;
    refuse_below_a_cell(loaded)?;
    refuse_too_stiff(loaded, scene)
}

/// Refuses free particles that are smaller than a cell: nothing of the flow around them is found,
/// and the box is most likely in another unit than they are.
fn refuse_below_a_cell(loaded: &Loaded) -> Result<()> {
    let case = &loaded.case;
    let free = case.particle.iter().any(Particle::is_free);
    let Some(cells) = cells_across(case).filter(|cells| free && *cells < 1.0) else {
        return Ok(());
    };
    Err(loaded.error_at(
        "domain.size",
        format!(
            "the smallest particle is {} cells across, and {RESOLVED} or more are needed: if the \
            box is in another unit than the diameters, \
             write both in m; else give domain.cells more",
            brief(cells)
        ),
    ))
}

/// What a run has to be warned of before it begins. Collective.
pub(crate) fn warnings<const D: usize>(case: &Case, scene: &Scene<D>) -> Result<Vec<String>> {
    let later = later_step(case, &scene.limits()?);
    let (coarse, shut) = (unresolved(case), shut(case, scene));
    let all = experiment(case)
        .into_iter()
        .chain(outwards(case))
        .chain(sticks(case))
        .chain(coarse)
        .chain(layer(case))
        .chain(shut)
        .chain(run_into(case, scene))
        .chain(locked_into(case, scene))
        .chain(contacts(case, scene, later));
    Ok(all.filter(|line| line.starts_with("warning")).collect())
}

fn describe<const D: usize>(session: &Session, loaded: &Loaded) -> Result<Vec<String>> {
    let case = &loaded.case;
    let started = Instant::now();
    let mut scene = Scene::<D>::new(session, case)?;
    let start_up = started.elapsed().as_secs_f64();
    refuse(loaded, &scene)?;
    let limits = scene.limits()?;
    let (dt, choice) = choose_step(case, &limits, None, case.time.end);

    let times = |v: &[f64]| v.iter().map(|x| number(*x)).collect::<Vec<_>>().join(" x ");
    let cells = case.domain.cells.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
    let h = scene.domain.grid.h.iter().map(|h| format!("{h:.4e}")).collect::<Vec<_>>().join(" x ");
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
    lines.extend(experiment(case).into_iter().chain(outwards(case)).chain(sticks(case)));
    lines.extend(case.drive.as_ref().map(|drive| format!("drive        {}", drive.describe())));
    if let Some(axis) = case.falls_as_a_whole() {
        let x = ["x", "y", "z"][axis];
        lines.push(format!(
            "note         nothing holds this periodic box along {x}: fluid and particles \
            accelerate by the particles' weight; \
             drive.hold_mixture = true carries it"
        ));
    }
    lines.extend(
        case.initial.from.as_ref().map(|run| format!("begins       where {run} has come to")),
    );
    lines.extend(doubled(case));
    lines.extend(
        case.describe_particles().into_iter().map(|(label, words)| format!("{label:<13}{words}")),
    );
    lines.extend(
        case.contact
            .iter()
            .flat_map(Contact::describe)
            .map(|words| format!("materials    {words}")),
    );
    lines.extend(untouchable(case));
    lines.extend(
        unresolved(case)
            .into_iter()
            .chain(unusual(case))
            .chain(out_of_range(case))
            .chain(mixed_impacts(case)),
    );
    if let (Some(speed), true) = (case.reference_speed, case.fluid.viscosity > 0.0) {
        let nu = case.fluid.viscosity / case.fluid.density;
        let length = case.particle.iter().map(|p| p.shape.diameter()).fold(0.0, f64::max);
        let (length, of) = if length > 0.0 {
            (length, "largest diameter")
        } else {
            (case.domain.size[1], "height")
        };
        lines.push(format!(
            "Reynolds     {} (speed {} m/s, {of} {} m)",
            number_of_flow(speed * length / nu),
            number(speed),
            number(length)
        ));
    }
    lines.extend(layer(case));
    lines.extend(shut(case, &scene));
    lines.extend(
        run_into(case, &scene)
            .into_iter()
            .chain(locked_into(case, &scene))
            .chain(pressed(case, &scene)),
    );
    let explicit = Limits { scheme: limits.scheme.explicit(), ..limits };
    for ((bound, limit), (_, first)) in
        limits.bounds().into_iter().zip(explicit.bounds()).filter(|b| b.0.1.is_finite())
    {
        let stages = limits.scheme.most_stages.filter(|_| first < limit);
        let stages = stages.map_or(String::new(), |most| {
            format!(
                ", in {most} stages; {first:.4e} s in {}, which the first step goes by",
                limits.scheme.weights.len()
            )
        });
        lines.push(format!("step limit   {limit:.4e} s, {bound}{stages}"));
    }
    let later = later_step(case, &limits);
    let steps = steps(case, &limits, dt, later);
    let stages = limits.scheme.stages_for(later * limits.diffusion_rate);
    let more = if stages > limits.scheme.weights.len() {
        format!(" in {stages} stages")
    } else {
        String::new()
    };
    let pace = Pace::expected(case).filter(|_| !(0.99..1.01).contains(&(later / dt))).map(|pace| {
        let Pace { speed, words, .. } = pace;
        format!(", and {later:.1e} s{more} at {} m/s, {words}", brief(speed))
    });
    let pace = pace.unwrap_or_default();
    lines.push(format!(
        "step         {dt:.4e} s at the start, {choice}{pace}; about {} steps to t = {} s",
        whole(steps),
        number(case.time.end)
    ));
    lines.extend(long_beside_wall(case, &scene, later));
    lines.extend(contacts(case, &scene, later));
    lines.push(format!(
        "pressure     {}, until |D| < {:e} 1/s",
        scene.solver()?,
        case.pressure.divergence_limit
    ));
    lines.extend(tight_pressure(case));
    for (what, needed, why) in scene.needs() {
        lines.push(format!("{:<13}{what}: {why}", if needed { "needs" } else { "skips" }));
    }
    let (trial, mut dt) = (Instant::now(), dt);
    for k in 0..TRIAL_STEPS {
        if k > 0 {
            // As a run would.
            dt = choose_step(case, &scene.limits()?, Some(dt), case.time.end - scene.state.time).0;
        }
        scene.step(dt)?;
    }
    let step = trial.elapsed().as_secs_f64() / f64::from(TRIAL_STEPS);
    let disk = disk::expected(case, &mut scene, steps)?;
    lines.push(outputs(case, &disk));
    let disk = size(disk.all);
    let mut memory = [peak_memory()];
    session.sum(&mut memory)?;
    lines.push(format!(
        "cost         {:.2} ms a step ({:.2} us a cell; the first {TRIAL_STEPS} steps tried), \
        start-up {start_up:.2} s, \
         memory {:.0} MB; about {} for the run, more where many particles touch; {disk} of disk at \
         most",
        1e3 * step,
        1e6 * step / scene.domain.grid.total_cells() as f64,
        memory[0] / 1e6,
        minutes((steps * step).ceil())
    ));
    Ok(lines)
}

/// Inflows that take the fluid away.
fn outwards(case: &Case) -> Vec<String> {
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

/// Bodies that may touch where the case says nothing of contacts.
fn untouchable(case: &Case) -> Option<String> {
    let solid = |side: &Side| !matches!(side, Side::Periodic | Side::Outflow);
    let meets = case.particle.len() > 1 || case.boundary.iter().flatten().any(solid);
    let free = case.contact.is_none() && case.particle.iter().any(Particle::is_free);
    (free && meets).then(|| {
        "notice       the case has no [contact]: the run ends as soon as a free particle touches \
        another or a wall; an empty [contact] lets \
         them touch"
            .into()
    })
}

/// A limit on the divergence that is tighter than what the flow is resolved to, by orders. A
/// divergence below D0 in all cells changes a velocity by D0 L over the length L of the box at the
/// most, where all cells err to the same side.
fn tight_pressure(case: &Case) -> Option<String> {
    let (speed, limit) = (Pace::expected(case)?.speed, case.pressure.divergence_limit);
    let length = case.domain.size.iter().copied().fold(0.0, f64::max);
    let (part, enough) = (limit * length / speed, EXACT * speed / length);
    // A power of ten, rounded down.
    let enough = 10f64.powf(enough.log10().floor());
    (part < TIGHT * EXACT && enough > limit).then(|| {
        format!(
            "note         pressure.divergence_limit = {limit:e} 1/s is tighter than this flow \
            needs: over the whole box it changes a velocity by \
             at most {part:.0e} of {} m/s; {enough:e} keeps that below {EXACT:e}, and saves \
             iterations",
            brief(speed)
        )
    })
}

/// What a run will write: the folder, how often, how many and how much.
fn outputs(case: &Case, disk: &Disk) -> String {
    let often = |cadence: &Cadence| match cadence {
        Cadence::Steps(1) => "every step".to_owned(),
        Cadence::Steps(n) => format!("every {n} steps"),
        Cadence::Time(time) => format!("every {} s", number(*time)),
    };
    let fields =
        case.output.fields.as_ref().map_or("of the first and the last state".to_owned(), often);
    let mut words = format!(
        "output       into runs/{}, unless --out names another folder: fields {fields}, {} \
        snapshots of {}",
        case.name,
        whole(disk.snapshots),
        size(disk.snapshot)
    );
    if !case.particle.is_empty() {
        words +=
            &format!("; particles.csv {}, {}", often(&case.output.particles), size(disk.particles));
    }
    let checkpoint = match case.output.checkpoint {
        Checkpoints::Steps(n) => format!("every {n} steps"),
        Checkpoints::WallMinutes(minutes) => format!("every {} minutes", number(minutes)),
    };
    words
        + &format!(
            "; a checkpoint {checkpoint}, of which two of {} are kept",
            size(disk.checkpoint)
        )
}

/// A free body that begins beside a wall along which gravity pulls it, in steps that take more
/// stages for viscosity once the wall has slowed it to a third of the speed that it comes to
/// elsewhere: such steps are too long for the flow in the gap. A disc at a gap of 0.02 d, 8 to 16
/// cells a diameter, falls 4 to 5 % faster in four stages than in the two of rk2, which are within
/// 1 % of steps of a seventh.
fn long_beside_wall<const D: usize>(case: &Case, scene: &Scene<D>, later: f64) -> Option<String> {
    let (limits, h) = (scene.limits().ok()?, case.spacings().into_iter().fold(0.0, f64::max));
    let stages = limits.scheme.stages_for(3.0 * later * limits.diffusion_rate);
    let along = |(face, side): (usize, &Side)| {
        matches!(side, Side::Wall | Side::MovingWall(_)) && case.fluid.gravity[face / 2] == 0.0
    };
    let walls = || case.sides().map(|(_, side)| side).enumerate().filter(|wall| along(*wall));
    let distance = |body: &Body, face: usize| {
        let (x, size) = (body.centre[face / 2], case.domain.size[face / 2]);
        if face.is_multiple_of(2) { x } else { size - x }
    };
    let gap = |body: &Body| {
        walls().map(|(face, _)| distance(body, face) - body.radius()).fold(f64::INFINITY, f64::min)
    };
    let falls = case.fluid.gravity.iter().any(|g| *g != 0.0);
    let long = falls && stages > limits.scheme.weights.len();
    let free =
        |body: &&Body| body.freedom().is_some() && gap(body) < gap_reach(false, &case.numerics) * h;
    let first = scene.state.bodies.iter().find(free).filter(|_| long)?;
    Some(format!(
        "warning      {} begins {} spacings from a wall, where steps of {stages} stages are too \
         long: its speed along the wall may be off by 5 %; time.scheme = \"rk2\" is within 1 % of \
         short steps",
        case.called(first.id),
        brief(gap(first).max(0.0) / h)
    ))
}

/// Numbers of the method that are not the defaults, for which nothing was validated.
fn experiment(case: &Case) -> Option<String> {
    let changed: Vec<_> = case
        .numerics
        .changed()
        .into_iter()
        .map(|(name, value, default)| format!("numerics.{name} = {value} (default {default})"))
        .collect();
    (!changed.is_empty()).then(|| {
        format!(
            "warning      {}: results are an experiment, to which no validation of this program \
            applies",
            changed.join(", ")
        )
    })
}

/// Bodies in a fluid without viscosity, which slips along the walls of the box.
fn sticks(case: &Case) -> Option<String> {
    let sticks = case.fluid.viscosity == 0.0 && !case.particle.is_empty();
    let words = "warning      without viscosity bodies hold the fluid beside them all the same: \
        how they are set off from rest is right, \
                 drag, wakes and light bodies at walls are not";
    sticks.then(|| words.into())
}

/// Bodies that overlap at the start by so much that their springs throw them apart.
fn pressed<const D: usize>(case: &Case, scene: &Scene<D>) -> Option<String> {
    let (stored, g) =
        (scene.state.energy.springs, case.fluid.gravity.iter().map(|g| g * g).sum::<f64>().sqrt());
    let free = || scene.state.bodies.iter().filter(|body| body.freedom().is_some());
    // What they would have from a fall by a hundredth of their diameters.
    let weight = |body: &Body| (body.mass() - case.fluid.density * body.volume()).abs() * g;
    let fall = free().map(|body| 0.02 * body.radius() * weight(body)).sum::<f64>();
    let lightest = free().map(Body::mass).fold(f64::INFINITY, f64::min);
    (stored > fall && lightest.is_finite()).then(|| {
        format!(
            "warning      particles overlap at the start, and the springs of their contacts hold \
            {stored:.2e} J: they may part at up to {} m/s; \
             place them further apart",
            brief((2.0 * stored / lightest).sqrt())
        )
    })
}

/// Cells across the smallest particle; `None` without particles.
fn cells_across(case: &Case) -> Option<f64> {
    let widest = case.spacings().into_iter().fold(0.0, f64::max);
    case.particle
        .iter()
        .map(|p| p.shape.diameter())
        .min_by(f64::total_cmp)
        .map(|least| least / widest)
}

/// Particles that are too small for the grid.
fn unresolved(case: &Case) -> Option<String> {
    let smallest = cells_across(case)?;
    if smallest < RESOLVED {
        let cells = case.domain.cells.iter().map(|&n| whole((n as f64 * GOOD / smallest).ceil()));
        return Some(format!(
            "warning      a particle of {} cells is not resolved: {RESOLVED} or more are needed; \
            domain.cells = [{}] give it {GOOD}",
            if smallest < 1.0 { brief(smallest) } else { format!("{smallest:.1}") },
            cells.collect::<Vec<_>>().join(", ")
        ));
    }
    // As large as asked for, but for rounding.
    (smallest < GOOD * (1.0 - 1e-9)).then(|| {
        format!(
            "note         a particle of {smallest:.1} cells is coarse: from {GOOD} on forces \
            are right within some per cent"
        )
    })
}

/// Contacts outside the densities and sizes for which they hold.
fn out_of_range(case: &Case) -> Vec<String> {
    if case.contact.is_none() || case.particle.len() < 2 {
        return Vec::new();
    }
    let ratio = |p: &Particle| p.density / case.fluid.density;
    let outside = case.particle.iter().position(|p| p.is_free() && !IN_CONTACT.contains(&ratio(p)));
    let density = outside.map(|id| {
        format!(
            "warning      {} is {} times as dense as the fluid: contacts among particles hold from \
            {} to {}",
            case.called(id),
            brief(ratio(&case.particle[id])),
            IN_CONTACT.start(),
            IN_CONTACT.end()
        )
    });
    let diameters = case.particle.iter().map(|p| p.shape.diameter());
    let [least, most] =
        [diameters.clone().fold(f64::INFINITY, f64::min), diameters.fold(0.0, f64::max)];
    let sizes = (most > MOST_SIZE_RATIO * least * (1.0 + 1e-9)).then(|| {
        format!(
            "warning      particles of {} and {} m: contacts hold for diameters up to \
            {MOST_SIZE_RATIO} times each other",
            brief(least),
            brief(most)
        )
    });
    density.into_iter().chain(sizes).collect()
}

/// Bodies of the file beside those that another run brings along.
fn doubled(case: &Case) -> Option<String> {
    let (inherited, own) = (case.initial.inherited, case.particle.len() - case.initial.inherited);
    (inherited > 0 && own > 0).then(|| {
        format!(
            "note         this file adds {own} to the {inherited} that come from that run: if they \
            are the same, remove its [[particle]] and \
             [[swarm]]"
        )
    })
}

/// Impacts by the paper's method, which loses energy in them.
fn mixed_impacts(case: &Case) -> Option<String> {
    let mixes = case.coupling.wall == WallRule::Mixing && case.contact.is_some();
    let free = case.particle.iter().any(Particle::is_free);
    (mixes && free).then(|| {
        "warning      coupling.wall = \"mixing\" takes energy from impacts: speeds after them are \
        up to a quarter less than the \
         restitution leaves; \"sharp\" keeps them"
            .into()
    })
}

/// Free particles of a density that may be in another unit than the fluid's.
fn unusual(case: &Case) -> Option<String> {
    let ratio = |p: &Particle| p.density / case.fluid.density;
    let id = case.particle.iter().position(|p| p.is_free() && !USUAL.contains(&ratio(p)))?;
    let s = ratio(&case.particle[id]);
    Some(format!(
        "note         {} is {s:.3e} times as dense as the fluid: if that is not meant, look at \
        both densities",
        case.called(id)
    ))
}

/// The boundary layer that the grid has to resolve: that of a body, or else that of the walls of
/// the box.
fn layer(case: &Case) -> Vec<String> {
    let Some(layer) = Layer::thinnest(case) else { return wall_layer(case) };
    let Layer { particle, falls, speed, reynolds, thickness, .. } = layer;
    let h = case.spacings().into_iter().fold(0.0, f64::max);
    let meets = if falls { "comes to" } else { "meets a flow of" };
    let by = if falls { ", by its drag," } else { "," };
    let mut line = format!(
        "layer        {} {meets} {} m/s{by} Re = {}",
        case.called(particle),
        brief(speed),
        number_of_flow(reynolds)
    );
    if thickness.is_infinite() {
        return vec![line + ": no boundary layer"];
    }
    line += &format!(": a boundary layer of {thickness:.3e} m, {:.2} h", thickness / h);
    let warning = thin_layer(case).map(|thin| format!("warning      {thin}{}", doubt(reynolds)));
    [Some(line), warning].into_iter().flatten().collect()
}

/// That of the walls of the box, where the flow along them is fast enough for one.
fn wall_layer(case: &Case) -> Vec<String> {
    let Some(Walls { axis, speed, reynolds, thickness }) = Walls::thinnest(case) else {
        return Vec::new();
    };
    let (x, h) = (["x", "y", "z"][axis], case.spacings()[axis]);
    let line = format!(
        "layer        along the walls across {x}, at {} m/s, Re = {}: a boundary layer of \
        {thickness:.3e} m, {:.2} h",
        brief(speed),
        number_of_flow(reynolds),
        thickness / h
    );
    let warning = thin_layer(case).map(|thin| format!("warning      {thin}{}", doubt(reynolds)));
    [Some(line), warning].into_iter().flatten().collect()
}

/// The body that is held in the fastest stream for its size, its Reynolds number, diameter (m)
/// and speed (m/s).
pub(crate) fn wake(case: &Case) -> Option<(String, f64, f64, f64)> {
    let layer = Layer::thinnest(case).filter(|layer| !layer.falls)?;
    Some((case.called(layer.particle), layer.reynolds, layer.diameter, layer.speed))
}

/// The boundary layer, where the grid does not resolve it, and how many cells would.
pub(crate) fn thin_layer(case: &Case) -> Option<String> {
    let (whose, needed, there, thickness, h) = match (Layer::thinnest(case), Walls::thinnest(case))
    {
        (Some(layer), _) => {
            let h = case.spacings().into_iter().fold(0.0, f64::max);
            let needed = format!("{} cells a diameter", whole(layer.cells_needed()));
            (
                case.called(layer.particle),
                needed,
                format!("{:.1}", layer.diameter / h),
                layer.thickness,
                h,
            )
        }
        (None, Some(Walls { axis, thickness, .. })) => {
            let x = ["x", "y", "z"][axis];
            let needed =
                format!("{} cells along {x}", whole((case.domain.size[axis] / thickness).ceil()));
            (
                format!("the walls across {x}"),
                needed,
                case.domain.cells[axis].to_string(),
                thickness,
                case.spacings()[axis],
            )
        }
        (None, None) => return None,
    };
    (thickness < h).then(|| {
        format!(
            "the boundary layer of {whose} is thinner than a spacing: {needed} would put one \
            into it, and there are {there}"
        )
    })
}

/// A Reynolds number, with what a creeping flow has of it.
fn number_of_flow(reynolds: f64) -> String {
    if reynolds < 10.0 { brief(reynolds) } else { whole(reynolds) }
}

/// What a Reynolds number often comes of that is far too large.
fn doubt(reynolds: f64) -> &'static str {
    let units = "; so large a Reynolds number often comes of a viscosity in other units: \
        fluid.viscosity is dynamic, in Pa s, that of \
                 water 1e-3";
    if reynolds > DOUBTFUL { units } else { "" }
}
