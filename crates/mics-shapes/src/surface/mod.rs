//! Surfaces of bodies: points and triangles all over them, distances from them, and what they
//! enclose.

pub(crate) mod balls;
pub(crate) mod ellipsoid;
pub(crate) mod facets;
pub(crate) mod moments;
pub(crate) mod outline;
pub(crate) mod patches;
pub mod stl;
pub(crate) mod superquadric;
