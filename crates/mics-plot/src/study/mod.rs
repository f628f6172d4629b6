//! The figures of a study: each measure over what is varied, error over CPU seconds for each
//! reference, and cost of a cell and step over cells.

mod groups;

use crate::figure::{Axes, Series, SeriesStyle, curves};
use groups::Groups;
use mics_run::Result;
use std::path::{Path, PathBuf};

/// Ratio of the greatest to the least varied value from which on their axis is logarithmic.
const WIDE: f64 = 20.0;

/// Plan of a study: what it varies, measures and compares with.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// The names of the columns that tell runs apart.
    pub names: &'a [String],
    /// The names of the measures.
    pub measures: &'a [String],
    /// References that measures are compared with.
    pub references: &'a [Target],
    /// CPU times and errors of others.
    pub others: &'a [Others],
    /// The costs that have a figure: their names, and what their axes say.
    pub costs: &'a [(String, &'a str)],
}

impl Plan<'_> {
    /// Text of a row in a column of labels; the number of ranks where there is no such column.
    fn label(&self, name: &str, row: &Row) -> String {
        match self.names.iter().position(|other| other == name) {
            Some(at) => row.labels[at].clone(),
            None => row.ranks.to_string(),
        }
    }

    fn target(&self, measure: &str) -> Option<&Target> {
        self.references.iter().find(|target| target.measure == measure)
    }
}

/// Points of others in the figure of a measure.
#[derive(Clone, Debug)]
pub struct Others {
    /// The measure's name.
    pub measure: String,
    /// Source, CPU time (s) and error of each (% where errors are parts of a reference).
    pub points: Vec<(String, (f64, f64))>,
}

/// References of a measure.
#[derive(Clone, Debug)]
pub struct Target {
    /// The measure's name.
    pub measure: String,
    /// For each run, its reference, where there is one.
    pub values: Vec<Option<f64>>,
    /// Whether these are of other runs of the study.
    pub of_runs: bool,
}

impl Target {
    /// References of some of the runs.
    fn of(&self, runs: &[usize]) -> Target {
        let values = runs.iter().map(|run| self.values.get(*run).copied().flatten()).collect();
        Target { values, ..self.clone() }
    }

    /// Whether errors are parts of the reference: where it is 0 in every run, they are differences.
    pub fn is_relative(&self) -> bool {
        self.values.iter().flatten().any(|exact| *exact != 0.0)
    }

    /// The error of a run's value; `None` where it has no reference, or one of 0 beside others that
    /// are not.
    pub fn error(&self, run: usize, value: f64) -> Option<f64> {
        match self.values[run]? {
            0.0 if self.is_relative() => None,
            0.0 => Some(value),
            exact => Some(value / exact - 1.0),
        }
    }
}

/// A measure of a run.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Its name.
    pub name: String,
    /// Its unit, where the run says one.
    pub unit: String,
    /// Its median, where a repeat gave one.
    pub value: Option<f64>,
    /// `value/reference - 1` (the difference where all references are 0), where there is a
    /// reference.
    pub error: Option<f64>,
}

/// A run, of several repeats their medians.
#[derive(Clone, Debug)]
pub struct Row {
    /// Texts of its columns.
    pub labels: Vec<String>,
    /// Number of ranks.
    pub ranks: usize,
    /// The measures.
    pub measured: Vec<Measured>,
    /// CPU seconds of all ranks, start and end included.
    pub cpu: Option<f64>,
    /// Cells of the grid.
    pub cells: Option<f64>,
    /// Wall-clock time of a cell and step (us).
    pub per_cell_step: Option<f64>,
    /// The costs that have a figure.
    pub costs: Vec<Option<f64>>,
}

/// Layout of the runs in figures.
#[derive(Clone, Copy, Debug)]
pub struct Layout<'a> {
    /// The columns that tell one curve from another.
    pub series: Option<&'a [String]>,
    /// The columns that have figures of their own for each of their labels.
    pub each: &'a [String],
    /// Runs that differ in these columns alone are one point of the errors.
    pub over: &'a [String],
}

/// Draws what there is to draw, each as `STEM.png` and `STEM.svg` in a folder. Runs that differ in
/// the columns `over` of the layout alone are one point of the errors: the worst of them and, in a
/// figure of its own, their mean.
///
/// # Errors
/// When a figure cannot be written.
pub fn draw(
    study: &str,
    plan: &Plan,
    rows: &[Row],
    layout: &Layout,
    folder: &Path,
) -> Result<Vec<PathBuf>> {
    let mut parts: Vec<(Vec<String>, Vec<usize>)> = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        let key: Vec<String> = layout.each.iter().map(|name| plan.label(name, row)).collect();
        match parts.iter_mut().find(|(other, _)| *other == key) {
            Some((_, all)) => all.push(index),
            None => parts.push((key, vec![index])),
        }
    }
    let mut written = Vec::new();
    for (key, of_key) in parts {
        let part: Vec<Row> = of_key.iter().map(|index| rows[*index].clone()).collect();
        let references: Vec<Target> =
            plan.references.iter().map(|target| target.of(&of_key)).collect();
        let title = [&[study.to_owned()], &key[..]].concat().join(", ");
        let named = key.iter().filter(|label| !label.is_empty());
        let ending: String = named.map(|label| format!("_{}", file_name(label))).collect();
        let plan = Plan { references: &references, ..*plan };
        written.extend(draw_part(&title, &plan, &part, layout, &|stem| {
            folder.join(format!("{stem}{ending}"))
        })?);
    }
    Ok(written)
}

