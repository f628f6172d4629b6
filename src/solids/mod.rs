//! The particles: what they are ([`body`]) and how much of each cell they fill ([`fraction`]).
//!
//! Bodies are three-dimensional always; in 2D a disc is a body of unit depth.

pub mod body;
pub mod contact;
pub mod fraction;
mod sphere;

pub use body::{Body, Freedom, Motion, Oscillation, Shape, nearest_image};
pub use fraction::Overlap;
