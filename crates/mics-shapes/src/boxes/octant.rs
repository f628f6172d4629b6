//! The part of a sphere of radius R about the origin beyond three planes, in closed form; a box is
//! eight such corners.
//!
//! ```text
//!   G(a, b, c) = volume where x > a, y > b, z > c         box = sum over its corners of +-G
//!
//!   the corner inside the sphere:   3 G = R A - a A_a - b A_b - c A_c        cones from the origin
//!      A / R^2 = 2 pi - sum of the outer angles - sum (a/R) arc_a
//!              by Gauss and Bonnet, with A the patch of the sphere
//!      A_a = rho^2 arc_a/2 + b c - (b s_ab + c s_ca)/2,   rho^2 = R^2 - a^2,
//!              s_ab^2 = rho^2 - b^2
//!      arc_a = pi/2 - asin(b/rho) - asin(c/rho),   cos(outer angle of a, b) = -a b/(rho_a rho_b)
//!   outside:  what is left is empty, or what two planes, one or none cut off, by the signs of a,
//!                 b, c
//!
//!   moment      int x dV = 1/2 int_(x = a) (rho^2 - y^2 - z^2) dA
//!              since -(R^2 - r^2)/2 e_x has the divergence x, and is zero on the sphere
//! ```
//! All angles belong to two planes, so that a lattice of boxes has as many as it has edges.

use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI};

/// A plane normal to an axis.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Where (m).
    at: f64,
    /// Square of the radius of the circle in it (m2).
    square: f64,
    /// Volume beyond it (m3).
    cap: f64,
}

/// Two planes normal to two axes.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Half the chord along their edge (m); 0 outside.
    root: f64,
    /// Angle of the second one's line in the first one's circle, and the other way round.
    first: f64,
    second: f64,
    /// Outer angle between their circles.
    outer: f64,
    /// Volume beyond both (m3).
    beyond: f64,
}

/// The part of the sphere beyond a corner.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Volume (m3).
    pub volume: f64,
    /// Integrals of the coordinates over it (m4).
    pub moment: Vector3<f64>,
}

/// A line in a plane's circle: where (m), its angle, half its chord (m).
#[derive(Clone, Copy)]
struct Line {
    at: f64,
    angle: f64,
    root: f64,
}

impl Plane {
    /// At a place (m), of a sphere of the given radius (m).
    pub fn new(at: f64, radius: f64) -> Plane {
        let within = at.clamp(-radius, radius);
        let cap = PI / 3.0 * (radius - within).powi(2) * (2.0 * radius + within);
        Plane { at, square: (radius * radius - at * at).max(0.0), cap }
    }

    /// Integral over its circle beyond one line, of `rho^2 - r^2` (m4).
    fn half(&self, line: &Line) -> f64 {
        let Line { at, angle, root } = *line;
        let along = (0.5 * self.square - 0.25 * at * at) * 2.0 * root - root.powi(3) / 6.0;
        0.5 * self.square * self.square * (FRAC_PI_2 - angle) - at * along
    }

    /// Integral over its circle beyond two lines, of `rho^2 - r^2` (m4), the corner inside.
    fn quarter(&self, y: &Line, z: &Line) -> f64 {
        let along = |line: &Line, other: &Line| {
            let part = (0.5 * self.square - 0.25 * line.at * line.at) * (line.root - other.at);
            line.at * (part - (line.root.powi(3) - other.at.powi(3)) / 12.0)
        };
        0.25 * self.square * self.square * (FRAC_PI_2 - y.angle - z.angle)
            - along(y, z)
            - along(z, y)
    }

    /// Integral over its circle beyond two lines, of `rho^2 - r^2` (m4), the corner outside.
    fn rest(&self, y: &Line, z: &Line) -> f64 {
        match (y.at < 0.0, z.at < 0.0) {
            (false, false) => 0.0,
            (true, false) => self.half(z),
            (false, true) => self.half(y),
            (true, true) => self.half(y) + self.half(z) - 0.5 * PI * self.square * self.square,
        }
    }
}

