//! Parts that bodies fill of the boxes of a lattice: the cells of a grid, or its faces with the
//! halves of the cells beside them.
//!
//! ```text
//!   planes of an axis    p_0   p_1   p_2   ...
//!              box (i, j, k) from p_i to p_(i+1) along x, and so on
//! ```

pub(crate) mod angle;
pub(crate) mod ball;
pub(crate) mod circle;
pub(crate) mod convex;
pub(crate) mod octant;
pub(crate) mod rim;
pub(crate) mod round;
pub(crate) mod rows;
pub(crate) mod stretched;

use crate::Orientation;
use nalgebra::Vector3;

/// A lattice of boxes, and how a body lies in it, the body's centre at its origin.
#[derive(Clone, Copy, Debug)]
pub struct Lattice<'a> {
    /// Ratio of the body's size to that of its geometry.
    pub factor: f64,
    /// Rotation from the body's own axes to those of the lattice.
    pub orientation: Orientation,
    /// The planes between the boxes along each axis, ascending (m); two alike along z in 2D.
    pub planes: &'a [Vec<f64>; 3],
    /// The axis of the faces in whose middles the boxes lie, where moments and levers are asked
    /// for.
    pub faces: Option<usize>,
}

impl Lattice<'_> {
    /// Where a point of the body's geometry (m) is (m).
    pub(crate) fn place(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.factor * (self.orientation * point)
    }

    /// The middle of a box and its half edges in the axes of the body's geometry (m).
    pub(crate) fn own_box(&self, at: [usize; 3]) -> (Vector3<f64>, [Vector3<f64>; 3]) {
        let end = |a: usize, n: usize| self.planes[a][at[a] + n];
        let own = |x: Vector3<f64>| self.orientation.inverse_transform_vector(&x) / self.factor;
        let middle = own(Vector3::from_fn(|a, _| 0.5 * (end(a, 0) + end(a, 1))));
        (middle, [0, 1, 2].map(|a| own(Vector3::ith(a, 0.5 * (end(a, 1) - end(a, 0))))))
    }
}

/// The part of a box of a lattice that a body fills.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    /// Number of the box along each axis.
    pub at: [usize; 3],
    /// Part of its volume.
    pub part: f64,
    /// The box's middle, from the body's centre (m).
    pub middle: Vector3<f64>,
    /// Its half edges (m; zero along z in 2D).
    pub half: Vector3<f64>,
    /// First moment of that part about the body's centre, along the axes of the lattice, per volume
    /// of the box (m); of round bodies where faces are asked for.
    pub moment: Vector3<f64>,
    /// The lever of the face in its middle (m), where faces are asked for: where a turning body
    /// carries fluid through it, its flux is `(spin x lever).n` per area of the face. For round
    /// bodies it is that of the section in the face's own plane, for others the moment.
    pub lever: Vector3<f64>,
}

impl Tile {
    /// A box between these planes (m), with its part and moment (m).
    pub(crate) fn new(
        planes: &[Vec<f64>; 3],
        at: [usize; 3],
        part: f64,
        moment: Vector3<f64>,
    ) -> Tile {
        let end = |n: usize| Vector3::from_fn(|a, _| planes[a][at[a] + n]);
        let low = end(0);
        let high = end(1);
        Tile {
            at,
            part,
            middle: 0.5 * (low + high),
            half: 0.5 * (high - low),
            moment,
            lever: moment,
        }
    }

    /// One of which nothing is filled.
    pub(crate) fn empty(planes: &[Vec<f64>; 3], at: [usize; 3]) -> Tile {
        Tile::new(planes, at, 0.0, Vector3::zeros())
    }

    /// Goes to the box of this number along an axis.
    #[inline]
    pub(crate) fn set(&mut self, planes: &[Vec<f64>; 3], axis: usize, at: usize) {
        let low = planes[axis][at];
        let high = planes[axis][at + 1];
        self.at[axis] = at;
        self.middle[axis] = 0.5 * (low + high);
        self.half[axis] = 0.5 * (high - low);
    }
}

/// Empties a list of the planes of a body along this many axes. Without room for `count` of them it
/// gets room for twice as many along each: a body that moves lies across one plane more or less,
/// and one across a side of the box has only a part of them.
fn make_room<T>(list: &mut Vec<T>, count: usize, axes: u32) {
    list.clear();
    if count > list.capacity() {
        list.reserve(2usize.pow(axes) * count);
    }
}
