//! The particles: what they are ([`body`]) and how they meet ([`contact`]); their shapes are [`crate::geometry`]'s.
//!
//! Bodies are three-dimensional always; in 2D a disc is a body of unit depth.

pub mod body;
pub mod contact;
mod inertia;

pub use body::{Body, Freedom, Motion, Oscillation, nearest_image};
pub use inertia::Inertia;
