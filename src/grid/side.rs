//! The places of a side of the domain, and the velocity that it gives there.

use super::{BoundaryKind, Grid};
use nalgebra::Vector3;

impl<const D: usize> BoundaryKind<D> {
    /// The side `side` (0 low, 1 high) across an axis that gives a velocity (m/s) by place (m); in
    /// 2D what that has along the third axis does not count.
    pub fn given(
        grid: &Grid<D>,
        [axis, side]: [usize; 2],
        velocity: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    ) -> BoundaryKind<D> {
        let places = || places(grid, axis, side);
        let values = |c: usize| places().map(|place| velocity(&place)[c]).collect();
        BoundaryKind::Velocity(std::array::from_fn(values))
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
