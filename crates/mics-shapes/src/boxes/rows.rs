//! Parts that a closed surface of flat convex faces encloses of the boxes of a lattice: its faces
//! are cut by the planes once, and rows of boxes summed up from their ends.
//!
//! ```text
//!     row of boxes along x     V = sum over pieces of  integral of (x - x_i) n_x dA + h C_(i+1)
//!    +----+----+----+----+     C_(i+1) = C_i - sum over pieces of  integral of n_x dA
//!    |   _|____|__  |    |
//!    |  / |    |  \ |    |     with x_i the low plane of a box of the length h, and C_i how much
//!    +-/--+----+---\+----+     of that plane is covered; moments likewise
//! ```

use super::Tile;
use nalgebra::Vector3;
use std::cell::RefCell;

/// No number.
const NONE: u32 = u32::MAX;

/// Integrals over the pieces of faces in a box, by n_x dA, x from its low plane: 1, y and z; x;
/// x^2/2, x y and x z.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    area: Vector3<f64>,
    volume: f64,
    first: Vector3<f64>,
}

impl Sum {
    /// Adds a piece of a face, corners counterclockwise seen from outside (m).
    fn add(&mut self, polygon: &[Vector3<f64>], low: f64) {
        let Some(a) = polygon.first() else { return };
        for k in 2..polygon.len() {
            let b = &polygon[k - 1];
            let c = &polygon[k];
            let area = 0.5 * ((b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y));
            let sum = a + b + c;
            let x = [a.x - low, b.x - low, c.x - low];
            let along = x[0] + x[1] + x[2];
            self.area += area * Vector3::new(1.0, sum.y / 3.0, sum.z / 3.0);
            self.volume += area / 3.0 * along;
            // The integral of a product of two linear functions over a triangle.
            let squares = 0.5 * (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + along * along);
            let [y, z] = [1, 2].map(|k| x[0] * a[k] + x[1] * b[k] + x[2] * c[k] + along * sum[k]);
            self.first += area / 12.0 * Vector3::new(squares, y, z);
        }
    }
}

/// The pieces of a closed surface in a lattice, in room that is used again.
#[derive(Default)]
pub(crate) struct Rows {
    /// A face, and by axis what is left of it, that of the next plane, and what is cut off.
    face: Vec<Vector3<f64>>,
    pieces: [[Vec<Vector3<f64>>; 3]; 3],
    /// By box, one before the first of each row among them, the number of its sum.
    numbers: Vec<u32>,
    sums: Vec<Sum>,
}

thread_local! {
    static ROWS: RefCell<Rows> = RefCell::default();
}

/// Calls with the boxes between `planes` (m) that a body reaches; `surface` adds its faces.
pub(crate) fn tile(
    planes: &[Vec<f64>; 3],
    found: &mut dyn FnMut(&Tile),
    surface: impl FnOnce(&mut Rows),
) {
    let [nx, ny, nz] = planes.each_ref().map(|planes| planes.len().saturating_sub(1));
    if nx * ny * nz == 0 {
        return;
    }
    ROWS.with_borrow_mut(|rows| {
        rows.numbers.clear();
        rows.numbers.resize((nx + 1) * ny * nz, NONE);
        rows.sums.clear();
        surface(rows);
        rows.each(planes, found);
    });
}

impl Rows {
    /// Adds a flat convex face, corners counterclockwise seen from outside (m).
    pub fn add_face(
        &mut self,
        planes: &[Vec<f64>; 3],
        corners: impl IntoIterator<Item = Vector3<f64>>,
    ) {
        let mut face = std::mem::take(&mut self.face);
        face.clear();
        face.extend(corners);
        self.cut(planes, 0, &face, 0);
        self.face = face;
    }

    /// Cuts a polygon by the planes normal to an axis and those after it; `row` is the number of
    /// the boxes so far.
    fn cut(&mut self, planes: &[Vec<f64>; 3], axis: usize, polygon: &[Vector3<f64>], row: usize) {
        let own = &planes[axis];
        let mut least = f64::INFINITY;
        let mut most = f64::NEG_INFINITY;
        for x in polygon {
            least = least.min(x[axis]);
            most = most.max(x[axis]);
        }
        let mut next = place(own, least);
        if next == own.len() || own.len() < 2 {
            return;
        }
        if most <= own[next] {
            self.keep(planes, axis, polygon, row, next);
            return;
        }
        let [mut rest, mut other, mut piece] = std::mem::take(&mut self.pieces[axis]);
        divide(polygon, axis, own[next], &mut piece, &mut rest);
        self.keep(planes, axis, &piece, row, next);
        next += 1;
        while next < own.len() && most > own[next] {
            divide(&rest, axis, own[next], &mut piece, &mut other);
            std::mem::swap(&mut rest, &mut other);
            self.keep(planes, axis, &piece, row, next);
            next += 1;
        }
        if next < own.len() {
            self.keep(planes, axis, &rest, row, next);
        }
        self.pieces[axis] = [rest, other, piece];
    }

