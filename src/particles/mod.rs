//! The particles: what they are ([`body`]), and which are near each other; their shapes are
//! [`crate::geometry`]'s, how they touch is [`crate::contact`]'s.
//!
//! Bodies are three-dimensional always; in 2D a disc is a body of unit depth.

pub mod body;
mod colours;
mod gap;
mod inertia;
mod load;
mod neighbours;

pub use body::{
    Accelerations, Body, Freedom, Motion, Oscillation, all_fixed, by_number, nearest_image,
};
pub(crate) use colours::{Colours, Span};
pub use gap::gap;
pub use inertia::Inertia;
pub use load::{Impulse, Load, RigidVelocity, Velocities, velocities};
pub(crate) use neighbours::Neighbours;
