//! Where the time of a run goes: one sum per stage of the step.

use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::system::cpu_seconds;
use std::time::{Duration, Instant};

/// A stage of the step, or what surrounds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Density and viscosity of the mixture, (1).
    Properties,
    /// Refilling the pressure matrix.
    Assembly,
    /// Halo exchange and boundary conditions of velocities.
    Ghosts,
    /// Advection of (7), with the diffusion where the two are one pass.
    Advection,
    /// Diffusion of (7).
    Diffusion,
    /// Sums of the stages.
    Update,
    /// Faces (8) and cells (16).
    Faces,
    /// C-HSMAC (13-15).
    Pressure,
    /// Forces (19).
    Force,
    /// Particles' motion, through contacts where they have any.
    Contacts,
    /// Solid fractions of cells and faces.
    Particles,
    /// Mixing (27).
    Mixing,
    /// Choice of dt, logs, measures.
    Logs,
    /// Means over time.
    Statistics,
    /// Fields and figures.
    Fields,
}

/// Names of the stages, in the order of [`Stage`].
pub const NAMES: [&str; 15] = [
    "properties",
    "assembly",
    "ghosts",
    "advection",
    "diffusion",
    "update",
    "faces",
    "pressure",
    "force",
    "contacts",
    "particles",
    "mixing",
    "logs",
    "statistics",
    "fields",
];

/// A lap timer: each lap's time goes to the stage that it ends.
#[derive(Clone, Debug)]
pub struct Clock {
    last: Instant,
    spent: [Duration; NAMES.len()],
    steps: u64,
    /// CPU seconds of this process when the faces were done, and those that the pressure took.
    pressure: [f64; 2],
}

impl Default for Clock {
    fn default() -> Self {
        Clock { last: Instant::now(), spent: Default::default(), steps: 0, pressure: [0.0; 2] }
    }
}

impl Clock {
    /// Adds the time since the last lap on `stage`.
    pub fn lap(&mut self, stage: Stage) {
        let now = Instant::now();
        self.spent[stage as usize] += now - self.last;
        self.last = now;
        // Reading the CPU time takes half a microsecond, ten times as long as the time of day: it
        // is read where the pressure begins and ends alone.
        if let Stage::Faces | Stage::Pressure = stage {
            let [begun, spent] = &mut self.pressure;
            let cpu = cpu_seconds();
            *spent += if stage == Stage::Pressure { cpu - *begun } else { 0.0 };
            *begun = cpu;
        }
    }

    /// Seconds in a stage.
    pub fn spent(&self, stage: Stage) -> f64 {
        self.spent[stage as usize].as_secs_f64()
    }

    /// CPU seconds of this rank in the stage of the pressure.
    pub fn pressure_cpu(&self) -> f64 {
        self.pressure[1]
    }

    /// Counts a step.
    pub fn count(&mut self) {
        self.steps += 1;
    }

    /// Adds the counts of another clock, that of the part of the run before this one.
    pub fn add(&mut self, before: &Clock) {
        self.spent.iter_mut().zip(&before.spent).for_each(|(spent, before)| *spent += *before);
        self.steps += before.steps;
        self.pressure[1] += before.pressure[1];
    }

    /// Stages that took time, with nanoseconds a cell and step.
    pub fn table(&self, cells: usize) -> Vec<(&'static str, f64)> {
        let per = (cells as f64 * self.steps.max(1) as f64).recip() * 1e9;
        let rows = NAMES.iter().zip(&self.spent).filter(|(_, t)| !t.is_zero());
        rows.map(|(name, t)| (*name, t.as_secs_f64() * per)).collect()
    }
}

impl Checkpointed for Clock {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        for spent in &mut self.spent {
            let mut seconds = spent.as_secs_f64();
            seconds.serialize(archive)?;
            *spent = Duration::try_from_secs_f64(seconds).unwrap_or_default();
        }
        self.steps.serialize(archive)?;
        self.pressure[1].serialize(archive)
    }
}
