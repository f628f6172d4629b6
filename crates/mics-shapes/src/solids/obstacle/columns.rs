//! Whether a closed surface encloses a place, by its faces above that.
//!
//! In 2D the faces are segments, and above is along the second axis.

use super::{Face, walls};
use crate::contact::faces::{bounds_of, place};
use nalgebra::Vector3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};

/// A closed surface.
#[derive(Clone)]
pub struct Columns {
    dimension: usize,
    faces: Vec<Face>,
    tree: Bvh,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Columns {
    /// The columns over faces that close a surface.
    pub fn new(dimension: usize, faces: Vec<Face>) -> Columns {
        let boxes = faces.iter().map(bounds_of).enumerate();
        let tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes);
        let [low, high] = walls::ends(faces.iter());
        Columns { dimension, faces, tree, low, high }
    }

    /// The faces.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Whether it encloses a place (m), by the faces above that. One on an edge counts as a little
    /// further along x, and less further along y: of the faces at an edge, one has it.
    pub fn has(&self, x: &Vector3<f64>) -> bool {
        let last = self.dimension - 1;
        if (0..self.dimension).any(|a| x[a] < self.low[a] || x[a] > self.high[a]) {
            return false;
        }
        let mut top = *x;
        top[last] = self.high[last];
        let bounds = Aabb::new(place(x), place(&top));
        let above = |k: u32| match self.dimension {
            2 => above_segment(&self.faces[k as usize], x),
            _ => above_triangle(&self.faces[k as usize], x),
        };
        self.tree.intersect_aabb(&bounds).map(above).sum::<i32>() > 0
    }
}

/// 1 where a segment with the solid below it passes above a place, -1 where it has it above.
fn above_segment([from, to, _]: &Face, x: &Vector3<f64>) -> i32 {
    let passes = (from.x <= x.x) != (to.x <= x.x);
    let height = || from.y + (x.x - from.x) / (to.x - from.x) * (to.y - from.y);
    if !passes || height() <= x.y {
        return 0;
    }
    if to.x < from.x { 1 } else { -1 }
}

/// 1 where a triangle with the solid below it lies above a place, -1 where it has it above.
fn above_triangle(face: &Face, x: &Vector3<f64>) -> i32 {
    let turns = [0, 1, 2].map(|k| turn(&face[k], &face[(k + 1) % 3], x));
    if turns[0] != turns[1] || turns[0] != turns[2] {
        return 0;
    }
    let [a, b, c] = face;
    let normal = (b - a).cross(&(c - a));
    let height = a.z - normal.xy().dot(&(x - a).xy()) / normal.z;
    if height > x.z { turns[0] } else { 0 }
}

/// Side of an edge, seen from above, on which a place is: 1 on the left. The number changes its
/// sign for the edge the other way round.
fn turn(from: &Vector3<f64>, to: &Vector3<f64>, x: &Vector3<f64>) -> i32 {
    if (from.x, from.y) > (to.x, to.y) {
        return -turn(to, from, x);
    }
    let way = (to - from).xy();
    let side = way.perp(&(x - from).xy());
    let left = if side != 0.0 {
        side > 0.0
    } else if way.y != 0.0 {
        way.y < 0.0
    } else {
        way.x > 0.0
    };
    if left { 1 } else { -1 }
}
