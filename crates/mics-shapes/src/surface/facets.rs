//! A convex polyhedron of many faces about the origin that is asked for distances without a loop
//! over all faces.
//!
//! ```text
//!    +--+--+--+--+      each cell of a grid lists the faces that may be nearest to one of its
//!    |  |  |  |  |      points, found by halving cells. The nearest face of a point outside is one
//!    +--+--+--+--+      of them, and one of them has it on its outer side.
//!    |  | a|ab| b|
//!    +--+--+--+--+
//! ```

use super::patches;
use crate::boxes::convex::Convex;
use crate::boxes::rows;
use crate::{Lattice, Nearest, SurfacePoint, Tile};
use nalgebra::Vector3;

/// Part of the size within which corners are one.
const SAME: f64 = 1e-9;

/// Times that the grid's cell is halved along each axis, up to so many faces, and of more.
const HALVINGS: [(usize, u32); 2] = [(400, 4), (usize::MAX, 5)];

/// A face: its plane and which of the edges are its own.
#[derive(Clone, Debug)]
pub struct Facet {
    /// Outward normal, of length 1.
    pub normal: Vector3<f64>,
    /// The plane's distance from the origin (m).
    pub offset: f64,
    first: u32,
    count: u32,
    /// Centre and radius of a sphere that holds it (m).
    middle: Vector3<f64>,
    reach: f64,
}

/// An edge of a face, counterclockwise.
#[derive(Clone, Debug)]
struct Edge {
    corner: u32,
    from: Vector3<f64>,
    along: Vector3<f64>,
    length: f64,
    /// In the face's plane, outwards.
    out: Vector3<f64>,
}

/// The faces that may be the nearest ones, by the cells of a grid.
#[derive(Clone, Debug, Default)]
struct Index {
    low: Vector3<f64>,
    cell: Vector3<f64>,
    count: usize,
    starts: Vec<u32>,
    lists: Vec<u16>,
    all: Vec<u16>,
}

/// A convex polyhedron that holds the origin.
#[derive(Clone, Debug)]
pub struct Facets {
    corners: Vec<Vector3<f64>>,
    faces: Vec<Facet>,
    edges: Vec<Edge>,
    index: Index,
    radius: f64,
}

impl Facets {
    /// The facets of a polyhedron; corners that are one are merged, and faces that then have no
    /// area are left out.
    pub fn new(body: &Convex) -> Facets {
        let size = body.corners().iter().map(|corner| corner.norm()).fold(0.0, f64::max);
        let mut corners: Vec<Vector3<f64>> = Vec::new();
        let mut numbers = Vec::with_capacity(body.corners().len());
        for corner in body.corners() {
            let same = corners.iter().position(|other| (corner - other).amax() < SAME * size);
            numbers.push(same.unwrap_or(corners.len()) as u32);
            if same.is_none() {
                corners.push(*corner);
            }
        }
        let mut faces = Vec::new();
        let mut edges = Vec::new();
        for (normal, offset, round) in body.faces() {
            let mut round: Vec<u32> = round.iter().map(|k| numbers[*k as usize]).collect();
            round.dedup();
            if round.len() > 1 && round.first() == round.last() {
                round.pop();
            }
            if round.len() < 3 {
                continue;
            }
            let first = edges.len() as u32;
            let count = round.len() as u32;
            for (k, corner) in round.iter().enumerate() {
                let from = corners[*corner as usize];
                let way = corners[round[(k + 1) % round.len()] as usize] - from;
                let length = way.norm();
                let along = way.normalize();
                let out = along.cross(&normal);
                edges.push(Edge { corner: *corner, from, along, length, out });
            }
            let places = || round.iter().map(|k| corners[*k as usize]);
            let middle = places().sum::<Vector3<f64>>() / f64::from(count);
            let reach = places().map(|corner| (corner - middle).norm()).fold(0.0, f64::max);
            faces.push(Facet { normal, offset, first, count, middle, reach });
        }
        let mut facets = Facets { corners, faces, edges, index: Index::default(), radius: size };
        facets.find_index();
        facets
    }

    /// The faces.
    pub fn faces(&self) -> &[Facet] {
        &self.faces
    }

    /// The corners (m).
    pub fn corners(&self) -> &[Vector3<f64>] {
        &self.corners
    }

    /// The numbers of a face's corners, counterclockwise.
    pub fn round(&self, face: &Facet) -> impl Iterator<Item = u32> {
        self.edges_of(face).iter().map(|edge| edge.corner)
    }

    /// Radius of the sphere about the origin that holds it (m).
    pub fn radius(&self) -> f64 {
        self.radius
    }

    fn edges_of(&self, face: &Facet) -> &[Edge] {
        &self.edges[face.first as usize..(face.first + face.count) as usize]
    }

