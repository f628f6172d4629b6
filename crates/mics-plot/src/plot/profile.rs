//! Means over layers of cells: what `profile.csv` has, over the axis.

use super::rows::table;
use crate::figure::{Axes, Chart, Series, SeriesStyle};
use mics_run::Result;
use mics_run::config::Case;
use mics_run::words::rounded;
use mics_run::{folder, not_a_run};
use std::path::Path;

/// The columns of `profile.csv`.
struct Columns {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Columns {
    /// Reads the columns of a run that has any; an inner `None` where mics did not write the file.
    fn read(run: &Path) -> Option<Option<Columns>> {
        let mut reader = table(&run.join(folder::PROFILE))?;
        let Ok(head) = reader.headers() else { return Some(None) };
        let names = head.iter().map(str::to_owned).collect();
        let numbers = |record: csv::Result<csv::StringRecord>| {
            record.ok()?.iter().map(|number| number.parse().ok()).collect::<Option<Vec<f64>>>()
        };
        Some(
            reader
                .records()
                .map(numbers)
                .collect::<Option<_>>()
                .map(|rows| Columns { names, rows }),
        )
    }

    fn column(&self, name: &str) -> Option<Vec<f64>> {
        let at = self.names.iter().position(|n| n == name)?;
        Some(self.rows.iter().map(|row| row[at]).collect())
    }
}

/// The mean velocity of fluid and bodies along each axis that matters, and beside it the solid
/// fraction; `None` where a run has no profile.
///
/// # Errors
/// When the file is not one of a run.
pub fn profile(run: &Path, case: &Case) -> Result<Option<Chart>> {
    let strange = || not_a_run(run, "profile.csv is not one that mics wrote");
    let Some(read) = Columns::read(run) else { return Ok(None) };
    let columns = read.ok_or_else(strange)?;
    let column = |name: &str| columns.column(name);
    let axis = columns.names.first().cloned().ok_or_else(strange)?;
    let heights = column(&axis).ok_or_else(strange)?;
    let fractions =
        column("solid_fraction").filter(|all| all.iter().any(|fraction| *fraction > 0.0));
    let largest = |name: &str| {
        column(name).map_or(0.0, |v| v.iter().fold(0.0f64, |most, v| most.max(v.abs())))
    };
    let along =
        ["u", "v", "w"].into_iter().max_by(|a, b| largest(a).total_cmp(&largest(b))).unwrap_or("u");
    let direction = match along {
        "u" => "x",
        "v" => "y",
        _ => "z",
    };
    let line = |values: Vec<f64>, label: &str, shown: &dyn Fn(usize) -> bool| {
        let points =
            (0..values.len()).filter(|k| shown(*k)).map(|k| (values[k], heights[k])).collect();
        Series { label: label.into(), points, style: SeriesStyle::Line }
    };
    // Where there are no particles they have no velocity.
    let filled = |k: usize| fractions.as_ref().is_some_and(|fraction| fraction[k] > 0.0);
    let mut speeds: Vec<Series> =
        column(along).map(|u| line(u, "fluid", &|_| true)).into_iter().collect();
    let solid = column(&format!("solid_{along}")).map(|u| line(u, "particles", &filled));
    speeds.extend(solid.filter(|one| !one.points.is_empty()));
    if let [fluid] = &mut speeds[..] {
        fluid.label.clear();
    }
    let from = case.statistics.as_ref().map_or(0.0, |statistics| statistics.from);
    let y_label = format!("{axis} (m)");
    let velocity = Axes {
        x_label: match fractions {
            Some(_) => format!("mean velocity along {direction} (m/s)"),
            None => format!("mean velocity of the fluid along {direction} (m/s)"),
        },
        y_label: y_label.clone(),
        title: format!("profile over {axis}"),
        note: format!(
            "means over each layer of cells and over the time from {} s on",
            rounded(from)
        ),
        ..Axes::default()
    };
    let mut panels = vec![(velocity, speeds)];
    if let Some(fractions) = &fractions {
        let axes = Axes { x_label: "solid fraction".into(), y_label, ..Axes::default() };
        panels.push((axes, vec![line(fractions.clone(), "", &|_| true)]));
    }
    Ok(Some(Chart { panels, beside: true }).filter(Chart::shows))
}
