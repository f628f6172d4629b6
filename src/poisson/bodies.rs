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
//! cells: a sweep solves with `D + sum w j j^T` in place of D, for each body by itself, and for its
//! turning by itself,
//!
//! ```text
//!   (D + J W J^T)^-1 = D^-1 - D^-1 J (W^-1 + J^T D^-1 J)^-1 J^T D^-1
//! ```
//! and coarser levels see a mixture in their place: faces conduct, where a body covers them, as a
//! fluid of its density.

use super::lattice::Lattice;
use super::level::{Level, Single};
use crate::petsc::Session;
use crate::{Error, Result};
use std::f64::consts::PI;

/// A face that a free body covers, in part or whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covered {
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

/// A cell of a body's surface.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    /// Its number among this rank's.
    row: u32,
    /// Its place in the lattice.
    place: u32,
    /// j of each of the group's modes, in units of the smallest spacing.
    j: [f64; 3],
}

/// A covered face of a level.
#[derive(Clone, Copy, Debug)]
struct Face {
    group: u32,
    /// Which of the group's modes.
    mode: u8,
    axis: u8,
    place: u32,
    /// Covered parts of the finest level's faces in it, summed; and so that they conduct.
    part: f64,
    conduct: f64,
}

/// A group as a level smooths it.
#[derive(Clone, Copy, Debug, Default)]
struct Smooth {
    /// `(W^-1 + J^T D^-1 J)^-1`.
    block: [[Single; 3]; 3],
    /// The weights, so far as smoothing takes them.
    weight: [Single; 3],
    /// What goes back to the cells.
    back: [Single; 3],
}

/// The bodies on one level.
#[derive(Default)]
struct Layer {
    /// Group by group.
    faces: Vec<Face>,
    /// Where each group's cells begin, and where the last one's end.
    begin: Vec<usize>,
    cells: Vec<Cell>,
    /// At a cell's or a face's place, its number in the list while its group's are collected.
    found: Vec<u32>,
    smooth: Vec<Smooth>,
    /// Nine numbers a group that the ranks sum.
    grams: Vec<f64>,
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
    layers: Vec<Layer>,
    /// The cells that each body fills, by axis, and nothing for its turning: three numbers a group;
    /// then, of each group, on how many ranks it has cells. Summed over the ranks.
    volumes: Vec<f64>,
    shared: Shared,
    sums: Vec<f64>,
    /// Whether any is light enough to take part in the multigrid.
    active: bool,
}

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

/// No cell.
const NONE: u32 = u32::MAX;

/// The way from a field's indices to a lattice's.
pub(super) struct Frame {
    /// Strides, stored cells and layers of ghosts of a field.
    pub stride: [usize; 3],
    pub stored: [usize; 3],
    pub ghosts: usize,
}

