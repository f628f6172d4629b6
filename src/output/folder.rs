//! A run's folder: who may use it, its logs, tables, snapshots and summary. Lives on rank 0.
//! docs/output.md says what each column is.

mod log;
mod permission;

use super::bodies::Shown;
use super::progress::Progress;
use super::rows::LineFile;
use super::{bodies, probe, progress};
use crate::archive::{Archive, Checkpointed};
use crate::config::{Case, ForceRule, WallRule};
use crate::method::Traction;
use crate::particles::{Body, by_number};
use crate::poisson::SolveRow;
use crate::state::{EnergyLosses, Exchange, State, SuppliedWork};
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

/// Time after which the logs are brought to the disk.
const FLUSH_EVERY: Duration = Duration::from_secs(5);

/// First columns of `particles.csv` and `obstacles.csv`.
const PARTICLE_COLUMNS: &str = "step,time,id,x,y,z,path_x,path_y,path_z,angle,vx,vy,vz,wx,wy,wz,\
    fluid_fx,fluid_fy,fluid_fz,fluid_tx,fluid_ty,fluid_tz,pressure_fx,pressure_fy,pressure_fz,\
    viscous_fx,viscous_fy,viscous_fz";
/// The force defect of a sharp surface; in the mixture method the convective part of (19).
const DEFECT_COLUMNS: &str = ",defect_fx,defect_fy,defect_fz";
const CONVECTIVE_COLUMNS: &str = ",convective_fx,convective_fy,convective_fz";
const IMPULSE_COLUMNS: &str =
    ",momentum_fx,momentum_fy,momentum_fz,contact_fx,contact_fy,contact_fz";
/// Columns that 3D adds at the end: the orientation of a particle, a unit quaternion.
const ORIENTATION_COLUMNS: &str = ",qw,qx,qy,qz";
/// Columns of `steps.csv`: the contract's; then, where particles are free, the substeps of contacts
/// and the balance of momentum; then the budget of energy.
const STEP_COLUMNS: &str =
    "step,time,dt,outer_iterations,krylov_iterations,divergence_max,cfl,kinetic_energy,wall";
const BALANCE_COLUMNS: &str = ",substeps,momentum_x,momentum_y,momentum_z,\
    boundary_impulse_x,boundary_impulse_y,boundary_impulse_z,momentum_error,angular_momentum_error";
const ENERGY_COLUMNS: &str = ",fluid_energy,bodies_energy,spring_energy,gravity_work,boundary_work,\
    prescribed_work,viscous_loss,contact_loss,friction_loss,method_loss,bounded_energy";
/// Columns that a drive adds at the end: its force on the fluid (N/m3), and its work.
const DRIVE_COLUMNS: &str = ",drive_fx,drive_fy,drive_fz,drive_work";

/// Bodies that have left the box, and its columns.
const PASSAGES: &str = "passages.csv";
const PASSAGE_COLUMNS: &str = "step,time,id,what,mass,diameter,x,y,z,vx,vy,vz";
/// Columns of `solves.csv`.
const SOLVE_COLUMNS: &str = "step,time,projection,outer_iteration,attempt,krylov_iteration,norm,\
    residual,relative_residual,tolerance,divergence_before,divergence_after";
/// File of what does not change about particles: a row each.
const ROSTER: &str = "bodies.csv";

/// A row of `steps.csv`.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepRow {
    /// Step count.
    pub step: u64,
    /// Time after the step (s).
    pub time: f64,
    /// Time step (s).
    pub dt: f64,
    /// C-HSMAC iterations.
    pub outer: u32,
    /// Krylov iterations.
    pub krylov: u32,
    /// Largest |D| (1/s).
    pub divergence_max: f64,
    /// Courant number.
    pub cfl: f64,
    /// Kinetic energy of the fluid outside the bodies and of the free bodies (J; per metre of depth
    /// in 2D).
    pub kinetic_energy: f64,
    /// Wall-clock seconds since the start.
    pub wall: f64,
}

/// An open run folder.
pub struct Folder {
    /// The folder.
    pub path: PathBuf,
    steps: LineFile,
    particles: Option<LineFile>,
    obstacles: Option<LineFile>,
    probes: Option<LineFile>,
    passages: Option<LineFile>,
    solves: Option<LineFile>,
    snapshots: Vec<(f64, u64)>,
    /// Snapshots that are on the disk for good.
    synced: usize,
    flushed: Instant,
    /// Held as long as this run writes here.
    _lock: File,
}

