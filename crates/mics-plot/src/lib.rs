//! Figures, films and reports of runs: they read run folders and know no solver.

pub mod figure;
pub mod film;
pub mod plot;
pub mod report;
pub mod study;
