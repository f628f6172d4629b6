//! The passes of a level's smoothing, several of them at once where this rank has the whole level:
//!
//! ```text
//!   layer of cells   t  t-1  t-2  t-3         pass 1 works on layer t, pass 2 on t-1, ...: what
//!   pass             1   2    3    4          one leaves is still near when the next one takes it
//! ```
//! A layer is a row in 2D, a plane in 3D. Two fields suffice: a pass overwrites the result of the
//! one before the last, which the last pass no longer needs. The sums are those of one pass after
//! the other.

use super::lattice::{Lattice, exchange};
use super::level::{Level, Single, add_up};
use crate::Result;
use crate::grid::simd;

/// A pass over the cells of a level.
#[derive(Clone, Copy, Debug)]
pub(super) enum Pass {
    /// The first sweep, from x = 0, with this weight.
    FromZero(Single),
    /// Adds the next level's x.
    Prolong,
    /// A sweep with this weight.
    Sweep(Single),
    /// b of the next level: what is left of this one's, summed.
    Restrict,
}

/// A level's fields while passes work on it.
struct Fields<'a> {
    lattice: Lattice,
    g: &'a [Vec<Single>; 3],
    inverse: &'a [Single],
    b: &'a [Single],
    /// Sweeps go from the one to the other, and back.
    x: [&'a mut [Single]; 2],
    row: &'a mut [Single],
    factor: [usize; 3],
    /// Axes within a layer that are periodic on this rank.
    wraps: [bool; 2],
    coarse: Option<&'a mut Level>,
}

/// All passes at once, of a level that is `layered`; `coarse` is the next level.
pub fn pass_together(level: &mut Level, passes: &[Pass], coarse: Option<&mut Level>) {
    let sweeps = passes.iter().filter(|pass| matches!(pass, Pass::Sweep(_))).count();
    let mut fields = fields(level, coarse);
    let layers = fields.layers();
    simd(
        #[inline(always)]
        || {
            for t in 0..layers + passes.len() - 1 {
                let mut from = 0;
                for (m, pass) in passes.iter().enumerate() {
                    if m <= t && t - m < layers {
                        fields.work(*pass, from, t - m);
                    }
                    from ^= usize::from(matches!(pass, Pass::Sweep(_)));
                }
            }
        },
    );
    if sweeps % 2 == 1 {
        std::mem::swap(&mut level.x, &mut level.next);
    }
}

/// One pass. After a sweep `next` holds what it started from. Collective.
pub fn pass(level: &mut Level, pass: Pass, coarse: Option<&mut Level>) -> Result<()> {
    if matches!(pass, Pass::Sweep(_) | Pass::Restrict) {
        exchange(&mut level.halo, level.lattice.axes, &mut level.x)?;
    }
    let mut fields = fields(level, coarse);
    let layers = fields.layers();
    simd(
        #[inline(always)]
        || {
            for layer in 0..layers {
                fields.work(pass, 0, layer);
            }
        },
    );
    if matches!(pass, Pass::Sweep(_)) {
        std::mem::swap(&mut level.x, &mut level.next);
    }
    Ok(())
}

fn fields<'a>(level: &'a mut Level, coarse: Option<&'a mut Level>) -> Fields<'a> {
    let Level { lattice, g, inverse, x, b, next, row, factor, wraps, .. } = level;
    let lattice = *lattice;
    let factor = *factor;
    let wraps = *wraps;
    Fields { lattice, g, inverse, b, x: [x, next], row, factor, wraps, coarse }
}

