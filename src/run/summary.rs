//! The end of a run: what it came to, in words and in `summary.json`, and its figures.

use super::{Run, energy_bound};
use crate::Result;
use crate::output::measure::Series;
use crate::system::{cpu_seconds, now, peak_memory};
use mics_run::compare::measured;
use serde_json::{Map, Value, json};

/// What all ranks spent.
struct Totals {
    /// Seconds that the run took, in all its sessions.
    wall: f64,
    /// Seconds of all cores.
    cpu: f64,
    /// Those of the pressure.
    pressure_cpu: f64,
    /// Steps of all sessions, one at least.
    steps: f64,
    /// Time of each stage (ns for each cell and step).
    stages: Vec<(&'static str, f64)>,
    cells: usize,
    /// Peak memory of all ranks (bytes).
    memory: f64,
    busiest: Busiest,
}

/// The largest of all ranks, in this session: messages a step and memory.
struct Busiest {
    collectives: f64,
    collective_bytes: f64,
    messages: f64,
    message_bytes: f64,
    /// Peak memory (bytes).
    memory: f64,
}

impl<const D: usize> Run<'_, D> {
    /// Closes the logs, sums up and draws. Collective.
    ///
    /// # Errors
    /// When ranks cannot sum, or the folder cannot be written.
    pub(super) fn close(&mut self, status: &str) -> Result<()> {
        if let Some(statistics) = self.statistics.as_ref().filter(|_| status != "failed") {
            statistics.write(&self.scene, &self.out)?;
        }
        let totals = self.totals()?;
        let unused = self.session.unused_options()?;
        self.write_run(Some(&now()))?;
        if self.folder.is_none() {
            return Ok(());
        }
        let mut notes = self.energy_notes(status);
        if !unused.is_empty() {
            let why =
                if self.account.krylov == 0 { ", since no pressure was solved for" } else { "" };
            notes.push(format!("PETSc options that nothing used{why}: {}", unused.join(", ")));
        }
        // Remarks stand beside their measures on the screen.
        let summary = self.summary(status, &totals, [&notes[..], &self.doubts(status)].concat());
        self.say_cost(&totals);
        if !self.scene.state.waiting.is_empty() {
            let count = self.scene.state.waiting.len();
            let cure = "their time had not come, or their place was never free";
            self.log.say(&format!("{count} of the particles never came in: {cure}"));
        }
        notes.iter().for_each(|note| self.log.say(note));
        self.say_measures();
        let Some(folder) = &mut self.folder else { return Ok(()) };
        folder.write_json("summary.json", &summary)?;
        folder.flush(&mut self.log)?;
        if status == "done" && self.case.output.figures {
            for path in (self.draw)(&self.out)? {
                self.log.say(&format!("figure {}", path.display()));
            }
        }
        folder.flush(&mut self.log)
    }

    /// Sums up what all ranks spent. Collective.
    fn totals(&self) -> Result<Totals> {
        let (before, told) = self.before;
        let mut most = [&(self.session.traffic() - told).numbers()[..], &[peak_memory()]].concat();
        let mut used = [peak_memory(), cpu_seconds(), self.scene.domain.clock.pressure_cpu()];
        self.session.sum(&mut used)?;
        self.session.max(&mut most)?;
        let [memory, cpu, pressure_cpu] = used;
        let stepped = (self.scene.state.steps - before).max(1) as f64;
        Ok(Totals {
            wall: self.wall(),
            cpu: self.account.cpu + cpu,
            pressure_cpu,
            steps: self.scene.state.steps.max(1) as f64,
            stages: self.scene.stages(),
            cells: self.scene.domain.grid.total_cells(),
            memory,
            busiest: Busiest {
                collectives: most[0] / stepped,
                collective_bytes: most[1] / stepped,
                messages: most[2] / stepped,
                message_bytes: most[3] / stepped,
                memory: most[4],
            },
        })
    }

    /// Doubts about the budget of energy.
    fn energy_notes(&self, status: &str) -> Vec<String> {
        let domain = &self.scene.domain;
        let state = &self.scene.state;
        let made = energy_bound::doubt(state, energy_bound::settling(domain, &state.bodies));
        let notes = [
            made.filter(|_| status == "done"),
            energy_bound::bounded(state),
            energy_bound::lost(self.case, state),
        ];
        notes.into_iter().flatten().collect()
    }

