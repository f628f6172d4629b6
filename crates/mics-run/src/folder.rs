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

/// Beginnings of the names of columns that version 0.3 renamed, the new one first. Until version
/// 0.4 the files have these columns under both names.
const RENAMED: [[&str; 2]; 2] = [["boundary_", "border_"], ["defect_", "convective_"]];

/// The old name of a column that was renamed.
pub fn old_name(column: &str) -> Option<String> {
    RENAMED.iter().find_map(|[new, old]| Some(format!("{old}{}", column.strip_prefix(new)?)))
}
