//! Cd(Re) (Fig. 4) and St(Re) (Fig. 5) of bodies, one point for each run, beside the references of
//! their cases.

use super::Run;
use super::paths::brief;
use crate::figure::{Axes, Chart, Series, SeriesStyle};
use mics_run::Result;
use mics_run::config::{Case, MeasureKind, Reference, Side};
use mics_run::not_a_run;
use mics_run::progress::Record;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// (Re, value) of every run that measures it, by the name of the measure.
type Measured = BTreeMap<String, Vec<(f64, f64)>>;

/// Drag coefficients beside the references of their cases, and beside (30) or the curve of spheres
/// where each run is of one body in a stream without walls; none where no run has one.
///
/// # Errors
/// When a folder has no measures.
pub fn drag(runs: &[Run]) -> Result<Option<Chart>> {
    let spheres = runs.iter().all(|run| run.case.dimension() == 3);
    let alike = spheres || runs.iter().all(|run| run.case.dimension() == 2);
    let isolated = alike && runs.iter().all(|run| is_isolated(&run.case));
    let formula = isolated.then(|| match spheres {
        // Schiller and Naumann 1933.
        true => formula("unbounded stream: 24/Re (1 + 0.15 Re^0.687)", |re| {
            24.0 / re * (1.0 + 0.15 * re.powf(0.687))
        }),
        // White 1991, for cylinders.
        false => formula("unbounded stream, eq. (30): 1 + 10 Re^(-2/3)", |re| {
            1.0 + 10.0 * re.powf(-2.0 / 3.0)
        }),
    });
    chart(runs, MeasureKind::DragCoefficient, "Cd", "drag", formula)
}

/// Strouhal numbers beside the references of their cases; none where no run has one.
///
/// # Errors
/// When a folder has no measures.
pub fn strouhal(runs: &[Run]) -> Result<Option<Chart>> {
    chart(runs, MeasureKind::Strouhal, "St", "Strouhal number", None)
}

/// A formula of the Reynolds number, from 5 to 500.
fn formula(label: &str, of: fn(f64) -> f64) -> Series {
    let reynolds = (0..=40).map(|k| 10f64.powf(0.7 + 0.05 * f64::from(k)));
    let points = reynolds.map(|re| (re, of(re))).collect();
    Series { label: label.into(), points, style: SeriesStyle::Dashed }
}

/// The measures of a kind over Re beside the references of their cases and a formula.
fn chart(
    runs: &[Run],
    kind: MeasureKind,
    symbol: &str,
    title: &str,
    formula: Option<Series>,
) -> Result<Option<Chart>> {
    let (values, references) = measured(runs, kind)?;
    if values.is_empty() {
        return Ok(None);
    }
    let log = formula.is_some();
    let marker = |(label, points)| Series { label, points, style: SeriesStyle::Markers };
    let series = formula.into_iter().chain(references).chain(values.into_iter().map(marker));
    let axes = Axes {
        x_label: "Re".into(),
        y_label: symbol.into(),
        log_x: log,
        log_y: log,
        title: title.into(),
        ..Axes::default()
    };
    Ok(Some(Chart { panels: vec![(axes, series.collect())], beside: false }))
}

/// Whether a case is one round body in a uniform stream without walls.
fn is_isolated(case: &Case) -> bool {
    let uniform = case.sides().any(|(_, side)| matches!(side, Side::Inflow(_)));
    let open =
        |side: &Side| matches!(side, Side::Inflow(_) | Side::Outflow | Side::Periodic | Side::Slip);
    let round = case.particle.iter().all(|p| p.shape.is_round());
    case.particle.len() == 1 && round && uniform && case.sides().all(|(_, side)| open(side))
}

/// The measures of a kind over the Reynolds numbers of the runs, and the references of their cases.
fn measured(runs: &[Run], kind: MeasureKind) -> Result<(Measured, Vec<Series>)> {
    let mut all = Measured::new();
    let mut references = Vec::<Series>::new();
    for Run { folder, case, .. } in runs {
        let mut wanted = case.measure.iter().filter(|m| m.kind == kind).peekable();
        if wanted.peek().is_none() {
            continue;
        }
        let values = values(folder)?;
        for m in wanted {
            let Some(value) = values[&m.name].as_f64() else { continue };
            let (Some(speed), Some(p)) = (m.speed, case.particle.get(m.particle.id())) else {
                continue;
            };
            let re = case.fluid.density * speed * p.shape.diameter() / case.fluid.viscosity;
            all.entry(m.name.clone()).or_default().push((re, value));
            let Some(reference) = m.reference else { continue };
            let label = m
                .source
                .as_ref()
                .map_or_else(|| format!("reference of {}", m.name), |text| brief(text));
            let (points, style) = match reference {
                Reference::Value(value) => (vec![(re, value)], SeriesStyle::Markers),
                Reference::Band([low, high]) => (vec![(re, low), (re, high)], SeriesStyle::Joined),
            };
            match references.iter_mut().find(|other| other.label == label) {
                Some(known) => {
                    known.points.push((f64::NAN, f64::NAN));
                    known.points.extend(points);
                }
                None => references.push(Series { label, points, style }),
            }
        }
    }
    all.values_mut().for_each(|points| points.sort_by(|a, b| a.0.total_cmp(&b.0)));
    Ok((all, references))
}

/// The measures of a run: those at its end, or, where it has not ended, those so far.
fn values(folder: &Path) -> Result<serde_json::Value> {
    let refuse = |e: &dyn std::fmt::Display| not_a_run(folder, &format!("summary.json: {e}"));
    match fs::read_to_string(folder.join("summary.json")) {
        Ok(text) => {
            let mut summary: serde_json::Value =
                serde_json::from_str(&text).map_err(|e| refuse(&e))?;
            Ok(summary["measures"].take())
        }
        Err(e) => {
            Record::newest(folder).map(|newest| newest.measures.into()).ok_or_else(|| refuse(&e))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drag_formula_is_of_one_body_without_walls() {
        let case = |north: &str, more: &str| {
            mics_run::config::written(&format!(
                "name = \"t\"\ntime.end = 9.0\n\
                domain = {{ size = [4.0, 1.6], cells = [160, 64] }}\n\
                fluid = {{ density = 2.0, viscosity = 0.1 }}\n\
                boundary = {{ west = {{ inflow = [1.0, 0.0] }}, east = \"outflow\", \
                south = {north}, north = {north} }}\n\
                [[particle]]\nshape = {{ disc = {{ diameter = 0.2 }} }}\n\
                position = [0.8, 0.8]\nmotion = \"fixed\"\n{more}"
            ))
            .unwrap()
        };
        let second = "[[particle]]\nshape = { disc = { diameter = 0.2 } }\nposition = [2.0, 0.8]\n\
            motion = \"fixed\"\n";
        assert!(is_isolated(&case("\"periodic\"", "")) && is_isolated(&case("\"slip\"", "")));
        assert!(!is_isolated(&case("\"wall\"", "")) && !is_isolated(&case("\"slip\"", second)));
    }
}
