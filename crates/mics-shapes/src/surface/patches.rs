//! Patches and triangles of curved surfaces.

use crate::SurfacePoint;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Number of equal angles that a face of a cube needs each way for patches of a sphere of this
/// radius (m) that are about `spacing` (m) wide.
pub fn divisions(radius: f64, spacing: f64) -> usize {
    ((4.0 * PI / 3.0).sqrt() * radius / spacing).ceil().max(1.0) as usize
}

/// The point of the unit sphere over a cube's face at two angles, of so many a face.
fn on_sphere(face: usize, [i, j]: [f64; 2], n: usize) -> Vector3<f64> {
    let slope = |i: f64| (FRAC_PI_2 * (i / n as f64 - 0.5)).tan();
    let mut place = Vector3::zeros();
    place[face % 3] = if face < 3 { 1.0 } else { -1.0 };
    place[(face + 1) % 3] = slope(i);
    place[(face + 2) % 3] = slope(j);
    place.normalize()
}

/// Directions over the unit sphere with their solid angles: in the middles of equal angles on the
/// faces of a cube, `n` each way, as symmetric as a grid.
pub fn directions(n: usize) -> impl Iterator<Item = (Vector3<f64>, f64)> {
    let slope = move |i: f64| (FRAC_PI_2 * (i / n as f64 - 0.5)).tan();
    // Solid angle of a rectangle on the face, from its middle to here, as seen from the origin.
    let seen = |x: f64, y: f64| (x * y / (1.0 + x * x + y * y).sqrt()).atan();
    (0..6 * n * n).map(move |k| {
        let face = k / (n * n);
        let i = (k % n) as f64;
        let j = (k / n % n) as f64;
        let [x0, x1] = [slope(i), slope(i + 1.0)];
        let [y0, y1] = [slope(j), slope(j + 1.0)];
        let angle = seen(x1, y1) - seen(x0, y1) - seen(x1, y0) + seen(x0, y0);
        (on_sphere(face, [i + 0.5, j + 0.5], n), angle)
    })
}

/// Triangles of the unit sphere between such directions, counterclockwise seen from outside.
pub fn triangles(n: usize) -> impl Iterator<Item = [Vector3<f64>; 3]> {
    (0..6 * n * n).flat_map(move |k| {
        let face = k / (n * n);
        let i = (k % n) as f64;
        let j = (k / n % n) as f64;
        let at = |x: f64, y: f64| on_sphere(face, [i + x, j + y], n);
        let [a, b, c, d] = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        let turn = |[a, b, c]: [Vector3<f64>; 3]| if face < 3 { [a, b, c] } else { [a, c, b] };
        [turn([a, b, c]), turn([a, c, d])]
    })
}

/// Patches of a triangle, about `spacing` (m) wide: their middles and areas.
pub fn of_triangle(
    corners: &[Vector3<f64>; 3],
    normal: &Vector3<f64>,
    spacing: f64,
    patches: &mut Vec<SurfacePoint>,
) {
    let [a, b, c] = corners;
    let area = 0.5 * (b - a).cross(&(c - a)).norm();
    // Two for each square of the spacing, and none much longer.
    let longest = [b - a, c - b, a - c].iter().map(|e| e.norm()).fold(0.0, f64::max);
    let n = ((2.0 * area).sqrt() / spacing).max(0.5 * longest / spacing).ceil().max(1.0) as usize;
    let at = |i: f64, j: f64| a + (i * (b - a) + j * (c - a)) / n as f64;
    for i in 0..n {
        for j in 0..n - i {
            let x = i as f64 + 1.0 / 3.0;
            let y = j as f64 + 1.0 / 3.0;
            let area = area / (n * n) as f64;
            patches.push(SurfacePoint { place: at(x, y), normal: *normal, area });
            if i + j + 1 < n {
                let third = 1.0 / 3.0;
                patches.push(SurfacePoint {
                    place: at(x + third, y + third),
                    normal: *normal,
                    area,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_and_triangles_cover_the_sphere() {
        let (angle, sum) = directions(7)
            .fold((0.0, Vector3::zeros()), |sum, (n, angle)| (sum.0 + angle, sum.1 + angle * n));
        assert!((angle - 4.0 * PI).abs() < 1e-13 && sum.norm() < 1e-14);
        let volume: f64 = triangles(40).map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum();
        assert!((volume / (4.0 / 3.0 * PI) - 1.0).abs() < 2e-3, "{volume}");
    }

    #[test]
    fn patches_of_a_triangle_sum_to_it() {
        let corners = [Vector3::x(), Vector3::new(3.0, 0.5, 0.0), Vector3::new(0.5, 2.0, 0.0)];
        let mut patches = Vec::new();
        of_triangle(&corners, &Vector3::z(), 0.3, &mut patches);
        let mut area = 0.0;
        let mut place = Vector3::zeros();
        for patch in &patches {
            area += patch.area;
            place += patch.area * patch.place;
        }
        let [a, b, c] = corners;
        assert!((area - 0.5 * (b - a).cross(&(c - a)).norm()).abs() < 1e-14);
        assert!((place / area - (a + b + c) / 3.0).norm() < 1e-13);
    }
}
