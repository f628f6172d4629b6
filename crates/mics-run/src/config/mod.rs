//! A case: read from its file, checked, its shapes and walls built, its swarms expanded, every key
//! filled in, all in one set of types. Pure data; the solver's `scene` alone turns it into a
//! running scene.
//!
//! ```text
//!   case.toml, --set, preset  ->  document  ->  Case  ->  checked, built, filled in  ->  scene,
//!         keys and their lines                   ^                    |                  run,
//!   case.toml of the run                         +--------------------+                  check
//! ```
//! A default that stands by itself belongs to its key; one that depends on other keys is filled in
//! where its table is (`fill`). Nobody after that asks whether a key was given. SI units are named
//! throughout; any consistent set works.

#[macro_use]
mod fault;
mod begin;
mod boundary;
mod change;
mod contact;
mod coupling;
mod describe;
mod direction;
mod document;
mod drive;
mod fill;
mod measure;
mod measure_kind;
mod message;
mod obstacle;
mod orientation;
mod output;
mod over_time;
mod particle;
mod preset;
mod pressure;
mod read;
mod reference;
mod shape;
mod source;
mod speeds;
mod statistics;
mod swarm;
mod time;
mod validate;
mod write;

pub use boundary::{Boundary, Inflow, LogProfile, Profile, Side, VaryingInflow};
pub use change::refuse_changes;
pub use contact::{
    Contact, Damping, Loss, MOST_SUBSTEPS, Pair, PairLaw, Stiffness, Substeps, TangentialDamping,
    WALL,
};
pub use coupling::{Coupling, ForceRule, WallRule};
pub use describe::Line;
pub use drive::{Axis, Drive, DrivingForce, MeanVelocity, VaryingForce};
pub use fault::{AXES, Check, Fault};
pub use measure::{Measure, Reference, When, Which};
pub use measure_kind::MeasureKind;
pub use message::suggest;
pub use obstacle::{Heights, Obstacle, Outlines, Surface, Wall};
pub use orientation::{About, By, Orientation};
pub use output::{Cadence, Checkpoints, FixedRows, Output, Removed, Section};
pub use over_time::OverTime;
pub use particle::{Enter, Lock, Motion, Oscillation, Particle, Prescribed, Spin};
pub use preset::Preset;
pub use pressure::{History, Petsc, Pressure, Solver};
pub use read::{Loaded, Text, load, written};
pub use reference::{reference, schema};
pub use shape::solid::{Shape, Solid};
pub use shape::{
    Ball, Clump, Ellipse, Ellipsoid, Like, Listed, Polygon, Polyhedron, Round, Superquadric, Typed,
};
pub use speeds::{Stream, driven_speed, fluid_speed, stream};
pub use statistics::{Probe, Statistics};
pub use swarm::{Diameters, Feed, Kind, Orientations, Range, Region, Swarm};
pub use time::{Advection, Scheme, Step, Time};

use message::unnamed;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// The material of particles that name none.
pub const DEFAULT_MATERIAL: &str = Particle::DEFAULT_MATERIAL;

/// A whole case. One that has been read has all keys filled in and its swarms among its particles.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// The case's name; the run folder is `runs/NAME` unless `--out` names another.
    pub name: String,
    /// Fills keys that neither the file nor `--set` gives.
    pub preset: Option<Preset>,
    /// The box and its grid.
    pub domain: Domain,
    /// The carrier fluid.
    pub fluid: Fluid,
    /// One condition per side of the box.
    pub boundary: Boundary,
    /// Bodies, one by one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub particle: Vec<Particle>,
    /// Many bodies at once; they become entries of `particle`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub swarm: Vec<Swarm>,
    /// Walls of any shape in the box.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacle: Vec<Obstacle>,
    /// The fluid at time 0.
    #[serde(default)]
    pub initial: Initial,
    /// Drive of the fluid besides its boundaries; default none.
    pub drive: Option<Drive>,
    /// Coupling of fluid and particles.
    #[serde(default)]
    pub coupling: Coupling,
    /// Contacts of bodies with each other and the walls; without this table a touch ends the run.
    pub contact: Option<Contact>,
    /// Time stepping.
    pub time: Time,
    /// The pressure equation and its stopping rule.
    #[serde(default)]
    pub pressure: Pressure,
    /// Raw PETSc options.
    #[serde(default)]
    pub petsc: Petsc,
    /// Numbers that `summary.json` reports.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measure: Vec<Measure>,
    /// Means over time; default none.
    pub statistics: Option<Statistics>,
    /// Velocity and pressure recorded at points.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub probe: Vec<Probe>,
    /// Files that are written, and how often.
    #[serde(default)]
    pub output: Output,
}

