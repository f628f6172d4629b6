//! Contacts of bodies: their convex parts, and where two of them, or one and a surface, are nearest
//! or touch.

mod beside;
pub(crate) mod depths;
pub(crate) mod distance;
pub(crate) mod faces;
mod flags;
mod foot;
pub(crate) mod ground;
mod near;
pub(crate) mod part;
mod polytope;
pub(crate) mod pose;
pub(crate) mod region;
mod simplex;
mod smooth;
mod support;
pub(crate) mod touch;
