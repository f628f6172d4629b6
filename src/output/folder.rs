//! A run's folder: who may use it, its logs, its snapshots and its summary. Lives on rank 0.

mod log;
mod permission;
mod tables;

use super::progress::Progress;
use super::rows::Rows;
use super::{bodies, probe, progress};
use crate::archive::{Archive, Checkpointed};
use crate::config::Case;
use crate::particles::Body;
use crate::state::Exchange;
use crate::state::State;
use crate::{Error, Result};
pub use log::Log;
use mics_run::bodies::{OBSTACLES as OBSTACLE_SURFACES, PREFIX as BODIES};
use mics_run::file::replace;
use mics_run::folder::{OBSTACLES, SOLVES};
use mics_run::vti::write_series;
use permission::{PART, RUN, clear, delete, lock};
pub use permission::{may_use, refuse_held};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
pub use tables::StepRow;
use tables::{PASSAGES, particle_columns, step_columns, write_roster};

/// Time after which the logs are brought to the disk.
const FLUSH_EVERY: Duration = Duration::from_secs(5);

/// An open run folder.
pub struct Folder {
    /// The folder.
    pub path: PathBuf,
    steps: Rows,
    particles: Option<Rows>,
    obstacles: Option<Rows>,
    probes: Option<Rows>,
    passages: Option<Rows>,
    solves: Option<Rows>,
    snapshots: Vec<(f64, u64)>,
    /// Snapshots that are on the disk for good.
    synced: usize,
    flushed: Instant,
    /// Held as long as this run writes here.
    _lock: File,
}

/// How far a run's logs and fields had come.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    /// Bytes of `steps.csv`.
    steps: u64,
    /// Bytes of `particles.csv`, where there is one.
    particles: Option<u64>,
    /// Bytes of `obstacles.csv`, where there is one.
    obstacles: Option<u64>,
    /// Bytes of `probes.csv`, where there is one.
    probes: Option<u64>,
    /// Bytes of `passages.csv`, where there is one.
    passages: Option<u64>,
    /// Bytes of `solves.csv`, where there is one.
    solves: Option<u64>,
    /// Bytes of `log.txt`.
    log: u64,
    /// Bytes of `progress.jsonl`.
    progress: u64,
    /// Time (s) and step of every snapshot.
    snapshots: Vec<(f64, u64)>,
}

impl Marks {
    /// Marks of logs as long as `bytes` with snapshots at these times (s).
    pub fn at(bytes: u64, snapshots: Vec<(f64, u64)>) -> Marks {
        Marks {
            steps: bytes,
            particles: Some(bytes),
            obstacles: None,
            probes: None,
            passages: None,
            solves: None,
            log: bytes,
            progress: bytes,
            snapshots,
        }
    }
}

impl Checkpointed for Marks {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Marks { steps, particles, obstacles, probes, passages, solves, log, .. } = self;
        archive.label("logs")?;
        archive.serialize([steps, particles, obstacles, probes, passages, solves, log])?;
        archive.serialize([&mut self.progress, &mut self.snapshots])
    }
}

impl Folder {
    /// Makes the folder (replacing a run that [`may_use`] allowed to replace) and opens its logs.
    /// The state says which columns there are.
    pub fn create<const D: usize>(
        path: &Path,
        log: &mut Log,
        case: &Case,
        s: &State<D>,
    ) -> Result<Folder> {
        let cure = |e| {
            Error::Usage(format!(
                "{}: cannot be made ({e}); give another folder with --out",
                path.display()
            ))
        };
        fs::create_dir_all(path).map_err(cure)?;
        let lock = lock(path)?;
        clear(path)?;
        let fields = path.join("fields");
        fs::create_dir_all(&fields).map_err(cure)?;
        replace(&path.join(RUN), b"{}\n")?;
        replace(&path.join("case.toml"), case.to_toml().as_bytes())?;
        write_roster(path, case)?;
        log.file = Some(Rows::create(&path.join("log.txt"), "")?);
        Ok(Folder {
            steps: Rows::create(&path.join("steps.csv"), &step_columns(s))?,
            particles: (s.bodies.iter().any(|body| !body.is_obstacle()) || !s.waiting.is_empty())
                .then(|| Rows::create(&path.join("particles.csv"), &particle_columns(D)))
                .transpose()?,
            obstacles: (s.bodies.iter().any(Body::is_obstacle))
                .then(|| Rows::create(&path.join(OBSTACLES), &particle_columns(D)))
                .transpose()?,
            probes: match case.probe.is_empty() {
                true => None,
                false => Some(Rows::create(&path.join("probes.csv"), probe::COLUMNS)?),
            },
            passages: None,
            solves: None,
            snapshots: Vec::new(),
            synced: 0,
            flushed: Instant::now(),
            path: path.to_owned(),
            _lock: lock,
        })
    }

