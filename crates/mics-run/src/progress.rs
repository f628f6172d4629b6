//! Progress of a run: the records of `progress.jsonl`.

use crate::words::minutes;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::path::Path;

/// The file's name in a run's folder.
pub const FILE: &str = "progress.jsonl";

/// Progress of a run: a line of `progress.jsonl`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Record {
    /// `running`, and in the last record how the run ended: `done`, `failed`, `interrupted`.
    pub status: String,
    /// Step count.
    pub step: u64,
    /// Time of the flow (s).
    pub time: f64,
    /// When the run ends (s).
    pub end: f64,
    /// The newest step (s).
    pub dt: Option<f64>,
    /// Steps a second.
    pub rate: f64,
    /// Wall-clock seconds left, as guessed from those spent; none before the first step.
    pub left: Option<f64>,
    /// Largest |D| of the newest step (1/s).
    pub divergence: f64,
    /// Largest speed of the fluid (m/s).
    pub largest_speed: f64,
    /// Values of the measures so far.
    pub measures: Map<String, Value>,
    /// The process that runs it, on rank 0.
    pub pid: u32,
}

impl Record {
    /// The newest one of a run's folder; none where there is no whole line.
    pub fn newest(folder: &Path) -> Option<Record> {
        let text = std::fs::read_to_string(folder.join(FILE)).ok()?;
        text.lines().rev().find_map(|line| serde_json::from_str(line).ok())
    }

    /// The part of the time to the end that has gone.
    pub fn done(&self) -> f64 {
        if self.end > 0.0 { (self.time / self.end).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The record in a line, as the bar says it.
    pub fn describe(&self) -> String {
        let dt = self.dt.map_or(String::new(), |dt| format!(" dt {dt:.2e} s,"));
        let left = self.left.map_or(String::new(), |left| format!(", {} left", minutes(left)));
        format!(
            "t = {:.4} s, step {},{dt} |D| {:.1e}, {:.0} steps/s{left}",
            self.time, self.step, self.divergence, self.rate
        )
    }

    /// The part done and the record, in a line.
    pub fn line(&self) -> String {
        format!("{:>3.0} %  {}", 100.0 * self.done(), self.describe())
    }
}

/// Progress of the run in a folder by its newest record, in a line; `None` before the first one.
pub fn newest(run: &Path) -> Option<String> {
    Record::newest(run).map(|record| record.line().trim_start().to_owned())
}
