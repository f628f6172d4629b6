//! Cd(Re) (Fig. 4) and St(Re) (Fig. 5) of cylinders or of spheres, one point for each run, beside
//! the references of their cases.

use super::Run;
use super::paths::brief;
use crate::figure::{self, Axes, Series, SeriesStyle};
use mics_run::config::{Case, Inflow, MeasureKind, Motion, Reference, Side};
use mics_run::not_a_run;
use mics_run::progress::Record;
use mics_run::published::cylinder_reference;
use mics_run::{Error, Result};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The body-fitted reference of section 3, for its box only: other boxes have other values.
const REFERENCE_LABEL: &str = "body-fitted, box of cases/cylinder-wake";
/// Length and width of its box, and the distance of the cylinder from the inflow, in diameters.
const REFERENCE_BOX: [f64; 3] = [20.0, 8.0, 4.0];

/// (Re, value) of every run that measures it, by the name of the measure.
type Measured = BTreeMap<String, Vec<(f64, f64)>>;

/// Draws drag coefficients beside the references of their cases, and (30) or the curve of spheres
/// where each run is of one body in a stream without walls; none where no run has one.
///
/// # Errors
/// When a folder has no measures, or a file cannot be written.
pub fn drag(runs: &[Run], folder: &Path) -> Result<Option<[PathBuf; 2]>> {
    let (drag, references) = measured(runs, MeasureKind::DragCoefficient)?;
    if drag.is_empty() {
        return Ok(None);
    }
    let dashed = |label: &str, formula: fn(f64) -> f64| {
        let points = (0..=40)
            .map(|k| 10f64.powf(0.7 + 0.05 * f64::from(k)))
            .map(|re| (re, formula(re)))
            .collect();
        Series { label: label.into(), points, style: SeriesStyle::Dashed }
    };
    let spheres = all_of_spheres(runs)?;
    let mut series = Vec::new();
    if runs.iter().all(|run| is_isolated(&run.case)) {
        series.push(match spheres {
            // Schiller and Naumann 1933.
            true => dashed("unbounded stream: 24/Re (1 + 0.15 Re^0.687)", |re| {
                24.0 / re * (1.0 + 0.15 * re.powf(0.687))
            }),
            // White 1991, for cylinders.
            false => dashed("unbounded stream, eq. (30): 1 + 10 Re^(-2/3)", |re| {
                1.0 + 10.0 * re.powf(-2.0 / 3.0)
            }),
        });
    }
    series.extend(compared(runs, "cd", references));
    let curve = series.iter().any(|reference| reference.points.len() > 2);
    series.extend(markers(drag));
    let axes = Axes {
        x_label: "Re".into(),
        y_label: "Cd".into(),
        log_x: curve,
        log_y: curve,
        title: format!("Drag of a {}", if spheres { "sphere" } else { "cylinder" }),
        ..Axes::default()
    };
    figure::curves(&axes, &series, &folder.join("drag_over_reynolds")).map(Some)
}

/// Draws Strouhal numbers beside the references of their cases; none where no run has one.
///
/// # Errors
/// When a folder has no measures, or a file cannot be written.
pub fn strouhal(runs: &[Run], folder: &Path) -> Result<Option<[PathBuf; 2]>> {
    let (values, references) = measured(runs, MeasureKind::Strouhal)?;
    if values.is_empty() {
        return Ok(None);
    }
    let spheres = all_of_spheres(runs)?;
    let mut series = compared(runs, "st", references);
    series.extend(markers(values));
    let axes = Axes {
        x_label: "Re".into(),
        y_label: "St".into(),
        title: format!("Strouhal number of a {}", if spheres { "sphere" } else { "cylinder" }),
        ..Axes::default()
    };
    figure::curves(&axes, &series, &folder.join("strouhal_over_reynolds")).map(Some)
}

fn markers(measured: Measured) -> impl Iterator<Item = Series> {
    measured.into_iter().map(|(label, points)| Series {
        label,
        points,
        style: SeriesStyle::Markers,
    })
}

