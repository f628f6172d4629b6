//! Reuse of a preconditioner for several matrices (`-ksp_lag_preconditioner`): for a number of
//! them, or, by `auto`, for as many as come until iterations have grown by a third. Where a solve
//! with a matrix that it was not built from takes more than [`Reuse::patience`], it is built anew
//! at once, and by `auto` for ever more matrices in a row.

use super::Session;
use crate::{Error, Result};

/// Growth of the iterations at which a preconditioner is built anew.
const GROWTH: f64 = 1.3;

/// A preconditioner that may outlive its matrix.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reuse {
    /// Matrices that it serves; `None`: until iterations have grown.
    most: Option<u32>,
    /// Matrices since the one that it was built from.
    served: u32,
    /// Iterations a decade of reduction with the matrix that it was built from.
    first: Option<f64>,
    /// Whether it has to be built anew before the next solve.
    due: bool,
    /// Matrices for which it is built anew in any case: it has failed on one that it was not built
    /// from.
    wait: u32,
    failures: u32,
    /// Number of times that it was built.
    pub setups: u32,
}

impl Reuse {
    /// Reads the user's options; without them reuse goes by `auto`, or is for one matrix.
    ///
    /// # Errors
    /// When the option is no number of matrices.
    pub fn by_options(session: &Session, auto: bool) -> Result<Reuse> {
        let name = "-ksp_lag_preconditioner";
        let kept = session.has_option("-ksp_reuse_preconditioner")?;
        let most = match session.used_option(name)?.as_deref() {
            None if kept => Some(u32::MAX),
            None => (!auto).then_some(1),
            Some("auto") => None,
            Some(text) => Some(text.parse().ok().filter(|most| *most > 0).ok_or_else(|| {
                Error::Usage(format!(
                    "PETSc option {name}: {text:?} is neither auto nor a number of matrices from 1"
                ))
            })?),
        };
        Ok(Reuse { most, ..Reuse::default() })
    }

    /// Description of when it is built anew.
    pub fn words(&self) -> String {
        match self.most {
            None => "set up anew once iterations have grown by a third".into(),
            Some(u32::MAX) => "set up once".into(),
            Some(most) => format!("set up anew after {most} matrices, or where it fails"),
        }
    }

    /// Whether it can serve more than one matrix.
    pub fn reuses(&self) -> bool {
        self.most != Some(1)
    }

    /// Takes note of another matrix.
    pub fn outdate(&mut self) {
        self.served = self.served.saturating_add(1);
    }

    /// Whether the matrix is another than the one that it was built from.
    pub fn is_stale(&self) -> bool {
        self.served > 0
    }

    /// Whether the next solve goes on with what there is, although the matrix is another.
    pub fn keeps(&self) -> bool {
        self.first.is_some()
            && self.most.map_or(!self.due && self.wait == 0, |most| self.served < most)
    }

    /// Iterations after which building anew costs less than going on.
    pub fn patience(&self, rtol: f64) -> i32 {
        (2.0 * GROWTH * self.first.unwrap_or(0.0) * -rtol.log10()) as i32 + 5
    }

    /// Takes a solve's iterations.
    pub fn judge(&mut self, iterations: u32, rtol: f64) {
        let decades = -rtol.log10();
        match self.first {
            Some(first) if self.is_stale() => {
                self.due = f64::from(iterations) > GROWTH * first * decades + 1.0
            }
            _ => self.first = Some(f64::from(iterations) / decades),
        }
    }

    /// Takes note that it is built anew by the next solve.
    pub fn build(&mut self) {
        *self = Reuse {
            first: None,
            served: 0,
            due: false,
            wait: self.wait.saturating_sub(1),
            setups: self.setups + 1,
            ..*self
        };
    }

    /// Takes note of a failure with another matrix: waits longer each time.
    pub fn fail(&mut self) {
        self.failures = (self.failures + 1).min(6);
        self.wait = 1 << self.failures;
    }
}
