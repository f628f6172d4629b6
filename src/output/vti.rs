//! Files of fields ([`mics_run::vti`]) by all ranks together: each writes its own cells.

use super::file::create_together;
use crate::Result;
use crate::grid::Grid;
use crate::petsc::Session;
use mics_run::file::PartFile;
use mics_run::vti::{Cells, Head};
use std::path::Path;

/// Head of the file of a grid at a time (s), with these arrays of 1 or 3 components.
pub fn head<const D: usize>(grid: &Grid<D>, time: f64, arrays: &[(&str, usize)]) -> Head {
    let pick = |a: usize| if a < D { a } else { 0 };
    Head {
        time,
        cells: std::array::from_fn(|a| if a < D { grid.cells[a] } else { 1 }),
        h: std::array::from_fn(|a| grid.h[pick(a)]),
        arrays: arrays.iter().map(|(name, components)| ((*name).to_owned(), *components)).collect(),
    }
}

/// A file that all ranks write; dropped before [`Writer::commit`], it leaves nothing.
pub struct Writer<'a> {
    session: &'a Session,
    /// The file to be renamed, on rank 0.
    part: Option<PartFile>,
    cells: Cells,
    head: Head,
}

impl<'a> Writer<'a> {
    /// Begins a file. Collective.
    ///
    /// # Errors
    /// When it cannot be made, or a rank does not see it.
    pub fn begin(session: &'a Session, path: &Path, head: Head) -> Result<Writer<'a>> {
        let (part, file) = create_together(session, path)?;
        let mut cells = Cells::of(file, path, &head);
        if part.is_some() {
            cells.frame(&head);
        }
        Ok(Writer { session, part, cells, head })
    }

    /// Writes this rank's cells of an array that the head has, from fields of its components;
    /// components that are missing are zero. What fails is told at the end.
    pub fn put<const D: usize>(&mut self, grid: &Grid<D>, name: &str, parts: &[&[f64]]) {
        let Some(k) = self.head.arrays.iter().position(|array| array.0 == name) else { return };
        for row in grid.rows() {
            let cell = grid.global_cell(row.start);
            let first = (0..D).rev().fold(0, |number, a| number * grid.cells[a] + cell[a]);
            self.cells.put(k, self.head.arrays[k].1, first, row, parts);
        }
    }

    /// Ends the file and gives it its name. Collective.
    ///
    /// # Errors
    /// When a rank could not write.
    pub fn commit(self) -> Result<()> {
        self.session.agree(self.cells.finish())?;
        self.session.agree(self.part.map_or(Ok(()), PartFile::commit))
    }
}
