//! Intersection of a ball with a convex polyhedron, in closed form.
//!
//! ```text
//!    V   = sum over faces of  integral of h/3 (1 - R^3/|x|^3) dA   (+ the ball, of centres inside)
//!    M   = sum over faces of  n integral of g dA                      g = (|x|^2 - R^2)/2
//!    S   = sum over faces of  n (integral of x g dA)^T - 1 integral of g dV
//! ```
//! All fields vanish on the sphere, so that only faces count, with h the distance of the plane from
//! the ball's centre, and of these only what lies in the ball, a disc of the radius `c`. Each edge
//! spans two right-angled triangles with the disc's centre:
//!
//! ```text
//!        |\          t along the edge from the foot of the perpendicular, of length e;
//!      e | \         r up to e/cos(theta) or c, whichever is less
//!        |__\
//!          t
//! ```

use crate::boxes::convex::Convex;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// Below this part of the radius a centre counts as lying in a plane.
const NEAR: f64 = 1e-9;

/// A face of a polyhedron, by the disc that its plane has in a ball.
struct Face {
    /// Distance of the plane from the centre, and the square of the disc's radius.
    h: f64,
    square: f64,
}

/// Integrals over a right-angled triangle.
#[derive(Default)]
struct Triangle {
    volume: f64,
    potential: f64,
    /// Angle that the whole triangle spans at the disc's centre, and the solid one.
    solid: f64,
}

impl Face {
    /// With the perpendicular `e`, at least zero, and `t` along the edge; the ball's radius is 1.
    fn triangle(&self, e: f64, t: f64, solid: bool) -> Triangle {
        let Face { h, square } = *self;
        let angle = t.atan2(e);
        let past = |t: f64| (h.abs() * t).atan2(e * (t * t + e * e + h * h).sqrt());
        let mut found = Triangle::default();
        if solid {
            found.solid = angle - past(t);
        }
        if square <= 0.0 {
            return found;
        }
        let within = (square - e * e).max(0.0).sqrt();
        let near = if t.abs() <= within { t } else { within.copysign(t) };
        let rest = if near == t { 0.0 } else { angle - near.atan2(e) };
        found.volume = 1f64.copysign(h) / 3.0 * (past(near) - angle)
            + h / 3.0 * (0.5 * e * near + (0.5 * square + 1.0) * rest);
        found.potential = e * near * ((3.0 * e * e + near * near) / 24.0 - 0.25 * square)
            - 0.125 * square * square * rest;
        found
    }

    /// The integral of the place in the plane times g, along the perpendicular and along the edge.
    fn first(&self, e: f64, t: f64) -> (f64, f64) {
        let square = self.square;
        if square <= 0.0 {
            return (0.0, 0.0);
        }
        let within = (square - e * e).max(0.0).sqrt();
        let near = if t.abs() <= within { t } else { within.copysign(t) };
        let fifth = square * square * square.sqrt() / 15.0;
        let [(sin, cos), (inner_sin, inner_cos)] = [t, near].map(|t| {
            let length = t.hypot(e);
            if length > 0.0 { (t / length, e / length) } else { (0.0, 1.0) }
        });
        let ee = e * e;
        let perpendicular =
            near * ee * (ee / 10.0 + near * near / 30.0 - square / 6.0) - fifth * (sin - inner_sin);
        let n = near * near;
        let along = e * (n * (2.0 * ee + n) / 40.0 - square * n / 12.0) - fifth * (inner_cos - cos);
        (perpendicular, along)
    }
}

