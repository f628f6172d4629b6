//! Regions of the surface of an obstacle: all faces that one contact of a part of a body may touch.
//!
//! ```text
//!        ( o )            a face is in a region by the direction from it to the part or by its
//!    \   /   \   /        normal: two walls of a groove are two, all triangles of a flat bed
//!     \ /     \ /         are one. They are chosen anew where the contacts of a step are
//!      x       x          searched for; who was held by one face is held by all
//!       \_____/
//! ```
//! A ball touches a flat surface once, however many triangles that has: of the depths of faces,
//! edges and corners (of all of each, by its nearest point) those of edges count against and those
//! of corners for it, as in Euler's characteristic of what lies within the ball,
//!
//! ```text
//!   D^p = sum_faces d^p - sum_edges d^p + sum_corners d^p        corner: 1 - its edges + its faces
//! ```
//! of which is left: the nearest points of all places where the surface comes nearest, less the
//! saddles between them. D changes smoothly as the ball goes from one face to the next, also
//! where these make a hollow.

use crate::distance::closest;
use crate::mesh::{Face, Mesh};
use crate::part::{Core, Part, Polytope};
use crate::placed::{Placed, Pose};
use crate::support::Beside;
use nalgebra::{Rotation3, Vector3};

/// Cosine of the angle between the directions to a part, or between the normals, up to which faces
/// are of one region.
const ALIKE: f64 = 0.866;

/// The faces that one contact may touch, the nearest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    pub(crate) faces: Vec<Held>,
    /// Edges and corners, and how often they count.
    pub(crate) edges: Vec<([u32; 2], f64)>,
    pub(crate) corners: Vec<(u32, f64)>,
    /// The sharp ones, which may touch a face of a part.
    pub(crate) sharp_edges: Vec<[u32; 2]>,
    pub(crate) sharp_corners: Vec<u32>,
}

/// A face of a region, at hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Held {
    /// Its corners (m), of a segment the second twice, and its outward normal.
    pub corners: [Vector3<f64>; 3],
    pub normal: Vector3<f64>,
    /// The number that contacts know it by.
    pub origin: u32,
}

/// Regions, and the room of those that were.
#[derive(Clone, Debug, Default)]
pub struct Regions {
    all: Vec<Region>,
    count: usize,
    scratch: Scratch,
}

#[derive(Clone, Debug, Default)]
struct Scratch {
    /// Faces in reach, with gaps and directions, and then their regions.
    near: Vec<(f64, Vector3<f64>, u32)>,
    /// Of each region, of its nearest face, the direction to the part and the normal.
    seeds: Vec<[Vector3<f64>; 2]>,
    of: Vec<u32>,
    /// Edges with their regions, and whether they are sharp.
    edges: Vec<([u32; 2], u32, bool)>,
    /// Corners with their regions and how often they count.
    corners: Vec<(u32, u32, i32)>,
}

impl Regions {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// One by its number.
    pub fn get(&self, k: usize) -> &Region {
        &self.all[k]
    }

    /// Room for one more, empty.
    fn push(&mut self) {
        if self.count == self.all.len() {
            self.all.push(Region::default());
        }
        let Region { faces, edges, corners, sharp_edges, sharp_corners } =
            &mut self.all[self.count];
        faces.clear();
        edges.clear();
        corners.clear();
        sharp_edges.clear();
        sharp_corners.clear();
        self.count += 1;
    }
}

/// The point of a face, an edge or a corner that is nearest to a part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    /// From there to the part's surface (m), negative where they overlap.
    pub gap: f64,
    /// From there to the part, of length 1.
    pub up: Vector3<f64>,
    /// The point (m).
    pub place: Vector3<f64>,
}

