//! Coupling of fluid and particles.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Coupling of fluid and particles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// Method by which the surface of a particle acts on the fluid.
    #[serde(default)]
    pub wall: WallRule,
}

/// Method by which the surface of a particle acts on the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WallRule {
    /// Sharp-interface immersed boundary: apertures of faces in the pressure equation, ghost cells
    /// inside the particle.
    #[default]
    Sharp,
    /// The paper's method as printed: fluid and particles are one mixture. `docs/method.md` has
    /// its faults.
    #[serde(rename = "mixing")]
    Mixture,
}

impl WallRule {
    /// The force by which a method moves free particles.
    pub fn force(self) -> ForceRule {
        match self {
            WallRule::Sharp => ForceRule::Momentum,
            WallRule::Mixture => ForceRule::Literal,
        }
    }
}

/// Definition of the force that a measure uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ForceRule {
    /// The momentum that the fluid loses at the particle's surface, or to the mixing (27).
    Momentum,
    /// Eq. (19) as printed: convective + pressure + viscous parts, weighted by the fraction.
    Literal,
}
