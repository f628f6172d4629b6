//! A sphere; its overlap with a box by slices of exact area, integrated by Gauss points between the heights where a
//! slice changes its form.
//!
//! ```text
//!      z        a slice at z is a disc of radius sqrt(R^2 - z^2) against the box's rectangle; its area has kinks where
//!      |-----   that disc first meets an edge or a corner of the rectangle, and is smooth between them
//! ```

use super::circle::{rectangle_moment, rectangle_overlap};
use super::{Shape, SurfacePoint, Turn, round};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// A sphere (3D).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Radius (m).
    pub radius: f64,
}

impl Shape for Sphere {
    fn dimension(&self) -> usize {
        3
    }

    fn is_round(&self) -> bool {
        true
    }

    fn radius(&self) -> f64 {
        self.radius
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.radius.powi(3)
    }

    fn inertia(&self, mass: f64) -> Matrix3<f64> {
        Matrix3::from_diagonal_element(0.4 * mass * self.radius.powi(2))
    }

    fn distance(&self, _: &Turn, arm: &Vector3<f64>) -> f64 {
        arm.norm() - self.radius
    }

    fn normal(&self, _: &Turn, arm: &Vector3<f64>) -> Vector3<f64> {
        arm.normalize()
    }

    /// On a spiral of equal areas.
    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let area = 4.0 * PI * self.radius * self.radius;
        let count = 2 * (area / spacing.powi(2)).ceil() as usize;
        let golden = PI * (3.0 - 5.0f64.sqrt());
        let point = |i: usize| {
            let z = 1.0 - 2.0 * ((i as f64 + 0.5) / count as f64);
            let (y, x) = (golden * i as f64).sin_cos();
            let c = (1.0 - z * z).max(0.0).sqrt();
            round::surface_point(self.radius * Vector3::new(c * x, c * y, z), self.radius, area / count as f64)
        };
        (0..count).map(point).collect()
    }

    fn shell(&self) -> (f64, Matrix3<f64>) {
        let area = 4.0 * PI * self.radius * self.radius;
        (area, Matrix3::from_diagonal_element(8.0 / 3.0 * PI * self.radius.powi(4)))
    }

    fn whole_or_nothing(&self, _: &Turn, middle: &Vector3<f64>, half: &Vector3<f64>) -> Option<f64> {
        round::whole_or_nothing(middle, half, self.radius)
    }

    fn moments(&self, _: &Turn, middle: &Vector3<f64>, half: &Vector3<f64>) -> (f64, Vector3<f64>) {
        box_moments(&(middle - half), &(middle + half), self.radius)
    }

    fn filled(&self, _: &Turn, middle: &Vector3<f64>, half: &Vector3<f64>) -> f64 {
        box_overlap(&(middle - half), &(middle + half), self.radius)
    }

    /// Of the part of the face's own plane that it covers, a disc's: the flux of a rotation through the faces of a cell then
    /// sums to zero, in every cell.
    fn lever(
        &self,
        _: &Turn,
        axis: usize,
        middle: &Vector3<f64>,
        half: &Vector3<f64>,
        _: &Vector3<f64>,
    ) -> Vector3<f64> {
        let c = (self.radius * self.radius - middle[axis] * middle[axis]).max(0.0).sqrt();
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let [x, y] = [a, b].map(|a| [middle[a] - half[a], middle[a] + half[a]]);
        let area = rectangle_overlap(x, y, c);
        let part = area / (2.0 * half[a] * (2.0 * half[b]));
        let mut centroid = *middle;
        if part > LEAST {
            centroid[a] = rectangle_moment(x, y, c) / area;
            centroid[b] = rectangle_moment(y, x, c) / area;
        }
        part * centroid
    }

    fn meets(&self, _: &Turn, apart: &Vector3<f64>, along: &Vector3<f64>) -> Option<f64> {
        round::meets(apart, along, self.radius)
    }
}

/// Part of a face below which the covered one's centroid is the face's own.
const LEAST: f64 = 1e-9;

