//! A flow past bodies that has stayed its own mirror image, where a wake sheds vortices.
//!
//! ```text
//!   |mean of u_b| < 1e-6 |mean of u_a|      a along the stream, b across it
//! ```
//! Where the flow is symmetric, the mean across is 0 but for rounding. A scene that is symmetric
//! stays so for hundreds of passages of the stream: rounding is all that grows. The drag is that of
//! the symmetric flow then, which no experiment has. No perturbation is there by default: it would
//! change every steady flow, and what is compared with its mirror image.

use crate::Result;
use crate::check;
use crate::config::Case;
use crate::drive::mean;
use crate::scene::Scene;

/// Reynolds numbers from which on an isolated body sheds vortices, in 2D and 3D (Jackson 1987, J.
/// Fluid Mech. 182; Natarajan & Acrivos 1993, J. Fluid Mech. 254).
const SHEDS: [f64; 2] = [47.0, 278.0];

/// Part of the mean velocity below which the one across it is rounding.
const ROUNDING: f64 = 1e-6;

/// Diameters that the stream has to have gone.
const WAY: f64 = 20.0;

/// Says so, with the key that perturbs. Collective.
///
/// # Errors
/// When ranks cannot sum.
pub(super) fn stayed<const D: usize>(case: &Case, scene: &Scene<D>) -> Result<Option<String>> {
    let Some((whose, reynolds, diameter, speed)) = check::wake(case) else { return Ok(None) };
    let gone = scene.state.time * speed / diameter;
    if reynolds < SHEDS[D - 2]
        || gone < WAY
        || case.initial.perturbation != 0.0
        || case.initial.from.is_some()
    {
        return Ok(None);
    }
    let mut means = [0.0; 3];
    for (axis, mean_velocity) in means.iter_mut().enumerate().take(D) {
        *mean_velocity =
            mean(&scene.domain.session, &scene.domain.grid, axis, &scene.state.faces)?.abs();
    }
    let along = means.iter().copied().fold(0.0, f64::max);
    let across =
        means[..D].iter().filter(|mean_velocity| **mean_velocity < ROUNDING * along).count();
    Ok((across == D - 1).then(|| {
        format!(
            "note: the flow has stayed symmetric to rounding, where at Re = {reynolds:.0} {whose} \
            sheds vortices: forces may be far from those of a wake (a fifth of the drag at Re = \
            100); initial.perturbation = {:.2} (m/s) wakes it",
            0.05 * speed
        )
    }))
}
