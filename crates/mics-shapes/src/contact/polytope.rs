//! Distances of convex polygons and polyhedra from points, from each other and from corners, edges
//! and faces that stand fixed.
//!
//! ```text
//!        x_                     of two cores:  every corner with the other core, and in 3D every
//!     d |  \__                                 two edges; the least of them is the distance
//!     .-|-----\-.
//!     |  core   |               of a corner:   the height above the face that it is highest above,
//!     '---------'                              where its foot is in that face, and else its way to
//!                                              the nearest edge; inside that height, negative
//! ```
//! A direction m gives each corner a bound, `m.(y - x) - reach`, than which it is no nearer: most
//! corners and edges are passed over.

use crate::contact::depths::{POWER, Patch};
use crate::contact::flags::Flags;
use crate::contact::near::{Crossing, Foot, crossing, foot_of_ball};
use crate::contact::part::{Edge, Polytope};
use crate::contact::pose::Placed;
use nalgebra::Vector3;

/// Most directions that two are seen along before all corners and edges count.
const MOST: usize = 8;

/// The nearest points of a corner and a core, or of two edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Feature {
    /// Distance of the cores (m).
    pub distance: f64,
    /// From the first to the second.
    pub normal: Vector3<f64>,
    /// On both cores (m).
    pub points: [Vector3<f64>; 2],
    /// Weight with which it counts in a patch.
    counts: f64,
}

/// Two of them, seen along a direction from the first to the second.
struct Seen<'a> {
    sides: [&'a Placed<'a>; 2],
    polytopes: [&'a Polytope; 2],
    /// From the middle of the first to that of the second (m).
    centres: Vector3<f64>,
    /// From each to the other, in its own axes, and how far it reaches there (m).
    own: [Vector3<f64>; 2],
    reach: [f64; 2],
    /// Between them along that direction (m): no two points are nearer.
    gap: f64,
}

impl<'a> Seen<'a> {
    fn along(
        sides: [&'a Placed<'a>; 2],
        polytopes: [&'a Polytope; 2],
        way: Vector3<f64>,
    ) -> Seen<'a> {
        let own = [
            sides[0].orientation.inverse_transform_vector(&way),
            -sides[1].orientation.inverse_transform_vector(&way),
        ];
        let reach = [0, 1].map(|k| {
            let along = polytopes[k].corners.iter().map(|corner| corner.dot(&own[k]));
            along.fold(f64::NEG_INFINITY, f64::max)
        });
        let centres = sides[1].place - sides[0].place;
        let gap = centres.dot(&way) - reach[0] - reach[1];
        Seen { sides, polytopes, centres, own, reach, gap }
    }

    /// Calls with all that may be nearer than `bound` (m), or than what the last call said.
    fn features(&self, mut bound: f64, mut take: impl FnMut(Feature) -> f64) {
        let mut near = [Flags::none(), Flags::none()];
        for side in 0..2 {
            let own = self.sides[side];
            let other = self.sides[1 - side];
            for (k, corner) in self.polytopes[side].corners.iter().enumerate() {
                if self.gap + self.reach[side] - corner.dot(&self.own[side]) > bound {
                    continue;
                }
                near[side].add(k);
                let place = own.at(corner);
                let back = other.orientation.inverse_transform_vector(&(place - other.place));
                let (distance, away) = self.polytopes[1 - side].beside(&back);
                let away = other.orientation * away;
                let foot = place - distance * away;
                let (normal, points) =
                    if side == 0 { (-away, [place, foot]) } else { (away, [foot, place]) };
                bound = take(Feature { distance, normal, points, counts: 1.0 });
            }
        }
        let is_near = |side: usize, edge: &Edge| edge.corners.iter().any(|k| near[side].may(*k));
        let side = self.sides[1];
        for own in self.polytopes[0].edges.iter().filter(|edge| is_near(0, edge)) {
            let ends = self.polytopes[0].ends(&own.corners).map(|end| {
                side.orientation.inverse_transform_vector(&(self.sides[0].at(&end) - side.place))
            });
            for its in self.polytopes[1].edges.iter().filter(|edge| is_near(1, edge)) {
                if let Some(feature) = self.edges(&ends, its, bound) {
                    bound = take(feature);
                }
            }
        }
    }

