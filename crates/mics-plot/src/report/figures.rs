//! The figures of a report, as SVG text.

use super::Run;
use crate::figure::{self, Chart};
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
    for (figure, chart) in plot::charts(&run.of)? {
        let (title, part) = match figure {
            plot::Figure::Forces => ("Forces", Part::Particles),
            plot::Figure::Speeds => ("Velocity", Part::Particles),
            plot::Figure::Paths => ("Paths", Part::Particles),
            plot::Figure::Profile => ("Profile", Part::Records),
            plot::Figure::Probes => ("Probes over time", Part::Records),
            plot::Figure::ProbeLines => ("Probes along lines", Part::Records),
            plot::Figure::ConvergenceSteps => ("Iterations and divergence", Part::Numerics),
            _ => ("Convergence", Part::Numerics),
        };
        all.push(charted(part, title, chart)?);
    }
    let numerics = [("Time step", plot::lengths(&run.of)?), ("Energy", plot::energy(&run.of)?)];
    for (title, chart) in numerics {
        all.extend(chart.map(|chart| charted(Part::Numerics, title, chart)).transpose()?);
    }
    Ok(all)
}

fn fields(run: &Run, folder: &Path) -> Result<Vec<Figure>> {
    // A run that has written no field yet has no figure of one.
    let Ok(newest) = plot::newest_snapshot(folder) else { return Ok(Vec::new()) };
    let mut all = Vec::new();
    for mut plane in plot::last_planes(folder, run.case(), None, &newest)? {
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
fn charted(part: Part, title: &'static str, mut chart: Chart) -> Result<Figure> {
    let mut caption = String::new();
    if let Some((axes, _)) = chart.panels.first_mut() {
        let [title, note] = [&mut axes.title, &mut axes.note].map(std::mem::take);
        let said = [title, note].into_iter().filter(|text| !text.is_empty());
        caption = said.map(|text| capital(&text) + ".").collect::<Vec<_>>().join(" ");
    }
    Ok(Figure { svg: figure::chart_svg(&chart)?, title, caption, part })
}

/// A text with a capital letter.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}
