//! The figures of a study: error over CPU seconds for each reference, and cost of a cell and step over cells.

use super::plan::Plan;
use super::table::Row;
use crate::Result;
use crate::output::figure::{Axes, Series, SeriesStyle, curves};
use std::path::{Path, PathBuf};

/// Curves in a figure at most, where the study file does not say which.
const CURVES: usize = 12;

/// Draws what there is to draw, each as `STEM.png` and `STEM.svg` in a folder; `wanted` names the columns that tell one
/// curve from another.
pub fn draw(name: &str, plan: &Plan, rows: &[Row], wanted: Option<&[String]>, folder: &Path) -> Result<Vec<PathBuf>> {
    let groups = Groups::new(plan, rows, wanted);
    let title = match &groups.along[..] {
        [along] => format!("{name}, {along} along a curve"),
        _ => name.to_owned(),
    };
    let mut written = Vec::new();
    let mut figure = |axes: Axes, stem: String, point: &dyn Fn(&Row) -> Option<(f64, f64)>| -> Result<()> {
        let series = groups.series(rows, point);
        if !series.is_empty() {
            written.extend(curves(
                &Axes { title: title.clone(), log_x: true, log_y: true, ..axes },
                &series,
                &folder.join(stem),
            )?);
        }
        Ok(())
    };
    for target in &plan.references {
        let (measure, relative) = (&target.measure, target.is_relative());
        let point = |row: &Row| {
            let error = row.measured.iter().find(|m| m.name == *measure)?.error?;
            // An error of nothing has no place on a logarithmic axis.
            Some((row.cpu?, if relative { 100.0 * error.abs() } else { error.abs() })).filter(|point| point.1 > 0.0)
        };
        let unit = if relative { " (%)" } else { "" };
        let axes =
            Axes { x_label: "CPU time (s)".into(), y_label: format!("error of {measure}{unit}"), ..Axes::default() };
        figure(axes, format!("work_precision_{measure}"), &point)?;
    }
    // Runs that failed have no cells.
    let mut cells = rows.iter().filter_map(|row| row.cells);
    let first = cells.next();
    let varied = cells.any(|cells| Some(cells) != first);
    // Where the grid is one, over the first thing that is varied, if that is a number.
    let number = |row: &Row| row.labels.first()?.parse::<f64>().ok().filter(|x| *x > 0.0);
    let over = match plan.names.first() {
        _ if varied => Some("cells"),
        Some(name) if rows.iter().all(|row| number(row).is_some()) => Some(name.as_str()),
        _ => None,
    };
    if let Some(over) = over {
        let axes = Axes { x_label: over.into(), y_label: "time per cell and step (us)".into(), ..Axes::default() };
        let x = |row: &Row| if varied { row.cells } else { number(row) };
        figure(axes, "cost".into(), &|row| x(row).zip(row.per_cell_step))?;
    }
    Ok(written)
}

/// Which rows are a curve, and what it is called.
struct Groups {
    /// Rows of each curve, under its label.
    curves: Vec<(String, Vec<usize>)>,
    /// What changes from point to point of a curve.
    along: Vec<String>,
}

impl Groups {
    fn new(plan: &Plan, rows: &[Row], wanted: Option<&[String]>) -> Groups {
        let column = |name: &str, row: &Row| match plan.names.iter().position(|other| other == name) {
            Some(at) => row.labels[at].clone(),
            None => row.ranks.to_string(),
        };
        let count = |names: &[String]| {
            let mut keys: Vec<Vec<String>> =
                rows.iter().map(|row| names.iter().map(|name| column(name, row)).collect()).collect();
            keys.sort();
            keys.dedup();
            keys.len()
        };
        let mut all: Vec<String> = plan.names.iter().cloned().chain(["ranks".to_owned()]).collect();
        all.retain(|name| count(std::slice::from_ref(name)) > 1);
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
        let mut curves: Vec<(String, Vec<usize>)> = Vec::new();
        for (index, row) in rows.iter().enumerate() {
            let part = |name: &String| {
                let label = column(name, row);
                if label.parse::<f64>().is_ok() { format!("{name} {label}") } else { label }
            };
            let parts: Vec<String> = names.iter().map(part).filter(|part| !part.is_empty()).collect();
            let label = parts.join(", ");
            match curves.iter_mut().find(|(other, _)| *other == label) {
                Some((_, rows)) => rows.push(index),
                None => curves.push((label, vec![index])),
            }
        }
        all.retain(|name| !names.contains(name));
        Groups { curves, along: all }
    }

    /// The curves, without those that have no point.
    fn series(&self, rows: &[Row], point: &dyn Fn(&Row) -> Option<(f64, f64)>) -> Vec<Series> {
        let of = |(label, indices): &(String, Vec<usize>)| Series {
            label: label.clone(),
            points: indices.iter().filter_map(|index| point(&rows[*index])).collect(),
            // Points of a curve follow each other where only one thing changes along it.
            style: if self.along.len() == 1 { SeriesStyle::Joined } else { SeriesStyle::Markers },
        };
        self.curves.iter().map(of).filter(|series| !series.points.is_empty()).collect()
    }
}
