//! Cells to which several bodies are about as near, as between two that touch: each body has its
//! part, by its ownership weight to the cell.
//!
//! ```text
//!                            c_k
//!              ownership weight of a body: from 0 to 1 by how much nearer it is than others
//!   ( 1 ) o o ( 2 )          W_k = c_k w_k/(c_1 + c_2)
//!              w_k: what the cell would weigh were the body alone
//!                            v = sum W_k v_k/W,  W = sum W_k    v_k: what it would be set to
//!                            u <- u + W (v - u)                 each body gives W_k (v - u)
//! ```
//! Bodies set their cells one after another, each with the weight `W_k/(1 - sum of those before)`:
//! after all of them u is as above, whatever their order. Were the cell the nearest body's alone,
//! forces would jump as two that touch pass over it, and a pair that is its own mirror image would
//! not stay one.

use super::cut::CutBodies;
use super::cut_body::CutBody;
use crate::grid::VectorField;
use crate::state::BeforeForcing;
use nalgebra::Vector3;

/// A cell in a list of a body, which shares it with others.
#[derive(Clone, Copy, Debug)]
pub struct SharedCell {
    /// Its index in a field.
    pub cell: u32,
    /// Its place in the list.
    pub place: u32,
    /// The body's ownership weight to it.
    pub owned: f64,
    /// What it would weigh there were the body alone.
    pub weight: f64,
    /// Whether the body has just left it.
    pub cleared: bool,
}

impl SharedCell {
    /// The one that comes next to a list.
    pub fn next<T>(list: &[T], cell: usize, owned: f64, weight: f64, cleared: bool) -> SharedCell {
        SharedCell { cell: cell as u32, place: list.len() as u32, owned, weight, cleared }
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

/// Lists the parts of all bodies in lists of theirs, of which `list` gives the shared cells and the
/// length: those of a cell together, in the order of the bodies.
fn gather<const D: usize>(
    bodies: &[CutBody<D>],
    parts: &mut Vec<Part>,
    list: impl Fn(&CutBody<D>) -> (&[SharedCell], usize),
) {
    parts.clear();
    let mut before = 0;
    for (body, cut) in bodies.iter().enumerate() {
        let (cells, length) = list(cut);
        parts.extend(cells.iter().map(|&shared| Part {
            shared,
            body: body as u32,
            at: before + shared.place,
        }));
        before += length as u32;
    }
    parts.sort_unstable_by_key(|part| (part.shared.cell, part.at));
}

/// Those of each cell, with the sum of their ownership weights.
fn by_cell(parts: &[Part]) -> impl Iterator<Item = (&[Part], f64)> {
    let cells = parts.chunk_by(|a, b| a.shared.cell == b.shared.cell);
    cells.map(|parts| (parts, parts.iter().map(|part| part.shared.owned).sum()))
}

impl<const D: usize> CutBodies<D> {
    /// Shares the cells to which several bodies are about as near.
    pub(super) fn share_cells(&mut self) {
        let (bodies, parts) = (&mut self.bodies, &mut self.shared);
        gather(bodies, parts, |cut| (&cut.ownership_shared, cut.ownership.len()));
        for (parts, owned_by) in by_cell(parts) {
            for part in parts {
                bodies[part.body as usize].ownership[part.shared.place as usize] =
                    part.shared.owned / owned_by;
            }
        }
        gather(bodies, parts, |cut| (&cut.inside_shared, cut.inside.len()));
        for (parts, owned_by) in by_cell(parts) {
            let mut left = 1.0f64;
            for part in parts {
                let weight = part.shared.owned * part.shared.weight / owned_by;
                // Rounding may leave less than the last one has.
                let part_of_left = if weight > 0.0 { weight / left.max(weight) } else { 0.0 };
                bodies[part.body as usize].inside[part.shared.place as usize].weight = part_of_left;
                left -= weight;
            }
        }
    }

    /// Leaves one entry of each shared cell in what [`CutBodies::take_before_forcing`] found before
    /// the wall was imposed: the others have the velocity `u` (m/s) that it has now.
    pub(super) fn count_shared_once(
        &self,
        u: &VectorField<D>,
        before_forcing: &mut [BeforeForcing<D>],
    ) {
        for part in by_cell(&self.shared).flat_map(|(parts, _)| &parts[1..]) {
            let BeforeForcing { cell, velocity } = &mut before_forcing[part.at as usize];
            *velocity = std::array::from_fn(|a| u[a][*cell as usize]);
        }
    }

    /// Gives all that share a cell one value of it, of what each would set alone, in the order of
    /// [`CutBody::inside`] of all bodies. Without `cleared` those that have just left a cell set
    /// nothing.
    pub(super) fn share_values(&self, cleared: bool, values: &mut [Vector3<f64>]) {
        for (parts, _) in by_cell(&self.shared) {
            let setting = || parts.iter().filter(|part| cleared || !part.shared.cleared);
            let (mut sum, mut weights) = (Vector3::zeros(), 0.0);
            for Part { shared, at, .. } in setting() {
                sum += shared.owned * shared.weight * values[*at as usize];
                weights += shared.owned * shared.weight;
            }
            if weights > 0.0 {
                setting().for_each(|part| values[part.at as usize] = sum / weights);
            }
        }
    }
}
