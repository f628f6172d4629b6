//! The cells and faces of the bodies' surfaces on one level of the multigrid, where a sweep solves
//! with
//!
//! ```text
//!   (D + J W J^T)^-1 = D^-1 - D^-1 J (W^-1 + J^T D^-1 J)^-1 J^T D^-1
//!
//!   j_c = sum over its faces (m_low - m_high)/h,      a group: up to three modes of one body
//! ```
//! in place of D, for each body by itself and for its rotation by itself.

use super::super::frame::Frame;
use super::super::lattice::Lattice;
use super::super::level::{Level, Single};
use super::ModeFace;
use super::groups::Groups;
use super::shared::Shared;
use crate::Result;

/// Largest `w j^T D^-1 j` that smoothing takes: neighbours that share cells would make it
/// indefinite beyond.
const HEAVIEST: f64 = 3.0;

/// Share of `j^2` that is added to the diagonal: cells that bodies close from all sides have next
/// to none of their own.
const FLOOR: f64 = 0.1;

/// Safety factor of the blocks, since bodies that share cells are taken one by one.
const SHARED: f64 = 1.3;

/// No cell.
const NONE: u32 = u32::MAX;

/// A cell of a body's surface.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cell {
    /// Its number among this rank's.
    pub row: u32,
    /// Its place in the lattice.
    pub place: u32,
    /// j of each of the group's modes, in units of the smallest spacing.
    pub j: [f64; 3],
}

/// A covered face of a level.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceFace {
    pub group: u32,
    /// Number of the mode within its group.
    pub mode: u8,
    pub axis: u8,
    pub place: u32,
    /// Covered parts of the finest level's faces in it, summed; and summed as conductances are.
    pub part: f64,
    pub conduct: f64,
}

/// A group as a level smooths it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Smooth {
    /// `(W^-1 + J^T D^-1 J)^-1`.
    pub block: [[Single; 3]; 3],
    /// The weights, so far as smoothing takes them.
    pub weight: [Single; 3],
    /// Factors of the modes' j, by which the cells are corrected.
    pub back: [Single; 3],
}

/// The bodies on one level.
#[derive(Default)]
pub struct SurfaceCells {
    /// Covered faces, group by group.
    pub faces: Vec<SurfaceFace>,
    /// Where each group's cells begin, and where the last one's end.
    pub begin: Vec<usize>,
    pub cells: Vec<Cell>,
    /// At a cell's or a face's place, its number in the list while its group's are collected.
    pub found: Vec<u32>,
    pub smooth: Vec<Smooth>,
    /// `J^T D^-1 J` of each group, nine numbers that the ranks sum.
    pub grams: Vec<f64>,
}

impl SurfaceCells {
    /// Takes the covered faces of all groups to the finest level, with the cells beside them and
    /// the volumes of the bodies. Returns whether there are faces out of the groups' order: those
    /// of a group have to stand together.
    pub fn take_covered(
        &mut self,
        frame: &Frame,
        groups: &mut Groups,
        covered: &[ModeFace],
        inverse_h: &[f64; 3],
    ) -> bool {
        let lattice = &frame.lattice;
        let axes = groups.axes;
        self.clear(lattice);
        // Bodies that move cut now more cells, now fewer.
        if self.faces.capacity() < covered.len() {
            self.faces.reserve(2 * covered.len());
            self.cells.reserve(2 * covered.len());
        }
        let mut rest = covered;
        for group in 0..groups.weights.len() {
            let first = self.faces.len();
            let count = rest.iter().take_while(|e| e.mode as usize / axes == group).count();
            let (own, others) = rest.split_at(count);
            rest = others;
            for e in own {
                let axis = e.axis as usize;
                let Some(at) = frame.on_lattice(e.face, axis) else { continue };
                let mode = (e.mode as usize % axes) as u8;
                let place = (0..axes).map(|a| at[a] * lattice.stride[a]).sum::<usize>() as u32;
                self.faces.push(SurfaceFace {
                    group: group as u32,
                    mode,
                    axis: e.axis,
                    place,
                    part: e.part,
                    conduct: e.part,
                });
                // Faces between ranks count on the upper one.
                if at[axis] <= lattice.n[axis] && group < groups.bodies {
                    groups.volumes[3 * group + axis] += e.part;
                }
            }
            self.collect(lattice, inverse_h, first);
        }
        !rest.is_empty()
    }

