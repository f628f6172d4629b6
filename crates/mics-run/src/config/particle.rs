//! Bodies, one by one.

mod check;
mod overlap;

use super::shape::solid::Shape;
use super::{Case, Fluid, Orientation, Region, Typed};
pub(super) use check::{Nature, below_periods, inside, motion, particle, printable};
use nalgebra::UnitQuaternion;
pub(super) use overlap::{Overlap, distance, overlap, slack};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// One body.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Particle {
    /// Name in measures and figures; several may share it. Numbers count from 0, `[[particle]]`
    /// before `[[swarm]]`.
    pub name: Option<String>,
    /// Its shape.
    #[schemars(with = "Typed")]
    pub shape: Shape,
    /// Orientation at time 0: degrees in 2D, `{ axis = [0, 0, 1], degrees = 30 }` in 3D; default
    /// its own axes are along those of the box.
    pub orientation: Option<Orientation>,
    /// Density (kg/m3), default the fluid's.
    pub density: Option<f64>,
    /// Viscosity inside the particle (Pa s), default the fluid's; the paper has 0.
    pub viscosity: Option<f64>,
    /// Centre at time 0 (m).
    pub position: Vec<f64>,
    /// Its motion; default free.
    #[serde(default)]
    pub motion: Motion,
    /// Velocity of a free particle at time 0 (m/s), default zero.
    pub velocity: Option<Vec<f64>>,
    /// Angular velocity of a free particle at time 0 (rad/s), default zero.
    pub spin: Option<Spin>,
    /// Directions in which a free particle keeps its velocity; default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub locked: Vec<Lock>,
    /// Its name in `[[contact.pair]]`, default `default`.
    pub material: Option<String>,
    /// When and where it enters the box, default at time 0 at its position; without `velocity` at
    /// that of the fluid there.
    pub enter: Option<Enter>,
}

/// Entry of a free body during the run: at the end of the first step after its time in which its
/// place is free. It shares its momentum with the fluid: a disc of density ratio s in fluid at rest
/// keeps s/(s + 1) of its velocity.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Enter {
    /// When (s).
    pub time: f64,
    /// Where: at random in this part of the box; default at its position.
    pub region: Option<Region>,
    /// Least distance to bodies and walls then (m).
    #[serde(default)]
    pub gap: f64,
    /// Seed of the random numbers.
    #[serde(default = "one")]
    pub seed: u64,
}

fn one() -> u64 {
    1
}

impl Particle {
    /// Range of places at which its centre may enter the box, by axis: start and length (m).
    pub fn entrance(&self, case: &Case) -> Vec<(f64, f64)> {
        let here = || self.position.iter().map(|x| (*x, 0.0)).collect();
        let region =
            self.enter.as_ref().and_then(|enter| Some((enter.region.as_ref()?, enter.gap)));
        region
            .and_then(|(region, gap)| region.room(case, gap, self.shape.bounding_diameter()))
            .unwrap_or_else(here)
    }

    /// Extent from its centre along an axis (m), to the low and to the high side.
    pub fn reach(&self, axis: usize) -> [f64; 2] {
        match self.shape.solid() {
            Some(solid) => solid.reach(axis, &self.turn()),
            None => [0.5 * self.shape.diameter(); 2],
        }
    }

    /// Rotation from its own axes to those of the box at time 0.
    pub fn turn(&self) -> UnitQuaternion<f64> {
        self.orientation.as_ref().map_or(UnitQuaternion::identity(), Orientation::quaternion)
    }

    /// The angle (rad) about z by which it is turned at time 0 in 2D.
    pub fn angle(&self) -> f64 {
        self.orientation.as_ref().map_or(0.0, Orientation::angle)
    }

    /// Whether forces and contacts move it.
    pub fn is_free(&self) -> bool {
        self.motion == Motion::Free
    }

    /// Density (kg/m3) of a particle of a case that has been read.
    pub fn density(&self) -> f64 {
        self.density.unwrap_or(f64::NAN)
    }

    /// Viscosity (Pa s) inside a particle of a case that has been read.
    pub fn viscosity(&self) -> f64 {
        self.viscosity.unwrap_or(f64::NAN)
    }

