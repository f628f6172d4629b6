//! A run's folder: who may use it, its logs, its snapshots and its summary. Lives on rank 0.

use super::snapshot::{Snapshot, replace, write_series};
use super::{progress, report};
use crate::audit::Audit;
use crate::case::ForceRule;
use crate::coupling::Exchange;
use crate::solids::Body;
use crate::{Error, Result};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What `particles.csv` holds: the contract's columns, then what 3D and the other force add.
const PARTICLE_COLUMNS: &str = "step,time,id,x,y,z,angle,vx,vy,vz,wx,wy,wz,fluid_fx,fluid_fy,fluid_fz,pressure_fx,\
    pressure_fy,viscous_fx,viscous_fy,convective_fx,convective_fy,contact_fx,contact_fy,contact_fz,fluid_tx,fluid_ty,\
    fluid_tz,pressure_fz,viscous_fz,convective_fz,momentum_fx,momentum_fy,momentum_fz";
/// What `steps.csv` holds: the contract's columns; then, where particles are free, the substeps of contacts and the
/// balance of momentum.
const STEP_COLUMNS: &str = "step,time,dt,outer_iterations,krylov_iterations,divergence_max,cfl,kinetic_energy,wall";
const BALANCE_COLUMNS: &str = ",substeps,momentum_x,momentum_y,momentum_z,border_impulse_x,border_impulse_y,\
    border_impulse_z,momentum_error,angular_momentum_error";

/// What this program writes into a run's folder, and so may delete with `--force`.
const OURS: [&str; 8] =
    ["case.toml", "run.json", "steps.csv", "particles.csv", "summary.json", "log.txt", progress::FILE, report::FILE];
/// Its folders, with the endings of what it writes there.
const OUR_FOLDERS: [(&str, &[&str]); 2] = [("fields", &["vti", "pvd"]), ("figures", &["png", "svg"])];
/// Ending of a file that is being written.
const PART: &str = "part";
/// Time after which the logs are brought to the disk.
const FLUSH_EVERY: Duration = Duration::from_secs(5);

/// Lines for the screen and for `log.txt`.
pub struct Log {
    file: Option<BufWriter<File>>,
    screen: bool,
}

impl Log {
    /// A log that prints when `screen` is set, and keeps nothing yet.
    pub fn new(screen: bool) -> Log {
        Log { file: None, screen }
    }

    /// Says a line.
    pub fn say(&mut self, line: &str) {
        if self.screen {
            // A closed pipe (`| head`) is no reason to end a run.
            let _ = writeln!(std::io::stdout(), "{line}");
        }
        if let Some(file) = &mut self.file {
            let _ = writeln!(file, "{line}");
        }
    }
}

/// An open run folder.
pub struct Folder {
    /// The folder.
    pub path: PathBuf,
    steps: BufWriter<File>,
    particles: Option<BufWriter<File>>,
    snapshots: Vec<(f64, String)>,
    flushed: Instant,
}

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
    /// Kinetic energy (J).
    pub kinetic_energy: f64,
    /// Wall-clock seconds since the start.
    pub wall: f64,
}

/// Whether a run of the case file `case` may be written to `path`.
///
/// # Errors
/// When the folder holds a run and `force` is not set, or holds anything that is not a run's, or the case file itself.
pub fn may_use(path: &Path, force: bool, case: &Path) -> Result<()> {
    let refuse = |why: String| Err(Error::Usage(format!("{}: {why}", path.display())));
    let entries = match fs::read_dir(path) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(e) => return refuse(format!("cannot be used as a run's folder: {e}")),
        Ok(entries) => entries,
    };
    let names: Vec<String> = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    if names.is_empty() {
        return Ok(());
    }
    let ours = |n: &str| {
        OURS.contains(&n.strip_suffix(".part").unwrap_or(n)) || OUR_FOLDERS.iter().any(|(folder, _)| *folder == n)
    };
    if let Some(strange) = names.iter().find(|n| !ours(n)) {
        return refuse(format!(
            "the folder exists and holds {strange:?}, which no run wrote; give another folder with --out"
        ));
    }
    if !names.iter().any(|n| n == "run.json") {
        return refuse("the folder exists and holds no run (no run.json); give another folder with --out".into());
    }
    if !force {
        return refuse("the folder exists and holds a run; give another with --out, or --force to replace it".into());
    }
    let inside = |p: &Path| Some(p.canonicalize().ok()?.starts_with(path.canonicalize().ok()?));
    if inside(case) == Some(true) {
        return refuse(format!("--force would delete the case file {}; copy it elsewhere first", case.display()));
    }
    Ok(())
}

/// Deletes what a run left in its folder, and nothing else.
fn clear(path: &Path) -> Result<()> {
    let delete = |file: &Path| match fs::remove_file(file) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::io(file)(e)),
        _ => Ok(()),
    };
    for name in OURS {
        delete(&path.join(name))?;
        delete(&path.join(format!("{name}.{PART}")))?;
    }
    for (name, endings) in OUR_FOLDERS {
        let Ok(entries) = fs::read_dir(path.join(name)) else { continue };
        for file in entries.flatten().map(|e| e.path()) {
            let ending = file.extension().unwrap_or_default();
            if ending == PART || endings.iter().any(|e| ending == *e) {
                delete(&file)?;
            }
        }
    }
    Ok(())
}

