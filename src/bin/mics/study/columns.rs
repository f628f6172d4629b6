//! The columns that every study has: no axis or label may take their names.

/// Columns of `study.csv` besides labels and measures, in their order.
pub const COLUMNS: [&str; 27] = [
    "ranks",
    "status",
    "repeats",
    "cpu_seconds",
    "cpu_spread",
    "wall_seconds",
    "us_per_cell_step",
    "cpu_us_per_cell_step",
    "pressure_cpu_seconds",
    "pressure_cpu_us_per_cell_step",
    "cells",
    "steps",
    "time",
    "outer_iterations",
    "krylov_iterations",
    "krylov_per_step",
    "krylov_per_solve",
    "preconditioner_setups",
    "divergence_max",
    "divergence_over_limit",
    "peak_memory_bytes",
    "peak_memory_bytes_per_cell",
    "commit",
    "set",
    "petsc",
    "folder",
    "message",
];

/// Those of them that are numbers, costs and counts of a run.
pub const NUMBERS: [&str; 20] = [
    "repeats",
    "cpu_seconds",
    "cpu_spread",
    "wall_seconds",
    "us_per_cell_step",
    "cpu_us_per_cell_step",
    "pressure_cpu_seconds",
    "pressure_cpu_us_per_cell_step",
    "cells",
    "steps",
    "time",
    "outer_iterations",
    "krylov_iterations",
    "krylov_per_step",
    "krylov_per_solve",
    "preconditioner_setups",
    "divergence_max",
    "divergence_over_limit",
    "peak_memory_bytes",
    "peak_memory_bytes_per_cell",
];

/// Those that `study.md` has where the study file does not say.
pub const USUAL: [&str; 7] = [
    "cpu_seconds",
    "wall_seconds",
    "us_per_cell_step",
    "cpu_us_per_cell_step",
    "krylov_per_step",
    "steps",
    "peak_memory_bytes",
];

/// A column of numbers as heads of tables and axes of figures have it.
pub fn head(column: &str) -> &str {
    match column {
        "cpu_seconds" => "CPU s",
        "cpu_spread" => "CPU spread",
        "wall_seconds" => "wall s",
        "us_per_cell_step" => "us per cell and step",
        "cpu_us_per_cell_step" => "CPU us",
        "pressure_cpu_seconds" => "CPU s of the pressure",
        "pressure_cpu_us_per_cell_step" => "CPU us of the pressure per cell and step",
        "outer_iterations" => "C-HSMAC",
        "krylov_iterations" => "Krylov",
        "krylov_per_step" => "Krylov a step",
        "krylov_per_solve" => "Krylov a solve",
        "preconditioner_setups" => "setups",
        "divergence_max" => "max |D|",
        "divergence_over_limit" => "max |D|/D0",
        "peak_memory_bytes" => "MB",
        "peak_memory_bytes_per_cell" => "bytes a cell",
        other => other,
    }
}

/// What the axis of a figure of a column says.
pub fn axis(column: &str) -> &'static str {
    match column {
        "cpu_seconds" => "CPU time (s)",
        "wall_seconds" => "wall-clock time (s)",
        "us_per_cell_step" => "time per cell and step (us)",
        "cpu_us_per_cell_step" => "CPU time per cell and step (us)",
        "pressure_cpu_seconds" => "CPU time of the pressure (s)",
        "pressure_cpu_us_per_cell_step" => "CPU time of the pressure per cell and step (us)",
        "outer_iterations" => "C-HSMAC iterations",
        "krylov_iterations" => "Krylov iterations",
        "krylov_per_step" => "Krylov iterations per step",
        "krylov_per_solve" => "Krylov iterations per solve",
        "preconditioner_setups" => "setups of the preconditioner",
        "divergence_max" => "largest |D| (1/s)",
        "divergence_over_limit" => "largest |D| over D0",
        "peak_memory_bytes" => "peak memory (bytes)",
        "peak_memory_bytes_per_cell" => "peak memory per cell (bytes)",
        other => NUMBERS.iter().find(|name| **name == other).copied().unwrap_or_default(),
    }
}