/// A label as a part of a file's name: letters and digits, and a `-` for what stands between.
fn file_name(label: &str) -> String {
    let words = label.split(|c: char| !c.is_ascii_alphanumeric() && c != '.');
    words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-")
}

/// Draws the figures of some rows where `place` puts them by name.
fn draw_part(
    study: &str,
    plan: &Plan,
    rows: &[Row],
    layout: &Layout,
    place: &dyn Fn(&str) -> PathBuf,
) -> Result<Vec<PathBuf>> {
    let groups = Groups::new(plan, rows, layout);
    let title = match &groups.along[..] {
        [along] => format!("{study}, {along} along a curve"),
        _ => study.to_owned(),
    };
    let figures = values(study, plan, rows, &groups)
        .into_iter()
        .chain(errors(plan, rows, &groups, !layout.over.is_empty()))
        .chain(cost(plan, rows, &groups))
        .chain(costs(study, plan, rows, &groups));
    let mut written = Vec::new();
    for Figure { axes, series, stem } in figures.filter(|figure| !figure.series.is_empty()) {
        let title = if axes.title.is_empty() { title.clone() } else { axes.title.clone() };
        written.extend(curves(&Axes { title, ..axes }, &series, &place(&stem))?);
    }
    Ok(written)
}

/// A figure before it is drawn.
struct Figure {
    axes: Axes,
    series: Vec<Series>,
    stem: String,
}

/// Each measure over what changes along a curve, where that is a number, beside its references.
fn values(study: &str, plan: &Plan, rows: &[Row], groups: &Groups) -> Vec<Figure> {
    let Some(along) = groups.numeric(plan, rows) else { return Vec::new() };
    let x = |row: &Row| groups.number(plan, row, along);
    let figure = |name: &String| {
        let value = |row: &&Row| Some((x(row)?, row.measure(name)?.value?));
        let mut series = groups.series(rows, &|same| mean_point(same.iter().filter_map(value)));
        let target = plan.target(name).filter(|_| !series.is_empty());
        let exact = target.map_or(Vec::new(), |target| {
            let place = |(row, value): (&Row, &Option<f64>)| Some((x(row)?, (*value)?));
            let mut points: Vec<_> = rows.iter().zip(&target.values).filter_map(place).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points.dedup();
            points
        });
        if exact.len() > 1 {
            let label = "reference".into();
            let style = SeriesStyle::Dashed;
            series.push(Series { label, points: exact, style });
        }
        let places = || series.iter().flat_map(|one| &one.points).map(|point| point.0);
        let least = places().fold(f64::INFINITY, f64::min);
        let most = places().fold(0.0, f64::max);
        let axes = Axes {
            x_label: along.to_owned(),
            y_label: format!("{name}{}", unit(rows, name)),
            title: format!("{study}: {name} over {along}"),
            log_x: least > 0.0 && most > WIDE * least,
            ..Axes::default()
        };
        Figure { axes, series, stem: format!("value_{name}") }
    };
    plan.measures.iter().map(figure).collect()
}

/// The error of each measure that has a reference over CPU time; of `several` runs that are one
/// point the worst and, in a figure of its own, the mean.
fn errors(plan: &Plan, rows: &[Row], groups: &Groups, several: bool) -> Vec<Figure> {
    let worst = |errors: &[f64]| errors.iter().fold(0.0f64, |worst, error| worst.max(error.abs()));
    let kinds: &[(&str, &str, Summary)] = match several {
        false => &[("error", "", &worst)],
        true => {
            &[("worst error", "", &worst), ("mean error", "_mean", &|errors| mean(errors).abs())]
        }
    };
    let mut figures = Vec::new();
    for target in plan.references {
        let measure = &target.measure;
        let percent = if target.is_relative() { 100.0 } else { 1.0 };
        let unit = if target.is_relative() { " (%)".into() } else { unit(rows, measure) };
        let error = |row: &&Row| Some((row.cpu?, row.measure(measure)?.error?));
        for (kind, ending, summary) in kinds {
            let point = |same: &[&Row]| {
                let (cpu, errors): (Vec<f64>, Vec<f64>) = same.iter().filter_map(error).unzip();
                // An error of nothing has no place on a logarithmic axis.
                Some((mean(&cpu), percent * summary(&errors))).filter(|point| point.1 > 0.0)
            };
            let axes = Axes {
                x_label: "CPU time (s)".into(),
                y_label: format!("{kind} of {measure}{unit}"),
                log_x: true,
                log_y: true,
                ..Axes::default()
            };
            let mut series = groups.series(rows, &point);
            let shown = !series.is_empty();
            series.extend(others(plan, measure).into_iter().filter(|_| shown));
            figures.push(Figure {
                axes,
                series,
                stem: format!("work_precision_{measure}{ending}"),
            });
        }
    }
    figures
}

