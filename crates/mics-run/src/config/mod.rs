//! What the user typed, and what it means: a case file becomes a [`raw::Case`], is checked, and is
//! resolved once into a [`Case`] of plain values. Pure data; the solver's `scene` alone turns it
//! into a running scene.
//!
//! ```text
//!   case.toml, --set, preset  ->  document  ->  raw::Case  ->  checked  ->  Case  ->
//!              scene, run, check, output
//!         keys and their lines                  options         swarms      values
//!                                                                expanded     |
//!   case.toml of the run      <-------------  raw::Case, every key given  <---+
//! ```
//! A default that stands by itself belongs to its key, in [`raw`]; one that depends on other keys
//! is given where the case is resolved. Nobody after that asks whether a key was given. SI units
//! are named throughout; any consistent set works.

#[macro_use]
mod fault;
mod change;
mod describe;
mod direction;
mod document;
mod message;
pub mod raw;
mod read;
mod reference;
mod resolve;
mod resolved;
mod speeds;
mod write;

pub use raw::obstacle::Wall;
pub use raw::shape::solid::{Shape, Solid};
pub use raw::{
    Advection, Axis, Cadence, Checkpoints, Contact, Coupling, Damping, Domain, Drive, FACES,
    FixedRows, Fluid, ForceRule, History, Initial, Lock, Loss, MOST_SUBSTEPS, MeanVelocity,
    MeasureKind, Orientation, Oscillation, Output, Pair, PairLaw, Petsc, Preset, Pressure, Probe,
    Profile, Reference, Region, Removed, Round, Scheme, Section, Side, Solver, Statistics, Step,
    Stiffness, Substeps, TangentialDamping, Time, WALL, WallRule, When,
};
pub use read::{Loaded, load, schema};
pub use reference::reference;
pub use resolved::{Case, Enter, Measure, Motion, Obstacle, Particle, Target};

/// The material of particles that name none.
pub const DEFAULT_MATERIAL: &str = raw::Particle::DEFAULT_MATERIAL;

pub use fault::{Check, Fault};
pub use message::suggest;
pub use read::Text;
pub use read::written;
