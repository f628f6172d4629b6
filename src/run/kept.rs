//! The state of late that a run keeps, should it fail.

use crate::scene::Scene;
use crate::state::{Readable, State};

/// Steps from one state that is kept to the next, and the growth of the fluid's speed since the
/// last one above which a state is kept at once.
const EVERY: u64 = 8;
const FASTER: f64 = 1.05;

/// A state that readers can use, and the largest speed of the fluid there (m/s).
pub(super) struct Kept<const D: usize> {
    state: Readable<D>,
    speed: f64,
}

impl<const D: usize> Kept<D> {
    /// Keeps the state that a run begins with.
    pub fn new(state: &State<D>) -> Kept<D> {
        let mut kept = Kept { state: Readable::default(), speed: 0.0 };
        state.keep(&mut kept.state);
        kept
    }

    /// Keeps the state at the start of a step, where that is due; `speed` (m/s) is the largest of
    /// the fluid.
    pub fn take(&mut self, state: &State<D>, speed: f64) {
        let due = state.steps.is_multiple_of(EVERY);
        if due || speed > FASTER * self.speed || state.differs(&self.state) {
            state.keep(&mut self.state);
            self.speed = speed;
        }
    }

    /// Brings it back into the scene, for readers.
    pub fn restore(&self, scene: &mut Scene<D>) {
        scene.restore(&self.state);
    }
}