/// Time per cell and step over the number of cells or, where the grid is one, over the first thing
/// that is varied, if that is a number.
fn cost(plan: &Plan, rows: &[Row], groups: &Groups) -> Option<Figure> {
    // Runs that failed have no cells.
    let mut cells = rows.iter().filter_map(|row| row.cells);
    let first = cells.next();
    let varied = cells.any(|cells| Some(cells) != first);
    let number = |row: &Row| row.labels.first()?.parse::<f64>().ok().filter(|x| *x > 0.0);
    let over = match plan.names.first() {
        _ if varied => "cells",
        Some(name) if rows.iter().all(|row| number(row).is_some()) => name.as_str(),
        _ => return None,
    };
    let axes = Axes {
        x_label: over.into(),
        y_label: "time per cell and step (us)".into(),
        log_x: true,
        log_y: true,
        ..Axes::default()
    };
    let place = |row: &&Row| {
        let x = if varied { row.cells } else { number(row) };
        x.zip(row.per_cell_step)
    };
    let series = groups.series(rows, &|same| mean_point(same.iter().filter_map(place)));
    Some(Figure { axes, series, stem: "cost".into() })
}

/// Each cost over the cells, where they change along a curve, or over what changes along it and is
/// a number.
fn costs(study: &str, plan: &Plan, rows: &[Row], groups: &Groups) -> Vec<Figure> {
    let along = groups.numeric(plan, rows);
    let over_cells = groups.curves.iter().any(|(_, points)| {
        let mut cells = points.iter().flatten().filter_map(|index| rows[*index].cells);
        let first = cells.next();
        cells.any(|cells| Some(cells) != first)
    });
    let Some(over) = along.filter(|_| !over_cells).or(over_cells.then_some("cells")) else {
        return Vec::new();
    };
    let x = |row: &Row| match over_cells {
        true => row.cells,
        false => groups.number(plan, row, over),
    };
    let positive = |point: &(f64, f64)| point.0 > 0.0 && point.1 > 0.0;
    let figure = |(k, (name, words)): (usize, &(String, &str))| {
        let point = |row: &&Row| x(row).zip(row.costs.get(k).copied().flatten()).filter(positive);
        let axes = Axes {
            x_label: over.into(),
            y_label: (*words).to_owned(),
            title: format!("{study}, over {over}"),
            log_x: true,
            log_y: true,
            ..Axes::default()
        };
        let series = groups.series(rows, &|same| mean_point(same.iter().filter_map(point)));
        Figure { axes, series, stem: format!("cost_{name}") }
    };
    plan.costs.iter().enumerate().map(figure).collect()
}

/// The unit of a measure behind its name; nothing where it has none.
fn unit(rows: &[Row], name: &str) -> String {
    let units = rows.iter().filter_map(|row| Some(&row.measure(name)?.unit));
    let mut said = units.filter(|unit| !unit.is_empty());
    said.next().map_or(String::new(), |unit| format!(" ({unit})"))
}

impl Row {
    fn measure(&self, name: &str) -> Option<&Measured> {
        self.measured.iter().find(|m| m.name == name)
    }
}

/// The mean of some places; none of nothing.
fn mean_point(places: impl Iterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    let (x, y): (Vec<f64>, Vec<f64>) = places.unzip();
    (!x.is_empty()).then(|| (mean(&x), mean(&y)))
}

/// Function that sums up the errors of several runs.
type Summary<'a> = &'a dyn Fn(&[f64]) -> f64;

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The points of others in the figure of a measure, each as a series of its own.
fn others(plan: &Plan, measure: &str) -> Vec<Series> {
    let mut all: Vec<Series> = Vec::new();
    for (label, (cpu, error)) in
        plan.others.iter().filter(|o| o.measure == measure).flat_map(|o| &o.points)
    {
        let point = (*cpu, error.abs());
        match all.iter_mut().find(|series| series.label == *label) {
            Some(series) => series.points.push(point),
            None => all.push(Series {
                label: label.clone(),
                points: vec![point],
                style: SeriesStyle::Markers,
            }),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn study_error_relative_or_absolute_at_zero_reference() {
        let target = |values: &[Option<f64>]| Target {
            measure: "lift".into(),
            values: values.to_vec(),
            of_runs: false,
        };
        let mixed = target(&[Some(2.0), None, Some(0.0), Some(-4.0)]);
        let errors = [0, 1, 2, 3].map(|run| mixed.error(run, 3.0));
        assert_eq!(errors, [Some(0.5), None, None, Some(-1.75)]);
        let nothing = target(&[Some(0.0), None]);
        assert_eq!(
            (nothing.is_relative(), nothing.error(0, 3.0), nothing.error(1, 3.0)),
            (false, Some(3.0), None)
        );
    }
}
