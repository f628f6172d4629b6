//! The part of a sphere of radius R about the origin in the boxes of a lattice, in closed form: a
//! box is a sum over its corners.
//!
//! ```text
//!   H(a, b, c) = volume between the planes of the origin and x = a, y = b, z = c, odd in each of
//!                them; box = sum over its corners of +-H
//!
//!   the corner inside the sphere:   H = a b c
//!   outside:   H = c' E(a, b) + a' E(b, c) + b' E(c, a),   a' the sign of a
//!      E(a, b) = a b s/3 + w_a u_ab + w_b u_ba - R^3/3 (atan(a b/(R s)) - a' b' pi/6)
//!      s^2 = R^2 - a^2 - b^2,   w_a = a (3 R^2 - a^2)/6,   u_ab = atan(b/s) - b' pi/4
//!              the column over a b, less what is beyond single planes: half of that for each of
//!              the two columns that a plane is part of
//!
//!   moment      int x dV = -1/2 [int (rho^2 - y^2 - z^2) dA] from x = a_0 to a_1,
//!              rho^2 = R^2 - a^2, since -(R^2 - r^2)/2 e_x has the divergence x
//!      inside:   b c (rho^2 - (b^2 + c^2)/3)
//!      outside:  c' F(a, b) + b' F(a, c),   F(a, b) = b s (s^2/6 + rho^2/4) + rho^4/4 u_ab
//! ```
//! All angles belong to two planes, so that a lattice of boxes has as many as it has edges. Planes
//! beyond the sphere count as touching it.

use super::angle::{angle, sign};
use super::circle::VECTOR;
use super::make_room;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_4, FRAC_PI_6};
use std::ops::Range;

/// Planes normal to an axis, by number, the last one once more up to a whole number of vectors.
#[derive(Clone, Debug, Default)]
struct Planes {
    /// Where, within the sphere (m).
    at: Vec<f64>,
    /// The sign of that.
    sign: Vec<f64>,
    /// Square of the radius of the circle in it (m2).
    square: Vec<f64>,
}

/// Pairs of planes normal to two axes, the first one fastest.
#[derive(Clone, Debug, Default)]
struct Pairs {
    /// The volume E (m3).
    volume: Vec<f64>,
    /// The integral F in the first plane's circle, and in the second one's (m4).
    first: Vec<f64>,
    second: Vec<f64>,
}

/// The corners of a lattice of boxes, and the sums over the four edges of a row of them along x.
#[derive(Clone, Debug, Default)]
pub struct Corners {
    planes: [Planes; 3],
    /// Pairs of x and y, x and z, y and z.
    pairs: [Pairs; 3],
    /// Sums of volumes (m3) and of moments (m4, times -2) over the edges, at each plane in x.
    volume: Vec<f64>,
    moment: [Vec<f64>; 3],
}

impl Planes {
    #[inline(always)]
    fn one(&self, k: usize) -> Place {
        Place { at: self.at[k], sign: self.sign[k], square: self.square[k] }
    }

    #[inline(always)]
    fn set(&mut self, places: &[f64], radius: f64) {
        let n = places.len().max(1).next_multiple_of(VECTOR);
        for values in [&mut self.at, &mut self.sign, &mut self.square] {
            make_room(values, n, 1);
        }
        self.at.extend(places.iter().map(|at| at.clamp(-radius, radius)));
        let last = self.at.last().copied().unwrap_or(0.0);
        self.at.resize(n, last);
        self.sign.extend(self.at.iter().map(|at| sign(*at)));
        self.square.extend(self.at.iter().map(|at| (radius - at) * (radius + at)));
    }
}

