//! Surfaces of obstacles as contacts see them: faces, which are triangles or the segments of a
//! section, that share edges and corners.
//!
//! ```text
//!      \  1 /       faces 1, 2, ... with outward normals; of a corner or an edge it is known
//!    2  \../  5     whether it is sharp: convex, and no part of a flat or of a straight edge
//!       /3 \
//! ```

use nalgebra::Vector3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector as Place;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use std::f64::consts::TAU;

/// Distance (of the domain's size) within which two corners are one.
const SAME: f64 = 1e-9;
/// Angle (rad) by which a surface is bent at a sharp edge: numbers of single precision bend what
/// was meant to be flat by less.
const SHARP: f64 = 1e-3;

/// A surface by its faces.
#[derive(Clone)]
pub struct Mesh {
    dimension: usize,
    corners: Vec<Vector3<f64>>,
    /// Whether each corner is sharp.
    sharp: Vec<bool>,
    faces: Vec<Face>,
    tree: Bvh,
}

/// A face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    /// Its corners by number, counterclockwise seen from outside; the third of a segment repeats
    /// the second.
    pub corners: [u32; 3],
    /// Outward normal, of length 1.
    pub normal: Vector3<f64>,
    /// Whether the edge after each corner is sharp.
    pub sharp: [bool; 3],
    /// The number of the face that this one is a periodic image of, or its own.
    pub origin: u32,
}

impl std::fmt::Debug for Mesh {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "Mesh of {} faces", self.faces.len())
    }
}

pub(crate) fn place(x: &Vector3<f64>) -> Place {
    Place::new(x.x, x.y, x.z)
}

/// The box about a face.
pub(crate) fn bounds_of([a, b, c]: &[Vector3<f64>; 3]) -> Aabb {
    Aabb::new(place(&a.inf(b).inf(c)), place(&a.sup(b).sup(c)))
}

