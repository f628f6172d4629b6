//! `mics plot`: the figures of run folders, from what the folders hold.
//!
//! One run: the last state's vorticity with streamlines and its streamlines (`fields`), both over
//! time as strips (Figs. 6, 7, 11, 14), forces over time and over the height of a fall (`forces`,
//! Fig. 10), speeds, means over layers (`profile`), what probes recorded (`probes`) and how the
//! pressure solves converged (`convergence`). One or
//! several: paths (`paths`, Fig. 9), Cd(Re) and St(Re) (`reynolds`, Figs. 4, 5). `rows` reads
//! `particles.csv`, `kinds` chooses the bodies that stand for many.

mod components;
mod convergence;
mod discs;
mod fields;
mod forces;
mod kinds;
mod paths;
mod probes;
mod profile;
mod reel;
mod request;
mod reynolds;
mod rows;
mod section;
mod slice;
mod solids;
mod view;

use crate::figure::{self, Chart};
use mics_run::config::{Case, Section, load};
use mics_run::folder::SOLVES;
use mics_run::progress::Record;
use mics_run::snapshot::Snapshot;
use mics_run::words::rounded;
use mics_run::{Error, Result};
use mics_run::{bodies, not_a_run};
use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

pub(super) use convergence::{Solve, StepSolves, convergence, over_steps};
pub use discs::Bodies;
use discs::Colours;
pub(super) use fields::{Look, dated, evenly, nearest, newest_snapshot, plane, sections};
pub(super) use forces::{forces, speeds};
pub(super) use paths::{Track, paths};
pub(super) use probes::probes;
pub(super) use profile::profile;
pub(super) use reel::Reel;
pub use request::{Figure, Request};
pub(super) use rows::{Rows, moving, table};
pub use view::View;

/// The file that the folder of a study has.
const STUDY: &str = "study.csv";

/// A run's folder and its case.
pub(super) struct Run {
    pub folder: PathBuf,
    pub case: Case,
    /// The particles that are asked for; empty: all.
    asked: Vec<usize>,
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
        Ok(Run { folder: folder.to_owned(), case, asked })
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

