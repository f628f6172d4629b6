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

mod by_row;
mod shared;
mod smoothing;
mod surface;

use super::lattice::Lattice;
use super::system::{Factor, Origin};
use crate::petsc::Session;
use crate::sharing::Sharing;
use crate::{Error, Result};
use by_row::ByRow;
use shared::Shared;
use std::f64::consts::PI;
use surface::{Face, SurfaceCells};

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
    /// The cells that each body fills, by axis, and nothing for its turning: three numbers a group,
    /// summed over the ranks that have it.
    volumes: Vec<f64>,
    /// Cells across the largest of them, as far as is known.
    across: f64,
    shared: Shared,
    sums: Vec<f64>,
    /// The finest level's cells as products take them.
    rows: ByRow,
    /// The fluid's density over the lightest body's, times the cells across it, per unit of weight.
    lightest: f64,
    /// Cells across the widest body by what it fills: the same on all ranks.
    widest: f64,
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
        let index = |a: usize| (face.face / self.stride[a] as u32 % self.stored[a] as u32) as usize;
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
            across: 0.0,
            shared: Shared::new(session),
            rows: ByRow::default(),
            lightest: 0.0,
            widest: 0.0,
            sums: Vec::new(),
            active: false,
        }
    }

    /// See [`super::Poisson::set_modes`]; `scale` multiplies the weights.
    pub fn set(
        &mut self,
        (lattice, frame): (&Lattice, &Frame),
        weights: &[f64],
        covered: &[ModeFace],
        turning: &[u32],
        sharing: &Sharing,
        scale: f64,
    ) -> Result<()> {
        let groups = weights.len() / self.axes;
        let bodies = groups.saturating_sub(turning.len());
        let unsound = self.is_unsound(frame, weights, covered, turning, groups, bodies);
        self.weights.clear();
        self.weights.extend(
            weights
                .chunks(self.axes)
                .map(|w| std::array::from_fn(|a| w.get(a).map_or(0.0, |w| w * scale))),
        );
        self.owner.clear();
        self.owner.extend((0..bodies as u32).chain(turning.iter().copied()));
        for numbers in [&mut self.sums, &mut self.volumes] {
            numbers.clear();
            numbers.resize(3 * self.weights.len(), 0.0);
        }
        let covered = if unsound { &[] } else { covered };
        let strays = self.take_faces(lattice, frame, covered, bodies);
        self.rows.sort(&self.layers[0], lattice.n[0], lattice.n[1] * lattice.n[2]);
        self.shared.set(sharing, bodies, turning);
        self.shared.sum(3, &mut self.volumes)?;
        self.agree(unsound, strays)
    }

    /// Refuses what is unsound on any rank, and finds the lightest and the widest body of all.
    /// Collective.
    fn agree(&mut self, unsound: bool, strays: bool) -> Result<()> {
        let of_body = |(v, w): (&f64, &f64)| v * w * cells_across(*v, self.axes);
        let light = self.volumes.iter().zip(self.weights.iter().flatten()).map(of_body);
        let most = self.volumes.iter().copied().fold(0.0, f64::max);
        let mut all = [light.fold(0.0, f64::max), most, f64::from(unsound), f64::from(strays)];
        self.session.max(&mut all)?;
        let [lightest, most, unsound, strays] = all;
        self.lightest = lightest;
        self.widest = cells_across(most, self.axes);
        if unsound > 0.0 {
            return Err(Error::Run(
                "a free body's mode in the pressure equation is not finite, has a negative weight, \
                or has a face that is not its rank's"
                    .into(),
            ));
        }
        if strays > 0.0 {
            return Err(Error::Run(
                "free bodies' modes in the pressure equation are not in the bodies' order".into(),
            ));
        }
        Ok(())
    }

    /// Takes how many cells the largest body spans.
    pub fn set_across(&mut self, cells: f64) {
        self.across = cells;
    }

    /// Whether these numbers are no modes.
    fn is_unsound(
        &self,
        frame: &Frame,
        weights: &[f64],
        covered: &[ModeFace],
        turning: &[u32],
        groups: usize,
        bodies: usize,
    ) -> bool {
        let axes = self.axes;
        let stored = frame.stored.iter().product::<usize>();
        let mut unsound = !weights.len().is_multiple_of(axes)
            || weights.iter().any(|w| !w.is_finite() || *w < 0.0);
        unsound |= turning.len() > groups || turning.iter().any(|k| *k as usize >= bodies);
        unsound |= covered.iter().any(|e| {
            let mode = e.mode as usize;
            let axis = e.axis as usize;
            let moves = axis == mode % axes && e.part > 0.0;
            let known = mode < weights.len() && axis < axes && (e.face as usize) < stored;
            !(known && e.part.is_finite() && (moves || mode / axes >= bodies))
        });
        unsound
    }

    /// Takes the covered faces of all groups to the finest level, with the cells beside them and
    /// the volumes of the bodies. Returns whether there are faces out of the groups' order: those
    /// of a group have to stand together.
    fn take_faces(
        &mut self,
        lattice: &Lattice,
        frame: &Frame,
        covered: &[ModeFace],
        bodies: usize,
    ) -> bool {
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
                let axis = e.axis as usize;
                let mode = (e.mode as usize % axes) as u8;
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
        !rest.is_empty()
    }

    /// Whether there are any.
    pub fn any(&self) -> bool {
        !self.weights.is_empty()
    }

    /// Takes x, a value by place, to `w_k (j_k . x)` of each mode, which [`Bodies::terms`] gives
    /// the cells; `begin` says where a row of the grid begins. Collective.
    pub fn respond(
        &mut self,
        begin: impl Fn(usize) -> usize,
        x: impl Fn(usize) -> f64,
    ) -> Result<()> {
        let Bodies { weights, sums, shared, rows, .. } = self;
        sums.fill(0.0);
        rows.add_up(sums, begin, x);
        shared.sum(3, sums)?;
        for (sum, w) in sums.chunks_exact_mut(3).zip(weights) {
            sum.iter_mut().zip(w).for_each(|(sum, w)| *sum *= *w);
        }
        Ok(())
    }

    /// What the modes add to the cells of a row, by place in it.
    #[inline(always)]
    pub fn terms(&self, row: usize) -> impl Iterator<Item = (usize, f64)> {
        self.rows.row(row).iter().map(
            #[inline(always)]
            |cell| {
                let back = &self.sums[3 * cell.group as usize..][..3];
                let value = back[0] * cell.j[0] + back[1] * cell.j[1] + back[2] * cell.j[2];
                (cell.at as usize, value)
            },
        )
    }

    /// The modes that have a weight and cells here, one by one, as the operator has them.
    pub fn factors(&self) -> Vec<Factor> {
        let mut factors = Vec::new();
        let finest = &self.layers[0];
        for (group, range) in finest.begin.windows(2).enumerate() {
            let cells = &finest.cells[range[0]..range[1]];
            let body = self.owner[group] as usize;
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

/// Cells across a disc or sphere that fills so many.
fn cells_across(volume: f64, axes: usize) -> f64 {
    if axes == 2 { (volume * 4.0 / PI).sqrt() } else { (volume * 6.0 / PI).cbrt() }
}
