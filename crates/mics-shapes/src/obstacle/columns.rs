//! What a closed surface encloses of a box, exactly, by the columns below its faces.
//!
//! ```text
//!     . . a___ . .      V = sum over faces of sign(n.w) int ( min(max(w, -h), h) + h ) dA
//!     +--/----\-+ h
//!     | /######\|       with w the height of the face over the box's middle along its last axis,
//!     |/########b       h the half edge, and A the part of the face's projection on the box's
//!     +---------+ -h    floor that lies within it. Faces above the box count with its
//!     w                 whole height, below it with none.
//! ```
//! Each term is a continuous function of the corners, and terms of faces that share an edge agree
//! on it: a face that lies on a side of the box, or an edge that runs through its corners, is no
//! special case. Where the surface encloses a point several times, that counts several times.
//! In 2D the faces are segments, and the last axis is the second.

use super::{Face, walls};
use crate::mesh::{bounds_of, place};
use nalgebra::{Vector2, Vector3};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use std::cell::RefCell;

/// A closed surface.
#[derive(Clone)]
pub struct Columns {
    dimension: usize,
    faces: Vec<Face>,
    tree: Bvh,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

/// Volume and first moment about the middle of a box, in the box's axes.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    volume: f64,
    first: Vector3<f64>,
}

thread_local! {
    static ROOM: RefCell<[Vec<Vector3<f64>>; 3]> = RefCell::default();
}