/// Lengths of a run's logs and the snapshots of its fields, at a moment.
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
        log.file = Some(LineFile::create(&path.join("log.txt"), "")?);
        Ok(Folder {
            steps: LineFile::create(&path.join("steps.csv"), &step_columns(s))?,
            particles: (s.bodies.iter().any(|body| !body.is_obstacle()) || !s.waiting.is_empty())
                .then(|| LineFile::create(&path.join("particles.csv"), &particle_columns(case)))
                .transpose()?,
            obstacles: (s.bodies.iter().any(Body::is_obstacle))
                .then(|| LineFile::create(&path.join(OBSTACLES), &particle_columns(case)))
                .transpose()?,
            probes: match case.probe.is_empty() {
                true => None,
                false => Some(LineFile::create(&path.join("probes.csv"), probe::COLUMNS)?),
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
        LineFile::fits(&steps, marks.steps)?;
        marks.particles.map(|length| LineFile::fits(&particles, length)).transpose()?;
        let obstacles = path.join(OBSTACLES);
        marks.obstacles.map(|length| LineFile::fits(&obstacles, length)).transpose()?;
        let probes = path.join("probes.csv");
        marks.probes.map(|length| LineFile::fits(&probes, length)).transpose()?;
        let passages = path.join(PASSAGES);
        marks.passages.map(|length| LineFile::fits(&passages, length)).transpose()?;
        if marks.passages.is_none() {
            delete(&passages)?;
        }
        let solves = path.join(SOLVES);
        marks.solves.map(|length| LineFile::fits(&solves, length)).transpose()?;
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
        let kept = LineFile::go_on(&said, marks.log);
        log.file = Some(kept.or_else(|_| LineFile::create(&said, ""))?);
        progress::cut(path, marks.progress)?;
        let folder = Folder {
            steps: LineFile::go_on(&steps, marks.steps)?,
            particles: marks
                .particles
                .map(|length| LineFile::go_on(&particles, length))
                .transpose()?,
            obstacles: marks
                .obstacles
                .map(|length| LineFile::go_on(&obstacles, length))
                .transpose()?,
            probes: marks.probes.map(|length| LineFile::go_on(&probes, length)).transpose()?,
            passages: marks
                .passages
                .map(|length| LineFile::go_on(&passages, length))
                .transpose()?,
            solves: marks.solves.map(|length| LineFile::go_on(&solves, length)).transpose()?,
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
            particles: self.particles.as_mut().map(LineFile::sync).transpose()?,
            obstacles: self.obstacles.as_mut().map(LineFile::sync).transpose()?,
            probes: self.probes.as_mut().map(LineFile::sync).transpose()?,
            passages: self.passages.as_mut().map(LineFile::sync).transpose()?,
            solves: self.solves.as_mut().map(LineFile::sync).transpose()?,
            log: log.file.as_mut().map_or(Ok(0), LineFile::sync)?,
            progress: progress.length(),
            snapshots: self.snapshots.clone(),
        })
    }

    /// Takes up a snapshot of the fields that has been written: the bodies and what they exchanged
    /// beside it, with the tractions on each where there are any, and the series' indices.
    pub fn take_snapshot(
        &mut self,
        step: u64,
        time: f64,
        bodies: &[Body],
        exchange: &[Exchange],
        tractions: &[Vec<Traction>],
    ) -> Result<()> {
        let fields = self.path.join("fields");
        let write = |name: &str, of: fn(&Body) -> bool| {
            let own = by_number(bodies).into_iter().filter(|k| of(&bodies[*k])).enumerate();
            let shown = own.map(|(number, k)| Shown {
                // Obstacles by their numbers among themselves, as in their table.
                id: if bodies[k].is_obstacle() { number } else { bodies[k].id },
                body: &bodies[k],
                force: exchange[k].momentum,
                tractions: tractions.get(k).map_or(&[], Vec::as_slice),
            });
            bodies::write(&fields.join(name), time, shown)
        };
        if self.particles.is_some() && !bodies.iter().all(Body::is_obstacle) {
            write(&vtp(step), |body| !body.is_obstacle())?;
        }
        if self.obstacles.is_some() {
            // One file serves all snapshots where no obstacle moves and no traction changes.
            let moves = bodies.iter().any(|body| body.is_obstacle() && body.moves());
            let step =
                if moves || !tractions.is_empty() { format!("-{step:08}") } else { String::new() };
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
        files.map(LineFile::flush).fold(Ok(()), Result::and)
    }

    /// Writes a JSON file of the run.
    pub fn write_json(&self, name: &str, value: &serde_json::Value) -> Result<()> {
        let text = format!("{value:#}\n");
        replace(&self.path.join(name), text.as_bytes())
    }

    /// Writes a row of `steps.csv` of a step and the state after it.
    pub fn write_step<const D: usize>(&mut self, r: &StepRow, s: &State<D>) -> Result<()> {
        self.steps.put(format_args!(
            "{},{:?},{:?},{},{},{:e},{:.6},{:?},{:.3}",
            r.step,
            r.time,
            r.dt,
            r.outer,
            r.krylov,
            r.divergence_max,
            r.cfl,
            r.kinetic_energy,
            r.wall
        ));
        if let Some(a) = &s.balance {
            let m = &a.momentum;
            let b = &a.impulses.boundary();
            let substeps = s.substeps;
            let error = a.error.amax();
            let angular = a.angular_error;
            self.steps.put(format_args!(
                ",{substeps},{:e},{:e},{:e},{:e},{:e},{:e},{error:e},{angular:e}",
                m.x, m.y, m.z, b.x, b.y, b.z
            ));
        }
        let e = &s.energy;
        let SuppliedWork { gravity, drive, boundaries, prescribed } = e.work;
        let EnergyLosses { viscous, contacts, friction, method } = e.losses;
        let stored = [e.fluid, e.bodies, e.springs].into_iter();
        let budget = stored
            .chain([gravity, boundaries, prescribed])
            .chain([viscous, contacts, friction, method, e.bounded]);
        budget.for_each(|joule| self.steps.put(format_args!(",{joule:e}")));
        if let Some(force) = s.drive {
            force
                .iter()
                .chain([&drive])
                .for_each(|number| self.steps.put(format_args!(",{number:e}")));
        }
        self.steps.end_line()
    }

    /// Writes that a body has left the box (kg, m, m/s) or come back: a row of `passages.csv`,
    /// which the first one begins.
    pub fn write_passage(&mut self, step: u64, time: f64, what: &str, body: &Body) -> Result<()> {
        if self.passages.is_none() {
            self.passages = Some(LineFile::create(&self.path.join(PASSAGES), PASSAGE_COLUMNS)?);
        }
        let Some(rows) = &mut self.passages else { return Ok(()) };
        let c = body.centre;
        let v = body.velocity;
        let id = body.id;
        let mass = body.mass();
        let diameter = body.shape().diameter();
        rows.add(format_args!(
            "{step},{time:?},{id},{what},{mass:?},{diameter:?},{:?},{:?},{:?},{:?},{:?},{:?}",
            c.x, c.y, c.z, v.x, v.y, v.z
        ))
    }

    /// Writes the iterations of all solves of a step that ended, or was to end, at `time` (s): rows
    /// of `solves.csv`, which the first one begins.
    pub fn write_solves(
        &mut self,
        step: u64,
        time: f64,
        solves: impl Iterator<Item = SolveRow>,
    ) -> Result<()> {
        for r in solves {
            let rows = match &mut self.solves {
                Some(rows) => rows,
                none => none.insert(LineFile::create(&self.path.join(SOLVES), SOLVE_COLUMNS)?),
            };
            rows.put(format_args!(
                "{step},{time:?},{},{},{},{},{},{:e},{:e},",
                r.projection, r.outer, r.attempt, r.krylov, r.norm, r.residual, r.relative
            ));
            // A missing value is an empty cell.
            if let Some(tolerance) = r.tolerance {
                rows.put(format_args!("{tolerance:e}"));
            }
            rows.put(format_args!(",{:e},", r.before));
            if let Some(after) = r.after {
                rows.put(format_args!("{after:e}"));
            }
            rows.end_line()?;
        }
        Ok(())
    }

    /// Writes a line of `probes.csv`.
    pub fn write_probe(&mut self, line: std::fmt::Arguments) -> Result<()> {
        self.probes.as_mut().map_or(Ok(()), |probes| probes.add(line))
    }

    /// Writes a row a particle to `particles.csv` and a row an obstacle to `obstacles.csv`;
    /// `fluid_f*` is the force that `rule` names.
    pub fn write_bodies<'a>(
        &mut self,
        step: u64,
        time: f64,
        bodies: impl Iterator<Item = (&'a Body, &'a Exchange)>,
        rule: ForceRule,
    ) -> Result<()> {
        let mut obstacles = 0;
        for (b, e) in bodies {
            let (file, id) = match b.is_obstacle() {
                true => (&mut self.obstacles, obstacles),
                false => (&mut self.particles, b.id),
            };
            let Some(file) = file else { continue };
            obstacles += usize::from(b.is_obstacle());
            let (force, torque) = match rule {
                ForceRule::Momentum => (e.momentum, e.momentum_torque),
                ForceRule::Literal => (e.literal(), e.literal_torque),
            };
            let path = b.path();
            let vectors =
                [&b.centre, &path, &b.velocity, &b.spin, &force, &torque, &e.pressure, &e.viscous];
            let vectors = vectors.into_iter().chain([&e.remainder, &e.momentum, &e.contact]);
            file.put(format_args!("{step},{time:?},{id}"));
            for (k, vector) in vectors.enumerate() {
                vector.iter().for_each(|v| file.put(format_args!(",{v:?}")));
                if k == 1 {
                    file.put(format_args!(",{:?}", b.angle));
                }
            }
            if b.shape().dimension() == 3 {
                let q = b.orientation;
                file.put(format_args!(",{:?},{:?},{:?},{:?}", q.w, q.i, q.j, q.k));
            }
            file.end_line()?;
        }
        Ok(())
    }
}

