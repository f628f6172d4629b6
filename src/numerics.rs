//! The numbers of the method: those that were chosen or fitted once, for all cases.
//!
//! [`Numerics`] says what each is, in which unit, its default and its valid range. A case can give
//! them under `[numerics]`, for experiments, and is warned of; nobody who computes a flow should
//! have to think about them. `docs/constants.md` has what was measured of each, and the numbers
//! that follow from the scheme, or bound rounding or iterations: these stand beside their use.
//!
//! A scene has one copy, in its [`Domain`](crate::domain::Domain), and its contacts another.

pub use mics_run::config::Numerics;
