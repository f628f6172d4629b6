//! What the tests of shapes have in common.

use super::Geometry;
use nalgebra::{Rotation3, Vector3};

/// Numbers that look as drawn, in (-1, 1).
pub fn scatter(k: usize) -> f64 {
    (12.9898 * k as f64 + 4.1414).sin() * 43758.5453 % 1.0
}

/// How far the boxes of shifted and turned lattices are from summing to a body, and the first
/// moments from zero: the worst, over the volume.
pub fn lattice(body: &dyn Geometry) -> (f64, f64) {
    let three = body.dimension() == 3;
    let (n, mut worst) = (10usize, (0.0f64, 0.0f64));
    let h = 2.2 * body.radius() / (n as f64 - 1.0);
    for k in 0..10 {
        let axis = if three {
            Vector3::from_fn(|a, _| 3.0 * scatter(9 * k + a))
        } else {
            3.0 * scatter(9 * k) * Vector3::z()
        };
        // Also with corners, edges and faces of boxes right in the middle.
        let turn = Rotation3::from_scaled_axis(if k < 5 { 0.0 * axis } else { axis });
        let shift = Vector3::from_fn(|a, _| match k {
            _ if a == 2 && !three => 0.0,
            0..4 => 0.5 * h * f64::from(u8::from(a < k)),
            _ => 0.4 * h * scatter(100 + 3 * k + a),
        });
        let half = [0, 1, 2].map(|a| {
            if a < 2 || three { turn * Vector3::ith(a, 0.5 * h) } else { Vector3::zeros() }
        });
        let (mut volume, mut first) = (0.0, Vector3::zeros());
        let layers = if three { n } else { 1 };
        for at in 0..n * n * layers {
            let at = Vector3::new(at % n, at / n % n, at / n / n).map(|i| i as f64)
                - 0.5 * Vector3::new(n - 1, n - 1, layers - 1).map(|i| i as f64);
            let part = body.filled(&(turn * (h * at + shift)), &half);
            volume += part.0;
            first += part.1;
        }
        worst.0 = worst.0.max((volume / body.volume() - 1.0).abs());
        worst.1 = worst.1.max(first.norm() / (body.volume() * body.radius()));
    }
    worst
}

/// The largest of the distances of the feet of nearest points from the surface, of points about a
/// body, by the distance itself; and whether the distance changes no faster than the place.
pub fn feet(body: &dyn Geometry, reach: f64) -> f64 {
    let (three, mut worst) = (body.dimension() == 3, 0.0f64);
    let mut last: Option<(Vector3<f64>, f64)> = None;
    for k in 0..3000 {
        let point = Vector3::from_fn(|a, _| {
            if a < 2 || three { reach * body.radius() * scatter(3 * k + a) } else { 0.0 }
        });
        let found = body.nearest(&point);
        let foot = point - found.distance * found.normal;
        worst = worst.max(body.nearest(&foot).distance.abs() / body.radius());
        assert!((found.normal.norm() - 1.0).abs() < 1e-12, "{point} {found:?}");
        if let Some((other, distance)) = last {
            let apart = (found.distance - distance).abs() - (point - other).norm();
            assert!(apart < 1e-9 * body.radius(), "{point} {found:?} {other} {distance}");
        }
        last = Some((point, found.distance));
    }
    worst
}

/// [`worst_tile`] in lattices that are finer and coarser than a body, with planes through its
/// centre too.
pub fn worst_tiles(body: &dyn Geometry) -> [f64; 3] {
    let mut worst = [0.0f64; 3];
    for k in 0..60 {
        let two = body.dimension() == 2;
        let turn = if k % 3 == 0 {
            Rotation3::identity()
        } else if two {
            Rotation3::from_scaled_axis(3.0 * scatter(4 * k) * Vector3::z())
        } else {
            let at = |a: usize| 3.0 * scatter(4 * k + a);
            Rotation3::from_euler_angles(at(0), at(1), at(2))
        };
        let h = [0.07, 0.15, 0.4, 1.3][k % 4] * 2.0 * body.radius();
        let shift = if k % 5 == 0 { 0.0 } else { 0.5 * h * scatter(4 * k + 3) };
        let n = (1.2 * body.radius() / h) as i32 + 2;
        let mut planes: [Vec<f64>; 3] =
            [1.0, 0.8, 1.1].map(|part| (-n..=n).map(|i| part * h * f64::from(i) + shift).collect());
        if two {
            planes[2] = vec![0.0; 2];
        }
        worst = worst_tile(body, &turn, &planes, worst);
    }
    worst
}

/// The larger ones of what is given and of how far a lattice is from single boxes: the part of a
/// box, the moment over the radius, and the sum over all boxes from the volume.
fn worst_tile(
    body: &dyn Geometry,
    turn: &Rotation3<f64>,
    planes: &[Vec<f64>; 3],
    mut worst: [f64; 3],
) -> [f64; 3] {
    let (mut tiles, mut sum) = (Vec::new(), 0.0);
    assert!(body.tile(1.0, turn, planes, &mut |tile| tiles.push(*tile)));
    let mut rest = tiles.iter().peekable();
    let count = planes.each_ref().map(|planes| planes.len() - 1);
    for number in 0..count.iter().product() {
        let at = [number % count[0], number / count[0] % count[1], number / count[0] / count[1]];
        let end = |n: usize| Vector3::from_fn(|a, _| planes[a][at[a] + n]);
        let (low, high) = (end(0), end(1));
        let edges = [0, 1, 2].map(|a| {
            turn.inverse_transform_vector(&(0.5 * (high[a] - low[a]) * Vector3::ith(a, 1.0)))
        });
        let middle = turn.inverse_transform_vector(&(0.5 * (low + high)));
        let (volume, first) = body.filled(&middle, &edges);
        let whole: f64 = (0..body.dimension()).map(|a| high[a] - low[a]).product();
        let (part, moment) = match rest.next_if(|tile| tile.at == at) {
            Some(tile) => (tile.part, tile.moment),
            None => (0.0, Vector3::zeros()),
        };
        sum += part * whole;
        let moment = (moment - turn * (first / whole)).norm() / body.radius();
        worst = [worst[0].max((part - volume / whole).abs()), worst[1].max(moment), worst[2]];
    }
    assert!(rest.next().is_none(), "a box comes out of order");
    worst[2] = worst[2].max((sum / body.volume() - 1.0).abs());
    worst
}
