//! `mics check`: the scene in one screen, without running it: sizes, numbers, limits, what is
//! needed and what is not.

mod blocked;
mod channel;
mod disk;
mod flow;
mod layer;
mod memory;
mod particles;
mod path;
mod steps;
mod stiffness;
mod touching;

use crate::clock::Stage;
use crate::config::{Case, Loaded};
use crate::launch::{self, RunSize};
use crate::petsc::Session;
use crate::scene::{Scene, read_case};
use crate::step_size::{check_step, choose_step};
use crate::system::peak_memory;
use crate::words::{minutes, size};
use crate::{Error, Result};
use blocked::{refuse_shut, shut};
pub(crate) use layer::thin_layer;
pub use memory::check_memory;
use mics_run::print;
use path::{locked_into, run_into};
use std::path::Path;
use std::time::Instant;
use steps::{later_step, step_among_bodies};
use stiffness::{contacts, refuse_too_stiff, shortest};
use touching::Touching;

/// Fewest steps that are tried (and thrown away) to tell the cost of one.
const FEWEST_TRIED: u32 = 3;
/// Most steps that are tried: a run has as many at least.
const MOST_TRIED: u32 = 10;
/// Time (s) after which no more steps are tried than the fewest.
const LONGEST_TRIAL: f64 = 0.3;

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
    let ranks = match session.size() {
        1 => launch::usual(&loaded.case, !petsc.is_empty()),
        given => given,
    };
    let lines = match loaded.case.dimension() {
        2 => describe::<2>(&session, &loaded, ranks),
        _ => describe::<3>(&session, &loaded, ranks),
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
    particles::refuse_below_a_cell(loaded)?;
    refuse_too_stiff(loaded, scene)
}

/// Warnings of a run before it begins. Collective.
pub(crate) fn warnings<const D: usize>(case: &Case, scene: &Scene<D>) -> Result<Vec<String>> {
    let later = later_step(case, &scene.limits()?);
    let all = flow::outwards(case)
        .into_iter()
        .chain(particles::sticks(case))
        .chain(particles::unresolved(case))
        .chain(layer::describe(case))
        .chain(shut(case, scene))
        .chain(channel::narrow(case, scene))
        .chain(particles::flat_films(case))
        .chain(run_into(case, scene))
        .chain(locked_into(case, scene))
        .chain(contacts(case, scene, later));
    Ok(all.filter(|line| line.starts_with("warning")).collect())
}

fn describe<const D: usize>(
    session: &Session,
    loaded: &Loaded,
    ranks: usize,
) -> Result<Vec<String>> {
    let case = &loaded.case;
    let started = Instant::now();
    let mut scene = Scene::<D>::new(session, case)?;
    let start_up = started.elapsed().as_secs_f64();
    refuse(loaded, &scene)?;
    let limits = scene.limits()?;
    let mut lines = flow::describe_box(case);
    lines.extend(particles::describe(case));
    lines.extend(flow::reynolds(case));
    lines.extend(layer::describe(case));
    lines.extend(shut(case, &scene));
    lines.extend(channel::narrow(case, &scene));
    lines.extend(run_into(case, &scene));
    lines.extend(locked_into(case, &scene));
    lines.extend(particles::pressed(case, &scene));
    let (step_lines, steps) = steps::describe(case, &scene, &limits);
    lines.extend(step_lines);
    lines.extend(contacts(case, &scene, later_step(case, &limits)));
    lines.extend(flow::describe_pressure(case, &scene)?);
    let advice = RunSize::of(case).advice(ranks);
    let taken = (ranks > session.size()).then(|| format!("{ranks}, which a run starts by itself"));
    lines.extend(advice.or(taken).map(|line| format!("ranks        {line}")));
    let touching = Touching::measured(case, &scene, step_among_bodies(case, &limits));
    let Trial { steps: tried, step, without, solve_rows } = try_steps(case, &mut scene)?;
    lines.extend(touching.as_ref().map(Touching::describe));
    let (seconds, with) = match &touching {
        Some(touching) => (without + touching.seconds, " with contacts"),
        None => (step, uncounted(case, &scene)),
    };
    let disk = disk::expected(case, &mut scene, steps, solve_rows)?;
    lines.push(disk::describe(case, &disk));
    let mut memory = [peak_memory()];
    session.sum(&mut memory)?;
    lines.push(format!(
        "cost         {:.2} ms a step{with} ({:.2} us a cell; the first {tried} steps \
        tried{}), start-up {start_up:.2} s, memory {:.0} MB; about {} for so many steps; {} of \
        disk at most",
        1e3 * seconds,
        1e6 * seconds / scene.domain.grid.total_cells() as f64,
        if session.size() == 1 && ranks > 1 { " on one rank" } else { "" },
        memory[0] / 1e6,
        minutes((steps * seconds).ceil()),
        size(disk.all)
    ));
    Ok(lines)
}

/// Words for a cost without the contacts that may come and could not be measured.
fn uncounted<const D: usize>(case: &Case, scene: &Scene<D>) -> &'static str {
    let coming = case.particle.iter().any(|p| p.enter.is_some());
    if case.contact.is_some() && (coming || shortest(scene).is_some()) {
        " without contacts"
    } else {
        ""
    }
}

/// The cost of the first steps.
struct Trial {
    /// Number of steps that were tried.
    steps: u32,
    /// Time of a step (s).
    step: f64,
    /// Time of a step without its contacts (s).
    without: f64,
    /// Rows of the solves of a step.
    solve_rows: f64,
}

/// Tries the first steps as a run would take them; one that fails after the fewest is left to the
/// run. Collective.
fn try_steps<const D: usize>(case: &Case, scene: &mut Scene<D>) -> Result<Trial> {
    scene.domain.clock.lap(Stage::Logs);
    let in_contacts = |scene: &Scene<D>| scene.domain.clock.spent(Stage::Contacts);
    let trial = Instant::now();
    let begun = in_contacts(scene);
    let mut before = None;
    let mut rows = 0;
    let mut steps = 0;
    let mut spent = [0.0];
    while steps < FEWEST_TRIED || (steps < MOST_TRIED && spent[0] < LONGEST_TRIAL) {
        let left = case.time.end - scene.state.time;
        let (dt, _) = choose_step(case, &scene.limits()?, before, left);
        let report = match scene.step(dt) {
            Err(_) if steps >= FEWEST_TRIED => break,
            report => report?,
        };
        // A run computes it for its rows.
        scene.energy_and_speed()?;
        // Each solve has its first residual as well.
        rows += report.outer + report.krylov;
        steps += 1;
        before = Some(dt);
        spent = [trial.elapsed().as_secs_f64()];
        scene.domain.session.max(&mut spent)?;
    }
    let tried = f64::from(steps);
    let without = (spent[0] - (in_contacts(scene) - begun)) / tried;
    Ok(Trial { steps, step: spent[0] / tried, without, solve_rows: f64::from(rows) / tried })
}
