//! What a disc has in common with a polygon, in closed form: with the disc's centre each edge of
//! the polygon spans a triangle, where it lies in the disc, and sectors, where it does not.

use super::flat::of_triangle;
use nalgebra::{Matrix2, Vector2};

/// Area of the part of the disc of this radius about `centre` (m) that lies in a polygon with these
/// corners (m), counterclockwise, and the integral of the place over it (m3).
pub fn moments(
    corners: &[Vector2<f64>],
    centre: &Vector2<f64>,
    radius: f64,
) -> (f64, Vector2<f64>) {
    let (mut area, mut first) = (0.0, Vector2::zeros());
    pieces(corners, centre, radius, |p, q, inside| {
        if inside {
            let part = 0.5 * p.perp(q);
            area += part;
            first += part / 3.0 * (p + q);
        } else {
            area += 0.5 * p.perp(q).atan2(p.dot(q));
            let [p, q] = [p.normalize(), q.normalize()];
            first += Vector2::new(q.y - p.y, p.x - q.x) / 3.0;
        }
    });
    let square = radius * radius;
    (square * area, square * (radius * first + area * centre))
}

/// The integral of `x x^T` from the disc's centre over that part (m4).
pub fn second_moments(
    corners: &[Vector2<f64>],
    centre: &Vector2<f64>,
    radius: f64,
) -> Matrix2<f64> {
    let mut second = Matrix2::zeros();
    pieces(corners, centre, radius, |p, q, inside| {
        if inside {
            second += of_triangle(p, q);
        } else {
            let angle = p.perp(q).atan2(p.dot(q));
            // Integrals of cos cos, cos sin and sin sin over the angle.
            let [p, q] = [p, q].map(|x| x.normalize());
            let [xx, xy] = [q.x * q.y - p.x * p.y, q.y * q.y - p.y * p.y];
            second += 0.125 * Matrix2::new(angle + xx, xy, xy, angle - xx);
        }
    });
    radius.powi(4) * second
}

/// Calls with the ends of the pieces of the edges, from the centre and over the radius, and whether
/// each lies in the disc.
fn pieces(
    corners: &[Vector2<f64>],
    centre: &Vector2<f64>,
    radius: f64,
    mut found: impl FnMut(&Vector2<f64>, &Vector2<f64>, bool),
) {
    let place = |corner: &Vector2<f64>| (corner - centre) / radius;
    let Some(mut p) = corners.last().map(place) else { return };
    for q in corners.iter().map(place) {
        let way = q - p;
        let (a, b, c) = (way.norm_squared(), p.dot(&way), p.norm_squared() - 1.0);
        if a > 0.0 {
            let root = (b * b - a * c).max(0.0).sqrt();
            // The ends themselves: a point that rounding moves off one at the centre would turn.
            let [enter, leave] = [-root, root].map(|root| match (root - b) / a {
                t if t <= 0.0 => p,
                t if t >= 1.0 => q,
                t => p + t * way,
            });
            for (from, to, inside) in [(p, enter, false), (enter, leave, true), (leave, q, false)] {
                if from != to {
                    found(&from, &to, inside);
                }
            }
        }
        p = q;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scatter::scatter;
    use std::f64::consts::PI;

    #[test]
    fn disc_in_squares_and_their_parts() {
        let (centre, radius, mut worst) = (Vector2::new(0.1, -0.2), 0.7, 0.0f64);
        let boxed = |middle: Vector2<f64>, half: Vector2<f64>| {
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| middle + half.component_mul(&Vector2::new(x, y)));
            let (area, first) = moments(&corners, &centre, radius);
            (area, first, second_moments(&corners, &centre, radius))
        };
        let (area, first, second) = boxed(centre, Vector2::repeat(1.0));
        let whole = PI * radius * radius;
        assert!((area - whole).abs() < 1e-15 && (first - whole * centre).norm() < 1e-15);
        let exact = 0.25 * whole * radius * radius;
        assert!((second - Matrix2::identity() * exact).norm() < 1e-15, "{second}");
        for k in 0..100 {
            let middle = Vector2::new(scatter(2 * k), scatter(2 * k + 1));
            let half = Vector2::new(0.4, 0.1 + 0.3 * scatter(1000 + k).abs());
            let n = 5;
            let parts = (0..n * n).map(|at| {
                let at = Vector2::new(at % n, at / n)
                    .map(|i| (2.0 * f64::from(i) + 1.0) / f64::from(n) - 1.0);
                boxed(middle + half.component_mul(&at), half / f64::from(n))
            });
            let sum = parts.reduce(|a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2)).unwrap();
            let whole = boxed(middle, half);
            worst = worst.max((sum.0 - whole.0).abs()).max((sum.1 - whole.1).norm());
            worst = worst.max((sum.2 - whole.2).norm());
        }
        println!("parts of a disc: {worst:.1e}");
        assert!(worst < 1e-14, "{worst:e}");
    }
}
