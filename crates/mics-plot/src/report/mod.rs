//! `mics report`: a run in one HTML file that needs nothing else: no script, no network, no second
//! file.
//!
//! `numbers` are its dimensionless numbers, `figures` draws what the folder holds, `page`
//! sets it.

mod figures;
mod numbers;
mod page;
mod solves;

use crate::plot::{self, PARTICLES, Rows, StepSolves, Table};
use mics_run::compare::Comparison;
use mics_run::config::Case;
use mics_run::file::replace;
use mics_run::folder::REPORT;
use mics_run::summary::{Provenance, Summary};
use mics_run::{Error, Result};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Contents of a run's folder.
struct Run {
    /// Its folder and its case.
    of: plot::Run,
    provenance: Provenance,
    /// Summary; only of a run that has ended.
    summary: Option<Summary>,
    /// The largest speed (m/s) of each particle.
    fastest: HashMap<usize, f64>,
    /// Columns of `steps.csv`.
    steps: Table,
    /// The pressure solves of the last step that has a history.
    solves: Option<StepSolves>,
    log: String,
}

impl Run {
    fn read(folder: &Path) -> Result<Run> {
        let provenance = Provenance::read(folder)?;
        let of = plot::Run::read(folder, &[])?;
        let steps = ["time", "step", "wall", "cfl", "divergence_max"];
        Ok(Run {
            provenance,
            // A run that goes on has no summary yet: the report is of what there is.
            summary: Summary::read(folder).ok(),
            fastest: fastest(folder)?,
            of,
            solves: StepSolves::read(folder, None)?,
            steps: Table::read(folder, "steps.csv", &steps)?.unwrap_or_default(),
            log: std::fs::read_to_string(folder.join("log.txt")).unwrap_or_default(),
        })
    }

    fn case(&self) -> &Case {
        &self.of.case
    }

    fn status(&self) -> &str {
        self.summary.as_ref().map_or("not ended", |s| s.status.as_str())
    }

    /// Why the run ended early, in its own words.
    fn failure(&self) -> Option<&str> {
        self.log
            .lines()
            .rev()
            .find_map(|line| line.strip_prefix("error: "))
            .filter(|_| self.status() != "done")
    }

    /// A column of `steps.csv`; empty where there is none.
    fn column(&self, name: &str) -> &[f64] {
        self.steps.column(name)
    }

    /// Every measure, its value and how it compares.
    fn measures(&self) -> Vec<(&mics_run::config::Measure, Option<f64>, Option<Comparison>)> {
        let values = self.summary.as_ref().map(|s| &s.measures);
        let of = |m| {
            let m: &mics_run::config::Measure = m;
            let value = values.and_then(|v| v.get(&m.name)?.as_f64());
            (m, value, Comparison::of(m, value))
        };
        self.case().measure.iter().map(of).collect()
    }
}

/// Writes the report of a run's folder to `out`, by default `report.html` in it; returns where.
///
/// # Errors
/// When the folder holds no run, or the file cannot be written.
pub fn write(folder: &Path, out: Option<&Path>) -> Result<PathBuf> {
    let run = Run::read(folder)?;
    let out = out.map_or_else(|| folder.join(REPORT), Path::to_owned);
    if out.is_dir() {
        return Err(Error::Usage(format!(
            "{}: is a folder; give --out a file, as in --out report.html",
            out.display()
        )));
    }
    let html = page::page(&run, &figures::figures(&run, folder)?);
    replace(&out, html.into_string().as_bytes())?;
    Ok(out)
}

/// The largest speed (m/s) that each particle of a run has in its rows.
fn fastest(folder: &Path) -> Result<HashMap<usize, f64>> {
    let mut all = HashMap::new();
    let columns = ["id", "vx", "vy", "vz"];
    let Some(mut rows) = Rows::open(folder, PARTICLES, &columns)? else { return Ok(all) };
    while let Some(row) = rows.advance()? {
        let speed = row[1..].iter().map(|v| v * v).sum::<f64>().sqrt();
        let most = all.entry(row[0] as usize).or_insert(0.0f64);
        *most = most.max(speed);
    }
    Ok(all)
}
