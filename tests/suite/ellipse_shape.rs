//! The shape of an ellipse, given through [`Shape`] alone: area, moments, inertia and distance.

use crate::support::petsc;
use mics::geometry::{
    Cuts, Disc, Orientation, Placed, Shape, SurfacePoint, Tiles, aperture, fraction,
};
use mics::grid::{GHOSTS, Grid};
use mics::petsc::Layout;
use nalgebra::{Matrix3, Vector2, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// An ellipse (2D), of unit depth: `a` its half axis along its own x, `b` along y (m).
#[derive(Clone, Copy, Debug)]
pub struct Ellipse {
    pub a: f64,
    pub b: f64,
}

impl Ellipse {
    /// The point of the rim nearest to one (m), and the outward normal there, in the ellipse's own
    /// axes: for a point in the first quadrant `q = (a^2 x/(t + a^2), b^2 y/(t + b^2))` with t the
    /// largest root of `|q|` on the rim.
    fn foot(&self, point: Vector2<f64>) -> (Vector2<f64>, Vector2<f64>) {
        let square = Vector2::new(self.a * self.a, self.b * self.b);
        let tiny = 1e-14 * self.a.min(self.b);
        let p = point.map(|x| x.abs().max(tiny));
        // Where the function is convex and falls Newton's method comes to the root from below.
        let at = |t: f64| square.component_mul(&p).component_div(&square.add_scalar(t));
        let mut t = (self.a * p.x - square.x).max(self.b * p.y - square.y);
        for _ in 0..200 {
            let scaled = at(t).component_div(&Vector2::new(self.a, self.b));
            let value = scaled.norm_squared() - 1.0;
            let slope =
                -2.0 * scaled.component_mul(&scaled).component_div(&square.add_scalar(t)).sum();
            let next = t - value / slope;
            if next <= t {
                break;
            }
            t = next;
        }
        let q = at(t).zip_map(&point, f64::copysign);
        (q, q.component_div(&square).normalize())
    }

    /// Of the disc of radius 1 and the sector or triangle from its centre to `p` and `q`: area and
    /// first moment, with a sign.
    fn fan(p: Vector2<f64>, q: Vector2<f64>, inside: bool) -> (f64, Vector2<f64>) {
        if inside {
            let area = 0.5 * p.perp(&q);
            return (area, area / 3.0 * (p + q));
        }
        let (p, q) = (p.normalize(), q.normalize());
        (0.5 * p.perp(&q).atan2(p.dot(&q)), Vector2::new(q.y - p.y, p.x - q.x) / 3.0)
    }
}

impl Shape for Ellipse {
    fn dimension(&self) -> usize {
        2
    }

    fn radius(&self) -> f64 {
        self.a.max(self.b)
    }

    fn volume(&self) -> f64 {
        PI * self.a * self.b
    }

    fn inertia(&self, mass: f64) -> Matrix3<f64> {
        let (x, y) = (0.25 * mass * self.a * self.a, 0.25 * mass * self.b * self.b);
        Matrix3::from_diagonal(&Vector3::new(y, x, x + y))
    }

    fn distance(&self, orientation: &Orientation, arm: &Vector3<f64>) -> f64 {
        let point = (orientation.transpose() * arm).xy();
        let (foot, normal) = self.foot(point);
        (point - foot).dot(&normal)
    }

    fn normal(&self, orientation: &Orientation, arm: &Vector3<f64>) -> Vector3<f64> {
        let (_, normal) = self.foot((orientation.transpose() * arm).xy());
        orientation * Vector3::new(normal.x, normal.y, 0.0)
    }

    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let count = 2 * (TAU * self.radius() / spacing).ceil() as usize;
        let point = |i: usize| {
            let (sin, cos) = (TAU * ((i as f64 + 0.5) / count as f64)).sin_cos();
            let across = Vector3::new(self.b * cos, self.a * sin, 0.0);
            SurfacePoint {
                place: Vector3::new(self.a * cos, self.b * sin, 0.0),
                normal: across.normalize(),
                area: TAU / count as f64 * across.norm(),
            }
        };
        (0..count).map(point).collect()
    }

    fn bounds(&self, orientation: &Orientation) -> Vector3<f64> {
        Vector3::from_fn(|i, _| {
            if i < 2 {
                (orientation[(i, 0)] * self.a).hypot(orientation[(i, 1)] * self.b)
            } else {
                0.0
            }
        })
    }

    /// Stretched to a disc of radius 1 the box is a parallelogram: what of each edge is inside
    /// leaves a triangle, the rest sectors.
    fn moments(
        &self,
        orientation: &Orientation,
        middle: &Vector3<f64>,
        half: &Vector3<f64>,
    ) -> (f64, Vector3<f64>) {
        let corner = |k: usize| {
            let (x, y) = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)][k % 4];
            let own =
                orientation.transpose() * (middle + Vector3::new(x * half.x, y * half.y, 0.0));
            Vector2::new(own.x / self.a, own.y / self.b)
        };
        let (mut area, mut moment) = (0.0, Vector2::zeros());
        for (p, q) in (0..4).map(|k| (corner(k), corner(k + 1))) {
            let way = q - p;
            let (a, b, c) = (way.norm_squared(), p.dot(&way), p.norm_squared() - 1.0);
            let root = (b * b - a * c).max(0.0).sqrt();
            let [enter, leave] =
                [-root, root].map(|root| p + ((root - b) / a).clamp(0.0, 1.0) * way);
            for (from, to, inside) in [(p, enter, false), (enter, leave, true), (leave, q, false)] {
                if from != to {
                    let (part, first) = Ellipse::fan(from, to, inside);
                    (area, moment) = (area + part, moment + first);
                }
            }
        }
        let whole = self.a * self.b;
        (
            whole * area,
            orientation * Vector3::new(whole * self.a * moment.x, whole * self.b * moment.y, 0.0),
        )
    }
}

