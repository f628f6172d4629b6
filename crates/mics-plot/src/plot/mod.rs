//! `mics plot`: the figures of run folders, from what the folders hold.
//!
//! One run: the last state's vorticity with streamlines and its streamlines (`fields`), both over
//! time as strips (Figs. 6, 7, 11, 14), forces over time and over the height of a fall (`forces`,
//! Fig. 10), speeds, means over layers (`profile`) and what probes recorded (`probes`). One or
//! several: paths (`paths`, Fig. 9), Cd(Re) and St(Re) (`reynolds`, Figs. 4, 5). `rows` reads
//! `particles.csv`, `kinds` chooses the bodies that stand for many.

mod discs;
mod fields;
mod forces;
mod kinds;
mod paths;
mod probes;
mod profile;
mod reel;
mod reynolds;
mod rows;
mod section;
mod view;

use crate::figure::{self, Chart};
use mics_run::bodies::Pose;
use mics_run::config::{Case, Section, load};
use mics_run::progress::Record;
use mics_run::snapshot::Snapshot;
use mics_run::words::rounded;
use mics_run::{Error, Result};
use mics_run::{bodies, not_a_run};
use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

pub use discs::Bodies;
pub(super) use fields::{
    Look, dated, evenly, nearest, newest_snapshot, plane, sections, snapshots,
};
pub(super) use forces::{forces, speeds};
pub(super) use paths::{Track, paths};
pub(super) use probes::probes;
pub(super) use profile::profile;
pub(super) use reel::Reel;
pub(super) use rows::{Rows, moving, table};
pub use view::View;

/// The file that the folder of a study has.
const STUDY: &str = "study.csv";

/// What `mics plot` is asked for. Without figures: the last state, forces, speeds and paths of each
/// run, Cd(Re) and St(Re) of all; or vorticity and streamlines alone, where times or a plane, a
/// window or a size say something of the flow.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Request {
    /// Run folders.
    #[arg(required = true)]
    pub runs: Vec<PathBuf>,
    /// Draw this figure only; several with commas.
    #[arg(long = "figure", value_name = "FIGURE", value_delimiter = ',')]
    pub figures: Vec<Figure>,
    /// Times (s) of a strip's panels, or the one of a picture of the flow, e.g. 0.1,0.2,0.3:
    /// the nearest snapshots; without --figure and --field of vorticity and streamlines
    /// [default: of a strip six from start to end, else the last].
    #[arg(long, value_name = "TIMES", value_delimiter = ',', allow_negative_numbers = true)]
    pub times: Vec<f64>,
    /// Vorticity (1/s) from one contour line of vorticity-strip to the next [default: a round
    /// one].
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    pub interval: Option<f64>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub view: View,
    /// Draw paths, forces and speeds of this particle only, by its number (from 0) or its name;
    /// several with commas [default: all, of more than seven by material and size].
    #[arg(long = "particle", value_name = "PARTICLE", value_delimiter = ',')]
    pub particles: Vec<String>,
    /// Where figures go that are named or of several runs [default: figures/ of the run, of
    /// several the first].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// A figure that can be asked for by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Figure {
    /// Vorticity and streamlines of the last state.
    Vorticity,
    /// Streamlines of the last state, coloured by speed.
    Streamlines,
    /// The colours of --field alone, with bodies coloured by --bodies and marked so that their
    /// turning shows; beside each other at several --times.
    Field,
    /// Vorticity at several times, with contour lines that are dashed where it is negative (Figs.
    /// 7, 11, 14).
    VorticityStrip,
    /// Streamlines at several times (Fig. 6).
    StreamlinesStrip,
    /// Paths of particles in their box, of all runs in one picture, beside the band of a position
    /// measure (Fig. 9).
    Paths,
    /// Forces on particles over time: of few a line each, of many by material and size.
    Forces,
    /// Parts of the force across gravity over the height of a falling particle (Fig. 10).
    ForceParts,
    /// Velocities of free particles over time: of few a line each, of many by material and size.
    Speeds,
    /// Mean velocity and solid fraction across layers of cells, where the case has
    /// `statistics.profile`.
    Profile,
    /// Velocity and pressure over time at probes of one point, where the case has some.
    Probes,
    /// Mean velocity and pressure along probes of several points, where the case has some.
    ProbeLines,
    /// Drag coefficient over Re of all runs, beside the references of their cases; of one body in
    /// an unbounded stream beside a formula (Fig. 4).
    Drag,
    /// Strouhal number over Re of all runs, beside the references of their cases (Fig. 5).
    Strouhal,
}

