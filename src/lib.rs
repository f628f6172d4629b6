//! mics
pub mod case;
pub mod check;
pub mod clock;
pub mod coupling;
mod error;
pub mod fluid;
pub mod grid;
pub mod output;
pub mod petsc;
pub mod run;
pub mod scene;
pub mod solids;
pub mod step;

pub use error::{Error, Result};
