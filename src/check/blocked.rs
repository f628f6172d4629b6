//! Whether bodies shut a channel that is driven: then what flows goes through the rests of cells that they share, which means nothing.
//!
//! ```text
//!   a cell is open where bodies cover less than half of it; from all open ones at one end of the axis, over sides of cells, to the other:
//!   # # # # #
//!   . . o o .     open          . . o o .     shut
//!   . o o . .                   . o o o .
//!   # # # # #                   # # # # #
//! ```

use crate::config::{Case, Drive};
use crate::scene::Scene;

/// The axes along which the fluid of a case is driven.
pub fn driven_axes(case: &Case) -> Vec<usize> {
    let periodic = |axis: &usize| case.periodic(*axis);
    let axes = (0..case.dimension()).filter(periodic);
    match &case.drive {
        None | Some(Drive::HoldMixture) => Vec::new(),
        Some(Drive::Force(force)) => axes.filter(|axis| force[*axis] != 0.0).collect(),
        Some(Drive::Gravity) => axes.filter(|axis| case.fluid.gravity[*axis] != 0.0).collect(),
        Some(Drive::MeanVelocity(held)) => vec![held.axis.index()],
    }
}

/// Whether no open way leads from one end of the box to the other along an axis, as the bodies lie. For one rank, which has all cells.
pub fn blocked<const D: usize>(scene: &Scene<D>, axis: usize) -> bool {
    let grid = &scene.domain.grid;
    let mut covered = grid.field();
    scene.method.with_body_overlaps(|_, overlaps| overlaps.iter().for_each(|o| covered[o.cell] += o.fraction));
    let open = |at: [usize; D]| grid.owned_index(at).is_some_and(|c| covered[c] < 0.5);
    let number = |at: [usize; D]| (0..D).rev().fold(0, |n, a| n * grid.cells[a] + at[a]);
    let mut seen = vec![false; grid.total_cells()];
    let mut ways: Vec<[usize; D]> = grid.rows().flatten().map(|c| grid.global_cell(c)).collect();
    ways.retain(|at| at[axis] == 0 && open(*at));
    ways.iter().for_each(|at| seen[number(*at)] = true);
    while let Some(at) = ways.pop() {
        if at[axis] + 1 == grid.cells[axis] {
            return false;
        }
        for (a, forth) in (0..D).flat_map(|a| [(a, true), (a, false)]) {
            let (n, wraps) = (grid.cells[a], grid.periodic[a] && a != axis);
            let to = match (at[a], forth) {
                (0, false) if wraps => n - 1,
                (i, true) if i + 1 == n && wraps => 0,
                (0, false) => continue,
                (i, true) if i + 1 == n => continue,
                (i, true) => i + 1,
                (i, false) => i - 1,
            };
            let mut next = at;
            next[a] = to;
            if open(next) && !std::mem::replace(&mut seen[number(next)], true) {
                ways.push(next);
            }
        }
    }
    true
}
