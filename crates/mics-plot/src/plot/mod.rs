//! `mics plot`: the figures of run folders, from what the folders hold.
//!
//! `table` reads the tables (CSV files) of a run, `series` draws groups of their rows as lines over
//! axes. What they draw: `forces` (forces, torques and speeds of `bodies`, of many by their
//! `kinds`), `columns` (any by name), `records` (probes and profiles), `steps` and `solves` (the
//! pressure). Figures of other sorts: `fields` (the flow in planes, Figs. 6, 7, 11, 14), `solids`
//! (surfaces in 3D), `paths` (Fig. 9), `reynolds` (Cd and St over Re, Figs. 4, 5).

mod bodies;
mod columns;
mod discs;
mod fields;
mod forces;
mod kinds;
mod paths;
mod records;
mod reel;
mod request;
mod reynolds;
mod section;
mod series;
mod slice;
mod solids;
mod solves;
mod steps;
mod table;
mod view;

use crate::figure::{self, Chart};
use mics_run::config::{Case, Section, load};
use mics_run::progress::Record;
use mics_run::snapshot::Snapshot;
use mics_run::words::rounded;
use mics_run::{Error, Result};
use mics_run::{bodies as surfaces, not_a_run};
use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

pub(super) use bodies::PARTICLES;
pub use discs::Bodies;
use discs::Colours;
pub(super) use fields::{Look, dated, evenly, nearest, newest_snapshot, plane, sections};
use records::Probes;
pub(super) use reel::Reel;
pub use request::{Figure, Request};
use series::{Group, joined};
pub(super) use solves::{Solve, StepSolves};
pub(super) use steps::{energy, lengths};
pub(super) use table::{Rows, Table};
pub use view::View;

/// The file that the folder of a study has.
const STUDY: &str = "study.csv";

/// A run's folder and its case.
pub(super) struct Run {
    pub folder: PathBuf,
    pub case: Case,
    /// The particles that are asked for; empty: all.
    asked: Vec<usize>,
    /// Its name beside other runs; empty where it is alone.
    label: String,
}

impl Run {
    /// Reads a run of which these `particles` are asked for, by number or name.
    pub fn read(folder: &Path, particles: &[String]) -> Result<Run> {
        if folder.join(STUDY).is_file() && !folder.join("case.toml").exists() {
            return Err(Error::Usage(format!(
                "{}: a study's folder; `mics study` draws its figures into it, and its runs under \
                runs/ can be plotted",
                folder.display()
            )));
        }
        let case = read_case(folder)?;
        let ids = particles.iter().map(|wanted| {
            case.find(wanted).map_err(|why| {
                Error::Usage(format!("--particle {wanted}: {}: {why}", folder.display()))
            })
        });
        let asked = ids.collect::<Result<Vec<_>>>()?.concat();
        Ok(Run { folder: folder.to_owned(), case, asked, label: String::new() })
    }

    /// A run in a folder with a case of its own.
    #[cfg(test)]
    pub fn of_text(folder: &Path, case: &str) -> Run {
        let case = mics_run::config::written(case).unwrap();
        Run { folder: folder.to_owned(), case, asked: Vec::new(), label: String::new() }
    }

    /// Groups of its rows under its name, but where runs are averaged.
    fn name(&self, mut groups: Vec<Group>, averaged: bool) -> Vec<Group> {
        for group in groups.iter_mut().filter(|_| !averaged) {
            group.label = joined(&[&self.label, &group.label]);
        }
        groups
    }

    /// A note on the figures of a run that goes on or was killed; none where it has ended.
    fn unfinished(&self) -> Option<String> {
        let newest = Record::newest(&self.folder)?;
        let goes_on = newest.status == "running";
        goes_on.then(|| {
            format!(
                "note: {} has not ended: figures show it to t = {} of {} s",
                self.folder.display(),
                rounded(newest.time),
                rounded(newest.end)
            )
        })
    }
}

