//! What a run writes as it goes: rows, snapshots, samples of measures and probes, `run.json`.
//! Rank 0 writes, and all ranks know of a failure.

use super::restart::Restart;
use super::{Run, StepOutcome, Wishes};
use crate::clock::Stage;
use crate::config::FixedRows;
use crate::output::measure::Series;
use crate::output::{Folder, Log, StepRow, fields_file, snapshot};
use crate::particles::{Body, Motion};
use crate::scene::Scene;
use crate::system::host;
use crate::{Error, Result};
use serde_json::{Map, Value, json};

impl<const D: usize> Run<'_, D> {
    /// Writes a row of `steps.csv`; what ranks wish for is agreed on with it.
    pub(super) fn write_row(&mut self, outcome: StepOutcome) -> Result<Wishes> {
        let row = StepRow {
            step: self.scene.state.steps,
            time: self.scene.state.time,
            dt: outcome.dt,
            outer: outcome.projected.outer,
            krylov: outcome.projected.krylov,
            divergence_max: outcome.projected.divergence_max,
            cfl: outcome.cfl,
            kinetic_energy: self.scene.state.energy.kinetic(),
            wall: self.wall(),
        };
        let scene = &self.scene;
        let log = &mut self.log;
        let written = self.folder.as_mut().map_or(Ok(()), |folder| {
            let s = &scene.state;
            folder.write_step(&row, s)?;
            folder.write_solves(row.step, row.time, scene.domain.projection.solves())?;
            folder.flush_when_due(log)
        });
        // One message for all three, every step.
        let flags = [written.is_err(), self.interrupt.asked(), self.checkpoints.due(row.step)];
        let mut anywhere = flags.map(f64::from);
        self.session.max(&mut anywhere)?;
        let [failed, stop, checkpoint] = anywhere.map(|flag| flag > 0.0);
        written?;
        if failed {
            Err(Error::Run("rank 0 failed".into()))
        } else {
            Ok(Wishes { stop, checkpoint })
        }
    }

    /// Writes the solves of a step of `dt` (s) that failed: they may show why.
    pub(super) fn write_failed_solves(&mut self, dt: f64) {
        let (steps, time) = self.began;
        if let Some(folder) = &mut self.folder {
            // The step's own failure is what counts.
            let solves = self.scene.domain.projection.solves();
            let _ = folder.write_solves(steps + 1, time + dt, solves);
        }
    }

    /// Seconds that the run has taken, in all its sessions.
    pub(super) fn wall(&self) -> f64 {
        self.account.wall + self.started.elapsed().as_secs_f64()
    }

    pub(super) fn write_particles(&mut self) -> Result<()> {
        if self.account.last_rows == Some(self.scene.state.steps) {
            return Ok(());
        }
        self.account.last_rows = Some(self.scene.state.steps);
        let rule = self.case.coupling.wall.force();
        let fixed = self.case.output.fixed_rows();
        self.on_lead(|folder, scene, _| {
            let s = &scene.state;
            let shown = |body: &Body| {
                let rests = body.motion == Motion::Fixed && !body.is_obstacle();
                !rests || fixed == FixedRows::Always || s.steps == 0
            };
            let rows = s.bodies.iter().zip(&s.exchange).filter(|(body, _)| shown(body));
            folder.write_bodies(s.steps, s.time, rows, rule)
        })
    }

    pub(super) fn write_fields(&mut self) -> Result<()> {
        let path = self.out.join("fields").join(fields_file(self.scene.state.steps));
        snapshot::write(&mut self.scene, &path)?;
        self.account.last_fields = Some(self.scene.state.time);
        self.series.iter_mut().try_for_each(|s| s.take_fields(&self.scene))?;
        // A figure of the fields shows the particles where they are.
        self.write_particles()?;
        self.on_lead(|folder, scene, log| {
            let s = &scene.state;
            folder.take_snapshot(s.steps, s.time, &s.bodies, &s.exchange)?;
            folder.flush(log)
        })?;
        self.scene.domain.clock.lap(Stage::Fields);
        Ok(())
    }

    /// Rank 0 writes; a failure there is a failure everywhere.
    pub(super) fn on_lead(
        &mut self,
        write: impl FnOnce(&mut Folder, &Scene<D>, &mut Log) -> Result<()>,
    ) -> Result<()> {
        let written =
            self.folder.as_mut().map_or(Ok(()), |folder| write(folder, &self.scene, &mut self.log));
        self.session.agree(written)
    }

    /// Gives every measure the state after a step; the one at time 0 has exchanged nothing yet.
    pub(super) fn sample(&mut self, speed: f64) -> Result<()> {
        if self.scene.state.steps > 0 {
            let mut series = self.series.iter_mut();
            series.try_for_each(|series| series.take(&self.scene, speed))?;
        }
        Ok(())
    }

    /// Statistics and probes.
    pub(super) fn record(&mut self) -> Result<()> {
        if let Some(statistics) = &mut self.statistics {
            statistics.take(&mut self.scene);
        }
        let folder = &mut self.folder;
        let mut written = Ok(());
        self.probes.record(&mut self.scene, |line| {
            if let (Some(folder), Ok(())) = (folder.as_mut(), &written) {
                written = folder.write_probe(line);
            }
            Ok(())
        })?;
        written
    }

    /// The measures that have a value so far, by name.
    pub(super) fn values(&self) -> Map<String, Value> {
        self.table(|series| Some(json!(series.value()?)))
    }

    /// What measures give of something, by name.
    pub(super) fn table(&self, of: impl Fn(&Series) -> Option<Value>) -> Map<String, Value> {
        let row = |series: &Series| Some((series.name().to_owned(), of(series)?));
        self.series.iter().filter_map(row).collect()
    }

    /// Writes `run.json`: the program, the machine and the solver; `ended` is the time of day.
    pub(super) fn write_run(&mut self, ended: Option<&str>) -> Result<()> {
        let options = self.session.options()?;
        let solver = self.scene.solver()?;
        let words: Vec<String> = std::env::args().collect();
        let record = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "git_commit": self.commit,
            "command": words,
            "petsc_version": self.session.version(),
            "petsc_options": options,
            "ranks": self.session.size(),
            "host": host(), "pid": std::process::id(), "start": self.account.began, "end": ended,
            "resumed_after_step": self.restart.as_ref().map(Restart::step),
            "solver": solver,
            "needs": self.scene.needs(),
        });
        self.on_lead(|folder, _, _| folder.write_json("run.json", &record))
    }
}
