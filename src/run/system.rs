//! What the system says: memory, CPU time, host, the time of day.

use crate::Result;
use crate::config::Loaded;
use crate::petsc::Session;

/// Refuses a grid that this machine's memory cannot hold, before it is tried: the system would end the run without a
/// word. Ranks on other machines have their own memory and are not asked for.
pub fn check_memory(loaded: &Loaded, session: &Session) -> Result<()> {
    // Measured peaks: `peak_memory_bytes_per_cell` in summary.json at 1024^2 and 96 x 64 x 64.
    let per_cell = if loaded.case.dimension() == 2 { 900.0 } else { 1500.0 };
    let needed = per_cell * loaded.case.domain.cells.iter().map(|n| *n as f64).product::<f64>();
    let free = system_number("/proc/meminfo", "MemAvailable:") * 1024.0;
    session.agree(if free == 0.0 || needed < free {
        Ok(())
    } else {
        Err(loaded.error_at(
            "domain.cells",
            format!(
                "this grid takes about {:.1} GB of memory, and {:.1} GB are free here; use fewer cells",
                needed / 1e9,
                free / 1e9
            ),
        ))
    })
}

/// Largest resident memory of this process so far (bytes), 0 where the system does not tell.
pub fn peak_memory() -> f64 {
    system_number("/proc/self/status", "VmHWM:") * 1024.0
}

/// CPU seconds of this process so far, of all its threads, its start included.
pub fn cpu_seconds() -> f64 {
    let spent = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    spent.tv_sec as f64 + 1e-9 * spent.tv_nsec as f64
}

/// The number after `name` in a file of the system's, 0 where there is none.
fn system_number(file: &str, name: &str) -> f64 {
    let text = std::fs::read_to_string(file).unwrap_or_default();
    let line = text.lines().find_map(|l| l.strip_prefix(name));
    line.and_then(|l| l.split_whitespace().next()?.parse().ok()).unwrap_or(0.0)
}

/// The name of this machine.
pub fn host() -> String {
    std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default().trim().to_owned()
}

/// The time now, UTC, as `2026-11-21T03:04:05Z`.
pub fn now() -> String {
    let seconds = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let (days, day) = (seconds / 86_400, seconds % 86_400);
    // Civil date of a day count, by eras of 400 years that begin in March.
    let z = days + 719_468;
    let (era, doe) = (z / 146_097, z % 146_097);
    let yoe = (doe - doe / 1460 + doe / 36_524 - doe / 146_096) / 365;
    let doy = doe - (365 * yoe + yoe / 4 - yoe / 100);
    let mp = (5 * doy + 2) / 153;
    let (d, m) = (doy - (153 * mp + 2) / 5 + 1, if mp < 10 { mp + 3 } else { mp - 9 });
    let y = yoe + era * 400 + u64::from(m <= 2);
    format!("{y:04}-{m:02}-{d:02}T{:02}:{:02}:{:02}Z", day / 3600, day / 60 % 60, day % 60)
}
