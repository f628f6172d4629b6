//! What a run reports and writes.

use super::{Axis, ForceRule, Region};
use crate::words::rounded;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

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
    /// file describes: where `--set` changes the box's size, the fluid, its borders, its start or
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

/// What a measure is. Coefficients are forces over `0.5 rho_f speed^2 d` (2D, per unit depth) or
/// `0.5 rho_f speed^2 pi d^2/4` (3D); means are over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MeasureKind {
    /// Mean of the force along the stream, or `direction`, as a coefficient.
    DragCoefficient,
    /// Largest force along the stream, as a coefficient.
    DragCoefficientMax,
    /// Mean of the force across the stream, or along `direction`, as a coefficient.
    LiftCoefficient,
    /// Largest force across the stream, as a coefficient.
    LiftCoefficientMax,
    /// Mean of the size of all of the force across the stream, or across `direction`, as a
    /// coefficient.
    LiftMagnitude,
    /// Mean of the force by the fluid on all of `particles` together, along the stream or
    /// `direction` (N, in 2D N/m).
    Force,
    /// Root mean square of the lift coefficient about its mean.
    LiftRms,
    /// Half the span of the lift coefficient.
    LiftAmplitude,
    /// `f d/speed` of the lift, from its upward crossings of the mean.
    Strouhal,
    /// `C_D` of Morison's formula for a particle with a prescribed oscillation: the force along it
    /// is fitted, by least squares over time, by `F = -C_D 0.5 rho_f S |U| U - C_M rho_f V dU/dt`,
    /// U the particle's velocity along it, S and V its frontal area and its volume (2D: d and pi
    /// d^2/4 per unit depth). The force is a mean over each step: U is taken at its middle.
    MorisonDrag,
    /// `C_M` of the same fit: 1 for a disc in an unbounded inviscid fluid.
    MorisonInertia,
    /// What the same fit leaves of the force: its root mean square over that of the force.
    MorisonResidual,
    /// Root mean square of the force along the stream about its least-squares quadratic in time,
    /// over its mean; steps weigh as much as they are long. Of a particle that moves steadily
    /// through the grid it is noise.
    ForceNoise,
    /// Largest speed of the fluid over the domain and over time (m/s); cells that particles fill by
    /// more than half do not count.
    MaxSpeed,
    /// Least velocity along x on the line x = size/2 at the end (m/s), by a parabola through three
    /// cells; 2D only.
    MidlineULeast,
    /// Least velocity along y on the line y = size/2 at the end (m/s); 2D only.
    MidlineVLeast,
    /// Largest velocity along y on the line y = size/2 at the end (m/s); 2D only.
    MidlineVLargest,
    /// Largest speed of the particle's centre from `from` on (m/s), whatever makes it: at a start,
    /// in a fall or by an impact.
    #[serde(alias = "terminal_velocity")]
    LargestSpeed,
    /// Speed of a steady fall (m/s): the mean over that quarter of the particle's way, from `from`
    /// on, over which its speed changes least. The end of the run says whether it is steady there,
    /// within 1 %.
    TerminalSpeed,
    /// x of the particle's centre at the end, or `when` (m).
    PositionX,
    /// y of the particle's centre at the end, or `when` (m).
    PositionY,
    /// z of the particle's centre at the end, or `when` (m), 3D only.
    PositionZ,
    /// Mean of the particle's velocity along x, or that `when` (m/s).
    VelocityX,
    /// Mean of the particle's velocity along y, or that `when` (m/s).
    VelocityY,
    /// Mean of the particle's velocity along z, or that `when` (m/s), 3D only.
    VelocityZ,
    /// Mean of the particle's angular velocity about z, or that `when` (rad/s).
    Spin,
    /// First time at which the particle touches another or a wall, or in a viscous fluid comes as
    /// near as `contact.roughness` (s).
    ContactStart,
    /// Mean height of `particles` at the end, against gravity and above the lowest centre of all
    /// (m).
    MeanHeight,
    /// Mean rank of `particles` at the end in the order of all heights against gravity: 1 is the
    /// lowest.
    HeightRank,
    /// Fastest of the centres of `particles` at the end (m/s).
    FastestParticle,
    /// Deepest overlap of two bodies in contact, or of one and a wall, over time (m).
    LargestOverlap,
    /// Mean speed of the centres of `particles` (m/s), and over time.
    MeanSpeed,
    /// Root mean square of the speeds of the centres of `particles` (m/s); its mean over time.
    RmsSpeed,
    /// Volume of `particles` that passes through a cross-section of the box (m3/s; m2/s in 2D):
    /// `sum V v/L` along `axis`, L the length of the box; its mean over time.
    TransportRate,
    /// Mean over time of the fluid's velocity along `axis` over the whole box, bodies counted as
    /// nothing (m/s).
    SuperficialVelocity,
    /// Mean over time of the volume, fluid and bodies, that flows through a cross-section of the
    /// box along `axis` (m3/s; m2/s in 2D).
    FlowRate,
    /// Mean over time of the fall of the pressure from the low to the high end of the box along
    /// `axis`, a drive's with it (Pa).
    PressureDrop,
    /// Mean over time of the force of the drive on the fluid along `axis` (N/m3).
    DriveForce,
    /// Mean over time of the solid fraction of `region`.
    SolidFraction,
    /// Mean over time of the height at which the solid fraction of layers of cells falls to
    /// `threshold`, over the low end of the box (m).
    BedHeight,
    /// Mean over time of the kinetic energy of the fluid (J; per metre of depth in 2D).
    FluidEnergy,
    /// Largest rate at which the fluid loses kinetic energy, per mass of what would fill the box
    /// (m2/s3), from step to step.
    Dissipation,
    /// When that is (s).
    DissipationTime,
    /// Mean over time of the kinetic energy of the free bodies (J; per metre of depth in 2D).
    BodyEnergy,
}

