//! A case with nothing left open. Its fields have the names of the file's tables and keys; an
//! `Option` is physics that the case does without.

use super::raw::obstacle::Wall;
use super::raw::shape::solid::Shape;
use super::raw::{
    Contact, Coupling, Domain, Drive, FACES, Fluid, ForceRule, Initial, Lock, MeasureKind,
    Orientation, Oscillation, Output, Petsc, Preset, Pressure, Probe, Reference, Region, Side,
    Statistics, Time, When,
};

use nalgebra::{UnitQuaternion, Vector3};

/// A whole case, every default filled in.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The case's name.
    pub name: String,
    /// The preset that filled in keys, where one did.
    pub preset: Option<Preset>,
    /// The box and its grid.
    pub domain: Domain,
    /// The carrier fluid.
    pub fluid: Fluid,
    /// For each axis, the conditions at its low and its high face.
    pub boundary: Vec<[Side; 2]>,
    /// Bodies, those of swarms among them.
    pub particle: Vec<Particle>,
    /// Walls of any shape. As bodies they have the numbers that follow the particles'.
    pub obstacle: Vec<Obstacle>,
    /// The fluid at time 0.
    pub initial: Initial,
    /// What moves the fluid besides its boundaries.
    pub drive: Option<Drive>,
    /// How fluid and particles meet.
    pub coupling: Coupling,
    /// How bodies meet each other and the walls; without it a touch ends the run.
    pub contact: Option<Contact>,
    /// Time stepping.
    pub time: Time,
    /// The pressure equation and its stopping rule.
    pub pressure: Pressure,
    /// Raw PETSc options.
    pub petsc: Petsc,
    /// What `summary.json` reports.
    pub measure: Vec<Measure>,
    /// Means over time.
    pub statistics: Option<Statistics>,
    /// What is recorded at points.
    pub probe: Vec<Probe>,
    /// What is written, and how often.
    pub output: Output,
    /// The speed that coefficients refer to (m/s), `None` where nothing moves at the start: the
    /// fastest inflow's; without one, the mean velocity that is held; without one, the initial
    /// velocity's; without one, the fastest moving wall's.
    pub reference_speed: Option<f64>,
    /// The stream that has it (m/s).
    pub stream: Option<Vec<f64>>,
}

impl Case {
    /// 2 or 3: how many numbers `domain.size` has.
    pub fn dimension(&self) -> usize {
        self.domain.size.len()
    }

    /// The spacing of the grid along each axis (m).
    pub fn spacings(&self) -> Vec<f64> {
        self.domain
            .size
            .iter()
            .zip(&self.domain.cells)
            .map(|(size, cells)| size / *cells as f64)
            .collect()
    }

    /// The faces of the box by name, each with its condition.
    pub fn sides(&self) -> impl Iterator<Item = (&'static str, &Side)> {
        FACES.into_iter().zip(self.boundary.iter().flatten())
    }

    /// Whether there is anything in the fluid: a particle, or an obstacle.
    pub fn has_bodies(&self) -> bool {
        !self.particle.is_empty() || !self.obstacle.is_empty()
    }

    /// Whether the sides that close this axis are joined.
    pub fn periodic(&self, axis: usize) -> bool {
        self.boundary[axis][0] == Side::Periodic
    }
}

/// One body.
#[derive(Clone, Debug, PartialEq)]
pub struct Particle {
    /// What measures know it by.
    pub name: Option<String>,
    /// Its shape.
    pub shape: Shape,
    /// Density (kg/m3).
    pub density: f64,
    /// Viscosity inside the particle (Pa s).
    pub viscosity: f64,
    /// Centre at time 0 (m), a number for each axis.
    pub position: Vec<f64>,
    /// How it is turned at time 0, as the case gives it.
    pub orientation: Option<Orientation>,
    /// What moves it.
    pub motion: Motion,
    /// The name of its material.
    pub material: String,
    /// How it comes in; `None` of one that is there at time 0.
    pub enter: Option<Enter>,
}

