//! Tools that the tests of shapes share.

use super::{Lattice, Orientation, Shape, Tile};
use nalgebra::Vector3;

/// Numbers that look as drawn, in (-1, 1).
pub fn scatter(k: usize) -> f64 {
    (12.9898 * k as f64 + 4.1414).sin() * 43758.5453 % 1.0
}

/// Parts that a body fills of the boxes of a lattice about it, finer or coarser by the number `k`:
/// turned and shifted, or with planes through its centre.
pub fn with_tiles<T>(body: &dyn Shape, k: usize, then: impl FnOnce(&Lattice, &[Tile]) -> T) -> T {
    let two = body.dimension() == 2;
    let axis = Vector3::from_fn(|a, _| if two && a < 2 { 0.0 } else { 3.0 * scatter(9 * k + a) });
    let turn = Orientation::from_scaled_axis(if k.is_multiple_of(3) { 0.0 * axis } else { axis });
    let h = [0.07, 0.15, 0.4, 1.3][k % 4] * 2.0 * body.radius();
    let n = (1.2 * body.radius() / h) as i32 + 2;
    let shift = |a: usize| if k.is_multiple_of(5) { 0.0 } else { 0.5 * h * scatter(4 * k + a) };
    let mut planes = [0, 1, 2].map(|a| {
        let h = [1.0, 0.8, 1.1][a] * h;
        (-n..=n).map(|i| h * f64::from(i) + shift(a)).collect::<Vec<f64>>()
    });
    if two {
        planes[2] = vec![0.0; 2];
    }
    let lattice = Lattice { factor: 1.0, orientation: turn, planes: &planes, faces: None };
    let mut tiles = Vec::new();
    body.tile(&lattice, &mut |tile| tiles.push(*tile));
    then(&lattice, &tiles)
}

/// Differences of the sums over the boxes of lattices from the body's volume, and of their first
/// moments from zero: the worst, over the volume. The boxes come in their order.
pub fn lattice(body: &dyn Shape) -> (f64, f64) {
    let mut worst = (0.0f64, 0.0f64);
    let three = body.dimension() == 3;
    for k in 0..60 {
        let mut volume = 0.0;
        let mut first = Vector3::zeros();
        let mut last = None;
        with_tiles(body, k, |lattice, tiles| {
            for Tile { at, part, moment, .. } in tiles {
                let width = |a: usize| lattice.planes[a][at[a] + 1] - lattice.planes[a][at[a]];
                let whole = width(0) * width(1) * if three { width(2) } else { 1.0 };
                volume += whole * part;
                first += whole * moment;
                let order = Some([at[2], at[1], at[0]]);
                assert!(order > last, "a box comes out of order");
                last = order;
            }
        });
        worst.0 = worst.0.max((volume / body.volume() - 1.0).abs());
        worst.1 = worst.1.max(first.norm() / (body.volume() * body.radius()));
    }
    worst
}

/// Differences of the part of a box and its moment (of the radius) from those by points within, of
/// `n` along each axis: the worst over boxes of all lattices.
pub fn counted(body: &dyn Shape, n: usize) -> (f64, f64) {
    let mut worst = (0.0f64, 0.0f64);
    let three = body.dimension() == 3;
    let count = if three { n * n * n } else { n * n };
    for k in 0..60 {
        with_tiles(body, k, |lattice, tiles| {
            let boxes = lattice.planes.each_ref().map(|planes| planes.len() - 1);
            for i in 0..5 {
                let drawn = |a: usize| scatter(1000 + 15 * k + 3 * i + a).abs();
                let at = [0, 1, 2].map(|a| (drawn(a) * boxes[a] as f64) as usize);
                let (middle, half) = lattice.own_box(at);
                let mut part = 0.0;
                let mut first = Vector3::zeros();
                for point in 0..count {
                    let at = [point % n, point / n % n, if three { point / n / n } else { 0 }];
                    let way = |a: usize| ((2 * at[a] + 1) as f64 / n as f64 - 1.0) * half[a];
                    let x = middle + way(0) + way(1) + way(2);
                    if body.nearest(&x).distance < 0.0 {
                        part += 1.0;
                        first += x;
                    }
                }
                let found = tiles.iter().find(|tile| tile.at == at);
                let none = Tile::new(lattice.planes, at, 0.0, Vector3::zeros());
                let tile = found.copied().unwrap_or(none);
                let moment = lattice.orientation * first / count as f64;
                worst.0 = worst.0.max((tile.part - part / count as f64).abs());
                worst.1 = worst.1.max((tile.moment - moment).norm() / body.radius());
            }
        });
    }
    worst
}

/// The largest of the distances of the feet of nearest points from the surface, of points about a
/// body, by the distance itself; and whether the distance changes no faster than the place.
pub fn feet(body: &dyn Shape, reach: f64) -> f64 {
    let three = body.dimension() == 3;
    let mut worst = 0.0f64;
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
