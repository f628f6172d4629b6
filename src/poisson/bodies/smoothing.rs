//! Bodies in the multigrid: on the levels that resolve them a sweep solves with
//!
//! ```text
//!   (D + J W J^T)^-1 = D^-1 - D^-1 J (W^-1 + J^T D^-1 J)^-1 J^T D^-1
//! ```
//! in place of D, for each body by itself and for its rotation by itself; coarser levels see a
//! mixture in their place: faces conduct, where a body covers them, as a fluid of its density.

use super::super::level::{Level, Single};
use super::surface::{Face, Smooth, SurfaceCells, dot};
use super::{Bodies, cells_across};
use crate::Result;

/// Largest `w j^T D^-1 j` that smoothing takes: neighbours that share cells would make it
/// indefinite beyond.
const HEAVIEST: f64 = 3.0;

/// The fluid's density over a body's, times the cells across it, from which on the multigrid takes
/// bodies in, which costs it time: the more of them, the smaller they are.
const LIGHT: f64 = 4.5;

/// How much of `j^2` goes into the diagonal: cells that bodies close from all sides have next to
/// none of their own.
const FLOOR: f64 = 0.1;

/// The blocks' safety: bodies that share cells are taken one by one.
const SHARED: f64 = 1.3;

/// The best conductor, relative to the fluid, that a coarse level knows: what light bodies amount
/// to between others.
const CONDUCTOR: f64 = 3.0;

/// Cells across a body that a level has to have to resolve it.
const RESOLVED: f64 = 3.5;

impl Bodies {
    /// Whether the multigrid's level `l` has bodies.
    pub fn on(&self, l: usize) -> bool {
        self.active && l < self.layers.len() && !self.layers[l].smooth.is_empty()
    }

    /// How many levels resolve the largest body.
    pub fn resolving(&self) -> usize {
        let levels = |l: &usize| self.across >= RESOLVED * (1u64 << l) as f64;
        (0..30).take_while(levels).count()
    }

    /// What smoothing needs on level `l`, in units in which the finest level's largest face is 1:
    /// `scale` times the weights. Raises the diagonal where bodies lie. Collective.
    pub fn prepare(&mut self, l: usize, level: &mut Level, scale: f64) -> Result<()> {
        if l == 0 {
            // In these units a weight times the body's cells is the fluid's density over the
            // body's.
            self.active = self.lightest * scale >= LIGHT;
            self.layers[0].smooth.resize(self.weights.len(), Smooth::default());
        }
        if !self.on(l) {
            return Ok(());
        }
        let Bodies { axes, weights, layers, shared, .. } = self;
        let SurfaceCells { begin, cells, smooth, grams, .. } = &mut layers[l];
        grams.resize(9 * weights.len(), 0.0);
        // Every sweep goes through them four times, the sooner the nearer they lie to each other.
        for range in begin.windows(2) {
            cells[range[0]..range[1]].sort_unstable_by_key(|cell| cell.place);
        }
        let raised = |inverse: Single, j: &[f64; 3]| {
            let d = if inverse > 0.0 { 1.0 / f64::from(inverse) } else { 0.0 };
            1.0 / (d + FLOOR * j.iter().map(|j| j * j).sum::<f64>())
        };
        for (gram, range) in grams.chunks_exact_mut(9).zip(begin.windows(2)) {
            gram.fill(0.0);
            for cell in &cells[range[0]..range[1]] {
                let inverse = raised(level.inverse[cell.place as usize], &cell.j);
                for (p, q) in (0..3).flat_map(|p| (0..3).map(move |q| (p, q))) {
                    gram[3 * p + q] += inverse * cell.j[p] * cell.j[q];
                }
            }
        }
        shared.sum(9, grams)?;
        for ((gram, w), smooth) in grams.chunks_exact(9).zip(weights.iter()).zip(smooth.iter_mut())
        {
            let mut block = nalgebra::Matrix3::identity();
            for p in 0..*axes {
                let w = w[p] * scale;
                let d = gram[4 * p];
                let taken = if d > 0.0 { w.min(HEAVIEST / d) } else { 0.0 };
                smooth.weight[p] = taken as Single;
                for q in 0..*axes {
                    block[(p, q)] = SHARED * gram[3 * p + q];
                }
                // A direction that is held: an infinite 1/w would do.
                block[(p, p)] += SHARED * if taken > 0.0 { 1.0 / taken } else { 1e12 * (1.0 + d) };
            }
            let inverse = block.try_inverse().unwrap_or_else(nalgebra::Matrix3::zeros);
            smooth.block =
                std::array::from_fn(|p| std::array::from_fn(|q| inverse[(p, q)] as Single));
        }
        // Bodies that share a cell raise it in turn.
        for cell in cells.iter() {
            let inverse = &mut level.inverse[cell.place as usize];
            *inverse = raised(*inverse, &cell.j) as Single;
        }
        Ok(())
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
        let Bodies { axes, weights, owner, inverse_h, layers, volumes, widest, .. } = self;
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
        for (group, owner) in owner.iter().map(|k| *k as usize).enumerate() {
            let count = rest.iter().take_while(|face| face.group as usize == group).count();
            let (own, others) = rest.split_at(count);
            rest = others;
            let first = to.faces.len();
            let volume = volumes[3 * owner..][..3].iter().fold(0.0f64, |most, v| most.max(*v));
            if resolves(cells_across(volume, *axes)) {
                to.take_faces(own, fine, coarse, first);
            } else if owner == group {
                // What takes the body's place turns as well.
                let conductance: [f64; 3] = std::array::from_fn(|axis| {
                    let lightness = weights[group][axis] * scale * volumes[3 * group + axis];
                    lightness.min(CONDUCTOR) * unit[axis]
                });
                conduct(own, &conductance, fine, coarse);
            }
            to.collect(&coarse.lattice, inverse_h, first);
        }
        // Also where all that it resolves lie on other ranks, with which it sums.
        if resolves(*widest) {
            to.smooth.resize(weights.len(), Smooth::default());
        }
    }