/// Volume of the part of the ball of the given radius (m) about the origin that lies in a convex
/// polyhedron, of which `faces` has the outward normals, offsets (m) and corners (m), and the
/// integral of the place over it (m4).
pub fn moments(body: &Convex, centre: &Vector3<f64>, radius: f64) -> (f64, Vector3<f64>) {
    let corners = body.corners();
    let height = |n: &Vector3<f64>, offset: f64| (offset - n.dot(centre)) / radius;
    let least = body.faces().map(|(n, offset, _)| height(&n, offset)).fold(f64::INFINITY, f64::min);
    if body.is_empty() || least <= -1.0 {
        return (0.0, Vector3::zeros());
    }
    // A centre in a plane: the cones from it over the faces, solid angles and all.
    let solid = least.abs() <= NEAR;
    let mut volume = if least > NEAR { 4.0 / 3.0 * PI } else { 0.0 };
    let mut first = Vector3::zeros();
    for (n, offset, round) in body.faces() {
        let h = height(&n, offset);
        let face = Face { h, square: 1.0 - h * h };
        if face.square <= 0.0 && (!solid || h.abs() <= NEAR) {
            continue;
        }
        let mut part = 0.0;
        let mut potential = 0.0;
        each_edge(corners, round, &n, centre, radius, |edge| {
            let Edge { e, from, to, .. } = edge;
            let [high, low] = [to, from].map(|t| face.triangle(e.abs(), t, solid));
            let sign = if e < 0.0 { -1.0 } else { 1.0 };
            potential += sign * (high.potential - low.potential);
            if solid && h.abs() <= NEAR {
                return;
            }
            part += sign * (high.volume - low.volume);
            part += sign * (high.solid - low.solid) / 3f64.copysign(h);
        });
        volume += part;
        first += potential * n;
    }
    let cube = radius.powi(3);
    (cube * volume, cube * radius * first + cube * volume * centre)
}

/// The integral of `x x^T` from the ball's centre over that part (m5), whose volume is given (m3).
pub fn second_moments(
    body: &Convex,
    centre: &Vector3<f64>,
    radius: f64,
    volume: f64,
) -> Matrix3<f64> {
    let corners = body.corners();
    let mut second = Matrix3::zeros();
    for (n, offset, round) in body.faces() {
        let h = (offset - n.dot(centre)) / radius;
        let face = Face { h, square: 1.0 - h * h };
        let mut potential = 0.0;
        let mut place = Vector3::zeros();
        each_edge(corners, round, &n, centre, radius, |edge| {
            let Edge { e, from, to, along } = edge;
            let sign = if e < 0.0 { -1.0 } else { 1.0 };
            let [high, low] = [to, from].map(|t| face.triangle(e.abs(), t, false).potential);
            potential += sign * (high - low);
            let [high, low] = [to, from].map(|t| face.first(e.abs(), t));
            place += (high.0 - low.0) * along.cross(&n) + sign * (high.1 - low.1) * along;
        });
        second += n * (place + h * potential * n).transpose();
    }
    let inner = (second.trace() - volume / radius.powi(3)) / 5.0;
    let second = second - Matrix3::from_diagonal_element(inner);
    0.5 * radius.powi(5) * (second + second.transpose())
}

/// An edge of a face: the signed distance of its line from the disc's centre, from where to where
/// it goes along the line, and the line's direction; over the ball's radius.
struct Edge {
    e: f64,
    from: f64,
    to: f64,
    along: Vector3<f64>,
}

