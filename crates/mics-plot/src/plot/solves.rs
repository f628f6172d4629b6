//! The pressure solves of a step (`solves.csv`): their residuals, and |D| over the C-HSMAC
//! iterations.
//!
//! ```text
//!   largest |D|            residual
//!   | o                    | o.
//!   |   \                  |   o..o
//!   |     o                |       x.
//!   |- - - -\- - D0        |         '.x    a line a solve, of several runs a line a run
//!   +--------o             +--------------
//!   C-HSMAC iterations     Krylov iterations of the step so far
//! ```

use super::Run;
use super::series::{Group, Panel, Plot};
use super::steps::limits;
use super::table::{Rows, Table};
use crate::figure::{Chart, SeriesStyle};
use mics_run::folder::SOLVES;
use mics_run::words::rounded;
use mics_run::{Error, Result};
use std::path::Path;

/// Solves in a figure at most: two rounds of the colours.
const MOST: usize = 14;
/// Points of a line up to which each has a marker.
const MARKED: usize = 40;

/// The columns that are read, in this order; the norm is a text.
const COLUMNS: [&str; 11] = [
    "step",
    "time",
    "projection",
    "outer_iteration",
    "attempt",
    "krylov_iteration",
    "residual",
    "tolerance",
    "divergence_before",
    "divergence_after",
    "norm",
];

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
        let Some(mut rows) = Rows::open(run, SOLVES, &COLUMNS)? else { return Ok(None) };
        let off = |found: &StepSolves| time.map_or(0.0, |time| (found.time - time).abs());
        let mut best = StepSolves::default();
        let mut found = StepSolves::default();
        let mut first = None;
        while let Some(row) = rows.advance()?.map(<[f64]>::to_vec) {
            first.get_or_insert(row[1]);
            if row[0] as u64 != found.step {
                if best.solves.is_empty() || off(&found) <= off(&best) {
                    best = found;
                }
                found = StepSolves { step: row[0] as u64, time: row[1], solves: Vec::new() };
            }
            found.take(&row, rows.text(COLUMNS.len() - 1));
        }
        refuse_outside(run, time, first.map(|first| [first, found.time]))?;
        if best.solves.is_empty() || off(&found) <= off(&best) {
            best = found;
        }
        Ok(Some(best).filter(|best| !best.solves.is_empty()))
    }

    /// Takes a row of the step, with its norm.
    fn take(&mut self, row: &[f64], norm: &str) {
        let place = [row[2], row[3], row[4]].map(|number| number as u32);
        let some = |value: f64| (!value.is_nan()).then_some(value);
        if self.solves.last().is_none_or(|solve| solve.place != place) {
            self.solves.push(Solve {
                place,
                norm: norm.to_owned(),
                residuals: Vec::new(),
                tolerance: some(row[7]),
                divergence: (row[8], some(row[9])),
            });
        }
        if let Some(solve) = self.solves.last_mut() {
            solve.residuals.extend(some(row[5]).zip(some(row[6])));
        }
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

    /// The largest |D| over the C-HSMAC iterations, with a gap where a projection follows another.
    fn divergences(&self) -> Table {
        let mut table = Table::new(&["outer", "divergence"]);
        let after = |solve: &Solve| Some([f64::from(solve.place[1]), solve.divergence.1?]);
        let mut last: Option<&Solve> = None;
        for solve in &self.solves {
            if last.is_some_and(|last| last.place[..2] == solve.place[..2]) {
                continue;
            }
            if let Some(last) = last.filter(|last| last.place[0] != solve.place[0]) {
                after(last).iter().chain(&[[f64::NAN; 2]]).for_each(|point| table.push(point));
            }
            table.push(&[f64::from(solve.place[1]) - 1.0, solve.divergence.0]);
            last = Some(solve);
        }
        if let Some(point) = last.and_then(after) {
            table.push(&point);
        }
        table
    }

    /// The residuals of each solve over the Krylov iterations of the step so far.
    fn residuals(&self) -> Vec<Table> {
        let mut before = 0.0;
        let of = |solve: &Solve| {
            let mut table = Table::new(&["krylov", "residual"]);
            for (iterations, residual) in &solve.residuals {
                table.push(&[before + iterations, *residual]);
            }
            before += solve.residuals.last().map_or(0.0, |last| last.0);
            table
        };
        self.solves.iter().map(of).collect()
    }

    /// The groups of a run alone: |D|, and a line a solve.
    fn each(&self) -> Vec<Group> {
        let solves: Vec<_> = self.solves.iter().zip(self.residuals()).collect();
        let shown = super::evenly(solves.len(), solves.len().min(MOST));
        let named = |k: usize| Group::new(self.name(solves[k].0), solves[k].1.clone());
        [Group::new("", self.divergences())].into_iter().chain(shown.map(named)).collect()
    }

    /// The group of a run beside others: |D|, and its solves one after the other.
    fn together(&self) -> Group {
        let mut krylov = Vec::new();
        let mut residual = Vec::new();
        for table in self.residuals() {
            krylov.extend(table.column("krylov").iter().chain(&[f64::NAN]));
            residual.extend(table.column("residual").iter().chain(&[f64::NAN]));
        }
        let table = self.divergences().with("krylov", krylov).with("residual", residual);
        Group::new("", table)
    }
}

