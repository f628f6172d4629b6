//! Output of a run: the files that it writes, and how often.

use super::Case;
use crate::config::fault::{AXES, Check, positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Files that are written, and how often.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Rows of `particles.csv`; default every n/4 steps of n particles, every step of up to four.
    pub particles: Option<Cadence>,
    /// Snapshots under `fields/`; default only the first and the last state.
    pub fields: Option<Cadence>,
    /// Checkpoints, of which the newest two are kept; default every 15 minutes of running time, the
    /// first after one.
    pub checkpoint: Checkpoints,
    /// Figures of the last state as PNG and SVG; default yes.
    pub figures: bool,
    /// Pressure and shear on the surfaces of particles and obstacles, round ones too, in their
    /// files beside each snapshot (sharp surfaces only); default no.
    pub surfaces: bool,
    /// Treatment of a free particle that reaches an outflow; default it leaves, with a row in
    /// `passages.csv`.
    pub removed: Removed,
    /// Rows of fixed particles; default once, at the start, where more than ten are beside moving
    /// ones, else as often as those.
    pub fixed: Option<FixedRows>,
    /// Planes of figures in 3D (m), `planes = [{ z = 0.02 }, { x = 0.01 }]`; default one along
    /// gravity or the stream through the body, or the middle of all.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub planes: Vec<Section>,
}

/// Times at which fixed particles have rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FixedRows {
    /// At the start.
    Once,
    /// Whenever others have, with the forces on them.
    Always,
}

/// Treatment of a free particle as its surface reaches an outflow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Removed {
    /// It is taken out of the box.
    #[default]
    Log,
    /// It enters again at the other end of the box with its velocity; where another body is in its
    /// way, it leaves.
    Return,
    /// The run ends as at its `time.end`.
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
        write!(f, "{}={at}", AXES[axis])
    }
}

impl FromStr for Section {
    type Err = String;

    fn from_str(text: &str) -> Result<Section, String> {
        let wrong =
            || format!("\"{text}\" is no plane: give an axis and a place on it in m, as in z=0.02");
        let (name, at) = text.split_once('=').ok_or_else(wrong)?;
        let axis = AXES.iter().position(|axis| *axis == name.trim()).ok_or_else(wrong)?;
        let at = at.trim().parse::<f64>().ok().filter(|at| at.is_finite()).ok_or_else(wrong)?;
        Ok(Section::across(axis, at))
    }
}

impl Default for Output {
    fn default() -> Self {
        Output {
            particles: None,
            fields: None,
            checkpoint: Checkpoints::WallMinutes(15.0),
            figures: true,
            surfaces: false,
            removed: Removed::default(),
            fixed: None,
            planes: Vec::new(),
        }
    }
}

/// Interval of output, in steps or in time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum Cadence {
    /// Every so many steps.
    #[serde(rename = "every")]
    Steps(u64),
    /// Interval (s): at the end of the first step that reaches each multiple of it.
    #[serde(rename = "every_time")]
    Time(f64),
}

impl Cadence {
    /// Checks it as the value of a key.
    pub(in crate::config) fn check(self, key: &str) -> Check {
        match self {
            Cadence::Steps(steps) => at_least_one_step(&format!("{key}.every"), steps),
            Cadence::Time(time) => positive(&format!("{key}.every_time"), time, "s"),
        }
    }
}

/// Interval of checkpoints, in minutes of running time or in steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum Checkpoints {
    /// Every so many minutes of running time.
    #[serde(rename = "every_wall_minutes")]
    WallMinutes(f64),
    /// Every so many steps.
    #[serde(rename = "every_steps")]
    Steps(u64),
}

impl Checkpoints {
    fn check(self) -> Check {
        let key = "checkpoint";
        match self {
            Checkpoints::Steps(steps) => at_least_one_step(&format!("{key}.every_steps"), steps),
            Checkpoints::WallMinutes(minutes) => {
                positive(&format!("{key}.every_wall_minutes"), minutes, "minutes")
            }
        }
    }
}

fn at_least_one_step(key: &str, steps: u64) -> Check {
    ensure!(steps > 0, key, "must be 1 step or more, not 0");
    Ok(())
}

/// Most fixed particles beside others that have rows at every output; more count as a ground.
const MANY: usize = 10;

/// Rows of `particles.csv` a step where the case does not say how often: four times the bytes of
/// `steps.csv`.
const ROWS_A_STEP: usize = 4;

impl Output {
    /// Checks it as a part of its case.
    pub(in crate::config) fn check(&self, case: &Case) -> Check {
        if let Some(particles) = self.particles {
            particles.check("particles")?;
        }
        if let Some(fields) = self.fields {
            fields.check("fields")?;
        }
        self.checkpoint.check()?;
        for (index, plane) in self.planes.iter().enumerate() {
            let key = format!("planes.{index}");
            let (axis, at) = plane.place();
            let space = case.dimension() == 3;
            ensure!(space, key, "is for 3D only: in 2D figures show all of the flow");
            let size = case.domain.size[axis];
            ensure!(
                (0.0..=size).contains(&at),
                key,
                "must lie in the box, from 0 to {size:?} m, not at {at:?}"
            );
        }
        Ok(())
    }

    /// Fills in the keys that are not given, of a case of `count` particles of which `resting` are
    /// fixed.
    pub(in crate::config) fn fill(&mut self, count: usize, resting: usize) {
        let ground = resting > MANY && resting < count;
        let usual = if ground { FixedRows::Once } else { FixedRows::Always };
        let fixed = *self.fixed.get_or_insert(usual);
        let rows = if fixed == FixedRows::Once { count - resting } else { count };
        let steps = rows.div_ceil(ROWS_A_STEP).max(1);
        self.particles.get_or_insert(Cadence::Steps(steps as u64));
    }

    /// Interval of rows of particles, in a case that has been read.
    pub fn rows(&self) -> Cadence {
        self.particles.unwrap_or(Cadence::Steps(1))
    }

    /// Times at which fixed particles have rows, in a case that has been read.
    pub fn fixed_rows(&self) -> FixedRows {
        self.fixed.unwrap_or(FixedRows::Always)
    }
}
