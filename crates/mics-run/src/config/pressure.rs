//! The pressure equation: its stopping rule and its solver.

use super::Cadence;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The pressure equation and its stopping rule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Pressure {
    /// D0 (1/s): C-HSMAC iterates until every cell's |D| is below it.
    pub divergence_limit: f64,
    /// Factor on the linear tolerance at each further iteration (a in eps_k = a^k eps).
    pub tightening: f64,
    /// C-HSMAC iterations a step may take before the run fails.
    pub max_iterations: usize,
    /// The linear solver.
    pub solver: Solver,
    /// Whether `solves.csv` has the residual of every iteration of every solve: `true`, or of some
    /// steps, `{ every = 10 }`; default no.
    pub history: History,
}

impl Default for Pressure {
    fn default() -> Self {
        Pressure {
            divergence_limit: 1e-6,
            tightening: 0.1,
            max_iterations: 20,
            solver: Solver::default(),
            history: History::default(),
        }
    }
}

/// The linear solver of the pressure equation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Solver {
    /// The fastest: `multigrid`.
    #[default]
    Auto,
    /// BiCGStab with hypre's BoomerAMG.
    BcgsBoomeramg,
    /// PETSc's conjugate gradients with a geometric multigrid.
    Multigrid,
}

/// Steps whose pressure solves have their residuals written.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a history of solves is true, false or as often as in { every = 10 } (steps)"
)]
pub enum History {
    /// Every step, or none.
    Always(bool),
    /// Every so often.
    Every(Cadence),
}

impl Default for History {
    fn default() -> Self {
        History::Always(false)
    }
}

impl History {
    /// Interval of steps whose pressure solves are written; `None`: never.
    pub fn cadence(self) -> Option<Cadence> {
        match self {
            History::Always(always) => always.then_some(Cadence::Steps(1)),
            History::Every(often) => Some(often),
        }
    }
}

/// Raw PETSc options.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Petsc {
    /// As on a PETSc command line: `"-ksp_type cg -pc_type gamg"`.
    pub options: String,
}
