//! Face velocities beside a surface: predicted with their correction (formulas in the parent).

use super::acceleration::PressureAcceleration;
use super::cut::CutBodies;
use super::step_numbers::FaceWeights;
use crate::Result;
use crate::domain::Domain;
use crate::geometry::{Cut, FaceCentroids};
use crate::grid::{Grid, VectorField, simd};
use crate::kernels::faces::means;
use crate::particles::Body;
use crate::state::{State, SurfaceHistory};

/// (8): face velocities from those of the cells, ghosts filled, the correction, of which the part
/// `weights.cut_correction` stays on the faces that a body cuts and `weights.open_correction` on
/// the others, and the acceleration by the last pressure over `dt` (s), of which the cells still
/// have the part `1 - weights.face_gradient`. The correction becomes the velocity before that
/// acceleration.
pub fn interpolate<const D: usize>(
    cut: &mut CutBodies<D>,
    domain: &Domain<D>,
    s: &mut State<D>,
    weights: FaceWeights,
    dt: f64,
    acceleration: &PressureAcceleration<D>,
) -> Result<()> {
    let keep = weights.cut_correction;
    let in_cells = weights.in_cells(dt);
    let grid = &domain.grid;
    let acceleration = &acceleration.faces;
    let State { u, faces, bodies, surfaces, .. } = s;
    let correction = &mut SurfaceHistory::of(surfaces)?.correction;
    cut.corrections_before.clear();
    for (axis, correction) in correction.iter().enumerate() {
        for body in cut.bodies.iter() {
            let before = &mut cut.corrections_before;
            before.extend(body.faces.cuts[axis].iter().map(|cut| correction[cut.face as usize]));
            before.extend(body.faces.gaps[axis].iter().map(|gap| correction[gap.face as usize]));
        }
    }
    predict_open(grid, u, weights, dt, acceleration, correction, faces);
    let friction = cut.friction;
    let mut before = &cut.corrections_before[..];
    for axis in 0..D {
        let q = &u[axis];
        let correction = &mut correction[axis];
        let a = &acceleration[axis];
        let open_part = OpenPart::new(grid, axis);
        for cut in cut.bodies.iter() {
            let (of_cuts, rest) = before.split_at(cut.faces.cuts[axis].len());
            let (of_gaps, rest) = rest.split_at(cut.faces.gaps[axis].len());
            before = rest;
            for ((cut, centroids), before) in cut.covered(axis).zip(of_cuts) {
                let at = cut.face as usize;
                let open = open_part.mean(cut, centroids, q);
                // Both of two bodies that cut a face count there, each with all of the
                // correction.
                if cut.first {
                    correction[at] = open + keep * before - in_cells * a[at];
                } else {
                    correction[at] += open - open_part.of_all(at, q);
                }
            }
            for (gap, flow) in cut.faces.gaps[axis].iter().zip(of_gaps) {
                // Twice half a step.
                let kept = gap.flow.kept(friction).powi(2);
                correction[gap.face as usize] += gap.flow.share * (kept - keep).max(0.0) * flow;
            }
        }
        cover(cut, axis, bodies, dt, a, correction, &mut faces[axis]);
    }
    Ok(())
}

/// Gives the covered faces of an axis the fluid's velocity, which their correction has but for
/// the acceleration, and the bodies' part of it.
fn cover<const D: usize>(
    cut: &CutBodies<D>,
    axis: usize,
    bodies: &[Body],
    dt: f64,
    a: &[f64],
    correction: &[f64],
    face: &mut [f64],
) {
    for (k, cut) in cut.bodies.each() {
        let body = &bodies[k];
        for (cut, centroids) in cut.covered(axis) {
            let at = cut.face as usize;
            let q = correction[at] + dt * a[at];
            let own = cut.solid_fraction * (body.velocity[axis] - q)
                + body.spin.cross(&centroids.lever())[axis];
            face[at] = if cut.first { q } else { face[at] } + own;
        }
    }
}

