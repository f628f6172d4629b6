//! The coarsest level, solved by a dense inverse.

use super::lattice::Lattice;
use super::level::{Level, Single};
use crate::{Error, Result};
use nalgebra::{Cholesky, DMatrix};

/// The coarsest level's inverse.
pub(super) struct Dense {
    periodic: [bool; 3],
    singular: bool,
    /// The matrix, between two factorisations.
    matrix: Option<DMatrix<f64>>,
    columns: DMatrix<f64>,
    inverse: Vec<Single>,
    /// Where the cells are.
    cells: Vec<usize>,
    b: Vec<Single>,
}

impl Dense {
    pub fn new(lattice: Lattice, periodic: [bool; 3], singular: bool) -> Dense {
        let cells: Vec<usize> = lattice.rows().flat_map(|s| s..s + lattice.n[0]).collect();
        let n = cells.len();
        Dense {
            periodic,
            singular,
            matrix: Some(DMatrix::zeros(n, n)),
            columns: DMatrix::zeros(n, n),
            inverse: vec![0.0; n * n],
            b: vec![0.0; n],
            cells,
        }
    }

    pub fn factorise(&mut self, level: &Level) -> Result<()> {
        let n = self.cells.len();
        let mut matrix = self.matrix.take().unwrap_or_else(|| DMatrix::zeros(n, n));
        self.fill(level, &mut matrix);
        let factors = Cholesky::new(matrix).ok_or_else(|| {
            Error::Run(
                "the coarsest level of the multigrid is singular: the density varies by too much \
                for it; choose pressure.solver = \"bcgs-boomeramg\", or densities nearer to each \
                other"
                    .into(),
            )
        })?;
        self.columns.fill_with_identity();
        factors.solve_mut(&mut self.columns);
        let inverse =
            |k: usize| 0.5 * (self.columns[(k / n, k % n)] + self.columns[(k % n, k / n)]);
        self.inverse.iter_mut().enumerate().for_each(|(k, v)| *v = inverse(k) as Single);
        self.matrix = Some(factors.unpack_dirty());
        Ok(())
    }

    fn fill(&self, level: &Level, matrix: &mut DMatrix<f64>) {
        let lattice = level.lattice;
        let count = self.cells.len();
        matrix.fill(0.0);
        let strides = [1, lattice.n[0], lattice.n[0] * lattice.n[1]];
        for (p, &c) in self.cells.iter().enumerate() {
            for axis in 0..lattice.axes {
                let n = lattice.n[axis];
                let at = p / strides[axis] % lattice.n[axis];
                for (face, end, round) in [(c, 0, n - 1), (c + lattice.stride[axis], n - 1, 0)] {
                    let g = f64::from(level.g[axis][face]);
                    let q = match at == end {
                        true if self.periodic[axis] => {
                            p - at * strides[axis] + round * strides[axis]
                        }
                        true => count,
                        false if end == 0 => p - strides[axis],
                        false => p + strides[axis],
                    };
                    matrix[(p, p)] += g;
                    if q < count {
                        matrix[(p, q)] -= g;
                    }
                }
            }
        }
        let mean = matrix.trace() / count as f64;
        // A cell without an open face is coupled to none: its diagonal is made the mean.
        for p in 0..count {
            if matrix[(p, p)] == 0.0 {
                matrix[(p, p)] = if mean > 0.0 { mean } else { 1.0 };
            }
        }
        if self.singular {
            // A multiple of the constants' projection: on all that sums to zero the inverse is the
            // pseudo-inverse.
            matrix.add_scalar_mut((if mean > 0.0 { mean } else { 1.0 }) / count as f64);
        }
    }

    pub fn solve(&mut self, level: &mut Level) {
        for (b, c) in self.b.iter_mut().zip(&self.cells) {
            *b = level.b[*c];
        }
        for (row, c) in self.inverse.chunks_exact(self.cells.len()).zip(&self.cells) {
            level.x[*c] = row.iter().zip(&self.b).map(|(a, b)| a * b).sum();
        }
    }
}
