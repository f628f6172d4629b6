//! The columns that every study has: no axis or label may take their names.

/// Columns of `study.csv` besides labels and measures, in their order.
pub const COLUMNS: [&str; 22] = [
    "ranks",
    "status",
    "repeats",
    "cpu_seconds",
    "cpu_spread",
    "wall_seconds",
    "us_per_cell_step",
    "cpu_us_per_cell_step",
    "cells",
    "steps",
    "time",
    "outer_iterations",
    "krylov_iterations",
    "krylov_per_step",
    "divergence_max",
    "peak_memory_bytes",
    "peak_memory_bytes_per_cell",
    "commit",
    "set",
    "petsc",
    "folder",
    "message",
];
