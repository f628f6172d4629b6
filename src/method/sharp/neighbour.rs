//! The bodies near one that is built: where they and their images are.

use crate::geometry::Orientation;
use crate::grid::{Boundaries, BoundaryKind, Grid};
use crate::particles::{Body, nearest_image};
use mics_shapes::meets_ball;
use nalgebra::{Matrix3, Vector3};
use std::cell::Cell;

/// A body near another one.
#[derive(Clone, Debug)]
pub struct Neighbour {
    /// Its number.
    pub body: usize,
    /// The way to its nearest image (m), and how that is turned.
    pub(super) apart: Vector3<f64>,
    pub(super) orientation: Orientation,
    /// Axis normal to the plane of symmetry in which this is the image of the body itself.
    pub(super) mirror: Option<usize>,
    /// Its radius (m) where it is round: cells ask many neighbours for their distance, and round
    /// ones respond at once.
    round: Option<f64>,
    /// The radius of the sphere that holds it (m).
    radius: f64,
    /// The point that was last asked for its distance from one that is not round, and that (m).
    known: Cell<(Vector3<f64>, f64)>,
    /// A normal of a round body on which it lies less far than this (m) from its centre misses it;
    /// nothing where one of the two is not round.
    pub(super) grazes: f64,
}

impl Neighbour {
    /// The body `j` beside the body `k`: its nearest image, and of the next ones across periods
    /// those with gaps narrower than `reach` (m).
    pub fn all(
        bodies: &[Body],
        k: usize,
        j: usize,
        periods: &[Option<f64>; 3],
        reach: f64,
    ) -> impl Iterator<Item = Neighbour> {
        // An obstacle has its images in itself.
        let whole = bodies[j].shape().is_obstacle();
        let periods = if whole { &[None; 3] } else { periods };
        let nearest = nearest_image(&bodies[k].centre, &bodies[j].centre, periods);
        let orientation = bodies[j].orientation();
        let own = round(&bodies[k]);
        let near = reach + bodies[k].radius() + bodies[j].radius();
        // By axis, the way to the next image on the other side, where that may be near.
        let next: [Option<f64>; 3] = std::array::from_fn(|a| {
            let way = -periods[a]?.copysign(nearest[a]);
            ((nearest[a] + way).abs() < near).then_some(way)
        });
        (0..8usize).filter_map(move |sides| {
            let mut apart = nearest;
            for a in (0..3).filter(|a| sides >> a & 1 == 1) {
                apart[a] += next[a]?;
            }
            (sides == 0 || apart.norm() < near)
                .then_some(Neighbour::new(j, &bodies[j], apart, orientation, None).beside(own))
        })
    }

    /// The images of the body `k` itself across periods hardly longer than it is wide, the gaps
    /// narrower than `reach` (m).
    pub fn images(
        bodies: &[Body],
        k: usize,
        periods: &[Option<f64>; 3],
        reach: f64,
    ) -> impl Iterator<Item = Neighbour> {
        let orientation = bodies[k].orientation();
        let round = round(&bodies[k]);
        let near = reach + 2.0 * bodies[k].radius();
        let whole = bodies[k].shape().is_obstacle();
        let lengths = periods
            .iter()
            .enumerate()
            .filter_map(move |(axis, length)| Some((axis, (*length).filter(|l| *l < near)?)))
            .filter(move |_| !whole);
        lengths.flat_map(move |(axis, length)| {
            [length, -length].map(|way| {
                let mut apart = Vector3::zeros();
                apart[axis] = way;
                Neighbour::new(k, &bodies[k], apart, orientation, None).beside(round)
            })
        })
    }

    /// The images of the body `k` itself in boundaries along which the fluid slips, the gaps
    /// narrower than `reach` (m).
    pub fn reflections<const D: usize>(
        bodies: &[Body],
        k: usize,
        grid: &Grid<D>,
        boundaries: &Boundaries<D>,
        reach: f64,
    ) -> impl Iterator<Item = Neighbour> {
        let body = &bodies[k];
        let round = round(&bodies[k]);
        let slips = |axis: usize, side: usize| {
            matches!(boundaries.kinds[axis][side], Some(BoundaryKind::Slip))
        };
        let sides = (0..2 * D)
            .map(|face| (face / 2, face % 2))
            .filter(move |(axis, side)| slips(*axis, *side));
        sides.filter_map(move |(axis, side)| {
            let to = if side == 0 { 0.0 } else { grid.size[axis] } - body.centre[axis];
            if 2.0 * to.abs() > reach + 2.0 * body.radius() || body.shape().is_obstacle() {
                return None;
            }
            let mut apart = Vector3::zeros();
            let mut plane = Matrix3::identity();
            apart[axis] = 2.0 * to;
            plane[(axis, axis)] = -1.0;
            // No rotation: what is at x of the body's own axes is at its image there.
            let orientation =
                Orientation::from_matrix_unchecked(plane * body.orientation().matrix());
            Some(Neighbour::new(k, body, apart, orientation, Some(axis)).beside(round))
        })
    }