/// How a body comes into the box while the run goes on.
#[derive(Clone, Debug, PartialEq)]
pub struct Enter {
    /// When at the earliest (s).
    pub time: f64,
    /// The part of the box that it comes into, as the case gives it.
    pub region: Option<Region>,
    /// Where its centre may be, by axis: from, and how far (m).
    pub entrance: Vec<(f64, f64)>,
    /// Least distance to other bodies and to walls then (m).
    pub gap: f64,
    /// What the random numbers begin with.
    pub seed: u64,
    /// Its velocity then (m/s); `None` where it takes that of the fluid in its place.
    pub velocity: Option<Vec<f64>>,
}

impl Particle {
    /// Whether forces and contacts move it.
    pub fn is_free(&self) -> bool {
        matches!(self.motion, Motion::Free { .. })
    }

    /// What brings its own axes into those of the box at time 0.
    pub fn turn(&self) -> UnitQuaternion<f64> {
        self.orientation.as_ref().map_or(UnitQuaternion::identity(), Orientation::quaternion)
    }

    /// The angle (rad) about z by which it is turned at time 0 in 2D.
    pub fn angle(&self) -> f64 {
        self.orientation.as_ref().map_or(0.0, Orientation::angle)
    }
}

/// A wall of any shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// What measures know it by.
    pub name: Option<String>,
    /// What it is.
    pub wall: Wall,
    /// What moves it: nothing, or a given motion.
    pub motion: Motion,
    /// The name of its material.
    pub material: String,
}

/// What moves a body. Velocities (m/s) have a number for each axis; spins (rad/s) are about x, y
/// and z, in 2D about z alone.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Forces and contacts move it.
    Free {
        /// Velocity of its centre at time 0 (m/s).
        velocity: Vec<f64>,
        /// Angular velocity at time 0 (rad/s).
        spin: [f64; 3],
        /// Directions in which it keeps its velocity whatever the forces.
        locked: Vec<Lock>,
    },
    /// It rests.
    Fixed,
    /// Its motion is given.
    Prescribed {
        /// Velocity of its centre (m/s).
        velocity: Vec<f64>,
        /// Angular velocity (rad/s).
        spin: [f64; 3],
        /// What the centre does besides.
        oscillation: Option<Oscillation>,
    },
}

/// One number that `summary.json` reports.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// Its name in `summary.json`.
    pub name: String,
    /// What is measured.
    pub kind: MeasureKind,
    /// Of which body: the index of a particle in the case, or of an obstacle, which follow them.
    pub particle: usize,
    /// Of which particles, of a kind that is of several.
    pub particles: Vec<usize>,
    /// Along which axis, of a kind that is of the whole box.
    pub axis: usize,
    /// The lowest and the highest corner (m) of a part of the box.
    pub region: Option<[Vec<f64>; 2]>,
    /// From which solid fraction on a layer counts.
    pub threshold: f64,
    /// Along which direction, of length 1; `None` of what is of no force, or of a swing.
    pub direction: Option<Vector3<f64>>,
    /// From this time on (s).
    pub from: f64,
    /// The moment at which it is taken; `None` of what is a mean, an extremum or the end's.
    pub when: Option<When>,
    /// Reference speed (m/s); `None` of what is neither a coefficient nor a frequency.
    pub speed: Option<f64>,
    /// Reference length (m); `None` for that of the particle.
    pub length: Option<f64>,
    /// Which force.
    pub force: ForceRule,
    /// What it ought to be, where that is known.
    pub target: Option<Target>,
}

impl Measure {
    /// Whether it is the same number as another measure, whatever that is compared with.
    pub fn is_of(&self, other: &Measure) -> bool {
        Measure { target: None, ..self.clone() } == Measure { target: None, ..other.clone() }
    }
}

/// What a measure ought to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// A number or a band.
    pub reference: Reference,
    /// How far from the reference still passes, as a part of it; of a band, of its middle and
    /// beyond its ends.
    pub tolerance: f64,
    /// Where the reference is from, if the case says it.
    pub source: Option<String>,
}
