//! Disk space that a run's folder will take.
//!
//! ```text
//!   fields/ snapshots      the first, the last, and one whenever it is due
//!   checkpoint/            the newest two
//!   steps.csv, particles.csv     a row a step; a row a particle whenever it is due
//!   solves.csv             a row an iteration of the solves of the steps whose history is kept
//! ```

use crate::Result;
use crate::archive::{Archive, Target};
use crate::config::{Cadence, Case, FixedRows, Motion};
use crate::output::snapshot;
use crate::petsc::Session;
use crate::scene::Scene;
use crate::words::{size, whole};
use std::io;

/// Bytes of a row of `steps.csv`, and of a particle that moves in `particles.csv`, in 2D and 3D, as
/// they are in most runs.
const STEP_ROW: f64 = 460.0;
const PARTICLE_ROW: [f64; 2] = [480.0, 750.0];
/// Bytes of a row of `solves.csv`, as they are in most runs.
const SOLVE_ROW: f64 = 160.0;
/// Checkpoints that are kept, and the one that is being written.
const CHECKPOINTS: f64 = 3.0;

/// Counts what is written.
struct Counter(f64);

impl Target for Counter {
    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0 += bytes.len() as f64;
        Ok(())
    }

    fn put_parts(&mut self, session: &Session, mine: &[u8]) -> Result<()> {
        let mut all = [mine.len() as f64];
        session.sum(&mut all)?;
        self.0 += all[0];
        Ok(())
    }
}

/// Content of the folder of a run of so many steps, at most.
pub struct Disk {
    /// Snapshots of the fields.
    pub snapshots: f64,
    /// Bytes of one.
    pub snapshot: f64,
    /// Bytes of a checkpoint.
    pub checkpoint: f64,
    /// Bytes of `particles.csv`.
    pub particles: f64,
    /// Bytes of `solves.csv`; `None` where no history is kept.
    pub solves: Option<f64>,
    /// Bytes of all.
    pub all: f64,
}

/// Estimates what the folder of a run of so many steps will hold, whose solves have so many
/// `solve_rows` a step. Collective.
pub fn expected<const D: usize>(
    case: &Case,
    scene: &mut Scene<D>,
    steps: f64,
    solve_rows: f64,
) -> Result<Disk> {
    let due = |cadence: &Cadence| match cadence {
        Cadence::Steps(n) => (steps / *n as f64).floor(),
        Cadence::Time(time) => (case.time.end / time).floor().min(steps),
    };
    let snapshot = snapshot::bytes(scene)?;
    // The last state may be due as well, and counts once.
    let beside_ends = |cadence: &Cadence| {
        let times = match cadence {
            Cadence::Time(time) => case.time.end / time,
            Cadence::Steps(n) => steps / *n as f64,
        };
        ((times * (1.0 - 1e-9)).ceil() - 1.0).clamp(0.0, steps)
    };
    let snapshots = 2.0 + case.output.fields.as_ref().map_or(0.0, beside_ends);
    let mut checkpoint = Counter(0.0);
    let domain = &scene.domain;
    let mut archive = Archive::write(&domain.session, &mut checkpoint);
    scene.state.serialize(&domain.grid, &mut archive)?;
    archive.finish()?;
    let has_rows = |motion: &Motion| {
        !matches!((motion, case.output.fixed_rows()), (Motion::Fixed, FixedRows::Once))
    };
    let moving = case.particle.iter().filter(|p| has_rows(&p.motion)).count() as f64;
    let particles = PARTICLE_ROW[D - 2] * moving * (1.0 + due(&case.output.rows()));
    let solves = case.pressure.history.cadence().map(|often| SOLVE_ROW * solve_rows * due(&often));
    let all = snapshot * snapshots
        + CHECKPOINTS * checkpoint.0
        + particles
        + solves.unwrap_or(0.0)
        + STEP_ROW * steps;
    Ok(Disk { snapshots, snapshot, checkpoint: checkpoint.0, particles, solves, all })
}

/// Words on the output of a run: the folder, how often, how many and how much.
pub fn describe(case: &Case, disk: &Disk) -> String {
    let fields = case.output.fields.as_ref();
    let fields = fields.map_or("of the first and the last state".to_owned(), Cadence::describe);
    let mut words = format!(
        "output       into runs/{}, unless --out names another folder: fields {fields}, {} \
        snapshots of {}",
        case.name,
        whole(disk.snapshots),
        size(disk.snapshot)
    );
    if !case.particle.is_empty() {
        let often = case.output.rows().describe();
        words += &format!("; particles.csv {often}, {}", size(disk.particles));
    }
    if let Some((history, bytes)) = case.pressure.history.cadence().zip(disk.solves) {
        words += &format!("; solves.csv {}, {}", history.describe(), size(bytes));
    }
    let kept = size(disk.checkpoint);
    let often = case.output.checkpoint.describe();
    words + &format!("; a checkpoint {often}, of which two of {kept} are kept")
}