/// The names of the sides of the box: side `f` closes axis `f / 2`, opposite `f ^ 1`.
pub const SIDES: [&str; 6] = ["west", "east", "south", "north", "bottom", "top"];

impl Case {
    /// 2 or 3: how many numbers `domain.size` has.
    pub fn dimension(&self) -> usize {
        self.domain.size.len()
    }

    /// The sides of the box by name, each with its condition.
    pub fn sides(&self) -> impl Iterator<Item = (&'static str, &Side)> {
        let sides = SIDES.into_iter().enumerate();
        sides.filter_map(|(number, name)| Some((name, self.boundary.side(number)?)))
    }

    /// Whether there is anything in the fluid: a particle, or an obstacle.
    pub fn has_bodies(&self) -> bool {
        !self.particle.is_empty() || !self.obstacle.is_empty()
    }

    /// Cross-sections of the free particles together, over the least cross-section of the box:
    /// how many others a free particle meets on its way along the box. Above 1 they are a crowd,
    /// of which meetings soon part the paths of any two runs, so that means alone count.
    pub fn crowding(&self) -> f64 {
        let section = |d: f64| if self.dimension() == 2 { d } else { 0.25 * PI * d * d };
        let free = self.particle.iter().filter(|particle| particle.is_free());
        let sections: f64 = free.map(|particle| section(particle.shape.diameter())).sum();
        let longest = self.domain.size.iter().copied().fold(0.0, f64::max);
        sections * longest / self.domain.size.iter().product::<f64>()
    }

    /// Whether the sides that close this axis are joined.
    pub fn periodic(&self, axis: usize) -> bool {
        self.boundary.side(2 * axis) == Some(&Side::Periodic)
    }

    /// The spacing of the grid along each axis (m).
    pub fn spacings(&self) -> Vec<f64> {
        self.domain.size.iter().zip(&self.domain.cells).map(|(l, n)| l / *n as f64).collect()
    }

    /// The widest spacing of the grid (m).
    pub fn widest_spacing(&self) -> f64 {
        self.spacings().into_iter().fold(0.0, f64::max)
    }

    /// The axis of the height above the bed on a side across an `axis`, that of gravity where it
    /// lies in the side, else the first along it; and whether the bed is at its high end.
    pub fn height(&self, axis: usize) -> (usize, bool) {
        let gravity = |a: usize| self.fluid.gravity.get(a).copied().unwrap_or(0.0);
        let along = (0..self.dimension()).filter(|a| *a != axis);
        let height = along.reduce(|a, b| if gravity(b).abs() > gravity(a).abs() { b } else { a });
        height.map_or((axis, false), |height| (height, gravity(height) > 0.0))
    }

    /// The length (m) of each axis whose sides are joined.
    fn periods(&self) -> Vec<Option<f64>> {
        let sizes = self.domain.size.iter().enumerate();
        sizes.map(|(axis, size)| self.periodic(axis).then_some(*size)).collect()
    }

    /// The speed that coefficients refer to (m/s): that of [`Case::reference_velocity`].
    pub fn reference_speed(&self) -> Option<f64> {
        self.reference_velocity().map(|velocity| length(&velocity))
    }

    /// The stream (m/s): the fastest inflow's velocity; without one, the mean velocity that is
    /// held, both at the largest factor of their tables over time; without one, the initial
    /// velocity; without one, the fastest moving wall's. `None` where all of these rest.
    pub fn reference_velocity(&self) -> Option<Vec<f64>> {
        let fastest = |all: &mut dyn Iterator<Item = Vec<f64>>| {
            // The first of those that are alike.
            all.filter(|v| length(v) > 0.0)
                .reduce(|a, b| if length(&b) > length(&a) { b } else { a })
        };
        let sides = || self.sides().map(|(_, side)| side);
        let moving = |s: &Side| if let Side::MovingWall(v) = s { Some(v.clone()) } else { None };
        let held = self.drive.as_ref().and_then(|drive| {
            let Drive::MeanVelocity(held) = drive else { return None };
            let mut mean = vec![0.0; self.dimension()];
            mean[held.axis.index()] = drive.largest_factor() * held.value;
            Some(mean)
        });
        let strongest = |s: &Side| -> Vec<Vec<f64>> {
            let factor = s.over_time().map_or(1.0, OverTime::largest);
            s.inflow().iter().map(|v| v.iter().map(|v| factor * v).collect()).collect()
        };
        fastest(&mut sides().flat_map(strongest))
            .or_else(|| fastest(&mut held.into_iter()))
            .or_else(|| fastest(&mut [self.initial.velocity.clone()].into_iter()))
            .or_else(|| fastest(&mut sides().filter_map(moving)))
    }

