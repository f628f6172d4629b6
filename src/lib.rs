//! `mics`: particle-laden incompressible flow with every particle resolved by the grid.
//!
//! The method is MICS (Ushijima et al. 2003): fluid and particles are one mixture on a collocated Cartesian grid, in two
//! or three dimensions. Equation numbers are the paper's. Two couplings share it: [`coupling::sharp`], the default, has its
//! formulas in its own module; [`coupling::mixing`], the paper's, is this. With the fraction `alpha_k` of a cell inside particle k:
//!
//! ```text
//! (1)      rho = rho_f + sum_k alpha_k (rho_k - rho_f)                               mixture; viscosity alike
//! (7)      u* = u + dt [ -u.grad u + (1/rho) div( mu (grad u + grad u^T) ) ]         cells, without pressure
//! (8)      U = mean(u*) + dt a,  a = -(1/rho) dp^n/dn + g (1 - rho_f/rho)            faces
//! (13-15)  div( (1/rho) grad phi ) = D/dt,  p += phi,  U -= (dt/rho) grad phi        until max |D| < D0
//! (16)     u_f = u* + dt (a_low + a_high)/2                                          cells, with the new pressure
//! (19)     F_k = sum alpha_k dV [ -rho u.grad u - grad p_f + div tau ]               force as printed, three parts
//! (17, 18) m dV/dt = F + (m - m_f) g + contacts,  I domega/dt = T + contacts         free particles
//! (20-26)  F_n = k d^gamma + eta d^((gamma-1)/2) v_n,  F_t = -(k_t xi + eta_t v_t), |F_t| <= mu F_n, in substeps
//! (27)     u = u_f + sum_k alpha_k (v_k - u_f),  v_k = V_k + omega_k x r             the wall
//!          F_k = sum rho alpha_k (u_f - v_k) dV/dt                                   force by momentum, on held ones
//!          sum rho alpha_k (v_k - u_f) dV + b_k = 0                                  motion by momentum, of free ones
//! ```
//!
//! The last line is where this code leaves the paper: [`coupling::mixing`] derives it. The momentum of everything in
//! the box is then kept to rounding, at any ratio of densities, and [`audit`] watches it.
//!
//! The step is one function, [`scene::Scene::step`] in [`step`]. The modules, in the order of their arrows:
//!
//! | module | owns |
//! |---|---|
//! | [`petsc`] | the session, the grid's decomposition and halo, the linear solve; the only `unsafe` |
//! | [`grid`] | the grid, its fields, the conditions at the faces of the box |
//! | [`fluid`] | advection, diffusion, faces, the pressure iteration: a file each, its stencil at the top |
//! | [`solids`] | bodies, their exact volume fractions, their contacts |
//! | [`coupling`] | where the two meet: mixture, wall, force, the flight of free particles |
//! | [`audit`] | the balance of momentum over a step |
//! | [`step`] | the method: one function |
//! | [`case`] | a case file, checked: pure data |
//! | [`scheme`] | the time schemes and the limits of their step |
//! | [`scene`] | case to scene: builds only what the scene needs |
//! | [`run`], [`check`](mod@check), [`output`] | the time loop, the description of a scene, what a run leaves |
//! | [`validate`](mod@validate) | the shipped cases beside their references |
//! | [`clock`] | where the time goes |

pub mod audit;
pub mod case;
pub mod check;
pub mod clock;
pub mod coupling;
mod error;
pub mod fluid;
pub mod grid;
pub mod output;
pub mod petsc;
pub mod run;
pub mod scene;
pub mod scheme;
pub mod solids;
pub mod step;
pub mod validate;

pub use error::{Error, Result};
