//! The end of a run: what it came to, in words and in `summary.json`.

use super::cost::{Account, Busiest, Totals};
use super::energy_bound;
use super::measures::Measures;
use crate::config::Case;
use crate::scene::Scene;
use serde_json::{Map, Value, json};

/// A run that has ended, and what it has to say.
pub(super) struct Summary<'r, const D: usize> {
    pub status: &'r str,
    pub case: &'r Case,
    pub scene: &'r Scene<D>,
    pub account: &'r Account,
    pub measures: &'r Measures<D>,
    pub totals: Totals,
    pub ranks: usize,
}

impl<const D: usize> Summary<'_, D> {
    /// Doubts about the budget of energy, and PETSc's options that nothing has used.
    pub fn notes(&self, unused: &[String]) -> Vec<String> {
        let state = &self.scene.state;
        let settling = energy_bound::settling(&self.scene.domain, &state.bodies);
        let notes = [
            energy_bound::doubt(state, settling).filter(|_| self.status == "done"),
            energy_bound::bounded(state),
            energy_bound::lost(self.case, state),
        ];
        let mut notes: Vec<String> = notes.into_iter().flatten().collect();
        if !unused.is_empty() {
            let solved = self.account.krylov > 0;
            let why = if solved { "" } else { ", since no pressure was solved for" };
            notes.push(format!("PETSc options that nothing used{why}: {}", unused.join(", ")));
        }
        notes
    }

    /// The content of `summary.json`; doubts about measures follow the notes.
    pub fn json(&self, notes: &[String]) -> Value {
        let Totals { wall, cpu, pressure_cpu, steps, cells, memory, busiest, stages } =
            &self.totals;
        let Busiest { collectives, collective_bytes, messages, message_bytes, .. } = busiest;
        let doubts = if self.status == "done" { self.measures.doubts() } else { Vec::new() };
        let notes = [notes, &doubts].concat();
        json!({
            "notes": notes,
            "case": self.case.name,
            "status": self.status,
            "cells": cells,
            "steps": self.scene.state.steps,
            "time": self.scene.state.time,
            "wall_seconds": wall,
            "cpu_seconds": cpu,
            "pressure_cpu_seconds": pressure_cpu,
            "step_seconds": wall / steps,
            "divergence_max": self.account.divergence_max,
            "divergence_limit": self.case.pressure.divergence_limit,
            "outer_iterations": self.account.outer,
            "krylov_iterations": self.account.krylov,
            "solver_retries": self.account.retries,
            "preconditioner_setups": self.account.setups,
            "measures": self.measures.values(),
            "comparisons": self.measures.table(|s| Some(json!(s.comparison()?))),
            "units": self.measures.table(|s| Some(json!(s.unit(D)))),
            "remarks": self.measures.table(|s| Some(json!(s.remark()?.words))),
            "stages_ns_per_cell_step":
                stages.iter().map(|(n, t)| ((*n).to_owned(), json!(t))).collect::<Map<_, _>>(),
            "peak_memory_bytes": memory, "peak_memory_bytes_per_cell": memory / *cells as f64,
            "ranks": self.ranks,
            "busiest_rank": {
                "collectives_per_step": collectives,
                "collective_bytes_per_step": collective_bytes,
                "messages_per_step": messages,
                "message_bytes_per_step": message_bytes,
                "peak_memory_bytes": busiest.memory,
            },
        })
    }

    /// Cost of the run, in lines: its stages, steps, memory, iterations and messages.
    pub fn cost_lines(&self) -> Vec<String> {
        let Totals { wall, steps, cells, memory, busiest, stages, .. } = &self.totals;
        let all: f64 = stages.iter().map(|s| s.1).sum();
        let mut lines =
            vec![String::new(), "stage          ns per cell and step    share".to_owned()];
        lines.extend(
            stages
                .iter()
                .map(|(name, ns)| format!("{name:<14} {ns:>12.1} {:>19.1} %", 100.0 * ns / all)),
        );
        lines.push(format!("{:<14} {all:>12.1}", "all"));
        lines.push(String::new());
        lines.push(format!(
            "{} steps in {wall:.1} s, {:.2} ms a step; peak memory {:.0} MB, {:.0} bytes a cell",
            self.scene.state.steps,
            1e3 * wall / steps,
            memory / 1e6,
            memory / *cells as f64
        ));
        let account = self.account;
        let repeated = match account.retries {
            0 => String::new(),
            retries => format!(", {retries} solves repeated"),
        };
        lines.push(format!(
            "C-HSMAC {:.2} and Krylov {:.2} iterations and {:.2} preconditioner setups a step\
            {repeated}; largest |D| {:.2e} 1/s, limit {:.0e}",
            account.outer as f64 / steps,
            account.krylov as f64 / steps,
            account.setups as f64 / steps,
            account.divergence_max,
            self.case.pressure.divergence_limit
        ));
        if self.ranks > 1 {
            lines.push(format!(
                "{} ranks; the busiest: {:.0} collectives ({:.1} kB) and {:.0} messages ({:.1} kB) \
                a step, {:.0} MB",
                self.ranks,
                busiest.collectives,
                busiest.collective_bytes / 1e3,
                busiest.messages,
                busiest.message_bytes / 1e3,
                busiest.memory / 1e6
            ));
        }
        lines
    }

    /// A line on bodies that never came in.
    pub fn outside(&self) -> Option<String> {
        let count = self.scene.state.waiting.len();
        let cure = "their time had not come, or their place was never free";
        (count > 0).then(|| format!("{count} of the particles never came in: {cure}"))
    }
}
