//! Records that a run writes as it goes, and when: rows, snapshots, lines of probes, progress, the
//! log. Rank 0 writes, and all ranks know of a failure.

use super::measures::Measures;
use super::schedule::Schedule;
use super::stepper::{StepOutcome, Stepper};
use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::clock::Stage;
use crate::config::{Case, FixedRows};
use crate::method::Traction;
use crate::output::progress::Progress;
use crate::output::{Folder, Log, Marks, StepRow, fields_file, snapshot};
use crate::particles::{Body, Motion, by_number};
use crate::petsc::Session;
use crate::scene::Passed;
use crate::scene::Scene;
use crate::state::State;
use mics_run::progress::Record;
use serde_json::Value;
use std::path::PathBuf;

/// The records of a run.
pub(super) struct Records<'a, const D: usize> {
    pub session: &'a Session,
    pub case: &'a Case,
    pub out: PathBuf,
    /// The run's folder, on rank 0.
    pub folder: Option<Folder>,
    pub log: Log,
    pub progress: Progress,
    pub measures: Measures<D>,
    pub written: Written,
    /// When snapshots are due, and rows of particles.
    pub fields: Schedule,
    pub particles: Schedule,
}

/// The newest of what has been written and need not be written twice.
#[derive(Clone, Copy, Debug, Default)]
pub struct Written {
    /// Time of the newest snapshot (s).
    pub fields: Option<f64>,
    /// Step of the newest rows of particles.
    pub rows: Option<u64>,
}

impl Checkpointed for Written {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        archive.serialize([&mut self.fields, &mut self.rows])
    }
}

