//! One level of the multigrid: its smoother, and the way to the next coarser level and back.
//!
//! Smoothing is a Chebyshev polynomial of `D^-1 A` (D the diagonal; no eigenvalue is above 2), as
//! damped Jacobi sweeps `x += omega_i D^-1 (b - A x)` with `1/omega_i` the polynomial's roots over
//! [2/5, 2]: no colours, so that rows are worked off at the speed of memory, and the same before
//! and after the coarser level, so that the cycle is symmetric.
//!
//! ```text
//!   +---+---+---+---+---+      coarse cell: two cells along each axis that is coarsened, one where
//!                              an odd one is left
//!   | a   a | b   b | c |      r_C = sum of r_c,   x_c += x_C
//!   +---+---+---+---+---+
//!              g_F = (distance of cell centres, fine over coarse) * sum of the g_f in F
//! ```

use super::lattice::Lattice;
use crate::grid::simd;
use crate::petsc::{Halo, Session};

/// The multigrid's precision: half the memory traffic of double precision, and its error is the
/// Krylov method's to reduce.
pub(super) type Single = f32;

pub(super) struct Level {
    pub lattice: Lattice,
    pub g: [Vec<Single>; 3],
    /// 1/D.
    pub inverse: Vec<Single>,
    pub x: Vec<Single>,
    pub b: Vec<Single>,
    /// The sweep's result; after it, what it started from.
    pub next: Vec<Single>,
    /// Scratch of a row.
    pub row: Vec<Single>,
    pub halo: Halo<Single>,
    /// Whether several passes can be done at once ([`super::sweeps`]), and the axes within a layer
    /// of cells that are periodic on this rank.
    pub layered: bool,
    pub wraps: [bool; 2],
    /// Cells that make a coarse one along each axis: 1 or 2.
    pub factor: [usize; 3],
    /// Distance of cell centres across coarse faces, fine over coarse, by axis and coarse face.
    ratio: [Vec<Single>; 3],
}

impl Level {
    pub fn new(session: &Session, lattice: Lattice, neighbours: [[Option<usize>; 2]; 3]) -> Level {
        let itself = [Some(session.rank()); 2];
        let last = lattice.axes - 1;
        let alone = |a: usize| neighbours[a] == [None; 2] || a < last && neighbours[a] == itself;
        Level {
            layered: (0..lattice.axes).all(alone),
            wraps: [0, 1].map(|a| neighbours[a] == itself),
            g: lattice.faces(),
            inverse: lattice.field(),
            x: lattice.field(),
            b: lattice.field(),
            next: lattice.field(),
            row: vec![0.0; lattice.n[0]],
            halo: lattice.halo(session, neighbours),
            factor: [1; 3],
            ratio: Default::default(),
            lattice,
        }
    }

    /// Says how the next level follows from this one.
    pub fn coarsen_by(&mut self, factor: [usize; 3], fine: &[Vec<f64>; 3], coarse: &[Vec<f64>; 3]) {
        self.factor = factor;
        self.ratio = std::array::from_fn(|a| {
            let last = fine[a].len().saturating_sub(1);
            let ratio =
                |(i, wide): (usize, &f64)| (fine[a][(i * factor[a]).min(last)] / wide) as Single;
            coarse[a].iter().enumerate().map(ratio).collect()
        });
    }

    /// Computes 1/D from the faces; it is zero where a cell has no open face.
    pub fn invert(&mut self) {
        let Level { lattice, g, inverse, .. } = self;
        let Lattice { n, stride, axes, .. } = *lattice;
        simd(
            #[inline(always)]
            || {
                for s in lattice.rows() {
                    let inverse = &mut inverse[s..][..n[0]];
                    inverse.fill(0.0);
                    for axis in 0..axes {
                        let g = &g[axis];
                        let low = &g[s..][..n[0]];
                        let high = &g[s + stride[axis]..][..n[0]];
                        for ((d, l), h) in inverse.iter_mut().zip(low).zip(high) {
                            *d += l + h;
                        }
                    }
                    for d in inverse {
                        *d = if *d > 0.0 { 1.0 / *d } else { 0.0 };
                    }
                }
            },
        );
    }

