//! The pressure solves: residuals and |D| of a step (`solves.csv`), and iterations and |D| over the
//! steps (`steps.csv`).
//!
//! ```text
//!   largest |D|            residual
//!   | o                    | o.
//!   |   \                  |   o..o     C-HSMAC iteration 1
//!   |     o                | x.    '.
//!   |- - - -\- - D0        |   x..x  o  C-HSMAC iteration 2
//!   +--------o             +------------
//!   C-HSMAC iterations     Krylov iterations
//! ```

use super::evenly;
use super::rows::table;
use crate::figure::{Axes, Chart, Series, SeriesStyle};
use mics_run::folder::SOLVES;
use mics_run::words::rounded;
use mics_run::{Error, Result, not_a_run};
use std::collections::HashMap;
use std::path::Path;

/// Solves in a figure at most: two rounds of the colours.
const MOST: usize = 14;
/// Iterations of a solve up to which each has a marker.
const MARKED: usize = 40;

/// An attempt at the solve of a C-HSMAC iteration.
pub struct Solve {
    /// Projection of the step, C-HSMAC iteration of the step and attempt, each from 1.
    pub place: [u32; 3],
    /// The norm of the residuals, by PETSc's name.
    pub norm: String,
    /// Krylov iterations and the residual after each.
    pub residuals: Vec<(f64, f64)>,
    /// The residual below which it ends, where the method tests one.
    pub tolerance: Option<f64>,
    /// The largest |D| (1/s) before it and, where it is known, after it.
    pub divergence: (f64, Option<f64>),
}

/// The solves of a step, in their order.
#[derive(Default)]
pub struct StepSolves {
    /// The step and the time (s) at its end.
    pub step: u64,
    #[allow(missing_docs)]
    pub time: f64,
    #[allow(missing_docs)]
    pub solves: Vec<Solve>,
}

impl StepSolves {
    /// Reads the solves of the last step that has a history, or of the one next to a time (s);
    /// `None` where the run has none.
    ///
    /// # Errors
    /// When the file is not one of a run, or the time lies outside it.
    pub fn read(run: &Path, time: Option<f64>) -> Result<Option<StepSolves>> {
        let strange = || not_a_run(run, &format!("{SOLVES} is not one that mics wrote"));
        let Some(mut reader) = table(&run.join(SOLVES)) else { return Ok(None) };
        let head = reader.headers().map_err(|_| strange())?.clone();
        let columns: HashMap<&str, usize> = head.iter().enumerate().map(|(k, n)| (n, k)).collect();
        let column = |name: &str| columns.get(name).copied().ok_or_else(strange);
        let step = column("step")?;
        let when = column("time")?;
        let norm = column("norm")?;
        let mut numbers = [0; 7];
        let names = ["projection", "outer_iteration", "attempt", "krylov_iteration", "residual"];
        let names = names.iter().chain(&["tolerance", "divergence_before"]);
        for (number, name) in numbers.iter_mut().zip(names) {
            *number = column(name)?;
        }
        let after = column("divergence_after")?;
        let off = |found: &StepSolves| time.map_or(0.0, |time| (found.time - time).abs());
        let mut best: Option<StepSolves> = None;
        let mut found = StepSolves::default();
        let mut ends: Option<(f64, f64)> = None;
        let mut record = csv::StringRecord::new();
        loop {
            let more = reader.read_record(&mut record).map_err(|_| strange())?;
            let number = |k: usize| record.get(k).and_then(|text| text.parse::<f64>().ok());
            let at = if more { number(step).ok_or_else(strange)? as u64 } else { u64::MAX };
            if at != found.step {
                let nearer = best.as_ref().is_none_or(|best| off(&found) <= off(best));
                if !found.solves.is_empty() && nearer {
                    best = Some(found);
                }
                let time = number(when).unwrap_or(f64::NAN);
                found = StepSolves { step: at, time, solves: Vec::new() };
            }
            if !more {
                break;
            }
            ends = Some((ends.map_or(found.time, |ends| ends.0), found.time));
            let [projection, outer, attempt, krylov, residual, tolerance, before] =
                numbers.map(number);
            let place = [projection, outer, attempt].map(|number| number.unwrap_or(0.0) as u32);
            if found.solves.last().is_none_or(|solve| solve.place != place) {
                found.solves.push(Solve {
                    place,
                    norm: record.get(norm).unwrap_or_default().to_owned(),
                    residuals: Vec::new(),
                    tolerance,
                    divergence: (before.ok_or_else(strange)?, number(after)),
                });
            }
            if let (Some(solve), Some(point)) = (found.solves.last_mut(), krylov.zip(residual)) {
                solve.residuals.push(point);
            }
        }
        refuse_outside(run, time, ends)?;
        Ok(best)
    }

    /// Name of a solve, which tells it apart from the others of the step.
    pub fn name(&self, solve: &Solve) -> String {
        let [projection, outer, attempt] = solve.place;
        let mut name = format!("C-HSMAC iteration {outer}");
        if self.solves.last().is_some_and(|last| last.place[0] > 1) {
            name = format!("projection {projection}, {name}");
        }
        if self.solves.iter().any(|other| other.place[2] > 1) {
            name += &format!(", attempt {attempt}");
        }
        name
    }
}

