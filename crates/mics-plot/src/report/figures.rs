//! The figures of a report, as SVG text.

use super::Run;
use crate::figure::{self, Axes, Chart, Series, SeriesStyle};
use crate::plot;
use mics_run::Result;
use std::path::Path;

/// A figure and what stands below it.
pub struct Figure {
    /// SVG text.
    pub svg: String,
    /// In a few words.
    pub title: &'static str,
    /// Text below it, which says what it shows.
    pub caption: String,
    /// The part of the report that it is in.
    pub part: Part,
}

/// Parts of a report that have figures.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The flow.
    Fields,
    /// Forces, speeds and paths of particles.
    Particles,
    /// Profiles and probes.
    Records,
    /// Divergence, iterations, steps.
    Numerics,
}

/// All figures that the run's folder gives.
pub fn figures(run: &Run, folder: &Path) -> Result<Vec<Figure>> {
    let mut all = fields(run, folder)?;
    all.extend(motion(run)?);
    all.extend(records(run, folder)?);
    all.extend(numerics(run, folder)?);
    Ok(all)
}

/// Draws curves where there is something to draw.
fn curves(
    part: Part,
    title: &'static str,
    caption: &str,
    axes: Axes,
    series: &[Series],
) -> Result<Option<Figure>> {
    if series.iter().all(|s| s.points.len() < 2) {
        return Ok(None);
    }
    Ok(Some(Figure {
        svg: figure::curves_svg(&axes, series)?,
        title,
        caption: caption.into(),
        part,
    }))
}

fn axes(x_label: &str, y_label: &str) -> Axes {
    Axes { x_label: x_label.into(), y_label: y_label.into(), ..Axes::default() }
}

fn fields(run: &Run, folder: &Path) -> Result<Vec<Figure>> {
    // A run that has written no field yet has no figure of one.
    let Ok(newest) = plot::newest_snapshot(folder) else { return Ok(Vec::new()) };
    let mut all = Vec::new();
    for mut plane in plot::last_planes(folder, &run.case, None, &newest)? {
        let place = std::mem::take(&mut plane.title) + &plane.place;
        let figure = |svg, title, what: &str| Figure {
            svg,
            title,
            caption: format!("{what} at {place}."),
            part: Part::Fields,
        };
        all.push(figure(
            figure::vorticity_svg(&plane)?,
            "Vorticity",
            "Vorticity, blue clockwise and red counterclockwise, with streamlines,",
        ));
        all.push(figure(
            figure::streamlines_svg(&plane)?,
            "Streamlines",
            "Streamlines, coloured by speed,",
        ));
    }
    Ok(all)
}

/// A chart as a figure, what stands above it as its caption.
fn charted(part: Part, title: &'static str, chart: Option<Chart>) -> Result<Option<Figure>> {
    let Some(mut chart) = chart else { return Ok(None) };
    let mut caption = String::new();
    if let Some((axes, _)) = chart.panels.first_mut() {
        let [title, note] = [&mut axes.title, &mut axes.note].map(std::mem::take);
        let said = [title, note].into_iter().filter(|text| !text.is_empty());
        caption = said.map(|text| capital(&text)).collect::<Vec<_>>().join(". ") + ".";
    }
    Ok(Some(Figure { svg: figure::chart_svg(&chart)?, title, caption, part }))
}

/// A text with a capital letter.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}

/// Profiles, and what probes recorded.
fn records(run: &Run, folder: &Path) -> Result<Vec<Figure>> {
    let [points, lines] = plot::probes(folder)?;
    let figures = [
        charted(Part::Records, "Profile", plot::profile(folder, &run.case)?)?,
        charted(Part::Records, "Probes over time", points)?,
        charted(Part::Records, "Probes along lines", lines)?,
    ];
    Ok(figures.into_iter().flatten().collect())
}

fn motion(run: &Run) -> Result<Vec<Figure>> {
    let track = || plot::Track {
        label: "",
        case: &run.case,
        rows: &run.particles,
        asked: &[],
        averaged: false,
    };
    let (mut path_axes, paths) = plot::paths(&[track()])?.unwrap_or_default();
    path_axes.title.clear();
    let movers = plot::moving(&run.case, &[]).len();
    let shown = paths.iter().filter(|s| s.style == SeriesStyle::Line).count();
    let caption = match movers {
        0 | 1 => "The path of its centre, in the whole box.".to_owned(),
        _ if shown == movers => "The paths of the bodies that move, in the whole box.".to_owned(),
        _ => format!(
            "The paths of {shown} of the {movers} bodies that move, of every material and size, in \
            the whole box."
        ),
    };
    let figures = [
        charted(Part::Particles, "Forces", plot::forces(&[track()])?)?,
        curves(Part::Particles, "Paths", &caption, path_axes, &paths)?,
        charted(Part::Particles, "Velocity", plot::speeds(&[track()])?)?,
    ];
    Ok(figures.into_iter().flatten().collect())
}

fn numerics(run: &Run, folder: &Path) -> Result<Vec<Figure>> {
    let over = |name: &str, label: &str| Series {
        label: label.into(),
        // The row of time 0 has no step behind it.
        points: run
            .column("time")
            .iter()
            .copied()
            .zip(run.column(name).iter().copied())
            .skip(1)
            .collect(),
        style: SeriesStyle::Line,
    };
    let limit = run.case.pressure.divergence_limit;
    let part = Part::Numerics;
    let length = [over("dt", "")];
    let figures = [
        charted(part, "Iterations and divergence", plot::over_steps(&[("", folder, limit)])?)?,
        curves(part, "Time step", "The length of each step.", axes("time (s)", "dt (s)"), &length)?,
        energy(run, over)?,
        charted(part, "Convergence", plot::convergence(folder, limit, None)?)?,
    ];
    Ok(figures.into_iter().flatten().collect())
}

/// The kinetic energy over time, where particles are free of fluid and particles.
fn energy(run: &Run, over: impl Fn(&str, &str) -> Series) -> Result<Option<Figure>> {
    let (caption, energies) = match run.case.particle.iter().any(|p| p.is_free()) {
        true => (
            "The kinetic energy of the fluid outside the particles, that of the free particles, \
            and their sum.",
            vec![
                over("kinetic_energy", "both"),
                over("fluid_energy", "fluid"),
                over("bodies_energy", "free particles"),
            ],
        ),
        false => ("The kinetic energy of the fluid.", vec![over("kinetic_energy", "")]),
    };
    let unit = if run.case.dimension() == 2 { "J/m" } else { "J" };
    let axes = axes("time (s)", &format!("kinetic energy ({unit})"));
    curves(Part::Numerics, "Energy", caption, axes, &energies)
}
