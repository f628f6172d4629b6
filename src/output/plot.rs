//! `mics plot`: the figures of run folders, from what the folders hold.
//!
//! One run: vorticity with streamlines (Fig. 7), streamlines (Fig. 6), forces over time. All runs together: Cd(Re)
//! beside eq. (30) and the reference (Fig. 4), St(Re) (Fig. 5).

use super::figure::{self, Axes, Disc, Plane, Series, SeriesStyle};
use super::snapshot::Snapshot;
use crate::case::{Case, MeasureKind, Side};
use crate::{Error, Result};
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The body-fitted reference of section 3, as it stands beside the case.
const REFERENCE: &str = include_str!("../../cases/cylinder-wake/cylinder_s3.csv");

/// Draws every run's figures and, into `out` (default the first run's `figures/`), Cd(Re) and St(Re).
///
/// # Errors
/// When a folder does not hold a run, or a figure cannot be written.
pub fn draw(runs: &[PathBuf], out: Option<&Path>) -> Result<Vec<PathBuf>> {
    let mut written = Vec::new();
    for run in runs {
        written.extend(draw_run(run)?);
    }
    if let Some(first) = runs.first() {
        let folder = out.map_or_else(|| first.join("figures"), Path::to_owned);
        fs::create_dir_all(&folder).map_err(Error::io(&folder))?;
        written.extend(draw_over_reynolds(runs, &folder)?);
    }
    Ok(written)
}

/// Draws one run's figures into its `figures/`; returns the PNGs and SVGs, the vorticity's last.
pub fn draw_run(run: &Path) -> Result<Vec<PathBuf>> {
    let case = read_case(run)?;
    let figures = run.join("figures");
    fs::create_dir_all(&figures).map_err(Error::io(&figures))?;
    let mut written = Vec::new();
    if let Some(history) = forces(run, &case)? {
        let axes = Axes {
            x_label: "time (s)".into(),
            y_label: "force on particle 0 (N)".into(),
            title: case.name.clone(),
            ..Axes::default()
        };
        written.extend(figure::curves(&axes, &history, &figures.join("forces"))?);
    }
    let newest = newest_snapshot(run)?;
    let plane = plane(&case, &Snapshot::read(&newest)?, run)?;
    written.extend(figure::streamlines(&plane, &figures.join("streamlines"))?);
    written.extend(figure::vorticity(&plane, &figures.join("vorticity"))?);
    Ok(written)
}

fn not_a_run(run: &Path, what: &str) -> Error {
    Error::Usage(format!("{}: not a run's folder ({what}); give a folder that `mics run` wrote", run.display()))
}

fn read_case(run: &Path) -> Result<Case> {
    let path = run.join("case.toml");
    let text = fs::read_to_string(&path).map_err(|e| not_a_run(run, &format!("case.toml: {e}")))?;
    toml::from_str(&text).map_err(|e| not_a_run(run, &format!("case.toml: {}", e.message())))
}

fn newest_snapshot(run: &Path) -> Result<PathBuf> {
    let entries = fs::read_dir(run.join("fields")).map_err(|e| not_a_run(run, &format!("fields: {e}")))?;
    let paths = entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|x| x == "vti"));
    paths.max().ok_or_else(|| not_a_run(run, "fields holds no snapshot"))
}

