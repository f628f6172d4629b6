//! Parts that an ellipsoid fills of the boxes of a lattice, in closed form: stretched to a ball of
//! radius 1, in a lattice of parallelepipeds that share their faces.
//!
//! ```text
//!       .-----.          V = sum over faces of  integral of h/3 (1 - 1/|x|^3) dA
//!     /    __/_          M = sum over faces of  n integral of (|x|^2 - 1)/2 dA
//!    |    /  |/
//!     \  /__/|           over what lies in the ball: straight pieces from a to b, and arcs, whose
//!       '-----'          angles sum to phi. With c^2 = 1 - h^2 the square of the disc's radius,
//!
//!      area    A     = sum a x b/2 + c^2 phi/2
//!      angle   Omega = 2 sum arg(|a||b| + a.b + |h| (|a| + |b|) + i a x b) + (1 - |h|) phi
//!      V       h A/3 - sign(h) Omega/3
//! ```
//! A sum of angles is that of a product of complex numbers: one arctangent for all straight pieces,
//! and one for all arcs. See [`super::ball`] for the fields.

use super::{Lattice, Tile, ball};
use crate::boxes::convex::Convex;
use nalgebra::{Matrix3, Vector2, Vector3};
use std::cell::RefCell;
use std::f64::consts::TAU;

/// Boxes as near to the centre (of the radius) are found one by one: their faces may have it in
/// their planes.
const NEAR: f64 = 1e-3;

/// Integrals over the part of a face in the ball that count for volume and first moment.
#[derive(Clone, Copy, Debug, Default)]
struct Face {
    volume: f64,
    potential: f64,
}

/// A sum of angles, by a complex number.
#[derive(Clone, Copy)]
struct Angle(Vector2<f64>);

impl Angle {
    const NONE: Angle = Angle(Vector2::new(1.0, 0.0));

    fn add(&mut self, x: f64, y: f64) {
        self.0 = Vector2::new(self.0.x * x - self.0.y * y, self.0.x * y + self.0.y * x);
    }

    fn of(&self) -> f64 {
        self.0.y.atan2(self.0.x)
    }
}

/// Straight pieces of a face within a ball, and the arcs between them.
struct Pieces {
    h: f64,
    square: f64,
    /// Twice their area, twelve times the integral of the squared distance from the disc's centre,
    /// and their length.
    area: f64,
    squares: f64,
    length: f64,
    solid: Angle,
    arcs: Angle,
    has_arcs: bool,
}

impl Pieces {
    fn add_piece(&mut self, a: &Vector2<f64>, b: &Vector2<f64>) {
        let cross = a.perp(b);
        let dot = a.dot(b);
        let [aa, bb] = [a, b].map(|x| x.norm_squared());
        self.area += cross;
        self.squares += cross * (aa + dot + bb);
        self.length += (b - a).norm();
        let h = self.h.abs();
        let hh = self.h * self.h;
        let [p, q] = [aa, bb].map(|square| (square + hh).sqrt());
        self.solid.add(p * q + dot + hh + h * (p + q), cross);
    }

    /// Adds an edge, which may leave the disc and enter it.
    fn add_edge(&mut self, from: &Vector2<f64>, to: &Vector2<f64>, inside: [bool; 2]) {
        if inside == [true; 2] {
            self.add_piece(from, to);
            return;
        }
        let way = to - from;
        let cross = from.perp(to);
        let length = way.norm_squared();
        let root = (length * self.square - cross * cross).max(0.0).sqrt();
        let middle = -from.dot(&way);
        let start = if inside[0] { 0.0 } else { (middle - root) / length };
        let end = if inside[1] { 1.0 } else { (middle + root) / length };
        if end <= start || start >= 1.0 || end <= 0.0 {
            return;
        }
        let [a, b] = [from + start * way, from + end * way];
        let a = if inside[0] { *from } else { a };
        let b = if inside[1] { *to } else { b };
        self.add_piece(&a, &b);
        self.has_arcs = true;
        let unit = 1.0 / self.square.sqrt();
        if !inside[0] {
            self.arcs.add(unit * a.x, unit * a.y);
        }
        if !inside[1] {
            self.arcs.add(unit * b.x, -unit * b.y);
        }
    }

    /// The angle of all arcs together, of a face that has the disc's centre or not.
    fn arc(&self, has_centre: bool, all_inside: bool) -> f64 {
        if all_inside || (!self.has_arcs && !has_centre) {
            return 0.0;
        }
        if !self.has_arcs {
            return TAU;
        }
        let angle = self.arcs.of();
        // Near zero and near a whole turn: by how long the straight pieces are, in and out again.
        let whole = if angle.abs() < 1.0 {
            has_centre && self.length < 1.5 * self.square.sqrt()
        } else {
            angle < 0.0
        };
        if whole { angle + TAU } else { angle }
    }
}