    /// Takes up the folder of a run that goes on: its logs cut back to `marks`, its later snapshots
    /// deleted.
    ///
    /// # Errors
    /// When a log is not as the run left it, or another process writes here; nothing has been
    /// changed then.
    pub fn go_on(path: &Path, log: &mut Log, case: &Case, mut marks: Marks) -> Result<Folder> {
        let lock = lock(path)?;
        let steps = path.join("steps.csv");
        let particles = path.join("particles.csv");
        let said = path.join("log.txt");
        Rows::fits(&steps, marks.steps)?;
        marks.particles.map(|length| Rows::fits(&particles, length)).transpose()?;
        let obstacles = path.join(OBSTACLES);
        marks.obstacles.map(|length| Rows::fits(&obstacles, length)).transpose()?;
        let probes = path.join("probes.csv");
        marks.probes.map(|length| Rows::fits(&probes, length)).transpose()?;
        let passages = path.join(PASSAGES);
        marks.passages.map(|length| Rows::fits(&passages, length)).transpose()?;
        if marks.passages.is_none() {
            delete(&passages)?;
        }
        let solves = path.join(SOLVES);
        marks.solves.map(|length| Rows::fits(&solves, length)).transpose()?;
        if marks.solves.is_none() {
            delete(&solves)?;
        }
        let fields = path.join("fields");
        // Snapshots that somebody has deleted since, to save space, are no loss to the run.
        fs::create_dir_all(&fields).map_err(Error::io(&fields))?;
        marks.snapshots.retain(|(_, step)| fields.join(fields_file(*step)).exists());
        for file in fs::read_dir(&fields).map_err(Error::io(&fields))?.flatten().map(|e| e.path()) {
            let step = file.file_stem().and_then(|s| {
                let name = s.to_str()?;
                let step = name.strip_prefix(BODIES).or(name.strip_prefix(OBSTACLE_SURFACES));
                step.unwrap_or(name).trim_start_matches('-').parse::<u64>().ok()
            });
            let later = step.is_some_and(|step| marks.snapshots.iter().all(|(_, s)| *s < step));
            let ending = file.extension().unwrap_or_default();
            if ending == PART || (later && (ending == "vti" || ending == "vtp")) {
                fs::remove_file(&file).map_err(Error::io(&file))?;
            }
        }
        delete(&path.join("summary.json"))?;
        replace(&path.join("case.toml"), case.to_toml().as_bytes())?;
        write_roster(path, case)?;
        // Nobody needs what was said before.
        let kept = Rows::go_on(&said, marks.log);
        log.file = Some(kept.or_else(|_| Rows::create(&said, ""))?);
        progress::cut(path, marks.progress)?;
        let folder = Folder {
            steps: Rows::go_on(&steps, marks.steps)?,
            particles: marks.particles.map(|length| Rows::go_on(&particles, length)).transpose()?,
            obstacles: marks.obstacles.map(|length| Rows::go_on(&obstacles, length)).transpose()?,
            probes: marks.probes.map(|length| Rows::go_on(&probes, length)).transpose()?,
            passages: marks.passages.map(|length| Rows::go_on(&passages, length)).transpose()?,
            solves: marks.solves.map(|length| Rows::go_on(&solves, length)).transpose()?,
            synced: marks.snapshots.len(),
            snapshots: marks.snapshots,
            flushed: Instant::now(),
            path: path.to_owned(),
            _lock: lock,
        };
        folder.write_series()?;
        Ok(folder)
    }

