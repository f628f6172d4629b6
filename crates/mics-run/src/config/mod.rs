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
mod change;
mod describe;
mod document;
mod message;
mod names;
pub mod raw;
mod read;
mod reference;
mod speeds;
mod write;

pub use raw::obstacle::Wall;
pub use raw::shape::solid::{Shape, Solid};
pub use raw::{
    Advection, Axis, Cadence, Case, Checkpoints, Contact, Coupling, Damping, Domain, Drive, Enter,
    FACES, FixedRows, Fluid, ForceRule, History, Initial, Lock, Loss, MOST_SUBSTEPS, MeanVelocity,
    Measure, MeasureKind, Motion, Obstacle, Orientation, Oscillation, Output, Pair, PairLaw,
    Particle, Petsc, Prescribed, Preset, Pressure, Probe, Profile, Reference, Region, Removed,
    Round, Scheme, Section, Side, Solver, Spin, Statistics, Step, Stiffness, Substeps,
    TangentialDamping, Time, WALL, WallRule, When, Which,
};
pub use read::{Loaded, load};
pub use reference::{reference, schema};

/// The material of particles that name none.
pub const DEFAULT_MATERIAL: &str = raw::Particle::DEFAULT_MATERIAL;

pub use describe::Line;
pub use fault::{AXES, Check, Fault};
pub use message::suggest;
pub use read::Text;
pub use read::written;
pub use speeds::Stream;