impl Pair {
    /// Two planes that are normal to two axes, in a sphere of the given radius (m).
    pub fn new(p: &Plane, q: &Plane, radius: f64) -> Pair {
        let square = radius * radius - p.at * p.at - q.at * q.at;
        let whole = 4.0 / 3.0 * PI * radius.powi(3);
        if square <= 0.0 {
            let side = |at: f64| FRAC_PI_2.copysign(at);
            let angle = |plane: &Plane, at: f64| {
                if at * at < plane.square { (at / plane.square.sqrt()).asin() } else { side(at) }
            };
            let beyond = match (p.at < 0.0, q.at < 0.0) {
                (false, false) => 0.0,
                (true, false) => q.cap,
                (false, true) => p.cap,
                (true, true) => p.cap + q.cap - whole,
            };
            return Pair {
                root: 0.0,
                first: angle(p, q.at),
                second: angle(q, p.at),
                outer: 0.0,
                beyond,
            };
        }
        let root = square.sqrt();
        let circles = [p.square.sqrt(), q.square.sqrt()];
        let first = (q.at / circles[0]).asin();
        let second = (p.at / circles[1]).asin();
        let outer = (-p.at * q.at / (circles[0] * circles[1])).acos();
        // The lens between them: two arcs, two corners.
        let segment =
            |plane: &Plane, angle: f64, at: f64| plane.square * (FRAC_PI_2 - angle) - at * root;
        let arcs = p.at * (PI - 2.0 * first) + q.at * (PI - 2.0 * second);
        let patch = radius * radius * (2.0 * PI - 2.0 * outer) - radius * arcs;
        let flat = p.at * segment(p, first, q.at) + q.at * segment(q, second, p.at);
        Pair { root, first, second, outer, beyond: (radius * patch - flat) / 3.0 }
    }
}

impl Corner {
    /// None.
    pub const EMPTY: Corner = Corner { volume: 0.0, moment: Vector3::new(0.0, 0.0, 0.0) };

    /// Adds a multiple of another one.
    #[inline]
    pub fn add(&mut self, factor: f64, other: &Corner) {
        self.volume += factor * other.volume;
        self.moment += factor * other.moment;
    }

    /// The corner of planes normal to x, y, z and of their pairs xy, yz, zx; the integrals where
    /// they are asked for.
    pub fn new(planes: [&Plane; 3], pairs: [&Pair; 3], radius: f64, integrals: bool) -> Corner {
        let line = |k: usize, angle: f64, root: f64| Line { at: planes[k].at, angle, root };
        // The lines of the next two planes in the circle of each plane.
        let lines: [[Line; 2]; 3] = std::array::from_fn(|k| {
            let next = pairs[k];
            let last = pairs[(k + 2) % 3];
            [line((k + 1) % 3, next.first, next.root), line((k + 2) % 3, last.second, last.root)]
        });
        let distance: f64 = planes.iter().map(|plane| plane.at * plane.at).sum();
        let outer = distance >= radius * radius;
        let moment = |k: usize| {
            let [y, z] = &lines[k];
            0.5 * if outer { planes[k].rest(y, z) } else { planes[k].quarter(y, z) }
        };
        let moment = Vector3::from_fn(|k, _| if integrals { moment(k) } else { 0.0 });
        if outer {
            return Corner { volume: outside(planes, pairs, radius), moment };
        }
        let mut patch = 2.0 * PI - pairs.iter().map(|pair| pair.outer).sum::<f64>();
        let mut flat = 0.0;
        for (plane, [y, z]) in planes.iter().zip(&lines) {
            let arc = FRAC_PI_2 - y.angle - z.angle;
            patch -= plane.at / radius * arc;
            flat += plane.at
                * (0.5 * plane.square * arc + y.at * z.at - 0.5 * (y.at * y.root + z.at * z.root));
        }
        Corner { volume: (radius.powi(3) * patch - flat) / 3.0, moment }
    }
}

/// The volume beyond a corner outside the sphere: beyond the opposite corner there is nothing.
fn outside(planes: [&Plane; 3], pairs: [&Pair; 3], radius: f64) -> f64 {
    let below = planes.map(|plane| plane.at < 0.0);
    match below.iter().filter(|below| **below).count() {
        0 => 0.0,
        1 => {
            let k = if below[0] {
                0
            } else if below[1] {
                1
            } else {
                2
            };
            pairs[(k + 1) % 3].beyond
        }
        2 => {
            let k = if !below[0] {
                0
            } else if !below[1] {
                1
            } else {
                2
            };
            pairs[k].beyond + pairs[(k + 2) % 3].beyond - planes[k].cap
        }
        _ => {
            let caps: f64 = planes.iter().map(|plane| plane.cap).sum();
            4.0 / 3.0 * PI * radius.powi(3) - caps
                + pairs.iter().map(|pair| pair.beyond).sum::<f64>()
        }
    }
}

