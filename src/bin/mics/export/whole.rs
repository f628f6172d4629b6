//! The matrix of a system as a whole: the fluid's part and the factors' dense blocks.

use mics::poisson::System;
use mics_run::sparse::Sparse;

/// `A = A_fluid + sum_k w_k j_k j_k^T`.
pub struct Whole {
    /// `None` where it would have too many nonzeros.
    pub matrix: Option<Sparse>,
    /// A bound on its nonzeros: those of all its parts.
    pub at_most: usize,
}

/// The matrix, where a bound on its nonzeros is within `limit`, or nothing is added to the fluid's
/// part, which is written in any case.
pub fn sum(system: &System, limit: usize) -> Whole {
    let blocks = system.factors.iter().map(|f| f.entries.len().saturating_mul(f.entries.len()));
    let at_most = blocks.fold(system.fluid.entries(), usize::saturating_add);
    let small = at_most <= limit || system.factors.is_empty();
    Whole { matrix: small.then(|| add(system)), at_most }
}

/// J, a column a factor.
pub fn columns(system: &System) -> Sparse {
    let mut matrix = Sparse::new(system.factors.len());
    for mut row in rows(system) {
        matrix.push_row(&mut row);
    }
    matrix
}

/// The rows of J: factors, and their values.
fn rows(system: &System) -> Vec<Vec<(u32, f64)>> {
    let mut rows = vec![Vec::new(); system.fluid.rows()];
    for (k, factor) in system.factors.iter().enumerate() {
        for (cell, value) in &factor.entries {
            rows[*cell as usize].push((k as u32, *value));
        }
    }
    rows
}

/// Row by row; entry and transposed entry are the same sums of the same products.
fn add(system: &System) -> Sparse {
    let n = system.fluid.rows();
    let (mut sums, mut there) = (vec![0.0; n], vec![false; n]);
    let (mut columns, mut entries) = (Vec::new(), Vec::new());
    let mut matrix = Sparse::new(n);
    for (row, factors) in rows(system).into_iter().enumerate() {
        let mut add = |column: usize, value: f64| {
            if !std::mem::replace(&mut there[column], true) {
                columns.push(column);
            }
            sums[column] += value;
        };
        system.fluid.row(row).for_each(|(column, value)| add(column, value));
        for (k, mine) in factors {
            let factor = &system.factors[k as usize];
            for (column, other) in &factor.entries {
                add(*column as usize, factor.weight * (mine * other));
            }
        }
        entries.clear();
        for column in columns.drain(..) {
            entries.push((column as u32, std::mem::take(&mut sums[column])));
            there[column] = false;
        }
        matrix.push_row(&mut entries);
    }
    matrix
}
