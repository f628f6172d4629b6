//! Whether bodies shut a channel: the flow then goes through the rests of cells that they leave
//! open, which means nothing.
//!
//! ```text
//!   a cell is open where its centre lies in no body; from all open ones at one end,
//!                 over sides of cells, to the other:
//!   # # # # #
//!   . . o o .     open          . . o o .     shut
//!   . o o . .                   . o o o .
//!   # # # # #                   # # # # #
//! ```

use crate::Result;
use crate::config::{AXES, Case, Drive, Loaded, Side};
use crate::grid::Grid;
use crate::particles::{Body, Motion, nearest_image};
use crate::scene::Scene;
use nalgebra::Vector3;

/// A driven channel that bodies shut, or a way from an inflow to the outflows.
pub fn shut<const D: usize>(case: &Case, scene: &Scene<D>) -> Option<String> {
    let grid = &scene.domain.grid;
    let bodies = &scene.state.bodies;
    let way = find_shut(case, grid, bodies, |_| true)?;
    Some(format!(
        "warning      the bodies shut the channel {way}, as far as this grid shows gaps between \
        them: what is driven through it has no meaning; open it, or use more cells"
    ))
}

/// Refuses a channel that fixed bodies shut between an inflow and the outflows.
///
/// # Errors
/// With the side through which fluid comes in and has no way out.
pub fn refuse_shut<const D: usize>(loaded: &Loaded, scene: &Scene<D>) -> Result<()> {
    let case = &loaded.case;
    let grid = &scene.domain.grid;
    let bodies = &scene.state.bodies;
    let fixed = |body: &Body| matches!(body.motion, Motion::Fixed);
    let enters = case.sides().any(|(_, side)| !side.inflow().is_empty());
    let way = if enters { find_shut(case, grid, bodies, fixed) } else { None };
    way.map_or(Ok(()), |way| {
        Err(loaded.error_at(
            if case.particle.is_empty() { "obstacle" } else { "particle" },
            format!(
                "the fixed bodies shut the channel {way}, as far as this grid shows gaps \
                between them: what comes in cannot leave; open a way, or use more cells"
            ),
        ))
    })
}

/// The way that some of the bodies shut, in words.
fn find_shut<const D: usize>(
    case: &Case,
    grid: &Grid<D>,
    bodies: &[Body],
    wanted: impl Fn(&Body) -> bool,
) -> Option<String> {
    // Sides through which a given velocity leaves count as outflows.
    let sides: Vec<_> = case
        .sides()
        .enumerate()
        .map(|(n, (name, side))| (n, name, side, side.flux(n, &case.domain)))
        .collect();
    let out: Vec<usize> = sides
        .iter()
        .filter(|(_, _, side, flux)| **side == Side::Outflow || *flux < 0.0)
        .map(|side| side.0)
        .collect();
    let ends =
        |at: &[usize; D], side: usize| at[side / 2] == [0, grid.cells[side / 2] - 1][side % 2];
    let entered = sides.iter().filter(|(_, _, _, flux)| *flux > 0.0);
    let mut ways: Vec<(Way, String)> = driven_axes(case)
        .into_iter()
        .map(|a| (Way::Along(a), format!("along {}", AXES[a])))
        .collect();
    ways.extend(
        entered.map(|(n, name, ..)| (Way::From(*n), format!("between {name} and the outflow"))),
    );
    if bodies.is_empty() || ways.is_empty() {
        return None;
    }
    let solid = mark_solid(grid, bodies.iter().filter(|body| wanted(body)));
    let shut = ways.into_iter().find(|(way, _)| match way {
        Way::Along(axis) => {
            let first = |at: &[usize; D]| at[*axis] == 0;
            let last = |at: &[usize; D]| at[*axis] + 1 == grid.cells[*axis];
            !connected(grid, &solid, Some(*axis), first, last)
        }
        Way::From(side) => {
            let leaves = |at: &[usize; D]| out.iter().any(|side| ends(at, *side));
            !connected(grid, &solid, None, |at| ends(at, *side), leaves)
        }
    });
    shut.map(|(_, words)| words)
}

