//! Where the levels of a rank end: a dense inverse, or the way to the whole level on every rank.

use super::lattice::Lattice;
use super::level::{Level, Single};
use super::whole::Whole;
use crate::petsc::Session;
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
        let (lattice, count) = (level.lattice, self.cells.len());
        matrix.fill(0.0);
        let strides = [1, lattice.n[0], lattice.n[0] * lattice.n[1]];
        for (p, &c) in self.cells.iter().enumerate() {
            for axis in 0..lattice.axes {
                let (n, at) = (lattice.n[axis], p / strides[axis] % lattice.n[axis]);
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
        // What has no open face is its own.
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

/// Brings a level's fields from every rank's box to the whole of the level on every rank, and back.
pub(super) struct Gather {
    session: Session,
    /// Each rank's first cell and cells along each axis.
    boxes: Vec<([usize; 3], [usize; 3])>,
    mine: Vec<Single>,
    all: Vec<Single>,
    counts: Vec<i32>,
    starts: Vec<i32>,
}

impl Gather {
    pub fn new(session: &Session, whole: &Whole) -> Gather {
        let ranks: [usize; 3] = std::array::from_fn(|a| whole.widths[a].len());
        // Ranks are numbered like cells: x fastest.
        let place =
            |rank: usize| [rank % ranks[0], rank / ranks[0] % ranks[1], rank / ranks[0] / ranks[1]];
        let boxed = |at: [usize; 3]| {
            let start = |a: usize| whole.widths[a][..at[a]].iter().map(Vec::len).sum();
            (
                std::array::from_fn(start),
                std::array::from_fn(|a: usize| whole.widths[a][at[a]].len()),
            )
        };
        let boxes: Vec<_> = (0..session.size()).map(|rank| boxed(place(rank))).collect();
        let size = |n: &[usize; 3]| (n[0] + 1) * (n[1] + 1) * (n[2] + 1);
        let total = boxes.iter().map(|(_, n)| size(n)).sum();
        Gather {
            session: session.clone(),
            mine: vec![0.0; size(&boxes[session.rank()].1)],
            all: vec![0.0; total],
            counts: vec![0; boxes.len()],
            starts: vec![0; boxes.len()],
            boxes,
        }
    }

    /// Gathers a field of every rank's box, with one layer more along `axis`, into one of the
    /// `whole`. Collective.
    pub fn gather(
        &mut self,
        from: &[Single],
        lattice: &Lattice,
        axis: Option<usize>,
        to: &mut [Single],
        whole: &Lattice,
    ) -> Result<()> {
        let extent = |n: &[usize; 3]| -> [usize; 3] {
            std::array::from_fn(|a| n[a] + usize::from(Some(a) == axis))
        };
        let mut start = 0;
        for ((_, n), (count, at)) in
            self.boxes.iter().zip(self.counts.iter_mut().zip(&mut self.starts))
        {
            (*count, *at) = (extent(n).iter().product::<usize>() as i32, start);
            start += *count;
        }
        let [nx, ny, nz] = extent(&lattice.n);
        for (r, row) in self.mine.chunks_exact_mut(nx).take(ny * nz).enumerate() {
            row.copy_from_slice(&from[lattice.row(r % ny, r / ny)..][..nx]);
        }
        self.session.all_gather(
            &self.mine[..nx * ny * nz],
            &mut self.all,
            &self.counts,
            &self.starts,
        )?;
        for ((first, n), start) in self.boxes.iter().zip(&self.starts) {
            let [nx, ny, nz] = extent(n);
            for (r, row) in self.all[*start as usize..].chunks_exact(nx).take(ny * nz).enumerate() {
                let at = whole.row(first[1] + r % ny, first[2] + r / ny) + first[0];
                to[at..][..nx].copy_from_slice(row);
            }
        }
        Ok(())
    }

    /// Takes this rank's box out of a field of the `whole`.
    pub fn take_own(&self, from: &[Single], whole: &Lattice, to: &mut [Single], lattice: &Lattice) {
        let (first, n) = self.boxes[self.session.rank()];
        for (k, j) in (0..n[2]).flat_map(|k| (0..n[1]).map(move |j| (k, j))) {
            let at = whole.row(first[1] + j, first[2] + k) + first[0];
            to[lattice.row(j, k)..][..n[0]].copy_from_slice(&from[at..][..n[0]]);
        }
    }
}