impl Layer {
    /// The cells of the group whose faces begin at `first`, the last one so far.
    fn collect(&mut self, lattice: &Lattice, inverse_h: &[f64; 3], first: usize) {
        let start = self.cells.len();
        let place = |place: usize, a: usize| place / lattice.stride[a] % (lattice.n[a] + 2);
        for face in &self.faces[first..] {
            let (axis, high) = (face.axis as usize, face.place as usize);
            let j = face.part * inverse_h[axis];
            for (here, value) in [(high - lattice.stride[axis], j), (high, -j)] {
                if !(1..=lattice.n[axis]).contains(&place(here, axis)) {
                    continue;
                }
                if self.found[here] == NONE {
                    self.found[here] = self.cells.len() as u32;
                    let at = |a: usize| if a < lattice.axes { place(here, a) - 1 } else { 0 };
                    let row = (at(0) + lattice.n[0] * (at(1) + lattice.n[1] * at(2))) as u32;
                    self.cells.push(Cell { row, place: here as u32, j: [0.0; 3] });
                }
                self.cells[self.found[here] as usize].j[face.mode as usize] += value;
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

    /// Takes the faces from number `first` on out of the table.
    fn forget_faces(&mut self, first: usize) {
        for face in &self.faces[first..] {
            self.found[face.place as usize] = NONE;
        }
    }

    fn clear(&mut self, lattice: &Lattice) {
        self.found.resize(lattice.len, NONE);
        self.faces.clear();
        self.cells.clear();
        self.begin.clear();
        self.begin.push(0);
    }

    fn sum_up(
        &self,
        session: &Session,
        shared: &mut Shared,
        sums: &mut [f64],
        value: impl Fn(usize) -> Single,
    ) -> Result<()> {
        for (sum, range) in sums.chunks_exact_mut(3).zip(self.begin.windows(2)) {
            sum.fill(0.0);
            for cell in &self.cells[range[0]..range[1]] {
                let x = f64::from(value(cell.place as usize));
                (0..3).for_each(|a| sum[a] += cell.j[a] * x);
            }
        }
        shared.sum(session, 3, sums)
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

impl Bodies {
    pub fn new(session: &Session, axes: usize, inverse_h: [f64; 3]) -> Bodies {
        Bodies {
            session: session.clone(),
            axes,
            weights: Vec::new(),
            owner: Vec::new(),
            inverse_h,
            layers: vec![Layer::default()],
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
        covered: &[Covered],
        turning: &[u32],
        scale: f64,
    ) -> Result<()> {
        let axes = self.axes;
        let stored: usize = frame.stored.iter().product();
        let (groups, bodies) =
            (weights.len() / axes, (weights.len() / axes).saturating_sub(turning.len()));
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
                or has a face that \
                 is not its rank's"
                    .into(),
            ));
        }
        self.weights.clear();
        self.weights.extend(
            weights
                .chunks(axes)
                .map(|w| std::array::from_fn(|a| w.get(a).map_or(0.0, |w| w * scale))),
        );
        self.owner.clear();
        self.owner.extend((0..bodies as u32).chain(turning.iter().copied()));
        for (numbers, width) in [(&mut self.sums, 3), (&mut self.volumes, 4)] {
            numbers.clear();
            numbers.resize(width * self.weights.len(), 0.0);
        }
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
                let axis = e.axis as usize;
                // Counted from the layer of ghosts that a lattice has; -1 and below stand beyond
                // it.
                let at: [usize; 3] = std::array::from_fn(|a| match a < axes {
                    true => (e.face as usize / frame.stride[a] % frame.stored[a] + 1)
                        .wrapping_sub(frame.ghosts),
                    false => 0,
                });
                let inside =
                    |a: usize| (1..=lattice.n[a] + usize::from(a == axis)).contains(&at[a]);
                if (0..axes).all(inside) {
                    let place = (0..axes).map(|a| at[a] * lattice.stride[a]).sum::<usize>() as u32;
                    let (mode, part) = ((e.mode as usize % axes) as u8, e.part);
                    finest.faces.push(Face {
                        group: group as u32,
                        mode,
                        axis: e.axis,
                        place,
                        part,
                        conduct: part,
                    });
                    // Faces between ranks count on the upper one.
                    if at[axis] <= lattice.n[axis] && group < bodies {
                        self.volumes[3 * group + axis] += part;
                    }
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
        let here = finest.begin.windows(2).map(|range| f64::from(u8::from(range[1] > range[0])));
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

    /// y += sum_k w_k j_k (j_k . x). Collective.
    pub fn add_product(&mut self, x: &[f64], y: &mut [f64]) -> Result<()> {
        if self.weights.is_empty() {
            return Ok(());
        }
        let Bodies { session, weights, layers, sums, shared, .. } = self;
        let Layer { begin, cells, .. } = &layers[0];
        for (sum, range) in sums.chunks_exact_mut(3).zip(begin.windows(2)) {
            sum.fill(0.0);
            for cell in &cells[range[0]..range[1]] {
                let x = x[cell.row as usize];
                (0..3).for_each(|a| sum[a] += cell.j[a] * x);
            }
        }
        shared.sum(session, 3, sums)?;
        for ((sum, range), w) in sums.chunks_exact(3).zip(begin.windows(2)).zip(weights) {
            let back: [f64; 3] = std::array::from_fn(|a| w[a] * sum[a]);
            for cell in &cells[range[0]..range[1]] {
                y[cell.row as usize] +=
                    back[0] * cell.j[0] + back[1] * cell.j[1] + back[2] * cell.j[2];
            }
        }
        Ok(())
    }

    /// Whether the multigrid's level `l` has bodies.
    fn on(&self, l: usize) -> bool {
        self.active && l < self.layers.len() && !self.layers[l].smooth.is_empty()
    }

    /// What smoothing needs on level `l`, in units in which the finest level's largest face is 1:
    /// `scale` times the weights. Raises the diagonal where bodies lie. Collective.
    pub fn prepare(&mut self, l: usize, level: &mut Level, scale: f64) -> Result<()> {
        if l == 0 {
            // In these units a weight times the body's cells is the fluid's density over the
            // body's.
            let lightness = |v: f64, w: f64| v * w * scale * cells_across(v, self.axes);
            let lightest = self
                .volumes
                .iter()
                .zip(self.weights.iter().flatten())
                .map(|(v, w)| lightness(*v, *w));
            self.active = lightest.fold(0.0, f64::max) >= LIGHT;
            self.layers[0].smooth.resize(self.weights.len(), Smooth::default());
        }
        if !self.on(l) {
            return Ok(());
        }
        let Bodies { session, axes, weights, layers, shared, .. } = self;
        let Layer { begin, cells, smooth, grams, .. } = &mut layers[l];
        grams.resize(9 * weights.len(), 0.0);
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
        shared.sum(session, 9, grams)?;
        for ((gram, w), smooth) in grams.chunks_exact(9).zip(weights.iter()).zip(smooth.iter_mut())
        {
            let mut block = nalgebra::Matrix3::identity();
            for p in 0..*axes {
                let (w, d) = (w[p] * scale, gram[4 * p]);
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
            self.layers.push(Layer::default());
        }
        let on = self.on(l);
        let Bodies { axes, weights, owner, inverse_h, layers, volumes, .. } = self;
        let (upper, lower) = layers.split_at_mut(l + 1);
        let (from, to) = (&upper[l], &mut lower[0]);
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
        let mut any = false;
        for (group, owner) in owner.iter().map(|k| *k as usize).enumerate() {
            let count = rest.iter().take_while(|face| face.group as usize == group).count();
            let (own, others) = rest.split_at(count);
            rest = others;
            let first = to.faces.len();
            let volume = volumes[3 * owner..][..3].iter().fold(0.0f64, |most, v| most.max(*v));
            let resolved =
                cells_across(volume, *axes) >= RESOLVED * (1u64 << (l + 1)) as f64 && !last;
            any |= resolved;
            // What takes the body's place where it is not resolved turns as well.
            if !resolved && owner != group {
                to.collect(&coarse.lattice, inverse_h, first);
                continue;
            }
            // Faces of one mode and axis stand together; a place tells them apart within these
            // only.
            let (mut run_now, mut of_run) = (None, first);
            for face in own {
                let axis = face.axis as usize;
                let Some((place, ratio)) = fine.coarse_face(coarse, axis, face.place as usize)
                else {
                    continue;
                };
                if !resolved {
                    let lightness = weights[group][axis] * scale * volumes[3 * group + axis];
                    coarse.g[axis][place] +=
                        (lightness.min(CONDUCTOR) * unit[axis] * face.conduct) as Single * ratio;
                    continue;
                }
                let run = Some((face.mode, face.axis));
                if run_now != run {
                    to.forget_faces(of_run);
                    (run_now, of_run) = (run, to.faces.len());
                }
                let conduct = face.conduct * f64::from(ratio);
                match to.found[place] {
                    NONE => {
                        to.found[place] = to.faces.len() as u32;
                        to.faces.push(Face { place: place as u32, conduct, ..*face });
                    }
                    at => {
                        let whole = &mut to.faces[at as usize];
                        whole.part += face.part;
                        whole.conduct += conduct;
                    }
                }
            }
            to.forget_faces(of_run);
            to.collect(&coarse.lattice, inverse_h, first);
        }
        if any {
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
        if !self.on(l) {
            return Ok(());
        }
        let Bodies { session, layers, sums, shared, .. } = self;
        let layer = &mut layers[l];
        if !from_zero {
            // x -= omega D^-1 J W J^T x_before
            layer.sum_up(session, shared, sums, |place| level.next[place])?;
            for (smooth, sum) in layer.smooth.iter_mut().zip(sums.chunks_exact(3)) {
                smooth.back = std::array::from_fn(|a| smooth.weight[a] * sum[a] as Single);
            }
            layer.spread(level, omega);
        }
        // x -= omega D^-1 J (W^-1 + J^T D^-1 J)^-1 J^T (x - x_before)/omega
        layer.sum_up(session, shared, sums, |place| {
            (level.x[place] - if from_zero { 0.0 } else { level.next[place] }) / omega
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
        let Bodies { session, layers, sums, shared, .. } = self;
        let layer = &layers[l];
        layer.sum_up(session, shared, sums, |place| level.x[place])?;
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

/// Cells across a disc or sphere that fills so many.
fn cells_across(volume: f64, axes: usize) -> f64 {
    if axes == 2 { (volume * 4.0 / PI).sqrt() } else { (volume * 6.0 / PI).cbrt() }
}

fn dot(a: &[Single; 3], j: &[f64; 3]) -> Single {
    a[0] * j[0] as Single + a[1] * j[1] as Single + a[2] * j[2] as Single
}