/// That of the simplex with these corners (m) of a face with this normal.
pub(crate) fn foot(
    part: &Part,
    pose: &Pose,
    simplex: &[Vector3<f64>],
    normal: &Vector3<f64>,
) -> Foot {
    let middle = pose.place + pose.orientation * part.place;
    if matches!(part.core, Core::Point) {
        return foot_of_ball(&middle, part.rounding, simplex, normal);
    }
    if let Core::Ellipsoid { half, .. } = &part.core {
        let placed = Placed::new(part, pose);
        return foot_of_ellipsoid(&Beside { placed: &placed, half }, simplex, normal);
    }
    let core = Core::Polytope(Polytope { corners: simplex.to_vec(), faces: Vec::new() });
    let other = Part { place: Vector3::zeros(), core, rounding: 0.0, radius: 0.0 };
    let identity = Pose { place: Vector3::zeros(), orientation: Rotation3::identity() };
    let guess = nearest(simplex, &middle) - middle;
    match closest(part, pose, &other, &identity, &guess) {
        Some(found) => Foot { gap: found.distance, up: -found.normal, place: found.points[1] },
        // Cores that overlap: as deep as the skin is thick.
        None => Foot { gap: -part.rounding, up: *normal, place: nearest(simplex, &middle) },
    }
}

/// The same of a ball about a place (m).
#[inline]
pub(crate) fn foot_of_ball(
    middle: &Vector3<f64>,
    radius: f64,
    simplex: &[Vector3<f64>],
    normal: &Vector3<f64>,
) -> Foot {
    let place = nearest(simplex, middle);
    let way = middle - place;
    let (distance, height) = (way.norm(), way.dot(normal));
    // Straight below a face its outward normal says which way out is.
    if height <= -(1.0 - 1e-9) * distance {
        return Foot { gap: -distance - radius, up: *normal, place };
    }
    Foot { gap: distance - radius, up: way / distance, place }
}

/// The same of an ellipsoid: the least signed distance from it.
fn foot_of_ellipsoid(own: &Beside<'_>, simplex: &[Vector3<f64>], normal: &Vector3<f64>) -> Foot {
    let corner = |place: &Vector3<f64>| {
        let (gap, up) = own.corner(place);
        Foot { gap, up, place: *place }
    };
    match simplex {
        [a, b, c] => {
            let lowest = own.furthest(&-normal);
            let gap = (lowest - a).dot(normal);
            let place = lowest - gap * normal;
            let edges = [[*a, *b], [*b, *c], [*c, *a]];
            let beyond = |edge: &&[Vector3<f64>; 2]| {
                normal.cross(&(edge[1] - edge[0])).dot(&(place - edge[0])) < 0.0
            };
            let feet = edges.iter().filter(beyond).map(|edge| foot_of_ellipsoid(own, edge, normal));
            let nearest = feet.min_by(|one, other| one.gap.total_cmp(&other.gap));
            nearest.unwrap_or(Foot { gap, up: *normal, place })
        }
        [a, b] => {
            let length = (b - a).norm();
            let along = (b - a) / length;
            let line = if own.half.z == 0.0 {
                let lowest = own.furthest(&-normal);
                Some(((lowest - a).dot(normal), *normal, (lowest - a).dot(&along)))
            } else {
                let middle = a + 0.5 * length * along - own.placed.place;
                let known = normal.norm_squared() > 0.0;
                own.line(a, &along, &if known { -normal } else { middle })
            };
            match line {
                Some((gap, up, foot)) if foot > 0.0 && foot < length => {
                    Foot { gap, up, place: a + foot * along }
                }
                Some((.., foot)) if foot >= length => corner(b),
                _ => corner(a),
            }
        }
        _ => corner(&simplex[0]),
    }
}

/// The point of a corner, a segment or a triangle that is nearest to another one (m).
#[inline]
fn nearest(simplex: &[Vector3<f64>], point: &Vector3<f64>) -> Vector3<f64> {
    match simplex {
        [a, b] => nearest_of_segment(a, b, point),
        [a, b, c] => nearest_of_triangle([a, b, c], point),
        _ => simplex[0],
    }
}

fn nearest_of_segment(a: &Vector3<f64>, b: &Vector3<f64>, point: &Vector3<f64>) -> Vector3<f64> {
    let edge = b - a;
    let part = (point - a).dot(&edge) / edge.norm_squared();
    if part <= 0.0 {
        *a
    } else if part >= 1.0 {
        *b
    } else {
        a + part * edge
    }
}

