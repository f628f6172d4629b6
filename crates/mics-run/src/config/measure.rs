//! A number that a run reports: its subject, its span of time, and its expected value.

use super::{Axis, Case, ForceRule, MeasureKind, Motion, Region};
use crate::words::rounded;
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// One number that `summary.json` reports.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Its name in `summary.json`.
    pub name: String,
    /// Quantity that is measured.
    pub kind: MeasureKind,
    /// Its particle: number in the case, from 0, or name; default the first.
    #[serde(default)]
    pub particle: Which,
    /// Its obstacle, in place of a particle: number from 0, or name.
    pub obstacle: Option<Which>,
    /// Its particles, for kinds of several: numbers and names; default all, of grains of a bed all
    /// that are not fixed.
    pub particles: Option<Vec<Which>>,
    /// Its axis, for kinds of the whole box; default that of the drive or the stream, of
    /// `bed_height` gravity's.
    pub axis: Option<Axis>,
    /// Part of the box, for `solid_fraction`, `bed_shear_stress` and `shields`; default all of it.
    pub region: Option<Region>,
    /// Least solid fraction of a layer for `bed_height` and what is taken above it, default 0.1.
    pub threshold: Option<f64>,
    /// Direction of a force, of any length; of `lift_magnitude` that of the stream; of `torque` in
    /// 3D the axis, default z. Default: drag,
    /// `force` and `force_noise` along the stream; lift and Strouhal numbers across it, in 2D
    /// turned by +90 degrees, in 3D the next axis (x, y, z, x). The stream is the inflow, the
    /// initial velocity or a moving wall, less a prescribed velocity; otherwise it is along an
    /// oscillation or gravity.
    pub direction: Option<Vec<f64>>,
    /// Point about which `torque` is taken (m), default the centre of the particle or obstacle:
    /// `T_about = T_centre + (centre - about) x F`, with the centre as it lies in the box.
    pub about: Option<Vec<f64>>,
    /// From this time on (s).
    #[serde(default)]
    pub from: f64,
    /// Moment of a place, angle, velocity or spin: `{ time = 0.5 }` (s), `{ y = 0.075 }` as the
    /// centre first passes there (m), or `"contact"`. Default: a place or angle at the end, the
    /// mean of a velocity or spin.
    pub when: Option<When>,
    /// Reference speed (m/s), default the inflow's, at the largest factor of its `over_time`.
    pub speed: Option<f64>,
    /// Reference length (m) of a coefficient or a Strouhal number, default the diameter of the disc
    /// or sphere of the particle's volume.
    pub length: Option<f64>,
    /// Definition of the force; default the coupling's.
    pub force: Option<ForceRule>,
    /// Expected value: a number, or a band `[low, high]`. Dropped where `--set` changes the box's
    /// size, the fluid, the boundaries, the start or the particles. `mics plot` draws the band of a
    /// position beside the path.
    pub reference: Option<Reference>,
    /// Allowed difference as a part of the reference (0.02 is 2 %); of a band beyond its ends, as a
    /// part of its middle; default 0.
    pub tolerance: Option<f64>,
    /// Where the reference is from.
    pub source: Option<String>,
}

/// The solid fraction of the top of a bed.
const BED_FRACTION: f64 = 0.1;

impl Measure {
    /// Fills in the keys that are not given, with the direction and the axis that it is along.
    pub(super) fn fill(&mut self, case: &Case, direction: Option<Vector3<f64>>, axis: usize) {
        let dimension = case.dimension();
        if self.kind.is_of_group() && self.particles.is_none() {
            let counts = |id: &usize| {
                !self.kind.is_of_grains() || case.particle[*id].motion != Motion::Fixed
            };
            let all = (0..case.particle.len()).filter(counts);
            self.particles = Some(all.map(Which::Id).collect());
        }
        if self.kind.has_axis() {
            self.axis = Some([Axis::X, Axis::Y, Axis::Z][axis]);
        }
        if self.kind.has_threshold() {
            self.threshold.get_or_insert(BED_FRACTION);
        }
        // In 2D a torque is about z, which is no direction there.
        if dimension == 3 || self.kind != MeasureKind::Torque {
            self.direction = direction.map(|v| v.iter().take(dimension).copied().collect());
        }
        if self.kind.needs_speed() {
            self.speed = self.speed.or(case.reference_speed());
        }
        if self.kind.is_of_force() {
            self.force.get_or_insert(case.coupling.wall.force());
        } else {
            self.force = None;
        }
    }

    /// The numbers of the particles of a kind that is of several.
    pub fn group(&self) -> impl Iterator<Item = usize> {
        self.particles.iter().flatten().map(Which::id)
    }

    /// The number of its axis, of a kind that is of the whole box.
    pub fn axis(&self) -> usize {
        self.axis.map_or(0, Axis::index)
    }

    /// Its direction, a unit vector; `None` without a force, or for a fit of Morison's formula.
    pub fn direction(&self) -> Option<Vector3<f64>> {
        match &self.direction {
            Some(v) => Some(vector(v)),
            None => (self.kind == MeasureKind::Torque).then(Vector3::z),
        }
    }

    /// The point about which its torque is taken (m); `None` for the body's centre.
    pub fn about(&self) -> Option<Vector3<f64>> {
        self.about.as_deref().map(vector)
    }

    /// Definition of the force, for a kind that is of a force.
    pub fn force(&self) -> ForceRule {
        self.force.unwrap_or(ForceRule::Momentum)
    }

    /// Whether it is the same number as another measure, whatever that is compared with.
    pub fn is_of(&self, other: &Measure) -> bool {
        let bare =
            |m: &Measure| Measure { reference: None, tolerance: None, source: None, ..m.clone() };
        bare(self) == bare(other)
    }
}

/// A vector of the case; in 2D its third component is zero.
pub(super) fn vector(of: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| of.get(axis).copied().unwrap_or(0.0))
}

/// A particle, or several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a particle is its index in the case, from 0, or its name in quotes")]
pub enum Which {
    /// The particle of this index.
    Id(usize),
    /// All of this name.
    Named(String),
}

impl Which {
    /// Its index; `usize::MAX`, which no particle has, for a name that has not been looked up.
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
    /// As the particle's centre first passes this x (m).
    X(f64),
    /// As it first passes this y (m).
    Y(f64),
    /// As it first passes this z (m), 3D only.
    Z(f64),
    /// At this time (s).
    Time(f64),
}

/// Expected value of a measure, or a band of values.
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