impl MeasureKind {
    /// Names that kinds had in earlier versions, each with the present one.
    pub(in crate::config) const RENAMED: [(&str, &str); 1] =
        [("terminal_velocity", "largest_speed")];

    /// The unit of its value, where the case is in SI units; empty for numbers without one. Forces
    /// and energies in 2D are per metre of depth.
    pub fn unit(self, dimension: usize) -> &'static str {
        use MeasureKind::*;
        match self {
            DragCoefficient | DragCoefficientMax | LiftCoefficient | LiftCoefficientMax
            | LiftMagnitude | LiftRms | LiftAmplitude | Strouhal | MorisonDrag | MorisonInertia
            | MorisonResidual | ForceNoise | HeightRank | SolidFraction => "",
            MaxSpeed | MidlineULeast | MidlineVLeast | MidlineVLargest | LargestSpeed
            | TerminalSpeed | VelocityX | VelocityY | VelocityZ | FastestParticle | MeanSpeed
            | RmsSpeed | SuperficialVelocity => "m/s",
            PositionX | PositionY | PositionZ | MeanHeight | LargestOverlap | BedHeight => "m",
            ContactStart | DissipationTime => "s",
            Spin => "rad/s",
            Force if dimension == 2 => "N/m",
            Force => "N",
            TransportRate | FlowRate if dimension == 2 => "m2/s",
            TransportRate | FlowRate => "m3/s",
            PressureDrop => "Pa",
            DriveForce => "N/m3",
            FluidEnergy | BodyEnergy if dimension == 2 => "J/m",
            FluidEnergy | BodyEnergy => "J",
            Dissipation => "m2/s3",
        }
    }

    /// Whether its value is found from all samples from `from` on, so that an impulsive start at
    /// time 0 counts in it.
    pub fn counts_the_start(self) -> bool {
        use MeasureKind::*;
        matches!(
            self,
            DragCoefficient | LiftCoefficient | LiftMagnitude | LiftRms | LiftAmplitude | Force
        )
    }

    /// Whether it is of one particle.
    pub fn needs_particle(self) -> bool {
        !matches!(self, MeasureKind::MaxSpeed | MeasureKind::LargestOverlap)
            && !self.is_of_midline()
            && !self.is_of_group()
            && !self.is_of_box()
    }

    /// Whether it is of several particles.
    pub fn is_of_group(self) -> bool {
        use MeasureKind::*;
        matches!(
            self,
            MeanHeight
                | HeightRank
                | FastestParticle
                | Force
                | MeanSpeed
                | RmsSpeed
                | TransportRate
        )
    }

    /// Whether it is taken of the whole box after every step.
    pub fn is_of_box(self) -> bool {
        use MeasureKind::*;
        self.has_axis()
            || matches!(
                self,
                SolidFraction | FluidEnergy | BodyEnergy | Dissipation | DissipationTime
            )
    }

    /// Whether it is along an axis.
    pub fn has_axis(self) -> bool {
        use MeasureKind::*;
        matches!(
            self,
            SuperficialVelocity | FlowRate | PressureDrop | DriveForce | TransportRate | BedHeight
        )
    }

    /// Whether it needs gravity, to tell what is high.
    pub fn needs_gravity(self) -> bool {
        matches!(self, MeasureKind::MeanHeight | MeasureKind::HeightRank | MeasureKind::BedHeight)
    }

    /// Whether it is of the velocities on a line through the middle of the box.
    pub fn is_of_midline(self) -> bool {
        matches!(
            self,
            MeasureKind::MidlineULeast | MeasureKind::MidlineVLeast | MeasureKind::MidlineVLargest
        )
    }

    /// Whether a reference speed makes it dimensionless: a coefficient of a force, or a frequency.
    pub fn needs_speed(self) -> bool {
        use MeasureKind::*;
        matches!(
            self,
            DragCoefficient
                | DragCoefficientMax
                | LiftCoefficient
                | LiftCoefficientMax
                | LiftMagnitude
                | LiftRms
                | LiftAmplitude
                | Strouhal
        )
    }

    /// Whether it can be taken at a moment of the particle's way.
    pub fn has_moments(self) -> bool {
        use MeasureKind::*;
        matches!(self, PositionX | PositionY | PositionZ | VelocityX | VelocityY | VelocityZ | Spin)
    }

    /// Whether it is made of the force on a particle.
    pub fn is_of_force(self) -> bool {
        self.needs_speed()
            || self.fits_morison()
            || matches!(self, MeasureKind::ForceNoise | MeasureKind::Force)
    }

    /// Whether it is of the component of a force across the stream.
    pub fn is_across(self) -> bool {
        use MeasureKind::*;
        matches!(self, LiftCoefficient | LiftCoefficientMax | LiftRms | LiftAmplitude | Strouhal)
    }

    /// Whether its samples are means over their steps, as forces are, and not values at their ends.
    pub fn is_mean_of_step(self) -> bool {
        matches!(
            self,
            MeasureKind::DragCoefficient
                | MeasureKind::LiftCoefficient
                | MeasureKind::LiftMagnitude
                | MeasureKind::LiftRms
                | MeasureKind::Force
                | MeasureKind::DriveForce
                | MeasureKind::PressureDrop
        )
    }

    /// Whether it is a fit of Morison's formula, of a particle with a prescribed oscillation.
    pub fn fits_morison(self) -> bool {
        matches!(
            self,
            MeasureKind::MorisonDrag | MeasureKind::MorisonInertia | MeasureKind::MorisonResidual
        )
    }
}

