//! A run's folder: who may use it, its logs, its snapshots and its summary. Lives on rank 0.

use super::snapshot::{Snapshot, replace, write_series};
use crate::case::ForceRule;
use crate::coupling::Exchange;
use crate::solids::Body;
use crate::{Error, Result};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// What `particles.csv` holds: the contract's columns, then what 3D and the other force add.
const PARTICLE_COLUMNS: &str = "step,time,id,x,y,z,angle,vx,vy,vz,wx,wy,wz,fluid_fx,fluid_fy,fluid_fz,pressure_fx,\
    pressure_fy,viscous_fx,viscous_fy,convective_fx,convective_fy,contact_fx,contact_fy,contact_fz,fluid_tx,fluid_ty,\
    fluid_tz,pressure_fz,viscous_fz,convective_fz,momentum_fx,momentum_fy,momentum_fz";
const STEP_COLUMNS: &str = "step,time,dt,outer_iterations,krylov_iterations,divergence_max,cfl,kinetic_energy,wall";

/// What this program writes into a run's folder, and so may delete with `--force`.
const OURS: [&str; 8] =
    ["case.toml", "run.json", "steps.csv", "particles.csv", "fields", "figures", "summary.json", "log.txt"];

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

/// Whether a run may be written to `path`.
///
/// # Errors
/// When the folder holds a run and `force` is not set, or holds anything that is not a run's.
pub fn may_use(path: &Path, force: bool) -> Result<()> {
    let entries = match fs::read_dir(path) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(e) => return Err(Error::Usage(format!("{}: cannot be used as a run's folder: {e}", path.display()))),
        Ok(entries) => entries,
    };
    let names: Vec<String> = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    if let Some(strange) = names.iter().find(|n| !OURS.contains(&n.as_str())) {
        return Err(Error::Usage(format!(
            "{}: the folder exists and holds {strange:?}, which no run wrote; give another folder with --out",
            path.display()
        )));
    }
    if !names.is_empty() && !force {
        return Err(Error::Usage(format!(
            "{}: the folder exists and holds a run; give another with --out, or --force to replace it",
            path.display()
        )));
    }
    Ok(())
}

impl Folder {
    /// Makes the folder (replacing a run that [`may_use`] allowed to replace) and opens its logs.
    pub fn create(path: &Path, log: &mut Log, case: &str, particles: bool) -> Result<Folder> {
        for name in OURS {
            let old = path.join(name);
            let gone = if old.is_dir() { fs::remove_dir_all(&old) } else { fs::remove_file(&old) };
            match gone {
                Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(Error::io(&old)(e)),
                _ => {}
            }
        }
        let fields = path.join("fields");
        fs::create_dir_all(&fields).map_err(Error::io(&fields))?;
        replace(&path.join("case.toml"), case.as_bytes())?;
        log.file = Some(open(&path.join("log.txt"), "")?);
        Ok(Folder {
            steps: open(&path.join("steps.csv"), STEP_COLUMNS)?,
            particles: particles.then(|| open(&path.join("particles.csv"), PARTICLE_COLUMNS)).transpose()?,
            snapshots: Vec::new(),
            path: path.to_owned(),
        })
    }

    /// Writes a row of `steps.csv`.
    pub fn write_step(&mut self, r: &StepRow) -> Result<()> {
        writeln!(
            self.steps,
            "{},{:?},{:?},{},{},{:e},{:.6},{:?},{:.3}",
            r.step, r.time, r.dt, r.outer, r.krylov, r.divergence_max, r.cfl, r.kinetic_energy, r.wall
        )
        .map_err(Error::io(self.path.join("steps.csv")))
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
                // No contacts in this version.
                &[0.0; 3],
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

    /// Brings the logs to the disk.
    pub fn flush(&mut self, log: &mut Log) -> Result<()> {
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