impl Fields<'_> {
    fn layers(&self) -> usize {
        self.lattice.n[self.lattice.axes - 1]
    }

    /// Does a pass on a layer; the present x is in field `from`.
    #[inline(always)]
    fn work(&mut self, pass: Pass, from: usize, layer: usize) {
        let (rows, flat) = match self.lattice.axes {
            2 => (1, true),
            _ => (self.lattice.n[1], false),
        };
        for row in 0..rows {
            let at = if flat { [layer, 0] } else { [row, layer] };
            match pass {
                Pass::FromZero(omega) => self.begin(omega, from, at),
                Pass::Prolong => self.prolong(from, at),
                Pass::Sweep(omega) => self.sweep(omega, from, at),
                Pass::Restrict => self.restrict(from, at),
            }
        }
        match pass {
            Pass::Sweep(_) => self.wrap(1 - from, layer),
            Pass::Restrict => {}
            _ => self.wrap(from, layer),
        }
    }

    #[inline(always)]
    fn begin(&mut self, omega: Single, to: usize, [j, k]: [usize; 2]) {
        let s = self.lattice.row(j, k);
        let n = self.lattice.n[0];
        let b = &self.b[s..][..n];
        let inverse = &self.inverse[s..][..n];
        for ((x, b), d) in self.x[to][s..][..n].iter_mut().zip(b).zip(inverse) {
            *x = omega * d * b;
        }
    }

    #[inline(always)]
    fn sweep(&mut self, omega: Single, from: usize, [j, k]: [usize; 2]) {
        let Fields { lattice, g, inverse, b, x, .. } = self;
        let s = lattice.row(j, k);
        let n = lattice.n[0];
        let b = &b[s..][..n];
        let inverse = &inverse[s..][..n];
        let [first, second] = x;
        let (x, next) = if from == 0 { (first, second) } else { (second, first) };
        lattice.for_row(
            g,
            x,
            s,
            &mut next[s..],
            #[inline(always)]
            |i, x, flux| x + omega * inverse[i] * (b[i] + flux),
        );
    }

    #[inline(always)]
    fn restrict(&mut self, from: usize, [j, k]: [usize; 2]) {
        let Fields { lattice, g, b, x, row, factor, coarse: Some(coarse), .. } = self else {
            return;
        };
        let s = lattice.row(j, k);
        let n = lattice.n[0];
        let b = &b[s..][..n];
        lattice.for_row(
            g,
            x[from],
            s,
            row,
            #[inline(always)]
            |i, _, flux| b[i] + flux,
        );
        let wide = coarse.lattice;
        let to = &mut coarse.b[wide.row(j / factor[1], k / factor[2])..][..wide.n[0]];
        if j % factor[1] == 0 && k % factor[2] == 0 {
            to.fill(0.0);
        }
        add_up(row, factor[0], to);
    }

    #[inline(always)]
    fn prolong(&mut self, from: usize, [j, k]: [usize; 2]) {
        let Fields { lattice, x, factor, coarse: Some(coarse), .. } = self else { return };
        let n = lattice.n[0];
        let wide = coarse.lattice;
        let x = &mut x[from][lattice.row(j, k)..][..n];
        let add = &coarse.x[wide.row(j / factor[1], k / factor[2])..][..wide.n[0]];
        if factor[0] == 1 {
            x.iter_mut().zip(add).for_each(|(x, e)| *x += e);
            return;
        }
        let mut pairs = x.chunks_exact_mut(2);
        for (pair, e) in pairs.by_ref().zip(add) {
            pair[0] += e;
            pair[1] += e;
        }
        pairs.into_remainder().iter_mut().for_each(|x| *x += add[n / 2]);
    }

    /// Fills the ghosts of a layer that lie across a period.
    #[inline(always)]
    fn wrap(&mut self, field: usize, layer: usize) {
        let Fields { lattice, x, wraps, .. } = self;
        let lattice = *lattice;
        let x = &mut x[field];
        let n = lattice.n;
        let flat = lattice.axes == 2;
        if wraps[0] {
            for row in 0..if flat { 1 } else { n[1] } {
                let s = if flat { lattice.row(layer, 0) } else { lattice.row(row, layer) };
                x[s - 1] = x[s + n[0] - 1];
                x[s + n[0]] = x[s];
            }
        }
        if wraps[1] && !flat {
            let s = lattice.row(0, layer);
            let ny = n[1];
            let stride = lattice.stride[1];
            x.copy_within(s + (ny - 1) * stride..s + (ny - 1) * stride + n[0], s - stride);
            x.copy_within(s..s + n[0], s + ny * stride);
        }
    }
}