    /// Velocity (m/s) of a free particle at time 0, a number for each axis.
    pub fn velocity(&self) -> Vec<f64> {
        self.velocity.clone().unwrap_or_else(|| vec![0.0; self.position.len()])
    }

    /// Fills in the keys that are not given.
    pub(in crate::config) fn fill(&mut self, fluid: &Fluid) {
        self.density.get_or_insert(fluid.density);
        self.viscosity.get_or_insert(fluid.viscosity);
        self.material.get_or_insert_with(|| Self::DEFAULT_MATERIAL.to_owned());
        let dimension = self.position.len();
        if self.is_free() {
            self.spin.get_or_insert(Spin::none(dimension));
            // A particle that enters without a velocity takes that of the fluid.
            if self.enter.is_none() {
                self.velocity.get_or_insert_with(|| vec![0.0; dimension]);
            }
        }
        self.motion.fill(dimension);
    }

    /// The name of its material where none is given.
    pub const DEFAULT_MATERIAL: &str = "default";

    /// The name of its material.
    pub fn material(&self) -> &str {
        self.material.as_deref().unwrap_or(Self::DEFAULT_MATERIAL)
    }
}

/// A direction in which a free body keeps its velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Lock {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z, 3D only.
    Z,
    /// All rotation.
    Rotation,
}

/// Motion of a body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Motion {
    /// Forces and contacts move it.
    #[default]
    Free,
    /// It rests.
    Fixed,
    /// Its motion is given.
    Prescribed(Prescribed),
}

impl Motion {
    /// Fills in the keys that a prescribed motion leaves out.
    pub(in crate::config) fn fill(&mut self, dimension: usize) {
        if let Motion::Prescribed(told) = self {
            told.velocity.resize(dimension, 0.0);
            told.spin.get_or_insert(Spin::none(dimension));
        }
    }

    /// Its name, as a case has it.
    pub fn name(&self) -> &'static str {
        match self {
            Motion::Free => "free",
            Motion::Fixed => "fixed",
            Motion::Prescribed(_) => "prescribed",
        }
    }
}

/// A given motion: constant velocity and spin, and an oscillation.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Prescribed {
    /// Velocity of the centre (m/s), a number for each axis; default zero.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub velocity: Vec<f64>,
    /// Angular velocity (rad/s), default zero.
    pub spin: Option<Spin>,
    /// Added oscillation of the centre; default none.
    pub oscillation: Option<Oscillation>,
}

impl Prescribed {
    /// The angular velocity (rad/s) about x, y and z.
    pub fn about(&self) -> [f64; 3] {
        self.spin.map_or([0.0; 3], Spin::about)
    }

    /// Whether it turns.
    pub fn turns(&self) -> bool {
        self.about() != [0.0; 3]
    }
}

/// An oscillation: the centre is at `position + velocity t + amplitude sin(2 pi frequency t)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Oscillation {
    /// Amplitude along each axis (m); negative: it starts the other way.
    pub amplitude: Vec<f64>,
    /// Frequency (1/s), positive.
    pub frequency: f64,
}

impl Oscillation {
    /// Largest speed of the motion to and fro (m/s).
    pub fn speed(&self) -> f64 {
        TAU * self.frequency * self.amplitude.iter().map(|a| a * a).sum::<f64>().sqrt()
    }
}

/// An angular velocity: one number in 2D, three in 3D (rad/s).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a spin is one number in 2D, three in 3D (rad/s)")]
pub enum Spin {
    /// About z, positive from x to y.
    Plane(f64),
    /// About x, y, z.
    Space([f64; 3]),
}

impl Spin {
    /// The spin of a body that does not rotate: zero in this dimension.
    fn none(dimension: usize) -> Spin {
        if dimension == 2 { Spin::Plane(0.0) } else { Spin::Space([0.0; 3]) }
    }

    /// About x, y and z (rad/s).
    pub fn about(self) -> [f64; 3] {
        match self {
            Spin::Plane(z) => [0.0, 0.0, z],
            Spin::Space(spin) => spin,
        }
    }
}
