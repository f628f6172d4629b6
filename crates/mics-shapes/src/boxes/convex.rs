//! A convex polyhedron that is cut by planes, one after the other, in room that is used again.
//!
//! ```text
//!      +------+             a plane keeps the corners on its inner side; each edge that it crosses
//!      |      |             gives one new corner, which both faces of that edge share, and the new
//!      |    ./|  n  ->      corners are those of the new face, linked in their order by the faces
//!      +---/--+             that were cut. No comparison of places is needed.
//! ```

use nalgebra::{Matrix3, Vector3};

/// No number.
const NONE: u32 = u32::MAX;

/// A face: its plane's outward normal and offset, and which of the numbers are its corners'.
#[derive(Clone, Copy, Debug)]
struct Side {
    normal: Vector3<f64>,
    offset: f64,
    first: u32,
    count: u32,
}

/// A convex polyhedron.
#[derive(Clone, Debug, Default)]
pub struct Convex {
    corners: Vec<Vector3<f64>>,
    /// Numbers of corners, face by face, counterclockwise seen from outside.
    loops: Vec<u32>,
    sides: Vec<Side>,
    /// Scratch for a cut: the next faces and numbers, the corners' distances and new numbers, the
    /// edges that are cut with their new corners, and which new corner follows which.
    next: (Vec<u32>, Vec<Side>),
    distances: Vec<f64>,
    renumbered: Vec<u32>,
    crossings: Vec<(u32, u32, u32)>,
    links: Vec<(u32, u32)>,
}

impl Convex {
    /// An empty one, with room for so many corners.
    pub fn with_capacity(corners: usize) -> Convex {
        Convex {
            corners: Vec::with_capacity(corners),
            loops: Vec::with_capacity(4 * corners),
            sides: Vec::with_capacity(corners),
            next: (Vec::with_capacity(4 * corners), Vec::with_capacity(corners)),
            distances: Vec::with_capacity(corners),
            renumbered: Vec::with_capacity(corners),
            crossings: Vec::with_capacity(corners),
            links: Vec::with_capacity(corners),
        }
    }

    /// Becomes the parallelepiped about `middle` (m) with these half edges (m), which are
    /// right-handed.
    pub fn set_box(&mut self, middle: &Vector3<f64>, half: &[Vector3<f64>; 3]) {
        self.corners.clear();
        self.corners.extend((0..8).map(|k: usize| {
            let sign = |a: usize| if k >> a & 1 == 1 { 1.0 } else { -1.0 };
            middle + sign(0) * half[0] + sign(1) * half[1] + sign(2) * half[2]
        }));
        self.loops.clear();
        self.sides.clear();
        for axis in 0..3 {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            let normal = half[u].cross(&half[v]).normalize();
            let at = normal.dot(middle);
            let out = normal.dot(&half[axis]);
            let number = |high: u32, i: u32, j: u32| (high << axis) | (i << u) | (j << v);
            for (high, sign) in [(0, -1.0), (1, 1.0)] {
                let [a, b, c, d] =
                    [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| number(high, i, j));
                let first = self.loops.len() as u32;
                self.loops.extend(if high == 1 { [a, b, c, d] } else { [d, c, b, a] });
                let offset = sign * at + out;
                self.sides.push(Side { normal: sign * normal, offset, first, count: 4 });
            }
        }
    }

    /// Its corners (m).
    pub fn corners(&self) -> &[Vector3<f64>] {
        &self.corners
    }

    /// Its faces: the outward normal, the offset of the plane (m), and the corners' numbers.
    pub fn faces(&self) -> impl Iterator<Item = (Vector3<f64>, f64, &[u32])> {
        self.sides.iter().map(|side| {
            let round = side.first as usize..(side.first + side.count) as usize;
            (side.normal, side.offset, &self.loops[round])
        })
    }

