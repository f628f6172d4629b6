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
//! of corners for it, as in Euler's characteristic of what lies within the ball:
//!
//! ```text
//!   D^p = sum_faces d^p - sum_edges d^p + sum_corners d^p        corner: 1 - its edges + its faces
//! ```
//! This leaves the nearest points of all places where the surface comes nearest, less the saddles
//! between them. D changes smoothly as the ball goes from one face to the next, also where these
//! make a hollow.

use crate::Orientation;
use crate::contact::faces::{Face, Mesh};
use crate::contact::foot::{at_middle, foot};
use crate::contact::near::{Foot, foot_of_ball, nearest};
use crate::contact::part::{Core, Part};
use crate::contact::pose::{Placed, Pose};
use nalgebra::Vector3;

/// Cosine of the angle between the directions to a part, or between the normals, up to which faces
/// are of one region.
const ALIKE: f64 = 0.866;

/// The faces that one contact may touch, the nearest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    pub(crate) faces: Vec<Held>,
    /// Edges and corners that count in the sum, and sharp ones, which may touch a face of a part.
    pub(crate) edges: Vec<Bound<[u32; 2]>>,
    pub(crate) corners: Vec<Bound<u32>>,
    /// Where the middle of the part was (m), and how it was turned, when they were found.
    middle: Vector3<f64>,
    orientation: Orientation,
}

/// A face of a region, at hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Held {
    /// Its corners (m), of a segment the second twice, and its outward normal.
    pub corners: [Vector3<f64>; 3],
    pub normal: Vector3<f64>,
    /// The number that contacts know it by.
    pub origin: u32,
    /// From it to the part when it was found (m), or less where it is not touched.
    pub gap: f64,
}

/// An edge or a corner of faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bound<T> {
    pub corners: T,
    /// Its factor in the sum.
    pub counts: f64,
    pub sharp: bool,
    /// Two of the faces that have it, by their place among those of the region; none of another
    /// region's. It overlaps only where both do.
    pub faces: [u32; 2],
}

/// No face of the region.
pub(crate) const ELSEWHERE: u32 = u32::MAX;

impl Region {
    /// Where a point of the part, in its own axes (m), was then (m).
    pub(crate) fn before(&self, own: &Vector3<f64>) -> Vector3<f64> {
        self.middle + self.orientation * own
    }

    /// Bound of the way of all points of the part since the faces were found (m).
    pub(crate) fn way(&self, part: &Part, pose: &Pose) -> f64 {
        let way = (pose.place + pose.orientation * part.place - self.middle).norm();
        if part.core == Core::Point {
            return way * (1.0 + 1e-9);
        }
        // The norm of the difference of two rotations is sqrt(2) times how far it moves a point.
        let turned = (pose.orientation.matrix() - self.orientation.matrix()).norm();
        (way + part.radius * turned * std::f64::consts::FRAC_1_SQRT_2) * (1.0 + 1e-9)
    }

    /// The number by which contacts know the nearest face.
    pub fn nearest(&self) -> usize {
        self.faces.first().map_or(0, |face| face.origin as usize)
    }

    /// Whether it has a face that contacts know by this number.
    pub fn has(&self, origin: usize) -> bool {
        self.faces.iter().any(|face| face.origin as usize == origin)
    }

    /// The number by which contacts know the face that is nearest to a point (m).
    pub fn face_at(&self, mesh: &Mesh, point: &Vector3<f64>) -> usize {
        let far = |face: &Held| {
            (point - nearest(&face.corners[..mesh.dimension()], point)).norm_squared()
        };
        let best = self.faces.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        best.map_or(0, |face| face.origin as usize)
    }
}

