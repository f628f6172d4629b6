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
//! In the multigrid they take part on the levels that resolve them, with `j` summed over coarse
//! cells (`surface`); coarser levels see a mixture in their place: faces conduct, where a body
//! covers them, as a fluid of its density.

mod by_row;
mod groups;
mod shared;
mod surface;

use super::frame::Frame;
use super::level::{Level, Single};
use super::system::{Factor, Origin};
use crate::petsc::Session;
use crate::sharing::Sharing;
use crate::{Error, Result};
use by_row::ByRow;
use groups::Groups;
use shared::Shared;
use surface::{Smooth, SurfaceCells, SurfaceFace};

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

/// Density ratio, fluid over body, times the cells across the body, from which on the multigrid
/// takes bodies in, which costs it time: the more of them, the smaller they are.
const LIGHT: f64 = 4.5;

/// Largest conductance of bodies on a coarse level, relative to the fluid's: what light bodies
/// amount to between others.
const CONDUCTOR: f64 = 3.0;

/// Cells across a body that a level has to have to resolve it.
const RESOLVED: f64 = 3.5;

/// All bodies, as far as they lie on this rank.
pub(super) struct Bodies {
    session: Session,
    groups: Groups,
    shared: Shared,
    /// The smallest spacing over each axis's.
    inverse_h: [f64; 3],
    /// By level, as far as any level has had bodies.
    layers: Vec<SurfaceCells>,
    /// The finest level's cells as products take them.
    rows: ByRow,
    /// Three numbers a group: what a product or a sweep sums.
    sums: Vec<f64>,
    /// Cells across the largest of them, as far as is known.
    across: f64,
    /// The fluid's density over the lightest body's, times the cells across it, per unit of weight.
    lightest: f64,
    /// Cells across the widest body, from the cells that it fills: the same on all ranks.
    widest: f64,
    /// Whether any is light enough to take part in the multigrid.
    active: bool,
}

impl Bodies {
    pub fn new(session: &Session, axes: usize, inverse_h: [f64; 3]) -> Bodies {
        Bodies {
            session: session.clone(),
            groups: Groups { axes, ..Groups::default() },
            shared: Shared::new(session),
            inverse_h,
            layers: vec![SurfaceCells::default()],
            rows: ByRow::default(),
            sums: Vec::new(),
            across: 0.0,
            lightest: 0.0,
            widest: 0.0,
            active: false,
        }
    }

    /// See [`super::Poisson::set_modes`]; `scale` multiplies the weights.
    pub fn set(
        &mut self,
        frame: &Frame,
        weights: &[f64],
        covered: &[ModeFace],
        turning: &[u32],
        sharing: &Sharing,
        scale: f64,
    ) -> Result<()> {
        let Bodies { groups, shared, layers, inverse_h, rows, sums, .. } = self;
        groups.set(weights, turning, scale);
        sums.clear();
        sums.resize(3 * groups.weights.len(), 0.0);
        let unsound = groups.are_unsound(frame, weights, covered, turning);
        let covered = if unsound { &[] } else { covered };
        let strays = layers[0].take_covered(frame, groups, covered, inverse_h);
        let [nx, ny, nz] = frame.lattice.n;
        rows.sort(&layers[0], nx, ny * nz);
        shared.set(sharing, groups.bodies, turning);
        shared.sum(3, &mut groups.volumes)?;
        self.agree(unsound, strays)
    }

