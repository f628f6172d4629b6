//! The figures of a report, as SVG text.

use super::Run;
use crate::Result;
use crate::config::Motion;
use crate::output::figure::{self, Axes, Series, SeriesStyle};
use crate::output::plot;
use crate::output::snapshot::Snapshot;
use std::path::Path;

/// A figure and what stands below it.
pub struct Figure {
    /// SVG text.
    pub svg: String,
    /// In a few words.
    pub title: &'static str,
    /// What it shows.
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
    /// Divergence, iterations, steps.
    Numerics,
}

/// All figures that the run's folder gives.
pub fn figures(run: &Run, folder: &Path) -> Result<Vec<Figure>> {
    let mut all = fields(run, folder)?;
    all.extend(forces(run)?);
    all.extend(motion(run)?);
    all.extend(numerics(run)?);
    Ok(all)
}

/// Draws curves where there is something to draw.
fn curves(part: Part, title: &'static str, caption: &str, axes: Axes, series: &[Series]) -> Result<Option<Figure>> {
    if series.iter().all(|s| s.points.len() < 2) {
        return Ok(None);
    }
    Ok(Some(Figure { svg: figure::curves_svg(&axes, series)?, title, caption: caption.into(), part }))
}

fn axes(x_label: &str, y_label: &str) -> Axes {
    Axes { x_label: x_label.into(), y_label: y_label.into(), ..Axes::default() }
}

fn fields(run: &Run, folder: &Path) -> Result<Vec<Figure>> {
    // A run that has written no field yet has no figure of one.
    let Ok(newest) = plot::newest_snapshot(folder) else { return Ok(Vec::new()) };
    let snapshot = Snapshot::read(&newest)?;
    let mut all = Vec::new();
    for section in plot::sections(&run.case, run.particles.poses(0)) {
        let mut plane =
            plot::plane(&run.case, &snapshot, folder, section, &run.particles.poses(0), &plot::Look::default())?;
        let place = std::mem::take(&mut plane.title) + &plane.place;
        let figure =
            |svg, title, what: &str| Figure { svg, title, caption: format!("{what} at {place}."), part: Part::Fields };
        all.push(figure(
            figure::vorticity_svg(&plane)?,
            "Vorticity",
            "Vorticity, blue clockwise and red counterclockwise, with streamlines,",
        ));
        all.push(figure(figure::streamlines_svg(&plane)?, "Streamlines", "Streamlines, coloured by speed,"));
    }
    Ok(all)
}

/// The force along each axis: on one particle with its parts, on several of each.
fn forces(run: &Run) -> Result<Vec<Figure>> {
    let (case, ids) = (&run.case, plot::loaded(&run.case, &[]));
    if run.particles.is_empty() {
        return Ok(Vec::new());
    }
    let curve = |id: usize, column: &str, label: &str, style| {
        let mut one = run.particles.curve(id, "time", column, label)?;
        // An impulsive start would flatten all that follows.
        one.points.retain(|p| p.0 > 0.02 * case.time.end);
        Ok(Series { style, ..one })
    };
    let mut all = Vec::new();
    let titles = [("x", "Force along x"), ("y", "Force along y"), ("z", "Force along z")];
    for (axis, title) in titles.into_iter().take(case.dimension()) {
        let mut series = Vec::new();
        let [pressure, viscous, convective] = plot::words(case);
        let of_one = [
            ("fluid", "by the fluid", SeriesStyle::Line),
            ("pressure", pressure, SeriesStyle::Dashed),
            ("viscous", viscous, SeriesStyle::Dashed),
            ("convective", convective, SeriesStyle::Dashed),
            ("contact", "by contacts", SeriesStyle::Line),
        ];
        let (caption, parts) = match ids[..] {
            [id] => (format!("The force on {} and the parts that it is made of", case.called(id)), &of_one[..]),
            _ => (format!("The force of the fluid on {} of the particles", ids.len()), &of_one[..1]),
        };
        for id in &ids {
            for (column, label, style) in parts {
                let label = if parts.len() > 1 { (*label).to_owned() } else { case.called(*id) };
                let one = curve(*id, &format!("{column}_f{axis}"), &label, *style)?;
                if *column != "contact" || one.points.iter().any(|p| p.1 != 0.0) {
                    series.push(one);
                }
            }
        }
        let caption = caption + ", without the first fiftieth of the run.";
        all.extend(curves(Part::Particles, title, &caption, axes("time (s)", "force (N)"), &series)?);
    }
    Ok(all)
}

fn motion(run: &Run) -> Result<Vec<Figure>> {
    let track = plot::Track { label: "", case: &run.case, rows: &run.particles, asked: &[] };
    let (path_axes, paths) = plot::paths(&[track])?.unwrap_or_default();
    let movers = run.case.particle.iter().filter(|p| p.motion != Motion::Fixed).count();
    let shown = paths.iter().filter(|s| s.style != SeriesStyle::Band).count();
    let caption = match movers {
        0 | 1 => "The way of its centre, in the whole box.".to_owned(),
        _ => format!("The ways of the first {shown} of {movers} particles that move, in the whole box."),
    };
    let (y_label, speeds) = plot::speeds(&run.case, &run.particles, &[])?;
    let speed = match speeds.len() {
        count if y_label.starts_with("velocity along") => &format!("The velocity of {count} of the free particles."),
        _ => "The velocity of the free particle.",
    };
    let figures = [
        curves(Part::Particles, "Paths", &caption, path_axes, &paths)?,
        curves(Part::Particles, "Velocity", speed, axes("time (s)", &y_label), &speeds)?,
    ];
    Ok(figures.into_iter().flatten().collect())
}

fn numerics(run: &Run) -> Result<Vec<Figure>> {
    let (steps, times) = (run.column("step"), run.column("time"));
    let over = |x: &[f64], name: &str, label: &str| Series {
        label: label.into(),
        // The row of time 0 has no step behind it.
        points: x.iter().copied().zip(run.column(name).iter().copied()).skip(1).collect(),
        style: SeriesStyle::Line,
    };
    let limit = run.case.pressure.divergence_limit;
    let ends = [steps.get(1), steps.last()].into_iter().flatten();
    let limit = Series {
        label: "limit D0".into(),
        points: ends.map(|step| (*step, limit)).collect(),
        style: SeriesStyle::Dashed,
    };
    let divergence = [over(steps, "divergence_max", "largest |D|"), limit];
    let iterations = [over(steps, "outer_iterations", "C-HSMAC"), over(steps, "krylov_iterations", "Krylov")];
    let log = Axes { log_y: true, ..axes("step", "largest |D| (1/s)") };
    let part = Part::Numerics;
    let energies = [
        over(times, "kinetic_energy", "both"),
        over(times, "fluid_energy", "fluid"),
        over(times, "bodies_energy", "free particles"),
    ];
    let figures = [
        curves(
            part,
            "Divergence",
            "The largest |D| of all cells after each step, and the limit that it is held under.",
            log,
            &divergence,
        )?,
        curves(
            part,
            "Iterations",
            "Iterations of the pressure in each step: C-HSMAC's, and those of the linear solves in them.",
            axes("step", "iterations"),
            &iterations,
        )?,
        curves(part, "Time step", "The length of each step.", axes("time (s)", "dt (s)"), &[over(times, "dt", "")])?,
        curves(
            part,
            "Energy",
            "The kinetic energy of the fluid outside the particles, that of the free particles, and their sum.",
            axes("time (s)", "kinetic energy (J)"),
            &energies,
        )?,
    ];
    Ok(figures.into_iter().flatten().collect())
}
