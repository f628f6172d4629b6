//! The figures of a study: each measure over what is varied, error over CPU seconds for each
//! reference, and cost of a cell and step over cells.

use crate::figure::{Axes, Series, SeriesStyle, curves};
use mics_run::Result;
use std::path::{Path, PathBuf};

/// The greatest of what is varied over the least from which on its axis is logarithmic.
const WIDE: f64 = 20.0;
/// Curves in a figure at most, where the study file does not say which.
const CURVES: usize = 12;

/// What a study varies, measures and compares with.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// The names of the columns that tell runs apart.
    pub names: &'a [String],
    /// The names of the measures.
    pub measures: &'a [String],
    /// What measures are compared with.
    pub references: &'a [Target],
    /// What others paid for their errors.
    pub others: &'a [Others],
}

impl Plan<'_> {
    fn target(&self, measure: &str) -> Option<&Target> {
        self.references.iter().find(|target| target.measure == measure)
    }
}

/// Points of others in the figure of a measure.
#[derive(Clone, Debug)]
pub struct Others {
    /// The measure's name.
    pub measure: String,
    /// Of whom each is, its CPU time (s) and its error (% where errors are parts of a reference).
    pub points: Vec<(String, (f64, f64))>,
}

/// What a measure is compared with.
#[derive(Clone, Debug)]
pub struct Target {
    /// The measure's name.
    pub measure: String,
    /// For each run, its reference, where there is one.
    pub values: Vec<Option<f64>>,
}

impl Target {
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
    /// Its median, where a repeat gave one.
    pub value: Option<f64>,
    /// `value/reference - 1` (the difference where all references are 0), where there is a
    /// reference.
    pub error: Option<f64>,
}

/// A run, of several repeats their medians.
#[derive(Clone, Debug)]
pub struct Row {
    /// What its columns say.
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
}

