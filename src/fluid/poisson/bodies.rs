//! Free rigid bodies in the pressure equation, `sum_k w_k j_k j_k^T`, applied and never assembled; a mode k is one
//! direction in which one body moves, and
//!
//! ```text
//!   j_c = (m_low - m_high)/h     m: the part of a face that the body covers, along the mode's axis
//!   s_k = j_k . x                over this rank's cells, then one sum over the ranks for all k
//!   y  += sum_k (w_k s_k) j_k
//! ```
//! In the multigrid they take part on the finest level: a sweep solves with `D + sum w j j^T` in place of D, for each body
//! by itself,
//!
//! ```text
//!   (D + J W J^T)^-1 = D^-1 - D^-1 J (W^-1 + J^T D^-1 J)^-1 J^T D^-1
//! ```
//! and coarser levels see a mixture in their place: faces conduct, where a body covers them, as a fluid of its density.

use super::lattice::Lattice;
use super::level::{Level, Single};
use crate::petsc::Session;
use crate::{Error, Result};

/// A face that a free body covers, in part or whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covered {
    /// The mode: `axes * body + axis`, from 0, the same on every rank.
    pub mode: u32,
    /// Index of the face in this rank's fields, along the mode's axis.
    pub face: u32,
    /// The covered part, within (0, 1].
    pub part: f64,
}

/// A cell of a body's surface.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    /// Its number among this rank's.
    row: u32,
    /// Its place in the lattice.
    place: u32,
    /// j along each axis, in units of the smallest spacing.
    j: [f64; 3],
}

/// A cell, a face and a body as the multigrid has them.
#[derive(Clone, Copy, Debug, Default)]
struct Smooth {
    /// `(W^-1 + J^T D^-1 J)^-1`.
    block: [[Single; 3]; 3],
    /// The weights, so far as smoothing takes them.
    weight: [Single; 3],
    /// What goes back to the cells.
    back: [Single; 3],
}

/// All bodies, as far as they lie on this rank.
pub(super) struct Bodies {
    session: Session,
    axes: usize,
    weights: Vec<[f64; 3]>,
    /// Where each body's cells begin, and where the last one's end.
    begin: Vec<usize>,
    cells: Vec<Cell>,
    covered: Vec<Covered>,
    /// Three numbers a body that the ranks sum.
    sums: Vec<f64>,
    /// At a cell's place, its number in `cells` while its body's are collected.
    found: Vec<u32>,
    smooth: Vec<Smooth>,
    /// Nine numbers a body that the ranks sum.
    grams: Vec<f64>,
    /// Whether they weigh enough to take part in the multigrid.
    pub active: bool,
}

/// Largest `w j^T D^-1 j` that smoothing takes: neighbours that share cells would make it indefinite beyond.
const HEAVIEST: f64 = 3.0;

/// `w j^T D^-1 j` from which on the multigrid takes bodies in, which costs it time: below four of the fluid's densities.
const LIGHT: f64 = 0.15;

/// How much of `j^2` goes into the diagonal: cells that bodies close from all sides have next to none of their own.
const FLOOR: f64 = 0.1;

/// The blocks' safety: bodies that share cells are taken one by one.
const SHARED: f64 = 1.3;

/// The best conductor, relative to the fluid, that a coarse level knows: what light bodies amount to between others.
const CONDUCTOR: f64 = 3.0;

/// No cell.
const NONE: u32 = u32::MAX;

/// The way from a field's indices to a lattice's.
pub(super) struct Frame {
    /// Strides, stored cells and layers of ghosts of a field.
    pub stride: [usize; 3],
    pub stored: [usize; 3],
    pub ghosts: usize,
    /// The smallest spacing over each axis's.
    pub inverse_h: [f64; 3],
}

impl Bodies {
    pub fn new(session: &Session, axes: usize) -> Bodies {
        Bodies {
            session: session.clone(),
            axes,
            weights: Vec::new(),
            begin: vec![0],
            cells: Vec::new(),
            covered: Vec::new(),
            sums: Vec::new(),
            found: Vec::new(),
            smooth: Vec::new(),
            grams: Vec::new(),
            active: false,
        }
    }

