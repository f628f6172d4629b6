//! Facts about the system: memory, CPU time, host, the time of day.

/// Largest resident memory of this process so far (bytes), 0 where the system does not tell.
pub fn peak_memory() -> f64 {
    system_number("/proc/self/status", "VmHWM:") * 1024.0
}

/// Memory that is free on this machine (bytes), 0 where the system does not tell.
pub fn free_memory() -> f64 {
    system_number("/proc/meminfo", "MemAvailable:") * 1024.0
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
    let seconds = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0, |d| d.as_secs());
    let days = seconds / 86_400;
    let day = seconds % 86_400;
    // Civil date of a day count, by eras of 400 years that begin in March.
    let z = days + 719_468;
    let era = z / 146_097;
    let doe = z % 146_097;
    let yoe = (doe - doe / 1460 + doe / 36_524 - doe / 146_096) / 365;
    let doy = doe - (365 * yoe + yoe / 4 - yoe / 100);
    let mp = (5 * doy + 2) / 153;
    let d = doy - (153 * mp + 2) / 5 + 1;
    let m = if mp < 10 { mp + 3 } else { mp - 9 };
    let y = yoe + era * 400 + u64::from(m <= 2);
    format!("{y:04}-{m:02}-{d:02}T{:02}:{:02}:{:02}Z", day / 3600, day / 60 % 60, day % 60)
}
