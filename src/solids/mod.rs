//! The particles: what they are ([`body`]), how much of each cell they fill ([`fraction`]) and of each face they cover
//! ([`aperture`]).
//!
//! Bodies are three-dimensional always; in 2D a disc is a body of unit depth.

pub mod aperture;
pub mod body;
pub mod contact;
pub mod fraction;
pub mod reach;
mod sphere;

pub use aperture::{Cut, Opening};
pub use body::{Body, Freedom, Motion, Oscillation, Shape, nearest_image};
pub use fraction::Overlap;
