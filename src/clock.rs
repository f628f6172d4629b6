//! Where the time of a run goes: one sum per stage of the step.

use crate::Result;
use crate::archive::{Archive, Checkpointed};
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
    /// Their fractions, and what they cover.
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
}

impl Default for Clock {
    fn default() -> Self {
        Clock { last: Instant::now(), spent: Default::default(), steps: 0 }
    }
}

impl Clock {
    /// Adds the time since the last lap on `stage`.
    pub fn lap(&mut self, stage: Stage) {
        let now = Instant::now();
        self.spent[stage as usize] += now - self.last;
        self.last = now;
    }

    /// Counts a step.
    pub fn count(&mut self) {
        self.steps += 1;
    }

    /// Adds what another one has counted: that of the part of a run that this one goes on with.
    pub fn add(&mut self, before: &Clock) {
        self.spent.iter_mut().zip(&before.spent).for_each(|(spent, before)| *spent += *before);
        self.steps += before.steps;
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
        self.steps.serialize(archive)
    }
}
