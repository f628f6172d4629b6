//! Cd(Re) (Fig. 4) and St(Re) (Fig. 5) of cylinders, one point for each run.

use super::Run;
use crate::Result;
use crate::config::MeasureKind;
use crate::output::figure::{self, Axes, Series, SeriesStyle};
use crate::output::not_a_run;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The body-fitted reference of section 3, as it stands beside the case.
const REFERENCE: &str = include_str!("../../../cases/cylinder-wake/cylinder_s3.csv");

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
    // White 1991, for cylinders.
    let formula =
        (0..=40).map(|k| 10f64.powf(0.7 + 0.05 * f64::from(k))).map(|re| (re, 1.0 + 10.0 * re.powf(-2.0 / 3.0)));
    let mut series = vec![
        Series { label: "eq. (30): 1 + 10 Re^(-2/3)".into(), points: formula.collect(), style: SeriesStyle::Dashed },
        Series { label: "body-fitted reference".into(), points: cylinder_reference("cd"), style: SeriesStyle::Joined },
    ];
    let markers = |(label, points)| Series { label, points, style: SeriesStyle::Markers };
    series.extend(drag.into_iter().map(markers));
    let axes = Axes {
        x_label: "Re".into(),
        y_label: "Cd".into(),
        log_x: true,
        log_y: true,
        title: "Drag of a cylinder".into(),
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
    let series = [
        Series { label: "body-fitted reference".into(), points: cylinder_reference("st"), style: SeriesStyle::Joined },
        Series { label: "mics".into(), points, style: SeriesStyle::Markers },
    ];
    let axes = Axes {
        x_label: "Re".into(),
        y_label: "St".into(),
        title: "Strouhal number of a cylinder".into(),
        ..Axes::default()
    };
    figure::curves(&axes, &series, &folder.join("strouhal_over_reynolds")).map(Some)
}

/// What the runs measured of a kind, over their Reynolds numbers.
fn measured(runs: &[Run], kind: MeasureKind) -> Result<Measured> {
    let mut all = Measured::new();
    for Run { folder, case } in runs {
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
