//! Forces, torques and speeds of bodies over time.

use super::Run;
use super::bodies::{self, groups};
use super::kinds::{LINES, SPREAD};
use super::series::{Group, Panel, Plot, averaged};
use crate::figure::{Chart, SeriesStyle};
use mics_run::Result;
use mics_run::config::{Case, WallRule};
use mics_run::words::rounded;

const AXES: [&str; 3] = ["x", "y", "z"];
/// Part of the run whose forces are not shown: the first steps of an impulsive start would flatten
/// all that follows.
const START: f64 = 0.02;

/// A vector of bodies over time.
struct Vector {
    /// Its columns without the axis.
    column: &'static str,
    /// Its name and its unit.
    name: &'static str,
    unit: &'static str,
    /// The components that it has.
    axes: &'static [&'static str],
}

impl Vector {
    /// A panel for each component.
    fn panels(&self) -> Vec<Panel> {
        let panel = |axis: &&str| {
            let column = format!("{}{axis}", self.column);
            let quantity = format!("{} along {axis}", self.name);
            Panel::of(&column, &quantity, self.unit, "time", "time (s)").in_family(self.name)
        };
        self.axes.iter().map(panel).collect()
    }

    /// The columns of all components, the time before them.
    fn columns(&self) -> Vec<String> {
        let components = self.axes.iter().map(|axis| format!("{}{axis}", self.column));
        std::iter::once("time".to_owned()).chain(components).collect()
    }
}

/// The axes of a case.
fn axes(case: &Case) -> &'static [&'static str] {
    &AXES[..case.dimension()]
}

/// Force of the fluid over time, a panel for each axis that matters: on one body of one run with
/// its parts, on few a line each, on many by kinds; on bodies and obstacles that are asked for, or
/// else on all. None where there are no rows.
///
/// # Errors
/// When the rows lack a column.
pub fn forces(runs: &[Run], mean: bool) -> Result<Option<Chart>> {
    let Some(Run { case, asked, .. }) = runs.first() else { return Ok(None) };
    let unit = if case.dimension() == 2 { "N/m" } else { "N" };
    let force = Vector { column: "fluid_f", name: "force", unit, axes: axes(case) };
    match (runs, &bodies::loaded(case, asked)[..]) {
        ([run], [id]) => Ok(parts_of(run, *id, &force)?.chart()),
        _ => loads(runs, mean, &force),
    }
}

/// Torque of the fluid over time, as [`forces`].
///
/// # Errors
/// When the rows lack a column.
pub fn torques(runs: &[Run], mean: bool) -> Result<Option<Chart>> {
    let Some(Run { case, .. }) = runs.first() else { return Ok(None) };
    let flat = case.dimension() == 2;
    let unit = if flat { "N m/m" } else { "N m" };
    let axes = if flat { &AXES[2..] } else { &AXES[..] };
    let torque = Vector { column: "fluid_t", name: "torque", unit, axes };
    let mut chart = loads(runs, mean, &torque)?;
    if let Some((axes, _)) = chart.iter_mut().flat_map(|chart| &mut chart.panels).next() {
        axes.title += ", about the centre of each";
    }
    Ok(chart)
}

/// A load of the fluid on the bodies of runs.
fn loads(runs: &[Run], mean: bool, vector: &Vector) -> Result<Option<Chart>> {
    let of = |run: &Run| bodies::loaded(&run.case, &run.asked);
    let mut plot = of_bodies(runs, mean, vector, of)?;
    let start = runs.iter().map(|run| START * run.case.time.end).fold(0.0, f64::max);
    plot.groups.iter_mut().for_each(|group| after(group, start));
    plot.notes.push(cut(start));
    let of = match (runs, &of(&runs[0])[..]) {
        ([run], [id]) => format!(" on {}", run.case.called(*id)),
        _ => std::mem::take(&mut plot.title),
    };
    plot.title = format!("{} of the fluid{of}", vector.name);
    plot.cut_peaks = true;
    Ok(plot.chart())
}