impl Columns {
    /// Of faces that close a surface.
    pub fn new(dimension: usize, faces: Vec<Face>) -> Columns {
        let boxes = faces.iter().map(bounds_of).enumerate();
        let tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes);
        let [low, high] = walls::ends(faces.iter());
        Columns { dimension, faces, tree, low, high }
    }

    /// The ends of the surface along each axis (m).
    pub fn ends(&self) -> [Vector3<f64>; 2] {
        [self.low, self.high]
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

    /// Volume (m3; m2 in 2D) enclosed of the box with its centre at `middle` (m) and the half edges
    /// `half` (m; the third zero in 2D), which are normal to each other, and the integral of the
    /// place from the middle over that (m4; m3).
    pub fn filled(&self, middle: &Vector3<f64>, half: &[Vector3<f64>; 3]) -> (f64, Vector3<f64>) {
        let last = self.dimension - 1;
        let length = Vector3::from_fn(|a, _| half[a].norm());
        let axes = [0, 1].map(|a| half[a] / length[a]);
        let axes = [axes[0], axes[1], axes[0].cross(&axes[1])];
        let turned = |x: &Vector3<f64>| Vector3::from_fn(|a, _| axes[a].dot(&(x - middle)));
        let bounds = self.column(middle, half, &axes[last]);
        let mut sum = Sum::default();
        ROOM.with_borrow_mut(|room| {
            self.tree.intersect_aabb(&bounds).for_each(|k| {
                let face = self.faces[k as usize].each_ref().map(turned);
                if self.dimension == 2 {
                    sum.add_segment(&face, &length);
                } else {
                    sum.add_triangle(&face, &length, room);
                }
            });
        });
        let first = (0..3).map(|a| sum.first[a] * axes[a]).sum();
        (sum.volume, first)
    }

    /// The box about a box and all that lies above it along its last axis.
    fn column(&self, middle: &Vector3<f64>, half: &[Vector3<f64>; 3], up: &Vector3<f64>) -> Aabb {
        let reach = half.iter().map(|edge| edge.abs()).sum::<Vector3<f64>>();
        let farthest = (self.high - middle).abs().sup(&(self.low - middle).abs()).norm();
        // A box along the axes has a column along one: of the others it has no part.
        let above = (farthest * up).map(|x| if x.abs() < 1e-12 * farthest { 0.0 } else { x });
        let slack = Vector3::repeat(1e-9 * reach.amax());
        let low = (middle - reach).inf(&(middle + above)) - slack;
        let high = (middle + reach).sup(&(middle + above)) + slack;
        Aabb::new(place(&low), place(&high))
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

/// The same of a triangle.
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

/// On which side of an edge, seen from above, a place is: 1 on the left. The same number with the
/// other sign for the edge the other way round.
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

impl Sum {
    /// Adds what lies below a segment, of a box of these half edges (m).
    fn add_segment(&mut self, [from, to, _]: &Face, half: &Vector3<f64>) {
        let way = to - from;
        if way.x == 0.0 {
            return;
        }
        // Where along the segment it passes the box's sides, and its floor and ceiling.
        let at_x = |x: f64| ((x - from.x) / way.x).clamp(0.0, 1.0);
        let [first, last] = [at_x(-half.x), at_x(half.x)];
        let at_y = |y: f64| if way.y == 0.0 { first } else { (y - from.y) / way.y };
        let within = |t: f64| t.clamp(first.min(last), first.max(last));
        let [floor, ceiling] = [at_y(-half.y), at_y(half.y)].map(within);
        let mut ends = [first, floor, ceiling, last];
        ends.sort_unstable_by(f64::total_cmp);
        for piece in ends.windows(2).filter(|piece| piece[1] > piece[0]) {
            let dx = (piece[1] - piece[0]) * way.x;
            // Simpson's rule is exact for polynomials of the third degree.
            for (t, weight) in
                [(piece[0], 1.0), (0.5 * (piece[0] + piece[1]), 4.0), (piece[1], 1.0)]
            {
                let x = from.x + t * way.x;
                let y = (from.y + t * way.y).clamp(-half.y, half.y);
                let dx = -weight / 6.0 * dx;
                self.volume += dx * (y + half.y);
                self.first.x += dx * x * (y + half.y);
                self.first.y += 0.5 * dx * (y * y - half.y * half.y);
            }
        }
    }

    /// Adds what lies below a triangle, of a box of these half edges (m), with room for polygons.
    fn add_triangle(
        &mut self,
        face: &Face,
        half: &Vector3<f64>,
        [within, part, next]: &mut [Vec<Vector3<f64>>; 3],
    ) {
        within.clear();
        within.extend(face);
        for axis in [0, 1] {
            for sign in [-1.0, 1.0] {
                clip(within, |x| sign * x[axis] - half[axis], |height| height <= 0.0, next);
                std::mem::swap(within, next);
            }
        }
        let below_ceiling = |x: &Vector3<f64>| x.z - half.z;
        clip(within, below_ceiling, |height| height >= 0.0, part);
        self.add_prisms(part, |_| half.z, half.z);
        // What lies in the ceiling has been counted.
        clip(within, below_ceiling, |height| height < 0.0, part);
        clip(part, |x| x.z + half.z, |height| height >= 0.0, next);
        self.add_prisms(next, |w| w, half.z);
    }

    /// Adds the prisms from the floor at `-h` up to a polygon, whose corners' heights `top` gives.
    fn add_prisms(&mut self, polygon: &[Vector3<f64>], top: impl Fn(f64) -> f64, h: f64) {
        for k in 2..polygon.len() {
            let corners = [polygon[0], polygon[k - 1], polygon[k]];
            let [a, b, c] = corners;
            let area = 0.5 * (b - a).xy().perp(&(c - a).xy());
            let heights = corners.map(|x| top(x.z));
            let height: f64 = heights.iter().sum();
            self.volume += area * (height / 3.0 + h);
            // The integral of a product of two linear functions over a triangle.
            let middle: Vector2<f64> = corners.iter().map(|x| x.xy()).sum();
            let product: Vector2<f64> = corners.iter().zip(heights).map(|(x, w)| w * x.xy()).sum();
            let first = area * ((product + height * middle) / 12.0 + h / 3.0 * middle);
            let squares: f64 = heights.iter().map(|w| w * w).sum();
            self.first += Vector3::new(
                first.x,
                first.y,
                0.5 * area * ((squares + height * height) / 12.0 - h * h),
            );
        }
    }
}

/// The part of a polygon whose height over a plane is kept.
fn clip(
    polygon: &[Vector3<f64>],
    height: impl Fn(&Vector3<f64>) -> f64,
    keeps: impl Fn(f64) -> bool,
    kept: &mut Vec<Vector3<f64>>,
) {
    kept.clear();
    let Some(mut from) = polygon.last() else { return };
    let mut above = height(from);
    for to in polygon {
        let next = height(to);
        if keeps(above) != keeps(next) {
            kept.push(from + above / (above - next) * (to - from));
        }
        if keeps(next) {
            kept.push(*to);
        }
        (from, above) = (to, next);
    }
}
