//! A mean velocity that is held, in the pressure equation: `w j j^T` with a negative weight,
//! applied and never assembled ([`crate::drive`] has the formulas).
//!
//! ```text
//!   j_c = (g_high - g_low)/h     g: by how much less than the fluid alone a face responds to the
//!                                drive (m3/kg); zero far from bodies
//!   y  += w (j . x) j
//! ```

use super::frame::Frame;
use super::system::{Factor, Origin};
use crate::Result;
use crate::petsc::Session;

/// The term on this rank's cells.
#[derive(Default)]
pub(super) struct HeldMean {
    /// Cells by number, with their parts of j (m2/kg); a cell may come several times.
    cells: Vec<(u32, f64)>,
    weight: f64,
}

impl HeldMean {
    /// Takes the faces along `axis`, `h` (m) apart, with g each, and the weight (kg/m3).
    pub fn set(
        &mut self,
        frame: &Frame,
        axis: usize,
        h: f64,
        faces: impl Iterator<Item = (usize, f64)>,
        weight: f64,
    ) {
        self.weight = weight;
        self.cells.clear();
        for (face, g) in faces {
            for (cell, part) in [(face - frame.stride[axis], g / h), (face, -g / h)] {
                self.cells.extend(frame.number(cell).map(|row| (row, part)));
            }
        }
    }

    /// Whether there is any; the same on every rank.
    pub fn any(&self) -> bool {
        self.weight != 0.0
    }

    /// Adds `w (j . x) j` to the cells by number; nothing where no rank has set any. Collective.
    pub fn add_product(
        &self,
        session: &Session,
        x: impl Fn(usize) -> f64,
        mut add: impl FnMut(usize, f64),
    ) -> Result<()> {
        if !self.any() {
            return Ok(());
        }
        let mut sum = [self.cells.iter().map(|(row, j)| j * x(*row as usize)).sum::<f64>()];
        session.sum(&mut sum)?;
        self.cells.iter().for_each(|(row, j)| add(*row as usize, self.weight * sum[0] * j));
        Ok(())
    }

    /// The term as the operator has it, a cell's parts summed; nothing where none is set.
    pub fn factor(&self) -> Option<Factor> {
        let mut cells = self.cells.clone();
        cells.sort_by_key(|cell| cell.0);
        let parts = cells.chunk_by(|a, b| a.0 == b.0);
        let sum = |parts: &[(u32, f64)]| (parts[0].0, parts.iter().map(|part| part.1).sum());
        let entries: Vec<_> = parts.map(sum).filter(|(_, j)| *j != 0.0).collect();
        let there = self.weight != 0.0 && !entries.is_empty();
        there.then_some(Factor { origin: Origin::HeldMean, weight: self.weight, entries })
    }
}
