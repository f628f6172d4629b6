//! Where a run is from: the program, the case's remarks, and the runs that it goes on from.

use super::restart::Restart;
use crate::Result;
use crate::petsc::Session;
use crate::scene::{self, Scene};
use crate::system::host;
use serde_json::{Value, json};

/// Where a run is from.
pub(super) struct Origin<'a> {
    /// The git commit that the program was built from.
    pub commit: &'static str,
    /// Remarks on the case file, a line each.
    pub notes: &'a [String],
    /// Lines on what was taken over from the run that `initial.from` names.
    pub inherited: Vec<String>,
    /// The checkpoint that it goes on from.
    pub restart: Option<Restart>,
}

impl Origin<'_> {
    /// The content of `run.json`: the program, the machine and the solver; `began` and `ended` are
    /// times of day. Collective.
    pub fn json<const D: usize>(
        &self,
        session: &Session,
        scene: &Scene<D>,
        began: &str,
        ended: Option<&str>,
    ) -> Result<Value> {
        let words: Vec<String> = std::env::args().collect();
        Ok(json!({
            "version": env!("CARGO_PKG_VERSION"),
            "git_commit": self.commit,
            "command": words,
            "petsc_version": session.version(),
            "petsc_options": session.options()?,
            "ranks": session.size(),
            "host": host(), "pid": std::process::id(), "start": began, "end": ended,
            "resumed_after_step": self.restart.as_ref().map(Restart::step),
            "solver": scene.solver()?,
            "needs": scene::needs(scene),
        }))
    }
}
