//! `mics plot`: the figures of run folders, from what the folders hold.
//!
//! One run: vorticity with streamlines (Fig. 7), streamlines (Fig. 6), forces over time and their parts
//! (Fig. 10), paths (Fig. 9) and speeds of free particles. All runs together: Cd(Re) beside eq. (30) and the reference
//! (Fig. 4), St(Re) (Fig. 5).

use super::figure::{self, Axes, Disc, Plane, Series, SeriesStyle};
use super::not_a_run;
use super::snapshot::Snapshot;
use crate::config::{Case, MeasureKind, Motion, load};
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
    // All is read before anything is written.
    let snapshot = Snapshot::read(&newest_snapshot(run)?)?;
    let rows = Rows::read(run, &case, snapshot.time);
    let plane = plane(&case, &snapshot, run, &rows)?;
    let figures = run.join("figures");
    fs::create_dir_all(&figures).map_err(Error::io(&figures))?;
    let mut written = Vec::new();
    for (name, x_label, y_label, series) in [
        ("forces", "time (s)", "force on particle 0 (N)", forces(run, &case, &rows)?),
        ("speeds", "time (s)", "velocity of particle 0 (m/s)", speeds(run, &case, &rows)?),
        ("paths", "x (m)", "y (m)", paths(run, &case, &rows)?),
    ] {
        if series.iter().any(|s| s.points.len() > 1) {
            let (x_label, y_label) = (x_label.into(), y_label.into());
            let frame = (name == "paths").then(|| [case.domain.size[0], case.domain.size[1]]);
            let axes = Axes { x_label, y_label, title: case.name.clone(), frame, ..Axes::default() };
            written.extend(figure::curves(&axes, &series, &figures.join(name))?);
        }
    }
    written.extend(figure::streamlines(&plane, &figures.join("streamlines"))?);
    written.extend(figure::vorticity(&plane, &figures.join("vorticity"))?);
    Ok(written)
}

pub(super) fn read_case(run: &Path) -> Result<Case> {
    let loaded = load(&run.join("case.toml"), &[]).map_err(|e| not_a_run(run, &e.to_string()))?;
    Ok(loaded.case)
}

pub(super) fn newest_snapshot(run: &Path) -> Result<PathBuf> {
    let entries = fs::read_dir(run.join("fields")).map_err(|e| not_a_run(run, &format!("fields: {e}")))?;
    let paths = entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|x| x == "vti"));
    paths.max().ok_or_else(|| not_a_run(run, "fields holds no snapshot"))
}

