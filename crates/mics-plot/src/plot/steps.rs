//! What `steps.csv` has of a run's steps: iterations and |D| of the pressure, length of the steps,
//! kinetic energy.

use super::Run;
use super::series::{Group, Panel, Plot, joined};
use super::table::Table;
use crate::figure::{Chart, SeriesStyle};
use mics_run::Result;

/// The file of the steps.
const STEPS: &str = "steps.csv";
/// Ratio of the most to the fewest iterations of a step from which on their axis is logarithmic.
const WIDE: f64 = 20.0;

/// Iterations of the pressure and the largest |D| over the steps of runs; none where there is no
/// step.
///
/// # Errors
/// When `steps.csv` is not one of a run.
pub fn over_steps(runs: &[Run]) -> Result<Option<Chart>> {
    let columns = ["step", "krylov_iterations", "outer_iterations", "divergence_max"];
    let groups = groups(runs, &columns)?;
    let panel = |name: &str, quantity: &str, unit| Panel::of(name, quantity, unit, "step", "step");
    let mut panels = vec![
        panel(columns[1], "Krylov iterations a step", ""),
        panel(columns[2], "C-HSMAC iterations a step", ""),
        panel(columns[3], "largest |D|", "1/s"),
    ];
    let iterations = || groups.iter().flat_map(|group| group.table.column(columns[1]));
    let fewest = iterations().copied().fold(f64::INFINITY, f64::min);
    let most = iterations().copied().fold(0.0, f64::max);
    panels[0].log = fewest > 0.0 && most > WIDE * fewest;
    panels[2].log = true;
    let mut notes = Vec::new();
    panels[2].limits = limits(runs, &mut notes);
    let title = "iterations and |D| of the pressure".to_owned();
    Ok(Plot { groups, panels, title, notes, counts: true, ..Plot::default() }.chart())
}

/// The limits D0 of |D| of some runs (1/s), with a note on the dashed lines.
pub fn limits(runs: &[Run], notes: &mut Vec<String>) -> Vec<f64> {
    let mut limits: Vec<f64> = runs.iter().map(|run| run.case.pressure.divergence_limit).collect();
    limits.sort_by(f64::total_cmp);
    limits.dedup();
    notes.push("dashed: the limit D0 of |D|".to_owned());
    limits
}

/// The length of each step of a run.
///
/// # Errors
/// When `steps.csv` is not one of a run.
pub fn lengths(run: &Run) -> Result<Option<Chart>> {
    let groups = groups(std::slice::from_ref(run), &["time", "dt"])?;
    let panels = vec![Panel::of("dt", "length of a step", "s", "time", "time (s)")];
    Ok(Plot { groups, panels, ..Plot::default() }.chart())
}

/// The kinetic energy of the fluid and, where there are free particles, theirs and the sum.
///
/// # Errors
/// When `steps.csv` is not one of a run.
pub fn energy(run: &Run) -> Result<Option<Chart>> {
    let columns = ["kinetic_energy", "fluid_energy", "bodies_energy"];
    let groups = groups(std::slice::from_ref(run), &[&["time"][..], &columns].concat())?;
    let unit = if run.case.dimension() == 2 { "J/m" } else { "J" };
    let mut panel = Panel::of(columns[0], "kinetic energy", unit, "time", "time (s)");
    let mut title = "kinetic energy of the fluid".to_owned();
    if run.case.particle.iter().any(|p| p.is_free()) {
        panel.lines[0].label = "both".to_owned();
        panel = panel.with(columns[1], "fluid outside the particles", SeriesStyle::Line);
        panel = panel.with(columns[2], "free particles", SeriesStyle::Line);
        title = joined(&[&title, "of the free particles, and their sum"]);
    }
    Ok(Plot { groups, panels: vec![panel], title, ..Plot::default() }.chart())
}

/// Columns of the steps of runs, a group each, without the row of time 0, which has no step behind
/// it.
fn groups(runs: &[Run], columns: &[&str]) -> Result<Vec<Group>> {
    let mut all = Vec::new();
    for run in runs {
        let Some(table) = Table::read(&run.folder, STEPS, columns)? else { continue };
        let table = table.map(|column| column.get(1..).unwrap_or_default().to_vec());
        all.extend(run.name(vec![Group::new("", table)], false));
    }
    Ok(all)
}