/// Refuses a time (s) outside those of a history by more than its length.
fn refuse_outside(run: &Path, time: Option<f64>, ends: Option<(f64, f64)>) -> Result<()> {
    let Some((time, (first, last))) = time.zip(ends) else { return Ok(()) };
    // A step ends at its time, and the last ones may have no history.
    if (0.0..=last + (last - first).max(1e-9 * last)).contains(&time) {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--times {time}: the steps in {SOLVES} of {} are from t = {} to {} s; give a time in there",
        run.display(),
        rounded(first),
        rounded(last)
    )))
}

/// |D| over the C-HSMAC iterations of the last step that has a history, or of the one next to a
/// time (s), beside the residuals of their solves; `None` where the run has no history. `limit` is
/// D0 (1/s).
///
/// # Errors
/// As [`StepSolves::read`].
pub fn convergence(run: &Path, limit: f64, time: Option<f64>) -> Result<Option<Chart>> {
    let Some(found) = StepSolves::read(run, time)? else { return Ok(None) };
    let shown: Vec<&Solve> = evenly(found.solves.len(), found.solves.len().min(MOST))
        .map(|k| &found.solves[k])
        .collect();
    let mut series: Vec<Series> = shown.iter().map(|solve| residuals(&found, solve)).collect();
    // Where each was to end.
    let last = |solve: &&Solve| Some((solve.residuals.last()?.0, solve.tolerance?));
    let tolerances: Vec<_> = shown.iter().filter_map(last).collect();
    if !tolerances.is_empty() {
        let label = "tolerance of each".into();
        let style = SeriesStyle::Markers;
        series.push(Series { label, points: tolerances, style });
    }
    let of = if shown.len() < found.solves.len() {
        format!(", {} of its {} solves", shown.len(), found.solves.len())
    } else {
        String::new()
    };
    let note = if found.solves.last().is_some_and(|last| last.place[0] > 1) {
        "dashed: the limit D0 of |D|; a point alone: a projection to part of the digits"
    } else {
        "dashed: the limit D0 of |D|"
    };
    let norm = shown.first().map_or("", |solve| &solve.norm);
    let divergence = Axes {
        x_label: "C-HSMAC iterations".into(),
        y_label: "largest |D| (1/s)".into(),
        title: format!("pressure solves of step {}, t = {} s{of}", found.step, rounded(found.time)),
        note: note.into(),
        log_y: true,
        whole_x: true,
        ..Axes::default()
    };
    let solves = Axes {
        x_label: "Krylov iterations".into(),
        y_label: residual_label(norm).into(),
        log_y: true,
        whole_x: true,
        ..Axes::default()
    };
    let panels = vec![(divergence, divergences(&found, limit)), (solves, series)];
    Ok(Some(Chart { panels, beside: true }))
}

/// The chart of several runs, a line each of its name: their solves one after the other, over the
/// Krylov iterations of the step so far. `None` where no run has a history; `limit` is D0 (1/s).
///
/// # Errors
/// As [`StepSolves::read`].
pub fn of_runs(runs: &[(&str, &Path, f64)], time: Option<f64>) -> Result<Option<Chart>> {
    let mut divergence = Vec::new();
    let mut limits = Vec::new();
    let mut residual = Vec::new();
    let mut norms: Vec<&str> = Vec::new();
    for (label, folder, limit) in runs {
        let Some(found) = StepSolves::read(folder, time)? else { continue };
        let mut lines = divergences(&found, *limit);
        limits.extend(lines.pop().filter(|limit| is_new(&limits, limit)));
        divergence.extend(lines.into_iter().map(|line| Series { label: (*label).into(), ..line }));
        let mut points = Vec::new();
        let mut before = 0.0;
        for solve in &found.solves {
            points.extend(solve.residuals.iter().map(|(k, residual)| (before + k, *residual)));
            points.push((f64::NAN, f64::NAN));
            before += solve.residuals.last().map_or(0.0, |last| last.0);
            norms.push(residual_label(&solve.norm));
        }
        residual.push(Series { label: String::new(), points, style: SeriesStyle::Joined });
    }
    norms.dedup();
    if divergence.is_empty() {
        return Ok(None);
    }
    divergence.extend(limits);
    let step = time.map_or("the last step".to_owned(), |t| format!("the step at t = {t} s"));
    let axes = |x: &str, y: &str| Axes {
        x_label: x.into(),
        y_label: y.into(),
        log_y: true,
        whole_x: true,
        ..Axes::default()
    };
    let first = Axes {
        title: format!("pressure solves of {step}"),
        note: "dashed: the limit D0 of |D|; right: a line of each solve, one after the other"
            .into(),
        ..axes("C-HSMAC iterations", "largest |D| (1/s)")
    };
    let y = if let [norm] = norms[..] { norm } else { "residual, each in its own norm" };
    let second = axes("Krylov iterations of the step", y);
    Ok(Some(Chart { panels: vec![(first, divergence), (second, residual)], beside: true }))
}

