//! How far a step goes, and what the faces keep in it of their correction (formulas in the parent).

use super::cut::CutBodies;
use crate::Result;
use crate::domain::Domain;
use crate::kernels::faces;
use crate::numerics::{
    CORRECTION_COURANT, CORRECTION_DECAY_CUT_2D, CORRECTION_DECAY_CUT_3D, CORRECTION_DECAY_FIXED,
    CORRECTION_DECAY_OPEN, PRESSURE_TIME,
};
use crate::particles::all_fixed;
use crate::state::State;

/// How far a step goes at the largest face speed.
#[derive(Clone, Copy, Debug)]
pub struct StepNumbers {
    /// Spacings that the flow crosses.
    pub courant: f64,
    /// Squared spacings that viscosity crosses.
    pub diffusion: f64,
    /// Part of the correction that faces keep which a body cuts.
    pub keep: f64,
    /// The same where they are all open.
    pub keep_open: f64,
    /// How much of the last pressure's acceleration they have at once in place of the mean of the
    /// cells'.
    pub own: f64,
    /// Whether a body on any rank has another one or a surface near.
    pub crowded: bool,
}

impl StepNumbers {
    /// Before the first step.
    pub const START: StepNumbers = StepNumbers {
        courant: 0.0,
        diffusion: 0.0,
        keep: 1.0,
        keep_open: 1.0,
        own: 1.0,
        crowded: false,
    };

    /// How far a step of `dt` (s) goes. Collective.
    pub fn find<const D: usize>(
        domain: &Domain<D>,
        s: &State<D>,
        cut: &CutBodies<D>,
        dt: f64,
    ) -> Result<StepNumbers> {
        let crowded = cut.bodies.iter().any(|body| body.has_neighbours);
        let mut most = [faces::fastest(&domain.grid, &s.faces), f64::from(crowded)];
        domain.session.max(&mut most)?;
        let [speed, crowded] = [most[0], most[1]];
        let h = cut.h;
        let nu = domain.fluid.viscosity / domain.fluid.density;
        let courant = dt * speed / h;
        let diffusion = nu * dt / (h * h);
        let rest = all_fixed(&s.bodies);
        // Of cells that are longer one way it goes by the way that they are short: what faces
        // remember is of that size.
        let least = domain.grid.h.iter().copied().fold(h, f64::min);
        let kept = |decay: f64| {
            1.0 - (courant / CORRECTION_COURANT + decay * diffusion * (h / least).powi(2)).min(1.0)
        };
        let [of_cut, of_open] = match (rest, D) {
            (true, _) => [CORRECTION_DECAY_FIXED; 2],
            (false, 3) => [CORRECTION_DECAY_CUT_3D, CORRECTION_DECAY_OPEN],
            (false, _) => [CORRECTION_DECAY_CUT_2D, CORRECTION_DECAY_OPEN],
        };
        let short = (PRESSURE_TIME / diffusion).min(CORRECTION_COURANT / courant);
        let own = if rest { short.min(1.0) } else { 1.0 };
        let keep = kept(of_cut);
        let keep_open = kept(of_open);
        let crowded = crowded > 0.0;
        Ok(StepNumbers { courant, diffusion, keep, keep_open, own, crowded })
    }

    /// For how long (s) of a step `dt` (s) the cells still have the last pressure's acceleration.
    pub fn in_cells(&self, dt: f64) -> f64 {
        (1.0 - self.own) * dt
    }
}
