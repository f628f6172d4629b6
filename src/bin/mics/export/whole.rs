//! The matrix of a system as a whole, and what is added to the fluid's part as columns.

use mics::poisson::System;
use mics_run::sparse::Sparse;

/// A bound on the nonzeros of the whole matrix: those of all its parts.
pub fn at_most(system: &System) -> usize {
    let blocks = system.factors.iter().map(|f| f.entries.len().saturating_mul(f.entries.len()));
    blocks.fold(system.fluid.entries(), usize::saturating_add)
}

/// J, a column a factor.
pub fn columns(system: &System) -> Sparse {
    let mut matrix = Sparse::new(system.factors.len());
    rows(system).iter_mut().for_each(|row| matrix.push_row(row));
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

/// `A = A_fluid + sum_k w_k j_k j_k^T`. Entry and transposed entry are the same sums of the same
/// products.
pub fn sum(system: &System) -> Sparse {
    let mut matrix = Sparse::new(system.fluid.rows());
    let mut entries = Vec::new();
    for (row, factors) in rows(system).into_iter().enumerate() {
        entries.clear();
        entries.extend(system.fluid.row(row).map(|(column, value)| (column as u32, value)));
        for (k, mine) in factors {
            let factor = &system.factors[k as usize];
            let product = |(column, other): &(u32, f64)| (*column, factor.weight * (mine * other));
            entries.extend(factor.entries.iter().map(product));
        }
        matrix.push_row(&mut entries);
    }
    matrix
}
