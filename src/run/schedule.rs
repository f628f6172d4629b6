//! When something is due that happens every so often.

use crate::config::Cadence;

/// A cadence from a time on: decided by step and time alone, so that all ranks agree.
pub(super) struct Schedule {
    cadence: Option<Cadence>,
    done: f64,
}

impl Schedule {
    /// A schedule from `time` (s) on.
    pub fn new(cadence: Option<Cadence>, time: f64) -> Schedule {
        let mut schedule = Schedule { cadence, done: 0.0 };
        schedule.due(0, time);
        schedule
    }

    /// Whether a step that ended at `time` (s) is the first at or after a due moment.
    pub fn due(&mut self, step: u64, time: f64) -> bool {
        match self.cadence {
            Some(Cadence::Steps(n)) => step.is_multiple_of(n),
            Some(Cadence::Time(interval)) => {
                let passed = (time / interval * (1.0 + 1e-9)).floor();
                std::mem::replace(&mut self.done, passed) < passed
            }
            None => false,
        }
    }
}