impl Folder {
    /// Makes the folder (replacing a run that [`may_use`] allowed to replace) and opens its logs.
    /// `particles` and `balance` say which columns there are.
    pub fn create(path: &Path, log: &mut Log, case: &str, particles: bool, balance: bool) -> Result<Folder> {
        clear(path)?;
        let fields = path.join("fields");
        let cure =
            |e| Error::Usage(format!("{}: cannot be made ({e}); give another folder with --out", path.display()));
        fs::create_dir_all(&fields).map_err(cure)?;
        replace(&path.join("case.toml"), case.as_bytes())?;
        log.file = Some(open(&path.join("log.txt"), "")?);
        Ok(Folder {
            steps: open(&path.join("steps.csv"), &[STEP_COLUMNS, if balance { BALANCE_COLUMNS } else { "" }].concat())?,
            particles: particles.then(|| open(&path.join("particles.csv"), PARTICLE_COLUMNS)).transpose()?,
            snapshots: Vec::new(),
            flushed: Instant::now(),
            path: path.to_owned(),
        })
    }

    /// Writes a row of `steps.csv`.
    pub fn write_step(&mut self, r: &StepRow, balance: Option<(usize, &Audit)>) -> Result<()> {
        let written = write!(
            self.steps,
            "{},{:?},{:?},{},{},{:e},{:.6},{:?},{:.3}",
            r.step, r.time, r.dt, r.outer, r.krylov, r.divergence_max, r.cfl, r.kinetic_energy, r.wall
        );
        let written = written.and_then(|()| match balance {
            None => writeln!(self.steps),
            Some((substeps, a)) => {
                let (m, b) = (&a.momentum, &a.border);
                let (error, angular) = (a.error.amax(), a.angular_error);
                writeln!(
                    self.steps,
                    ",{substeps},{:e},{:e},{:e},{:e},{:e},{:e},{error:e},{angular:e}",
                    m.x, m.y, m.z, b.x, b.y, b.z
                )
            }
        });
        written.map_err(Error::io(self.path.join("steps.csv")))
    }

    /// Writes a row a particle to `particles.csv`; `fluid_f*` is the force that `rule` names.
    pub fn write_particles(
        &mut self,
        step: u64,
        time: f64,
        bodies: &[Body],
        exchange: &[Exchange],
        rule: ForceRule,
    ) -> Result<()> {
        let Some(file) = &mut self.particles else { return Ok(()) };
        for (id, (b, e)) in bodies.iter().zip(exchange).enumerate() {
            let (force, torque) = match rule {
                ForceRule::Momentum => (e.momentum, e.momentum_torque),
                ForceRule::Literal => (e.literal(), e.literal_torque),
            };
            let numbers = [
                &[b.centre.x, b.centre.y, b.centre.z, b.angle][..],
                b.velocity.as_slice(),
                b.spin.as_slice(),
                force.as_slice(),
                &[e.pressure.x, e.pressure.y, e.viscous.x, e.viscous.y, e.convective.x, e.convective.y],
                e.contact.as_slice(),
                torque.as_slice(),
                &[e.pressure.z, e.viscous.z, e.convective.z],
                e.momentum.as_slice(),
            ];
            let written = write!(file, "{step},{time:?},{id}")
                .and_then(|()| numbers.iter().copied().flatten().try_for_each(|v| write!(file, ",{v:?}")))
                .and_then(|()| writeln!(file));
            written.map_err(Error::io(self.path.join("particles.csv")))?;
        }
        Ok(())
    }

    /// Writes a snapshot of the fields and the series' index.
    pub fn write_snapshot(&mut self, step: u64, snapshot: &Snapshot) -> Result<()> {
        let name = format!("{step:08}.vti");
        snapshot.write(&self.path.join("fields").join(&name))?;
        self.snapshots.push((snapshot.time, name));
        write_series(&self.path.join("fields/series.pvd"), &self.snapshots)
    }

    /// The newest snapshot's time (s) and path.
    pub fn last_snapshot(&self) -> Option<(f64, PathBuf)> {
        self.snapshots.last().map(|(time, name)| (*time, self.path.join("fields").join(name)))
    }

    /// Brings the logs to the disk every few seconds, so that a long run can be followed.
    pub fn flush_when_due(&mut self, log: &mut Log) -> Result<()> {
        if self.flushed.elapsed() < FLUSH_EVERY { Ok(()) } else { self.flush(log) }
    }

    /// Brings the logs to the disk.
    pub fn flush(&mut self, log: &mut Log) -> Result<()> {
        self.flushed = Instant::now();
        self.steps.flush().map_err(Error::io(self.path.join("steps.csv")))?;
        if let Some(file) = &mut self.particles {
            file.flush().map_err(Error::io(self.path.join("particles.csv")))?;
        }
        if let Some(file) = &mut log.file {
            file.flush().map_err(Error::io(self.path.join("log.txt")))?;
        }
        Ok(())
    }

    /// Writes a JSON file of the run.
    pub fn write_json(&self, name: &str, value: &serde_json::Value) -> Result<()> {
        let text = format!("{value:#}\n");
        replace(&self.path.join(name), text.as_bytes())
    }
}

fn open(path: &Path, head: &str) -> Result<BufWriter<File>> {
    let mut file = BufWriter::new(File::create(path).map_err(Error::io(path))?);
    if !head.is_empty() {
        writeln!(file, "{head}").map_err(Error::io(path))?;
    }
    Ok(file)
}