    /// See [`super::Poisson::set_modes`]; `scale` multiplies the weights.
    pub fn set(
        &mut self,
        lattice: &Lattice,
        frame: &Frame,
        weights: &[f64],
        covered: &[Covered],
        scale: f64,
    ) -> Result<()> {
        let axes = self.axes;
        let stored: usize = frame.stored.iter().product();
        let mut unsound = !weights.len().is_multiple_of(axes) || weights.iter().any(|w| !w.is_finite() || *w < 0.0);
        unsound |= covered.iter().any(|e| {
            e.mode as usize >= weights.len() || e.face as usize >= stored || !(e.part > 0.0 && e.part.is_finite())
        });
        if self.session.anywhere(unsound)? {
            return Err(Error::Run(
                "a free body's mode in the pressure equation is not finite, has a negative weight, or has a face that \
                 is not its rank's"
                    .into(),
            ));
        }
        if self.found.is_empty() {
            self.found = vec![NONE; lattice.len];
        }
        self.weights.clear();
        self.weights.extend(weights.chunks(axes).map(|w| std::array::from_fn(|a| w.get(a).map_or(0.0, |w| w * scale))));
        self.covered.clear();
        // Bodies that move cut now more cells, now fewer.
        if self.covered.capacity() < covered.len() {
            self.covered.reserve(2 * covered.len());
        }
        self.cells.clear();
        self.begin.clear();
        self.begin.push(0);
        let mut rest = covered;
        for body in 0..self.weights.len() {
            let count = rest.iter().take_while(|e| e.mode as usize / axes == body).count();
            let (own, others) = rest.split_at(count);
            rest = others;
            self.collect(lattice, frame, own);
        }
        // A body's faces have to stand together.
        if self.session.anywhere(!rest.is_empty())? {
            return Err(Error::Run("free bodies' modes in the pressure equation are not in the bodies' order".into()));
        }
        self.sums.resize(3 * self.weights.len(), 0.0);
        self.smooth.resize(self.weights.len(), Smooth::default());
        self.grams.resize(9 * self.weights.len(), 0.0);
        Ok(())
    }