fn each_edge(
    corners: &[Vector3<f64>],
    round: &[u32],
    n: &Vector3<f64>,
    centre: &Vector3<f64>,
    radius: f64,
    mut found: impl FnMut(Edge),
) {
    let place = |k: u32| (corners[k as usize] - centre) / radius;
    let mut p = place(round[round.len() - 1]);
    for q in round.iter().map(|k| place(*k)) {
        let way = q - p;
        let length = way.norm();
        if length > 0.0 {
            let along = way / length;
            let e = n.dot(&p.cross(&along));
            found(Edge { e, from: p.dot(&along), to: q.dot(&along), along });
        }
        p = q;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boxes::convex::inertia;
    use crate::scatter::scatter;

    fn boxed(middle: Vector3<f64>, half: Vector3<f64>) -> Convex {
        let mut body = Convex::default();
        body.set_box(&middle, &[0, 1, 2].map(|a| half[a] * Vector3::ith(a, 1.0)));
        body
    }

    #[test]
    fn ball_in_a_box_half_spaces_and_octants() {
        let centre = Vector3::new(0.3, -0.2, 0.1);
        let whole = 4.0 / 3.0 * PI * 0.125;
        let big = boxed(centre, Vector3::repeat(1.0));
        let (volume, first) = moments(&big, &centre, 0.5);
        assert!((volume - whole).abs() < 1e-15 && (first - whole * centre).norm() < 1e-15);
        let second = second_moments(&big, &centre, 0.5, volume);
        let exact = 0.4 * whole * 0.25;
        assert!((inertia(&second) - Matrix3::identity() * exact).norm() < 1e-15, "{second}");
        // The centre at a corner and in a face of the box.
        for (shift, part) in [(Vector3::repeat(1.0), 8.0), (Vector3::x(), 2.0)] {
            let (volume, first) =
                moments(&boxed(centre + shift, Vector3::repeat(1.0)), &centre, 0.5);
            assert!((volume - whole / part).abs() < 1e-14, "{volume} {}", whole / part);
            let arm = first / volume - centre;
            let expected = 0.375 * 0.5 * shift;
            assert!((arm - expected).norm() < 1e-13, "{arm} {expected}");
        }
        // A cap of the height 0.2.
        let (volume, _) =
            moments(&boxed(centre + 1.3 * Vector3::x(), Vector3::repeat(1.0)), &centre, 0.5);
        assert!((volume - PI * 0.04 * (1.5 - 0.2) / 3.0).abs() < 1e-15);
    }

    /// Against sums over the halves, and over small boxes.
    #[test]
    fn parts_of_a_ball_sum_to_the_whole() {
        let centre = Vector3::new(0.1, 0.2, -0.3);
        let radius = 0.7;
        let mut worst = [0.0f64; 3];
        for k in 0..40 {
            let middle = Vector3::from_fn(|a, _| 0.8 * scatter(3 * k + a));
            let half = Vector3::from_fn(|a, _| 0.2 + 0.3 * scatter(1000 + 3 * k + a).abs());
            let whole = |middle: Vector3<f64>, half: Vector3<f64>| {
                let body = boxed(middle, half);
                let (volume, first) = moments(&body, &centre, radius);
                (volume, first, second_moments(&body, &centre, radius, volume))
            };
            let (volume, first, second) = whole(middle, half);
            let n = 6;
            let mut sum = (0.0, Vector3::zeros(), Matrix3::zeros());
            for at in 0..n * n * n {
                let at = Vector3::new(at % n, at / n % n, at / n / n)
                    .map(|i| (2.0 * i as f64 + 1.0) / n as f64 - 1.0);
                let part = whole(middle + half.component_mul(&at), half / n as f64);
                sum = (sum.0 + part.0, sum.1 + part.1, sum.2 + part.2);
            }
            worst[0] = worst[0].max((sum.0 - volume).abs());
            worst[1] = worst[1].max((sum.1 - first).norm());
            worst[2] = worst[2].max((sum.2 - second).norm());
            // By points, which see a factor and a sign.
            let points = 40;
            let mut count = 0.0;
            let mut place = Vector3::zeros();
            let mut square = Matrix3::zeros();
            for at in 0..points * points * points {
                let at = Vector3::new(at % points, at / points % points, at / points / points)
                    .map(|i| (2.0 * i as f64 + 1.0) / points as f64 - 1.0);
                let x = middle + half.component_mul(&at) - centre;
                if x.norm() < radius {
                    count += 1.0;
                    place += x;
                    square += x * x.transpose();
                }
            }
            let dv = 8.0 * half.product() / f64::from(points * points * points);
            assert!((dv * count - volume).abs() < 2e-3, "{} {volume}", dv * count);
            assert!((dv * place - (first - volume * centre)).norm() < 2e-3);
            assert!((dv * square - second).norm() < 2e-3, "{} {second}", dv * square);
        }
        println!("volume, first and second moments: {worst:?}");
        assert!(worst.iter().all(|worst| *worst < 1e-13), "{worst:?}");
    }
}