    /// Brings all that is written so far to the disk, and says how far the logs have come,
    /// `progress` among them.
    pub fn mark(&mut self, log: &mut Log, progress: &Progress) -> Result<Marks> {
        let fields = self.path.join("fields");
        let named = ["case.toml", RUN].map(|name| self.path.join(name));
        let new = self.snapshots[self.synced..]
            .iter()
            .flat_map(|(_, step)| [fields_file(*step), vtp(*step)].map(|name| fields.join(name)));
        for path in named.into_iter().chain(new).chain([self.path.clone(), fields.clone()]) {
            match File::open(&path).and_then(|file| file.sync_all()) {
                // Deleted by somebody meanwhile.
                Err(e) if e.kind() == std::io::ErrorKind::NotFound => {}
                synced => synced.map_err(Error::io(&path))?,
            }
        }
        self.synced = self.snapshots.len();
        Ok(Marks {
            steps: self.steps.sync()?,
            particles: self.particles.as_mut().map(Rows::sync).transpose()?,
            obstacles: self.obstacles.as_mut().map(Rows::sync).transpose()?,
            probes: self.probes.as_mut().map(Rows::sync).transpose()?,
            passages: self.passages.as_mut().map(Rows::sync).transpose()?,
            solves: self.solves.as_mut().map(Rows::sync).transpose()?,
            log: log.file.as_mut().map_or(Ok(0), Rows::sync)?,
            progress: progress.length(),
            snapshots: self.snapshots.clone(),
        })
    }

    /// Takes up a snapshot of the fields that has been written: the bodies and what they exchanged
    /// beside it, and the series' indices.
    pub fn take_snapshot(
        &mut self,
        step: u64,
        time: f64,
        bodies: &[Body],
        exchange: &[Exchange],
    ) -> Result<()> {
        let fields = self.path.join("fields");
        let write = |name: &str, of: fn(&Body) -> bool| {
            let own = bodies.iter().zip(exchange).filter(|(body, _)| of(body)).enumerate();
            // Obstacles by their numbers among themselves, as in their table.
            let number = |k, body: &Body| if body.is_obstacle() { k } else { body.id };
            let own = own.map(|(k, (body, e))| (number(k, body), body, e.momentum));
            bodies::write(&fields.join(name), time, own)
        };
        if self.particles.is_some() && !bodies.iter().all(Body::is_obstacle) {
            write(&vtp(step), |body| !body.is_obstacle())?;
        }
        if self.obstacles.is_some() {
            // Those that rest are where they are.
            let moves = bodies.iter().any(|body| body.is_obstacle() && body.moves());
            let step = if moves { format!("-{step:08}") } else { String::new() };
            write(&format!("{OBSTACLE_SURFACES}{step}.vtp"), Body::is_obstacle)?;
        }
        self.snapshots.push((time, step));
        self.write_series()
    }

    fn write_series(&self) -> Result<()> {
        let entries = |name: fn(u64) -> String| {
            self.snapshots.iter().map(|(time, step)| (*time, name(*step))).collect::<Vec<_>>()
        };
        if self.particles.is_some() {
            write_series(&self.path.join("fields/bodies.pvd"), &entries(vtp))?;
        }
        write_series(&self.path.join("fields/series.pvd"), &entries(fields_file))
    }

    /// The newest snapshot's time (s) and path.
    pub fn last_snapshot(&self) -> Option<(f64, PathBuf)> {
        self.snapshots
            .last()
            .map(|(time, step)| (*time, self.path.join("fields").join(fields_file(*step))))
    }

    /// Brings the logs to the disk every few seconds, so that a long run can be followed.
    pub fn flush_when_due(&mut self, log: &mut Log) -> Result<()> {
        if self.flushed.elapsed() < FLUSH_EVERY { Ok(()) } else { self.flush(log) }
    }

    /// Brings the logs to the disk.
    pub fn flush(&mut self, log: &mut Log) -> Result<()> {
        self.flushed = Instant::now();
        let files = std::iter::once(&mut self.steps)
            .chain(&mut self.particles)
            .chain(&mut self.obstacles)
            .chain(&mut self.probes)
            .chain(&mut self.passages)
            .chain(&mut self.solves)
            .chain(&mut log.file);
        files.map(Rows::flush).fold(Ok(()), Result::and)
    }

    /// Writes a JSON file of the run.
    pub fn write_json(&self, name: &str, value: &serde_json::Value) -> Result<()> {
        let text = format!("{value:#}\n");
        replace(&self.path.join(name), text.as_bytes())
    }
}

/// Name of the file with the bodies of a step.
fn vtp(step: u64) -> String {
    format!("{BODIES}{step:08}.vtp")
}

/// The file name of a step's snapshot.
pub fn fields_file(step: u64) -> String {
    format!("{step:08}.vti")
}
