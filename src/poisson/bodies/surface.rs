//! The cells and faces of the bodies' surfaces on one level of the multigrid:
//!
//! ```text
//!   j_c = sum over its faces (m_low - m_high)/h,      a group: up to three modes of one body
//! ```

use super::super::lattice::Lattice;
use super::super::level::{Level, Single};
use super::shared::Shared;
use crate::Result;

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
pub struct Face {
    pub group: u32,
    /// Which of the group's modes.
    pub mode: u8,
    pub axis: u8,
    pub place: u32,
    /// Covered parts of the finest level's faces in it, summed; and so that they conduct.
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
    /// What goes back to the cells.
    pub back: [Single; 3],
}

/// The bodies on one level.
#[derive(Default)]
pub struct SurfaceCells {
    /// Group by group.
    pub faces: Vec<Face>,
    /// Where each group's cells begin, and where the last one's end.
    pub begin: Vec<usize>,
    pub cells: Vec<Cell>,
    /// At a cell's or a face's place, its number in the list while its group's are collected.
    pub found: Vec<u32>,
    pub smooth: Vec<Smooth>,
    /// Nine numbers a group that the ranks sum.
    pub grams: Vec<f64>,
}

impl SurfaceCells {
    /// The cells of the group whose faces begin at `first`, the last one so far.
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
    pub fn forget_faces(&mut self, first: usize) {
        for face in &self.faces[first..] {
            self.found[face.place as usize] = NONE;
        }
    }

    /// Takes the faces `own` of a group from the finer level, those on the same coarse face as one;
    /// the group's begin at `first`.
    pub fn take_faces(&mut self, own: &[Face], fine: &Level, coarse: &Level, first: usize) {
        // Faces of one mode and axis stand together; a place tells them apart within these only.
        let mut run_now = None;
        let mut of_run = first;
        for face in own {
            let coarse_face = fine.coarse_face(coarse, face.axis as usize, face.place as usize);
            let Some((place, ratio)) = coarse_face else { continue };
            let run = Some((face.mode, face.axis));
            if run_now != run {
                self.forget_faces(of_run);
                (run_now, of_run) = (run, self.faces.len());
            }
            let conduct = face.conduct * f64::from(ratio);
            match self.found[place] {
                NONE => {
                    self.found[place] = self.faces.len() as u32;
                    self.faces.push(Face { place: place as u32, conduct, ..*face });
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

    /// The sum over each group's cells of `j` times their `value`, over all ranks. Collective.
    pub fn sum_up(
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
    pub fn spread(&self, level: &mut Level, omega: Single) {
        for (smooth, range) in self.smooth.iter().zip(self.begin.windows(2)) {
            for cell in &self.cells[range[0]..range[1]] {
                let place = cell.place as usize;
                level.x[place] -= omega * level.inverse[place] * dot(&smooth.back, &cell.j);
            }
        }
    }
}

/// `a . j` in the precision of the multigrid.
pub fn dot(a: &[Single; 3], j: &[f64; 3]) -> Single {
    a[0] * j[0] as Single + a[1] * j[1] as Single + a[2] * j[2] as Single
}
