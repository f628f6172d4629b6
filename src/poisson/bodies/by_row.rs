//! The cells of all bodies' surfaces on the finest level, row by row of the grid: a product with
//! the operator takes them as it comes by.

use super::surface::SurfaceCells;

/// A cell of a body's surface.
#[derive(Clone, Copy, Debug, Default)]
pub struct RowCell {
    /// Its place in its row.
    pub at: u32,
    pub group: u32,
    /// j of each of the group's modes.
    pub j: [f64; 3],
}

/// The cells of all bodies' surfaces.
#[derive(Default)]
pub struct ByRow {
    /// Where each row's cells begin, and where the last one's end.
    begin: Vec<u32>,
    cells: Vec<RowCell>,
}

impl ByRow {
    /// Sorts the cells of `surface` into `rows` rows of `nx` cells.
    pub fn sort(&mut self, surface: &SurfaceCells, nx: usize, rows: usize) {
        let ByRow { begin, cells } = self;
        begin.clear();
        begin.resize(rows + 2, 0);
        // Counted one place too far, so that each begins where it is to when all are placed.
        surface.cells.iter().for_each(|cell| begin[cell.row as usize / nx + 2] += 1);
        (1..begin.len()).for_each(|row| begin[row] += begin[row - 1]);
        if cells.capacity() < surface.cells.len() {
            cells.reserve(2 * surface.cells.len() - cells.len());
        }
        cells.resize(surface.cells.len(), RowCell::default());
        for (group, range) in (0u32..).zip(surface.begin.windows(2)) {
            for cell in &surface.cells[range[0]..range[1]] {
                let row = cell.row as usize / nx;
                let at = cell.row % nx as u32;
                cells[begin[row + 1] as usize] = RowCell { at, group, j: cell.j };
                begin[row + 1] += 1;
            }
        }
    }

    /// Surface cells of a row; none, where none were sorted.
    #[inline(always)]
    pub fn row(&self, row: usize) -> &[RowCell] {
        match self.begin.get(row..row + 2) {
            Some([begin, end]) => &self.cells[*begin as usize..*end as usize],
            _ => &[],
        }
    }

    /// Adds to the groups' `sums` j times the value of each cell by its place; `begin` says where a
    /// row begins.
    pub fn add_up(
        &self,
        sums: &mut [f64],
        begin: impl Fn(usize) -> usize,
        value: impl Fn(usize) -> f64,
    ) {
        for row in 0..self.begin.len().saturating_sub(2) {
            let start = begin(row);
            for cell in self.row(row) {
                let x = value(start + cell.at as usize);
                let sums = &mut sums[3 * cell.group as usize..][..3];
                sums.iter_mut().zip(&cell.j).for_each(|(sum, j)| *sum += j * x);
            }
        }
    }
}
