//! Volume fractions: how much of a cell a particle fills, the alpha of eq. (1).
//!
//! Exact in 2D by inclusion and exclusion of quadrants,
//! ```text
//!   +------+ (x1, y1)      overlap = Q(x1, y1) - Q(x0, y1) - Q(x1, y0) + Q(x0, y0)
//!   |   ,--|               Q(x, y) = area of the disc where X < x and Y < y
//!   +--/---+
//! ```
//! or the paper's polygon through the crossings of circle and cell, whose missing area is spread over the cut cells.
//! Spheres: slices of exact area, in `sphere.rs`.

use super::reach::{Block, images};
use super::sphere;
use crate::grid::Grid;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// A cell that a particle touches.
#[derive(Clone, Debug)]
pub struct Overlap {
    /// The cell's index in a field.
    pub cell: usize,
    /// Fraction of the cell's volume inside the particle, within (0, 1].
    pub fraction: f64,
    /// From the particle's centre (its nearest image) to the cell's (m).
    pub arm: Vector3<f64>,
}

impl Overlap {
    /// Whether the particle's boundary passes through the cell.
    pub fn is_cut(&self) -> bool {
        self.fraction < 1.0
    }
}

/// How fractions are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// The exact overlap.
    Exact,
    /// Polygons with their missing area spread over the cut cells (2D); of discs up to two cells across, exact.
    Polygon,
}

/// Fills `overlaps` with the owned cells that a particle (or one of its periodic images) touches.
pub fn overlaps<const D: usize>(
    grid: &Grid<D>,
    centre: &Vector3<f64>,
    radius: f64,
    rule: Rule,
    overlaps: &mut Vec<Overlap>,
) {
    overlaps.clear();
    // No polygon through crossings of the grid lines is left of a disc that fits between them.
    let small = grid.h.iter().any(|h| 2.0 * radius <= 2.0 * h);
    let rule = if small { Rule::Exact } else { rule };
    images(grid, centre).for_each(|image| collect(grid, &image, radius, rule, overlaps));
    if rule == Rule::Polygon {
        let exact = |o: &Overlap| disc_overlap(&o.arm, grid, radius) / grid.cell_volume();
        let missing: f64 = overlaps.iter().map(|o| exact(o) - o.fraction).sum();
        let weight = |o: &Overlap| o.fraction * (1.0 - o.fraction);
        let total: f64 = overlaps.iter().map(weight).sum();
        if total > 0.0 {
            for o in overlaps.iter_mut() {
                o.fraction = (o.fraction + missing * weight(o) / total).min(1.0);
            }
        }
        overlaps.retain(|o| o.cell != ELSEWHERE);
    }
}

/// Stands for a cell of another rank.
const ELSEWHERE: usize = usize::MAX;

/// Adds the cells that one image touches: this rank's, and for the polygon, whose missing area is spread over all of a
/// particle's cells, those of other ranks as [`ELSEWHERE`].
fn collect<const D: usize>(grid: &Grid<D>, centre: &Vector3<f64>, radius: f64, rule: Rule, out: &mut Vec<Overlap>) {
    let cells = match rule {
        Rule::Exact => Block::owned(grid, centre, radius),
        Rule::Polygon => {
            let cell = |sign: f64| std::array::from_fn(|a| ((centre[a] + sign * radius) / grid.h[a]).floor());
            Block::between(cell(-1.0), cell(1.0), [0; D], grid.cells)
        }
    };
    let half = Vector3::from_fn(|a, _| if a < D { 0.5 * grid.h[a] } else { 0.0 });
    for cell in cells {
        let mut arm = Vector3::zeros();
        for a in 0..D {
            arm[a] = (cell[a] as f64 + 0.5) * grid.h[a] - centre[a];
        }
        let fraction = match rule {
            Rule::Exact => box_fraction::<D>(&arm, &half, radius),
            Rule::Polygon => whole_or_nothing(&arm, &half, radius)
                .unwrap_or_else(|| (polygon_overlap(&arm, grid, radius) / grid.cell_volume()).clamp(0.0, 1.0)),
        };
        // Below rounding of the quadrants a cell is not touched.
        if fraction > 1e-12 {
            let cell = grid.owned_index(cell).unwrap_or(ELSEWHERE);
            out.push(Overlap { cell, fraction, arm });
        }
    }
}

/// Whether all (1) or nothing (0) of the box with its centre at `arm` (m, from the particle's) and the `half` edges (m) lies inside
/// the particle; `None` where its surface passes.
pub fn whole_or_nothing(arm: &Vector3<f64>, half: &Vector3<f64>, radius: f64) -> Option<f64> {
    if (arm.abs() + half).norm() <= radius {
        return Some(1.0);
    }
    ((arm.abs() - half).map(|x| x.max(0.0)).norm() >= radius).then_some(0.0)
}

/// Fraction of the box with its centre at `arm` (m, from the particle's) and the `half` edges (m) that the particle fills.
pub fn box_fraction<const D: usize>(arm: &Vector3<f64>, half: &Vector3<f64>, radius: f64) -> f64 {
    if let Some(fraction) = whole_or_nothing(arm, half, radius) {
        return fraction;
    }
    let (low, high) = (arm - half, arm + half);
    let filled = if D == 3 {
        sphere::box_overlap(&low, &high, radius)
    } else {
        rectangle_overlap([low.x, high.x], [low.y, high.y], radius)
    };
    (filled / (0..D).map(|a| 2.0 * half[a]).product::<f64>()).clamp(0.0, 1.0)
}