    /// An edge of the first, by its ends in the axes of the second (m), and one of that, where they
    /// are within `bound` (m) without having crossed.
    fn edges(&self, own: &[Vector3<f64>; 2], its: &Edge, bound: f64) -> Option<Feature> {
        let side = self.sides[1];
        let its = self.polytopes[1].ends(&its.corners);
        let Crossing { points, counts } = crossing(own, &its, bound)?;
        let way = points[1] - points[0];
        let square = way.norm_squared();
        if square == 0.0 || square > bound * bound {
            return None;
        }
        let distance = square.sqrt();
        let way = side.orientation * way;
        let points = points.map(|point| side.at(&point));
        let apart = way.dot(&self.centres) > 0.0;
        apart.then_some(Feature { distance, normal: way / distance, points, counts })
    }
}

/// The nearest points of two cores with these roundings (m), and the patch of all that overlap;
/// `guess` is a direction from the first to the second.
pub(crate) fn meet(
    sides: [&Placed<'_>; 2],
    polytopes: [&Polytope; 2],
    rounding: [f64; 2],
    guess: &Vector3<f64>,
) -> (Feature, Patch) {
    let most = rounding[0] + rounding[1];
    let mut way = guess.try_normalize(0.0).unwrap_or_else(Vector3::x);
    for tried in 0.. {
        let seen = Seen::along(sides, polytopes, way);
        let bound = match tried {
            MOST => f64::INFINITY,
            _ if seen.gap < most => most,
            _ => seen.gap + 0.03 * (most + seen.gap),
        };
        let about = sides[0].at(&(seen.reach[0] * seen.own[0]));
        let mut patch = Patch::about(most, about, f64::from(POWER));
        let mut nearest: Option<Feature> = None;
        seen.features(bound, |feature| {
            let depth = most - feature.distance;
            if depth > 0.0 {
                let place = feature.points[0] + (rounding[0] - 0.5 * depth) * feature.normal;
                patch.add(depth, &feature.normal, &place, feature.counts);
            }
            let best = nearest.filter(|nearest| nearest.distance <= feature.distance);
            nearest = Some(best.unwrap_or(feature));
            // All that overlaps counts, and the nearest of all.
            bound.min(most.max(best.unwrap_or(feature).distance))
        });
        let Some(nearest) = nearest else { continue };
        if nearest.distance <= bound {
            return (nearest, patch);
        }
        way = nearest.normal;
    }
    unreachable!("all corners are within an infinite bound")
}

/// The point of a corner, a segment or a triangle that stands fixed, with this outward normal,
/// which is nearest to a polytope with this rounding (m), of which no corner lies within the solid.
/// `None` where the gap is no less than `most` (m).
pub(crate) fn foot(
    polytope: &Polytope,
    side: &Placed<'_>,
    rounding: f64,
    simplex: &[Vector3<f64>],
    normal: &Vector3<f64>,
    most: f64,
) -> Option<Foot> {
    let mut best = None;
    let mut gap = most;
    let mut take = |foot: Foot| {
        if foot.gap < gap {
            gap = foot.gap;
            best = Some(foot);
        }
        gap
    };
    for place in simplex {
        let back = side.orientation.inverse_transform_vector(&(place - side.place));
        if simplex.len() == 1 || polytope.height(&back) - rounding < most {
            let (distance, away) = polytope.beside(&back);
            let up = -(side.orientation * away);
            take(Foot { gap: distance - rounding, up, place: *place });
        }
    }
    if simplex.len() == 1 {
        return best;
    }
    let mut near = Flags::none();
    let none = Vector3::zeros();
    for (k, corner) in polytope.corners.iter().map(|corner| side.at(corner)).enumerate() {
        if (corner - simplex[0]).dot(normal) - rounding < most {
            near.add(k);
            take(foot_of_ball(&corner, rounding, simplex, &none));
        }
    }
    if near.count == 0 {
        return best;
    }
    for edge in polytope.edges.iter().filter(|edge| edge.corners.iter().any(|k| near.may(*k))) {
        let ends = polytope.ends(&edge.corners).map(|end| side.at(&end));
        for k in 0..if simplex.len() == 2 { 1 } else { 3 } {
            let other = [simplex[k], simplex[(k + 1) % simplex.len()]];
            if let Some(Crossing { points: [x, y], .. }) = crossing(&ends, &other, most + rounding)
            {
                let up = x - y;
                if up.dot(normal) >= 0.0 {
                    let distance = up.norm();
                    let up = up.try_normalize(0.0).unwrap_or(*normal);
                    take(Foot { gap: distance - rounding, up, place: y });
                }
            }
        }
    }
    best
}