    /// Collects the cells of the last group so far, whose faces begin at `first`.
    pub fn collect(&mut self, lattice: &Lattice, inverse_h: &[f64; 3], first: usize) {
        let start = self.cells.len();
        for face in &self.faces[first..] {
            let axis = face.axis as usize;
            let high = face.place as usize;
            let j = face.part * inverse_h[axis];
            for (here, value) in [(high - lattice.stride[axis], j), (high, -j)] {
                if !(1..=lattice.n[axis]).contains(&lattice.along(here, axis)) {
                    continue;
                }
                if self.found[here] == NONE {
                    self.found[here] = self.cells.len() as u32;
                    let at =
                        |a: usize| if a < lattice.axes { lattice.along(here, a) - 1 } else { 0 };
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

    /// Takes the faces `own` of a group from the finer level, those on the same coarse face as one;
    /// the group's begin at `first`.
    pub fn take_faces(&mut self, own: &[SurfaceFace], fine: &Level, coarse: &Level, first: usize) {
        // Faces of one mode and axis stand together; a place tells them apart within these only.
        let mut run_now = None;
        let mut of_run = first;
        for face in own {
            let coarse_face = fine.coarse_face(coarse, face.axis as usize, face.place as usize);
            let Some((place, ratio)) = coarse_face else { continue };
            let run = Some((face.mode, face.axis));
            if run_now != run {
                self.forget_faces(of_run);
                run_now = run;
                of_run = self.faces.len();
            }
            let conduct = face.conduct * f64::from(ratio);
            match self.found[place] {
                NONE => {
                    self.found[place] = self.faces.len() as u32;
                    self.faces.push(SurfaceFace { place: place as u32, conduct, ..*face });
                }
                at => {
                    let whole = &mut self.faces[at as usize];
                    whole.part += face.part;
                    whole.conduct += conduct;
                }
            }
        }
        self.forget_faces(of_run);
    }

    /// Leaves no body on the level.
    pub fn clear(&mut self, lattice: &Lattice) {
        self.found.resize(lattice.len, NONE);
        self.faces.clear();
        self.cells.clear();
        self.begin.clear();
        self.begin.push(0);
    }

    /// Makes ready to smooth a level, in units in which the finest level's largest face is 1:
    /// `scale` times the weights. Raises the diagonal where bodies lie. Collective.
    pub fn prepare(
        &mut self,
        groups: &Groups,
        shared: &mut Shared,
        level: &mut Level,
        scale: f64,
    ) -> Result<()> {
        let Groups { axes, weights, .. } = groups;
        let SurfaceCells { begin, cells, smooth, grams, .. } = self;
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

    /// Corrects the sweep by `omega` that D alone has done: from `next` (before the sweep; zero if
    /// `from_zero`) to `x`. Collective.
    pub fn correct(
        &mut self,
        shared: &mut Shared,
        sums: &mut [f64],
        level: &mut Level,
        omega: Single,
        from_zero: bool,
    ) -> Result<()> {
        if !from_zero {
            // x -= omega D^-1 J W J^T x_before
            self.sum_up(shared, sums, |cell| f64::from(level.next[cell.place as usize]))?;
            for (smooth, sum) in self.smooth.iter_mut().zip(sums.chunks_exact(3)) {
                smooth.back = std::array::from_fn(|a| smooth.weight[a] * sum[a] as Single);
            }
            self.spread(level, omega);
        }
        // x -= omega D^-1 J (W^-1 + J^T D^-1 J)^-1 J^T (x - x_before)/omega
        self.sum_up(shared, sums, |cell| {
            let place = cell.place as usize;
            f64::from((level.x[place] - if from_zero { 0.0 } else { level.next[place] }) / omega)
        })?;
        for (smooth, sum) in self.smooth.iter_mut().zip(sums.chunks_exact(3)) {
            let s = [0, 1, 2].map(|a| sum[a] as Single);
            smooth.back = smooth.block.map(|row| row[0] * s[0] + row[1] * s[1] + row[2] * s[2]);
        }
        self.spread(level, omega);
        Ok(())
    }

    /// Takes the bodies' part out of the next level's b. Collective.
    pub fn restrict(
        &self,
        shared: &mut Shared,
        sums: &mut [f64],
        level: &Level,
        coarse: &mut Level,
    ) -> Result<()> {
        self.sum_up(shared, sums, |cell| f64::from(level.x[cell.place as usize]))?;
        for ((smooth, sum), range) in
            self.smooth.iter().zip(sums.chunks_exact(3)).zip(self.begin.windows(2))
        {
            let back: [Single; 3] = std::array::from_fn(|a| smooth.weight[a] * sum[a] as Single);
            for cell in &self.cells[range[0]..range[1]] {
                let place = level.coarse_place(coarse, cell.place as usize);
                coarse.b[place] -= dot(&back, &cell.j);
            }
        }
        Ok(())
    }

    /// The sum over each group's cells of `j` times their `value`, over all ranks. Collective.
    fn sum_up(
        &self,
        shared: &mut Shared,
        sums: &mut [f64],
        value: impl Fn(&Cell) -> f64,
    ) -> Result<()> {
        for (sum, range) in sums.chunks_exact_mut(3).zip(self.begin.windows(2)) {
            sum.fill(0.0);
            for cell in &self.cells[range[0]..range[1]] {
                let x = value(cell);
                (0..3).for_each(|a| sum[a] += cell.j[a] * x);
            }
        }
        shared.sum(3, sums)
    }

    /// Gives the cells of each group what smoothing takes back from them, times `omega`.
    fn spread(&self, level: &mut Level, omega: Single) {
        for (smooth, range) in self.smooth.iter().zip(self.begin.windows(2)) {
            for cell in &self.cells[range[0]..range[1]] {
                let place = cell.place as usize;
                level.x[place] -= omega * level.inverse[place] * dot(&smooth.back, &cell.j);
            }
        }
    }
}

/// `a . j` in the precision of the multigrid.
fn dot(a: &[Single; 3], j: &[f64; 3]) -> Single {
    a[0] * j[0] as Single + a[1] * j[1] as Single + a[2] * j[2] as Single
}
