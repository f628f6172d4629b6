//! Inflows and drives that vary over time, as a hydrograph has it.
//!
//! ```text
//!   inflow    U_b(t) = f(t) U_b            in every stage of a step, at the time of the stage;
//!                                            faces on the boundary at the end of the step
//!   mean      U_held(t) = f(t) U_held      at the end of the step
//!   force     G = f(t + dt/2) G            over the step, by its middle: exact where f is linear
//! ```
//! The factor f is a function of time alone, so that a run which goes on has the same. Where f has
//! a corner the pressure jumps, and the trapezium of the budget of energy errs by half a step of
//! what the jump gives: to the side of a loss of the method, and less in shorter steps.

use crate::config::OverTime;
use crate::drive::Drive;
use crate::grid::{Boundaries, BoundaryKind, VectorField};
use nalgebra::Vector3;

/// A side of the box whose velocity varies.
struct VaryingSide<const D: usize> {
    axis: usize,
    /// 0 low, 1 high.
    side: usize,
    /// The velocity at a factor of 1 (m/s), as [`BoundaryKind::Velocity`] has it.
    velocity: VectorField<D>,
    factor: OverTime,
}

/// The inflows and the drive that vary, with their values at a factor of 1; none where all is
/// steady.
pub struct Varying<const D: usize> {
    sides: Vec<VaryingSide<D>>,
    drive: Option<(Drive, OverTime)>,
}

impl<const D: usize> Varying<D> {
    /// Those of these boundaries, which have their values at a factor of 1 now, by axis and side,
    /// and the `drive`.
    pub fn new<'a>(
        boundaries: &Boundaries<D>,
        factor: impl Fn(usize, usize) -> Option<&'a OverTime>,
        drive: Option<(Drive, OverTime)>,
    ) -> Varying<D> {
        let side = |f: usize| {
            let axis = f / 2;
            let side = f % 2;
            let factor = factor(axis, side)?.clone();
            let Some(BoundaryKind::Velocity(velocity)) = &boundaries.kinds[axis][side] else {
                return None;
            };
            Some(VaryingSide { axis, side, velocity: velocity.clone(), factor })
        };
        Varying { sides: (0..2 * D).filter_map(side).collect(), drive }
    }

    /// Gives boundaries and drive their values at the factors that `factor` finds of the tables.
    pub fn set(
        &self,
        factor: impl Fn(&OverTime) -> f64,
        boundaries: &mut Boundaries<D>,
        drive: &mut Option<Drive>,
    ) {
        for of in &self.sides {
            let factor = factor(&of.factor);
            if let Some(BoundaryKind::Velocity(all)) = &mut boundaries.kinds[of.axis][of.side] {
                for (now, full) in all.iter_mut().zip(&of.velocity) {
                    now.iter_mut().zip(full).for_each(|(now, full)| *now = factor * full);
                }
            }
        }
        if let Some((full, table)) = &self.drive {
            *drive = Some(full.times(factor(table)));
        }
    }

    /// The force of a drive that varies at a time (s), in N/m3; `None` of others.
    pub fn force_at(&self, time: f64) -> Option<Vector3<f64>> {
        let (drive, factor) = self.drive.as_ref().filter(|(drive, _)| drive.held().is_none())?;
        Some(drive.times(factor.at(time)).at_start())
    }

    /// The acceleration (m/s2) of a mean velocity that a drive holds, over a step that ends at a
    /// time (s); 0 of other drives.
    pub fn held_acceleration(&self, time: f64, dt: f64) -> f64 {
        let Some((Drive::Held { velocity, .. }, factor)) = &self.drive else { return 0.0 };
        velocity * (factor.at(time) - factor.at(time - dt)) / dt
    }

    /// The drive that varies, at its largest.
    pub fn largest_drive(&self) -> Option<Drive> {
        self.drive.as_ref().map(|(drive, factor)| drive.times(factor.largest()))
    }
}
