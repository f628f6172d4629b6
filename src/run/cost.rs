//! Cost of a run: its counts over all its sessions, and what this session spends.

use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::clock::Clock;
use crate::petsc::{Session, Traffic};
use crate::poisson::pressure::Projected;
use crate::scene::{self, Scene};
use crate::system::{cpu_seconds, now, peak_memory};
use std::time::Instant;

/// Counts of a run so far, over all its sessions.
#[derive(Clone, Debug, Default)]
pub struct Account {
    /// When it began, in words.
    pub began: String,
    /// Seconds that it took before this session, those of all cores, and where they went.
    pub wall: f64,
    #[allow(missing_docs)]
    pub cpu: f64,
    #[allow(missing_docs)]
    pub clock: Clock,
    /// Largest |D| (1/s).
    pub divergence_max: f64,
    /// C-HSMAC iterations, Krylov iterations, solves that were repeated, setups of the
    /// preconditioner.
    pub outer: u64,
    #[allow(missing_docs)]
    pub krylov: u64,
    #[allow(missing_docs)]
    pub retries: u64,
    #[allow(missing_docs)]
    pub setups: u64,
    /// The last step (s).
    pub dt: Option<f64>,
}

impl Account {
    /// The account of a run that begins now.
    pub(super) fn begin() -> Account {
        Account { began: now(), ..Account::default() }
    }

    /// Counts a step of `dt` (s).
    pub(super) fn count(&mut self, dt: f64, projected: &Projected) {
        self.dt = Some(dt);
        self.divergence_max = self.divergence_max.max(projected.divergence_max);
        self.outer += u64::from(projected.outer);
        self.krylov += u64::from(projected.krylov);
        self.retries += u64::from(projected.retries);
        self.setups += u64::from(projected.setups);
    }
}

impl Checkpointed for Account {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Account { began, wall, cpu, clock, divergence_max, outer, krylov, .. } = self;
        archive.label("run")?;
        archive.serialize([began, wall, cpu, clock, divergence_max, outer, krylov])?;
        archive.serialize([&mut self.retries, &mut self.setups, &mut self.dt])
    }
}

/// The account of a run, and where this session's part of it began.
pub(super) struct Cost {
    /// The counts so far; the seconds are those before this session.
    pub account: Account,
    started: Instant,
    /// Steps done, and messages that this rank had sent, when the time loop began.
    steps: u64,
    traffic: Traffic,
}

/// Cost of a run, over all ranks.
pub(super) struct Totals {
    /// Seconds that the run took, in all its sessions.
    pub wall: f64,
    /// Seconds of all cores.
    pub cpu: f64,
    /// CPU seconds of the pressure.
    pub pressure_cpu: f64,
    /// Steps of all sessions, one at least.
    pub steps: f64,
    /// Time of each stage (ns for each cell and step).
    pub stages: Vec<(&'static str, f64)>,
    pub cells: usize,
    /// Peak memory of all ranks (bytes).
    pub memory: f64,
    pub busiest: Busiest,
}

/// The largest of all ranks, in this session: messages a step and memory.
pub(super) struct Busiest {
    pub collectives: f64,
    pub collective_bytes: f64,
    pub messages: f64,
    pub message_bytes: f64,
    /// Peak memory (bytes).
    pub memory: f64,
}

impl Cost {
    /// The cost of a run from now on, with its account of earlier sessions.
    pub fn new(account: Account) -> Cost {
        Cost { account, started: Instant::now(), steps: 0, traffic: Traffic::default() }
    }

    /// Counts messages from now on, after so many steps.
    pub fn begin(&mut self, session: &Session, steps: u64) {
        self.steps = steps;
        self.traffic = session.traffic();
    }

    /// Seconds that the run has taken, in all its sessions.
    pub fn wall(&self) -> f64 {
        self.account.wall + self.started.elapsed().as_secs_f64()
    }

    /// The account with what this session has spent so far, of all ranks; `clock` says where it
    /// went. Collective.
    pub fn so_far(&self, session: &Session, clock: &Clock) -> Result<Account> {
        let mut cpu = [cpu_seconds()];
        session.sum(&mut cpu)?;
        Ok(Account {
            wall: self.wall(),
            cpu: self.account.cpu + cpu[0],
            clock: clock.clone(),
            ..self.account.clone()
        })
    }

    /// Sums up what all ranks spent. Collective.
    pub fn totals<const D: usize>(&self, session: &Session, scene: &Scene<D>) -> Result<Totals> {
        let told = (session.traffic() - self.traffic).numbers();
        let mut most = [&told[..], &[peak_memory()]].concat();
        let mut used = [peak_memory(), cpu_seconds(), scene.domain.clock.pressure_cpu()];
        session.sum(&mut used)?;
        session.max(&mut most)?;
        let [memory, cpu, pressure_cpu] = used;
        let stepped = (scene.state.steps - self.steps).max(1) as f64;
        Ok(Totals {
            wall: self.wall(),
            cpu: self.account.cpu + cpu,
            pressure_cpu,
            steps: scene.state.steps.max(1) as f64,
            stages: scene::stages(scene),
            cells: scene.domain.grid.total_cells(),
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
}
