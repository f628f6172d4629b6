//! A number that a run reports: of what it is taken, from when on, and what it ought to be.

use super::{Axis, ForceRule, MeasureKind, Region};
use crate::words::rounded;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// One number that `summary.json` reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Its name in `summary.json`.
    pub name: String,
    /// What is measured.
    pub kind: MeasureKind,
    /// Of which particle: its number in the case, from 0, or its name; default the first.
    #[serde(default)]
    pub particle: Which,
    /// Of which particles, where the kind is of several: numbers, from 0, and names, of which one
    /// may be that of many; default all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub particles: Option<Vec<Which>>,
    /// Along which axis, where the kind is of the whole box; default that of the drive or of the
    /// stream, of `bed_height` that of gravity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<Axis>,
    /// Of which part of the box, for `solid_fraction`; default all of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<Region>,
    /// From which solid fraction on `bed_height` counts a layer, default 0.1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
    /// The direction that a force is taken along, of any length. Default: of drag, `force` and
    /// `force_noise` along the stream, of lift and Strouhal numbers across it: in 2D the stream
    /// turned by +90 degrees, in 3D the axis after the stream's (x, y, z, x); of `lift_magnitude`
    /// the direction is the stream's, and what counts is across it. The stream is the inflow, the
    /// initial velocity or a moving wall, less a prescribed particle's velocity; without any it is
    /// along a swing, or past a free particle that gravity pulls.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<Vec<f64>>,
    /// From this time on (s).
    #[serde(default)]
    pub from: f64,
    /// When, for a place, a velocity or a spin: at a time (s), `when = { time = 0.5 }`, as the
    /// particle's centre first passes a coordinate (m), `when = { y = 0.075 }`, or as it first
    /// touches something, as `contact_start` says it, `when = "contact"`. Without it a place is
    /// that of the end, and a velocity or a spin the mean.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub when: Option<When>,
    /// Reference speed (m/s), default the inflow's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Which force, default the coupling's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<ForceRule>,
    /// What the value ought to be: a number, or a band `[low, high]`. It is of the flow that the
    /// file describes: where `--set` changes the box's size, the fluid, its sides, its start or
    /// the particles, it is dropped. The band of a particle's position is drawn with its path by
    /// `mics plot`, under the name of its source.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// How far from the reference still passes, as a part of it (0.02 is 2 %); of a band, as a part
    /// of its middle and beyond its ends, default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Where the reference is from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

/// A particle, or several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a particle is its index in the case, from 0, or its name in quotes")]
pub enum Which {
    /// That of this index.
    Id(usize),
    /// All of this name.
    Named(String),
}

impl Which {
    /// Its index; of a name that has not been looked up, no particle's.
    pub fn id(&self) -> usize {
        if let Which::Id(id) = self { *id } else { usize::MAX }
    }
}

impl Default for Which {
    fn default() -> Self {
        Which::Id(0)
    }
}

/// The moment at which a measure of a particle is taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum When {
    /// At the end of the first step in which the particle touches another or a wall.
    Contact,
    /// As the particle's centre first passes this x (m), interpolated between two steps.
    X(f64),
    /// As it first passes this y (m).
    Y(f64),
    /// As it first passes this z (m), 3D only.
    Z(f64),
    /// At this time (s), interpolated between two steps.
    Time(f64),
}

/// What a measure ought to be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a reference is one number or a band [low, high]")]
pub enum Reference {
    /// This value, not 0.
    Value(f64),
    /// Anything from the first to the second.
    Band([f64; 2]),
}

impl Reference {
    /// The value, or the middle of the band: what errors are taken against.
    pub fn middle(self) -> f64 {
        match self {
            Reference::Value(value) => value,
            Reference::Band([low, high]) => 0.5 * (low + high),
        }
    }

    /// Whether `value` is within `tolerance`, a part of the middle.
    pub fn holds(self, value: f64, tolerance: f64) -> bool {
        let room = tolerance * self.middle().abs();
        let [low, high] = match self {
            Reference::Value(value) => [value; 2],
            Reference::Band(band) => band,
        };
        (low - room..=high + room).contains(&value)
    }
}

impl fmt::Display for Reference {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Reference::Value(value) => f.write_str(&rounded(*value)),
            Reference::Band([low, high]) => write!(f, "{} to {}", rounded(*low), rounded(*high)),
        }
    }
}
