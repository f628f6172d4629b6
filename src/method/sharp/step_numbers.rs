//! Courant and diffusion number, and weights of the face velocities (formulas in the parent).

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

/// The Courant and the diffusion number of a step, and the weights of its face velocities.
#[derive(Clone, Copy, Debug)]
pub struct StepNumbers {
    /// Courant number: spacings that the flow crosses at the largest face speed.
    pub courant: f64,
    /// Diffusion number: squared spacings that viscosity crosses.
    pub diffusion: f64,
    /// Weights of the face velocities.
    pub weights: FaceWeights,
    /// Whether a body on any rank has another one or a surface near.
    pub crowded: bool,
}

/// Weights of the parts of a predicted face velocity.
#[derive(Clone, Copy, Debug)]
pub struct FaceWeights {
    /// Part of the correction that stays on the faces that a body cuts.
    pub cut_correction: f64,
    /// Part of the correction that stays on open faces.
    pub open_correction: f64,
    /// Part of the acceleration by the last pressure that a face takes by itself, in place of the
    /// mean of the cells' accelerations.
    pub face_gradient: f64,
}

impl FaceWeights {
    /// Numbers before the first step.
    pub const START: FaceWeights =
        FaceWeights { cut_correction: 1.0, open_correction: 1.0, face_gradient: 1.0 };

    /// Time (s), of a step `dt` (s), over which the cells still have the last pressure's
    /// acceleration.
    pub fn in_cells(&self, dt: f64) -> f64 {
        (1.0 - self.face_gradient) * dt
    }
}

impl StepNumbers {
    /// Finds the numbers of a step of `dt` (s). Collective.
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
        // The decay by viscosity goes by the least spacing, where cells are longer one way: what
        // faces remember is of that size.
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
        let weights = FaceWeights {
            cut_correction: kept(of_cut),
            open_correction: kept(of_open),
            face_gradient: if rest { short.min(1.0) } else { 1.0 },
        };
        Ok(StepNumbers { courant, diffusion, weights, crowded: crowded > 0.0 })
    }
}