/// Distances within which faces are found (m).
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// All of them, for the fluid in the gaps.
    pub all: f64,
    /// Faces that may be touched before faces are found anew: a bound of their gap will not do.
    pub touched: f64,
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
    /// Direction to the part and normal of the nearest face of each region.
    seeds: Vec<[Vector3<f64>; 2]>,
    /// Region and place there of each face.
    of: Vec<[u32; 2]>,
    /// Edges and corners of faces, with their regions.
    edges: Vec<(u32, Bound<[u32; 2]>)>,
    corners: Vec<(u32, Bound<u32>)>,
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
        let Region { faces, edges, corners, .. } = &mut self.all[self.count];
        faces.clear();
        edges.clear();
        corners.clear();
        self.count += 1;
    }

    /// Finds the regions within reach of a part of a body in this pose, in the axes of the surface,
    /// the nearest first, and adds them; their numbers.
    pub fn find(
        &mut self,
        mesh: &Mesh,
        part: &Part,
        pose: &Pose,
        reach: Reach,
    ) -> std::ops::Range<usize> {
        let begin = self.count;
        let mut scratch = std::mem::take(&mut self.scratch);
        find_near(mesh, part, pose, reach, &mut scratch);
        let Scratch { near, seeds, of, .. } = &mut scratch;
        for (gap, up, k) in near.iter() {
            let face = mesh.face(*k);
            let own = [*up, face.normal];
            let alike = |seed: &[Vector3<f64>; 2]| (0..2).any(|k| seed[k].dot(&own[k]) >= ALIKE);
            let known = seeds.iter().position(alike);
            if known.is_none() {
                seeds.push(own);
                self.push();
            }
            let region = known.unwrap_or(seeds.len() - 1);
            let faces = &mut self.all[begin + region].faces;
            of.push([region as u32, faces.len() as u32]);
            let corners = mesh.corners_of(*k);
            let gap = *gap;
            faces.push(Held { corners, normal: face.normal, origin: face.origin, gap });
        }
        let found = &mut self.all[begin..self.count];
        if near.len() > 1 || part.core != Core::Point {
            find_edges(mesh, &mut scratch, found);
        }
        for region in found {
            region.middle = pose.place + pose.orientation * part.place;
            region.orientation = pose.orientation;
        }
        self.scratch = scratch;
        begin..self.count
    }
}

/// The faces within reach that do not face away from a part, the nearest first.
fn find_near(mesh: &Mesh, part: &Part, pose: &Pose, reach: Reach, scratch: &mut Scratch) {
    let Scratch { near, seeds, of, .. } = scratch;
    near.clear();
    seeds.clear();
    of.clear();
    let placed = Placed::new(part, pose);
    let middle = placed.place;
    let widest = part.radius + reach.all;
    let before = std::cell::OnceCell::new();
    mesh.near(&middle, &extents(mesh, part, &placed, reach.all), |k| {
        let face = mesh.face(k);
        let corners = &mesh.corners_of(k)[..mesh.dimension()];
        let height = (middle - corners[0]).dot(&face.normal);
        let before = || *before.get_or_init(|| nearest_front(mesh, &middle, widest));
        if height > widest || is_behind(part, &middle, face, corners, reach.all, before) {
            return;
        }
        // As with walls of the box, the sphere about a part is in reach or not.
        let sphere = foot_of_ball(&middle, part.radius, corners, &face.normal);
        if sphere.gap > reach.all {
            return;
        }
        let foot = foot_within(mesh, part, pose, k, reach);
        if let Some(foot) = foot.filter(|foot| !is_far_side(part, foot, face)) {
            near.push((foot.gap, foot.up, k));
        }
    });
    near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
}

/// The foot of a face, where it is within reach; that of its middle, with a bound of the gap,
/// where it is not touched.
fn foot_within(mesh: &Mesh, part: &Part, pose: &Pose, k: u32, reach: Reach) -> Option<Foot> {
    let normal = &mesh.face(k).normal;
    let corners = &mesh.corners_of(k)[..mesh.dimension()];
    if part.core == Core::Point {
        return foot(part, pose, corners, normal, reach.all.next_up());
    }
    let (middle, more) = at_middle(part, &Placed::new(part, pose), corners);
    let least = middle.gap - more;
    if least > reach.touched {
        return (least <= reach.all).then_some(Foot { gap: least, ..middle });
    }
    let nearer = foot(part, pose, corners, normal, middle.gap).unwrap_or(middle);
    (nearer.gap <= reach.all).then_some(nearer)
}

/// Whether a face with these corners (m) faces away from a part with this middle (m) by more
/// than `reach` (m), or is the far side of a thin wall: farther than what the middle lies
/// `before` (m). Polytopes are asked at their nearest corner.
fn is_behind(
    part: &Part,
    middle: &Vector3<f64>,
    face: &Face,
    corners: &[Vector3<f64>],
    reach: f64,
    before: impl Fn() -> f64,
) -> bool {
    let height = (middle - corners[0]).dot(&face.normal);
    if height >= 0.0 || matches!(part.core, Core::Polytope(_)) {
        return false;
    }
    height < -reach || (middle - nearest(corners, middle)).norm() > before()
}

/// Distances along the axes from the middle of a part that hold all faces within `reach` (m).
fn extents(mesh: &Mesh, part: &Part, placed: &Placed<'_>, reach: f64) -> Vector3<f64> {
    if part.core == Core::Point {
        return Vector3::repeat(part.radius + reach);
    }
    Vector3::from_fn(|a, _| {
        if a >= mesh.dimension() {
            return reach;
        }
        let axis = Vector3::ith(a, 1.0);
        let along = [axis, -axis].map(|n| (placed.support(&n) - placed.place).dot(&n));
        along[0].max(along[1]) + part.rounding + reach
    })
}