/// Updates the faces' correction, which [`interpolate`] left before the acceleration of its step,
/// `dt` (s) long: to their velocity beyond that of the cells' `u` with ghost cells set at the
/// present place, ghosts filled. What these change at once is then no change of a face's velocity.
pub fn update_face_correction<const D: usize>(
    cut: &CutBodies<D>,
    domain: &Domain<D>,
    u: &VectorField<D>,
    dt: f64,
    acceleration: &PressureAcceleration<D>,
    correction: &mut VectorField<D>,
) {
    let grid = &domain.grid;
    let acceleration = &acceleration.faces;
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
    for (axis, (correction, q)) in correction.iter_mut().zip(u).enumerate() {
        let open_part = OpenPart::new(grid, axis);
        for (cut, centroids) in cut.bodies.iter().flat_map(|cut| cut.covered(axis)) {
            let at = cut.face as usize;
            correction[at] -= open_part.mean(cut, centroids, q) - open_part.of_all(at, q);
        }
    }
}

/// The correction and the velocity of faces as if no body covered them.
fn predict_open<const D: usize>(
    grid: &Grid<D>,
    u: &VectorField<D>,
    weights: FaceWeights,
    dt: f64,
    acceleration: &VectorField<D>,
    correction: &mut VectorField<D>,
    faces: &mut VectorField<D>,
) {
    let keep = weights.open_correction;
    let in_cells = weights.in_cells(dt);
    simd(
        #[inline(always)]
        || {
            for (axis, (correction, face)) in
                correction.iter_mut().zip(faces.iter_mut()).enumerate()
            {
                for row in grid.face_rows(axis) {
                    let mean = means(&u[axis], row.clone(), grid.stride[axis]);
                    let to = correction[row.clone()].iter_mut().zip(face[row.clone()].iter_mut());
                    for (i, ((m, f), a)) in to.zip(&acceleration[axis][row]).enumerate() {
                        *m = mean(i) + keep * *m - in_cells * a;
                        *f = *m + dt * a;
                    }
                }
            }
        },
    )
}

/// The velocity of the fluid through the open part of a covered face.
struct OpenPart<const D: usize> {
    axis: usize,
    stride: [usize; D],
    /// Factors of the differences of cells in the derivatives (1/m): `1/h` along the axis of the
    /// face, `1/(4 h)` across it, as the mean of two central ones.
    inverse: [f64; D],
}

impl<const D: usize> OpenPart<D> {
    fn new(grid: &Grid<D>, axis: usize) -> OpenPart<D> {
        let factor = |a: usize| if a == axis { 1.0 } else { 0.25 };
        let inverse = std::array::from_fn(|a| factor(a) / grid.h[a]);
        OpenPart { axis, stride: grid.stride, inverse }
    }

    /// Mean of the two cells, moved to the centroid of the open part by the derivatives.
    #[inline(always)]
    fn mean(&self, cut: &Cut, centroids: &FaceCentroids<D>, q: &[f64]) -> f64 {
        let face = cut.face as usize;
        let s = self.stride[self.axis];
        let mut sum = 0.5 * (q[face] + q[face - s]);
        // Inside, where nothing is open, there is no such centroid.
        if centroids.open == [0.0; D] {
            return sum;
        }
        for (a, open) in centroids.open.iter().enumerate() {
            let t = self.stride[a];
            let difference = if a == self.axis {
                q[face] - q[face - s]
            } else {
                q[face + t] - q[face - t] + q[face - s + t] - q[face - s - t]
            };
            sum += open * self.inverse[a] * difference;
        }
        sum
    }

    /// The mean of the cells at a face, as at one that no body covers.
    #[inline(always)]
    fn of_all(&self, face: usize, q: &[f64]) -> f64 {
        means(q, face..face + 1, self.stride[self.axis])(0)
    }
}