impl<const D: usize> Records<'_, D> {
    /// Rank 0 writes; a failure there is a failure everywhere.
    fn on_lead(&mut self, write: impl FnOnce(&mut Folder, &mut Log) -> Result<()>) -> Result<()> {
        let written = self.folder.as_mut().map_or(Ok(()), |folder| write(folder, &mut self.log));
        self.session.agree(written)
    }

    /// Writes the state at time 0. Collective.
    pub fn write_start(&mut self, scene: &mut Scene<D>) -> Result<()> {
        self.write_particles(&scene.state)?;
        self.write_fields(scene)?;
        self.record(scene)
    }

    /// Writes a row of `steps.csv`, at so many seconds of the run. A failure is this rank's alone.
    pub fn write_row(&mut self, scene: &Scene<D>, outcome: &StepOutcome, wall: f64) -> Result<()> {
        let Some(folder) = &mut self.folder else { return Ok(()) };
        let s = &scene.state;
        let row = StepRow {
            step: s.steps,
            time: s.time,
            dt: outcome.dt,
            outer: outcome.projected.outer,
            krylov: outcome.projected.krylov,
            divergence_max: outcome.projected.divergence_max,
            cfl: outcome.cfl,
            kinetic_energy: s.energy.kinetic(),
            wall,
        };
        folder.write_step(&row, s)?;
        folder.write_solves(row.step, row.time, scene.domain.projection.solves())?;
        folder.flush_when_due(&mut self.log)
    }

    /// Writes what is due after a step beside its row. Collective.
    pub fn write_due(&mut self, scene: &mut Scene<D>, outcome: &StepOutcome) -> Result<()> {
        let step = scene.state.steps;
        let time = scene.state.time;
        if self.particles.due(step, time) {
            self.write_particles(&scene.state)?;
        }
        self.measures.sample(scene, outcome.speed)?;
        self.record(scene)?;
        self.show_progress(&scene.state, outcome);
        scene.domain.clock.lap(Stage::Logs);
        if self.fields.due(step, time) {
            self.write_fields(scene)?;
        }
        Ok(())
    }

    /// Writes the solves of a step of `dt` (s) that failed: they may show why.
    pub fn write_failed_solves(&mut self, stepper: &Stepper<D>, dt: f64) {
        if let Some(folder) = &mut self.folder {
            let solves = stepper.scene.domain.projection.solves();
            // The step's own failure is what counts.
            let _ = folder.write_solves(stepper.number(), stepper.began_at + dt, solves);
        }
    }

    /// Writes which bodies have passed the boundaries. Collective.
    pub fn write_passages(&mut self, state: &State<D>, passed: &Passed) -> Result<()> {
        for passage in &passed.passages {
            let time = state.time;
            let body = &passage.body;
            self.on_lead(|folder, log| {
                let passes = if passage.what == "entered" { "came in" } else { passage.what };
                log.say(&format!("particle {} {passes} at t = {time:.6} s", body.id));
                folder.write_passage(state.steps, time, passage.what, body)
            })?;
        }
        Ok(())
    }

    /// Writes the rows of the particles, unless this step has them. Collective.
    fn write_particles(&mut self, s: &State<D>) -> Result<()> {
        if self.written.rows == Some(s.steps) {
            return Ok(());
        }
        self.written.rows = Some(s.steps);
        let rule = self.case.coupling.wall.force();
        let fixed = self.case.output.fixed_rows();
        self.on_lead(|folder, _| {
            let shown = |body: &Body| {
                let rests = body.motion == Motion::Fixed && !body.is_obstacle();
                !rests || fixed == FixedRows::Always || s.steps == 0
            };
            let rows = by_number(&s.bodies).into_iter().map(|k| (&s.bodies[k], &s.exchange[k]));
            let rows = rows.filter(|(body, _)| shown(body));
            folder.write_bodies(s.steps, s.time, rows, rule)
        })
    }

    /// Writes a snapshot, unless there is one of this time. Collective.
    pub fn write_last_fields(&mut self, scene: &mut Scene<D>) -> Result<()> {
        match self.written.fields == Some(scene.state.time) {
            true => Ok(()),
            false => self.write_fields(scene),
        }
    }

    /// Writes a snapshot. Collective.
    fn write_fields(&mut self, scene: &mut Scene<D>) -> Result<()> {
        let path = self.out.join("fields").join(fields_file(scene.state.steps));
        snapshot::write(scene, &path)?;
        self.written.fields = Some(scene.state.time);
        self.measures.take_fields(scene)?;
        // A figure of the fields shows the particles where they are.
        self.write_particles(&scene.state)?;
        let tractions = if self.case.output.surfaces {
            let own = scene.method.tractions(&mut scene.domain, &mut scene.state)?;
            Traction::gather(self.session, scene.state.bodies.len(), &own)?
        } else {
            Vec::new()
        };
        let s = &scene.state;
        self.on_lead(|folder, log| {
            folder.take_snapshot(s.steps, s.time, &s.bodies, &s.exchange, &tractions)?;
            folder.flush(log)
        })?;
        scene.domain.clock.lap(Stage::Fields);
        Ok(())
    }

    /// Takes the state into statistics, and writes the lines of the probes. Collective.
    fn record(&mut self, scene: &mut Scene<D>) -> Result<()> {
        let folder = &mut self.folder;
        let mut written = Ok(());
        self.measures.record(scene, |line| {
            if let (Some(folder), Ok(())) = (folder.as_mut(), &written) {
                written = folder.write_probe(line);
            }
            Ok(())
        })?;
        written
    }

    /// Shows how far the run is, where that is due, after a step.
    fn show_progress(&mut self, state: &State<D>, outcome: &StepOutcome) {
        if self.progress.due() {
            let measures = self.measures.values();
            let line = self.progress.take(Record {
                end: self.case.time.end,
                measures,
                ..outcome.progress(state)
            });
            line.into_iter().for_each(|line| self.log.say(&line));
        }
    }

    /// Writes a JSON file of the run. Collective.
    pub fn write_json(&mut self, name: &str, value: &Value) -> Result<()> {
        self.on_lead(|folder, _| folder.write_json(name, value))
    }

    /// Says why the run ends, which the program does on standard error, in the log.
    pub fn keep_error(&mut self, words: &str) {
        self.log.keep(words);
        let _ = self.on_lead(|folder, log| folder.flush(log));
    }

    /// Brings all that is written so far to the disk, and says how far it has come. Collective.
    pub fn mark(&mut self) -> Result<Marks> {
        let marked = self
            .folder
            .as_mut()
            .map_or(Ok(Marks::default()), |folder| folder.mark(&mut self.log, &self.progress));
        self.session.agree(marked)
    }
}