/// What is written, and how often.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Rows of `particles.csv`; default every n/4 steps of n particles, every step of up to four.
    /// Fixed ones that have a row at the start only do not count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particles: Option<Cadence>,
    /// Snapshots under `fields/`; default only the first and the last state.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fields: Option<Cadence>,
    /// Checkpoints to go on from, of which the newest two are kept; default every 15 minutes of
    /// running time.
    pub checkpoint: Checkpoints,
    /// Figures of the last state as PNG and SVG; default yes.
    pub figures: bool,
    /// What becomes of a free particle that reaches an outflow; default it leaves, which
    /// `passages.csv` says.
    pub removed: Removed,
    /// How often `particles.csv` has rows of fixed particles; default once, at the start, where
    /// there are more than ten of them beside others that move, and else as often as of these.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fixed: Option<FixedRows>,
    /// Where figures cut a 3D flow, `planes = [{ z = 0.02 }, { x = 0.01 }]` (m), each drawn in the
    /// layer of cells that holds it; default one along gravity or the stream, through the body or
    /// the middle of all of them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub planes: Vec<Section>,
}

/// How often fixed particles have rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FixedRows {
    /// At the start.
    Once,
    /// Whenever others have, with the forces on them.
    Always,
}

/// What becomes of a free particle as its surface reaches an outflow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Removed {
    /// It is taken out of the box.
    #[default]
    Log,
    /// It comes in again at the other end of the box, at the velocity that it has; where another
    /// one is in its way, it is taken out.
    Return,
    /// The run ends, as one that has come to its `time.end`.
    Stop,
}

/// A plane across an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Section {
    /// At this x (m).
    X(f64),
    /// At this y (m).
    Y(f64),
    /// At this z (m).
    Z(f64),
}

impl Section {
    /// The plane across `axis` at a coordinate (m).
    pub fn across(axis: usize, at: f64) -> Section {
        [Section::X, Section::Y, Section::Z][axis](at)
    }

    /// Its axis, and where on it the plane lies (m).
    pub fn place(self) -> (usize, f64) {
        match self {
            Section::X(at) => (0, at),
            Section::Y(at) => (1, at),
            Section::Z(at) => (2, at),
        }
    }
}

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (axis, at) = self.place();
        write!(f, "{}={at}", ["x", "y", "z"][axis])
    }
}

impl FromStr for Section {
    type Err = String;

    fn from_str(text: &str) -> Result<Section, String> {
        let wrong =
            || format!("\"{text}\" is no plane: give an axis and a place on it in m, as in z=0.02");
        let (name, at) = text.split_once('=').ok_or_else(wrong)?;
        let axis =
            ["x", "y", "z"].iter().position(|axis| *axis == name.trim()).ok_or_else(wrong)?;
        let at = at.trim().parse::<f64>().ok().filter(|at| at.is_finite()).ok_or_else(wrong)?;
        Ok(Section::across(axis, at))
    }
}

impl Default for Output {
    fn default() -> Self {
        Output {
            particles: None,
            fields: None,
            checkpoint: Checkpoints::default(),
            figures: true,
            removed: Removed::default(),
            fixed: None,
            planes: Vec::new(),
        }
    }
}

/// How often: exactly one of the two.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cadence {
    /// Every so many steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every: Option<u64>,
    /// Every so much time (s): at the end of the first step that reaches or passes each multiple of
    /// it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every_time: Option<f64>,
}

/// How often a checkpoint is written: exactly one of the two.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Checkpoints {
    /// Every so many minutes of running time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every_wall_minutes: Option<f64>,
    /// Every so many steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every_steps: Option<u64>,
}

impl Default for Checkpoints {
    fn default() -> Self {
        Checkpoints { every_wall_minutes: Some(15.0), every_steps: None }
    }
}
