//! Ctrl-C and SIGTERM: the first asks a run to stop after its step, a second one of the same kind
//! ends it at once.

use crate::error::INTERRUPTED;
use crate::{Error, Result};
use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
use signal_hook::{SigId, flag, low_level};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Signals that end a run early. mpirun hands SIGUSR1 on to its ranks and lets them live, where it
/// gives them a second only after Ctrl-C; schedulers send it ahead of the end of a job.
const SIGNALS: [i32; 3] = [SIGINT, SIGTERM, SIGUSR1];

/// Whether somebody has asked this process to stop; listens for as long as it lives.
pub struct Interrupt {
    asked: [Arc<AtomicBool>; SIGNALS.len()],
    handlers: Vec<SigId>,
}

impl Interrupt {
    /// Listens from now on.
    ///
    /// # Errors
    /// When the system refuses to install a handler.
    pub fn listen() -> Result<Interrupt> {
        // Each kind has a flag of its own: on a terminal a rank gets SIGINT, and SIGTERM from
        // mpirun for the same Ctrl-C.
        let mut listening = Interrupt { asked: Default::default(), handlers: Vec::new() };
        for (signal, asked) in SIGNALS.into_iter().zip(&listening.asked) {
            // In this order, so that the first signal does not find the flag that it sets itself.
            let ends =
                flag::register_conditional_shutdown(signal, i32::from(INTERRUPTED), asked.clone());
            listening.handlers.push(ends.map_err(Error::io("signal handler"))?);
            listening
                .handlers
                .push(flag::register(signal, asked.clone()).map_err(Error::io("signal handler"))?);
        }
        Ok(listening)
    }

    /// Whether a signal has come.
    pub fn asked(&self) -> bool {
        self.asked.iter().any(|asked| asked.load(Ordering::Relaxed))
    }
}

impl Drop for Interrupt {
    fn drop(&mut self) {
        // The next run of this process begins anew.
        for handler in self.handlers.drain(..) {
            low_level::unregister(handler);
        }
    }
}
