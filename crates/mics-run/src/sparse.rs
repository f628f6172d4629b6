//! Sparse matrices and vectors in files that others read: MatrixMarket's text and PETSc's binary.
//!
//! ```text
//!   MatrixMarket   %%MatrixMarket matrix coordinate real symmetric|general
//!                  % a comment
//!                  rows columns entries
//!                  row column value           counted from 1; of a symmetric one the lower part
//!   PETSc          1211216, rows, columns, entries, entries of each row, columns (from 0), values
//!                  1211214, length, values                                            a vector
//!                  big endian: integers of four bytes, doubles
//! ```
//! Sources: R. Boisvert et al. 1996, The Matrix Market exchange formats; PETSc's manual pages of
//! MatLoad and VecLoad.

use crate::file::replace_by;
use crate::{Error, Result};
use std::io::{BufWriter, Write};
use std::path::Path;

/// First integers of PETSc's binary files of matrices and vectors.
const PETSC_MATRIX: i32 = 1_211_216;
const PETSC_VECTOR: i32 = 1_211_214;

/// A sparse matrix by rows, each with ascending columns.
#[derive(Clone, Debug)]
pub struct Sparse {
    width: usize,
    /// Where each row begins, and where the last one ends.
    begins: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Sparse {
    /// A matrix of so many columns, without a row yet.
    pub fn new(width: usize) -> Sparse {
        Sparse { width, begins: vec![0], columns: Vec::new(), values: Vec::new() }
    }

    /// Adds a row of these columns and values, which it sorts; those of one column are summed.
    pub fn push_row(&mut self, entries: &mut [(u32, f64)]) {
        entries.sort_by_key(|entry| entry.0);
        let first = self.columns.len();
        for (column, value) in entries.iter() {
            match self.columns[first..].last() {
                Some(last) if last == column => {
                    *self.values.last_mut().unwrap_or(&mut 0.0) += value;
                }
                _ => {
                    self.columns.push(*column);
                    self.values.push(*value);
                }
            }
        }
        self.begins.push(self.columns.len());
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.begins.len() - 1
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Entries.
    pub fn entries(&self) -> usize {
        self.values.len()
    }

    /// Columns and values of a row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.begins[row]..self.begins[row + 1];
        let columns = self.columns[range.clone()].iter().map(|column| *column as usize);
        columns.zip(self.values[range].iter().copied())
    }

    /// Writes it in MatrixMarket's form, with a line of comment; of a `symmetric` one the lower
    /// part.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_market(&self, path: &Path, symmetric: bool, comment: &str) -> Result<()> {
        let form = if symmetric { "symmetric" } else { "general" };
        let shown = |row: usize| self.row(row).filter(move |(c, _)| !symmetric || *c <= row);
        let count: usize = (0..self.rows()).map(|row| shown(row).count()).sum();
        write_by(path, |file| {
            writeln!(file, "%%MatrixMarket matrix coordinate real {form}\n% {comment}")?;
            writeln!(file, "{} {} {count}", self.rows(), self.width)?;
            for row in 0..self.rows() {
                for (column, value) in shown(row) {
                    writeln!(file, "{} {} {value:e}", row + 1, column + 1)?;
                }
            }
            Ok(())
        })
    }

    /// Writes it in PETSc's binary form.
    ///
    /// # Errors
    /// When it has more entries than PETSc's integers count, or the file cannot be written.
    pub fn write_petsc(&self, path: &Path) -> Result<()> {
        let counts = [self.rows(), self.width, self.entries()];
        let counts = counts.map(|count| petsc_integer(path, count));
        let [rows, width, entries] = counts;
        let head = [PETSC_MATRIX, rows?, width?, entries?];
        write_by(path, |file| {
            let lengths = self.begins.windows(2).map(|row| (row[1] - row[0]) as i32);
            let columns = self.columns.iter().map(|column| *column as i32);
            for number in head.into_iter().chain(lengths).chain(columns) {
                file.write_all(&number.to_be_bytes())?;
            }
            self.values.iter().try_for_each(|value| file.write_all(&value.to_be_bytes()))
        })
    }
}

/// Writes a vector in MatrixMarket's form, with a line of comment.
///
/// # Errors
/// When the file cannot be written.
pub fn write_vector_market(path: &Path, vector: &[f64], comment: &str) -> Result<()> {
    write_by(path, |file| {
        writeln!(file, "%%MatrixMarket matrix array real general\n% {comment}")?;
        writeln!(file, "{} 1", vector.len())?;
        vector.iter().try_for_each(|value| writeln!(file, "{value:e}"))
    })
}

/// Writes a vector in PETSc's binary form.
///
/// # Errors
/// When it is longer than PETSc's integers count, or the file cannot be written.
pub fn write_vector_petsc(path: &Path, vector: &[f64]) -> Result<()> {
    let length = petsc_integer(path, vector.len())?;
    write_by(path, |file| {
        file.write_all(&PETSC_VECTOR.to_be_bytes())?;
        file.write_all(&length.to_be_bytes())?;
        vector.iter().try_for_each(|value| file.write_all(&value.to_be_bytes()))
    })
}

/// A count as an integer of a PETSc file.
fn petsc_integer(path: &Path, count: usize) -> Result<i32> {
    i32::try_from(count).map_err(|_| {
        Error::Usage(format!(
            "{}: {count} is more than the integers of PETSc's files count; take a smaller grid",
            path.display()
        ))
    })
}

/// Writes a whole file or none.
fn write_by(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<std::fs::File>) -> std::io::Result<()>,
) -> Result<()> {
    replace_by(path, |file| write(file).map_err(Error::io(path)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_symmetric_matrix_has_the_bytes_of_both_formats() {
        let mut matrix = Sparse::new(2);
        matrix.push_row(&mut [(1, -1.0), (0, 2.0)]);
        matrix.push_row(&mut [(0, -1.0), (1, 1.0), (1, 0.5)]);
        assert_eq!((matrix.rows(), matrix.entries()), (2, 4));
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        matrix.write_market(&at("a.mtx"), true, "words").unwrap();
        let text = std::fs::read_to_string(at("a.mtx")).unwrap();
        let head = "%%MatrixMarket matrix coordinate real symmetric\n% words\n";
        assert_eq!(text, format!("{head}2 2 3\n1 1 2e0\n2 1 -1e0\n2 2 1.5e0\n"));
        matrix.write_petsc(&at("a.petsc")).unwrap();
        let integers = [1_211_216i32, 2, 2, 4, 2, 2, 0, 1, 0, 1].map(i32::to_be_bytes);
        let values = [2.0f64, -1.0, -1.0, 1.5].map(f64::to_be_bytes);
        assert_eq!(
            std::fs::read(at("a.petsc")).unwrap(),
            [integers.as_flattened(), values.as_flattened()].concat()
        );
        write_vector_petsc(&at("b.petsc"), &[0.25]).unwrap();
        let expected = [&1_211_214i32.to_be_bytes()[..], &[0, 0, 0, 1], &0.25f64.to_be_bytes()];
        assert_eq!(std::fs::read(at("b.petsc")).unwrap(), expected.concat());
    }
}
