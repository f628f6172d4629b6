//! A convex polygon that is cut by lines, in room that is used again.

use nalgebra::{Matrix2, Vector2, Vector3};

/// A convex polygon, its corners counterclockwise.
#[derive(Clone, Debug, Default)]
pub struct Flat {
    corners: Vec<Vector2<f64>>,
    next: Vec<Vector2<f64>>,
}

impl Flat {
    /// Of these corners (m), counterclockwise.
    pub fn new(corners: Vec<Vector2<f64>>) -> Flat {
        Flat { next: Vec::with_capacity(2 * corners.len() + 16), corners }
    }

    /// Becomes the parallelogram about `middle` (m) with the first two of these half edges (m).
    pub fn set_box(&mut self, middle: &Vector3<f64>, half: &[Vector3<f64>; 3]) {
        let [a, b] = [half[0].xy(), half[1].xy()];
        let a = if a.perp(&b) < 0.0 { -a } else { a };
        let middle = middle.xy();
        self.corners.clear();
        self.corners.extend([middle - a - b, middle + a - b, middle + a + b, middle - a + b]);
    }

    /// Becomes the polygon of these corners (m).
    pub fn set(&mut self, corners: impl IntoIterator<Item = Vector2<f64>>) {
        self.corners.clear();
        self.corners.extend(corners);
    }

    /// Its corners (m).
    pub fn corners(&self) -> &[Vector2<f64>] {
        &self.corners
    }

    /// Keeps what lies below a line, `n.x <= offset`.
    pub fn cut(&mut self, n: &Vector2<f64>, offset: f64) {
        self.next.clear();
        let Some(mut from) = self.corners.last().copied() else { return };
        let mut below = n.dot(&from) - offset;
        for to in self.corners.iter().copied() {
            let next = n.dot(&to) - offset;
            if (below <= 0.0) != (next <= 0.0) {
                self.next.push(from + below / (below - next) * (to - from));
            }
            if next <= 0.0 {
                self.next.push(to);
            }
            (from, below) = (to, next);
        }
        std::mem::swap(&mut self.corners, &mut self.next);
    }

    /// Drops corners that lie on the one before (closer than `distance`, m).
    pub fn merge(&mut self, distance: f64) {
        let Flat { corners, next } = self;
        next.clear();
        let mut last = corners.last().copied();
        for corner in corners.iter().copied() {
            if last.is_some_and(|last| (corner - last).norm() > distance) {
                next.push(corner);
                last = Some(corner);
            }
        }
        std::mem::swap(corners, next);
    }

    /// The ends of its edges (m).
    pub fn edges(&self) -> impl Iterator<Item = [Vector2<f64>; 2]> {
        let n = self.corners.len();
        (0..n).map(move |k| [self.corners[k], self.corners[(k + 1) % n]])
    }

    /// Area (m2) and the integral of the place over it (m3).
    pub fn moments(&self) -> (f64, Vector2<f64>) {
        let (mut area, mut first) = (0.0, Vector2::zeros());
        let Some(top) = self.corners.first().copied() else { return (area, first) };
        for [p, q] in self.edges() {
            let part = 0.5 * (p - top).perp(&(q - top));
            area += part;
            first += part / 3.0 * (top + p + q);
        }
        (area, first)
    }

    /// The integral of `x x^T` over it (m4).
    pub fn second_moments(&self) -> Matrix2<f64> {
        self.edges().map(|[p, q]| of_triangle(&p, &q)).sum()
    }
}

/// The integral of `x x^T` over the triangle of the origin and two points (m4), with a sign.
pub fn of_triangle(p: &Vector2<f64>, q: &Vector2<f64>) -> Matrix2<f64> {
    let squares = [*p, *q, p + q].map(|x| x * x.transpose()).iter().sum::<Matrix2<f64>>();
    p.perp(q) / 24.0 * squares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cut_square_has_known_moments() {
        let mut body = Flat::default();
        body.set_box(&Vector3::zeros(), &[Vector3::x(), Vector3::y(), Vector3::zeros()]);
        assert_eq!(body.moments(), (4.0, Vector2::zeros()));
        assert!((body.second_moments() - Matrix2::identity() * 4.0 / 3.0).norm() < 1e-15);
        body.cut(&Vector2::repeat(0.5f64.sqrt()), 0.0);
        let (area, first) = body.moments();
        assert!(
            (area - 2.0).abs() < 1e-15
                && (first / area + Vector2::repeat(1.0) / 3.0).norm() < 1e-15
        );
        body.cut(&Vector2::x(), -1.5);
        assert!(body.corners().is_empty());
    }
}
