//! When a preconditioner that was built from an older matrix is built anew: once iterations have
//! grown by a third, or after a failure, ever later.

/// Growth of the iterations at which a preconditioner is built anew.
const GROWTH: f64 = 1.3;

/// A preconditioner that outlives its matrix until iterations have grown.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reuse {
    /// Iterations a decade of reduction with the matrix that it was built from.
    first: Option<f64>,
    /// Whether the matrix is another by now.
    pub stale: bool,
    /// Whether it has to be built anew before the next solve.
    due: bool,
    /// Matrices for which it is built anew in any case: it has failed on one that it was not built
    /// from.
    wait: u32,
    failures: u32,
}

impl Reuse {
    /// Whether the next solve goes on with what there is, although the matrix is another.
    pub fn keeps(&self) -> bool {
        self.first.is_some() && !self.due && self.wait == 0
    }

    /// Iterations after which building anew costs less than going on.
    pub fn patience(&self, rtol: f64) -> i32 {
        (2.0 * GROWTH * self.first.unwrap_or(0.0) * -rtol.log10()) as i32 + 5
    }

    /// Takes a solve's iterations.
    pub fn judge(&mut self, iterations: u32, rtol: f64) {
        let decades = -rtol.log10();
        match self.first {
            Some(first) if self.stale => {
                self.due = f64::from(iterations) > GROWTH * first * decades + 1.0
            }
            _ => self.first = Some(f64::from(iterations) / decades),
        }
    }

    /// Takes note that it was built anew.
    pub fn built(&mut self) {
        *self = Reuse {
            first: None,
            stale: false,
            due: false,
            wait: self.wait.saturating_sub(1),
            ..*self
        };
    }

    /// Takes note of a failure with another matrix: waits longer each time.
    pub fn failed(&mut self) {
        self.failures = (self.failures + 1).min(6);
        self.wait = 1 << self.failures;
    }
}
