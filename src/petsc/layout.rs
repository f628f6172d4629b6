//! The decomposition of the grid over ranks: a DMDA decides it, plain numbers carry it.

use super::{Session, failure::check};
use crate::{Error, Result};
use petsc_sys as ffi;
use std::{ptr, slice};

/// Which cells this rank owns, who its neighbours are, and PETSc's number of every cell within its
/// ghosted box.
///
/// Boxes are stored with layers of ghosts on every side of every axis in use, x fastest.
#[derive(Clone, Debug)]
pub struct Layout {
    /// First owned cell along each axis.
    pub start: [usize; 3],
    /// Owned cells along each axis (1 along z in 2D).
    pub local: [usize; 3],
    /// Stored cells along each axis, ghosts included (1 along z in 2D).
    pub stored: [usize; 3],
    /// Layers of ghosts.
    pub ghosts: usize,
    /// Ranks along each axis (1 along z in 2D), numbered x fastest.
    pub ranks: [usize; 3],
    /// The rank below and above along each axis, where there is one (itself, where it closes a
    /// period alone).
    pub neighbours: [[Option<usize>; 2]; 3],
    /// PETSc's global number of each stored cell, -1 outside the domain.
    pub numbers: Vec<i32>,
    /// Cells of the whole grid along each axis, and whether that closes a period.
    pub whole: Vec<(usize, bool)>,
}

/// Work of the heaviest rank over the mean of all, by the number of ranks along each axis.
pub type Imbalance<'a> = &'a dyn Fn([usize; 3]) -> f64;

/// Part of the mean work by which the heaviest rank of a split may exceed that of the most even one
/// where that has fewer faces between ranks.
const EVEN: f64 = 0.05;

/// The grid as PETSc knows it, cell-centred and divided over the ranks as the layout is: from it
/// preconditioners make coarser grids.
pub(super) struct CellGrid {
    pub dm: ffi::DM,
}

impl Drop for CellGrid {
    fn drop(&mut self) {
        // SAFETY: null or ours, destroyed once; a solver that holds it has its own reference.
        unsafe { ffi::DMDestroy(&mut self.dm) };
    }
}

impl Layout {
    /// Splits `cells` (two or three axes) over the session's ranks, with so many layers of
    /// `ghosts`.
    ///
    /// # Errors
    /// When there are more ranks than the grid can feed: each needs `ghosts` cells along every
    /// axis.
    pub fn new(
        session: &Session,
        cells: &[usize],
        periodic: &[bool],
        ghosts: usize,
    ) -> Result<Layout> {
        Layout::balanced(session, cells, periodic, ghosts, &|_| 1.0)
    }

    /// Splits as [`Layout::new`] does, by the work of the heaviest rank as `imbalance` tells it.
    ///
    /// # Errors
    /// As [`Layout::new`].
    pub fn balanced(
        session: &Session,
        cells: &[usize],
        periodic: &[bool],
        ghosts: usize,
        imbalance: Imbalance,
    ) -> Result<Layout> {
        let ranks = split(session.size(), cells, ghosts, imbalance)
            .ok_or_else(|| too_many_ranks(session.size(), cells, ghosts))?;
        let mut da = make_da(
            session,
            cells,
            periodic,
            ranks,
            ghosts,
            ffi::DM_BOUNDARY_GHOSTED,
            ffi::DMDA_STENCIL_BOX,
        )?;
        // SAFETY: `da` is a DMDA just made; on failure it is still ours to destroy.
        let read = check("DMSetUp", unsafe { ffi::DMSetUp(da) })
            .and_then(|()| Self::read(da, cells, periodic, ranks, ghosts));
        // SAFETY: destroyed once.
        check("DMDestroy", unsafe { ffi::DMDestroy(&mut da) })?;
        read
    }

    /// The grid with the layout's division, for preconditioners that coarsen it. Collective.
    pub(super) fn cell_grid(&self, session: &Session) -> Result<CellGrid> {
        let (cells, periodic): (Vec<_>, Vec<_>) = self.whole.iter().copied().unzip();
        let dm = make_da(
            session,
            &cells,
            &periodic,
            self.ranks,
            1,
            ffi::DM_BOUNDARY_NONE,
            ffi::DMDA_STENCIL_BOX,
        )?;
        let grid = CellGrid { dm };
        // SAFETY: a DMDA just made, owned by `grid`.
        unsafe {
            let q0 = ffi::DMDA_Q0;
            check("DMDASetInterpolationType", ffi::DMDASetInterpolationType(grid.dm, q0))?;
            check("DMSetUp", ffi::DMSetUp(grid.dm))?;
        }
        Ok(grid)
    }

