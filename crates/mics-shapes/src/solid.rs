//! What a solid, given by triangles of its surface, fills of a box, exactly, from the triangles
//! that are near it: Gauss's theorem along one axis,
//!
//! ```text
//!   V = sum over clipped triangles of int x n_x dA  +  x_1 A(x_1) - x_0 A(x_0)
//! ```
//! with the areas A of the solid's sections in the box's two sides across x ([`super::section`]).

use super::section::Section;
use nalgebra::{Vector2, Vector3};

/// Part by which the box is narrower along x, as in [`super::section`].
const NARROWER: [f64; 2] = [1.1e-10, 1.4e-10];

/// Room for a box that is cut by triangles, used again.
#[derive(Clone, Debug, Default)]
pub struct BoxSection {
    sections: [Section; 2],
    ends: [f64; 2],
    half: Vector3<f64>,
    volume: f64,
    first: Vector3<f64>,
    corners: Vec<Vector3<f64>>,
    next: Vec<Vector3<f64>>,
}

impl BoxSection {
    /// Begins with the box of these half edges (m) about the origin.
    pub fn begin(&mut self, half: &Vector3<f64>) {
        let size = half.amax();
        self.half = *half;
        self.ends = [NARROWER[0] * size - half.x, half.x - NARROWER[1] * size];
        self.sections.iter_mut().for_each(|section| section.begin(&half.yz()));
        (self.volume, self.first) = (0.0, Vector3::zeros());
    }

    /// Adds a triangle of the surface, corners counterclockwise seen from outside (m).
    pub fn add(&mut self, corners: &[Vector3<f64>; 3]) {
        for (section, x) in self.sections.iter_mut().zip(self.ends) {
            add_crossing(section, corners, x);
        }
        self.corners.clear();
        self.corners.extend(corners);
        for (axis, [low, high]) in
            [self.ends, [-self.half.y, self.half.y], [-self.half.z, self.half.z]]
                .into_iter()
                .enumerate()
        {
            self.clip(axis, 1.0, high);
            self.clip(axis, -1.0, -low);
        }
        for k in 2..self.corners.len() {
            let [a, b, c] = [self.corners[0], self.corners[k - 1], self.corners[k]];
            let area = 0.5 * (b - a).cross(&(c - a)).x;
            let sum = a + b + c;
            self.volume += area * sum.x / 3.0;
            let squares = a.x * a + b.x * b + c.x * c;
            let moment = area / 12.0 * (squares + sum.x * sum);
            self.first += Vector3::new(0.5 * moment.x, moment.y, moment.z);
        }
    }

    /// Keeps what lies at `sign x <= limit` along an axis.
    fn clip(&mut self, axis: usize, sign: f64, limit: f64) {
        self.next.clear();
        let Some(mut from) = self.corners.last().copied() else { return };
        let mut above = sign * from[axis] - limit;
        for to in self.corners.iter().copied() {
            let next = sign * to[axis] - limit;
            if (above <= 0.0) != (next <= 0.0) {
                self.next.push(from + above / (above - next) * (to - from));
            }
            if next <= 0.0 {
                self.next.push(to);
            }
            (from, above) = (to, next);
        }
        std::mem::swap(&mut self.corners, &mut self.next);
    }

    /// Volume of the solid within the box (m3) and the integral of the place over that (m4);
    /// `inside` says whether the solid has a point, asked where no triangle tells.
    pub fn end(&mut self, inside: impl Fn(&Vector3<f64>) -> bool) -> (f64, Vector3<f64>) {
        let (mut volume, mut first) = (self.volume, self.first);
        for (k, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let x = self.ends[k];
            let (area, moment) = self.sections[k].end(|at| inside(&Vector3::new(x, at.x, at.y)));
            volume += sign * x * area;
            first += sign * x * Vector3::new(0.5 * x * area, moment.x, moment.y);
        }
        (volume, first)
    }
}

