//! Cells to which several bodies are equally near, as in the plane between two of one size: each body has its part, whatever their order.
//!
//! ```text
//!   ( 1 )  o  ( 2 )      W = (w_1 + w_2)/n,   v = (w_1 v_1 + w_2 v_2)/(n W),   u <- u + W (v - u),   each gives W (v - u)/n
//! ```
//! with `w_k` what the cell would weigh were the body k alone, and `v_k` what it would be set to. Bodies set their cells one after another, the
//! i-th of n with the weight `(W/n)/(1 - i W/n)`, i from 0: after all of them u is as above, and every one has given the same.

use super::cut::CutBodies;
use super::cut_body::CutBody;
use nalgebra::Vector3;

/// A cell in a list of a body, which shares it with others.
#[derive(Clone, Copy, Debug)]
pub struct SharedCell {
    /// Its index in a field.
    pub cell: u32,
    /// Its place in the list.
    pub place: u32,
    /// What it would weigh there were the body alone.
    pub weight: f64,
    /// Whether the body has just left it.
    pub fresh: bool,
}

impl SharedCell {
    /// The one that comes next to a list.
    pub fn next<T>(list: &[T], cell: usize, weight: f64, fresh: bool) -> SharedCell {
        SharedCell { cell: cell as u32, place: list.len() as u32, weight, fresh }
    }
}

/// The part of a body in a cell.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    shared: SharedCell,
    body: u32,
    /// Its place in the lists of all bodies, one after another.
    at: u32,
}

/// Lists the parts of all bodies in lists of theirs, of which `list` gives the shared cells and the length: those of a cell together, in the
/// order of the bodies.
fn gather<const D: usize>(
    bodies: &[CutBody<D>],
    parts: &mut Vec<Part>,
    list: impl Fn(&CutBody<D>) -> (&[SharedCell], usize),
) {
    parts.clear();
    let mut before = 0;
    for (body, cut) in bodies.iter().enumerate() {
        let (cells, length) = list(cut);
        parts.extend(cells.iter().map(|&shared| Part { shared, body: body as u32, at: before + shared.place }));
        before += length as u32;
    }
    parts.sort_unstable_by_key(|part| (part.shared.cell, part.at));
}

/// Those of each cell.
fn by_cell(parts: &[Part]) -> impl Iterator<Item = &[Part]> {
    parts.chunk_by(|a, b| a.shared.cell == b.shared.cell)
}

impl<const D: usize> CutBodies<D> {
    /// Shares the cells to which several bodies are equally near.
    pub(super) fn share_cells(&mut self) {
        let (bodies, parts) = (&mut self.bodies, &mut self.shared);
        gather(bodies, parts, |cut| (&cut.owns_shared, cut.owns.len()));
        for parts in by_cell(parts) {
            for part in parts {
                bodies[part.body as usize].owns[part.shared.place as usize] = part.shared.weight / parts.len() as f64;
            }
        }
        gather(bodies, parts, |cut| (&cut.inside_shared, cut.inside.len()));
        for parts in by_cell(parts) {
            let n = parts.len() as f64;
            let each = parts.iter().map(|part| part.shared.weight).sum::<f64>() / (n * n);
            for (i, part) in parts.iter().enumerate() {
                let weight = each / (1.0 - i as f64 * each);
                bodies[part.body as usize].inside[part.shared.place as usize].weight = weight;
            }
        }
    }

    /// Gives all that share a cell one value of it, of what each would set alone, in the order of [`CutBody::inside`] of all bodies. Without
    /// `fresh` those that have just left a cell set nothing.
    pub(super) fn share_values(&self, fresh: bool, values: &mut [Vector3<f64>]) {
        for parts in by_cell(&self.shared) {
            let setting = || parts.iter().filter(|part| fresh || !part.shared.fresh);
            let (mut sum, mut weights) = (Vector3::zeros(), 0.0);
            for part in setting() {
                sum += part.shared.weight * values[part.at as usize];
                weights += part.shared.weight;
            }
            setting().for_each(|part| values[part.at as usize] = sum / weights);
        }
    }
}