/// Draws what there is to draw, each as `STEM.png` and `STEM.svg` in a folder; `wanted` names the
/// columns that tell one curve from another. Runs that differ in the columns `over` alone are one
/// point of the errors: the worst of them and, in a figure of its own, their mean.
///
/// # Errors
/// When a figure cannot be written.
pub fn draw(
    study: &str,
    plan: &Plan,
    rows: &[Row],
    wanted: Option<&[String]>,
    over: &[String],
    folder: &Path,
) -> Result<Vec<PathBuf>> {
    let groups = Groups::new(plan, rows, wanted, over);
    let title = match &groups.along[..] {
        [along] => format!("{study}, {along} along a curve"),
        _ => study.to_owned(),
    };
    let figures = values(study, plan, rows, &groups)
        .into_iter()
        .chain(errors(plan, rows, &groups, !over.is_empty()))
        .chain(cost(plan, rows, &groups));
    let mut written = Vec::new();
    for Figure { axes, series, stem } in figures.filter(|figure| !figure.series.is_empty()) {
        let title = if axes.title.is_empty() { title.clone() } else { axes.title.clone() };
        written.extend(curves(&Axes { title, ..axes }, &series, &folder.join(stem))?);
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
            let (label, style) = ("reference".into(), SeriesStyle::Dashed);
            series.push(Series { label, points: exact, style });
        }
        let places = || series.iter().flat_map(|one| &one.points).map(|point| point.0);
        let (least, most) = (places().fold(f64::INFINITY, f64::min), places().fold(0.0, f64::max));
        let axes = Axes {
            x_label: along.to_owned(),
            y_label: name.clone(),
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
        let (measure, percent) = (&target.measure, if target.is_relative() { 100.0 } else { 1.0 });
        let unit = if target.is_relative() { " (%)" } else { "" };
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

/// Where runs that belong together lie in a figure, if they do.
type Point<'a> = &'a dyn Fn(&[&Row]) -> Option<(f64, f64)>;

/// What errors of several runs come to.
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

/// Which rows are a curve, and what it is called.
struct Groups {
    /// Rows of each point of each curve, under its label.
    curves: Vec<(String, Vec<Vec<usize>>)>,
    /// What changes from point to point of a curve.
    along: Vec<String>,
}

impl Groups {
    fn new(plan: &Plan, rows: &[Row], wanted: Option<&[String]>, over: &[String]) -> Groups {
        let column = |name: &str, row: &Row| match plan.names.iter().position(|other| other == name)
        {
            Some(at) => row.labels[at].clone(),
            None => row.ranks.to_string(),
        };
        let count = |names: &[String]| {
            let mut keys: Vec<Vec<String>> = rows
                .iter()
                .map(|row| names.iter().map(|name| column(name, row)).collect())
                .collect();
            keys.sort();
            keys.dedup();
            keys.len()
        };
        let mut all: Vec<String> = plan.names.iter().cloned().chain(["ranks".to_owned()]).collect();
        all.retain(|name| count(std::slice::from_ref(name)) > 1 && !over.contains(name));
        let names: Vec<String> = match wanted {
            Some(wanted) => wanted.to_vec(),
            None => {
                let mut rest = all.get(1..).unwrap_or_default();
                while count(rest) > CURVES {
                    rest = &rest[1..];
                }
                rest.to_vec()
            }
        };
        let mut curves: Vec<(String, Vec<Vec<usize>>)> = Vec::new();
        let along: Vec<String> = all.iter().filter(|name| !names.contains(name)).cloned().collect();
        let same = |a: usize, b: usize| {
            along.iter().all(|name| column(name, &rows[a]) == column(name, &rows[b]))
        };
        for (index, row) in rows.iter().enumerate() {
            let part = |name: &String| {
                let label = column(name, row);
                if label.parse::<f64>().is_ok() { format!("{name} {label}") } else { label }
            };
            let parts: Vec<String> =
                names.iter().map(part).filter(|part| !part.is_empty()).collect();
            let label = parts.join(", ");
            match curves.iter_mut().find(|(other, _)| *other == label) {
                Some((_, points)) => {
                    match points.iter_mut().find(|point| !over.is_empty() && same(point[0], index))
                    {
                        Some(point) => point.push(index),
                        None => points.push(vec![index]),
                    }
                }
                None => curves.push((label, vec![vec![index]])),
            }
        }
        Groups { curves, along }
    }

    /// The first thing that changes along a curve and is a number in every row that says it.
    fn numeric(&self, plan: &Plan, rows: &[Row]) -> Option<&str> {
        let varies = |name: &&String| {
            let mut values: Vec<f64> =
                rows.iter().filter_map(|row| self.number(plan, row, name)).collect();
            let text = |row: &Row| {
                plan.names
                    .iter()
                    .position(|other| other == *name)
                    .is_some_and(|at| row.labels[at].is_empty())
            };
            let all = values.len() + rows.iter().filter(|row| text(row)).count() == rows.len();
            values.sort_by(f64::total_cmp);
            values.dedup();
            all && values.len() > 1
        };
        self.along.iter().find(varies).map(String::as_str)
    }

    /// The number in a column of a row, where its label is one.
    fn number(&self, plan: &Plan, row: &Row, name: &str) -> Option<f64> {
        let at = plan.names.iter().position(|other| other == name)?;
        row.labels[at].parse().ok()
    }

    /// The curves, without those that have no point.
    fn series(&self, rows: &[Row], point: Point) -> Vec<Series> {
        let of = |(label, points): &(String, Vec<Vec<usize>>)| Series {
            label: label.clone(),
            points: points
                .iter()
                .filter_map(|same| {
                    point(&same.iter().map(|index| &rows[*index]).collect::<Vec<_>>())
                })
                .collect(),
            // Points of a curve follow each other where only one thing changes along it.
            style: if self.along.len() == 1 { SeriesStyle::Joined } else { SeriesStyle::Markers },
        };
        self.curves.iter().map(of).filter(|series| !series.points.is_empty()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_differing_in_position_share_a_curve_point() {
        let names = ["N", "scheme", "place"].map(str::to_owned).to_vec();
        let plan = Plan { names: &names, measures: &[], references: &[], others: &[] };
        let row = |n: f64, scheme: &str, place: &str, cpu: f64| Row {
            labels: vec![n.to_string(), scheme.to_owned(), place.to_owned()],
            ranks: 1,
            measured: Vec::new(),
            cpu: Some(cpu),
            cells: Some(n),
            per_cell_step: None,
        };
        let mut rows = Vec::new();
        for (k, scheme) in ["rk2", "rk3"].into_iter().enumerate() {
            for n in [8.0, 16.0] {
                let cpu = n * (1.0 + k as f64);
                rows.extend([row(n, scheme, "a", cpu), row(n, scheme, "b", 3.0 * cpu)]);
            }
        }
        let point = |same: &[&Row]| {
            Some((mean(&same.iter().filter_map(|r| r.cpu).collect::<Vec<_>>()), same.len() as f64))
        };
        let series = |over: &[String]| {
            let groups = Groups::new(&plan, &rows, Some(&["scheme".to_owned()]), over);
            let points = groups.series(&rows, &point);
            (
                points.into_iter().map(|s| (s.label, s.points, s.style)).collect::<Vec<_>>(),
                groups.along,
            )
        };
        let joined = |label: &str, points: [(f64, f64); 2]| {
            (label.to_owned(), points.to_vec(), SeriesStyle::Joined)
        };
        let (found, along) = series(&["place".to_owned()]);
        assert_eq!(
            found,
            [joined("rk2", [(16.0, 2.0), (32.0, 2.0)]), joined("rk3", [(32.0, 2.0), (64.0, 2.0)])]
        );
        assert_eq!(along, ["N"]);
        // Where nobody says that they belong together, each is a point.
        let (found, along) = series(&[]);
        assert_eq!((found[0].1.len(), found[0].2, along.len()), (4, SeriesStyle::Markers, 2));
    }
}