/// Integrals over the part in the ball of a parallelogram in a plane `h` above its centre, of which
/// the corners are given from the disc's centre, counterclockwise.
fn face(h: f64, corners: &[Vector2<f64>; 4]) -> Face {
    let square = 1.0 - h * h;
    if square <= 0.0 {
        return Face::default();
    }
    let inside = corners.map(|x| x.norm_squared() <= square);
    let mut all = Pieces {
        h,
        square,
        area: 0.0,
        squares: 0.0,
        length: 0.0,
        solid: Angle::NONE,
        arcs: Angle::NONE,
        has_arcs: false,
    };
    let mut has_centre = true;
    for k in 0..4 {
        let next = (k + 1) % 4;
        has_centre &= corners[k].perp(&corners[next]) >= 0.0;
        all.add_edge(&corners[k], &corners[next], [inside[k], inside[next]]);
    }
    let arc = all.arc(has_centre, inside == [true; 4]);
    let half = all.solid.of();
    let half = if has_centre && half < -1.0 { half + TAU } else { half };
    let area = 0.5 * (all.area + square * arc);
    let solid = 2.0 * half + (1.0 - h.abs()) * arc;
    let squares = all.squares / 12.0 + 0.25 * square * square * arc;
    Face {
        volume: (h * area - if h < 0.0 { -solid } else { solid }) / 3.0,
        potential: 0.5 * (squares - square * area),
    }
}

/// The planes of the lattice that are normal to one of its axes, as the ball sees them.
struct Family {
    normal: Vector3<f64>,
    /// Height above the centre of the plane a metre along the axis (1/m).
    height: f64,
    /// From the disc's centre in a plane to a place a metre along this axis, the next one and the
    /// last one (1/m).
    in_plane: [Vector2<f64>; 3],
}

impl Family {
    fn new(edges: &[Vector3<f64>; 3], axis: usize) -> Family {
        let [own, next, last] = [0, 1, 2].map(|k| edges[(axis + k) % 3]);
        let normal = next.cross(&last).normalize();
        let u = next.normalize();
        let v = normal.cross(&u);
        let in_plane = [own, next, last].map(|x| Vector2::new(x.dot(&u), x.dot(&v)));
        Family { normal, height: normal.dot(&own), in_plane }
    }

    /// The face in the plane at `own` along the axis (m), between these places along the others.
    fn face(&self, own: f64, next: [f64; 2], last: [f64; 2]) -> Face {
        let [a, b, c] = &self.in_plane;
        let at = |y: usize, z: usize| own * a + next[y] * b + last[z] * c;
        face(own * self.height, &[at(0, 0), at(1, 0), at(1, 1), at(0, 1)])
    }
}

/// A face that has been found, by its number along the axis.
#[derive(Clone, Copy)]
struct Known {
    number: usize,
    face: Face,
}

/// Scratch that is used again.
#[derive(Default)]
struct Scratch {
    body: Convex,
    /// Low faces along y of the next row, and along z of the next layer.
    rows: Vec<Known>,
    layers: Vec<Known>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// An ellipsoid in a lattice.
struct Stretched<'a> {
    planes: &'a [Vec<f64>; 3],
    /// The lattice's axes where the ellipsoid is a ball of radius 1 (1/m).
    edges: [Vector3<f64>; 3],
    families: [Family; 3],
    /// From there to the axes of the lattice (m), and its volume in a cubic metre.
    back: Matrix3<f64>,
    density: f64,
}