    /// Extent from the origin in a direction (m).
    pub fn extent(&self, n: &Vector3<f64>) -> f64 {
        self.corners.iter().map(|corner| corner.dot(n)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Distance of the two closest parallel planes along a face's normal that hold it (m).
    pub fn thickness(&self) -> f64 {
        let width = |face: &Facet| face.offset + self.extent(&-face.normal);
        self.faces.iter().map(width).fold(f64::INFINITY, f64::min)
    }

    /// The depth of the origin below the nearest face (m).
    pub fn depth(&self) -> f64 {
        self.faces.iter().map(|face| face.offset).fold(f64::INFINITY, f64::min)
    }

    /// From the nearest point of a face to a point, which is `above` its plane (m), and whether it
    /// is inside of the face's edges.
    #[inline]
    fn arm_from(&self, face: &Facet, point: &Vector3<f64>, above: f64) -> (Vector3<f64>, bool) {
        let mut best: Option<(f64, Vector3<f64>)> = None;
        for edge in self.edges_of(face) {
            let arm = point - edge.from;
            if edge.out.dot(&arm) > 0.0 {
                let t = edge.along.dot(&arm).clamp(0.0, edge.length);
                let arm = arm - t * edge.along;
                let square = arm.norm_squared();
                if best.is_none_or(|(least, _)| square < least) {
                    best = Some((square, arm));
                }
            }
        }
        best.map_or((above * face.normal, true), |(_, arm)| (arm, false))
    }

    /// The face of a list whose plane a point is furthest above, and how far (m).
    #[inline]
    fn highest(&self, list: &[u16], point: &Vector3<f64>) -> (f64, usize) {
        let mut best = (f64::NEG_INFINITY, 0);
        for k in list {
            let face = &self.faces[*k as usize];
            let above = face.normal.dot(point) - face.offset;
            if above > best.0 {
                best = (above, *k as usize);
            }
        }
        best
    }

    /// The nearest point of the surface.
    pub fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let list = self.index.list(point).unwrap_or(&self.index.all);
        let (above, highest) = self.highest(list, point);
        let top = Nearest { distance: above, normal: self.faces[highest].normal };
        if above <= 0.0 {
            return top;
        }
        let (arm, flat) = self.arm_from(&self.faces[highest], point, above);
        if flat {
            return top;
        }
        let mut best = arm.norm_squared();
        let mut arm = arm;
        let mut at = highest;
        let mut distance = best.sqrt();
        for k in list {
            let face = &self.faces[*k as usize];
            let above = face.normal.dot(point) - face.offset;
            if above > 0.0
                && above * above < best
                && (point - face.middle).norm_squared()
                    < (1.0 + 1e-9) * (distance + face.reach).powi(2)
                && *k as usize != highest
            {
                let (next, _) = self.arm_from(face, point, above);
                let square = next.norm_squared();
                if square < best {
                    best = square;
                    arm = next;
                    at = *k as usize;
                    distance = best.sqrt();
                }
            }
        }
        let normal =
            if distance > 1e-12 * self.radius { arm / distance } else { self.faces[at].normal };
        Nearest { distance, normal }
    }

    /// The feet of the perpendiculars from a point inside on faces up to `within` (m) away.
    pub fn feet(&self, point: &Vector3<f64>, within: f64, feet: &mut Vec<Nearest>) {
        feet.clear();
        for face in &self.faces {
            let distance = face.normal.dot(point) - face.offset;
            let inside = |edge: &Edge| edge.out.dot(&(point - edge.from)) <= SAME * self.radius;
            if distance < 0.0 && -distance <= within && self.edges_of(face).iter().all(inside) {
                feet.push(Nearest { distance, normal: face.normal });
            }
        }
    }

    /// The plane of a face that a point is furthest above of those listed: its height (m), which is
    /// the distance from the surface inside and no more than that outside, and the normal.
    pub fn plane(&self, point: &Vector3<f64>) -> Nearest {
        let list = self.index.list(point).unwrap_or(&self.index.all);
        let (distance, face) = self.highest(list, point);
        Nearest { distance, normal: self.faces[face].normal }
    }

    /// As [`crate::Shape::tile`].
    pub fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        let place = |corner: u32| lattice.place(&self.corners[corner as usize]);
        rows::tile(lattice.planes, found, |rows| {
            for face in &self.faces {
                rows.add_face(lattice.planes, self.round(face).map(place));
            }
        });
    }

