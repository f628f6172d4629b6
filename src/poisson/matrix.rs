//! The operator as a matrix, for preconditioners that are built from one: a row for each cell,
//!
//! ```text
//!   ... -g_w ... -g_s  (g_w + g_e + g_s + g_n)  -g_e ... -g_n ...
//! ```

use super::Poisson;
use super::coefficient::Coefficient;
use crate::grid::Grid;
use crate::petsc::{Layout, Pattern};

/// The matrix's rows, cell by cell: the neighbours' entries, low and high along each axis, then the
/// diagonal's.
pub struct MatrixRows {
    /// For each cell, which of its faces have a cell beyond: one bit each.
    inner: Vec<u8>,
    values: Vec<f64>,
}

/// Added to the diagonal, relative to it, where no boundary fixes the pressure. Without it a
/// multigrid's coarse operators hold nothing but rounding in the direction of the constants, and
/// now and then blow them up until the Krylov method stagnates (seen with BoomerAMG and GAMG at
/// density ratios of 1000). Its effect is far below D0, and C-HSMAC judges by the true divergence.
const SHIFT: f64 = 1e-13;

impl MatrixRows {
    /// The rows of this rank's cells, and the pattern of their entries.
    pub fn new<const D: usize>(layout: &Layout, grid: &Grid<D>) -> (MatrixRows, Pattern) {
        let mut pattern = Pattern::default();
        let mut inner = Vec::new();
        let mut push = |row, column, face| {
            pattern.rows.push(row);
            pattern.columns.push(column);
            pattern.faces.push(face);
        };
        for c in grid.rows().flatten() {
            let mut faces = 0;
            for face in 0..2 * D {
                let s = grid.stride[face / 2];
                let neighbour = layout.numbers[if face % 2 == 0 { c - s } else { c + s }];
                if neighbour >= 0 {
                    faces |= 1 << face;
                    push(layout.numbers[c], neighbour, Some(face as u8));
                }
            }
            push(layout.numbers[c], layout.numbers[c], None);
            inner.push(faces);
        }
        (MatrixRows { inner, values: vec![0.0; pattern.rows.len()] }, pattern)
    }

    /// The entries' values, in the order of [`MatrixRows::new`].
    pub fn fill(&mut self, operator: &mut Poisson) -> &[f64] {
        let Poisson { coefficient: Coefficient { lattice, g, singular, .. }, shift, .. } = operator;
        let definite = if *singular { 1.0 + SHIFT } else { 1.0 };
        shift.resize(if *singular { self.inner.len() } else { 0 }, 0.0);
        let mut at = 0;
        let cells = lattice.rows().flat_map(|s| s..s + lattice.n[0]);
        for (row, (c, inner)) in cells.zip(&self.inner).enumerate() {
            let mut diagonal = 0.0;
            for face in 0..2 * lattice.axes {
                let axis = face / 2;
                let each = g[axis][if face % 2 == 0 { c } else { c + lattice.stride[axis] }];
                diagonal += each;
                if inner & (1 << face) != 0 {
                    self.values[at] = -each;
                    at += 1;
                }
            }
            self.values[at] = diagonal * definite;
            shift.get_mut(row).into_iter().for_each(|shift| *shift = self.values[at] - diagonal);
            at += 1;
        }
        &self.values
    }
}
