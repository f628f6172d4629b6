//! What a run writes, and how often.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// What is written, and how often.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Rows of `particles.csv`; default every n/4 steps of n particles, every step of up to four.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particles: Option<Cadence>,
    /// Snapshots under `fields/`; default only the first and the last state.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fields: Option<Cadence>,
    /// Checkpoints, of which the newest two are kept; default every 15 minutes of running time.
    pub checkpoint: Checkpoints,
    /// Figures of the last state as PNG and SVG; default yes.
    pub figures: bool,
    /// What happens to a free particle that reaches an outflow; default it leaves, with a row in
    /// `passages.csv`.
    pub removed: Removed,
    /// How often fixed particles have rows; default once, at the start, where more than ten are
    /// beside moving ones, else as often as those.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fixed: Option<FixedRows>,
    /// Planes of figures in 3D (m), `planes = [{ z = 0.02 }, { x = 0.01 }]`; default one along
    /// gravity or the stream through the body, or the middle of all.
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
    /// Interval (s): at the end of the first step that reaches each multiple of it.
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
