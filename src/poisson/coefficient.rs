//! The coefficient of the pressure's operator on faces, `beta/h^2`: zero on closed faces, and twice
//! as large where the pressure is given at the domain boundary, half a spacing away.

use super::lattice::Lattice;
use crate::grid::{Boundaries, BoundaryKind, Grid, largest, simd};
use crate::kernels::faces::FaceCoefficient;
use crate::petsc::Session;
use crate::{Error, Result};
use mics_run::sparse::Sparse;

/// The two ends of an axis: periodic, or boundaries.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Ends {
    Periodic,
    /// Whether the pressure is given (zero on the face) at the low and the high end.
    Boundaries {
        given: [bool; 2],
    },
}

/// The coefficient on the faces of this rank's cells.
pub(super) struct Coefficient {
    pub lattice: Lattice,
    /// `1/h^2` by axis (1/m2), zero along unused ones.
    pub inverse_h2: [f64; 3],
    ends: [Ends; 3],
    /// Whether this rank's box ends at the low and high end of each axis.
    at_end: [[bool; 2]; 3],
    /// Whether no boundary fixes the pressure: constants solve the homogeneous system.
    pub singular: bool,
    /// `beta/h^2` on faces.
    pub g: [Vec<f64>; 3],
    /// The largest `beta/h^2` of all ranks.
    pub largest: f64,
}

impl Coefficient {
    /// No coefficient yet, on a grid between these boundaries.
    pub fn new<const D: usize>(
        lattice: Lattice,
        grid: &Grid<D>,
        boundaries: &Boundaries<D>,
    ) -> Coefficient {
        let ends = std::array::from_fn(|a| match boundaries.kinds.get(a) {
            Some([Some(low), Some(high)]) => {
                let given = [low, high].map(|boundary| matches!(boundary, BoundaryKind::Outflow));
                Ends::Boundaries { given }
            }
            _ => Ends::Periodic,
        });
        let inverse_h2 = |a: usize| if a < D { 1.0 / (grid.h[a] * grid.h[a]) } else { 0.0 };
        Coefficient {
            lattice,
            inverse_h2: std::array::from_fn(inverse_h2),
            ends,
            at_end: std::array::from_fn(|a| [0, 1].map(|side| a < D && grid.at_boundary(a, side))),
            singular: !boundaries.fixes_pressure(),
            g: lattice.faces(),
            largest: 0.0,
        }
    }

    /// The largest `1/h^2` (1/m2).
    pub fn finest(&self) -> f64 {
        self.inverse_h2.iter().copied().fold(0.0, f64::max)
    }

    /// Takes `beta` on faces. Collective.
    ///
    /// # Errors
    /// When it is not positive and finite on every open face: a zero row would make solvers report
    /// success.
    pub fn set<const D: usize>(
        &mut self,
        session: &Session,
        grid: &Grid<D>,
        beta: &FaceCoefficient<D>,
    ) -> Result<()> {
        let unsound = match beta {
            FaceCoefficient::Uniform(value) => {
                self.largest = value * self.finest();
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
        session.max(&mut all)?;
        self.largest = all[1];
        if all[0] > 0.0 {
            return Err(Error::Run(
                "the density of the mixture is not positive and finite on every face: a flow that \
                grows without bounds does that (smaller steps, time.step or time.cfl), or \
                densities whose ratio is out of range"
                    .into(),
            ));
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
            let n = self.lattice.n[0] + usize::from(axis == 0);
            let each = value * self.inverse_h2[axis];
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

    /// The fluid's part of the operator as a matrix, where one rank has all cells. The faces at the
    /// two ends of a period are one.
    pub fn matrix(&self) -> Sparse {
        let lattice = self.lattice;
        let g = &self.g;
        let [nx, ny, nz] = lattice.n;
        let steps = [1, nx, nx * ny];
        let mut matrix = Sparse::new(nx * ny * nz);
        let mut row = Vec::with_capacity(2 * lattice.axes + 1);
        let places = lattice.rows().flat_map(|s| s..s + nx);
        for (cell, place) in places.enumerate() {
            let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
            let mut diagonal = 0.0;
            row.clear();
            for axis in 0..lattice.axes {
                let n = lattice.n[axis];
                let step = steps[axis];
                let stride = lattice.stride[axis];
                let closes = matches!(self.ends[axis], Ends::Periodic);
                let low = g[axis][place];
                let high = match closes && at[axis] + 1 == n {
                    true => g[axis][place - (n - 1) * stride],
                    false => g[axis][place + stride],
                };
                let around = (n - 1) * step;
                let below = match at[axis] {
                    0 => closes.then_some(cell + around),
                    _ => Some(cell - step),
                };
                let above = match at[axis] + 1 == n {
                    true => closes.then(|| cell - around),
                    false => Some(cell + step),
                };
                for (beyond, each) in [(below, low), (above, high)] {
                    diagonal += each;
                    row.extend(beyond.map(|beyond| (beyond as u32, -each)));
                }
            }
            row.push((cell as u32, diagonal));
            matrix.push_row(&mut row);
        }
        matrix
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