    /// Corrects the sweep by `omega` that D alone has done: from `next` (before the sweep; zero if
    /// `from_zero`) to `x`.
    pub fn correct(
        &mut self,
        l: usize,
        level: &mut Level,
        omega: Single,
        from_zero: bool,
    ) -> Result<()> {
        let Bodies { layers, sums, shared, .. } = self;
        let layer = &mut layers[l];
        if !from_zero {
            // x -= omega D^-1 J W J^T x_before
            layer.sum_up(shared, sums, |cell| f64::from(level.next[cell.place as usize]))?;
            for (smooth, sum) in layer.smooth.iter_mut().zip(sums.chunks_exact(3)) {
                smooth.back = std::array::from_fn(|a| smooth.weight[a] * sum[a] as Single);
            }
            layer.spread(level, omega);
        }
        // x -= omega D^-1 J (W^-1 + J^T D^-1 J)^-1 J^T (x - x_before)/omega
        layer.sum_up(shared, sums, |cell| {
            let place = cell.place as usize;
            f64::from((level.x[place] - if from_zero { 0.0 } else { level.next[place] }) / omega)
        })?;
        for (smooth, sum) in layer.smooth.iter_mut().zip(sums.chunks_exact(3)) {
            let s = [0, 1, 2].map(|a| sum[a] as Single);
            smooth.back = smooth.block.map(|row| row[0] * s[0] + row[1] * s[1] + row[2] * s[2]);
        }
        layer.spread(level, omega);
        Ok(())
    }

    /// Takes the bodies' part out of the next level's b.
    pub fn restrict(&mut self, l: usize, level: &Level, coarse: &mut Level) -> Result<()> {
        if !self.on(l) {
            return Ok(());
        }
        let Bodies { layers, sums, shared, .. } = self;
        let layer = &layers[l];
        layer.sum_up(shared, sums, |cell| f64::from(level.x[cell.place as usize]))?;
        for ((smooth, sum), range) in
            layer.smooth.iter().zip(sums.chunks_exact(3)).zip(layer.begin.windows(2))
        {
            let back: [Single; 3] = std::array::from_fn(|a| smooth.weight[a] * sum[a] as Single);
            for cell in &layer.cells[range[0]..range[1]] {
                let place = level.coarse_place(coarse, cell.place as usize);
                coarse.b[place] -= dot(&back, &cell.j);
            }
        }
        Ok(())
    }
}

/// Adds to the coarse level's coefficient what faces of a body conduct, which have this
/// conductance by axis.
fn conduct(own: &[Face], conductance: &[f64; 3], fine: &Level, coarse: &mut Level) {
    for face in own {
        let axis = face.axis as usize;
        if let Some((place, ratio)) = fine.coarse_face(coarse, axis, face.place as usize) {
            coarse.g[axis][place] += (conductance[axis] * face.conduct) as Single * ratio;
        }
    }
}
