//! The tables of a run: the columns and rows of `steps.csv`, `particles.csv`, `obstacles.csv`,
//! `passages.csv` and `bodies.csv`. docs/output.md says what each column is.

use super::super::rows::Rows;
use super::Folder;
use crate::config::{Case, ForceRule};
use crate::particles::Body;
use crate::poisson::SolveRow;
use crate::state::{EnergyLosses, Exchange, State, SuppliedWork};
use crate::{Error, Result};
use mics_run::file::replace;
use mics_run::folder::SOLVES;
use std::path::Path;

/// What `particles.csv` and `obstacles.csv` hold; docs/output.md says what each column is.
const PARTICLE_COLUMNS: &str = "step,time,id,x,y,z,path_x,path_y,path_z,angle,vx,vy,vz,wx,wy,wz,\
    fluid_fx,fluid_fy,fluid_fz,fluid_tx,fluid_ty,fluid_tz,pressure_fx,pressure_fy,pressure_fz,\
    viscous_fx,viscous_fy,viscous_fz,convective_fx,convective_fy,convective_fz,\
    momentum_fx,momentum_fy,momentum_fz,contact_fx,contact_fy,contact_fz";
/// What 3D adds at the end: the orientation of a particle, a unit quaternion.
const ORIENTATION_COLUMNS: &str = ",qw,qx,qy,qz";
/// What `steps.csv` holds: the contract's columns; then, where particles are free, the substeps of
/// contacts and the balance of momentum; then the budget of energy.
const STEP_COLUMNS: &str =
    "step,time,dt,outer_iterations,krylov_iterations,divergence_max,cfl,kinetic_energy,wall";
const BALANCE_COLUMNS: &str = ",substeps,momentum_x,momentum_y,momentum_z,\
    border_impulse_x,border_impulse_y,border_impulse_z,momentum_error,angular_momentum_error";
const ENERGY_COLUMNS: &str = ",fluid_energy,bodies_energy,spring_energy,gravity_work,border_work,\
    prescribed_work,viscous_loss,contact_loss,friction_loss,method_loss,bounded_energy";
/// What a drive adds at the end: its force on the fluid (N/m3), and its work.
const DRIVE_COLUMNS: &str = ",drive_fx,drive_fy,drive_fz,drive_work";

/// Bodies that have left the box, and its columns.
pub(super) const PASSAGES: &str = "passages.csv";
const PASSAGE_COLUMNS: &str = "step,time,id,what,mass,diameter,x,y,z,vx,vy,vz";
/// What `solves.csv` holds.
const SOLVE_COLUMNS: &str = "step,time,projection,outer_iteration,attempt,krylov_iteration,norm,\
    residual,relative_residual,tolerance,divergence_before,divergence_after";
/// What particles are, which does not change: a row each.
pub(super) const ROSTER: &str = "bodies.csv";
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

/// The columns of `steps.csv` of runs with such a state.
pub(super) fn step_columns<const D: usize>(s: &State<D>) -> String {
    let of = |there: bool, columns| if there { columns } else { "" };
    let columns = [
        STEP_COLUMNS,
        of(s.balance.is_some(), BALANCE_COLUMNS),
        ENERGY_COLUMNS,
        of(s.drive.is_some(), DRIVE_COLUMNS),
    ];
    columns.concat()
}

/// The columns of `particles.csv` and `obstacles.csv` in so many dimensions.
pub(super) fn particle_columns(dimension: usize) -> String {
    [PARTICLE_COLUMNS, if dimension == 3 { ORIENTATION_COLUMNS } else { "" }].concat()
}

/// Writes what each particle is: its number, name, material, shape, diameter (m; of what is not
/// round that of the disc or sphere of its volume), density (kg/m3) and motion.
pub(super) fn write_roster(path: &Path, case: &Case) -> Result<()> {
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

impl Folder {
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
            self.passages = Some(Rows::create(&self.path.join(PASSAGES), PASSAGE_COLUMNS)?);
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
                none => none.insert(Rows::create(&self.path.join(SOLVES), SOLVE_COLUMNS)?),
            };
            rows.put(format_args!(
                "{step},{time:?},{},{},{},{},{},{:e},{:e},",
                r.projection, r.outer, r.attempt, r.krylov, r.norm, r.residual, r.relative
            ));
            // What there is none of is an empty cell.
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
            let vectors = vectors.into_iter().chain([&e.convective, &e.momentum, &e.contact]);
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