impl Mesh {
    /// A mesh of triangles (3D), or of segments whose third corner repeats the second (2D), with
    /// the numbers that contacts know them by, in a domain of this size (m).
    pub(crate) fn new(
        dimension: usize,
        given: impl Iterator<Item = ([Vector3<f64>; 3], u32)>,
        size: f64,
    ) -> Mesh {
        let normal = |[a, b, c]: &[Vector3<f64>; 3]| match dimension {
            2 => (b - a).cross(&Vector3::z()).try_normalize(0.0),
            _ => (b - a).cross(&(c - a)).try_normalize(0.0),
        };
        let given: Vec<_> = given.filter_map(|(t, k)| Some((t, k, normal(&t)?))).collect();
        let all: Vec<_> = given.iter().flat_map(|(t, ..)| t.iter().copied()).collect();
        let (corners, numbers) = merge(&all, SAME * size);
        let faces =
            given.iter().zip(numbers.chunks_exact(3)).map(|((_, origin, normal), k)| Face {
                corners: [k[0], k[1], k[2]],
                normal: *normal,
                sharp: [false; 3],
                origin: *origin,
            });
        let faces: Vec<Face> = faces.collect();
        let boxes = given.iter().map(|(t, ..)| bounds_of(t)).enumerate();
        let tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes);
        let sharp = vec![false; corners.len()];
        let mut mesh = Mesh { dimension, corners, sharp, faces, tree };
        if dimension == 2 {
            mesh.find_sharp_corners()
        } else {
            mesh.find_sharp_edges()
        }
        mesh
    }

    /// Number of corners of a face: as many as dimensions.
    pub(crate) fn dimension(&self) -> usize {
        self.dimension
    }

    /// A face by its number.
    pub(crate) fn face(&self, k: u32) -> &Face {
        &self.faces[k as usize]
    }

    /// A corner by its number (m).
    pub(crate) fn corner(&self, k: u32) -> Vector3<f64> {
        self.corners[k as usize]
    }

    /// The corners of a face (m), of a segment the second twice.
    pub(crate) fn corners_of(&self, face: u32) -> [Vector3<f64>; 3] {
        self.face(face).corners.map(|k| self.corner(k))
    }

    /// Whether a corner is sharp.
    pub(crate) fn is_sharp(&self, corner: u32) -> bool {
        self.sharp[corner as usize]
    }

    /// Calls `take` with the faces whose boxes lie within these distances (m) of a point (m), along
    /// the axes.
    pub(crate) fn near(&self, point: &Vector3<f64>, wide: &Vector3<f64>, take: impl FnMut(u32)) {
        let bounds = Aabb::new(place(&(point - wide)), place(&(point + wide)));
        self.tree.intersect_aabb(&bounds).for_each(take);
    }

    /// Height (m) of the corner of the face `other` that `face` lacks above the plane of `face`.
    fn beyond(&self, face: usize, other: usize) -> f64 {
        let own = &self.faces[face];
        let apart = |k: &u32| (self.corner(*k) - self.corner(own.corners[0])).dot(&own.normal);
        let theirs = self.faces[other].corners.iter().filter(|k| !own.corners.contains(k));
        theirs.map(apart).fold(0.0, |most: f64, x| if x.abs() > most.abs() { x } else { most })
    }

    /// By how much the surface is bent between two faces (rad), negative where it is concave.
    fn bend(&self, face: usize, other: usize) -> f64 {
        let [n, m] = [face, other].map(|k| self.faces[k].normal);
        n.cross(&m).norm().atan2(n.dot(&m)).copysign(-self.beyond(face, other))
    }

    fn find_sharp_corners(&mut self) {
        let mut ends: Vec<(u32, usize)> = Vec::with_capacity(2 * self.faces.len());
        for (k, face) in self.faces.iter().enumerate() {
            ends.extend(face.corners[..2].iter().map(|corner| (*corner, k)));
        }
        ends.sort_unstable();
        for two in ends.windows(2).filter(|two| two[0].0 == two[1].0) {
            self.sharp[two[0].0 as usize] = self.bend(two[0].1, two[1].1) > SHARP;
        }
    }

    /// A corner is sharp where the angles of its faces are less than a full turn, as of no flat nor
    /// folded surface, and it is convex in the mean of its edges.
    fn find_sharp_edges(&mut self) {
        let mut edges: Vec<([u32; 2], usize, usize)> = Vec::with_capacity(3 * self.faces.len());
        let mut angles = vec![0.0; self.corners.len()];
        let mut bends = vec![0.0; self.corners.len()];
        for (f, face) in self.faces.iter().enumerate() {
            for k in 0..3 {
                let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| face.corners[k]);
                edges.push(([a.min(b), a.max(b)], f, k));
                let [e, g] = [b, c].map(|end| self.corner(end) - self.corner(a));
                angles[a as usize] += e.angle(&g);
            }
        }
        edges.sort_unstable();
        for group in edges.chunk_by(|one, other| one.0 == other.0) {
            let bend = match group {
                [(_, f, _), (_, g, _)] => self.bend(*f, *g),
                // The surface ends there.
                _ => f64::NEG_INFINITY,
            };
            group[0].0.iter().for_each(|corner| bends[*corner as usize] += bend);
            for (_, face, k) in group {
                self.faces[*face].sharp[*k] = bend > SHARP;
            }
        }
        let whole = angles.iter().zip(&bends);
        self.sharp =
            whole.map(|(angle, bend)| TAU - angle > SHARP * SHARP && *bend > 0.0).collect();
    }
}

/// Makes corners one that are nearer than a distance (m): those left, and the number of each.
fn merge(all: &[Vector3<f64>], near: f64) -> (Vec<Vector3<f64>>, Vec<u32>) {
    // Along a direction that no lattice has.
    let along = |x: &Vector3<f64>| x.dot(&Vector3::new(0.577, 0.319_5, 0.751_7));
    let mut order: Vec<(f64, usize)> = all.iter().map(along).zip(0..).collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut corners = Vec::<Vector3<f64>>::new();
    let mut numbers = vec![0; all.len()];
    // Where along the direction the corners lie.
    let mut ways: Vec<f64> = Vec::new();
    for (way, k) in order {
        let known = (0..corners.len()).rev().take_while(|c| way - ways[*c] <= near);
        let same = |c: &usize| (corners[*c] - all[k]).norm() <= near;
        let found = known.into_iter().find(same);
        numbers[k] = found.unwrap_or(corners.len()) as u32;
        if found.is_none() {
            corners.push(all[k]);
            ways.push(way);
        }
    }
    (corners, numbers)
}
