//! Free rigid bodies in the pressure equation, `sum_k w_k j_k j_k^T`, applied and never assembled;
//! a mode k is one direction in which one body moves, or turns if pressure can turn it, and
//!
//! ```text
//!   j_c = sum over its faces (m_low - m_high)/h
//!              m: what the body carries through a face when it moves in the mode at 1 m/s:
//!                                                   the part that it covers of those along the
//!                 axis that it moves along
//!   s_k = j_k . x                over this rank's cells, then one sum over the ranks for the
//!                                bodies that lie on several
//!   y  += sum_k (w_k s_k) j_k
//! ```
//! In the multigrid they take part on the levels that resolve them (`smoothing`), with `j` summed
//! over coarse cells (`surface`).

mod smoothing;
mod surface;

use super::lattice::Lattice;
use super::system::{Factor, Origin};
use crate::petsc::Session;
use crate::{Error, Result};
use surface::{Cell, Face, SurfaceCells};

/// A face that a free body covers, in part or whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeFace {
    /// The mode: `axes * body + axis` where a body moves along an axis, from 0, the same on every
    /// rank; the modes in which bodies turn, as many for each, come after those of all bodies.
    pub mode: u32,
    /// The face's own axis: that of the mode, where a body moves along one.
    pub axis: u8,
    /// Index of the face in this rank's fields.
    pub face: u32,
    /// The covered part, within (0, 1]; of a body that turns, times the velocity through the face
    /// at 1 rad a unit of time.
    pub part: f64,
}

/// The groups that have cells on more than one rank: the others need nobody else's numbers.
#[derive(Default)]
struct Shared {
    groups: Vec<u32>,
    /// Scratch: their numbers, one group after the other.
    packed: Vec<f64>,
}

impl Shared {
    /// Sums the `width` numbers of each such group over the ranks. Collective.
    fn sum(&mut self, session: &Session, width: usize, numbers: &mut [f64]) -> Result<()> {
        if self.groups.is_empty() {
            return Ok(());
        }
        let of = |group: &u32| width * *group as usize..width * (*group as usize + 1);
        self.packed.clear();
        self.groups.iter().for_each(|group| self.packed.extend_from_slice(&numbers[of(group)]));
        session.sum(&mut self.packed)?;
        for (group, sums) in self.groups.iter().zip(self.packed.chunks_exact(width)) {
            numbers[of(group)].copy_from_slice(sums);
        }
        Ok(())
    }
}

/// All bodies, as far as they lie on this rank. Their modes come in groups: a body's motion along
/// the axes; then, of those that pressure turns, its turning.
pub(super) struct Bodies {
    session: Session,
    axes: usize,
    /// By group.
    weights: Vec<[f64; 3]>,
    /// The body that each group is of.
    owner: Vec<u32>,
    /// The smallest spacing over each axis's.
    inverse_h: [f64; 3],
    /// By level, as far as any level has had bodies.
    layers: Vec<SurfaceCells>,
    /// The cells that each body fills, by axis, and nothing for its turning: three numbers a group;
    /// then, of each group, on how many ranks it has cells. Summed over the ranks.
    volumes: Vec<f64>,
    shared: Shared,
    sums: Vec<f64>,
    /// Whether any is light enough to take part in the multigrid.
    active: bool,
}

/// The way from a field's indices to a lattice's.
pub(super) struct Frame {
    /// Strides, stored cells and layers of ghosts of a field.
    pub stride: [usize; 3],
    pub stored: [usize; 3],
    pub ghosts: usize,
}

impl Frame {
    /// Where a face lies on the lattice, counted along each axis from its layer of ghosts; `None`
    /// beyond the faces of its cells.
    fn on_lattice(&self, lattice: &Lattice, face: &ModeFace) -> Option<[usize; 3]> {
        let index = |a: usize| face.face as usize / self.stride[a] % self.stored[a];
        // -1 and below stand beyond the layer of ghosts.
        let at = std::array::from_fn(|a| match a < lattice.axes {
            true => (index(a) + 1).wrapping_sub(self.ghosts),
            false => 0,
        });
        let last = |a: usize| lattice.n[a] + usize::from(a == face.axis as usize);
        (0..lattice.axes).all(|a| (1..=last(a)).contains(&at[a])).then_some(at)
    }
}

impl Bodies {
    pub fn new(session: &Session, axes: usize, inverse_h: [f64; 3]) -> Bodies {
        Bodies {
            session: session.clone(),
            axes,
            weights: Vec::new(),
            owner: Vec::new(),
            inverse_h,
            layers: vec![SurfaceCells::default()],
            volumes: Vec::new(),
            shared: Shared::default(),
            sums: Vec::new(),
            active: false,
        }
    }

    /// See [`super::Poisson::set_modes`]; `scale` multiplies the weights.
    pub fn set(
        &mut self,
        lattice: &Lattice,
        frame: &Frame,
        weights: &[f64],
        covered: &[ModeFace],
        turning: &[u32],
        scale: f64,
    ) -> Result<()> {
        let groups = weights.len() / self.axes;
        let bodies = groups.saturating_sub(turning.len());
        self.refuse_unsound(frame, weights, covered, turning, (groups, bodies))?;
        self.weights.clear();
        self.weights.extend(
            weights
                .chunks(self.axes)
                .map(|w| std::array::from_fn(|a| w.get(a).map_or(0.0, |w| w * scale))),
        );
        self.owner.clear();
        self.owner.extend((0..bodies as u32).chain(turning.iter().copied()));
        for (numbers, width) in [(&mut self.sums, 3), (&mut self.volumes, 4)] {
            numbers.clear();
            numbers.resize(width * self.weights.len(), 0.0);
        }
        self.take_faces(lattice, frame, covered, bodies)?;
        self.find_shared()
    }

