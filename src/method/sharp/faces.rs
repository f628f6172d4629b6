//! Face velocities beside a surface: predicted with their correction (formulas in the parent).

use super::acceleration::PressureAcceleration;
use super::cut::CutBodies;
use super::cut_body::CutBody;
use super::{StepNumbers, history};
use crate::Result;
use crate::domain::Domain;
use crate::grid::{Grid, VectorField, simd};
use crate::kernels::faces::means;
use crate::particles::Body;
use crate::state::State;

impl<const D: usize> CutBodies<D> {
    /// (8): face velocities from those of the cells, ghosts filled, the correction, of which the
    /// part `numbers.keep` stays on the faces that a body cuts and `numbers.keep_open` on the
    /// others, and the acceleration by the last pressure over `dt` (s), of which the cells still
    /// have the part `1 - numbers.own`. The momentum-interpolation correction becomes the velocity
    /// before that acceleration.
    pub(super) fn interpolate(
        &mut self,
        domain: &Domain<D>,
        s: &mut State<D>,
        StepNumbers { keep, keep_open, own, .. }: StepNumbers,
        dt: f64,
        acceleration: &PressureAcceleration<D>,
    ) -> Result<()> {
        let in_cells = (1.0 - own) * dt;
        let (grid, acceleration) = (&domain.grid, &acceleration.faces);
        let State { u, faces, bodies, surfaces, .. } = s;
        let correction = &mut history(surfaces)?.correction;
        let cuts = |axis| {
            self.bodies
                .iter()
                .flat_map(move |cut: &CutBody<D>| cut.faces(axis))
                .map(|(cut, _)| cut.face as usize)
        };
        let gaps = |axis| self.bodies.iter().flat_map(move |cut: &CutBody<D>| &cut.gaps[axis]);
        self.corrections_before.clear();
        for axis in 0..D {
            let faces = cuts(axis).chain(gaps(axis).map(|gap| gap.face as usize));
            self.corrections_before.extend(faces.map(|face| correction[axis][face]));
        }
        simd(
            #[inline(always)]
            || {
                for (axis, (correction, face)) in
                    correction.iter_mut().zip(faces.iter_mut()).enumerate()
                {
                    for row in grid.face_rows(axis) {
                        let mean = means(&u[axis], row.clone(), grid.stride[axis]);
                        let to =
                            correction[row.clone()].iter_mut().zip(face[row.clone()].iter_mut());
                        for (i, ((m, f), a)) in to.zip(&acceleration[axis][row]).enumerate() {
                            *m = mean(i) + keep_open * *m - in_cells * a;
                            *f = *m + dt * a;
                        }
                    }
                }
            },
        );
        let mut corrections_before = self.corrections_before.iter();
        for axis in 0..D {
            let (correction, face, a) =
                (&mut correction[axis], &mut faces[axis], &acceleration[axis]);
            for (at, before) in cuts(axis).zip(&mut corrections_before) {
                correction[at] = means(&u[axis], at..at + 1, grid.stride[axis])(0) + keep * before
                    - in_cells * a[at];
            }
            for (gap, flow) in gaps(axis).zip(&mut corrections_before) {
                correction[gap.face as usize] += gap.share * (gap.kept - keep).max(0.0) * flow;
            }
            self.interpolate_cut(grid, axis, &u[axis], bodies, (dt, a), correction, face);
        }
        Ok(())
    }

    /// The same on the covered faces of an axis, whose correction has the mean of the cells
    /// already.
    #[allow(clippy::too_many_arguments)]
    fn interpolate_cut(
        &self,
        grid: &Grid<D>,
        axis: usize,
        u: &[f64],
        bodies: &[Body],
        (dt, a): (f64, &[f64]),
        correction: &mut [f64],
        face: &mut [f64],
    ) {
        // Both of two bodies that cut a face count there, each with all of the correction.
        for (cut, centroids) in self.bodies.iter().flat_map(|cut| cut.faces(axis)) {
            let at = cut.face as usize;
            correction[at] += to_open_part(grid, axis, at, &centroids.open, u);
            face[at] = correction[at] + dt * a[at];
        }
        for (k, cut) in self.bodies.each() {
            let body = &bodies[k];
            for (cut, centroids) in cut.faces(axis) {
                let at = cut.face as usize;
                let q = correction[at] + dt * a[at];
                face[at] += cut.solid_fraction * (body.velocity[axis] - q)
                    + body.spin.cross(&centroids.lever())[axis];
            }
        }
    }

    /// Updates the faces' correction, which `CutBodies::interpolate` left before the acceleration
    /// of its step, `dt` (s) long: to what their velocity was beyond the cells' `u` with ghost
    /// cells set at the present place, ghosts filled. What these change at once is then
    /// no change of a face's velocity.
    pub fn update_face_correction(
        &self,
        domain: &Domain<D>,
        u: &VectorField<D>,
        dt: f64,
        acceleration: &PressureAcceleration<D>,
        correction: &mut VectorField<D>,
    ) {
        let (grid, acceleration) = (&domain.grid, &acceleration.faces);
        simd(
            #[inline(always)]
            || {
                for (axis, correction) in correction.iter_mut().enumerate() {
                    for row in grid.face_rows(axis) {
                        let mean = means(&u[axis], row.clone(), grid.stride[axis]);
                        let a = &acceleration[axis][row.clone()];
                        for (i, (m, a)) in correction[row].iter_mut().zip(a).enumerate() {
                            *m += dt * a - mean(i);
                        }
                    }
                }
            },
        );
        for axis in 0..D {
            let correction = &mut correction[axis];
            for (cut, centroids) in self.bodies.iter().flat_map(|cut| cut.faces(axis)) {
                correction[cut.face as usize] -=
                    to_open_part(grid, axis, cut.face as usize, &centroids.open, &u[axis]);
            }
        }
    }
}

/// What a covered face has in place of that mean: that of the two cells, moved to the centroid of
/// its open part by the derivatives.
fn to_open_part<const D: usize>(
    grid: &Grid<D>,
    axis: usize,
    face: usize,
    open: &[f64; D],
    q: &[f64],
) -> f64 {
    let s = grid.stride[axis];
    let parts = (0..D).map(|a| {
        let t = grid.stride[a];
        if a == axis {
            return open[a] * (q[face] - q[face - s]) / grid.h[a];
        }
        open[a] * (q[face + t] - q[face - t] + q[face - s + t] - q[face - s - t])
            / (4.0 * grid.h[a])
    });
    0.5 * (q[face] + q[face - s]) - means(q, face..face + 1, s)(0) + parts.sum::<f64>()
}