impl Stretched<'_> {
    /// The middle and half edges of a box, in the radius.
    fn lie(&self, at: [usize; 3]) -> (Vector3<f64>, [Vector3<f64>; 3]) {
        let ends = [0, 1, 2].map(|a| [self.planes[a][at[a]], self.planes[a][at[a] + 1]]);
        let middle = (0..3).map(|a| 0.5 * (ends[a][0] + ends[a][1]) * self.edges[a]).sum();
        (middle, [0, 1, 2].map(|a| 0.5 * (ends[a][1] - ends[a][0]) * self.edges[a]))
    }

    /// Whether the ball has all of a box (1) or nothing (0) beyond doubt.
    fn whole_or_nothing(middle: &Vector3<f64>, half: &[Vector3<f64>; 3]) -> Option<f64> {
        let square = middle.norm_squared();
        let along: f64 = half.iter().map(|edge| middle.dot(edge).abs()).sum();
        if square - along >= square.sqrt() {
            return Some(0.0);
        }
        let corner: f64 = (0..3)
            .map(|a| half[a].norm_squared() + 2.0 * half[a].dot(&half[(a + 1) % 3]).abs())
            .sum();
        (square + 2.0 * along + corner <= 1.0).then_some(1.0)
    }

    /// The face along an axis of a box, the low one or the high one.
    fn face(&self, axis: usize, at: [usize; 3], high: usize) -> Face {
        let ends = |a: usize| [self.planes[a][at[a]], self.planes[a][at[a] + 1]];
        let [next, last] = [(axis + 1) % 3, (axis + 2) % 3].map(ends);
        self.families[axis].face(ends(axis)[high], next, last)
    }

    /// Volume and first moment that the ball has of a box with these faces.
    fn cut(&self, low: [Face; 3], high: [Face; 3]) -> (f64, Vector3<f64>) {
        let mut volume = 0.0;
        let mut first = Vector3::zeros();
        for a in 0..3 {
            volume += high[a].volume - low[a].volume;
            first += (high[a].potential - low[a].potential) * self.families[a].normal;
        }
        (volume, first)
    }

    /// Whether a box comes near the centre.
    fn is_central(&self, at: [usize; 3]) -> bool {
        (0..3).all(|a| {
            let height = |n: usize| self.planes[a][at[a] + n] * self.families[a].height;
            height(0) < NEAR && height(1) > -NEAR
        })
    }
}

/// Calls with the boxes of a lattice that an ellipsoid of these half axes (m), turned with it,
/// reaches.
pub(crate) fn tile(half: &Vector3<f64>, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
    let Lattice { orientation: turn, planes, .. } = *lattice;
    let scales = Matrix3::from_diagonal(half);
    let back = turn.matrix() * scales;
    let to_ball = Matrix3::from_diagonal(&half.map(|a| 1.0 / a)) * turn.matrix().transpose();
    let edges = [0, 1, 2].map(|a| to_ball.column(a).into_owned());
    let families = [0, 1, 2].map(|a| Family::new(&edges, a));
    let body = Stretched { planes, edges, families, back, density: 1.0 / half.product() };
    SCRATCH.with_borrow_mut(|room| body.each(room, found));
}

impl Stretched<'_> {
    fn each(&self, room: &mut Scratch, found: &mut dyn FnMut(&Tile)) {
        let [nx, ny, nz] = self.planes.each_ref().map(|planes| planes.len().saturating_sub(1));
        let none = Known { number: usize::MAX, face: Face::default() };
        for (known, n) in [(&mut room.rows, nx), (&mut room.layers, nx * ny)] {
            known.clear();
            known.resize(n, none);
        }
        for k in 0..nz {
            for j in 0..ny {
                let mut last = none;
                for i in 0..nx {
                    let at = [i, j, k];
                    let (middle, half) = self.lie(at);
                    match Stretched::whole_or_nothing(&middle, &half) {
                        Some(0.0) => {}
                        Some(_) => found(&Tile::new(self.planes, at, 1.0, self.back * middle)),
                        None => found(&self.find(at, &middle, &half, room, &mut last)),
                    }
                }
            }
        }
    }

    /// Finds the part of a box that the ellipsoid fills.
    fn find(
        &self,
        at: [usize; 3],
        middle: &Vector3<f64>,
        half: &[Vector3<f64>; 3],
        room: &mut Scratch,
        last: &mut Known,
    ) -> Tile {
        let [i, j, k] = at;
        let volume = (0..3).fold(self.density, |volume, a| {
            volume * (self.planes[a][at[a] + 1] - self.planes[a][at[a]])
        });
        let (filled, first) = if self.is_central(at) {
            room.body.set_box(middle, half);
            ball::moments(&room.body, &Vector3::zeros(), 1.0)
        } else {
            let [nx, ny] = [0, 1].map(|a| self.planes[a].len() - 1);
            let numbers = [i, j + (ny + 1) * k, k];
            let known = [last, &mut room.rows[i], &mut room.layers[i + nx * j]];
            let high = [0, 1, 2].map(|axis| self.face(axis, at, 1));
            let mut low = [Face::default(); 3];
            for (axis, known) in known.into_iter().enumerate() {
                let number = numbers[axis];
                let is_known = known.number == number;
                low[axis] = if is_known { known.face } else { self.face(axis, at, 0) };
                *known = Known { number: number + 1, face: high[axis] };
            }
            self.cut(low, high)
        };
        Tile::new(self.planes, at, filled / volume, self.back * (first / volume))
    }
}
