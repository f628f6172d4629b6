//! Time stepping: `[time]`.

use crate::config::Case;
use crate::config::fault::{Check, positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Time stepping: exactly one of `step` and `cfl`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// When the run ends (s).
    pub end: f64,
    /// A fixed step (s), refused where it breaks a stability limit.
    pub step: Option<f64>,
    /// Courant number of a step, sum over axes of |u| dt/h; default 0.4 (0.8 for rkl3, 0.2 for
    /// euler with upwind advection).
    pub cfl: Option<f64>,
    /// The time scheme; default rkl3; rkl2 where particles move, unless the free ones are a crowd
    /// and neither `cfl` nor `step` is given; rk2 with the mixture method.
    pub scheme: Option<Scheme>,
    /// Most stages of a step of rkl2 or rkl3, 3 to 50; default 10, beside fixed particles 8, where
    /// particles move 4.
    pub max_stages: Option<usize>,
    /// The advection scheme.
    #[serde(default)]
    pub advection: Advection,
}

/// Most stages of a step by [`Bodies`]. The velocity imposed at a wall has a part that turns and
/// does not decay: with ten stages the drag of a fixed disc keeps fluctuating by some thousandths
/// at a quarter of its places, with eight at none. A moving body feels the fluid's response a step
/// late; the longer the steps, the fewer it has to come to rest on a wall.
const MAX_STAGES: [usize; 4] = [10, 8, 4, 4];

/// Most stages of a step that have a use: rounding grows with them.
const MOST_STAGES: usize = 50;

/// The bodies of a case, as far as defaults depend on them.
#[derive(Clone, Copy)]
pub(super) enum Bodies {
    None,
    Fixed,
    Moving,
    /// So many move that they meet each other ([`Case::crowding`]).
    Crowd,
}

/// Rule for the length of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// `time.step`: always this (s).
    Fixed(f64),
    /// `time.cfl`: this Courant number, sum over axes of |u| dt/h, and the other limits.
    Courant(f64),
}

impl Time {
    /// Checks it as a part of its case, what is filled in apart.
    pub(super) fn check(&self, case: &Case) -> Check {
        positive("end", self.end, "s")?;
        let both = self.step.is_some() && self.cfl.is_some();
        ensure!(!both, "step", "time.step and time.cfl exclude each other: remove one of them");
        positive("step", self.step, "s")?;
        positive("cfl", self.cfl, "a Courant number, such as 0.4")?;
        if let Some(stages) = self.max_stages {
            let own = self.scheme.is_none_or(Scheme::has_further_stages);
            ensure!(
                own,
                "max_stages",
                "only time.scheme = \"rkl2\" and \"rkl3\" have a choice of stages: remove one of \
                 them"
            );
            ensure!(
                (3..=MOST_STAGES).contains(&stages),
                "max_stages",
                "must be 3 to {MOST_STAGES} stages, not {stages}"
            );
        }
        let euler = self.scheme == Some(Scheme::Euler);
        let holds = self.advection != Advection::Qsi || euler;
        let cure = "set time.scheme = \"euler\" or choose upwind5";
        ensure!(holds, "advection", "qsi is a one-step scheme: {cure}");
        let holds = !euler || self.advection == Advection::Qsi || case.fluid.viscosity > 0.0;
        let cure = "choose \"rk2\" or \"rk3\", or time.advection = \"qsi\"";
        ensure!(
            holds,
            "scheme",
            "euler steps with upwind advection grow without viscosity: {cure}"
        );
        Ok(())
    }

    /// Fills in the keys that are not given; `mixed` with the mixture method and bodies.
    pub(super) fn fill(&mut self, mixed: bool, bodies: Bodies) -> Check {
        let given = self.step.or(self.cfl).is_some();
        let scheme = *self.scheme.get_or_insert(match bodies {
            _ if mixed => Scheme::Rk2,
            Bodies::Moving => Scheme::Rkl2,
            Bodies::Crowd if given => Scheme::Rkl2,
            _ => Scheme::Rkl3,
        });
        let stages = self.max_stages.is_some();
        let key = if stages { "time.max_stages" } else { "time.scheme" };
        ensure!(
            !mixed || !(scheme.has_further_stages() || stages),
            key,
            "rkl2 and rkl3 have no stages for the mixing (27): choose rk2 without max_stages, or \
            coupling.wall = \"sharp\""
        );
        if scheme.has_further_stages() {
            self.max_stages.get_or_insert(MAX_STAGES[bodies as usize]);
        }
        if self.step.is_none() {
            self.cfl.get_or_insert(match scheme {
                // Euler steps with upwind advection reach less far than all others.
                Scheme::Euler if self.advection != Advection::Qsi => 0.2,
                Scheme::Rkl3 => 0.8,
                _ => 0.4,
            });
        }
        Ok(())
    }

    /// Rule for the length of a step, in a case that has been read.
    pub fn length(&self) -> Step {
        self.step.map_or(Step::Courant(self.cfl.unwrap_or_default()), Step::Fixed)
    }

    /// Most stages of a step of a case that has been read.
    pub fn stages(&self) -> usize {
        self.max_stages.unwrap_or(MAX_STAGES[0])
    }

    /// The time scheme of a case that has been read.
    pub fn scheme(&self) -> Scheme {
        self.scheme.unwrap_or(Scheme::Rk2)
    }
}

/// The time scheme of the prediction (7).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// First order, the paper's.
    Euler,
    /// Second order: strong-stability-preserving Runge-Kutta, two stages.
    Rk2,
    /// Three stages, stable at larger steps; second order with the projection.
    Rk3,
    /// Second order: rk2, or as many Runge-Kutta-Legendre stages as viscosity asks for. Not with
    /// the mixture method.
    Rkl2,
    /// As rkl2 from rk3, with steps twice as long where advection binds, which cost accuracy where
    /// bodies move.
    Rkl3,
}

impl Scheme {
    /// Whether a step takes more stages where viscosity asks for them.
    pub fn has_further_stages(self) -> bool {
        matches!(self, Scheme::Rkl2 | Scheme::Rkl3)
    }
}

/// The advection scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Advection {
    /// Conservative: fifth-order upwind values carried by the divergence-free face velocities.
    #[default]
    Upwind5,
    /// The paper's QSI: semi-Lagrangian local quintic, axis by axis; `scheme = "euler"` only. It
    /// does not conserve momentum; forces are those of pressure and surface shear alone.
    Qsi,
}
