//! mics
pub mod case;
pub mod error;
pub use error::{Error, Result};