/// The figures that were drawn.
#[derive(Debug, Default)]
pub struct Drawn {
    /// The files.
    pub files: Vec<PathBuf>,
    /// Notes on them, a line each.
    pub notes: Vec<String>,
}

/// Draws what is asked for. A run that has not ended is drawn as far as it is, with a note.
///
/// # Errors
/// When the request contradicts itself, a folder does not hold a run or not what a figure needs, or
/// a file cannot be written.
pub fn draw(request: &Request) -> Result<Drawn> {
    request.check()?;
    let mut runs = request
        .runs
        .iter()
        .map(|folder| Run::read(folder, &request.particles))
        .collect::<Result<Vec<_>>>()?;
    name_runs(&mut runs);
    let mut written = Vec::new();
    let notes = runs.iter().filter_map(Run::unfinished).collect();
    if request.figures().is_empty() {
        for run in &runs {
            written.extend(draw_run(&run.folder)?);
        }
        let folder = folder_of(request, &runs)?;
        for figure in [Figure::Drag, Figure::Strouhal] {
            if let Some(chart) = curves(figure, &runs, request)? {
                written.extend(figure::chart(&chart, &folder.join(figure.file()))?);
            }
        }
    }
    for figure in &request.figures() {
        for runs in runs.chunks(if figure.joins_runs() { runs.len() } else { 1 }) {
            let Some(files) = draw_figure(request, *figure, runs)? else {
                let names = runs
                    .iter()
                    .map(|run| run.folder.display().to_string())
                    .collect::<Vec<_>>()
                    .join(", ");
                return Err(Error::Usage(format!(
                    "{names}: {} needs {}",
                    figure.name(),
                    figure.needs()
                )));
            };
            written.extend(files);
        }
    }
    Ok(Drawn { files: written, notes })
}

/// Where a figure of some runs goes, made if it is not there.
fn folder_of(request: &Request, runs: &[Run]) -> Result<PathBuf> {
    let folder = request
        .out
        .clone()
        .or_else(|| Some(runs.first()?.folder.join("figures")))
        .unwrap_or_default();
    fs::create_dir_all(&folder).map_err(Error::io(&folder))?;
    Ok(folder)
}

/// Draws a figure of some runs, of the first one where it is of one; none where there is
/// nothing to draw.
fn draw_figure(request: &Request, figure: Figure, runs: &[Run]) -> Result<Option<Vec<PathBuf>>> {
    let Some(run) = runs.first() else { return Ok(None) };
    let stem = |name: &str| Ok::<_, Error>(folder_of(request, runs)?.join(name));
    let strip_title = |planes: &[figure::Plane]| {
        let place = planes.first().map_or("", |plane| &plane.place);
        format!("{}{place}", run.case.name)
    };
    let seen = |plane| request.view.part(figure::Plane { style: request.view.style(), ..plane });
    request.view.fits(run)?;
    let last = |run: &Run| {
        let path = snapshot_at(run, request.times.last().copied())?;
        let plane = last_planes(&run.folder, &run.case, request.view.plane, &path)?.swap_remove(0);
        seen(titled(&run.case, plane))
    };
    let planes = |run: &Run| -> Result<Vec<_>> {
        fields::planes(&run.folder, &run.case, request.view.plane, &request.times)?
            .into_iter()
            .map(seen)
            .collect()
    };
    if figure == Figure::Field {
        return draw_field(request, runs, run).map(Some);
    }
    let drawn = match figure {
        Figure::Vorticity => figure::vorticity(&last(run)?, &stem("vorticity")?)?,
        Figure::Streamlines => figure::streamlines(&last(run)?, &stem("streamlines")?)?,
        Figure::VorticityStrip => {
            let planes = planes(run)?;
            figure::vorticity_strip(
                &planes,
                &strip_title(&planes),
                request.interval,
                &stem("vorticity_strip")?,
            )?
        }
        Figure::StreamlinesStrip => {
            let planes = planes(run)?;
            figure::streamlines_strip(&planes, &strip_title(&planes), &stem("streamlines_strip")?)?
        }
        Figure::Solids => {
            let Some(scene) = solid_scene(run, request)? else { return Ok(None) };
            figure::shaded(&scene, &stem("solids")?)?
        }
        _ => {
            let Some(chart) = curves(figure, runs, request)? else { return Ok(None) };
            figure::chart(&chart, &stem(figure.file())?)?
        }
    };
    Ok(Some(drawn.into()))
}