    /// Takes a piece between the plane before that of a number and that one.
    fn keep(
        &mut self,
        planes: &[Vec<f64>; 3],
        axis: usize,
        piece: &[Vector3<f64>],
        row: usize,
        next: usize,
    ) {
        let nx = planes[0].len();
        let ny = planes[1].len() - 1;
        match axis {
            // A piece before the first plane counts as covering it.
            0 => self.cut(planes, 1, piece, next),
            1 if next > 0 => self.cut(planes, 2, piece, row + nx * (next - 1)),
            2 if next > 0 => {
                let number = &mut self.numbers[row + nx * ny * (next - 1)];
                if *number == NONE {
                    *number = self.sums.len() as u32;
                    self.sums.push(Sum::default());
                }
                let low = planes[0][(row % nx).max(1) - 1];
                self.sums[*number as usize].add(piece, low);
            }
            _ => {}
        }
    }

    /// Calls with the boxes that the body reaches.
    pub fn each(&self, planes: &[Vec<f64>; 3], found: &mut dyn FnMut(&Tile)) {
        let [nx, ny, nz] = planes.each_ref().map(|planes| planes.len().saturating_sub(1));
        let ends = |at: usize, axis: usize| [planes[axis][at], planes[axis][at + 1]];
        for (j, k) in (0..nz).flat_map(|k| (0..ny).map(move |j| (j, k))) {
            let across = [ends(j, 1), ends(k, 2)];
            let face: f64 = across.iter().map(|ends| ends[1] - ends[0]).product();
            let mut covered = Vector3::zeros();
            let row = &self.numbers[(nx + 1) * (j + ny * k)..][..nx + 1];
            for (i, number) in row.iter().enumerate() {
                let sum = self.sums.get(*number as usize);
                covered -= sum.map_or_else(Vector3::zeros, |sum| sum.area);
                if i == 0 {
                    continue;
                }
                let at = [i - 1, j, k];
                let [low, high] = ends(i - 1, 0);
                let h = high - low;
                if let Some(sum) = sum {
                    let part = (sum.volume + h * covered.x) / (h * face);
                    let first =
                        sum.first + h * Vector3::new(0.5 * h * covered.x, covered.y, covered.z);
                    let moment = first / (h * face) + part * low * Vector3::x();
                    found(&Tile::new(planes, at, part, moment));
                } else if covered.x > 0.5 * face {
                    let [y, z] = across.map(|ends| 0.5 * (ends[0] + ends[1]));
                    let moment = Vector3::new(0.5 * (low + high), y, z);
                    found(&Tile::new(planes, at, 1.0, moment));
                }
            }
        }
    }
}

/// Number of the planes that lie at a place (m) or below; they are about evenly apart.
#[inline]
pub(crate) fn place(planes: &[f64], at: f64) -> usize {
    let [Some(first), Some(last)] = [planes.first(), planes.last()] else { return 0 };
    let part = (at - first) / (last - first) * (planes.len() - 1) as f64;
    let mut next = (part.clamp(0.0, planes.len() as f64) as usize).min(planes.len());
    while next > 0 && planes[next - 1] > at {
        next -= 1;
    }
    while next < planes.len() && planes[next] <= at {
        next += 1;
    }
    next
}

/// Divides a convex polygon by a plane into what is below and what is above.
fn divide(
    polygon: &[Vector3<f64>],
    axis: usize,
    plane: f64,
    below: &mut Vec<Vector3<f64>>,
    above: &mut Vec<Vector3<f64>>,
) {
    below.clear();
    above.clear();
    let Some(mut from) = polygon.last() else { return };
    let mut low = from[axis] - plane;
    for to in polygon {
        let high = to[axis] - plane;
        if low * high < 0.0 {
            let mut place = from + low / (low - high) * (to - from);
            place[axis] = plane;
            below.push(place);
            above.push(place);
        }
        if high <= 0.0 {
            below.push(*to);
        }
        if high >= 0.0 {
            above.push(*to);
        }
        from = to;
        low = high;
    }
}