/// The flow in the plane of the figure: all of a 2D run, the middle plane across z of a 3D one.
fn plane(case: &Case, snapshot: &Snapshot, run: &Path) -> Result<Plane> {
    let [nx, ny, nz] = snapshot.cells;
    let (from, count) = (nx * ny * (nz / 2), nx * ny);
    let component = |name: &str, k: usize| -> Result<Vec<f64>> {
        let array = snapshot.array(name).ok_or_else(|| not_a_run(run, &format!("its fields have no {name}")))?;
        let k = k.min(array.components - 1);
        let values = array.values.iter().skip(from * array.components + k).step_by(array.components);
        Ok(values.take(count).copied().collect())
    };
    let [hx, hy, hz] = snapshot.h;
    let height = (nz / 2) as f64 * hz + 0.5 * hz;
    let mut discs = Vec::new();
    let size = [nx as f64 * hx, ny as f64 * hy];
    let centres = centres_at(run, snapshot.time);
    for (id, p) in case.particle.iter().enumerate() {
        let at = centres
            .get(&id)
            .copied()
            .unwrap_or_else(|| std::array::from_fn(|a| p.position.get(a).copied().unwrap_or(0.0)));
        let off = if case.dimension() == 3 { at[2] - height } else { 0.0 };
        let square = 0.25 * p.shape.diameter() * p.shape.diameter() - off * off;
        if square <= 0.0 {
            continue;
        }
        // Across periodic faces, the images that reach into the box too.
        let images = |axis: usize| if case.sides()[2 * axis] == Some(&Side::Periodic) { -1..=1 } else { 0..=0 };
        for (kx, ky) in images(0).flat_map(|kx| images(1).map(move |ky| (kx, ky))) {
            let centre = [at[0] + f64::from(kx) * size[0], at[1] + f64::from(ky) * size[1]];
            let radius = square.sqrt();
            if (0..2).all(|a| centre[a] > -radius && centre[a] < size[a] + radius) {
                discs.push(Disc { centre, radius });
            }
        }
    }
    let slice = if nz > 1 { format!(", z = {height:.4} m") } else { String::new() };
    Ok(Plane {
        cells: [nx, ny],
        size,
        u: component("velocity", 0)?,
        v: component("velocity", 1)?,
        vorticity: component("vorticity", 2)?,
        discs,
        labels: ["x (m)".into(), "y (m)".into()],
        title: format!("{}, t = {:.4} s{slice}", case.name, snapshot.time),
    })
}

/// The rows of `particles.csv` as numbers by column name; empty where there is no such file.
fn particle_rows(run: &Path) -> (HashMap<String, usize>, Vec<Vec<f64>>) {
    let Ok(mut reader) = csv::Reader::from_path(run.join("particles.csv")) else { return Default::default() };
    let columns = reader.headers().map(|h| h.iter().enumerate().map(|(k, n)| (n.to_owned(), k)).collect());
    let numbers = |r: csv::StringRecord| r.iter().map(|v| v.parse().unwrap_or(f64::NAN)).collect();
    (columns.unwrap_or_default(), reader.records().flatten().map(numbers).collect())
}

/// Each particle's centre at the last row up to `time` (s).
fn centres_at(run: &Path, time: f64) -> HashMap<usize, [f64; 3]> {
    let (columns, rows) = particle_rows(run);
    let [Some(t), Some(id), Some(x)] = ["time", "id", "x"].map(|n| columns.get(n).copied()) else {
        return HashMap::new();
    };
    let upto = rows.iter().filter(|r| r[t] <= time * (1.0 + 1e-12));
    upto.map(|r| (r[id] as usize, [r[x], r[x + 1], r[x + 2]])).collect()
}

/// Force on particle 0 over time, and the three parts of (19) along x.
fn forces(run: &Path, case: &Case) -> Result<Option<Vec<Series>>> {
    let (columns, rows) = particle_rows(run);
    if case.particle.is_empty() || rows.is_empty() {
        return Ok(None);
    }
    let column =
        |name: &str| columns.get(name).copied().ok_or_else(|| not_a_run(run, &format!("particles.csv lacks {name}")));
    let (id, time) = (column("id")?, column("time")?);
    let mut series = Vec::new();
    for (name, label, style) in [
        ("fluid_fx", "fluid, along x", SeriesStyle::Line),
        ("fluid_fy", "fluid, along y", SeriesStyle::Line),
        ("pressure_fx", "pressure part of (19), x", SeriesStyle::Dashed),
        ("viscous_fx", "viscous part, x", SeriesStyle::Dashed),
        ("convective_fx", "convective part, x", SeriesStyle::Dashed),
    ] {
        let k = column(name)?;
        // The first steps of an impulsive start would flatten all that follows.
        let points: Vec<(f64, f64)> =
            rows.iter().filter(|r| r[id] == 0.0 && r[time] > 0.02 * case.time.end).map(|r| (r[time], r[k])).collect();
        series.push(Series { label: label.into(), points, style });
    }
    Ok(series.iter().any(|s| s.points.len() > 1).then_some(series))
}

