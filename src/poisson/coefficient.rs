//! The coefficient of the pressure's operator on faces, `beta/h^2`: zero on closed faces, and twice
//! as large where the pressure is given at the domain boundary, half a spacing away.

use super::Poisson;
use crate::grid::{Grid, largest, simd};
use crate::kernels::faces::FaceCoefficient;
use crate::{Error, Result};

/// What is at the two ends of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ends {
    Periodic,
    /// Whether the pressure is given (zero on the face) at the low and the high end.
    Boundaries {
        given: [bool; 2],
    },
}

impl Poisson {
    /// Takes `beta` on faces. Collective.
    ///
    /// # Errors
    /// When it is not positive and finite on every open face: a zero row would make solvers report
    /// success.
    pub fn set<const D: usize>(&mut self, grid: &Grid<D>, beta: &FaceCoefficient<D>) -> Result<()> {
        let unsound = match beta {
            FaceCoefficient::Uniform(value) => {
                self.largest = value * self.inverse_h2.iter().copied().fold(0.0, f64::max);
                self.fill_uniform(*value);
                !(value.is_finite() && *value > 0.0)
            }
            FaceCoefficient::Field(beta) => {
                let mut sound = true;
                let mut most = 0.0f64;
                for axis in 0..D {
                    let rows = self.face_rows(axis);
                    let h2 = self.inverse_h2[axis];
                    for (row, s) in grid.face_rows(axis).zip(rows) {
                        let to = &mut self.g[axis][s..][..row.len()];
                        let largest = take_row(h2, &beta[axis][row], to);
                        sound &= largest.is_some();
                        most = most.max(largest.unwrap_or(0.0));
                    }
                }
                self.set_boundaries();
                self.largest = most;
                !sound
            }
        };
        let mut all = [f64::from(unsound), self.largest];
        self.session.max(&mut all)?;
        self.largest = all[1];
        if all[0] > 0.0 {
            return Err(Error::Run(
                "the density of the mixture is not positive and finite on every face: a flow that \
                grows without bounds does that (smaller steps, time.step or time.cfl), or \
                densities whose ratio is out of range"
                    .into(),
            ));
        }
        if let Some(made) = &mut self.multigrid {
            made.valid = false;
        }
        Ok(())
    }

    /// The places of the low faces of this rank's cells along `axis`, and of the high ones of the
    /// last: the first of each row, in the order of [`Grid::face_rows`].
    fn face_rows(&self, axis: usize) -> impl Iterator<Item = usize> + use<> {
        let lattice = self.lattice;
        let n = |a: usize| lattice.n[a] + usize::from(a == axis);
        let ny = n(1);
        let nz = n(2);
        (0..nz).flat_map(move |k| (0..ny).map(move |j| lattice.row(j, k)))
    }

    /// Sets all faces to `value/h^2`.
    fn fill_uniform(&mut self, value: f64) {
        for axis in 0..self.lattice.axes {
            let (n, each) =
                (self.lattice.n[0] + usize::from(axis == 0), value * self.inverse_h2[axis]);
            for s in self.face_rows(axis) {
                self.g[axis][s..][..n].fill(each);
            }
        }
        self.set_boundaries();
    }

    /// Closes the faces at boundaries of the domain, or doubles them where the pressure is given.
    fn set_boundaries(&mut self) {
        for axis in 0..self.lattice.axes {
            let Ends::Boundaries { given } = self.ends[axis] else { continue };
            for side in [0, 1].into_iter().filter(|side| self.at_end[axis][*side]) {
                let factor = if given[side] { 2.0 } else { 0.0 };
                let mut n = self.lattice.n;
                n[axis] = 1;
                let first =
                    if side == 0 { 0 } else { self.lattice.n[axis] * self.lattice.stride[axis] };
                for (k, j) in (0..n[2]).flat_map(|k| (0..n[1]).map(move |j| (k, j))) {
                    let s = self.lattice.row(j, k) + first;
                    self.g[axis][s..][..n[0]].iter_mut().for_each(|g| *g *= factor);
                }
            }
        }
    }
}

/// Takes `h2` times the coefficients of a row of faces; returns the largest, `None` where any is
/// not positive and finite.
fn take_row(h2: f64, from: &[f64], to: &mut [f64]) -> Option<f64> {
    let [most, unsound] = simd(
        #[inline(always)]
        || {
            for (to, from) in to.iter_mut().zip(from) {
                *to = h2 * from;
            }
            let to = &to[..];
            [
                largest(
                    to.len(),
                    #[inline(always)]
                    |i| to[i],
                ),
                largest(
                    to.len(),
                    #[inline(always)]
                    |i| if to[i] > 0.0 { 0.0 } else { 1.0 },
                ),
            ]
        },
    );
    (most.is_finite() && unsound == 0.0).then_some(most)
}
