//! The fluid's terms, one file each: advection, diffusion, the faces and the sides of the box. Pure
//! functions of fields.

pub mod advection;
pub mod boundary;
pub mod diffusion;
pub mod faces;
