//! `mics`: particle-laden incompressible flow with every particle resolved by the grid.
//!
//! These pages are the manual of the method; how to run cases and what was measured is in the book,
//! in the repository's `docs/`. Read in this order: what is solved (here), a step (of a
//! [`method`]), its terms ([`kernels::advection`], [`kernels::diffusion`], [`kernels::faces`],
//! [`poisson::pressure`]), its stability ([`scheme`]), the wall ([`method::sharp`],
//! [`method::mixture`]), contacts ([`contact`]), the constants ([`numerics`]), and what a case can
//! ask for ([`config::Case`] and the tables in it, [`config::MeasureKind`] for what is
//! measured). Each page opens with its formulas, and with the stencil where there is one.
//!
//! # What is solved
//!
//! ```text
//!   div u = 0,   rho ( du/dt + u.grad u ) = -grad p + div( mu (grad u + grad u^T) )   in the fluid
//!   u = V_k + omega_k x r                                                            on particle k
//!   m dV/dt = force by the fluid + (m - m_f) g + contacts,   I domega/dt = torque + contacts
//!              of a free one
//! ```
//! on equal cells with velocity and pressure at their centres and a second, divergence-free
//! velocity on their faces; p is without the hydrostatic part, which leaves gravity to the
//! particles. A step predicts u without the new pressure, finds the pressure that makes the
//! divergence of every cell smaller than the limit D0, and corrects.
//!
//! # Sharp surfaces
//!
//! By default a particle's wall is where it is: it covers a part m of the volume around a face and
//! leaves H = 1 - m open, and the velocity inside it is set to continue the profile of the flow
//! beside its wall.
//!
//! ```text
//! (7)      u* = u + dt [ -div(U u) + div( mu (grad u + grad u^T) )/rho ]
//!              cells, the fluid's rho and mu
//! (8)      U = H q + m U_b.n,  q = mean(u*) + dt a + correction,  a = -grad p^n/rho
//!              faces, U_b the body's motion
//! (13-15)  -div( H grad phi )/rho + added mass of free bodies = -D/dt           until max |D| < D0
//! (16)     u = u* + dt (H_w a_w + H_e a_e)/(1 + (H_w + H_e)/2)        cells, with the new pressure
//! (19)     F = what the fluid loses in a step, in its parts by pressure, wall shear, rest
//!              the force
//! ```
//! [`method::sharp`] derives it.
//!
//! # The mixture method of the paper
//!
//! The method of the paper (Ushijima et al. 2003), whose equation numbers are used throughout, as
//! it is printed: fluid and particles are one mixture. With the fraction `alpha_k` of a cell inside
//! particle k:
//!
//! ```text
//! (1)      rho = rho_f + sum_k alpha_k (rho_k - rho_f)                    mixture; viscosity alike
//! (7)      u* = u + dt [ -u.grad u + (1/rho) div( mu (grad u + grad u^T) ) ]
//!              cells, without pressure
//! (8)      U = mean(u*) - (dt/rho) dp^n/dn                                                   faces
//! (13-15)  div( (1/rho) grad phi ) = D/dt,  p += phi,  U -= (dt/rho) grad phi   until max |D| < D0
//! (16)     u_f = u* - (dt/rho) grad p                             cells, with the new pressure
//! (19)     F_k = sum alpha_k dV rho_k [ -u.grad u - (grad p_f - div tau)/rho ]
//! (17, 18) m dV/dt = F + (m - m_f) g + contacts,  I domega/dt = T + contacts        free particles
//! (20-26)  F_n = k d^gamma + eta d^((gamma-1)/2) v_n,
//!              F_t = -(k_t xi + eta_t v_t), |F_t| <= mu F_n, in substeps
//! (27)     u = u_f + sum_k alpha_k (v_k - u_f),  v_k = V_k + omega_k x r             the wall
//! (28, 29) p = p_f + sum_k alpha_k (mean of p in k - p_f)
//! ```
//! It is there to compare with the paper; [`method::mixture`] is its step.
//!
//! # The house
//!
//! The modules, in the order of their arrows:
//!
//! | module | owns |
//! |---|---|
//! | [`petsc`] | session, decomposition and halo of the grid, linear solve; the only `unsafe` |
//! | [`grid`] | the grid, its fields, the conditions at the sides of the box |
//! | [`kernels`] | advection, diffusion, faces: a file each, its stencil at the top |
//! | [`poisson`] | the pressure equation: operator, multigrid, C-HSMAC |
//! | [`geometry`] | solid fractions of cells and faces; the shapes are [`mics_shapes`]'s |
//! | [`particles`], [`contact`] | bodies; how they touch, and the fluid in the gaps between them |
//! | [`state`] | what lasts from step to step, and nothing else |
//! | [`drive`] | a force, a slope or a flow rate that moves the fluid |
//! | [`varying`] | inflows and drives that vary over time |
//! | [`force`] | a force per volume by place, time and velocity, that a library's user gives |
//! | [`domain`] | where a scene takes place: grid, fluid, pressure equation, ranks |
//! | [`method`] | how a step is made: sharp surfaces, the mixture method, no bodies |
//! | [`numerics`], [`scheme`], [`step_size`] | numbers; time schemes, limits and length of a step |
//! | [`config`], [`error`], [`interrupt`] | of [`mics_run`]: a checked case; errors; signals |
//! | [`scene`] | case to scene: builds only what the scene needs |
//! | [`launch`] | ranks that the program starts by itself |
//! | [`run`], [`check`](mod@check), [`output`] | time loop, scene description, what a run leaves |
//! | [`clock`] | where the time goes |
//! | [`archive`], [`system`] | state written and read; the machine |
//!
//! Figures, films and reports are the crate `mics-plot`, which reads what a run leaves; the command
//! line and tables of runs are `src/bin/mics`.
//!
//! # Sources
//!
//! - S. Ushijima et al. 2003, MICS, Journal of JSCE No. 740, p. 121 (in Japanese): the method and
//!   its numbers.
//! - S. Balay et al., PETSc users manual; R. Falgout and U. Yang 2002, hypre: the linear solvers.
//! - S. Gottlieb and C.-W. Shu 1998, Math. Comput. 67, p. 73: the two-stage Runge-Kutta scheme.
//! - P. Cundall and O. Strack 1979, Geotechnique 29, p. 47: contacts of soft discs.
//! - B. Jobard and W. Lefer 1997: evenly spaced streamlines of the figures.
//!
//! The references of the shipped cases are named in their folders.

pub mod archive;
pub mod check;
pub mod clock;
pub mod contact;
pub mod domain;
pub mod drive;
pub mod force;
pub mod geometry;
pub mod grid;
pub mod kernels;
pub mod launch;
pub mod method;
pub mod numerics;
pub mod output;
pub mod particles;
pub mod petsc;
pub mod poisson;
pub(crate) mod reach;
pub mod run;
pub mod scene;
pub mod scheme;
pub mod sharing;
pub mod state;
pub mod step_size;
pub(crate) mod sums;
pub mod system;
pub mod varying;

pub use mics_run::{Error, Result, config, error, interrupt};
use mics_run::{drag, words};
