//! What a run leaves: logs, fields, figures, and their readers. Reads the state; the step does not know of it.

pub mod figure;
mod folder;
pub mod measure;
pub mod plot;
pub mod snapshot;

pub use folder::{Folder, Log, StepRow, may_use};