impl Pairs {
    #[inline(always)]
    fn set(&mut self, p: &Planes, q: &Planes, radius: f64) {
        let n = p.at.len();
        let [volume, first, second] = [&mut self.volume, &mut self.first, &mut self.second];
        for values in [&mut *volume, first, second] {
            make_room(values, n * q.at.len(), 2);
            values.resize(n * q.at.len(), 0.0);
        }
        let rows = volume.chunks_exact_mut(n).zip(first.chunks_exact_mut(n));
        for (j, ((volume, first), second)) in rows.zip(second.chunks_exact_mut(n)).enumerate() {
            let b = q.at[j];
            let b_sign = q.sign[j];
            let b_square = q.square[j];
            let p_at = &p.at[..n];
            let p_sign = &p.sign[..n];
            let p_square = &p.square[..n];
            let third = radius * radius * radius / 3.0;
            let weight = |at: f64, square: f64| at * (2.0 * radius * radius + square) / 6.0;
            let own = weight(b, b_square);
            for i in 0..n {
                let a = p_at[i];
                let a_sign = p_sign[i];
                let a_square = p_square[i];
                let square = a_square - b * b;
                let square = if square > 0.0 { square } else { 0.0 };
                let root = square.sqrt();
                let u = angle(b, root) - FRAC_PI_4 * b_sign;
                let v = angle(a, root) - FRAC_PI_4 * a_sign;
                let w = angle(a * b, radius * root) - FRAC_PI_6 * (a_sign * b_sign);
                volume[i] = a * b * root / 3.0 + (weight(a, a_square) * u + own * v) - third * w;
                first[i] =
                    b * root * (square / 6.0 + 0.25 * a_square) + 0.25 * (a_square * a_square) * u;
                second[i] =
                    a * root * (square / 6.0 + 0.25 * b_square) + 0.25 * (b_square * b_square) * v;
            }
        }
    }
}

impl Corners {
    /// Sets the planes of a lattice (m) and the radius of the sphere (m).
    #[inline(always)]
    pub fn set(&mut self, planes: &[Vec<f64>; 3], radius: f64) {
        for (own, places) in self.planes.iter_mut().zip(planes) {
            own.set(places, radius);
        }
        let [x, y, z] = &self.planes;
        let [xy, xz, yz] = &mut self.pairs;
        xy.set(x, y, radius);
        xz.set(x, z, radius);
        yz.set(y, z, radius);
        let [a, b, c] = &mut self.moment;
        for values in [&mut self.volume, a, b, c] {
            make_room(values, x.at.len(), 1);
            values.resize(x.at.len(), 0.0);
        }
    }

    /// Number of planes in x, with those that fill the last vector.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.volume.len()
    }

    /// Finds the sums over the edges of a row of boxes, of the number `at` in y and z, at a range
    /// of planes in x, a whole number of vectors; those of moments where they are asked for.
    #[inline(always)]
    pub fn find(&mut self, at: [usize; 2], range: Range<usize>, moments: bool) {
        let Corners { planes: [x, y, z], pairs: [xy, xz, yz], volume, moment, .. } = self;
        let n = x.at.len();
        let row = Row {
            at: &x.at[range.clone()],
            sign: &x.sign[range.clone()],
            square: &x.square[range.clone()],
            edges: [
                Edge::new([y, z], yz, [at[0] + 1, at[1] + 1]),
                Edge::new([y, z], yz, [at[0], at[1] + 1]),
                Edge::new([y, z], yz, [at[0] + 1, at[1]]),
                Edge::new([y, z], yz, at),
            ],
        };
        let [j, k] = at.map(|at| [at + 1, at].map(|at| at * n + range.start));
        row.sum(
            &mut volume[range.clone()],
            j.map(|j| &xy.volume[j..]),
            k.map(|k| &xz.volume[k..]),
            #[inline(always)]
            |edge, x, xy, xz| edge.volume(x, xy, xz),
        );
        if !moments {
            return;
        }
        let [mx, my, mz] = moment.each_mut().map(|values| &mut values[range.clone()]);
        row.sum(
            mx,
            j.map(|j| &xy.first[j..]),
            k.map(|k| &xz.first[k..]),
            #[inline(always)]
            |edge, x, xy, xz| edge.moment_x(x, xy, xz),
        );
        row.sum(
            my,
            j.map(|j| &xy.second[j..]),
            k.map(|k| &xz.second[k..]),
            #[inline(always)]
            |edge, x, xy, _| edge.moment_y(x, xy),
        );
        row.sum(
            mz,
            j.map(|j| &xy.second[j..]),
            k.map(|k| &xz.second[k..]),
            #[inline(always)]
            |edge, x, _, xz| edge.moment_z(x, xz),
        );
    }

    /// Volume (m3) and first moments (m4) of the part of the sphere in a box of that row, which
    /// lies between two planes of that range.
    #[inline(always)]
    pub fn part(&self, i: usize) -> (f64, Vector3<f64>) {
        let between = |values: &[f64]| values[i + 1] - values[i];
        let moment = Vector3::from_fn(|a, _| -0.5 * between(&self.moment[a]));
        (between(&self.volume), moment)
    }
}