/// By the regions of the plane in which the corners, the edges or the face are nearest (Ericson,
/// Real-Time Collision Detection, 5.1.5).
fn nearest_of_triangle([a, b, c]: [&Vector3<f64>; 3], point: &Vector3<f64>) -> Vector3<f64> {
    let (e, f) = (b - a, c - a);
    let of = |corner: &Vector3<f64>| {
        let way = point - corner;
        (e.dot(&way), f.dot(&way))
    };
    let ((ae, af), (be, bf), (ce, cf)) = (of(a), of(b), of(c));
    let (u, v, w) = (be * cf - ce * bf, ce * af - ae * cf, ae * bf - be * af);
    if u > 0.0 && v > 0.0 && w > 0.0 {
        let normal = e.cross(&f);
        return point - (point - a).dot(&normal) / normal.norm_squared() * normal;
    }
    let mut best = (f64::INFINITY, *a);
    for (beyond, [p, q]) in [(u, [b, c]), (v, [c, a]), (w, [a, b])] {
        if beyond <= 0.0 {
            let at = nearest_of_segment(p, q, point);
            let square = (point - at).norm_squared();
            if square < best.0 {
                best = (square, at);
            }
        }
    }
    best.1
}

impl Mesh {
    /// Finds the regions within `reach` (m) of a part of a body in this pose, in the axes of the
    /// surface, the nearest first, and adds them; their numbers.
    pub fn regions(
        &self,
        part: &Part,
        pose: &Pose,
        reach: f64,
        regions: &mut Regions,
    ) -> std::ops::Range<usize> {
        let begin = regions.count;
        let mut scratch = std::mem::take(&mut regions.scratch);
        self.find_near(part, pose, reach, &mut scratch);
        let Scratch { near, seeds, of, .. } = &mut scratch;
        for (_, up, face) in near.iter() {
            let own = [*up, self.face(*face).normal];
            let alike = |seed: &[Vector3<f64>; 2]| (0..2).any(|k| seed[k].dot(&own[k]) >= ALIKE);
            let known = seeds.iter().position(alike);
            let k = known.unwrap_or(seeds.len());
            if known.is_none() {
                seeds.push(own);
                regions.push();
            }
            let (corners, Face { normal, origin, .. }) =
                (self.corners_of(*face), *self.face(*face));
            regions.all[begin + k].faces.push(Held { corners, normal, origin });
            of.push(k as u32);
        }
        if near.len() > 1 || part.core != Core::Point {
            self.find_edges(&mut scratch, &mut regions.all[begin..regions.count]);
        }
        regions.scratch = scratch;
        begin..regions.count
    }

    /// The faces within reach that do not face away from a part, the nearest first.
    fn find_near(&self, part: &Part, pose: &Pose, reach: f64, scratch: &mut Scratch) {
        let Scratch { near, seeds, of, .. } = scratch;
        near.clear();
        seeds.clear();
        of.clear();
        let middle = pose.place + pose.orientation * part.place;
        let before = self.before(&middle, part.radius + reach);
        self.near(&middle, part.radius + reach, |k| {
            let (face, corners) = (self.face(k), self.corners_of(k));
            let height = (middle - corners[0]).dot(&face.normal);
            if height < -reach || height > part.radius + reach {
                return;
            }
            let corners = &corners[..self.dimension()];
            if height < 0.0 && (middle - nearest(corners, &middle)).norm() > before {
                return;
            }
            // As with walls of the box, the sphere about a part is in reach or not.
            let sphere = foot_of_ball(&middle, part.radius, corners, &face.normal);
            if sphere.gap <= reach {
                let foot = foot(part, pose, corners, &face.normal);
                near.push((foot.gap, foot.up, k));
            }
        });
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
    }

