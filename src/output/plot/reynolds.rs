//! Cd(Re) (Fig. 4) and St(Re) (Fig. 5) of cylinders or of spheres, one point for each run.

use super::Run;
use crate::config::MeasureKind;
use crate::output::figure::{self, Axes, Series, SeriesStyle};
use crate::output::not_a_run;
use crate::{Error, Result};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The body-fitted reference of section 3, as it stands beside the case.
const REFERENCE: &str = include_str!("../../../cases/cylinder-wake/cylinder_s3.csv");

/// What its box is: other boxes have other values.
const REFERENCE_LABEL: &str = "body-fitted, box of cases/cylinder-wake";

/// (Re, value) of every run that measures it, by the name of the measure.
type Measured = BTreeMap<String, Vec<(f64, f64)>>;

/// Draws drag coefficients beside (30) and the reference; none where no run has one.
///
/// # Errors
/// When a folder has no summary, or a file cannot be written.
pub fn drag(runs: &[Run], folder: &Path) -> Result<Option<[PathBuf; 2]>> {
    let drag = measured(runs, MeasureKind::DragCoefficient)?;
    if drag.is_empty() {
        return Ok(None);
    }
    let dashed = |label: &str, formula: fn(f64) -> f64| {
        let points = (0..=40).map(|k| 10f64.powf(0.7 + 0.05 * f64::from(k))).map(|re| (re, formula(re))).collect();
        Series { label: label.into(), points, style: SeriesStyle::Dashed }
    };
    let spheres = all_of_spheres(runs)?;
    let mut series = if spheres {
        // Schiller and Naumann 1933.
        vec![dashed("24/Re (1 + 0.15 Re^0.687)", |re| 24.0 / re * (1.0 + 0.15 * re.powf(0.687)))]
    } else {
        // White 1991, for cylinders.
        let points = cylinder_reference("cd");
        let reference = Series { label: REFERENCE_LABEL.into(), points, style: SeriesStyle::Joined };
        vec![dashed("eq. (30): 1 + 10 Re^(-2/3)", |re| 1.0 + 10.0 * re.powf(-2.0 / 3.0)), reference]
    };
    let markers = |(label, points)| Series { label, points, style: SeriesStyle::Markers };
    series.extend(drag.into_iter().map(markers));
    let axes = Axes {
        x_label: "Re".into(),
        y_label: "Cd".into(),
        log_x: true,
        log_y: true,
        title: format!("Drag of a {}", if spheres { "sphere" } else { "cylinder" }),
        ..Axes::default()
    };
    figure::curves(&axes, &series, &folder.join("drag_over_reynolds")).map(Some)
}

/// Draws Strouhal numbers beside the reference; none where no run has one.
///
/// # Errors
/// When a folder has no summary, or a file cannot be written.
pub fn strouhal(runs: &[Run], folder: &Path) -> Result<Option<[PathBuf; 2]>> {
    let points: Vec<_> = measured(runs, MeasureKind::Strouhal)?.into_values().flatten().collect();
    if points.is_empty() {
        return Ok(None);
    }
    let spheres = all_of_spheres(runs)?;
    let mut series = vec![Series { label: "mics".into(), points, style: SeriesStyle::Markers }];
    if !spheres {
        let points = cylinder_reference("st");
        let label = REFERENCE_LABEL.into();
        series.insert(0, Series { label, points, style: SeriesStyle::Joined });
    }
    let axes = Axes {
        x_label: "Re".into(),
        y_label: "St".into(),
        title: format!("Strouhal number of a {}", if spheres { "sphere" } else { "cylinder" }),
        ..Axes::default()
    };
    figure::curves(&axes, &series, &folder.join("strouhal_over_reynolds")).map(Some)
}

/// Whether the runs are of spheres, not of cylinders.
///
/// # Errors
/// When some are of one and some of the other, which no reference is beside.
fn all_of_spheres(runs: &[Run]) -> Result<bool> {
    let count = runs.iter().filter(|run| run.case.dimension() == 3).count();
    if count > 0 && count < runs.len() {
        return Err(Error::Usage(
            "some of the runs are in 2D and some in 3D: draw those of cylinders and of spheres apart".into(),
        ));
    }
    Ok(count > 0)
}

/// What the runs measured of a kind, over their Reynolds numbers.
fn measured(runs: &[Run], kind: MeasureKind) -> Result<Measured> {
    let mut all = Measured::new();
    for Run { folder, case, .. } in runs {
        let path = folder.join("summary.json");
        let text = fs::read_to_string(&path).map_err(|e| not_a_run(folder, &format!("summary.json: {e}")))?;
        let summary: serde_json::Value =
            serde_json::from_str(&text).map_err(|e| not_a_run(folder, &format!("summary.json: {e}")))?;
        for m in case.measure.iter().filter(|m| m.kind == kind) {
            let Some(value) = summary["measures"][&m.name].as_f64() else { continue };
            let (Some(speed), Some(p)) = (m.speed, case.particle.get(m.particle)) else {
                continue;
            };
            let re = case.fluid.density * speed * p.shape.diameter() / case.fluid.viscosity;
            all.entry(m.name.clone()).or_default().push((re, value));
        }
    }
    all.values_mut().for_each(|points| points.sort_by(|a, b| a.0.total_cmp(&b.0)));
    Ok(all)
}

/// (Re, value) of a column of section 3's reference (`cylinder_s3.csv`), where it has one.
pub fn cylinder_reference(column: &str) -> Vec<(f64, f64)> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(REFERENCE.as_bytes());
    let at = reader.headers().ok().and_then(|h| h.iter().position(|n| n == column));
    let point = |r: csv::StringRecord| Some((r.get(0)?.parse().ok()?, r.get(at?)?.parse().ok()?));
    reader.records().flatten().filter_map(point).collect()
}