    /// Refuses what is unsound on any rank, and finds the lightest and the widest body of all.
    /// Collective.
    fn agree(&mut self, unsound: bool, strays: bool) -> Result<()> {
        let groups = &self.groups;
        let mut all = [groups.lightest(), groups.largest(), f64::from(unsound), f64::from(strays)];
        self.session.max(&mut all)?;
        let [lightest, most, unsound, strays] = all;
        self.lightest = lightest;
        self.widest = groups.cells_across(most);
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

    /// Takes the number of cells that the largest body spans.
    pub fn set_across(&mut self, cells: f64) {
        self.across = cells;
    }

    /// Whether there are any.
    pub fn any(&self) -> bool {
        !self.groups.weights.is_empty()
    }

    /// Takes x, a value by place, to `w_k (j_k . x)` of each mode, which [`Bodies::terms`] gives
    /// the cells; `begin` says where a row of the grid begins. Collective.
    pub fn respond(
        &mut self,
        begin: impl Fn(usize) -> usize,
        x: impl Fn(usize) -> f64,
    ) -> Result<()> {
        let Bodies { groups, sums, shared, rows, .. } = self;
        sums.fill(0.0);
        rows.add_up(sums, begin, x);
        shared.sum(3, sums)?;
        for (sum, w) in sums.chunks_exact_mut(3).zip(&groups.weights) {
            sum.iter_mut().zip(w).for_each(|(sum, w)| *sum *= *w);
        }
        Ok(())
    }

    /// Terms that the modes add to the cells of a row, by place in it.
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
            let body = self.groups.owner[group] as usize;
            for mode in (0..3).filter(|mode| self.groups.weights[group][*mode] != 0.0) {
                let entries = cells.iter().map(|cell| (cell.row, cell.j[mode]));
                let entries: Vec<_> = entries.filter(|(_, j)| *j != 0.0).collect();
                // The groups in which bodies turn come after one for each body.
                let origin = match group == body {
                    true => Origin::Translation { body, axis: mode },
                    false => Origin::Rotation { body, mode },
                };
                if !entries.is_empty() {
                    factors.push(Factor {
                        origin,
                        weight: self.groups.weights[group][mode],
                        entries,
                    });
                }
            }
        }
        factors
    }

    /// Whether the multigrid's level `l` has bodies.
    pub fn on(&self, l: usize) -> bool {
        self.active && l < self.layers.len() && !self.layers[l].smooth.is_empty()
    }

    /// Number of levels that resolve the largest body.
    pub fn resolving(&self) -> usize {
        let levels = |l: &usize| self.across >= RESOLVED * (1u64 << l) as f64;
        (0..30).take_while(levels).count()
    }

    /// Makes ready for smoothing on level `l`, in units in which the finest level's largest face is
    /// 1: `scale` times the weights. Raises the diagonal where bodies lie. Collective.
    pub fn prepare(&mut self, l: usize, level: &mut Level, scale: f64) -> Result<()> {
        if l == 0 {
            // In these units a weight times the body's cells is the fluid's density over the
            // body's.
            self.active = self.lightest * scale >= LIGHT;
            self.layers[0].smooth.resize(self.groups.weights.len(), Smooth::default());
        }
        if !self.on(l) {
            return Ok(());
        }
        self.layers[l].prepare(&self.groups, &mut self.shared, level, scale)
    }

    /// Takes the bodies from level `l` to the next: those that it resolves as they are, the others
    /// into its faces, of which one of the finest level's own conducts `unit` by axis; `scale` as
    /// in [`Bodies::prepare`].
    pub fn descend(
        &mut self,
        l: usize,
        fine: &Level,
        coarse: &mut Level,
        unit: [f64; 3],
        scale: f64,
        last: bool,
    ) {
        if self.layers.len() < l + 2 {
            self.layers.push(SurfaceCells::default());
        }
        let on = self.on(l);
        let Bodies { groups, inverse_h, layers, widest, .. } = self;
        let resolves = |across: f64| across >= RESOLVED * (1u64 << (l + 1)) as f64 && !last;
        let (upper, lower) = layers.split_at_mut(l + 1);
        let from = &upper[l];
        let to = &mut lower[0];
        to.clear(&coarse.lattice);
        to.smooth.clear();
        if !on {
            return;
        }
        if to.faces.capacity() < from.faces.len() {
            to.faces.reserve(2 * from.faces.len());
            to.cells.reserve(2 * from.faces.len());
        }
        let mut rest = &from.faces[..];
        for (group, owner) in groups.owner.iter().map(|k| *k as usize).enumerate() {
            let count = rest.iter().take_while(|face| face.group as usize == group).count();
            let (own, others) = rest.split_at(count);
            rest = others;
            let first = to.faces.len();
            if resolves(groups.across(owner)) {
                to.take_faces(own, fine, coarse, first);
            } else if owner == group {
                // The mixture in the body's place turns too, so that rotation needs no term.
                let conductance: [f64; 3] = std::array::from_fn(|axis| {
                    let lightness =
                        groups.weights[group][axis] * scale * groups.volumes[3 * group + axis];
                    lightness.min(CONDUCTOR) * unit[axis]
                });
                conduct(own, &conductance, fine, coarse);
            }
            to.collect(&coarse.lattice, inverse_h, first);
        }
        // Needed also where all bodies that it resolves lie on other ranks, with which it sums.
        if resolves(*widest) {
            to.smooth.resize(groups.weights.len(), Smooth::default());
        }
    }

    /// Corrects the sweep by `omega` that the diagonal alone has done on level `l`, from zero or
    /// not. Collective.
    pub fn correct(
        &mut self,
        l: usize,
        level: &mut Level,
        omega: Single,
        from_zero: bool,
    ) -> Result<()> {
        self.layers[l].correct(&mut self.shared, &mut self.sums, level, omega, from_zero)
    }

    /// Takes the bodies' part out of the next level's b. Collective.
    pub fn restrict(&mut self, l: usize, level: &Level, coarse: &mut Level) -> Result<()> {
        if !self.on(l) {
            return Ok(());
        }
        self.layers[l].restrict(&mut self.shared, &mut self.sums, level, coarse)
    }
}

/// Adds to the coarse level's coefficient what faces of a body conduct, which have this
/// conductance by axis.
fn conduct(own: &[SurfaceFace], conductance: &[f64; 3], fine: &Level, coarse: &mut Level) {
    for face in own {
        let axis = face.axis as usize;
        if let Some((place, ratio)) = fine.coarse_face(coarse, axis, face.place as usize) {
            coarse.g[axis][place] += (conductance[axis] * face.conduct) as Single * ratio;
        }
    }
}
