//! Fields in an archive: boxes of cells in the whole grid's count, one a rank.
//!
//! ```text
//!   count of boxes;  of each:  start, extent along each axis,  values, x fastest
//! ```
//! A rank that finds its own box takes that, bit for bit, and else its part of each.

use super::{Archive, Checkpointed, Head, double, refusal};
use crate::grid::{Grid, Rows};
use crate::{Error, Result};

/// A box of cells, or of faces, in the whole grid's count.
#[derive(Clone, Copy, PartialEq)]
struct Cells<const D: usize> {
    start: [usize; D],
    extent: [usize; D],
}

impl<const D: usize> Cells<D> {
    fn end(&self, axis: usize) -> usize {
        self.start[axis] + self.extent[axis]
    }

    fn count(&self) -> usize {
        self.extent.iter().product()
    }

    fn meets(&self, other: &Cells<D>) -> bool {
        (0..D).all(|a| self.end(a) > other.start[a] && other.end(a) > self.start[a])
    }
}

impl Archive<'_> {
    /// Writes or reads the cells of fields.
    pub fn cells<const D: usize>(&mut self, grid: &Grid<D>, fields: &mut [Vec<f64>]) -> Result<()> {
        fields.iter_mut().try_for_each(|field| self.boxes(grid, grid.local, || grid.rows(), field))
    }

    /// Writes or reads a velocity through faces.
    pub fn faces<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        field: &mut [Vec<f64>; D],
    ) -> Result<()> {
        for (axis, field) in field.iter_mut().enumerate() {
            let mut extent = grid.local;
            extent[axis] += 1;
            self.boxes(grid, extent, || grid.face_rows(axis), field)?;
        }
        Ok(())
    }

    fn boxes<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        extent: [usize; D],
        rows: impl Fn() -> Rows<D>,
        field: &mut [f64],
    ) -> Result<()> {
        let mut count = self.session.size() as u64;
        count.serialize(self)?;
        let Head::Writes { to, failed } = &mut self.head else {
            return self.read_boxes(grid, extent, rows, field, count);
        };
        let head = (0..D).flat_map(|a| [grid.start[a] as f64, extent[a] as f64]);
        let mut bytes: Vec<u8> = head.flat_map(f64::to_le_bytes).collect();
        bytes.reserve_exact(8 * extent.iter().product::<usize>());
        let mut finite = true;
        for x in rows().flat_map(|row| &field[row]) {
            finite &= x.is_finite();
            bytes.extend_from_slice(&x.to_le_bytes());
        }
        let written = to.put_parts(self.session, &bytes);
        if failed.is_none() {
            *failed = written.err();
        }
        if failed.is_none() && !finite {
            *failed = Some(Error::Run(
                "a field is not finite everywhere: there is nothing to go on from".into(),
            ));
        }
        Ok(())
    }

    /// Takes this rank's part of `count` boxes: its own where it is among them, else what the boxes
    /// have of it.
    fn read_boxes<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        extent: [usize; D],
        rows: impl Fn() -> Rows<D>,
        field: &mut [f64],
        count: u64,
    ) -> Result<()> {
        if !(1..=grid.total_cells() as u64).contains(&count) {
            return Err(refusal(format!("a field in {count} boxes is not of this grid")));
        }
        let mine = Cells { start: grid.start, extent };
        let mut taken = 0;
        let mut own = false;
        for _ in 0..count {
            let there = self.read_box(grid, extent)?;
            if there == mine {
                for row in rows() {
                    taken += put(self.row(row.len())?, &mut field[row])?;
                }
                own = true;
            } else if own || !there.meets(&mine) {
                self.skip(8 * there.count() as u64)?;
            } else {
                taken += self.read_common(grid, &mine, &there, field)?;
            }
        }
        if taken < mine.count() {
            return Err(refusal("a field does not fill the grid".into()));
        }
        Ok(())
    }

    /// The next box, which has to lie in the grid; `extent` is that of this rank's.
    fn read_box<const D: usize>(&mut self, grid: &Grid<D>, extent: [usize; D]) -> Result<Cells<D>> {
        let mut found = Cells { start: [0; D], extent: [0; D] };
        for a in 0..D {
            let inside = (grid.cells[a] + extent[a] - grid.local[a]) as f64;
            let mut s = 0.0;
            let mut n = 0.0;
            self.serialize([&mut s, &mut n])?;
            let whole = |x: f64| x >= 0.0 && x.fract() == 0.0 && x <= inside;
            if !(whole(s) && whole(n) && n >= 1.0 && s + n <= inside) {
                return Err(refusal(format!(
                    "a box of {n} cells from cell {s} on is not of this grid"
                )));
            }
            found.start[a] = s as usize;
            found.extent[a] = n as usize;
        }
        Ok(found)
    }

    /// Takes what another box has of this rank's, and returns how many cells that is.
    fn read_common<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        mine: &Cells<D>,
        there: &Cells<D>,
        field: &mut [f64],
    ) -> Result<usize> {
        let mut taken = 0;
        let from = there.start[0].max(mine.start[0]);
        let to = there.end(0).min(mine.end(0));
        for k in 0..there.extent[1..].iter().product() {
            let values = self.row(there.extent[0])?;
            // Where the row lies in this rank's box, if it does.
            let mut rest = k;
            let mut at = Some(from + grid.ghosts - mine.start[0]);
            for a in 1..D {
                let cell = there.start[a] + rest % there.extent[a];
                rest /= there.extent[a];
                let within = (mine.start[a]..mine.end(a)).contains(&cell);
                at = at
                    .filter(|_| within)
                    .map(|at| at + (cell + grid.ghosts - mine.start[a]) * grid.stride[a]);
            }
            if let Some(at) = at {
                let common = &values[8 * (from - there.start[0])..8 * (to - there.start[0])];
                taken += put(common, &mut field[at..])?;
            }
        }
        Ok(taken)
    }
}

/// Puts numbers in their places, and returns how many.
fn put(bytes: &[u8], field: &mut [f64]) -> Result<usize> {
    for (x, bytes) in field.iter_mut().zip(bytes.chunks_exact(8)) {
        *x = double(bytes)?;
    }
    Ok(bytes.len() / 8)
}
