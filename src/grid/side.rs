//! The velocity that a side of the domain gives the fluid: by place and time.
//!
//! ```text
//!   ghosts in a step from t to t + dt:  u_b(x, t + dt/2)
//!   faces at its end:                   u_b.n(x, t + dt)
//! ```
//! Whether a side gives the velocity or the pressure shapes the pressure equation, and what slips
//! mirrors bodies: these kinds, [`BoundaryKind`], are built in. Every side that gives a velocity,
//! those of cases too, is one of these.

use super::{BoundaryKind, Grid, VectorField};
use nalgebra::Vector3;
use std::sync::Arc;

/// The velocity that a side of the domain gives the fluid.
pub trait SideVelocity: Send + Sync {
    /// The velocity (m/s) at a place of the side (m) and a time (s); in 2D what it has along the
    /// third axis does not count. Where no side is an outflow, what flows in at any time has to
    /// flow out.
    fn at(&self, place: &Vector3<f64>, time: f64) -> Vector3<f64>;
}

impl<const D: usize> BoundaryKind<D> {
    /// The side `side` (0 low, 1 high) across an axis with the velocity that it gives at a time
    /// (s).
    pub fn given(
        grid: &Grid<D>,
        [axis, side]: [usize; 2],
        of: &dyn SideVelocity,
        time: f64,
    ) -> BoundaryKind<D> {
        let places = || places(grid, axis, side);
        let values = |c: usize| places().map(|place| of.at(&place, time)[c]).collect();
        BoundaryKind::Velocity(std::array::from_fn(values))
    }
}

/// A side whose velocity changes with time.
pub(super) struct Follows<const D: usize> {
    pub axis: usize,
    pub side: usize,
    of: Arc<dyn SideVelocity>,
    /// Its stored positions (m).
    places: Vec<Vector3<f64>>,
    /// Velocity through its faces at the end of the step (m/s).
    pub through: Vec<f64>,
}

impl<const D: usize> Follows<D> {
    pub fn new(grid: &Grid<D>, [axis, side]: [usize; 2], of: Arc<dyn SideVelocity>) -> Self {
        let places: Vec<_> = places(grid, axis, side).collect();
        let through = places.iter().map(|place| of.at(place, 0.0)[axis]).collect();
        Follows { axis, side, of, places, through }
    }

    /// Sets the `values` of the side at a time (s), and what goes through its faces at another.
    pub fn set(&mut self, values: &mut VectorField<D>, time: f64, end: f64) {
        for (k, place) in self.places.iter().enumerate() {
            let velocity = self.of.at(place, time);
            values.iter_mut().enumerate().for_each(|(a, values)| values[k] = velocity[a]);
            self.through[k] = self.of.at(place, end)[self.axis];
        }
    }
}

/// The stored positions (m) of a side, the first axis along it fastest; ghosts beyond it repeat its
/// edge.
fn places<const D: usize>(
    grid: &Grid<D>,
    axis: usize,
    side: usize,
) -> impl Iterator<Item = Vector3<f64>> {
    let positions = grid.stored.iter().product::<usize>() / grid.stored[axis];
    (0..positions).map(move |mut k| {
        let mut place = Vector3::zeros();
        place[axis] = if side == 0 { 0.0 } else { grid.size[axis] };
        for a in (0..D).filter(|a| *a != axis) {
            let i = (k % grid.stored[a] + grid.start[a]) as f64 - grid.ghosts as f64 + 0.5;
            place[a] = (i * grid.h[a]).clamp(0.0, grid.size[a]);
            k /= grid.stored[a];
        }
        place
    })
}