/// Numbers in [-1, 1) that look as drawn.
fn scatter(k: usize) -> f64 {
    (12.9898 * k as f64 + 4.1414).sin() * 43758.5453 % 1.0
}

#[test]
fn ellipse_area_and_moments_exact_at_any_orientation() {
    let petsc = petsc();
    let layout = Layout::new(&petsc.session, &[40, 36], &[true, false], GHOSTS).unwrap();
    let grid = Grid::<2>::new([40, 36], [2.0, 1.8], [true, false], &layout);
    let ellipse = Ellipse { a: 0.41, b: 0.17 };
    let (area, dv) = (ellipse.volume(), grid.cell_volume());
    let mut tiles = Tiles::for_radius(ellipse.radius(), &grid.h);
    let mut worst = 0.0f64;
    for k in 0..60 {
        let orientation = Orientation::from_scaled_axis(Vector3::z() * (7.0 * scatter(3 * k)));
        let centre = Vector3::new(1.0 + scatter(3 * k + 1), 0.9 + 0.4 * scatter(3 * k + 2), 0.0);
        let placed = Placed { shape: &ellipse, centre, orientation };
        let mut cells = Vec::new();
        fraction::overlaps(&grid, &placed, fraction::Rule::Exact, &mut tiles, &mut cells);
        let half = Vector3::new(0.5 * grid.h[0], 0.5 * grid.h[1], 0.0);
        let filled: f64 = cells.iter().map(|o| dv * o.fraction).sum();
        let moment: Vector3<f64> =
            cells.iter().map(|o| ellipse.moments(&orientation, &o.arm, &half).1).sum();
        worst = worst.max((filled / area - 1.0).abs()).max(moment.norm() / area);
        for axis in 0..2 {
            let (mut cuts, mut arms) = (Cuts::with_capacity(0), Vec::new());
            aperture::cuts(&grid, axis, &placed, &mut tiles, &mut cuts, &mut arms);
            // A face on the boundary between two periods stands at both of its ends.
            let once = || cuts.with_centroids().filter(|(cut, _)| cut.owned);
            let covered: f64 = once().map(|(cut, _)| dv * cut.solid_fraction).sum();
            let lever: Vector3<f64> = once().map(|(_, centroids)| dv * centroids.lever()).sum();
            worst = worst.max((covered / area - 1.0).abs()).max(lever.norm() / area);
        }
    }
    println!("cells and faces: {worst:.1e}");
    assert!(worst < 1e-10);
}

/// Second moments from the first ones of what is left of a line: with `M(X)` over `x < X`, that of
/// `x x` is the integral of -M.
#[test]
fn ellipse_inertia_matches_its_solid_fraction() {
    let ellipse = Ellipse { a: 0.41, b: 0.17 };
    let n = 64;
    for k in 0..20 {
        let orientation = Orientation::from_scaled_axis(Vector3::z() * (7.0 * scatter(k)));
        let bounds = ellipse.bounds(&orientation);
        let second = |axis: usize, of: usize| {
            let sum: f64 = (0..n)
                .map(|i| {
                    let (sin, cos) = (PI * (i as f64 + 0.5) / n as f64 - FRAC_PI_2).sin_cos();
                    let (mut middle, mut half) = (Vector3::zeros(), Vector3::new(1.0, 1.0, 0.0));
                    let to = bounds[axis] * sin;
                    (middle[axis], half[axis]) = (0.5 * (to - 1.0), 0.5 * (to + 1.0));
                    -bounds[axis] * cos * ellipse.moments(&orientation, &middle, &half).1[of]
                })
                .sum();
            sum * PI / n as f64
        };
        let inertia = orientation * ellipse.inertia(ellipse.volume()) * orientation.transpose();
        let found = [second(1, 1), second(0, 0), -second(0, 1), second(0, 0) + second(1, 1)];
        let exact = [inertia[(0, 0)], inertia[(1, 1)], inertia[(0, 1)], inertia[(2, 2)]];
        for (found, exact) in found.into_iter().zip(exact) {
            assert!((found - exact).abs() < 1e-10 * inertia[(2, 2)], "{found} {exact}");
        }
    }
}

#[test]
fn ellipse_of_equal_axes_has_fractions_of_disc() {
    let (disc, ellipse) = (Disc { radius: 0.3 }, Ellipse { a: 0.3, b: 0.3 });
    let mut worst = 0.0f64;
    for k in 0..500 {
        let orientation = Orientation::from_scaled_axis(Vector3::z() * (7.0 * scatter(k)));
        let middle = 0.4 * Vector3::new(scatter(k + 1000), scatter(k + 2000), 0.0);
        let half = Vector3::new(0.02 + 0.1 * scatter(k + 3000).abs(), 0.05, 0.0);
        let (area, moment) = ellipse.moments(&orientation, &middle, &half);
        let (exact, first) = disc.moments(&orientation, &middle, &half);
        worst = worst.max((area - exact).abs()).max((moment - first).norm());
        worst = worst.max(
            (ellipse.distance(&orientation, &middle) - disc.distance(&orientation, &middle)).abs(),
        );
        worst = worst.max(
            (ellipse.normal(&orientation, &middle) - disc.normal(&orientation, &middle)).norm(),
        );
    }
    assert!(worst < 1e-13, "{worst:e}");
}
