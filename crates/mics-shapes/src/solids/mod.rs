//! The shapes, a file each.

pub(crate) mod clump;
pub(crate) mod disc;
pub(crate) mod ellipse;
pub(crate) mod ellipsoid;
pub(crate) mod obstacle;
pub(crate) mod polygon;
pub(crate) mod polyhedron;
pub(crate) mod scaled;
pub(crate) mod sphere;
pub(crate) mod superquadric;
