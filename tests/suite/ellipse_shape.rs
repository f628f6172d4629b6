//! The shape of an ellipse on a grid: area, moments, inertia and distance.

use crate::support::petsc;
use mics::geometry::{Cuts, Disc, Orientation, Placed, Pose, Shape, aperture, fraction, shapes};
use mics::grid::{GHOSTS, Grid};
use mics::petsc::Layout;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI};

/// An ellipse of these half axes (m).
pub fn ellipse(a: f64, b: f64) -> shapes::Ellipse {
    shapes::Ellipse::new([2.0 * a, 2.0 * b])
}

/// Area and first moment (m3) of what a shape fills of a box.
fn filled(
    shape: &dyn Shape,
    turn: &Orientation,
    middle: &Vector3<f64>,
    half: &Vector3<f64>,
) -> (f64, Vector3<f64>) {
    let planes = [0, 1, 2].map(|a| vec![middle[a] - half[a], middle[a] + half[a]]);
    let whole = 4.0 * half.x * half.y;
    let mut found = (0.0, Vector3::zeros());
    shape.turned(turn).tile(&planes, Some(0), &mut |tile| {
        found = (whole * tile.part, whole * tile.moment);
    });
    found
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
    let body = ellipse(0.41, 0.17);
    let (area, dv) = (body.volume(), grid.cell_volume());
    let mut planes = std::array::from_fn(|_| Vec::new());
    let mut worst = 0.0f64;
    for k in 0..60 {
        let orientation = Orientation::from_scaled_axis(Vector3::z() * (7.0 * scatter(3 * k)));
        let centre = Vector3::new(1.0 + scatter(3 * k + 1), 0.9 + 0.4 * scatter(3 * k + 2), 0.0);
        let placed = Placed { shape: &body, pose: Pose { place: centre, orientation } };
        let mut cells = Vec::new();
        fraction::overlaps(&grid, &placed, fraction::Rule::Exact, &mut planes, &mut cells);
        let half = Vector3::new(0.5 * grid.h[0], 0.5 * grid.h[1], 0.0);
        let whole: f64 = cells.iter().map(|o| dv * o.fraction).sum();
        let moment: Vector3<f64> =
            cells.iter().map(|o| filled(&body, &orientation, &o.arm, &half).1).sum();
        worst = worst.max((whole / area - 1.0).abs()).max(moment.norm() / area);
        for axis in 0..2 {
            let (mut cuts, mut arms) = (Cuts::with_capacity(0), Vec::new());
            aperture::cuts(&grid, axis, &placed, &mut planes, &mut cuts, &mut arms);
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
    let body = ellipse(0.41, 0.17);
    let n = 64;
    for k in 0..20 {
        let orientation = Orientation::from_scaled_axis(Vector3::z() * (7.0 * scatter(k)));
        let bounds = (&body as &dyn Shape).turned(&orientation).bounds();
        let second = |axis: usize, of: usize| {
            let sum: f64 = (0..n)
                .map(|i| {
                    let (sin, cos) = (PI * (i as f64 + 0.5) / n as f64 - FRAC_PI_2).sin_cos();
                    let (mut middle, mut half) = (Vector3::zeros(), Vector3::new(1.0, 1.0, 0.0));
                    let to = bounds[axis] * sin;
                    (middle[axis], half[axis]) = (0.5 * (to - 1.0), 0.5 * (to + 1.0));
                    -bounds[axis] * cos * filled(&body, &orientation, &middle, &half).1[of]
                })
                .sum();
            sum * PI / n as f64
        };
        let inertia = orientation * body.inertia_of(body.volume()) * orientation.transpose();
        let found = [second(1, 1), second(0, 0), -second(0, 1), second(0, 0) + second(1, 1)];
        let exact = [inertia[(0, 0)], inertia[(1, 1)], inertia[(0, 1)], inertia[(2, 2)]];
        for (found, exact) in found.into_iter().zip(exact) {
            assert!((found - exact).abs() < 1e-10 * inertia[(2, 2)], "{found} {exact}");
        }
    }
}

#[test]
fn ellipse_of_equal_axes_has_fractions_of_disc() {
    let (disc, body) = (Disc { radius: 0.3 }, ellipse(0.3, 0.3));
    let mut worst = 0.0f64;
    for k in 0..500 {
        let orientation = Orientation::from_scaled_axis(Vector3::z() * (7.0 * scatter(k)));
        let middle = 0.4 * Vector3::new(scatter(k + 1000), scatter(k + 2000), 0.0);
        let half = Vector3::new(0.02 + 0.1 * scatter(k + 3000).abs(), 0.05, 0.0);
        let (area, moment) = filled(&body, &orientation, &middle, &half);
        let (exact, first) = filled(&disc, &orientation, &middle, &half);
        worst = worst.max((area - exact).abs()).max((moment - first).norm());
        let [own, exact] =
            [&body as &dyn Shape, &disc].map(|shape| shape.turned(&orientation).nearest(&middle));
        worst = worst.max((own.distance - exact.distance).abs());
        worst = worst.max((own.normal - exact.normal).norm());
    }
    assert!(worst < 1e-13, "{worst:e}");
}