fn disc_overlap<const D: usize>(arm: &Vector3<f64>, grid: &Grid<D>, radius: f64) -> f64 {
    let (hx, hy) = (0.5 * grid.h[0], 0.5 * grid.h[1]);
    rectangle_overlap([arm.x - hx, arm.x + hx], [arm.y - hy, arm.y + hy], radius)
}

/// Area of the disc of `radius` at the origin inside the rectangle `x` by `y` (m2).
pub fn rectangle_overlap(x: [f64; 2], y: [f64; 2], radius: f64) -> f64 {
    // Where no arc passes there is nothing to find: most slices of a sphere.
    let far = |edges: [f64; 2]| edges[0].abs().max(edges[1].abs());
    let near = |edges: [f64; 2]| edges[0].max(-edges[1]).max(0.0);
    let square = |f: &dyn Fn([f64; 2]) -> f64| f(x) * f(x) + f(y) * f(y);
    if square(&far) <= radius * radius {
        return (x[1] - x[0]) * (y[1] - y[0]);
    }
    if square(&near) >= radius * radius {
        return 0.0;
    }
    let [half_x, half_y] = [x, y].map(|edges| edges.map(|edge| half_plane(edge, radius)));
    let q = |i: usize, j: usize| quadrant((x[i], half_x[i]), (y[j], half_y[j]), radius);
    (q(1, 1) - q(0, 1) - q(1, 0) + q(0, 0)).max(0.0)
}

/// Area of the disc where X < x.
fn half_plane(x: f64, r: f64) -> f64 {
    if x.abs() >= r {
        return if x > 0.0 { PI * r * r } else { 0.0 };
    }
    // Near the rim asin and r^2 - x^2 would lose half of the digits.
    let half_chord = ((r - x) * (r + x)).sqrt();
    r * r * (0.5 * PI + x.atan2(half_chord)) + x * half_chord
}

/// Area of the disc where X < x and Y < y; each with its half plane's.
fn quadrant((x, half_x): (f64, f64), (y, half_y): (f64, f64), r: f64) -> f64 {
    if x * x + y * y < r * r {
        return 0.5 * (half_x + half_y) + x * y - 0.25 * PI * r * r;
    }
    match (x >= 0.0, y >= 0.0) {
        (true, true) => half_x + half_y - PI * r * r,
        (false, true) => half_x,
        (true, false) => half_y,
        (false, false) => 0.0,
    }
}

/// Area of the polygon through the cell's corners inside the circle and the crossings of circle and edges (m2).
fn polygon_overlap<const D: usize>(arm: &Vector3<f64>, grid: &Grid<D>, r: f64) -> f64 {
    let (hx, hy) = (0.5 * grid.h[0], 0.5 * grid.h[1]);
    let corner = |k: usize| {
        let (sx, sy) = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)][k % 4];
        [arm.x + sx * hx, arm.y + sy * hy]
    };
    // Walking round the cell meets the vertices in order; an edge crosses the circle twice at most.
    let (mut vertices, mut n) = ([[0.0f64; 2]; 12], 0);
    let mut add = |v: [f64; 2]| {
        vertices[n] = v;
        n += 1;
    };
    for k in 0..4 {
        let (from, to) = (corner(k), corner(k + 1));
        if from[0].hypot(from[1]) < r {
            add(from);
        }
        let d = [to[0] - from[0], to[1] - from[1]];
        let (a, b) = (d[0] * d[0] + d[1] * d[1], from[0] * d[0] + from[1] * d[1]);
        let c = from[0] * from[0] + from[1] * from[1] - r * r;
        let under = b * b - a * c;
        if under > 0.0 {
            for t in [(-b - under.sqrt()) / a, (-b + under.sqrt()) / a] {
                if (0.0..1.0).contains(&t) {
                    add([from[0] + t * d[0], from[1] + t * d[1]]);
                }
            }
        }
    }
    let v = &vertices[..n];
    0.5 * (0..n).map(|k| v[k][0] * v[(k + 1) % n][1] - v[(k + 1) % n][0] * v[k][1]).sum::<f64>().max(0.0)
}

/// Cells that a particle of `radius` may touch, for reserving room once.
pub fn most_cells<const D: usize>(grid: &Grid<D>, radius: f64) -> usize {
    // A body nearly as long as a period meets its first cells again at its other end.
    (0..D).map(|a| ((2.0 * radius / grid.h[a]) as usize + 2).min(grid.cells[a] + 2)).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_around_the_disc_holds_all_of_it_and_its_quarters_a_quarter_each() {
        let r = 0.7;
        assert!((rectangle_overlap([-1.0, 1.0], [-1.0, 1.0], r) - PI * r * r).abs() < 1e-14);
        assert!((rectangle_overlap([0.0, 1.0], [-1.0, 0.0], r) - PI * r * r / 4.0).abs() < 1e-14);
        assert_eq!(rectangle_overlap([0.7, 1.0], [-1.0, 1.0], r), 0.0);
    }

    #[test]
    fn the_exact_overlap_agrees_with_counting_points() {
        let (x, y, r) = ([0.1, 0.75], [-0.2, 0.6], 0.8);
        let n = 2000;
        let at = |s: [f64; 2], k: usize| s[0] + (s[1] - s[0]) * (k as f64 + 0.5) / n as f64;
        let inside = (0..n * n).filter(|k| at(x, k % n).hypot(at(y, k / n)) < r).count();
        let counted = inside as f64 / (n * n) as f64 * (x[1] - x[0]) * (y[1] - y[0]);
        assert!((rectangle_overlap(x, y, r) - counted).abs() < 1e-5);
    }
}
