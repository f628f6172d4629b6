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

use super::cut_body::CutBody;
use super::shared_cell::SharedCell;
use nalgebra::Vector3;

/// The part of a body in a cell.
#[derive(Clone, Copy, Debug)]
pub struct SharedPart {
    shared: SharedCell,
    body: u32,
}

impl SharedPart {
    /// Which of the bodies, and which place in its list.
    fn at(&self) -> (usize, usize) {
        (self.body as usize, self.shared.place as usize)
    }
}

/// The cells that bodies share.
#[derive(Clone, Debug, Default)]
pub struct SharedCells {
    /// The bodies' parts in them, those of a cell together, in the order of the bodies.
    parts: Vec<SharedPart>,
}

/// The parts of each cell, with the sum of their ownership weights.
fn by_cell(parts: &[SharedPart]) -> impl Iterator<Item = (&[SharedPart], f64)> {
    let cells = parts.chunk_by(|a, b| a.shared.cell == b.shared.cell);
    cells.map(|parts| (parts, parts.iter().map(|part| part.shared.owned).sum()))
}

impl SharedCells {
    /// Makes room for so many parts.
    pub fn reserve(&mut self, n: usize) {
        self.parts.reserve(n.saturating_sub(self.parts.len()));
    }

    /// Lists the parts of all bodies, of which `list` gives the shared cells.
    fn gather<const D: usize>(
        &mut self,
        bodies: &[CutBody<D>],
        list: impl Fn(&CutBody<D>) -> &[SharedCell],
    ) {
        self.parts.clear();
        for (body, cut) in bodies.iter().enumerate() {
            let parts = list(cut).iter().map(|&shared| SharedPart { shared, body: body as u32 });
            self.parts.extend(parts);
        }
        self.parts.sort_unstable_by_key(|part| (part.shared.cell, part.at()));
    }

    /// Shares the cells to which several of the bodies are about as near, and lists the ghost cells
    /// among them.
    pub fn share<const D: usize>(&mut self, bodies: &mut [CutBody<D>]) {
        self.gather(bodies, |cut| &cut.own.shared);
        for (parts, owned_by) in by_cell(&self.parts) {
            for (part, (body, place)) in parts.iter().map(|part| (part, part.at())) {
                bodies[body].own.cells[place].ownership = part.shared.owned / owned_by;
            }
        }
        self.gather(bodies, |cut| &cut.ghosts.shared);
        for (parts, owned_by) in by_cell(&self.parts) {
            let mut left = 1.0f64;
            for (i, part) in parts.iter().enumerate() {
                let (body, place) = part.at();
                let ghost = &mut bodies[body].ghosts.cells[place];
                let weight = part.shared.owned * part.shared.weight / owned_by;
                // Rounding may leave less than the last one has.
                ghost.weight = if weight > 0.0 { weight / left.max(weight) } else { 0.0 };
                ghost.first = i == 0;
                left -= weight;
            }
        }
    }

    /// Gives all ghost cells that share a cell one target, the mean of what each would set alone.
    /// Without `cleared` those that bodies have just left set nothing.
    pub fn share_targets<const D: usize>(&self, bodies: &mut [CutBody<D>], cleared: bool) {
        for (parts, _) in by_cell(&self.parts) {
            let setting = || parts.iter().filter(|part| cleared || !part.shared.cleared);
            let mut sum = Vector3::zeros();
            let mut weights = 0.0;
            for part in setting() {
                let (body, place) = part.at();
                let weight = part.shared.owned * part.shared.weight;
                sum += weight * bodies[body].ghosts.cells[place].target;
                weights += weight;
            }
            if weights > 0.0 {
                for (body, place) in setting().map(SharedPart::at) {
                    bodies[body].ghosts.cells[place].target = sum / weights;
                }
            }
        }
    }
}
