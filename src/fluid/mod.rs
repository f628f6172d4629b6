//! The fluid's terms, one file each: advection, diffusion, the faces, the sides of the box and the pressure iteration.

pub mod advection;
pub mod border;
pub mod diffusion;
pub mod faces;
pub mod poisson;
pub mod pressure;