/// The columns of `steps.csv` of runs with such a state.
fn step_columns<const D: usize>(s: &State<D>) -> String {
    let of = |there: bool, columns| if there { columns } else { "" };
    let columns = [
        STEP_COLUMNS,
        of(s.balance.is_some(), BALANCE_COLUMNS),
        ENERGY_COLUMNS,
        of(s.drive.is_some(), DRIVE_COLUMNS),
    ];
    columns.concat()
}

/// The columns of `particles.csv` and `obstacles.csv`.
fn particle_columns(case: &Case) -> String {
    let remainder = match case.coupling.wall {
        WallRule::Sharp => DEFECT_COLUMNS,
        WallRule::Mixture => CONVECTIVE_COLUMNS,
    };
    let orientation = if case.dimension() == 3 { ORIENTATION_COLUMNS } else { "" };
    [PARTICLE_COLUMNS, remainder, IMPULSE_COLUMNS, orientation].concat()
}

/// Writes what each particle is: its number, name, material, shape, diameter (m; of what is not
/// round that of the disc or sphere of its volume), density (kg/m3) and motion.
fn write_roster(path: &Path, case: &Case) -> Result<()> {
    if case.particle.is_empty() {
        return Ok(());
    }
    let mut rows = csv::Writer::from_writer(Vec::new());
    let failed = |e: csv::Error| Error::io(path.join(ROSTER))(e.into());
    rows.write_record(["id", "name", "material", "shape", "diameter", "density", "motion"])
        .map_err(failed)?;
    for (id, p) in case.particle.iter().enumerate() {
        let name = p.name.clone().unwrap_or_default();
        let motion = p.motion.name();
        let [id, diameter, density] =
            [id.to_string(), format!("{:?}", p.shape.diameter()), format!("{:?}", p.density())];
        rows.write_record([&id, &name, p.material(), p.shape.name(), &diameter, &density, motion])
            .map_err(failed)?;
    }
    let text = rows.into_inner().map_err(|e| Error::io(path.join(ROSTER))(e.into_error()))?;
    replace(&path.join(ROSTER), &text)
}

/// Name of the file with the bodies of a step.
fn vtp(step: u64) -> String {
    format!("{BODIES}{step:08}.vtp")
}

/// The file name of a step's snapshot.
pub fn fields_file(step: u64) -> String {
    format!("{step:08}.vti")
}
