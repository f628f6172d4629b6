//! Output of a run: logs and fields. Reads the state; the step does not know of it. The formats and
//! their readers are in [`mics_run`], figures and reports in `mics-plot`.

mod bed;
mod bodies;
pub mod checkpoint;
mod file;
mod fit;
mod folder;
pub mod measure;
mod midline;
pub mod probe;
pub mod progress;
mod rows;
pub mod snapshot;
pub mod statistics;
mod surface;
pub mod survey;
pub mod vti;

pub use folder::{Folder, Log, Marks, StepRow, fields_file, may_use, refuse_held};
