//! Names of files in a run's folder that one writes and another one reads.

/// Means over time in every cell.
pub const FIELDS: &str = "statistics.vti";
/// Means over time in layers of cells.
pub const PROFILE: &str = "profile.csv";
/// The residuals of the pressure solves.
pub const SOLVES: &str = "solves.csv";
/// The balance of momentum over time.
pub const BALANCE: &str = "balance.csv";
/// The report of the run.
pub const REPORT: &str = "report.html";
/// Forces on the obstacles.
pub const OBSTACLES: &str = "obstacles.csv";
