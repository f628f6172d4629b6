//! Volume fractions: how much of a cell a particle fills, the alpha of eq. (1): exact, or, of
//! discs, the paper's polygon through the crossings of circle and cell, whose missing area is
//! spread over the cut cells.

use super::block::{Block, images};
use super::{Disc, Placed, Pose};
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

    /// Whether the particle fills more than half of the cell: its middle is inside, and the
    /// velocity there is not the fluid's.
    pub fn is_inside(&self) -> bool {
        self.fraction > 0.5
    }
}

/// Method for the fractions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// The exact overlap.
    Exact,
    /// Polygons of discs, with their missing area spread over the cut cells; exact of discs up to
    /// two cells across, and of other shapes.
    Polygon,
}

/// Fills `overlaps` with the owned cells that a particle (or one of its periodic images) touches.
pub fn overlaps<const D: usize>(
    grid: &Grid<D>,
    body: &Placed,
    rule: Rule,
    planes: &mut [Vec<f64>; 3],
    overlaps: &mut Vec<Overlap>,
) {
    let shape = body.shape;
    overlaps.clear();
    // No polygon through crossings of the grid lines is left of a disc that fits between them.
    let small = grid.h.iter().any(|h| 2.0 * shape.radius() <= 2.0 * h);
    let is_disc = shape.dimension() == 2 && shape.is_round();
    let disc =
        (rule == Rule::Polygon && is_disc && !small).then(|| Disc { radius: shape.radius() });
    for centre in images(grid, shape, &body.pose.place) {
        match &disc {
            None => {
                let pose = Pose { place: centre, ..body.pose };
                collect(grid, &Placed { shape, pose }, planes, overlaps);
            }
            Some(disc) => collect_polygons(grid, disc, &centre, overlaps),
        }
    }
    if let Some(disc) = disc {
        let exact = |o: &Overlap| disc.area_in(&o.arm, &half(grid)) / grid.cell_volume();
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

/// Below this, rounding of the exact overlaps, a cell is not touched.
const LEAST: f64 = 1e-12;

/// Adds the cells of this rank that one image touches.
fn collect<const D: usize>(
    grid: &Grid<D>,
    body: &Placed,
    planes: &mut [Vec<f64>; 3],
    out: &mut Vec<Overlap>,
) {
    let centre = &body.pose.place;
    let block = Block::owned(grid, centre, &body.turned().bounds());
    let place = |a: usize, n: usize| n as f64 * grid.h[a] - centre[a];
    let Some(first) = block.set_planes(planes, place) else { return };
    body.turned().tile(planes, None, &mut |filled| {
        let fraction = filled.part.clamp(0.0, 1.0);
        let at = std::array::from_fn(|a| first[a] + filled.at[a]);
        if let (true, Some(cell)) = (fraction > LEAST, grid.owned_index(at)) {
            out.push(Overlap { cell, fraction, arm: filled.middle });
        }
    });
}

/// Adds the cells that one image touches, with their polygons: this rank's and, since the missing
/// area is spread over all of a particle's cells, those of other ranks as [`ELSEWHERE`].
fn collect_polygons<const D: usize>(
    grid: &Grid<D>,
    disc: &Disc,
    centre: &Vector3<f64>,
    out: &mut Vec<Overlap>,
) {
    let radius = disc.radius;
    let cell =
        |sign: f64| std::array::from_fn(|a| ((centre[a] + sign * radius) / grid.h[a]).floor());
    let half = half(grid);
    for cell in Block::between(cell(-1.0), cell(1.0), [0; D], grid.cells) {
        let mut arm = Vector3::zeros();
        for a in 0..D {
            arm[a] = (cell[a] as f64 + 0.5) * grid.h[a] - centre[a];
        }
        let whole: f64 = (0..D).map(|a| 2.0 * half[a]).product();
        let polygon = || (disc.polygon_in(&arm, &half) / whole).clamp(0.0, 1.0);
        let fraction = whole_or_nothing(&arm, &half, radius).unwrap_or_else(polygon);
        if fraction > LEAST {
            out.push(Overlap { cell: grid.owned_index(cell).unwrap_or(ELSEWHERE), fraction, arm });
        }
    }
}

/// Whether all (1) or nothing (0) of a box lies inside of a disc of this radius (m).
fn whole_or_nothing(middle: &Vector3<f64>, half: &Vector3<f64>, radius: f64) -> Option<f64> {
    if (middle.abs() + half).norm() <= radius {
        return Some(1.0);
    }
    ((middle.abs() - half).map(|x| x.max(0.0)).norm() >= radius).then_some(0.0)
}

/// Half edges of a cell (m).
fn half<const D: usize>(grid: &Grid<D>) -> Vector3<f64> {
    Vector3::from_fn(|a, _| if a < D { 0.5 * grid.h[a] } else { 0.0 })
}

/// Cells that a particle of `radius` (m) may touch, for reserving room once.
pub fn most_cells<const D: usize>(grid: &Grid<D>, radius: f64) -> usize {
    cells_within(grid, radius, (D as f64).sqrt())
}

/// Cells that may have their middle within a `radius` (m), for reserving room once.
pub fn most_middles<const D: usize>(grid: &Grid<D>, radius: f64) -> usize {
    cells_within(grid, radius, 0.5 * (D as f64).sqrt())
}

/// Cells in the volume of a ball that is `wider` than `radius` (m) by so many spacings, and no more
/// than its box has.
fn cells_within<const D: usize>(grid: &Grid<D>, radius: f64, wider: f64) -> usize {
    // A body nearly as long as a period meets its first cells again at its other end.
    let most = |a: usize| ((2.0 * radius / grid.h[a]) as usize + 2).min(grid.cells[a] + 2);
    let unit = if D == 2 { PI } else { 4.0 / 3.0 * PI };
    let ball = (0..D).fold(unit, |volume, a| volume * (radius / grid.h[a] + wider));
    (0..D).map(most).product::<usize>().min(ball.ceil() as usize)
}