    /// Refuses numbers that are no modes. Collective.
    fn refuse_unsound(
        &self,
        frame: &Frame,
        weights: &[f64],
        covered: &[ModeFace],
        turning: &[u32],
        (groups, bodies): (usize, usize),
    ) -> Result<()> {
        let (axes, stored) = (self.axes, frame.stored.iter().product::<usize>());
        let mut unsound = !weights.len().is_multiple_of(axes)
            || weights.iter().any(|w| !w.is_finite() || *w < 0.0);
        unsound |= turning.len() > groups || turning.iter().any(|k| *k as usize >= bodies);
        unsound |= covered.iter().any(|e| {
            let (mode, axis) = (e.mode as usize, e.axis as usize);
            let moves = axis == mode % axes && e.part > 0.0;
            let known = mode < weights.len() && axis < axes && (e.face as usize) < stored;
            !(known && e.part.is_finite() && (moves || mode / axes >= bodies))
        });
        if self.session.anywhere(unsound)? {
            return Err(Error::Run(
                "a free body's mode in the pressure equation is not finite, has a negative weight, \
                or has a face that is not its rank's"
                    .into(),
            ));
        }
        Ok(())
    }

    /// Takes the covered faces of all groups to the finest level, with the cells beside them and
    /// the volumes of the bodies. Collective.
    fn take_faces(
        &mut self,
        lattice: &Lattice,
        frame: &Frame,
        covered: &[ModeFace],
        bodies: usize,
    ) -> Result<()> {
        let axes = self.axes;
        let finest = &mut self.layers[0];
        finest.clear(lattice);
        // Bodies that move cut now more cells, now fewer.
        if finest.faces.capacity() < covered.len() {
            finest.faces.reserve(2 * covered.len());
            finest.cells.reserve(2 * covered.len());
        }
        let mut rest = covered;
        for group in 0..self.weights.len() {
            let (first, count) = (
                finest.faces.len(),
                rest.iter().take_while(|e| e.mode as usize / axes == group).count(),
            );
            let (own, others) = rest.split_at(count);
            rest = others;
            for e in own {
                let Some(at) = frame.on_lattice(lattice, e) else { continue };
                let (axis, mode) = (e.axis as usize, (e.mode as usize % axes) as u8);
                let place = (0..axes).map(|a| at[a] * lattice.stride[a]).sum::<usize>() as u32;
                finest.faces.push(Face {
                    group: group as u32,
                    mode,
                    axis: e.axis,
                    place,
                    part: e.part,
                    conduct: e.part,
                });
                // Faces between ranks count on the upper one.
                if at[axis] <= lattice.n[axis] && group < bodies {
                    self.volumes[3 * group + axis] += e.part;
                }
            }
            finest.collect(lattice, &self.inverse_h, first);
        }
        // A group's faces have to stand together.
        if self.session.anywhere(!rest.is_empty())? {
            return Err(Error::Run(
                "free bodies' modes in the pressure equation are not in the bodies' order".into(),
            ));
        }
        Ok(())
    }

    /// Finds the groups that have cells on several ranks, and sums the volumes. Collective.
    fn find_shared(&mut self) -> Result<()> {
        let begin = &self.layers[0].begin;
        let here = begin.windows(2).map(|range| f64::from(u8::from(range[1] > range[0])));
        self.volumes[3 * self.weights.len()..]
            .iter_mut()
            .zip(here)
            .for_each(|(count, here)| *count = here);
        self.session.sum(&mut self.volumes)?;
        let counts = self.volumes[3 * self.weights.len()..].iter();
        self.shared.groups.clear();
        self.shared.groups.extend(
            (0u32..).zip(counts).filter(|(_, count)| **count > 1.0).map(|(group, _)| group),
        );
        Ok(())
    }

    /// Whether there are any.
    pub fn any(&self) -> bool {
        !self.weights.is_empty()
    }

    /// Adds `sum_k w_k j_k (j_k . x)` cell by cell. Collective.
    pub fn add_product(
        &mut self,
        x: impl Fn(&Cell) -> f64,
        mut add: impl FnMut(&Cell, f64),
    ) -> Result<()> {
        if !self.any() {
            return Ok(());
        }
        let Bodies { session, weights, layers, sums, shared, .. } = self;
        let finest = &layers[0];
        finest.sum_up(session, shared, sums, x)?;
        let groups = sums.chunks_exact(3).zip(finest.begin.windows(2));
        for ((sum, range), w) in groups.zip(weights) {
            let back: [f64; 3] = std::array::from_fn(|a| w[a] * sum[a]);
            for cell in &finest.cells[range[0]..range[1]] {
                add(cell, back[0] * cell.j[0] + back[1] * cell.j[1] + back[2] * cell.j[2]);
            }
        }
        Ok(())
    }

    /// The modes that have a weight and cells here, one by one, as the operator has them.
    pub fn factors(&self) -> Vec<Factor> {
        let (mut factors, finest) = (Vec::new(), &self.layers[0]);
        for (group, range) in finest.begin.windows(2).enumerate() {
            let (cells, body) = (&finest.cells[range[0]..range[1]], self.owner[group] as usize);
            for mode in (0..3).filter(|mode| self.weights[group][*mode] != 0.0) {
                let entries = cells.iter().map(|cell| (cell.row, cell.j[mode]));
                let entries: Vec<_> = entries.filter(|(_, j)| *j != 0.0).collect();
                // The groups in which bodies turn come after one for each body.
                let origin = match group == body {
                    true => Origin::Translation { body, axis: mode },
                    false => Origin::Rotation { body, mode },
                };
                if !entries.is_empty() {
                    factors.push(Factor { origin, weight: self.weights[group][mode], entries });
                }
            }
        }
        factors
    }
}