/// The part of a sphere of the given radius (m) in a box from `low` to `high` (m).
#[cfg(test)]
pub fn of_box(low: &Vector3<f64>, high: &Vector3<f64>, radius: f64) -> Corner {
    let planes: [[Plane; 2]; 3] =
        std::array::from_fn(|a| [low[a], high[a]].map(|at| Plane::new(at, radius)));
    let pair =
        |a: usize, i: usize, j: usize| Pair::new(&planes[a][i], &planes[(a + 1) % 3][j], radius);
    let mut sum = Corner::EMPTY;
    for n in 0..8usize {
        let sign = if n.count_ones() % 2 == 0 { 1.0 } else { -1.0 };
        let [i, j, k] = [n & 1, n >> 1 & 1, n >> 2];
        let pairs = [pair(0, i, j), pair(1, j, k), pair(2, k, i)];
        let own = [&planes[0][i], &planes[1][j], &planes[2][k]];
        sum.add(sign, &Corner::new(own, pairs.each_ref(), radius, true));
    }
    sum
}

/// The part beyond an end of a box along x, by its corners at the low (0) or the high plane (1) of
/// y and z: that of the low end less that of the high one is the box's.
pub fn end(mut corner: impl FnMut([usize; 2]) -> Corner) -> Corner {
    let mut sum = Corner::EMPTY;
    for (sign, at) in [(1.0, [0, 0]), (-1.0, [1, 0]), (-1.0, [0, 1]), (1.0, [1, 1])] {
        sum.add(sign, &corner(at));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sphere_volume_is_sum_over_tiling_cells() {
        for (r, h, shift) in
            [(0.5, 0.125, 0.03), (1.0, 0.3, 0.11), (0.5, 0.02, 0.007), (0.5, 0.125, 0.0)]
        {
            let n = (r / h) as i32 + 2;
            let mut sum = 0.0;
            let mut moment = Vector3::zeros();
            for k in 0..(2 * n).pow(3) {
                let at = |k: i32| f64::from(k % (2 * n) - n) * h + shift;
                let low = Vector3::new(at(k), at(k / (2 * n)), at(k / (4 * n * n)));
                let part = of_box(&low, &low.add_scalar(h), r);
                assert!(
                    part.volume > -1e-12 * r.powi(3) && part.volume < (1.0 + 1e-9) * h.powi(3),
                    "{part:?}"
                );
                sum += part.volume;
                moment += part.moment;
            }
            let exact = 4.0 / 3.0 * PI * r * r * r;
            assert!((sum / exact - 1.0).abs() < 1e-12, "{r} {h}: {sum} against {exact}");
            assert!(moment.amax() < 1e-12 * r.powi(4), "{moment}");
        }
    }

    #[test]
    fn sphere_cap_and_octant_volumes_and_moments() {
        let r = 0.8f64;
        let h = 0.3;
        let cap = of_box(&Vector3::new(-1.0, -1.0, r - h), &Vector3::repeat(1.0), r);
        assert!((cap.volume - PI * h * h * (3.0 * r - h) / 3.0).abs() < 1e-14);
        assert!((cap.moment.z - PI / 4.0 * (h * (2.0 * r - h)).powi(2)).abs() < 1e-14);
        let octant = of_box(&Vector3::zeros(), &Vector3::repeat(1.0), r);
        assert!((octant.volume - PI * r.powi(3) / 6.0).abs() < 1e-14);
        assert!(
            (octant.moment - Vector3::repeat(PI * r.powi(4) / 16.0)).amax() < 1e-14,
            "{}",
            octant.moment
        );
    }

    #[test]
    fn sphere_box_overlap_matches_point_count() {
        let r = 1.0;
        let mut seed = 1u64;
        let mut chance = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) as f64 / (1u64 << 31) as f64
        };
        for _ in 0..60 {
            let low = Vector3::from_fn(|_, _| -1.2 + 2.0 * chance());
            let edges = Vector3::from_fn(|_, _| 0.05 + chance());
            let n = 48;
            let mut volume = 0.0;
            let mut moment = Vector3::zeros();
            let piece = edges.product() / f64::from(n * n * n);
            for k in 0..n * n * n {
                let at = Vector3::new(k % n, k / n % n, k / n / n)
                    .map(|k| (f64::from(k) + 0.5) / f64::from(n));
                let place = low + at.component_mul(&edges);
                if place.norm() < r {
                    volume += piece;
                    moment += piece * place;
                }
            }
            let exact = of_box(&low, &(low + edges), r);
            let close = 4e-3 * edges.product() + 1e-9;
            assert!(
                (exact.volume - volume).abs() < close,
                "{low} {edges}: {} counted {volume}",
                exact.volume
            );
            assert!(
                (exact.moment - moment).amax() < close,
                "{low} {edges}: {} counted {moment}",
                exact.moment
            );
        }
    }
}