/// The references: the curve of section 3 where all runs are in its box, or else those of the
/// cases.
fn compared(runs: &[Run], column: &str, references: Vec<Series>) -> Vec<Series> {
    if runs.iter().all(|run| in_the_box_of_section_3(&run.case)) {
        let points = cylinder_reference(column);
        return vec![Series { label: REFERENCE_LABEL.into(), points, style: SeriesStyle::Joined }];
    }
    references
}

/// Whether a case is one round body in a uniform stream without walls.
fn is_isolated(case: &Case) -> bool {
    let uniform = case.sides().any(|(_, side)| matches!(side, Side::Inflow(_)));
    let open =
        |side: &Side| matches!(side, Side::Inflow(_) | Side::Outflow | Side::Periodic | Side::Slip);
    let round = case.particle.iter().all(|p| p.shape.is_round());
    case.particle.len() == 1 && round && uniform && case.sides().all(|(_, side)| open(side))
}

/// Whether a case is the one of `cylinder_s3.csv`, at any Reynolds number: one fixed disc in its
/// box, within a cell of its place.
fn in_the_box_of_section_3(case: &Case) -> bool {
    let [disc] = &case.particle[..] else { return false };
    let d = disc.shape.diameter();
    let near = |value: f64, wanted: f64, room: f64| (value / d - wanted).abs() <= room;
    let [length, width, from] = REFERENCE_BOX;
    let sides: Vec<&Side> = case.sides().map(|(_, side)| side).collect();
    case.dimension() == 2
        && disc.shape.is_round()
        && disc.motion == Motion::Fixed
        && near(case.domain.size[0], length, 1e-6 * length)
        && near(case.domain.size[1], width, 1e-6 * width)
        && near(disc.position[0], from, case.spacings()[0] / d)
        && matches!(
            sides[..],
            [Side::Inflow(Inflow::Steady(v)), Side::Outflow, Side::Periodic, Side::Periodic]
                if v[1] == 0.0
        )
}

/// Whether the runs are of spheres, not of cylinders.
///
/// # Errors
/// When some are of one and some of the other, which no reference is beside.
fn all_of_spheres(runs: &[Run]) -> Result<bool> {
    let count = runs.iter().filter(|run| run.case.dimension() == 3).count();
    if count > 0 && count < runs.len() {
        return Err(Error::Usage(
            "some of the runs are in 2D and some in 3D: draw those of cylinders and of spheres \
            apart"
                .into(),
        ));
    }
    Ok(count > 0)
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

    fn case(north: &str, place: f64, more: &str) -> Case {
        mics_run::config::written(&format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [4.0, 1.6], cells = [160, 64] }}\n\
            fluid = {{ density = 2.0, viscosity = 0.1 }}\n\
            boundary = {{ west = {{ inflow = [1.0, 0.0] }}, east = \"outflow\", south = {north}, \
            north = {north} }}\n\
            [[particle]]\nshape = {{ disc = {{ diameter = 0.2 }} }}\nposition = [{place}, 0.8]\n\
            motion = \"fixed\"\n{more}"
        ))
        .unwrap()
    }

    #[test]
    fn drag_figure_reference_of_own_case_only() {
        let second = "[[particle]]\nshape = { disc = { diameter = 0.2 } }\nposition = [2.0, 0.8]\n\
            motion = \"fixed\"\n";
        let periodic = "\"periodic\"";
        for (case, own, free) in [
            (case(periodic, 0.8, ""), true, true),
            (case(periodic, 0.81, ""), true, true),
            (case(periodic, 1.2, ""), false, true),
            (case("\"slip\"", 0.8, ""), false, true),
            (case("\"wall\"", 0.8, ""), false, false),
            (case(periodic, 0.8, second), false, false),
        ] {
            assert_eq!(
                (in_the_box_of_section_3(&case), is_isolated(&case)),
                (own, free),
                "{:?}",
                case.boundary
            );
        }
    }
}
