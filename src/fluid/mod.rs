//! The fluid's terms, one file each: advection, diffusion, the faces and the pressure iteration.

pub mod advection;
pub mod diffusion;
pub mod faces;
pub mod poisson;
pub mod pressure;
