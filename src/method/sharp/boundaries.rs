//! Where fixed bodies are near boundaries of the box, the velocity's ghosts there are no longer
//! those of a parabola, of whose three cells a body has some.
//!
//! ```text
//!        ( k )
//!     |     |  g      share of the parabola at the place x on the boundary: that of a profile
//!                     through both image points in a gap as wide as g(x)
//!   __x__.__x__._____ boundary
//! ```

use super::cut::CutBodies;
use super::gap::{self, Shares};
use crate::domain::Domain;
use crate::grid::BoundaryKind;
use crate::particles::{Body, all_fixed};
use nalgebra::Vector3;

/// Says which parts of the boundaries obstacles cover.
pub fn cover_boundaries<const D: usize>(cut: &CutBodies<D>, domain: &mut Domain<D>) {
    domain.boundaries.uncover();
    for (axis, cuts) in cut.bodies.iter().flat_map(|body| body.faces.at_sides.iter().enumerate()) {
        for cut in cuts.iter() {
            let face = cut.face as usize;
            domain.boundaries.cover(&domain.grid, axis, face, cut.solid_fraction);
        }
    }
}

/// Finds that share under all bodies that are near a boundary, on ghosts as well; there is none
/// where bodies move.
pub fn straighten_boundaries<const D: usize>(
    cut: &CutBodies<D>,
    domain: &mut Domain<D>,
    bodies: &[Body],
) {
    if !all_fixed(bodies) {
        return domain.boundaries.bend(0.0);
    }
    domain.boundaries.bend(1.0);
    let size = domain.grid.size;
    for (axis, side) in (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]) {
        if !matches!(domain.boundaries.kinds[axis][side], Some(BoundaryKind::Velocity(_))) {
            continue;
        }
        let boundary = if side == 0 { 0.0 } else { size[axis] };
        let reach = gap::reach(false) * cut.h;
        for body in bodies {
            let bounds = body.reach();
            if (body.centre[axis] - boundary).abs() < bounds[axis] + reach {
                straighten_under(cut, domain, body, &bounds, axis, side);
            }
        }
    }
}

/// Finds that share under one body.
fn straighten_under<const D: usize>(
    cut: &CutBodies<D>,
    domain: &mut Domain<D>,
    body: &Body,
    bounds: &Vector3<f64>,
    axis: usize,
    side: usize,
) {
    let grid = &domain.grid;
    let boundaries = &mut domain.boundaries;
    let mut inwards = Vector3::zeros();
    let boundary = if side == 0 { 0.0 } else { grid.size[axis] };
    inwards[axis] = 1.0 - 2.0 * side as f64;
    let others: [usize; 2] = std::array::from_fn(|n| if n < axis { n } else { n + 1 });
    // The stored places along an axis that an image of the body stands over; one along an axis
    // that there is not.
    let under = |a: usize, shift: f64| {
        let place = move |i: usize| {
            if a < D {
                (i as f64 - grid.ghosts as f64 + grid.start[a] as f64 + 0.5) * grid.h[a] - shift
            } else {
                0.0
            }
        };
        let over = move |x: f64| a >= D || (x - body.centre[a]).abs() < bounds[a];
        (0..if a < D { grid.stored[a] } else { 1 })
            .map(move |i| (i, place(i)))
            .filter(move |(_, x)| over(*x))
    };
    let shifts = |a: usize| {
        let period = if a < D && grid.periodic[a] { Some(grid.size[a]) } else { None };
        [Some(0.0), period, period.map(|period| -period)].into_iter().flatten()
    };
    let [first, second] = others;
    let stride = if first < D { grid.stored[first] } else { 1 };
    let placed = body.placed();
    let turned = placed.turned();
    for (i, x) in shifts(first).flat_map(|shift| under(first, shift)) {
        for (j, y) in shifts(second).flat_map(|shift| under(second, shift)) {
            let mut apart = body.centre;
            apart[axis] -= boundary;
            apart[first] -= x;
            apart[second] -= y;
            if let Some(width) = turned.meets(&apart, &inwards, gap::reach(false) * cut.h) {
                boundaries.straighten(axis, side, i + j * stride, Shares::of(width / cut.h).full);
            }
        }
    }
}
