//! `summary.json` and `run.json` of a run's folder, read back.

use crate::Result;
use crate::compare::Comparison;
use crate::not_a_run;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use std::fs;
use std::path::Path;

/// `summary.json`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Summary {
    /// Status at the end: `done`, `failed`, `interrupted`.
    pub status: String,
    /// Cells of the grid.
    pub cells: usize,
    /// Steps.
    pub steps: u64,
    /// Time at the end (s).
    pub time: f64,
    /// Largest |D| over all steps (1/s).
    pub divergence_max: f64,
    /// C-HSMAC iterations of all steps.
    pub outer_iterations: u64,
    /// Krylov iterations of all steps.
    pub krylov_iterations: u64,
    /// Value of each measure that has one.
    pub measures: Map<String, Value>,
    /// Cost of the run.
    #[serde(flatten)]
    pub cost: Cost,
    /// Notes of the run on its energy at the end.
    #[serde(default)]
    pub notes: Vec<String>,
    comparisons: Map<String, Value>,
}

/// Cost of a run in time and memory, from its `summary.json`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Cost {
    /// Wall-clock seconds.
    pub wall_seconds: f64,
    /// Seconds of CPU, of all ranks together.
    pub cpu_seconds: f64,
    /// Time of each stage of the step (ns per cell and step).
    pub stages_ns_per_cell_step: Map<String, Value>,
    /// Largest memory of all ranks together (bytes).
    pub peak_memory_bytes: f64,
}

impl Summary {
    /// Reads a run's summary.
    ///
    /// # Errors
    /// When the folder has none: the run has not ended, or it is no run.
    pub fn read(run: &Path) -> Result<Summary> {
        read_json(&run.join("summary.json"))
    }

    /// The measures that have a reference, beside it, in the case's order.
    pub fn comparisons(&self) -> Vec<(String, Comparison)> {
        let comparison = |(name, value): (&String, &Value)| {
            Some((name.clone(), serde_json::from_value(value.clone()).ok()?))
        };
        self.comparisons.iter().filter_map(comparison).collect()
    }
}

/// `run.json`: what made the run.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Provenance {
    /// Version of mics.
    pub version: String,
    /// Git commit that it was built from.
    pub git_commit: String,
    /// The command line, word for word.
    pub command: Vec<String>,
    /// PETSc's version.
    pub petsc_version: String,
    /// PETSc's options in effect.
    pub petsc_options: String,
    /// Ranks.
    pub ranks: usize,
    /// The machine.
    pub host: String,
    /// The process of rank 0 on it.
    pub pid: u32,
    /// When it began (UTC).
    pub start: Option<String>,
    /// When it ended (UTC).
    pub end: Option<String>,
    /// The pressure solver in words.
    pub solver: String,
    /// Parts of the method that the scene needed or left out, each with its reason.
    pub needs: Vec<Need>,
}

/// A part of the method that a scene needs or leaves out.
#[derive(Clone, Debug, Default, Deserialize, serde::Serialize)]
pub struct Need {
    /// The part.
    pub what: String,
    /// Whether it is needed.
    pub needed: bool,
    /// The reason.
    pub why: String,
}

impl Provenance {
    /// Reads a run's `run.json`.
    ///
    /// # Errors
    /// When the folder holds no run.
    pub fn read(run: &Path) -> Result<Provenance> {
        read_json(&run.join("run.json"))
    }
}

fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let file = path.file_name().unwrap_or_default().display();
    let refuse = |why: String| not_a_run(path.parent().unwrap_or(path), &format!("{file}: {why}"));
    let text = fs::read_to_string(path).map_err(|e| refuse(e.to_string()))?;
    serde_json::from_str(&text).map_err(|e| refuse(e.to_string()))
}