/// Refuses a time (s) outside those of a history by more than its length.
fn refuse_outside(run: &Path, time: Option<f64>, ends: Option<[f64; 2]>) -> Result<()> {
    let Some((time, [first, last])) = time.zip(ends) else { return Ok(()) };
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
/// time (s), beside the residuals of their solves: of one run a line a solve, of several a line a
/// run. None where no run has a history.
///
/// # Errors
/// As [`StepSolves::read`].
pub fn convergence(runs: &[Run], time: Option<f64>) -> Result<Option<Chart>> {
    let mut groups = Vec::new();
    let mut norms: Vec<&str> = Vec::new();
    let mut without = Vec::new();
    let mut projections = 1;
    let mut title = match time {
        Some(time) => format!("pressure solves of the step at t = {time} s"),
        None => "pressure solves of the last step".to_owned(),
    };
    for run in runs {
        let Some(found) = StepSolves::read(&run.folder, time)? else {
            without.push(run.label.as_str());
            continue;
        };
        norms.extend(found.solves.iter().map(|solve| residual_label(&solve.norm)));
        projections = found.solves.iter().map(|solve| solve.place[0]).fold(projections, u32::max);
        if runs.len() > 1 {
            groups.extend(run.name(vec![found.together()], false));
            continue;
        }
        title = format!("pressure solves of step {}, t = {} s", found.step, rounded(found.time));
        groups = found.each();
        if found.solves.len() > MOST {
            title += &format!(", {MOST} of its {} solves", found.solves.len());
        }
    }
    norms.dedup();
    if groups.is_empty() {
        return Ok(None);
    }
    let points = groups.iter().map(|group| group.table.column("krylov").len()).max().unwrap_or(0);
    let style = if points > MARKED { SeriesStyle::Line } else { SeriesStyle::Joined };
    let panel = |name: &str, quantity: &str, over: &str, over_label: &str| {
        let mut panel = Panel::of(name, quantity, "", over, over_label);
        panel.lines[0].style = style;
        Panel { log: true, ..panel }
    };
    let mut notes = Vec::new();
    let mut divergence = panel("divergence", "largest |D| (1/s)", "outer", "C-HSMAC iterations");
    divergence.limits = limits(runs, &mut notes);
    if projections > 1 {
        notes.push("a point alone: a projection to part of the digits".to_owned());
    }
    if !without.is_empty() {
        notes.push(format!("without a history: {}", without.join(", ")));
    }
    let residual = if let [norm] = norms[..] { norm } else { "residual, each in its own norm" };
    let residual = panel("residual", residual, "krylov", "Krylov iterations of the step");
    let panels = vec![divergence, residual];
    let plot = Plot { groups, panels, title, notes, beside: true, counts: true, ..Plot::default() };
    Ok(plot.chart())
}

/// Axis label of residuals in a norm of PETSc's name.
fn residual_label(norm: &str) -> &'static str {
    match norm {
        "preconditioned" => "preconditioned residual (Pa), 2-norm",
        "natural" => "residual, natural norm",
        _ => "residual (1/s2), 2-norm",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn residuals_go_on_over_the_krylov_iterations_of_the_step() {
        let folder = tempfile::tempdir().unwrap();
        let head = "step,time,projection,outer_iteration,attempt,krylov_iteration,norm,residual,\
            relative_residual,tolerance,divergence_before,divergence_after\n";
        let row = |step: u32, outer: u32, krylov: u32, residual: f64, after: &str| {
            let before = 8 / outer;
            format!(
                "{step},0.{step},1,{outer},1,{krylov},unpreconditioned,{residual},1,1e-3,{before},\
                {after}\n"
            )
        };
        let rows = [
            row(1, 1, 0, 4.0, "0.5"),
            row(2, 1, 0, 8.0, "4"),
            row(2, 1, 2, 1.0, "4"),
            row(2, 2, 0, 1.0, "0.1"),
            row(2, 2, 3, 0.1, "0.1"),
        ];
        std::fs::write(folder.path().join(SOLVES), head.to_owned() + &rows.concat()).unwrap();
        let steps = "step,krylov_iterations,outer_iterations,divergence_max\n0,0,0,9\n1,3,1,0.5\n\
            2,5,2,0.1\n";
        std::fs::write(folder.path().join("steps.csv"), steps).unwrap();
        let case = "name = \"t\"\ntime.end = 9.0\ndomain = { size = [1.0, 2.0], cells = [8, 16] }\n\
            fluid = { density = 2.0, viscosity = 0.1 }\n\
            boundary = { west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" }\n";
        let runs = [Run::of_text(folder.path(), case)];
        let chart = convergence(&runs, None).unwrap().unwrap();
        let points = |panel: usize, line: usize| chart.panels[panel].1[line].points.clone();
        assert_eq!(points(0, 0), [(0.0, 8.0), (1.0, 4.0), (2.0, 0.1)]);
        assert_eq!(points(1, 0), [(0.0, 8.0), (2.0, 1.0)]);
        assert_eq!(points(1, 1), [(2.0, 1.0), (5.0, 0.1)]);
        // The row of the start has no step behind it.
        let over = super::super::steps::over_steps(&runs).unwrap().unwrap();
        assert_eq!(over.panels[0].1[0].points, [(1.0, 3.0), (2.0, 5.0)]);
    }
}
