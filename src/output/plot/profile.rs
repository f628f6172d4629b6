//! Means over layers of cells: what `profile.csv` has, over the axis.

use crate::Result;
use crate::output::figure::{Axes, Series, SeriesStyle};
use crate::output::{not_a_run, statistics};
use std::path::Path;

/// The mean velocity of the fluid and of the bodies in parts of the fluid's largest, and the solid fraction; `None` where a run has no
/// profile.
///
/// # Errors
/// When the file cannot be read.
pub fn profile(run: &Path) -> Result<Option<(Axes, Vec<Series>)>> {
    let Ok(mut reader) = csv::Reader::from_path(run.join(statistics::PROFILE)) else { return Ok(None) };
    let strange = || not_a_run(run, "profile.csv is not one that mics wrote");
    let names: Vec<String> = reader.headers().map_err(|_| strange())?.iter().map(str::to_owned).collect();
    let rows: Vec<Vec<f64>> = reader
        .records()
        .map(|record| record.ok()?.iter().map(|number| number.parse().ok()).collect::<Option<Vec<f64>>>())
        .collect::<Option<_>>()
        .ok_or_else(strange)?;
    let column = |name: &str| {
        let at = names.iter().position(|n| n == name)?;
        Some(rows.iter().map(|row| row[at]).collect::<Vec<f64>>())
    };
    let axis = names.first().cloned().ok_or_else(strange)?;
    let heights = column(&axis).ok_or_else(strange)?;
    let largest = |name: &str| column(name).map_or(0.0, |v| v.iter().fold(0.0f64, |most, v| most.max(v.abs())));
    let along = ["u", "v", "w"].into_iter().max_by(|a, b| largest(a).total_cmp(&largest(b))).unwrap_or("u");
    let scale = largest(along);
    let mut series = Vec::new();
    for (name, label, scale, style) in [
        (along.to_owned(), format!("velocity {along} of the fluid / {scale:.4} m/s"), scale, SeriesStyle::Line),
        (format!("solid_{along}"), "the same of the particles".into(), scale, SeriesStyle::Markers),
        ("solid_fraction".into(), "solid fraction".into(), 1.0, SeriesStyle::Dashed),
    ] {
        // Where there are no particles they have no velocity.
        let fractions = column("solid_fraction").filter(|_| style == SeriesStyle::Markers);
        let filled = |k: usize| fractions.as_ref().is_none_or(|fraction| fraction[k] > 0.0);
        if let Some(values) = column(&name).filter(|_| scale > 0.0) {
            let points = (0..values.len()).filter(|k| filled(*k)).map(|k| (values[k] / scale, heights[k]));
            series.push(Series { label, points: points.collect(), style });
        }
    }
    let axes = Axes { x_label: "mean over layers".into(), y_label: format!("{axis} (m)"), ..Axes::default() };
    Ok((!series.is_empty()).then_some((axes, series)))
}