    /// Whether nothing is left.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Keeps what lies below a plane, `n.x <= offset`.
    pub fn cut(&mut self, n: &Vector3<f64>, offset: f64) {
        self.distances.clear();
        self.distances.extend(self.corners.iter().map(|corner| n.dot(corner) - offset));
        if self.distances.iter().all(|d| *d <= 0.0) {
            return;
        }
        self.crossings.clear();
        self.links.clear();
        if !self.distances.iter().any(|d| *d <= 0.0) {
            self.corners.clear();
            self.loops.clear();
            self.sides.clear();
            return;
        }
        self.keep();
        self.cut_faces();
        self.close(n, offset);
        std::mem::swap(&mut self.loops, &mut self.next.0);
        std::mem::swap(&mut self.sides, &mut self.next.1);
    }

    /// Finds the new corners, and drops those that go.
    fn keep(&mut self) {
        let Convex { corners, loops, sides, distances, renumbered, crossings, .. } = self;
        renumbered.clear();
        let mut kept = 0;
        renumbered.extend(distances.iter().map(|d| {
            let number = if *d <= 0.0 { kept } else { NONE };
            kept += u32::from(*d <= 0.0);
            number
        }));
        // An edge is walked along in both directions: once with its end outside.
        for side in sides.iter() {
            let round = &loops[side.first as usize..(side.first + side.count) as usize];
            let mut from = round[round.len() - 1];
            for to in round.iter().copied() {
                let ends = [from as usize, to as usize];
                if renumbered[ends[0]] != NONE && renumbered[ends[1]] == NONE {
                    let [inside, outside] = ends.map(|k| distances[k]);
                    let t = inside / (inside - outside);
                    let place = corners[ends[0]] + t * (corners[ends[1]] - corners[ends[0]]);
                    crossings.push((from, to, corners.len() as u32));
                    corners.push(place);
                }
                from = to;
            }
        }
        let old = distances.len();
        for k in 0..old {
            if renumbered[k] != NONE {
                corners[renumbered[k] as usize] = corners[k];
            }
        }
        let found = corners.len() - old;
        for k in 0..found {
            corners[kept as usize + k] = corners[old + k];
        }
        corners.truncate(kept as usize + found);
        for (k, crossing) in crossings.iter_mut().enumerate() {
            crossing.2 = kept + k as u32;
        }
    }

    /// Walks round each face, and notes which new corner follows which on the new one.
    fn cut_faces(&mut self) {
        let Convex {
            loops, sides, next: (new_loops, new_sides), renumbered, crossings, links, ..
        } = self;
        new_loops.clear();
        new_sides.clear();
        let crossing = |inside: u32, outside: u32| {
            let found = crossings.iter().find(|(a, b, _)| (*a, *b) == (inside, outside));
            found.map_or(NONE, |(_, _, number)| *number)
        };
        for side in sides.iter() {
            let round = &loops[side.first as usize..(side.first + side.count) as usize];
            let first = new_loops.len() as u32;
            // Rounding may cut a face more than once.
            let mut left = NONE;
            let mut entered = NONE;
            let mut from = round[round.len() - 1];
            for to in round.iter().copied() {
                match (renumbered[from as usize], renumbered[to as usize]) {
                    (NONE, NONE) => {}
                    (NONE, kept) => {
                        let enters = crossing(to, from);
                        new_loops.extend([enters, kept]);
                        if left == NONE {
                            entered = enters;
                        } else {
                            links.push((enters, left));
                            left = NONE;
                        }
                    }
                    (_, NONE) => {
                        left = crossing(from, to);
                        new_loops.push(left);
                    }
                    (_, kept) => new_loops.push(kept),
                }
                from = to;
            }
            if left != NONE && entered != NONE {
                links.push((entered, left));
            }
            let count = new_loops.len() as u32 - first;
            if count > 0 {
                new_sides.push(Side { first, count, ..*side });
            }
        }
    }