    /// The grid as a box of three dimensions, of one layer where there are two. Collective.
    pub(super) fn box_grid(&self, session: &Session) -> Result<CellGrid> {
        let (cells, _): (Vec<_>, Vec<_>) = self.whole.iter().copied().unzip();
        let in_space = [cells[0], cells[1], cells.get(2).copied().unwrap_or(1)];
        let kind = ffi::DM_BOUNDARY_NONE;
        let form = ffi::DMDA_STENCIL_STAR;
        let dm = make_da(session, &in_space, &[false; 3], self.ranks, 1, kind, form)?;
        let grid = CellGrid { dm };
        // SAFETY: a DMDA just made, owned by `grid`.
        check("DMSetUp", unsafe { ffi::DMSetUp(grid.dm) })?;
        Ok(grid)
    }

    /// Number of axes.
    pub fn dimension(&self) -> usize {
        self.whole.len()
    }

    /// Number of times that all axes can be halved, down to two cells.
    pub(super) fn halvings(&self) -> usize {
        let of = |n: usize| (1..).take_while(|k| n.is_multiple_of(1 << k) && n >> k >= 2).count();
        self.whole.iter().map(|(cells, _)| of(*cells)).min().unwrap_or(0)
    }

    fn read(
        da: ffi::DM,
        cells: &[usize],
        periodic: &[bool],
        ranks_along: [usize; 3],
        ghosts: usize,
    ) -> Result<Layout> {
        let dimension = cells.len();
        let mut s = [0i32; 3];
        let mut n = [1i32; 3];
        let mut ranks = ptr::null();
        let mut map = ptr::null_mut();
        let mut indices = ptr::null();
        let mut neighbours = [[None; 2]; 3];
        let mut numbers = Vec::new();
        let stored = |n: [i32; 3]| {
            std::array::from_fn(|a| n[a] as usize + if a < dimension { 2 * ghosts } else { 0 })
        };
        // SAFETY: a set-up DMDA fills each pointer with memory that it owns; all of it is copied
        // before it goes. It has 3^dimension neighbours (itself in the middle), and one number for
        // every stored cell.
        unsafe {
            let [s0, s1, s2] = &mut s;
            let [n0, n1, n2] = &mut n;
            check("DMDAGetCorners", ffi::DMDAGetCorners(da, s0, s1, s2, n0, n1, n2))?;
            check("DMDAGetNeighbors", ffi::DMDAGetNeighbors(da, &mut ranks))?;
            let around = 3usize.pow(dimension as u32);
            let ranks = slice::from_raw_parts(ranks, around);
            for (a, pair) in neighbours.iter_mut().enumerate().take(dimension) {
                let step = 3usize.pow(a as u32);
                *pair =
                    [around / 2 - step, around / 2 + step].map(|k| usize::try_from(ranks[k]).ok());
            }
            check("DMGetLocalToGlobalMapping", ffi::DMGetLocalToGlobalMapping(da, &mut map))?;
            check(
                "ISLocalToGlobalMappingGetIndices",
                ffi::ISLocalToGlobalMappingGetIndices(map, &mut indices),
            )?;
            let count: usize = stored(n).iter().product();
            numbers.extend_from_slice(slice::from_raw_parts(indices, count));
            check(
                "ISLocalToGlobalMappingRestoreIndices",
                ffi::ISLocalToGlobalMappingRestoreIndices(map, &mut indices),
            )?;
        }
        Ok(Layout {
            start: s.map(|v| v as usize),
            local: n.map(|v| v as usize),
            stored: stored(n),
            ghosts,
            ranks: ranks_along,
            neighbours,
            numbers,
            whole: cells.iter().copied().zip(periodic.iter().copied()).collect(),
        })
    }
}

