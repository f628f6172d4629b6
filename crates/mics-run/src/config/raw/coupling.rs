//! How fluid and particles meet.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How fluid and particles meet.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// How the surface of a particle acts on the fluid.
    #[serde(default)]
    pub wall: WallRule,
    /// How the volume fractions are found.
    #[serde(default)]
    pub fraction: FractionRule,
    /// Which force moves free particles, and `fluid_f*` in `particles.csv` and the measures report.
    #[serde(default)]
    pub force: ForceRule,
    /// Where the mixing (27) turns the fluid with a particle.
    #[serde(default)]
    pub rotation: RotationRule,
    /// Whether the pressure is mixed inside particles, (28-29); default no.
    #[serde(default)]
    pub mix_pressure: bool,
    /// Where gravity acts on the particles.
    #[serde(default)]
    pub buoyancy: Buoyancy,
    /// Where the pressure gradient of (16) is taken.
    #[serde(default)]
    pub gradient: GradientRule,
}

/// How the surface of a particle acts on the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WallRule {
    /// Sharp-interface immersed boundary: apertures of faces in the pressure equation, ghost cells
    /// inside the particle.
    #[default]
    Sharp,
    /// The paper's mixing of its motion into every cell that it touches, (27).
    Mixing,
}

/// How the volume fraction of a particle in a cell is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FractionRule {
    /// The exact overlap of disc (sphere) and cell.
    #[default]
    Exact,
    /// The paper's polygon through the crossings of circle and grid; 2D.
    Polygon,
}

/// Which force a particle is said to feel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ForceRule {
    /// The momentum that the mixing (27) takes from the fluid.
    #[default]
    Momentum,
    /// Eq. (19) as printed: convective + pressure + viscous parts, weighted by the fraction.
    Literal,
}

/// Where the rotation of a particle, the third term of (27), enters the mixing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RotationRule {
    /// In all cells of the particle.
    #[default]
    All,
    /// In the cells that its surface cuts, as printed.
    Boundary,
}

/// Where gravity acts on the particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Buoyancy {
    /// As reduced gravity of the mixture at faces.
    #[default]
    Faces,
    /// As a force on the particle, in (17) only, as printed.
    Particle,
}

/// Where the pressure gradient of (16) is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GradientRule {
    /// The mean of the accelerations at the two faces of a cell.
    #[default]
    Faces,
    /// `(p_E - p_W)/(2 h rho)` at cells, as printed.
    Cells,
}