    fn rows(&self) -> Rows {
        Rows::read(&self.folder, &self.case, &self.asked)
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
    let runs = request
        .runs
        .iter()
        .map(|folder| Run::read(folder, &request.particles))
        .collect::<Result<Vec<_>>>()?;
    let mut written = Vec::new();
    let notes = runs.iter().filter_map(Run::unfinished).collect();
    if request.figures().is_empty() {
        for run in &runs {
            written.extend(draw_run(&run.folder)?);
        }
        let folder = folder_of(request, &runs)?;
        let flat = runs.iter().filter(|run| run.case.dimension() == 2).count();
        // Cylinders and spheres have curves of their own.
        if flat == 0 || flat == runs.len() {
            for draw in [reynolds::drag, reynolds::strouhal] {
                written.extend(draw(&runs, &folder)?.into_iter().flatten());
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
        Figure::Drag => return Ok(reynolds::drag(runs, &folder_of(request, runs)?)?.map(Vec::from)),
        Figure::Strouhal => {
            return Ok(reynolds::strouhal(runs, &folder_of(request, runs)?)?.map(Vec::from));
        }
        Figure::Convergence | Figure::ConvergenceSteps => {
            let Some(chart) = solves(figure, runs, request.times.last().copied())? else {
                return Ok(None);
            };
            figure::chart(&chart, &stem(&figure.file())?)?
        }
        _ => {
            let rows: Vec<Rows> = runs.iter().map(Run::rows).collect();
            let Some(chart) = curves(figure, runs, &rows, request.mean)? else { return Ok(None) };
            figure::chart(&chart, &stem(&figure.file())?)?
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
    let poses = bodies::of(&path, case.particle.len())?;
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
    let poses = bodies::of(path, case.particle.len())?;
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
    let rows = run.rows();
    let runs = std::slice::from_ref(&run);
    let rows = std::slice::from_ref(&rows);
    let figures = [
        Figure::Forces,
        Figure::Speeds,
        Figure::Paths,
        Figure::Profile,
        Figure::Probes,
        Figure::ProbeLines,
    ]
    .map(|figure| Ok((figure, curves(figure, runs, rows, false)?)));
    let mut figures = figures.into_iter().collect::<Result<Vec<_>>>()?;
    if folder.join(SOLVES).is_file() {
        for figure in [Figure::Convergence, Figure::ConvergenceSteps] {
            figures.push((figure, solves(figure, runs, None)?));
        }
    }
    let folder = folder_of(&Request::default(), runs)?;
    let mut written = Vec::new();
    if !planes.is_empty()
        && let Some(scene) = solid_scene(&run, &Request::default())?
    {
        written.extend(figure::shaded(&scene, &folder.join("solids"))?);
    }
    for (figure, drawn) in figures {
        if let Some(chart) = drawn {
            written.extend(figure::chart(&chart, &folder.join(figure.file()))?);
        }
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

/// A figure of curves, of the first run where it is of one; none where there is nothing to draw.
fn curves(figure: Figure, runs: &[Run], rows: &[Rows], averaged: bool) -> Result<Option<Chart>> {
    let Some((Run { case, folder, asked }, of_one)) = runs.first().zip(rows.first()) else {
        return Ok(None);
    };
    let labels = labels(runs);
    let track = |((run, rows), label)| {
        let Run { case, asked, .. }: &Run = run;
        Track { label, case, rows, asked, averaged }
    };
    let tracks = runs.iter().zip(rows).zip(labels.iter().map(String::as_str)).map(track);
    let tracks: Vec<_> = tracks.collect();
    let drawn = match figure {
        Figure::Forces => forces::forces(&tracks)?,
        Figure::Speeds => speeds(&tracks)?,
        Figure::ForceParts => forces::parts(case, of_one, asked)?.map(Chart::from),
        Figure::Profile => profile::profile(folder, case)?,
        Figure::Probes | Figure::ProbeLines => {
            let [points, lines] = probes::probes(folder)?;
            if figure == Figure::Probes { points } else { lines }
        }
        Figure::Paths => paths(&tracks)?.map(Chart::from),
        _ => None,
    };
    Ok(drawn.map(|chart| named(chart, case)))
}

/// A figure of the pressure solves of runs, of the step next to a time (s) where it is of one.
fn solves(figure: Figure, runs: &[Run], time: Option<f64>) -> Result<Option<Chart>> {
    let labels = labels(runs);
    let named_runs = labels.iter().map(String::as_str).zip(runs);
    let all: Vec<_> = named_runs
        .map(|(label, run)| (label, &*run.folder, run.case.pressure.divergence_limit))
        .collect();
    let drawn = match (figure, &all[..]) {
        (Figure::Convergence, [(_, folder, limit)]) => {
            convergence::convergence(folder, *limit, time)?
        }
        (Figure::Convergence, _) => convergence::of_runs(&all, time)?,
        _ => convergence::over_steps(&all)?,
    };
    Ok(drawn.zip(runs.first()).map(|(chart, run)| named(chart, &run.case)))
}

/// A figure with the name of its case before its title.
fn named(mut chart: Chart, case: &Case) -> Chart {
    if let Some((axes, _)) = chart.panels.first_mut() {
        let rest = if axes.title.is_empty() { String::new() } else { format!(": {}", axes.title) };
        axes.title = case.name.clone() + &rest;
    }
    chart
}

/// The names of the runs' folders, with what is before them where two have the same; of one run
/// alone none.
fn labels(runs: &[Run]) -> Vec<String> {
    if let [_] = runs {
        return vec![String::new()];
    }
    let last = |run: &Run| {
        run.folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    };
    let short: HashSet<String> = runs.iter().map(last).collect();
    let full = |run: &Run| run.folder.display().to_string();
    runs.iter().map(|run| if short.len() == runs.len() { last(run) } else { full(run) }).collect()
}

pub(super) fn read_case(run: &Path) -> Result<Case> {
    let loaded = load(&run.join("case.toml"), &[]).map_err(|e| not_a_run(run, &e.to_string()))?;
    Ok(loaded.case)
}