/// A DMDA over so many ranks along each axis, with so many layers of ghosts, and with `boundary`
/// where an axis closes no period; the caller's to destroy.
fn make_da(
    session: &Session,
    cells: &[usize],
    periodic: &[bool],
    ranks: [usize; 3],
    ghosts: usize,
    boundary: ffi::DMBoundaryType,
    stencil: ffi::DMDAStencilType,
) -> Result<ffi::DM> {
    let kind = |a: usize| match periodic[a] {
        true => ffi::DM_BOUNDARY_PERIODIC,
        false => boundary,
    };
    let n = |a: usize| cells[a] as i32;
    let [along_x, along_y, along_z] = ranks.map(|r| r as i32);
    let width = ghosts as i32;
    let comm = session.comm();
    let none = ptr::null();
    let mut da: ffi::DM = ptr::null_mut();
    // SAFETY: plain numbers, no ownership ranges (null), one output handle.
    #[rustfmt::skip]
    let made = unsafe {
        if cells.len() == 3 {
            ffi::DMDACreate3d(
                comm, kind(0), kind(1), kind(2), stencil, n(0), n(1), n(2),
                along_x, along_y, along_z, 1, width, none, none, none, &mut da,
            )
        } else {
            ffi::DMDACreate2d(
                comm, kind(0), kind(1), stencil, n(0), n(1),
                along_x, along_y, 1, width, none, none, &mut da,
            )
        }
    };
    check("DMDACreate", made)?;
    Ok(da)
}

/// Ranks along each axis: every rank has `ghosts` cells along every axis, the heaviest rank is as
/// light as possible, and among splits that are equal in that the faces between ranks are fewest;
/// rows along x stay whole where that costs nothing. `None` where no split gives every rank its
/// cells.
fn split(ranks: usize, cells: &[usize], ghosts: usize, imbalance: Imbalance) -> Option<[usize; 3]> {
    let divisors = |n: usize| (1..=n).filter(move |d| n.is_multiple_of(*d));
    let cells = |a: usize| cells.get(a).copied();
    let fits = |along: &[usize; 3]| {
        (0..3).all(|a| cells(a).map_or(along[a] == 1, |n| n / along[a] >= ghosts))
    };
    // Faces between ranks, up to the same factor for all splits.
    let faces = |along: &[usize; 3]| -> f64 {
        (0..3)
            .map(|a| {
                (along[a] - 1) as f64 / cells(a).unwrap_or(1) as f64
                    * if a == 0 { 1.0 + 1e-9 } else { 1.0 }
            })
            .sum()
    };
    let splits =
        divisors(ranks).flat_map(|x| divisors(ranks / x).map(move |y| [x, y, ranks / x / y]));
    let uneven: Vec<_> = splits.filter(fits).map(|along| (imbalance(along), along)).collect();
    let least = uneven.iter().fold(f64::INFINITY, |least, (heaviest, _)| least.min(*heaviest));
    let even = uneven.into_iter().filter(|(heaviest, _)| *heaviest <= least + EVEN);
    even.map(|(_, along)| along).min_by(|a, b| faces(a).total_cmp(&faces(b)))
}

fn too_many_ranks(ranks: usize, cells: &[usize], ghosts: usize) -> Error {
    let grid = cells.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
    Error::Usage(format!(
        "{ranks} ranks are too many for a grid of {grid} cells, or do not divide it: each rank \
        needs a box of {ghosts} cells along every axis; use fewer ranks (mpirun -n) or more cells \
        (domain.cells)"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subdomains_have_equal_cells_and_fewest_faces() {
        assert_eq!(split(1, &[160, 64], 3, &|_| 1.0), Some([1, 1, 1]));
        assert_eq!(split(2, &[160, 64], 3, &|_| 1.0), Some([2, 1, 1]));
        assert_eq!(split(4, &[64, 64], 3, &|_| 1.0), Some([2, 2, 1]));
        assert_eq!(split(2, &[64, 64], 3, &|_| 1.0), Some([1, 2, 1]));
        assert_eq!(split(7, &[20, 21], 3, &|_| 1.0), Some([1, 7, 1]));
        assert_eq!(split(8, &[40, 40, 40], 3, &|_| 1.0), Some([2, 2, 2]));
        assert_eq!(split(3, &[8, 8], 3, &|_| 1.0), None);
        assert_eq!(split(7, &[20, 20], 3, &|_| 1.0), None);
    }

    #[test]
    fn split_has_least_heaviest_rank_and_then_fewest_faces() {
        let across_y =
            |more: f64| move |along: [usize; 3]| if along[1] > 1 { 1.0 + more } else { 1.0 };
        assert_eq!(split(4, &[64, 64], 3, &across_y(0.04)), Some([2, 2, 1]));
        assert_eq!(split(4, &[64, 64], 3, &across_y(0.5)), Some([4, 1, 1]));
        assert_eq!(split(4, &[8, 64], 3, &across_y(0.5)), Some([1, 4, 1]));
    }
}