/// The scene of the bodies and obstacles of a 3D run in its last snapshot, or the one next to a
/// time that is asked for; none where there is nothing to show.
fn solid_scene(run: &Run, request: &Request) -> Result<Option<figure::Scene>> {
    let case = &run.case;
    if case.dimension() != 3 || !case.has_bodies() {
        return Ok(None);
    }
    let path = snapshot_at(run, request.times.last().copied())?;
    let time = Snapshot::time_of(&path)?;
    let poses = surfaces::of(&path, case.particle.len())?;
    let fastest = poses.values().map(|pose| pose.speed).fold(0.0, f64::max);
    let colours = Colours::of(request.view.bodies.unwrap_or_default(), case, fastest);
    let eye = if let [x, y, z] = request.eye[..] { Some([x, y, z]) } else { None };
    let title = format!("{}, t = {} s", case.name, rounded(time));
    let place = |id: usize| poses.get(&id).copied();
    Ok(Some(solids::scene(case, &place, &colours, eye, title)))
}

/// Draws the colours of a field of a run alone.
fn draw_field(request: &Request, runs: &[Run], run: &Run) -> Result<Vec<PathBuf>> {
    let frames = match (&request.times[..], newest_snapshot(&run.folder)?) {
        ([], last) => vec![(Snapshot::time_of(&last)?, last)],
        (times, _) => fields::choose(&run.folder, times)?,
    };
    let folder = folder_of(request, runs)?;
    reel::pictures(&Reel::of(run, &request.view, &frames)?, &folder)
}

/// The last snapshot of a run, or the one next to a time (s).
fn snapshot_at(run: &Run, time: Option<f64>) -> Result<PathBuf> {
    let Some(time) = time else { return newest_snapshot(&run.folder) };
    let mut all = dated(&run.folder)?;
    fields::check_time(&run.folder, &all, time)?;
    Ok(all.swap_remove(fields::nearest(&all, time)).1)
}

/// The last state of a run, or the one next to a time (s), in a plane or in those that its figures
/// show: titled by its time and place alone.
pub(super) fn last_planes(
    folder: &Path,
    case: &Case,
    section: Option<Section>,
    path: &Path,
) -> Result<Vec<figure::Plane>> {
    let snapshot = Snapshot::read(path)?;
    let poses = surfaces::of(path, case.particle.len())?;
    let place = |id: usize| poses.get(&id).copied();
    let sections = section.map_or_else(|| sections(case, place), |section| vec![section]);
    let look = Look::at(snapshot.time);
    let plane = |section| plane(case, &snapshot, folder, section, &place, &look);
    sections.into_iter().map(plane).collect()
}

/// A plane with the name of its case, its time and its place as its title.
fn titled(case: &Case, plane: figure::Plane) -> figure::Plane {
    let title = format!("{}, {}{}", case.name, plane.title, plane.place);
    figure::Plane { title, ..plane }
}