    /// How far a point is from the nearest face that it lies in front of (m), if that is within a
    /// distance (m). A face that it lies behind and that is farther is the far side of a thin wall.
    fn before(&self, point: &Vector3<f64>, within: f64) -> f64 {
        let mut least = f64::INFINITY;
        self.near(point, within, |k| {
            let (face, corners) = (self.face(k), self.corners_of(k));
            if (point - corners[0]).dot(&face.normal) >= 0.0 {
                let at = nearest(&corners[..self.dimension()], point);
                least = least.min((point - at).norm());
            }
        });
        // A corner that both have counts for both.
        least * (1.0 + 1e-9)
    }

    /// Finds the edges and corners of regions: each belongs to one, the first of its faces'.
    fn find_edges(&self, scratch: &mut Scratch, regions: &mut [Region]) {
        let Scratch { near, of, edges, corners, .. } = scratch;
        edges.clear();
        corners.clear();
        for ((_, _, face), region) in near.iter().zip(of.iter()) {
            let face = self.face(*face);
            // Those of a segment are its edges, as of a triangle.
            let sign = if self.dimension() == 2 { -1 } else { 1 };
            for k in 0..self.dimension() {
                let [a, b] = [face.corners[k], face.corners[(k + 1) % 3]];
                corners.push((a, *region, sign));
                if self.dimension() == 3 {
                    edges.push(([a.min(b), a.max(b)], *region, face.sharp[k]));
                }
            }
        }
        edges.sort_unstable_by_key(|edge| (edge.0, edge.1));
        for group in edges.chunk_by(|one, other| one.0 == other.0) {
            let (ends, first, _) = group[0];
            let counts = 1.0 - group.len() as f64;
            let region = &mut regions[first as usize];
            if counts != 0.0 {
                region.edges.push((ends, counts));
            }
            if group.iter().any(|edge| edge.2) {
                region.sharp_edges.push(ends);
            }
            corners.extend(ends.map(|corner| (corner, u32::MAX, -1)));
        }
        corners.sort_unstable_by_key(|corner| (corner.0, corner.1));
        for group in corners.chunk_by(|one, other| one.0 == other.0) {
            let (corner, first, _) = group[0];
            let counts = 1 + group.iter().map(|(_, _, counts)| counts).sum::<i32>();
            let region = &mut regions[first as usize];
            if counts != 0 {
                region.corners.push((corner, f64::from(counts)));
            }
            if self.is_sharp(corner) {
                region.sharp_corners.push(corner);
            }
        }
    }

    /// The number by which contacts know the nearest face of a region.
    pub fn nearest_of(&self, region: &Region) -> usize {
        region.faces.first().map_or(0, |face| face.origin as usize)
    }

    /// Whether a region has a face that contacts know by this number.
    pub fn has(&self, region: &Region, origin: usize) -> bool {
        region.faces.iter().any(|face| face.origin as usize == origin)
    }

    /// The number by which contacts know the face of a region that is nearest to a point (m).
    pub fn face_at(&self, region: &Region, point: &Vector3<f64>) -> usize {
        let far = |face: &Held| {
            (point - nearest(&face.corners[..self.dimension()], point)).norm_squared()
        };
        let best = region.faces.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        best.map_or(0, |face| face.origin as usize)
    }

    /// The gap (m) between a part of a body in this pose and the surface, of which a point is at
    /// most `most` (m) from the part's place, and the direction to there; in the axes of the
    /// surface.
    pub(crate) fn gap(&self, part: &Part, pose: &Pose, most: f64) -> Option<(Vector3<f64>, f64)> {
        let middle = pose.place + pose.orientation * part.place;
        let mut best: Option<Foot> = None;
        let before = self.before(&middle, most * (1.0 + 1e-9));
        self.near(&middle, most * (1.0 + 1e-9), |k| {
            let (face, corners) = (self.face(k), self.corners_of(k));
            let (height, corners) =
                ((middle - corners[0]).dot(&face.normal), &corners[..self.dimension()]);
            if height < 0.0 && (middle - nearest(corners, &middle)).norm() > before {
                return;
            }
            let foot = foot(part, pose, corners, &face.normal);
            if best.is_none_or(|best| foot.gap < best.gap) {
                best = Some(foot);
            }
        });
        best.map(|foot| (-foot.up, foot.gap))
    }
}