    /// Patches of its faces, about `spacing` (m) wide.
    pub fn patches(&self, spacing: f64) -> Vec<SurfacePoint> {
        let mut all = Vec::new();
        for face in &self.faces {
            let round: Vec<Vector3<f64>> =
                self.round(face).map(|corner| self.corners[corner as usize]).collect();
            let middle = round.iter().sum::<Vector3<f64>>() / round.len() as f64;
            let width = 2.0 * round.iter().map(|x| (x - middle).norm()).fold(0.0, f64::max);
            let from = all.len();
            let fine = if width <= 1.5 * spacing { f64::INFINITY } else { spacing };
            for (k, corner) in round.iter().enumerate() {
                let corners = [middle, *corner, round[(k + 1) % round.len()]];
                patches::of_triangle(&corners, &face.normal, fine, &mut all);
            }
            if fine.is_infinite() {
                let area: f64 = all[from..].iter().map(|patch| patch.area).sum();
                let first: Vector3<f64> =
                    all[from..].iter().map(|patch| patch.area * patch.place).sum();
                all.truncate(from);
                if area > 0.0 {
                    all.push(SurfacePoint { place: first / area, normal: face.normal, area });
                }
            }
        }
        all
    }

    /// Triangles of its faces, counterclockwise seen from outside.
    pub fn triangles(&self) -> Vec<[Vector3<f64>; 3]> {
        let mut all = Vec::new();
        for face in &self.faces {
            let round: Vec<u32> = self.round(face).collect();
            let at = |k: usize| self.corners[round[k] as usize];
            all.extend((2..round.len()).map(|k| [at(0), at(k - 1), at(k)]));
        }
        all
    }

    /// The faces of `near` that may be the highest for a point of a cell that lies inside; all of
    /// them where the surface may pass. Heights over two planes differ evenly from place to place.
    fn highest_within(
        &self,
        middle: &Vector3<f64>,
        half: &Vector3<f64>,
        near: Vec<u16>,
    ) -> Vec<u16> {
        let (most, highest) = self.highest(&near, middle);
        if most > -half.norm() {
            return near;
        }
        let top = self.faces[highest].normal;
        let may = |k: &u16| {
            let face = &self.faces[*k as usize];
            let below = most - (face.normal.dot(middle) - face.offset);
            below <= (1.0 + 1e-6) * (face.normal - top).abs().dot(half) + 1e-9 * self.radius
        };
        near.into_iter().filter(may).collect()
    }

    fn find_index(&mut self) {
        let mut low = self.corners[0];
        let mut high = self.corners[0];
        for corner in &self.corners {
            low = low.inf(corner);
            high = high.sup(corner);
        }
        let margin = Vector3::repeat(0.25 * (high - low).amax());
        low -= margin;
        high += margin;
        let times = HALVINGS.iter().find(|(faces, _)| self.faces.len() <= *faces);
        let times = times.map_or(0, |(_, times)| *times);
        let count = 1 << times;
        let all: Vec<u16> = (0..self.faces.len() as u16).collect();
        let mut lists = vec![Vec::new(); count * count * count];
        self.divide(&low, &(high - low), times, [0; 3], count, &all, &mut lists);
        let mut index =
            Index { low, cell: (high - low) / count as f64, count, all, ..Index::default() };
        index.starts.push(0);
        for list in lists {
            index.lists.extend(list);
            index.starts.push(index.lists.len() as u32);
        }
        self.index = index;
    }

    /// Lists the faces that may be nearest to points of a cell, among those of the one around it.
    #[allow(clippy::too_many_arguments)]
    fn divide(
        &self,
        low: &Vector3<f64>,
        size: &Vector3<f64>,
        times: u32,
        at: [usize; 3],
        count: usize,
        among: &[u16],
        lists: &mut [Vec<u16>],
    ) {
        let middle = low + 0.5 * size;
        let away = |k: &u16| {
            let face = &self.faces[*k as usize];
            let above = face.normal.dot(&middle) - face.offset;
            self.arm_from(face, &middle, above).0.norm()
        };
        let distances: Vec<f64> = among.iter().map(away).collect();
        let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
        let most = (1.0 + 1e-9) * (least + size.norm());
        let near = among.iter().zip(&distances).filter(|(_, away)| **away <= most);
        let near: Vec<u16> = near.map(|(k, _)| *k).collect();
        if times == 0 {
            let near = self.highest_within(&middle, &(0.5 * size), near);
            lists[at[0] + count * (at[1] + count * at[2])] = near;
            return;
        }
        let half = 0.5 * size;
        for k in 0..8usize {
            let high = [k & 1, k >> 1 & 1, k >> 2];
            let low = low + Vector3::from_fn(|a, _| high[a] as f64 * half[a]);
            let at = std::array::from_fn(|a| 2 * at[a] + high[a]);
            self.divide(&low, &half, times - 1, at, count, &near, lists);
        }
    }
}

impl Index {
    /// The faces listed for a point; none where it lies outside of the grid.
    #[inline]
    fn list(&self, point: &Vector3<f64>) -> Option<&[u16]> {
        let mut at = 0;
        for a in (0..3).rev() {
            let place = (point[a] - self.low[a]) / self.cell[a];
            if !(place >= 0.0 && place < self.count as f64) {
                return None;
            }
            at = at * self.count + place as usize;
        }
        Some(&self.lists[self.starts[at] as usize..self.starts[at + 1] as usize])
    }
}