/// A way that has to be open.
enum Way {
    /// From one end of a driven axis to the other.
    Along(usize),
    /// From the side of this number to the outflows.
    From(usize),
}

/// The axes along which the fluid of a case is driven.
fn driven_axes(case: &Case) -> Vec<usize> {
    match &case.drive {
        None => Vec::new(),
        Some(Drive::MeanVelocity(held)) => vec![held.axis.index()],
        Some(drive) => {
            let push = drive.push(case).unwrap_or_default();
            (0..3).filter(|axis| push[*axis] != 0.0).collect()
        }
    }
}

/// Number of a cell of the whole grid.
fn number<const D: usize>(grid: &Grid<D>, at: &[usize; D]) -> usize {
    (0..D).rev().fold(0, |n, a| n * grid.cells[a] + at[a])
}

/// The cells of the whole grid whose centre lies in a body: every rank finds the same.
fn mark_solid<'a, const D: usize>(
    grid: &Grid<D>,
    bodies: impl Iterator<Item = &'a Body>,
) -> Vec<bool> {
    let mut solid = vec![false; grid.total_cells()];
    let periods = std::array::from_fn(|a| (a < D && grid.periodic[a]).then(|| grid.size[a]));
    for body in bodies {
        let orientation = body.orientation();
        let shape = body.shape().turned(&orientation);
        let ends: [[i64; 2]; D] = std::array::from_fn(|a| {
            [-1.0, 1.0]
                .map(|side| ((body.centre[a] + side * body.radius()) / grid.h[a]).floor() as i64)
        });
        let mut at: [i64; D] = ends.map(|[low, _]| low);
        loop {
            let cell: [usize; D] =
                std::array::from_fn(|a| at[a].rem_euclid(grid.cells[a] as i64) as usize);
            let inside =
                (0..D).all(|a| grid.periodic[a] || (0..grid.cells[a] as i64).contains(&at[a]));
            let centre = Vector3::from_fn(|a, _| {
                if a < D { (cell[a] as f64 + 0.5) * grid.h[a] } else { body.centre[a] }
            });
            let arm = nearest_image(&body.centre, &centre, &periods);
            if inside && shape.distance(&arm) < 0.0 {
                solid[number(grid, &cell)] = true;
            }
            let Some(axis) = (0..D).find(|&a| at[a] < ends[a][1]) else { break };
            at[axis] += 1;
            (0..axis).for_each(|a| at[a] = ends[a][0]);
        }
    }
    solid
}

/// Whether a way over sides of open cells leads from the ones to the others, not across the
/// ends of the axis `kept`.
fn connected<const D: usize>(
    grid: &Grid<D>,
    solid: &[bool],
    kept: Option<usize>,
    first: impl Fn(&[usize; D]) -> bool,
    last: impl Fn(&[usize; D]) -> bool,
) -> bool {
    let mut seen = solid.to_vec();
    let cells = |n: usize| {
        let mut rest = n;
        std::array::from_fn(|a| {
            let at = rest % grid.cells[a];
            rest /= grid.cells[a];
            at
        })
    };
    let mut ways: Vec<[usize; D]> = (0..seen.len()).map(cells).filter(|at| first(at)).collect();
    ways.retain(|at| !std::mem::replace(&mut seen[number(grid, at)], true));
    while let Some(at) = ways.pop() {
        if last(&at) {
            return true;
        }
        for (a, forth) in (0..D).flat_map(|a| [(a, true), (a, false)]) {
            let n = grid.cells[a];
            let wraps = grid.periodic[a] && Some(a) != kept;
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
            if !std::mem::replace(&mut seen[number(grid, &next)], true) {
                ways.push(next);
            }
        }
    }
    false
}