fn draw_over_reynolds(runs: &[PathBuf], folder: &Path) -> Result<Vec<PathBuf>> {
    let mut drag: HashMap<String, Vec<(f64, f64)>> = HashMap::new();
    let mut strouhal = Vec::new();
    for run in runs {
        let case = read_case(run)?;
        let path = run.join("summary.json");
        let text = fs::read_to_string(&path).map_err(|e| not_a_run(run, &format!("summary.json: {e}")))?;
        let summary: serde_json::Value =
            serde_json::from_str(&text).map_err(|e| not_a_run(run, &format!("summary.json: {e}")))?;
        for m in &case.measure {
            let Some(value) = summary["measures"][&m.name].as_f64() else { continue };
            let (Some(speed), Some(p)) = (m.speed.or(case.reference_speed()), case.particle.get(m.particle)) else {
                continue;
            };
            let re = case.fluid.density * speed * p.shape.diameter() / case.fluid.viscosity;
            match m.kind {
                MeasureKind::DragCoefficient => drag.entry(m.name.clone()).or_default().push((re, value)),
                MeasureKind::Strouhal => strouhal.push((re, value)),
                _ => {}
            }
        }
    }
    let by_re = |mut points: Vec<(f64, f64)>| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let mut written = Vec::new();
    if !drag.is_empty() {
        // White's fit for cylinders; the paper's eq. (30) is taken to be it.
        let formula =
            (0..=40).map(|k| 10f64.powf(0.7 + 0.05 * f64::from(k))).map(|re| (re, 1.0 + 10.0 * re.powf(-2.0 / 3.0)));
        let mut series = vec![
            Series {
                label: "White: 1 + 10 Re^(-2/3), for eq. (30)".into(),
                points: formula.collect(),
                style: SeriesStyle::Dashed,
            },
            Series { label: "body-fitted reference".into(), points: reference("cd"), style: SeriesStyle::Line },
        ];
        let mut names: Vec<_> = drag.into_iter().collect();
        names.sort_by(|a, b| a.0.cmp(&b.0));
        series.extend(names.into_iter().map(|(label, points)| Series {
            label,
            points: by_re(points),
            style: SeriesStyle::Markers,
        }));
        let axes = Axes {
            x_label: "Re".into(),
            y_label: "Cd".into(),
            log_x: true,
            log_y: true,
            title: "Drag of a cylinder".into(),
        };
        written.extend(figure::curves(&axes, &series, &folder.join("drag_over_reynolds"))?);
    }
    if !strouhal.is_empty() {
        let series = [
            Series { label: "body-fitted reference".into(), points: reference("st"), style: SeriesStyle::Line },
            Series { label: "mics".into(), points: by_re(strouhal), style: SeriesStyle::Markers },
        ];
        let axes = Axes {
            x_label: "Re".into(),
            y_label: "St".into(),
            title: "Strouhal number of a cylinder".into(),
            ..Axes::default()
        };
        written.extend(figure::curves(&axes, &series, &folder.join("strouhal_over_reynolds"))?);
    }
    Ok(written)
}

/// (Re, value) of a column of the reference, where it has one.
fn reference(column: &str) -> Vec<(f64, f64)> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(REFERENCE.as_bytes());
    let at = reader.headers().ok().and_then(|h| h.iter().position(|n| n == column));
    let point = |r: csv::StringRecord| Some((r.get(0)?.parse().ok()?, r.get(at?)?.parse().ok()?));
    reader.records().flatten().filter_map(point).collect()
}