/// The flow in the plane of the figure: all of a 2D run, the middle plane across z of a 3D one.
pub(super) fn plane(case: &Case, snapshot: &Snapshot, run: &Path, rows: &Rows) -> Result<Plane> {
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
    for (id, p) in case.particle.iter().enumerate() {
        let at = rows
            .centres
            .get(&id)
            .copied()
            .unwrap_or_else(|| std::array::from_fn(|a| p.position.get(a).copied().unwrap_or(0.0)));
        let off = if case.dimension() == 3 { at[2] - height } else { 0.0 };
        let square = 0.25 * p.shape.diameter() * p.shape.diameter() - off * off;
        if square <= 0.0 {
            continue;
        }
        // Across periodic faces, the images that reach into the box too.
        let images = |axis: usize| if case.periodic(axis) { -1..=1 } else { 0..=0 };
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

/// What figures and reports take from `particles.csv`, which may be far larger than memory; empty where there is no such file.
#[derive(Default)]
pub(super) struct Rows {
    /// The number of each column by its name.
    columns: HashMap<String, usize>,
    /// All rows of particle 0 and of the first ones that move.
    followed: Vec<Vec<f64>>,
    /// Every particle's centre (m) at a time, and its largest speed (m/s).
    centres: HashMap<usize, [f64; 3]>,
    pub fastest: HashMap<usize, f64>,
}

impl Rows {
    /// Reads a run's rows, with the centres at the last rows up to `time` (s).
    pub(super) fn read(run: &Path, case: &Case, time: f64) -> Rows {
        let Ok(mut reader) = csv::Reader::from_path(run.join("particles.csv")) else { return Rows::default() };
        let columns = reader.headers().map(|h| h.iter().enumerate().map(|(k, n)| (n.to_owned(), k)).collect());
        let mut rows = Rows { columns: columns.unwrap_or_default(), ..Rows::default() };
        let [Some(t), Some(id), Some(x), Some(v)] = ["time", "id", "x", "vx"].map(|n| rows.columns.get(n).copied())
        else {
            return rows;
        };
        let mut follows: Vec<usize> = movers(case).take(PATHS).collect();
        follows.push(0);
        let (mut record, width) = (csv::StringRecord::new(), rows.columns.len());
        while let Ok(true) = reader.read_record(&mut record) {
            let number = |k: usize| record.get(k).and_then(|v| v.parse().ok()).unwrap_or(f64::NAN);
            let particle = number(id) as usize;
            if number(t) <= time * (1.0 + 1e-12) {
                rows.centres.insert(particle, [x, x + 1, x + 2].map(number));
            }
            let speed = [v, v + 1, v + 2].map(number).iter().map(|v| v * v).sum::<f64>().sqrt();
            let fastest = rows.fastest.entry(particle).or_insert(0.0);
            *fastest = fastest.max(speed);
            if follows.contains(&particle) {
                rows.followed.push((0..width).map(number).collect());
            }
        }
        rows
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.followed.is_empty()
    }
}

/// The particles that move.
fn movers(case: &Case) -> impl Iterator<Item = usize> {
    case.particle.iter().enumerate().filter(|(_, p)| p.motion != Motion::Fixed).map(|(id, _)| id)
}

/// One column over another, of one particle.
pub(super) fn curve(run: &Path, rows: &Rows, id: usize, x: &str, y: &str, label: &str) -> Result<Series> {
    let column = |name: &str| {
        rows.columns.get(name).copied().ok_or_else(|| not_a_run(run, &format!("particles.csv lacks {name}")))
    };
    let (k, x, y) = (column("id")?, column(x)?, column(y)?);
    let points = rows.followed.iter().filter(|r| r[k] == id as f64).map(|r| (r[x], r[y])).collect();
    Ok(Series { label: label.into(), points, style: SeriesStyle::Line })
}

/// Force on particle 0 over time, and the three parts of (19) along x.
pub(super) fn forces(run: &Path, case: &Case, rows: &Rows) -> Result<Vec<Series>> {
    if case.particle.is_empty() || rows.is_empty() {
        return Ok(Vec::new());
    }
    let all = [
        ("fluid_fx", "fluid, along x", SeriesStyle::Line),
        ("fluid_fy", "fluid, along y", SeriesStyle::Line),
        ("pressure_fx", "pressure part of (19), x", SeriesStyle::Dashed),
        ("viscous_fx", "viscous part, x", SeriesStyle::Dashed),
        ("convective_fx", "convective part, x", SeriesStyle::Dashed),
    ];
    let series = all.into_iter().map(|(name, label, style)| {
        let mut series = curve(run, rows, 0, "time", name, label)?;
        // The first steps of an impulsive start would flatten all that follows.
        series.points.retain(|p| p.0 > 0.02 * case.time.end);
        Ok(Series { style, ..series })
    });
    series.collect()
}

/// Velocity of particle 0 over time, where it is free.
pub(super) fn speeds(run: &Path, case: &Case, rows: &Rows) -> Result<Vec<Series>> {
    if rows.is_empty() || case.particle.first().is_none_or(|p| !p.is_free()) {
        return Ok(Vec::new());
    }
    [("vx", "along x"), ("vy", "along y")]
        .map(|(name, label)| curve(run, rows, 0, "time", name, label))
        .into_iter()
        .collect()
}

/// Paths drawn at most.
const PATHS: usize = 8;

/// The paths of the first particles that move, each cut where it crosses a periodic face.
pub(super) fn paths(run: &Path, case: &Case, rows: &Rows) -> Result<Vec<Series>> {
    let mut series = Vec::new();
    if rows.is_empty() {
        return Ok(series);
    }
    for id in movers(case).take(PATHS) {
        let path = curve(run, rows, id, "x", "y", &format!("particle {id}"))?;
        let far = |a: &(f64, f64), b: &(f64, f64)| {
            (a.0 - b.0).abs() > 0.5 * case.domain.size[0] || (a.1 - b.1).abs() > 0.5 * case.domain.size[1]
        };
        for (part, points) in path.points.chunk_by(|a, b| !far(a, b)).enumerate() {
            let label = if part == 0 { path.label.clone() } else { String::new() };
            series.push(Series { label, points: points.to_vec(), style: SeriesStyle::Line });
        }
    }
    Ok(series)
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
            let (Some(speed), Some(p)) = (m.speed, case.particle.get(m.particle)) else {
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
            Series {
                label: "body-fitted reference".into(),
                points: cylinder_reference("cd"),
                style: SeriesStyle::Line,
            },
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
            ..Axes::default()
        };
        written.extend(figure::curves(&axes, &series, &folder.join("drag_over_reynolds"))?);
    }
    if !strouhal.is_empty() {
        let series = [
            Series {
                label: "body-fitted reference".into(),
                points: cylinder_reference("st"),
                style: SeriesStyle::Line,
            },
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

/// (Re, value) of a column of section 3's reference (`cylinder_s3.csv`), where it has one.
pub fn cylinder_reference(column: &str) -> Vec<(f64, f64)> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(REFERENCE.as_bytes());
    let at = reader.headers().ok().and_then(|h| h.iter().position(|n| n == column));
    let point = |r: csv::StringRecord| Some((r.get(0)?.parse().ok()?, r.get(at?)?.parse().ok()?));
    reader.records().flatten().filter_map(point).collect()
}