/// Adds to a section across x the segment in which a triangle passes it, the solid on its left seen
/// against x.
fn add_crossing(section: &mut Section, corners: &[Vector3<f64>; 3], x: f64) {
    let mut ends = [Vector2::zeros(); 2];
    let mut count = 0;
    for k in 0..3 {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        if (from.x <= x) != (to.x <= x) && count < 2 {
            ends[count] = (from + (x - from.x) / (to.x - from.x) * (to - from)).yz();
            count += 1;
        }
    }
    if count < 2 {
        return;
    }
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let [mut p, mut q] = ends;
    // Outside is on the right of the way from p to q.
    if (q - p).dot(&Vector2::new(-normal.z, normal.y)) < 0.0 {
        (p, q) = (q, p);
    }
    section.add(&p, &q);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of a box with these ends.
    pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> Vec<[Vector3<f64>; 3]> {
        let at = |k: usize| Vector3::from_fn(|a, _| if k >> a & 1 == 0 { low[a] } else { high[a] });
        let faces =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let split = |[a, b, c, d]: [usize; 4]| [[at(a), at(b), at(c)], [at(a), at(c), at(d)]];
        faces.into_iter().flat_map(split).collect()
    }

    fn inside(low: &[f64; 3], high: &[f64; 3], x: &Vector3<f64>) -> bool {
        (0..3).all(|a| x[a] > low[a] && x[a] < high[a])
    }

    #[test]
    fn box_in_box_has_exact_volume_and_moments() {
        let half = Vector3::new(0.5, 0.4, 0.3);
        for (low, high) in [
            ([-0.2, -0.1, 0.0], [0.3, 0.2, 0.2]),
            ([-9.0, -9.0, -9.0], [0.1, 0.2, 9.0]),
            ([-9.0, -9.0, -9.0], [9.0, 9.0, 9.0]),
            ([-0.1, -9.0, -9.0], [9.0, 0.1, 0.05]),
            ([1.0, 1.0, 1.0], [2.0, 2.0, 2.0]),
            ([-0.5, -0.4, -0.3], [0.5, 0.4, 0.3]),
        ] {
            let mut room = BoxSection::default();
            room.begin(&half);
            cuboid(low, high).iter().for_each(|triangle| room.add(triangle));
            let (volume, first) = room.end(|x| inside(&low, &high, x));
            let (mut exact, mut middle) = (1.0, Vector3::zeros());
            for a in 0..3 {
                let (from, to) = (low[a].max(-half[a]), high[a].min(half[a]));
                exact *= (to - from).max(0.0);
                middle[a] = 0.5 * (from + to);
            }
            assert!((volume - exact).abs() < 1e-9, "{volume} {exact}");
            assert!((first - exact * middle).norm() < 1e-9, "{first}");
        }
    }

    #[test]
    fn octahedron_in_lattice_has_its_volume() {
        let n = 7;
        let (h, mut volume, mut first) = (0.31, 0.0, Vector3::zeros());
        let corner = |s: [f64; 3]| {
            let [x, y, z] = [0, 1, 2].map(|a| {
                let mut point = Vector3::zeros();
                point[a] = s[a];
                point
            });
            if s[0] * s[1] * s[2] > 0.0 { [x, y, z] } else { [x, z, y] }
        };
        let signs = (0..8usize).map(|k| [0, 1, 2].map(|a| 1.0 - 2.0 * (k >> a & 1) as f64));
        let surface: Vec<_> = signs.map(corner).collect();
        let offset = Vector3::new(0.013, -0.021, 0.034);
        for k in 0..n * n * n {
            let at = [k % n, k / n % n, k / n / n].map(|i| (i as f64 - 0.5 * (n - 1) as f64) * h);
            let middle = Vector3::from(at) + offset;
            let mut room = BoxSection::default();
            room.begin(&Vector3::repeat(0.5 * h));
            surface.iter().for_each(|triangle| room.add(&triangle.map(|x| x - middle)));
            let (part, moment) = room.end(|x| (x + middle).abs().sum() < 1.0);
            volume += part;
            first += moment + part * middle;
        }
        assert!((volume - 4.0 / 3.0).abs() < 1e-8 && first.norm() < 1e-8, "{volume} {first}");
    }
}