    /// Doubts about measures of a run that is done.
    fn doubts(&self, status: &str) -> Vec<String> {
        let remarks = self.series.iter().filter_map(|s| Some((s.name(), s.remark()?)));
        let doubts = remarks.filter(|(_, remark)| remark.doubt && status == "done");
        doubts.map(|(name, remark)| format!("{name} {}", remark.words)).collect()
    }

    /// The content of `summary.json`.
    fn summary(&self, status: &str, totals: &Totals, notes: Vec<String>) -> Value {
        let Totals { wall, cpu, pressure_cpu, steps, cells, memory, busiest, stages } = totals;
        let Busiest { collectives, collective_bytes, messages, message_bytes, .. } = busiest;
        json!({
            "notes": notes,
            "case": self.case.name,
            "status": status,
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
            "measures": self.values(),
            "comparisons": self.table(|s| Some(json!(s.comparison()?))),
            "units": self.table(|s| Some(json!(s.unit(D)))),
            "remarks": self.table(|s| Some(json!(s.remark()?.words))),
            "stages_ns_per_cell_step":
                stages.iter().map(|(n, t)| ((*n).to_owned(), json!(t))).collect::<Map<_, _>>(),
            "peak_memory_bytes": memory, "peak_memory_bytes_per_cell": memory / *cells as f64,
            "ranks": self.session.size(),
            "busiest_rank": {
                "collectives_per_step": collectives,
                "collective_bytes_per_step": collective_bytes,
                "messages_per_step": messages,
                "message_bytes_per_step": message_bytes,
                "peak_memory_bytes": busiest.memory,
            },
        })
    }

    /// Says what the run cost: its stages, steps, memory, iterations and messages.
    fn say_cost(&mut self, totals: &Totals) {
        let Totals { wall, steps, cells, memory, busiest, stages, .. } = totals;
        let all: f64 = stages.iter().map(|s| s.1).sum();
        self.log.say("");
        self.log.say("stage          ns per cell and step    share");
        for (name, ns) in stages {
            self.log.say(&format!("{name:<14} {ns:>12.1} {:>19.1} %", 100.0 * ns / all));
        }
        self.log.say(&format!("{:<14} {all:>12.1}", "all"));
        self.log.say("");
        self.log.say(&format!(
            "{} steps in {wall:.1} s, {:.2} ms a step; peak memory {:.0} MB, {:.0} bytes a cell",
            self.scene.state.steps,
            1e3 * wall / steps,
            memory / 1e6,
            memory / *cells as f64
        ));
        let account = &self.account;
        let repeated = match account.retries {
            0 => String::new(),
            retries => format!(", {retries} solves repeated"),
        };
        self.log.say(&format!(
            "C-HSMAC {:.2} and Krylov {:.2} iterations and {:.2} preconditioner setups a step\
            {repeated}; largest |D| {:.2e} 1/s, limit {:.0e}",
            account.outer as f64 / steps,
            account.krylov as f64 / steps,
            account.setups as f64 / steps,
            account.divergence_max,
            self.case.pressure.divergence_limit
        ));
        if self.session.size() > 1 {
            self.log.say(&format!(
                "{} ranks; the busiest: {:.0} collectives ({:.1} kB) and {:.0} messages ({:.1} kB) \
                a step, {:.0} MB",
                self.session.size(),
                busiest.collectives,
                busiest.collective_bytes / 1e3,
                busiest.messages,
                busiest.message_bytes / 1e3,
                busiest.memory / 1e6
            ));
        }
    }

    /// Says what each measure gives, beside its reference.
    fn say_measures(&mut self) {
        let line = |series: &Series| {
            let name = series.name();
            let Some(value) = series.value() else {
                return format!(
                    "{name}: the run gives no value (no oscillation, no contact, a particle that \
                    was not there, or no steps after `from`)"
                );
            };
            let value = format!("{name} = {} {}", measured(value), series.unit(D));
            let beside = series.comparison().map(|comparison| format!(", {comparison}"));
            let remark = series.remark().map(|remark| format!("; {}", remark.words));
            let beside = beside.unwrap_or_default();
            let remark = remark.unwrap_or_default();
            format!("{}{beside}{remark}", value.trim_end())
        };
        let lines: Vec<String> = self.series.iter().map(line).collect();
        lines.iter().for_each(|line| self.log.say(line));
    }
}