/// A plane of [`Planes`].
#[derive(Clone, Copy)]
struct Place {
    at: f64,
    sign: f64,
    square: f64,
}

/// An edge of a row of boxes along x, by its planes in y and z and what they have in common.
#[derive(Clone, Copy)]
struct Edge {
    planes: [Place; 2],
    volume: f64,
    moments: [f64; 2],
}

impl Edge {
    /// The edge of these planes by number, with their pairs.
    #[inline(always)]
    fn new(planes: [&Planes; 2], pairs: &Pairs, at: [usize; 2]) -> Edge {
        let [y, z] = planes;
        let [j, k] = at;
        let pair = j + y.at.len() * k;
        Edge {
            planes: [y.one(j), z.one(k)],
            volume: pairs.volume[pair],
            moments: [pairs.first[pair], pairs.second[pair]],
        }
    }

    /// Whether its corner at a plane in x lies in the sphere.
    #[inline(always)]
    fn is_inside(&self, x: &Place) -> bool {
        let [y, z] = &self.planes;
        x.at * x.at < y.square - z.at * z.at
    }

    /// The volume of the corner at a plane in x, by those of its pairs with the planes in y and z.
    #[inline(always)]
    fn volume(&self, x: &Place, xy: f64, xz: f64) -> f64 {
        let [y, z] = &self.planes;
        let outside = z.sign * xy + y.sign * xz + x.sign * self.volume;
        if self.is_inside(x) { x.at * (y.at * z.at) } else { outside }
    }

    /// Its moment along x likewise.
    #[inline(always)]
    fn moment_x(&self, x: &Place, xy: f64, xz: f64) -> f64 {
        let [y, z] = &self.planes;
        let inside = y.at * z.at * (x.square - (y.at * y.at + z.at * z.at) / 3.0);
        if self.is_inside(x) { inside } else { z.sign * xy + y.sign * xz }
    }

    #[inline(always)]
    fn moment_y(&self, x: &Place, xy: f64) -> f64 {
        let [y, z] = &self.planes;
        let inside = x.at * z.at * (y.square - (x.at * x.at + z.at * z.at) / 3.0);
        if self.is_inside(x) { inside } else { z.sign * xy + x.sign * self.moments[0] }
    }

    #[inline(always)]
    fn moment_z(&self, x: &Place, xz: f64) -> f64 {
        let [y, z] = &self.planes;
        let inside = x.at * y.at * (z.square - (x.at * x.at + y.at * y.at) / 3.0);
        if self.is_inside(x) { inside } else { y.sign * xz + x.sign * self.moments[1] }
    }
}

/// Planes in x, and the edges of a row of boxes: first the one that is further along y and z, the
/// one before it along y, along z, and along both.
struct Row<'a> {
    at: &'a [f64],
    sign: &'a [f64],
    square: &'a [f64],
    edges: [Edge; 4],
}

impl Row<'_> {
    /// Sets the sums over the edges of what `value` gives to their corners, by what belongs to
    /// pairs with the further and the nearer plane in y, and in z.
    #[inline(always)]
    fn sum(
        &self,
        out: &mut [f64],
        xy: [&[f64]; 2],
        xz: [&[f64]; 2],
        value: impl Fn(&Edge, &Place, f64, f64) -> f64,
    ) {
        let [far, low, below, near] = &self.edges;
        for (k, out) in out.chunks_exact_mut(VECTOR).enumerate() {
            let lanes = |values: &[f64]| -> [f64; VECTOR] {
                let values = &values[k * VECTOR..][..VECTOR];
                std::array::from_fn(|lane| values[lane])
            };
            let [at, sign, square] = [lanes(self.at), lanes(self.sign), lanes(self.square)];
            let [y, low_y] = [lanes(xy[0]), lanes(xy[1])];
            let [z, low_z] = [lanes(xz[0]), lanes(xz[1])];
            let mut sum = [0.0; VECTOR];
            for i in 0..VECTOR {
                let x = Place { at: at[i], sign: sign[i], square: square[i] };
                // In a mirror the sum is the same to the last bit.
                sum[i] = (value(far, &x, y[i], z[i]) - value(low, &x, low_y[i], z[i]))
                    - (value(below, &x, y[i], low_z[i]) - value(near, &x, low_y[i], low_z[i]));
            }
            out.copy_from_slice(&sum);
        }
    }
}