    /// One body's cells, from its faces.
    fn collect(&mut self, lattice: &Lattice, frame: &Frame, own: &[Covered]) {
        let start = self.cells.len();
        for e in own {
            let axis = e.mode as usize % self.axes;
            let at: [usize; 3] = std::array::from_fn(|a| match a < self.axes {
                true => (e.face as usize / frame.stride[a] % frame.stored[a] + 1).wrapping_sub(frame.ghosts),
                false => 1,
            });
            // Counted from 1, the first ghost at 0.
            let inside = |a: usize| (1..=lattice.n[a]).contains(&at[a]);
            if (0..self.axes).any(|a| a != axis && !inside(a)) || at[axis] == 0 || at[axis] > lattice.n[axis] + 1 {
                continue;
            }
            let place: usize = (0..self.axes).map(|a| at[a] * lattice.stride[a]).sum();
            self.covered.push(Covered { face: place as u32, ..*e });
            let j = e.part * frame.inverse_h[axis];
            let number = |axis_at: usize| {
                let at = |a: usize| (if a == axis { axis_at } else { at[a] }) - 1;
                at(0) + lattice.n[0] * (at(1) + lattice.n[1] * at(2))
            };
            for (low, value) in [(1, j), (0, -j)] {
                let axis_at = at[axis] - low;
                if !(1..=lattice.n[axis]).contains(&axis_at) {
                    continue;
                }
                let here = place - low * lattice.stride[axis];
                if self.found[here] == NONE {
                    self.found[here] = self.cells.len() as u32;
                    self.cells.push(Cell { row: number(axis_at) as u32, place: here as u32, j: [0.0; 3] });
                }
                self.cells[self.found[here] as usize].j[axis] += value;
            }
        }
        for cell in &self.cells[start..] {
            self.found[cell.place as usize] = NONE;
        }
        // Where a body covers both faces alike nothing is left.
        let mut kept = start;
        for k in start..self.cells.len() {
            if self.cells[k].j != [0.0; 3] {
                self.cells[kept] = self.cells[k];
                kept += 1;
            }
        }
        self.cells.truncate(kept);
        self.begin.push(kept);
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// y += sum_k w_k j_k (j_k . x). Collective.
    pub fn add_product(&mut self, x: &[f64], y: &mut [f64]) -> Result<()> {
        if self.is_empty() {
            return Ok(());
        }
        let Bodies { session, weights, begin, cells, sums, .. } = self;
        for (sum, range) in sums.chunks_exact_mut(3).zip(begin.windows(2)) {
            sum.fill(0.0);
            for cell in &cells[range[0]..range[1]] {
                let x = x[cell.row as usize];
                (0..3).for_each(|a| sum[a] += cell.j[a] * x);
            }
        }
        session.sum(sums)?;
        for ((sum, range), w) in sums.chunks_exact(3).zip(begin.windows(2)).zip(weights) {
            let back: [f64; 3] = std::array::from_fn(|a| w[a] * sum[a]);
            for cell in &cells[range[0]..range[1]] {
                y[cell.row as usize] += back[0] * cell.j[0] + back[1] * cell.j[1] + back[2] * cell.j[2];
            }
        }
        Ok(())
    }

    /// What smoothing needs, in units in which the finest level's largest face is 1: `scale` times the weights. Raises the
    /// diagonal where bodies lie. Collective.
    pub fn prepare(&mut self, finest: &mut Level, scale: f64) -> Result<()> {
        let Bodies { session, axes, weights, begin, cells, grams, smooth, active, .. } = self;
        *active = !weights.is_empty();
        if !*active {
            return Ok(());
        }
        for (gram, range) in grams.chunks_exact_mut(9).zip(begin.windows(2)) {
            gram.fill(0.0);
            for cell in &cells[range[0]..range[1]] {
                let own = f64::from(finest.inverse[cell.place as usize]);
                let d = if own > 0.0 { 1.0 / own } else { 0.0 };
                let inverse = 1.0 / (d + FLOOR * cell.j.iter().map(|j| j * j).sum::<f64>());
                for (p, q) in (0..3).flat_map(|p| (0..3).map(move |q| (p, q))) {
                    gram[3 * p + q] += inverse * cell.j[p] * cell.j[q];
                }
            }
        }
        session.sum(grams)?;
        let mut strongest = 0.0f64;
        for ((gram, w), smooth) in grams.chunks_exact(9).zip(weights.iter()).zip(smooth.iter_mut()) {
            let mut block = nalgebra::Matrix3::identity();
            for p in 0..*axes {
                let (w, d) = (w[p] * scale, gram[4 * p]);
                let taken = if d > 0.0 { w.min(HEAVIEST / d) } else { 0.0 };
                strongest = strongest.max(taken * d);
                smooth.weight[p] = taken as Single;
                for q in 0..*axes {
                    block[(p, q)] = SHARED * gram[3 * p + q];
                }
                // A direction that is held: an infinite 1/w would do.
                block[(p, p)] += SHARED * if taken > 0.0 { 1.0 / taken } else { 1e12 * (1.0 + d) };
            }
            let inverse = block.try_inverse().unwrap_or_else(nalgebra::Matrix3::zeros);
            smooth.block = std::array::from_fn(|p| std::array::from_fn(|q| inverse[(p, q)] as Single));
        }
        *active = strongest >= LIGHT;
        if *active {
            // The sum over bodies that share a cell.
            for cell in cells.iter() {
                let (inverse, j2) =
                    (&mut finest.inverse[cell.place as usize], cell.j.iter().map(|j| j * j).sum::<f64>());
                let d = if *inverse > 0.0 { 1.0 / f64::from(*inverse) } else { 0.0 };
                *inverse = (1.0 / (d + FLOOR * j2)) as Single;
            }
        }
        Ok(())
    }

    /// Adds to the faces of the level below the finest what covers them; `unit` is a face's own conductance in the
    /// finest, by axis, and `scale` as in [`Bodies::prepare`].
    pub fn thicken(&mut self, finest: &Level, coarse: &mut Level, unit: [f64; 3], scale: f64) -> Result<()> {
        if !self.active {
            return Ok(());
        }
        let Bodies { session, axes, weights, covered, sums, .. } = self;
        // A body's cells: the sum of what it covers along any axis; faces between ranks count on the upper one.
        sums.fill(0.0);
        let lattice = finest.lattice;
        for e in covered.iter() {
            let (body, axis) = (e.mode as usize / *axes, e.mode as usize % *axes);
            let at = e.face as usize / lattice.stride[axis] % (lattice.n[axis] + 2);
            if at <= lattice.n[axis] {
                sums[3 * body + axis] += e.part;
            }
        }
        session.sum(sums)?;
        for e in covered.iter() {
            let (body, axis) = (e.mode as usize / *axes, e.mode as usize % *axes);
            // In these units a fluid's weight for a body of one cell is the inverse of the smallest spacing's face.
            let density = weights[body][axis] * scale * sums[3 * body + axis];
            let add = density.min(CONDUCTOR) * unit[axis] * e.part;
            finest.add_to_coarse_face(coarse, axis, e.face as usize, add as Single);
        }
        Ok(())
    }

    /// Mends the sweep by `omega` that D alone has done: from `next` (before the sweep; zero if `from_zero`) to `x`.
    pub fn mend(&mut self, level: &mut Level, omega: Single, from_zero: bool) -> Result<()> {
        if !self.active {
            return Ok(());
        }
        if !from_zero {
            // x -= omega D^-1 J W J^T x_before
            self.sum_up(|place| level.next[place])?;
            for (smooth, sum) in self.smooth.iter_mut().zip(self.sums.chunks_exact(3)) {
                smooth.back = std::array::from_fn(|a| smooth.weight[a] * sum[a] as Single);
            }
            self.spread(level, omega);
        }
        // x -= omega D^-1 J (W^-1 + J^T D^-1 J)^-1 J^T (x - x_before)/omega
        self.sum_up(|place| (level.x[place] - if from_zero { 0.0 } else { level.next[place] }) / omega)?;
        for (smooth, sum) in self.smooth.iter_mut().zip(self.sums.chunks_exact(3)) {
            let s = [0, 1, 2].map(|a| sum[a] as Single);
            smooth.back = smooth.block.map(|row| row[0] * s[0] + row[1] * s[1] + row[2] * s[2]);
        }
        self.spread(level, omega);
        Ok(())
    }

    /// Takes the bodies' part out of the next level's b.
    pub fn restrict(&mut self, level: &Level, coarse: &mut Level) -> Result<()> {
        if !self.active {
            return Ok(());
        }
        self.sum_up(|place| level.x[place])?;
        for ((smooth, sum), range) in self.smooth.iter().zip(self.sums.chunks_exact(3)).zip(self.begin.windows(2)) {
            let back: [Single; 3] = std::array::from_fn(|a| smooth.weight[a] * sum[a] as Single);
            for cell in &self.cells[range[0]..range[1]] {
                let place = level.coarse_place(coarse, cell.place as usize);
                coarse.b[place] -= dot(&back, &cell.j);
            }
        }
        Ok(())
    }

    fn sum_up(&mut self, value: impl Fn(usize) -> Single) -> Result<()> {
        for (sum, range) in self.sums.chunks_exact_mut(3).zip(self.begin.windows(2)) {
            sum.fill(0.0);
            for cell in &self.cells[range[0]..range[1]] {
                let x = f64::from(value(cell.place as usize));
                (0..3).for_each(|a| sum[a] += cell.j[a] * x);
            }
        }
        self.session.sum(&mut self.sums)
    }

    fn spread(&self, level: &mut Level, omega: Single) {
        for (smooth, range) in self.smooth.iter().zip(self.begin.windows(2)) {
            for cell in &self.cells[range[0]..range[1]] {
                let place = cell.place as usize;
                level.x[place] -= omega * level.inverse[place] * dot(&smooth.back, &cell.j);
            }
        }
    }
}

fn dot(a: &[Single; 3], j: &[f64; 3]) -> Single {
    a[0] * j[0] as Single + a[1] * j[1] as Single + a[2] * j[2] as Single
}