/// Distance (m) of a point from the nearest face that it lies in front of, if that is within a
/// distance (m). A face that it lies behind and that is farther is the far side of a thin wall.
fn nearest_front(mesh: &Mesh, point: &Vector3<f64>, within: f64) -> f64 {
    let mut least = f64::INFINITY;
    mesh.near(point, &Vector3::repeat(within), |k| {
        let face = mesh.face(k);
        let corners = mesh.corners_of(k);
        if (point - corners[0]).dot(&face.normal) >= 0.0 {
            let at = nearest(&corners[..mesh.dimension()], point);
            least = least.min((point - at).norm());
        }
    });
    // A corner that both have counts for both.
    least * (1.0 + 1e-9)
}

/// Finds the edges and corners of regions: each belongs to one, the first of its faces'.
fn find_edges(mesh: &Mesh, scratch: &mut Scratch, regions: &mut [Region]) {
    let Scratch { near, of, edges, corners, .. } = scratch;
    edges.clear();
    corners.clear();
    for ((.., face), [region, place]) in near.iter().zip(of.iter()) {
        let face = mesh.face(*face);
        let faces = [*place, ELSEWHERE];
        // The corners of a segment count as the edges of a triangle do.
        let counts = if mesh.dimension() == 2 { -1.0 } else { 1.0 };
        for k in 0..mesh.dimension() {
            let [a, b] = [face.corners[k], face.corners[(k + 1) % 3]];
            let sharp = mesh.is_sharp(a);
            corners.push((*region, Bound { corners: a, counts, sharp, faces }));
            if mesh.dimension() == 3 {
                let ends = [a.min(b), a.max(b)];
                let sharp = face.sharp[k];
                edges.push((*region, Bound { corners: ends, counts: -1.0, sharp, faces }));
            }
        }
    }
    count(edges, |region, edge| {
        if edge.counts != 0.0 || edge.sharp {
            regions[region as usize].edges.push(edge);
        }
        let faces = [ELSEWHERE; 2];
        let of = |corner| Bound { corners: corner, sharp: false, counts: -1.0, faces };
        corners.extend(edge.corners.map(|corner| (u32::MAX, of(corner))));
    });
    count(corners, |region, corner| {
        if corner.counts != 0.0 || corner.sharp {
            regions[region as usize].corners.push(corner);
        }
    });
}

/// The gap (m) between a part of a body in this pose and the surface, of which a point is at
/// most `most` (m) from the part's place, and the direction to there; in the axes of the
/// surface.
pub(crate) fn gap(mesh: &Mesh, part: &Part, pose: &Pose, most: f64) -> Option<(Vector3<f64>, f64)> {
    let placed = Placed::new(part, pose);
    let middle = placed.place;
    let mut best: Option<Foot> = None;
    let within = most * (1.0 + 1e-9);
    let before = nearest_front(mesh, &middle, within);
    mesh.near(&middle, &Vector3::repeat(within), |k| {
        let face = mesh.face(k);
        let corners = &mesh.corners_of(k)[..mesh.dimension()];
        if is_behind(part, &middle, face, corners, f64::INFINITY, || before) {
            return;
        }
        let most = best.map_or(f64::INFINITY, |best| best.gap);
        let foot = foot_within(mesh, part, pose, k, Reach { all: most, touched: most });
        let foot = foot.filter(|foot| foot.gap < most);
        if let Some(foot) = foot.filter(|foot| !is_far_side(part, foot, face)) {
            best = Some(foot);
        }
    });
    best.map(|foot| (-foot.up, foot.gap))
}

/// Whether the nearest point of a polytope sees a face from behind, as the far side of a tip.
fn is_far_side(part: &Part, foot: &Foot, face: &Face) -> bool {
    matches!(part.core, Core::Polytope(_)) && foot.up.dot(&face.normal) < 0.0
}

/// Calls with each edge or corner once, in the first of its regions, with what all of them count.
fn count<T: Copy + Ord>(all: &mut [(u32, Bound<T>)], mut take: impl FnMut(u32, Bound<T>)) {
    all.sort_unstable_by_key(|(region, one)| (one.corners, *region));
    for group in all.chunk_by(|one, other| one.1.corners == other.1.corners) {
        let (region, first) = group[0];
        let counts = 1.0 + group.iter().map(|(_, one)| one.counts).sum::<f64>();
        let sharp = group.iter().any(|(_, one)| one.sharp);
        let second = group.get(1).filter(|(other, _)| *other == region);
        let faces = [first.faces[0], second.map_or(ELSEWHERE, |(_, one)| one.faces[0])];
        take(region, Bound { counts, sharp, faces, ..first });
    }
}
