//! The columns that every study has: no axis or label may take their names.

/// The columns of numbers besides measures, each with its head in tables and figures.
pub const NUMBERS: [(&str, &str); 18] = [
    ("repeats", "repeats"),
    ("cpu_seconds", "CPU time (s)"),
    ("wall_seconds", "wall-clock time (s)"),
    ("us_per_cell_step", "time per cell and step (us)"),
    ("cpu_us_per_cell_step", "CPU time per cell and step (us)"),
    ("pressure_cpu_seconds", "CPU time of the pressure (s)"),
    ("pressure_cpu_us_per_cell_step", "CPU time of the pressure per cell and step (us)"),
    ("cells", "cells"),
    ("steps", "steps"),
    ("outer_iterations", "C-HSMAC iterations"),
    ("krylov_iterations", "Krylov iterations"),
    ("krylov_per_step", "Krylov iterations per step"),
    ("krylov_per_solve", "Krylov iterations per solve"),
    ("preconditioner_setups", "setups of the preconditioner"),
    ("divergence_max", "largest |D| (1/s)"),
    ("divergence_over_limit", "largest |D| over D0"),
    ("peak_memory_bytes", "memory (bytes)"),
    ("peak_memory_bytes_per_cell", "memory per cell (bytes)"),
];

/// The last columns of `study.csv`, which are texts.
pub const TEXTS: [&str; 5] = ["status", "message", "commit", "set", "folder"];

/// Names of the columns of numbers besides measures.
pub fn number_columns() -> Vec<&'static str> {
    NUMBERS.iter().map(|(name, _)| *name).collect()
}

/// Names of the columns that every study has.
pub fn own_columns() -> Vec<&'static str> {
    [&number_columns()[..], &TEXTS].concat()
}

/// A column as heads of tables and axes of figures have it.
pub fn head(column: &str) -> &str {
    NUMBERS.iter().find(|(name, _)| *name == column).map_or(column, |(_, head)| head)
}

/// The column of a measure's errors.
pub fn error_of(measure: &str) -> String {
    format!("{measure}_error")
}
