//! CPU time, for tests that a busy machine must not fail.

/// CPU seconds of this thread so far.
pub fn thread_seconds() -> f64 {
    let spent = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    spent.tv_sec as f64 + 1e-9 * spent.tv_nsec as f64
}