    /// Adds the face in the plane of the cut.
    fn close(&mut self, normal: &Vector3<f64>, offset: f64) {
        let Convex { next: (new_loops, new_sides), links, .. } = self;
        while let Some((start, mut at)) = links.pop() {
            let first = new_loops.len();
            new_loops.push(start);
            while at != start {
                new_loops.push(at);
                let Some(k) = links.iter().position(|link| link.0 == at) else { break };
                at = links.swap_remove(k).1;
            }
            let count = new_loops.len() - first;
            if count < 3 {
                // The two faces beside it have that edge in common.
                new_loops.truncate(first);
                continue;
            }
            let first = first as u32;
            let count = count as u32;
            new_sides.push(Side { normal: *normal, offset, first, count });
        }
    }

    /// Calls with the corners of tetrahedra that make it up (m).
    fn tetrahedra(&self, mut found: impl FnMut([&Vector3<f64>; 4])) {
        let Some(top) = self.corners.first() else { return };
        for side in &self.sides {
            let round = &self.loops[side.first as usize..(side.first + side.count) as usize];
            let at = |k: usize| &self.corners[round[k] as usize];
            for k in 2..round.len() {
                found([top, at(0), at(k - 1), at(k)]);
            }
        }
    }

    /// Volume (m3) and the integral of the place over it (m4).
    pub fn moments(&self) -> (f64, Vector3<f64>) {
        let mut volume = 0.0;
        let mut first = Vector3::zeros();
        self.tetrahedra(|[o, a, b, c]| {
            let part = (a - o).dot(&(b - o).cross(&(c - o))) / 6.0;
            volume += part;
            first += 0.25 * part * (o + a + b + c);
        });
        (volume, first)
    }

    /// The integral of `x x^T` over it (m5).
    pub fn second_moments(&self) -> Matrix3<f64> {
        let mut second = Matrix3::zeros();
        self.tetrahedra(|[o, a, b, c]| {
            let part = (a - o).dot(&(b - o).cross(&(c - o))) / 6.0;
            let sum = o + a + b + c;
            let squares = [o, a, b, c].map(|x| x * x.transpose()).iter().sum::<Matrix3<f64>>();
            second += part / 20.0 * (squares + sum * sum.transpose());
        });
        second
    }

    /// Scales all of it about the origin.
    pub fn scale(&mut self, factor: f64) {
        self.corners.iter_mut().for_each(|corner| *corner *= factor);
        self.sides.iter_mut().for_each(|side| side.offset *= factor);
    }

    /// Shifts all of it (m).
    pub fn shift(&mut self, way: &Vector3<f64>) {
        self.corners.iter_mut().for_each(|corner| *corner += way);
        self.sides.iter_mut().for_each(|side| side.offset += side.normal.dot(way));
    }
}

/// Moments of inertia, `integral of x.x - x x^T`, of second moments.
pub fn inertia(second: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_diagonal_element(second.trace()) - second
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cuts_of_a_cube_leave_known_volumes() {
        let mut body = Convex::default();
        let edges = [Vector3::x(), Vector3::y(), Vector3::z()].map(|e| 0.5 * e);
        body.set_box(&Vector3::zeros(), &edges);
        assert!((body.moments().0 - 1.0).abs() < 1e-15);
        let second = body.second_moments();
        assert!((second - Matrix3::identity() / 12.0).norm() < 1e-15);
        // A corner off, a tetrahedron of the legs 0.5.
        let n = Vector3::repeat(1.0).normalize();
        body.cut(&n, 1.0 / 3.0f64.sqrt());
        let (volume, first) = body.moments();
        assert!((volume - (1.0 - 0.125 / 6.0)).abs() < 1e-15, "{volume}");
        let centroid = 0.5 - 0.125;
        assert!((first + Vector3::repeat(0.125 / 6.0 * centroid)).norm() < 1e-15, "{first}");
        // A plane through corners, and one beyond all.
        body.cut(&Vector3::new(1.0, -1.0, 0.0).normalize(), 0.0);
        body.cut(&Vector3::x(), 2.0);
        assert!((body.moments().0 - 0.5 * volume).abs() < 1e-15);
        body.cut(&Vector3::x(), -0.6);
        assert!(body.is_empty() && body.moments().0 == 0.0);
    }
}