/// Whether no series has the points of another one.
fn is_new(all: &[Series], one: &Series) -> bool {
    all.iter().all(|other| other.points != one.points)
}

/// Axis label of residuals in a norm of PETSc's name.
fn residual_label(norm: &str) -> &'static str {
    match norm {
        "preconditioned" => "preconditioned residual (Pa), 2-norm",
        "natural" => "residual, natural norm",
        _ => "residual (1/s2), 2-norm",
    }
}

fn residuals(step: &StepSolves, solve: &Solve) -> Series {
    let points = solve.residuals.clone();
    let style = if points.len() > MARKED { SeriesStyle::Line } else { SeriesStyle::Joined };
    Series { label: step.name(solve), points, style }
}

/// The largest |D| of a step over its C-HSMAC iterations, with a gap where a projection follows
/// another, and the limit.
fn divergences(step: &StepSolves, limit: f64) -> Vec<Series> {
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut last: Option<&Solve> = None;
    for solve in &step.solves {
        if last.is_some_and(|last| last.place[..2] == solve.place[..2]) {
            continue;
        }
        if let Some(last) = last.filter(|last| last.place[0] != solve.place[0]) {
            points.extend(after(last).into_iter().chain([(f64::NAN, f64::NAN)]));
        }
        points.push((f64::from(solve.place[1]) - 1.0, solve.divergence.0));
        last = Some(solve);
    }
    points.extend(last.and_then(after));
    let most = points.iter().map(|point| point.0).fold(1.0, f64::max);
    let limit = vec![(0.0, limit), (most, limit)];
    vec![
        Series { label: String::new(), points, style: SeriesStyle::Joined },
        Series { label: String::new(), points: limit, style: SeriesStyle::Dashed },
    ]
}

fn after(solve: &Solve) -> Option<(f64, f64)> {
    Some((f64::from(solve.place[1]), solve.divergence.1?))
}

/// Iterations and |D| over the steps of runs, with their names where there are several; `None`
/// where there is no step. `limit` is D0 (1/s).
///
/// # Errors
/// When `steps.csv` is not one of a run.
pub fn over_steps(runs: &[(&str, &Path, f64)]) -> Result<Option<Chart>> {
    let mut iterations = Vec::new();
    let mut divergence = Vec::new();
    let mut limits = Vec::new();
    for (label, run, limit) in runs {
        let Some(lines) = steps_of(run)? else { continue };
        let [krylov, outer, largest] = lines.map(|line| {
            let both = [*label, &line.label].into_iter().filter(|word| !word.is_empty());
            Series { label: both.collect::<Vec<_>>().join(", "), ..line }
        });
        let ends = [largest.points.first(), largest.points.last()].into_iter().flatten();
        let points = ends.map(|end| (end.0, *limit)).collect();
        let dashed = Series { label: "limit D0".into(), points, style: SeriesStyle::Dashed };
        limits.extend(Some(dashed).filter(|limit| is_new(&limits, limit)));
        iterations.extend([krylov, outer]);
        divergence.push(largest);
    }
    divergence.extend(limits);
    let above = Axes {
        x_label: "step".into(),
        y_label: "iterations a step".into(),
        title: "iterations and |D| of the pressure".into(),
        whole_x: true,
        ..Axes::default()
    };
    let below = Axes {
        x_label: "step".into(),
        y_label: "largest |D| (1/s)".into(),
        log_y: true,
        whole_x: true,
        ..Axes::default()
    };
    let panels = vec![(above, iterations), (below, divergence)];
    Ok(Some(Chart { panels, beside: false }).filter(Chart::shows))
}

/// Krylov and C-HSMAC iterations and the largest |D| over the steps of a run; `None` where it has
/// no step.
fn steps_of(run: &Path) -> Result<Option<[Series; 3]>> {
    let strange = || not_a_run(run, "steps.csv is not one that mics wrote");
    let Some(mut reader) = table(&run.join("steps.csv")) else { return Ok(None) };
    let head = reader.headers().map_err(|_| strange())?.clone();
    let column = |name: &str| head.iter().position(|other| other == name).ok_or_else(strange);
    let step = column("step")?;
    let columns = [
        (column("krylov_iterations")?, "Krylov"),
        (column("outer_iterations")?, "C-HSMAC"),
        (column("divergence_max")?, "largest |D|"),
    ];
    let mut all = columns.map(|(_, label)| Series {
        label: label.into(),
        points: Vec::new(),
        style: SeriesStyle::Line,
    });
    // The row of time 0 has no step behind it.
    for record in reader.records().skip(1) {
        let record = record.map_err(|_| strange())?;
        let number = |k: usize| record.get(k).and_then(|text| text.parse().ok());
        for (series, (k, _)) in all.iter_mut().zip(columns) {
            series.points.extend(number(step).zip(number(k)));
        }
    }
    Ok(Some(all))
}