    /// Computes the coefficient on the faces of the next level.
    pub fn coarsen(&self, coarse: &mut Level) {
        let fine = &self.lattice;
        let wide = coarse.lattice;
        for axis in 0..fine.axes {
            let factor = self.factor;
            let from = &self.g[axis];
            let to = &mut coarse.g[axis];
            let extent = |a: usize| wide.n[a] + usize::from(a == axis);
            let n = extent(0);
            for (k, j) in (0..extent(2)).flat_map(|k| (0..extent(1)).map(move |j| (k, j))) {
                let out = &mut to[wide.row(j, k)..][..n];
                out.fill(0.0);
                // The fine rows in this coarse one: across the axis all of them, along it the one
                // on the coarse face.
                let rows = |at: usize, a: usize| {
                    let begin = (at * factor[a]).min(fine.n[a]);
                    begin..if a == axis { begin + 1 } else { (begin + factor[a]).min(fine.n[a]) }
                };
                for (fk, fj) in rows(k, 2).flat_map(|fk| rows(j, 1).map(move |fj| (fk, fj))) {
                    let row = &from[fine.row(fj, fk)..][..fine.n[0] + usize::from(axis == 0)];
                    if axis == 0 {
                        let picked = (0..n).map(|i| row[(i * factor[0]).min(fine.n[0])]);
                        out.iter_mut().zip(picked).for_each(|(o, g)| *o += g);
                    } else {
                        add_up(row, factor[0], out);
                    }
                }
                match axis {
                    0 => out.iter_mut().zip(&self.ratio[0]).for_each(|(o, r)| *o *= r),
                    _ => {
                        let ratio = self.ratio[axis][if axis == 1 { j } else { k }];
                        out.iter_mut().for_each(|o| *o *= ratio);
                    }
                }
            }
        }
    }

    /// Where the next level has the cell at a place of this one.
    pub fn coarse_place(&self, coarse: &Level, place: usize) -> usize {
        let fine = &self.lattice;
        let wide = &coarse.lattice;
        let at = |a: usize| fine.along(place, a) - 1;
        wide.first + (0..fine.axes).map(|a| at(a) / self.factor[a] * wide.stride[a]).sum::<usize>()
    }

    /// Where the next level has the face in which one of this level's lies, if there is one, and
    /// the distance of cell centres across it, fine over coarse.
    pub fn coarse_face(
        &self,
        coarse: &Level,
        axis: usize,
        place: usize,
    ) -> Option<(usize, Single)> {
        let fine = &self.lattice;
        let wide = &coarse.lattice;
        let at = |a: usize| fine.along(place, a) - 1;
        let along = at(axis);
        let factor = self.factor[axis];
        if along % factor != 0 && along != fine.n[axis] {
            return None;
        }
        let number =
            |a: usize| if a == axis { along.div_ceil(factor) } else { at(a) / self.factor[a] };
        let face = wide.first + (0..fine.axes).map(|a| number(a) * wide.stride[a]).sum::<usize>();
        Some((face, self.ratio[axis][number(axis)]))
    }
}

/// Adds to `out` the sums of each `factor` numbers of a row; of one, where an odd one is left.
#[inline(always)]
pub(super) fn add_up(row: &[Single], factor: usize, out: &mut [Single]) {
    if factor == 1 {
        out.iter_mut().zip(row).for_each(|(o, v)| *o += v);
        return;
    }
    let pairs = row.chunks_exact(2);
    let rest = pairs.remainder();
    out.iter_mut().zip(pairs).for_each(|(o, p)| *o += p[0] + p[1]);
    if let ([v], Some(o)) = (rest, out.last_mut()) {
        *o += v;
    }
}