    fn new(
        number: usize,
        body: &Body,
        apart: Vector3<f64>,
        orientation: Orientation,
        mirror: Option<usize>,
    ) -> Neighbour {
        let round = round(body);
        let radius = body.radius();
        let known = Cell::new((Vector3::zeros(), f64::NEG_INFINITY));
        Neighbour { body: number, apart, orientation, mirror, round, radius, known, grazes: 0.0 }
    }

    /// The neighbour beside a body of this radius (m), where that is round.
    fn beside(mut self, own: Option<f64>) -> Neighbour {
        let square = |radius: f64| (self.apart.norm_squared() - radius * radius).max(0.0);
        // Normals that nearly graze it are looked at.
        self.grazes = match (own, self.round) {
            (Some(_), Some(radius)) => (1.0 - 1e-9) * square(radius).sqrt(),
            _ => f64::NEG_INFINITY,
        };
        self
    }

    /// Whether it comes after the body `k`, or is its own image further along: one of two always
    /// comes first.
    pub(super) fn is_after(&self, k: usize) -> bool {
        let ahead = || self.apart.iter().find(|way| **way != 0.0).is_some_and(|way| *way > 0.0);
        k < self.body || (k == self.body && ahead())
    }

    /// The signed distance (m) of its surface from the point at `arm` (m) from the centre of the
    /// body that it is near.
    #[inline]
    pub(super) fn distance(&self, bodies: &[Body], arm: &Vector3<f64>) -> f64 {
        let place = arm - self.apart;
        if let Some(radius) = self.round {
            return place.norm() - radius;
        }
        let (point, known) = self.known.get();
        if point == *arm && known.is_finite() {
            return known;
        }
        let distance = bodies[self.body].shape().turned(&self.orientation).distance(&place);
        self.known.set((*arm, distance));
        distance
    }

    /// Whether its surface is further from there than this (m) beyond doubt: by the sphere that
    /// holds it, without a root, or since the way from the last point is no longer.
    #[inline]
    pub(super) fn is_beyond(&self, arm: &Vector3<f64>, distance: f64) -> bool {
        let least = (distance + self.radius).max(0.0);
        if (arm - self.apart).norm_squared() > (1.0 + 1e-12) * least * least {
            return true;
        }
        let (point, known) = self.known.get();
        known > distance && (arm - point).norm() < (1.0 - 1e-12) * (known - distance)
    }

    /// Distance (m) along a ray from the point at `from` (m) along `n` to its surface, if it meets
    /// that; of a body that is not round only where that is within the `reach` (m) of the point.
    #[inline]
    pub(super) fn meets(
        &self,
        bodies: &[Body],
        from: &Vector3<f64>,
        n: &Vector3<f64>,
        reach: f64,
    ) -> Option<f64> {
        let apart = self.apart - from;
        if let Some(radius) = self.round {
            return meets_ball(&apart, n, radius);
        }
        if self.is_beyond(from, reach) {
            return None;
        }
        let body = bodies[self.body].shape().turned(&self.orientation);
        // It stays above a plane that the body lies below.
        let above = body.plane(&-apart).is_some_and(|plane| {
            plane.distance > 1e-9 * self.radius && plane.distance > -reach * plane.normal.dot(n)
        });
        if above { None } else { body.meets(&apart, n, f64::INFINITY) }
    }
}

/// The radius of a round body (m).
pub fn round(body: &Body) -> Option<f64> {
    body.shape().is_round().then(|| body.radius())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Ellipse;
    use nalgebra::vector;
    use std::sync::Arc;

    #[test]
    fn neighbour_is_never_beyond_its_distance() {
        let shape = Arc::new(Ellipse::new([1.0, 0.1]));
        let bodies = [Body::new(shape, 1.0, 0.0, Vector3::zeros())];
        let orientation = bodies[0].orientation();
        let neighbour = || Neighbour::new(0, &bodies[0], Vector3::zeros(), orientation, None);
        let asked = neighbour();
        let mut beyond = 0;
        for k in 0..400 {
            let turn = 0.7 * k as f64;
            let place =
                (0.2 + 0.8 * (0.3 * turn).sin().abs()) * vector![turn.cos(), turn.sin(), 0.0];
            let distance = neighbour().distance(&bodies, &place);
            assert!(!asked.is_beyond(&place, distance * (1.0 + 1e-12) + 1e-12));
            beyond += usize::from(asked.is_beyond(&place, 0.2 * distance - 0.1));
            if k % 3 == 0 {
                assert_eq!(asked.distance(&bodies, &place), distance);
            }
        }
        assert!(beyond > 50, "{beyond}");
    }
}
