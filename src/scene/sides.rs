//! The sides of the box as a case has them.

use crate::config::{Case, Side};
use crate::grid::{BoundaryKind, Grid};
use crate::particles::Body;
use nalgebra::Vector3;

use super::build::axes;

/// Depth within a side (spacings) down to which obstacles count as covering it.
const THIN: f64 = 1e-3;

/// Part of a face that rounding leaves open where it is covered.
const CLOSED: f64 = 1e-5;

/// The velocity that a side of a case gives, through the open part of each of its faces.
struct CaseSide<'a, const D: usize> {
    side: &'a Side,
    axis: usize,
    high: bool,
    grid: &'a Grid<D>,
    obstacles: Vec<&'a Body>,
    /// Axis of the height above the bed, and whether the bed is at its high end.
    height: (usize, bool),
    /// Start of the part that obstacles leave open (m): in 2D, and along the height in 3D.
    begin: f64,
    /// Edges of that part along the side (m).
    sizes: Vec<f64>,
}

impl<const D: usize> CaseSide<'_, D> {
    /// Narrows the side along an axis to the part that obstacles leave open of it, from the first
    /// open place to the last: a parabola is zero at its edges.
    fn narrow(&mut self, axis: usize) {
        let length = self.grid.size[axis];
        let h = self.grid.h[axis];
        let n = self.grid.cells[axis];
        let across = (0..D).find(|a| *a != axis && *a != self.axis);
        let open = |k: usize| {
            let mut place = Vector3::zeros();
            place[axis] = (k as f64 + 0.5) * h;
            place[self.axis] = if self.high { self.grid.size[self.axis] } else { 0.0 };
            let cells = across.map_or(1, |across| self.grid.cells[across]);
            let opens = (0..cells).map(|cell| {
                let mut place = place;
                across.iter().for_each(|a| place[*a] = (cell as f64 + 0.5) * self.grid.h[*a]);
                self.open(&place)
            });
            opens.fold(0.0, f64::max)
        };
        let first = (0..n).find(|k| open(*k) > 0.0);
        let last = (0..n).rfind(|k| open(*k) > 0.0);
        let (Some(first), Some(last)) = (first, last) else { return };
        let low = (first as f64 + 1.0 - open(first)) * h;
        let high = if last + 1 == n && open(last) == 1.0 {
            length
        } else {
            (last as f64 + open(last)) * h
        };
        self.begin = low;
        let place = self.place_of(axis);
        self.sizes[place] = high - low;
    }

    /// Place of an axis among those along the side.
    fn place_of(&self, axis: usize) -> usize {
        axis - usize::from(axis > self.axis)
    }

    /// The heights (m) above the bed between which the face around a place (m) lies, and the height
    /// that is open.
    fn heights(&self, place: &Vector3<f64>) -> ([f64; 2], f64) {
        let (axis, hangs) = self.height;
        let depth = self.sizes[self.place_of(axis)];
        let edge = |half: f64| {
            let height = place[axis] + half * self.grid.h[axis] - self.begin;
            (if hangs { depth - height } else { height }).clamp(0.0, depth)
        };
        let ends = [edge(-0.5), edge(0.5)];
        (if hangs { [ends[1], ends[0]] } else { ends }, depth)
    }

    /// Share of the face around a place (m) that no obstacle covers.
    fn open(&self, place: &Vector3<f64>) -> f64 {
        // A box of the face, a little way into the domain.
        let mut half = Vector3::zeros();
        half.iter_mut().zip(self.grid.h).for_each(|(half, h)| *half = 0.5 * h);
        half[self.axis] *= THIN;
        let mut middle = *place;
        middle[self.axis] += if self.high { -half[self.axis] } else { half[self.axis] };
        let covers = |body: &&Body| body.placed().turned().part_of(&(middle - body.centre), &half);
        let open = 1.0 - self.obstacles.iter().map(covers).sum::<f64>();
        if open > CLOSED { open } else { 0.0 }
    }
}

impl<const D: usize> CaseSide<'_, D> {
    /// The velocity (m/s) at a place of the side (m).
    fn velocity(&self, place: &Vector3<f64>) -> Vector3<f64> {
        match self.side {
            Side::MovingWall(v) => Vector3::from(axes::<f64, 3>(v)),
            side if !side.inflow().is_empty() => {
                let (heights, depth) = self.heights(place);
                let by_height = side.share_between(heights, depth);
                let mut along = (0..3).filter(|a| *a != self.axis).map(|a| place[a]);
                let mut x: [f64; 2] = std::array::from_fn(|_| along.next().unwrap_or_default());
                if let Side::InflowParabola(_) = self.side {
                    x[0] = (x[0] - self.begin).clamp(0.0, self.sizes[0]);
                }
                let dimension = self.sizes.len() + 1;
                let open = self.open(place);
                let of = |c: usize| match by_height {
                    Some(share) => open * share * side.inflow()[0][c],
                    None => open * side.inflow_at(&x, &self.sizes, c),
                };
                Vector3::from_fn(|c, _| if c < dimension { of(c) } else { 0.0 })
            }
            _ => Vector3::zeros(),
        }
    }
}

/// The condition at a side (0 low, 1 high) across an axis, of which obstacles may cover a part; an
/// inflow that varies at a factor of 1.
pub(super) fn boundary<const D: usize>(
    grid: &Grid<D>,
    at: [usize; 2],
    case: &Case,
    bodies: &[Body],
) -> Option<BoundaryKind<D>> {
    let side = case.boundary.side(2 * at[0] + at[1]).unwrap_or(&Side::Periodic);
    match side {
        Side::Periodic => None,
        Side::Outflow => Some(BoundaryKind::Outflow),
        Side::Slip => Some(BoundaryKind::Slip),
        _ => {
            let axis = at[0];
            let sizes = (0..D).filter(|&a| a != axis).map(|a| grid.size[a]).collect();
            let obstacles = bodies.iter().filter(|body| body.is_obstacle()).collect();
            let high = at[1] == 1;
            let height = case.height(axis);
            let mut side =
                CaseSide { side, axis, high, grid, obstacles, height, begin: 0.0, sizes };
            if !side.obstacles.is_empty() {
                match side.side {
                    Side::InflowParabola(_) if D == 2 => side.narrow(1 - axis),
                    Side::InflowHalfParabola(_) | Side::InflowLog(_) => side.narrow(height.0),
                    _ => {}
                }
            }
            Some(BoundaryKind::given(grid, at, |place| side.velocity(place)))
        }
    }
}