/// Nodes and weights of 10-point Gauss-Legendre on [-1, 1], the positive half (Abramowitz & Stegun, table 25.4).
const GAUSS: [(f64, f64); 5] = [
    (0.148_874_338_981_631_2, 0.295_524_224_714_752_9),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

/// Volume of the sphere of `radius` at the origin inside the box from `low` to `high` (m3); relative error about 1e-9
/// of the box.
fn box_overlap(low: &Vector3<f64>, high: &Vector3<f64>, radius: f64) -> f64 {
    let (x, y) = ([low.x, high.x], [low.y, high.y]);
    let [volume] = slices(low, high, radius, |_, c| [rectangle_overlap(x, y, c)]);
    volume
}

/// That volume (m3), and the integrals of the coordinates over it (m4), their error alike; in one go, since all have the same
/// slices.
fn box_moments(low: &Vector3<f64>, high: &Vector3<f64>, radius: f64) -> (f64, Vector3<f64>) {
    let (x, y) = ([low.x, high.x], [low.y, high.y]);
    let [volume, mx, my, mz] = slices(low, high, radius, |z, c| {
        let area = rectangle_overlap(x, y, c);
        [area, rectangle_moment(x, y, c), rectangle_moment(y, x, c), z * area]
    });
    (volume, Vector3::new(mx, my, mz))
}

/// Integrals over z of what `of` finds in the slices of the sphere of `radius`, each with its height and its circle's radius.
fn slices<const N: usize>(
    low: &Vector3<f64>,
    high: &Vector3<f64>,
    radius: f64,
    of: impl Fn(f64, f64) -> [f64; N],
) -> [f64; N] {
    let (x, y) = ([low.x, high.x], [low.y, high.y]);
    let (bottom, top) = (low.z.max(-radius), high.z.min(radius));
    if top <= bottom {
        return [0.0; N];
    }
    // Heights where the slice's circle passes an edge (|x|, |y|) or a corner of the rectangle, or shrinks to nothing.
    let mut cuts = [0.0; 20];
    let mut n = 0;
    let mut cut = |z: f64| {
        if z > bottom && z < top {
            cuts[n] = z;
            n += 1;
        }
    };
    let squares = [x[0] * x[0], x[1] * x[1], y[0] * y[0], y[1] * y[1]];
    let corners = [squares[0] + squares[2], squares[0] + squares[3], squares[1] + squares[2], squares[1] + squares[3]];
    for s in squares.into_iter().chain(corners) {
        let under = radius * radius - s;
        if under > 0.0 {
            cut(under.sqrt());
            cut(-under.sqrt());
        }
    }
    let cuts = &mut cuts[..n];
    cuts.sort_unstable_by(f64::total_cmp);
    let mut sums = [0.0; N];
    let mut from = bottom;
    for to in cuts.iter().copied().chain([top]) {
        integrate(from, to, &mut sums, |z| of(z, (radius * radius - z * z).max(0.0).sqrt()));
        from = to;
    }
    sums
}

/// Adds integrals of `f` with square-root-like ends: `z = m + w s (3 - s^2)/2` flattens them for the Gauss points.
fn integrate<const N: usize>(from: f64, to: f64, sums: &mut [f64; N], f: impl Fn(f64) -> [f64; N]) {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    for (s, w) in GAUSS.into_iter().flat_map(|(s, w)| [(s, w), (-s, w)]) {
        let (values, weight) = (f(middle + half * s * (1.5 - 0.5 * s * s)), half * w * 1.5 * (1.0 - s * s));
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn cells_that_tile_space_hold_the_whole_sphere() {
        for (r, h, shift) in [(0.5, 0.125, 0.03), (1.0, 0.3, 0.11), (0.5, 0.02, 0.007)] {
            let n = (r / h) as i32 + 2;
            let mut sum = 0.0;
            for k in 0..(2 * n).pow(3) {
                let at = |k: i32| f64::from(k % (2 * n) - n) * h + shift;
                let low = Vector3::new(at(k), at(k / (2 * n)), at(k / (4 * n * n)));
                sum += box_overlap(&low, &low.add_scalar(h), r);
            }
            let exact = 4.0 / 3.0 * PI * r * r * r;
            assert!((sum / exact - 1.0).abs() < 1e-8, "{r} {h}: {sum} against {exact}");
        }
    }

    #[test]
    fn an_octant_has_its_exact_moments_along_every_axis() {
        let r = 0.8f64;
        let (volume, moment) = box_moments(&Vector3::zeros(), &Vector3::repeat(1.0), r);
        assert!((volume - PI * r.powi(3) / 6.0).abs() < 1e-9);
        assert!((moment - Vector3::repeat(PI * r.powi(4) / 16.0)).amax() < 1e-9, "{moment}");
    }

    #[test]
    fn a_cap_and_an_octant_have_their_exact_volumes() {
        let (r, h) = (0.8f64, 0.3);
        let cap = box_overlap(&Vector3::new(-1.0, -1.0, r - h), &Vector3::repeat(1.0), r);
        assert!((cap - PI * h * h * (3.0 * r - h) / 3.0).abs() < 1e-12);
        let octant = box_overlap(&Vector3::zeros(), &Vector3::repeat(1.0), r);
        assert!((octant - PI * r.powi(3) / 6.0).abs() < 1e-9);
    }
}