    /// Label of a body: its name, with its number where others have the name too; without a name
    /// its number, from 0. Obstacles follow the particles.
    pub fn called(&self, id: usize) -> String {
        let name = |p: &Particle| p.name.clone();
        let wall =
            id.checked_sub(self.particle.len()).and_then(|k| Some((k, self.obstacle.get(k)?)));
        if let Some((k, obstacle)) = wall {
            return obstacle.name.clone().unwrap_or(format!("obstacle {k}"));
        }
        match self.particle.get(id).and_then(name) {
            None => format!("particle {id}"),
            Some(own)
                if self
                    .particle
                    .iter()
                    .filter(|p| p.name.as_ref() == Some(&own))
                    .nth(1)
                    .is_none() =>
            {
                own
            }
            Some(own) => format!("{own} {id}"),
        }
    }

    /// The particles of a number, from 0, or of a name, or the obstacles of a name, whose numbers
    /// follow those of the particles.
    ///
    /// # Errors
    /// When there is none, in words.
    pub fn find(&self, wanted: &str) -> Result<Vec<usize>, String> {
        let count = self.particle.len();
        if let Ok(id) = wanted.parse::<usize>() {
            let unknown =
                || format!("there is no particle {id}: the case has {count}, counted from 0");
            return (id < count).then(|| vec![id]).ok_or_else(unknown);
        }
        let particles = self.particle.iter().map(|p| p.name.as_deref());
        let names: Vec<_> =
            particles.chain(self.obstacle.iter().map(|o| o.name.as_deref())).collect();
        let ids: Vec<usize> = (0..names.len()).filter(|id| names[*id] == Some(wanted)).collect();
        let known = names.iter().flatten().copied();
        if ids.is_empty() { Err(unnamed("particle", wanted, known)) } else { Ok(ids) }
    }

    /// The case as TOML, of one that has been read.
    pub fn to_toml(&self) -> String {
        write::toml(self)
    }
}

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

fn length(v: &[f64]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// The box, from the origin to `size`, cut into equal cells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Edge lengths (m); two numbers make a 2D case, three a 3D one.
    pub size: Vec<f64>,
    /// Cells along each edge; at least 6, beside bodies 7, and up to 11 where cells are longer than
    /// wide.
    pub cells: Vec<usize>,
}

/// The carrier fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// Density (kg/m3), positive.
    pub density: f64,
    /// Dynamic viscosity (Pa s), zero (inviscid) or positive.
    pub viscosity: f64,
    /// Gravity (m/s2), a number for each axis; default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gravity: Vec<f64>,
}

impl Fluid {
    /// Kinematic viscosity (m2/s).
    pub fn kinematic_viscosity(&self) -> f64 {
        self.viscosity / self.density
    }

    /// Size of gravity (m/s2).
    pub fn weight(&self) -> f64 {
        length(&self.gravity)
    }
}

/// The fluid at time 0.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Initial {
    /// The folder of a run that has ended: its bodies come first, before the case's own, and its
    /// flow goes on. On the same grid with the same bodies and walls contacts and pressure go on
    /// too; otherwise the velocity is interpolated. Boundaries, drive, materials and fluid are
    /// those of this case.
    pub from: Option<String>,
    /// Whether this file lists the bodies of that run already, as the case.toml of a run does;
    /// default no.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub listed: bool,
    /// Number of particles that come from that run.
    #[serde(skip)]
    pub inherited: usize,
    /// Uniform velocity (m/s); default that which the inflow is given at time 0, of
    /// `inflow_profile` that of its middle, or rest.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub velocity: Vec<f64>,
    /// Largest speed V (m/s) of an added Taylor-Green vortex (1937) in a periodic box, default
    /// none: `u = V sin X cos Y cos Z, v = -V (Ly/Lx) cos X sin Y cos Z`, X = 2 pi x/Lx, without Z
    /// in 2D.
    pub taylor_green: Option<f64>,
    /// Couette flow along this axis, added: linear from the velocity of its low wall to that of its
    /// high one, where one of them moves at least. Default none.
    pub couette: Option<Axis>,
    /// Amplitude (m/s) of a reproducible random disturbance of every cell, which breaks the
    /// symmetry of a wake.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub perturbation: f64,
}