impl Figure {
    /// Its name on the command line.
    fn name(self) -> String {
        clap::ValueEnum::to_possible_value(&self)
            .map_or_else(String::new, |value| value.get_name().to_owned())
    }

    fn is_strip(self) -> bool {
        matches!(self, Figure::VorticityStrip | Figure::StreamlinesStrip)
    }

    fn is_of_the_flow(self) -> bool {
        self.is_strip() || matches!(self, Figure::Vorticity | Figure::Streamlines | Figure::Field)
    }

    fn is_of_particles(self) -> bool {
        matches!(self, Figure::Paths | Figure::Forces | Figure::ForceParts | Figure::Speeds)
    }

    /// Whether several runs make one picture.
    fn joins_runs(self) -> bool {
        matches!(self, Figure::Paths | Figure::Drag | Figure::Strouhal)
    }

    /// What a run needs for it.
    fn needs(self) -> &'static str {
        match self {
            Figure::Vorticity
            | Figure::Streamlines
            | Figure::Field
            | Figure::VorticityStrip
            | Figure::StreamlinesStrip => "fields",
            Figure::Paths => "a particle that moves, and its rows in particles.csv",
            Figure::Forces => "a particle, and its rows in particles.csv",
            Figure::ForceParts => {
                "a free particle with its rows in particles.csv, gravity, and a density other than \
                the fluid's"
            }
            Figure::Speeds => "a free particle, and its rows in particles.csv",
            Figure::Profile => "statistics with a profile (profile.csv)",
            Figure::Probes => "a [[probe]] of one point (probes.csv)",
            Figure::ProbeLines => "a [[probe]] of several points (probes.csv)",
            Figure::Drag => "a measure of kind \"drag_coefficient\" with a value in summary.json",
            Figure::Strouhal => "a measure of kind \"strouhal\" with a value in summary.json",
        }
    }
}

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
        Rows::read(&self.folder, &self.case, &[], &self.asked)
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
        let folder = request.folder(&runs)?;
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
            let Some(files) = request.draw(*figure, runs)? else {
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

impl Request {
    /// The figures that are asked for by name, or by what they show.
    fn figures(&self) -> Vec<Figure> {
        let view = &self.view;
        if !self.figures.is_empty() {
            return self.figures.clone();
        }
        if view.field.is_some() || view.bodies.is_some() {
            return vec![Figure::Field];
        }
        // What is said of the flow, is of its usual figures; a range would have to be that of
        // vorticity or of speed.
        let of_the_flow = !self.times.is_empty()
            || view.plane.is_some()
            || !view.window.is_empty()
            || view.size.is_some();
        match self.times.len() {
            _ if !of_the_flow || !view.range.is_empty() => Vec::new(),
            0 | 1 => vec![Figure::Streamlines, Figure::Vorticity],
            _ => vec![Figure::StreamlinesStrip, Figure::VorticityStrip],
        }
    }

    fn check(&self) -> Result<()> {
        let refuse = |why: String| Err(Error::Usage(why));
        let figures = self.figures();
        let of_the_flow =
            "ask for --figure field, vorticity, streamlines, vorticity-strip or streamlines-strip";
        let single = figures.iter().find(|figure| !figure.joins_runs());
        if let (Some(figure), Some(out), 2..) = (single, &self.out, self.runs.len()) {
            return refuse(format!(
                "--out {}: {} is of one run, and there are {}; leave --out away, and each goes to \
                its run's figures/",
                out.display(),
                figure.name(),
                self.runs.len()
            ));
        }
        if !self.times.is_empty() && !figures.iter().any(|figure| figure.is_of_the_flow()) {
            return refuse(format!("--times are of the flow; {of_the_flow}"));
        }
        if self.times.len() > 1
            && !figures.iter().any(|figure| figure.is_strip() || *figure == Figure::Field)
        {
            return refuse(
                "--times: several are of a strip; ask for --figure vorticity-strip, \
                streamlines-strip or field"
                    .into(),
            );
        }
        if self.interval.is_some() && !figures.contains(&Figure::VorticityStrip) {
            return refuse(
                "--interval is of contour lines; ask for --figure vorticity-strip".into(),
            );
        }
        let view = &self.view;
        let options = [
            ("--window", !view.window.is_empty()),
            ("--plane", view.plane.is_some()),
            ("--range", !view.range.is_empty()),
            ("--size", view.size.is_some()),
        ];
        if let Some((option, _)) = options.iter().find(|(_, given)| *given)
            && !figures.iter().any(|figure| figure.is_of_the_flow())
        {
            return refuse(format!("{option} is of the flow; {of_the_flow}"));
        }
        if (view.field.is_some() || view.bodies.is_some()) && !figures.contains(&Figure::Field) {
            return refuse(
                "--field and --bodies are of --figure field; add it, or leave --figure away".into(),
            );
        }
        view.check()?;
        if !self.particles.is_empty() && !figures.iter().any(|figure| figure.is_of_particles()) {
            return refuse(
                "--particle is of curves; ask for --figure paths, forces, force-parts or speeds"
                    .into(),
            );
        }
        if let Some(time) = self.times.iter().find(|time| !time.is_finite()) {
            return refuse(format!("--times {time}: a time is a number of seconds"));
        }
        if let Some(interval) =
            self.interval.filter(|interval| !(*interval > 0.0 && interval.is_finite()))
        {
            return refuse(format!("--interval {interval}: has to be positive, in 1/s"));
        }
        Ok(())
    }

    /// Where a figure of some runs goes, made if it is not there.
    fn folder(&self, runs: &[Run]) -> Result<PathBuf> {
        let folder = self
            .out
            .clone()
            .or_else(|| Some(runs.first()?.folder.join("figures")))
            .unwrap_or_default();
        fs::create_dir_all(&folder).map_err(Error::io(&folder))?;
        Ok(folder)
    }

    /// Draws a figure of some runs, of the first one where it is of one; none where there is
    /// nothing to draw.
    fn draw(&self, figure: Figure, runs: &[Run]) -> Result<Option<Vec<PathBuf>>> {
        let Some(run) = runs.first() else { return Ok(None) };
        let stem = |name: &str| Ok::<_, Error>(self.folder(runs)?.join(name));
        let titled = |planes: &[figure::Plane]| {
            let place = planes.first().map_or("", |plane| &plane.place);
            format!("{}{place}", run.case.name)
        };
        let seen = |plane| self.view.part(figure::Plane { style: self.view.style(), ..plane });
        self.view.fits(run)?;
        let last = |run: &Run| {
            let plane =
                Last::read(run, self.view.plane, self.times.last().copied())?.planes.swap_remove(0);
            seen(plane)
        };
        let planes = |run: &Run| -> Result<Vec<_>> {
            fields::planes(&run.folder, &run.case, self.view.plane, &self.times)?
                .into_iter()
                .map(seen)
                .collect()
        };
        if figure == Figure::Field {
            let frames = match (&self.times[..], newest_snapshot(&run.folder)?) {
                ([], last) => vec![(Snapshot::time_of(&last)?, last)],
                (times, _) => fields::choose(&run.folder, times)?,
            };
            let folder = self.folder(runs)?;
            return Reel::of(run, &self.view, &frames)
                .and_then(|reels| reel::pictures(&reels, &folder))
                .map(Some);
        }
        let drawn = match figure {
            Figure::Vorticity => figure::vorticity(&last(run)?, &stem("vorticity")?)?,
            Figure::Streamlines => figure::streamlines(&last(run)?, &stem("streamlines")?)?,
            Figure::VorticityStrip => {
                let planes = planes(run)?;
                figure::vorticity_strip(
                    &planes,
                    &titled(&planes),
                    self.interval,
                    &stem("vorticity_strip")?,
                )?
            }
            Figure::StreamlinesStrip => {
                let planes = planes(run)?;
                figure::streamlines_strip(&planes, &titled(&planes), &stem("streamlines_strip")?)?
            }
            Figure::Drag => return Ok(reynolds::drag(runs, &self.folder(runs)?)?.map(Vec::from)),
            Figure::Strouhal => {
                return Ok(reynolds::strouhal(runs, &self.folder(runs)?)?.map(Vec::from));
            }
            _ => {
                let rows: Vec<Rows> = runs.iter().map(Run::rows).collect();
                let Some(chart) = curves(figure, runs, &rows)? else { return Ok(None) };
                figure::chart(&chart, &stem(&figure.name().replace('-', "_"))?)?
            }
        };
        Ok(Some(drawn.into()))
    }
}

/// The last state of a run or one before, in one plane or several.
struct Last {
    planes: Vec<figure::Plane>,
    rows: Rows,
}

impl Last {
    /// Reads the last one, or that next to a time (s).
    fn read(run: &Run, section: Option<Section>, time: Option<f64>) -> Result<Last> {
        let path = match time {
            None => newest_snapshot(&run.folder)?,
            Some(time) => {
                let mut all = dated(&run.folder)?;
                fields::check_time(&run.folder, &all, time)?;
                all.swap_remove(fields::nearest(&all, time)).1
            }
        };
        let snapshot = Snapshot::read(&path)?;
        let rows = Rows::read(&run.folder, &run.case, &[snapshot.time], &run.asked);
        // The rows of a run that goes on may be behind its snapshots.
        let poses = bodies::read(&bodies::beside(&path))?;
        let place = |id: usize| {
            if poses.is_empty() {
                rows.centre(0, id).map(Pose::at)
            } else {
                poses.get(&id).copied()
            }
        };
        let sections = section.map_or_else(|| sections(&run.case, place), |section| vec![section]);
        let titled = |section: Section| {
            let plane = plane(
                &run.case,
                &snapshot,
                &run.folder,
                section,
                &place,
                &Look::at(snapshot.time),
            )?;
            let title = format!("{}, {}{}", run.case.name, plane.title, plane.place);
            Ok(figure::Plane { title, ..plane })
        };
        let planes = sections.into_iter().map(titled).collect::<Result<_>>()?;
        Ok(Last { planes, rows })
    }
}

/// Draws one run's usual figures into its `figures/`; returns the PNGs and SVGs, the vorticity's
/// last.
///
/// # Errors
/// When the folder does not hold a run, or a file cannot be written.
pub fn draw_run(folder: &Path) -> Result<Vec<PathBuf>> {
    let run = Run::read(folder, &[])?;
    // All is read before anything is written.
    let last = match Last::read(&run, None, None) {
        // One that has just begun has its rows.
        Err(_) if run.unfinished().is_some() && snapshots(folder).is_err() => {
            Last { planes: Vec::new(), rows: run.rows() }
        }
        last => last?,
    };
    let (runs, rows) = (std::slice::from_ref(&run), std::slice::from_ref(&last.rows));
    let figures = [
        Figure::Forces,
        Figure::Speeds,
        Figure::Paths,
        Figure::Profile,
        Figure::Probes,
        Figure::ProbeLines,
    ]
    .map(|figure| Ok((figure, curves(figure, runs, rows)?)));
    let figures = figures.into_iter().collect::<Result<Vec<_>>>()?;
    let folder = Request::default().folder(runs)?;
    let mut written = Vec::new();
    for (figure, drawn) in figures {
        if let Some(chart) = drawn {
            written.extend(figure::chart(&chart, &folder.join(figure.name().replace('-', "_")))?);
        }
    }
    for (number, plane) in last.planes.iter().enumerate().rev() {
        // The first has the plain names, and comes last.
        let stem = |name: &str| numbered(&folder.join(name), number);
        written.extend(figure::streamlines(plane, &stem("streamlines"))?);
        written.extend(figure::vorticity(plane, &stem("vorticity"))?);
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
fn curves(figure: Figure, runs: &[Run], rows: &[Rows]) -> Result<Option<Chart>> {
    let Some((Run { case, folder, asked }, of_one)) = runs.first().zip(rows.first()) else {
        return Ok(None);
    };
    let drawn = match figure {
        Figure::Forces => forces::forces(case, of_one, asked)?,
        Figure::Speeds => speeds(case, of_one, asked)?,
        Figure::ForceParts => forces::parts(case, of_one, asked)?.map(Chart::from),
        Figure::Profile => profile::profile(folder, case)?,
        Figure::Probes | Figure::ProbeLines => {
            let [points, lines] = probes::probes(folder)?;
            if figure == Figure::Probes { points } else { lines }
        }
        Figure::Paths => {
            let labels = labels(runs);
            let track = |((run, rows), label)| {
                let Run { case, asked, .. }: &Run = run;
                Track { label, case, rows, asked }
            };
            let tracks = runs.iter().zip(rows).zip(labels.iter().map(String::as_str)).map(track);
            paths(&tracks.collect::<Vec<_>>())?.map(Chart::from)
        }
        _ => None,
    };
    Ok(drawn.map(|mut chart| {
        if let Some((axes, _)) = chart.panels.first_mut() {
            let rest =
                if axes.title.is_empty() { String::new() } else { format!(": {}", axes.title) };
            axes.title = case.name.clone() + &rest;
        }
        chart
    }))
}

/// The names of the runs' folders, with what is before them where two have the same.
fn labels(runs: &[Run]) -> Vec<String> {
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