/// Draws one run's usual figures into its `figures/`; returns the PNGs and SVGs, the vorticity's
/// last.
///
/// # Errors
/// When the folder does not hold a run, or a file cannot be written.
pub fn draw_run(folder: &Path) -> Result<Vec<PathBuf>> {
    let run = Run::read(folder, &[])?;
    // All is read before anything is written.
    let planes = match snapshot_at(&run, None) {
        // One that has just begun has its rows.
        Err(_) if run.unfinished().is_some() => Vec::new(),
        path => last_planes(folder, &run.case, None, &path?)?,
    };
    let runs = std::slice::from_ref(&run);
    let charts = charts(&run)?;
    let folder = folder_of(&Request::default(), runs)?;
    let mut written = Vec::new();
    if !planes.is_empty()
        && let Some(scene) = solid_scene(&run, &Request::default())?
    {
        written.extend(figure::shaded(&scene, &folder.join("solids"))?);
    }
    for (figure, chart) in charts {
        written.extend(figure::chart(&chart, &folder.join(figure.file()))?);
    }
    for (number, plane) in planes.into_iter().enumerate().rev() {
        let plane = titled(&run.case, plane);
        // The first has the plain names, and comes last.
        let stem = |name: &str| numbered(&folder.join(name), number);
        written.extend(figure::streamlines(&plane, &stem("streamlines"))?);
        written.extend(figure::vorticity(&plane, &stem("vorticity"))?);
    }
    Ok(written)
}

/// The stem of a file of one of several planes, which are counted from 0: the first has the plain
/// name.
pub(super) fn numbered(stem: &Path, plane: usize) -> PathBuf {
    let name = stem.file_name().unwrap_or_default().to_string_lossy();
    if plane == 0 { stem.to_owned() } else { stem.with_file_name(format!("{name}_{}", plane + 1)) }
}

/// The usual figures of curves of a run that it has something for.
///
/// # Errors
/// When a table is not one of a run.
pub(super) fn charts(run: &Run) -> Result<Vec<(Figure, Chart)>> {
    let usual = [
        Figure::Forces,
        Figure::Speeds,
        Figure::Paths,
        Figure::Profile,
        Figure::Probes,
        Figure::ProbeLines,
        Figure::ConvergenceSteps,
        Figure::Convergence,
    ];
    let mut all = Vec::new();
    for figure in usual {
        let chart = curves(figure, std::slice::from_ref(run), &Request::default())?;
        all.extend(chart.map(|chart| (figure, chart)));
    }
    Ok(all)
}

/// A figure of curves of runs; none where there is nothing to draw.
fn curves(figure: Figure, runs: &[Run], request: &Request) -> Result<Option<Chart>> {
    let Some(run) = runs.first() else { return Ok(None) };
    let mean = request.mean;
    let drawn = match figure {
        Figure::Forces => forces::forces(runs, mean)?,
        Figure::Torques => forces::torques(runs, mean)?,
        Figure::Speeds => forces::speeds(runs, mean)?,
        Figure::Columns => columns::columns(runs, &request.columns, request.over.as_deref(), mean)?,
        Figure::Profile => records::profile(runs)?,
        Figure::Probes => records::probes(runs, Probes::OverTime)?,
        Figure::ProbeLines => records::probes(runs, Probes::AlongLines)?,
        Figure::Paths => paths::paths(runs)?,
        Figure::Convergence => solves::convergence(runs, request.times.last().copied())?,
        Figure::ConvergenceSteps => steps::over_steps(runs)?,
        Figure::Drag => reynolds::drag(runs)?,
        Figure::Strouhal => reynolds::strouhal(runs)?,
        _ => None,
    };
    Ok(drawn.map(|chart| named(chart, &run.case)))
}

/// A figure with the name of its case before its title.
fn named(mut chart: Chart, case: &Case) -> Chart {
    if let Some((axes, _)) = chart.panels.first_mut() {
        let rest = if axes.title.is_empty() { String::new() } else { format!(": {}", axes.title) };
        axes.title = case.name.clone() + &rest;
    }
    chart
}

/// Names several runs by their folders, with what is before these where two are alike.
fn name_runs(runs: &mut [Run]) {
    if let [_] = runs {
        return;
    }
    let last = |run: &Run| {
        run.folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    };
    let short: HashSet<String> = runs.iter().map(last).collect();
    let unlike = short.len() == runs.len();
    for run in runs {
        run.label = if unlike { last(run) } else { run.folder.display().to_string() };
    }
}

pub(super) fn read_case(run: &Path) -> Result<Case> {
    let loaded = load(&run.join("case.toml"), &[]).map_err(|e| not_a_run(run, &e.to_string()))?;
    Ok(loaded.case)
}