/// Velocity over time of the free particles that are asked for, or else of all, a panel for each
/// axis that matters: of few a line each, of many by kinds.
///
/// # Errors
/// When the rows lack a column.
pub fn speeds(runs: &[Run], mean: bool) -> Result<Option<Chart>> {
    let Some(Run { case, asked, .. }) = runs.first() else { return Ok(None) };
    let velocity = Vector { column: "v", name: "velocity", unit: "m/s", axes: axes(case) };
    let of = |run: &Run| bodies::free(&run.case, &run.asked);
    let mut plot = of_bodies(runs, mean, &velocity, of)?;
    plot.title = match (runs, &bodies::free(case, asked)[..]) {
        ([_], [id]) => format!("velocity of {}", case.called(*id)),
        _ => format!("velocity{}", plot.title.replace(" on ", " of ")),
    };
    Ok(plot.chart())
}

/// A vector of some bodies of runs; the title says how many they are.
fn of_bodies(
    runs: &[Run],
    mean: bool,
    vector: &Vector,
    ids: impl Fn(&Run) -> Vec<usize>,
) -> Result<Plot> {
    let columns = vector.columns();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut all = Vec::new();
    let mut most = 0;
    for run in runs {
        let ids = ids(run);
        most = most.max(ids.len());
        all.extend(run.name(groups(run, &ids, &columns)?, mean));
    }
    let all = if mean { averaged(&all, "time") } else { all };
    let of_kinds = most > LINES;
    Ok(Plot {
        groups: all,
        panels: vector.panels(),
        title: if of_kinds { format!(" on {most} bodies") } else { String::new() },
        notes: of_kinds.then(|| SPREAD.to_owned()).into_iter().collect(),
        ..Plot::default()
    })
}

/// Leaves out the rows of a group up to a time (s).
fn after(group: &mut Group, start: f64) {
    let edges = group.edges.iter_mut().flatten();
    edges.chain([&mut group.table]).for_each(|table| table.retain(|time| time > start));
}

/// A note on a start that is left out.
fn cut(start: f64) -> String {
    format!("the first {} s, of an impulsive start, left out", rounded(start))
}

/// The force on a body along each axis with its parts.
fn parts_of(run: &Run, id: usize, force: &Vector) -> Result<Plot> {
    let parts = force_parts(&run.case);
    let prefixes = ["fluid", "contact"].into_iter().chain(parts.iter().map(|part| part.column));
    let names: Vec<String> = prefixes
        .flat_map(|prefix| force.axes.iter().map(move |axis| format!("{prefix}_f{axis}")))
        .collect();
    let columns: Vec<&str> =
        std::iter::once("time").chain(names.iter().map(String::as_str)).collect();
    let mut groups = bodies::each(run, &[id], &columns)?;
    let touched = |group: &Group| {
        let contact = |axis: &&str| group.table.column(&format!("contact_f{axis}")).to_vec();
        force.axes.iter().flat_map(contact).any(|force| force != 0.0)
    };
    // All panels have the same lines, since they share a legend.
    let touched = groups.iter().any(touched);
    let start = START * run.case.time.end;
    groups.iter_mut().for_each(|group| after(group, start));
    let panel = |(mut panel, axis): (Panel, &&str)| {
        panel.lines[0].label = "fluid, in all".into();
        for Part { column, words } in &parts {
            panel = panel.with(&format!("{column}_f{axis}"), words, SeriesStyle::Dashed);
        }
        let contact = format!("contact_f{axis}");
        match touched {
            true => panel.with(&contact, "contacts and lubrication", SeriesStyle::Line),
            false => panel,
        }
    };
    Ok(Plot {
        groups,
        panels: force.panels().into_iter().zip(force.axes).map(panel).collect(),
        title: format!("force on {}", run.case.called(id)),
        notes: vec![cut(start)],
        cut_peaks: true,
        ..Plot::default()
    })
}

/// A part of the fluid's force on a body.
struct Part {
    /// Prefix of its columns.
    column: &'static str,
    /// Its name in legends.
    words: &'static str,
}

/// Pressure, viscous part and remainder of the fluid's force on a body.
fn force_parts(case: &Case) -> [Part; 3] {
    let part = |column, words| Part { column, words };
    match case.coupling.wall {
        WallRule::Sharp => [
            part("pressure", "pressure on the surface"),
            part("viscous", "shear on the surface"),
            part("defect", "force defect"),
        ],
        WallRule::Mixture => [
            part("pressure", "F_p, pressure part of (19)"),
            part("viscous", "F_d, viscous part"),
            part("convective", "F_c, convective part"),
        ],
    }
}
