//! The columns that every study has: no axis or label may take their names.

/// A column of numbers, costs and counts of a run.
struct Number {
    name: &'static str,
    /// Name in heads of tables.
    head: &'static str,
    /// Label of the axis of a figure.
    axis: &'static str,
}

/// The columns of numbers, in their order.
const NUMBERS: [Number; 20] = [
    number("repeats", "repeats", "repeats"),
    number("cpu_seconds", "CPU s", "CPU time (s)"),
    number("cpu_spread", "CPU spread", "cpu_spread"),
    number("wall_seconds", "wall s", "wall-clock time (s)"),
    number("us_per_cell_step", "us per cell and step", "time per cell and step (us)"),
    number("cpu_us_per_cell_step", "CPU us", "CPU time per cell and step (us)"),
    number("pressure_cpu_seconds", "CPU s of the pressure", "CPU time of the pressure (s)"),
    number(
        "pressure_cpu_us_per_cell_step",
        "CPU us of the pressure per cell and step",
        "CPU time of the pressure per cell and step (us)",
    ),
    number("cells", "cells", "cells"),
    number("steps", "steps", "steps"),
    number("time", "time", "time"),
    number("outer_iterations", "C-HSMAC", "C-HSMAC iterations"),
    number("krylov_iterations", "Krylov", "Krylov iterations"),
    number("krylov_per_step", "Krylov a step", "Krylov iterations per step"),
    number("krylov_per_solve", "Krylov a solve", "Krylov iterations per solve"),
    number("preconditioner_setups", "setups", "setups of the preconditioner"),
    number("divergence_max", "max |D|", "largest |D| (1/s)"),
    number("divergence_over_limit", "max |D|/D0", "largest |D| over D0"),
    number("peak_memory_bytes", "MB", "peak memory (bytes)"),
    number("peak_memory_bytes_per_cell", "bytes a cell", "peak memory per cell (bytes)"),
];

const fn number(name: &'static str, head: &'static str, axis: &'static str) -> Number {
    Number { name, head, axis }
}

/// Names of the columns of numbers.
pub fn numbers() -> Vec<&'static str> {
    NUMBERS.iter().map(|number| number.name).collect()
}

/// Names of the columns of `study.csv` besides labels and measures, in their order.
pub fn all() -> Vec<&'static str> {
    let texts = ["commit", "set", "petsc", "folder", "message"];
    [&["ranks", "status"], &numbers()[..], &texts].concat()
}

/// The columns that `study.md` has where the study file does not say.
pub const USUAL: [&str; 7] = [
    "cpu_seconds",
    "wall_seconds",
    "us_per_cell_step",
    "cpu_us_per_cell_step",
    "krylov_per_step",
    "steps",
    "peak_memory_bytes",
];

/// A column as heads of tables have it.
pub fn head(column: &str) -> &str {
    NUMBERS.iter().find(|number| number.name == column).map_or(column, |number| number.head)
}

/// Label of the axis of a figure of a column of numbers.
pub fn axis(column: &str) -> &'static str {
    NUMBERS.iter().find(|number| number.name == column).map_or("", |number| number.axis)
}
