//! Face velocities beside a wall: predicted with their history, and what pressure gives the cells of cut faces (formulas in the
//! parent).

use super::{FORGET, Sharp, Skin};
use crate::fluid::faces::FaceCoefficient;
use crate::grid::{Grid, VectorField, wide};
use nalgebra::Vector3;
use std::ops::Range;

impl<const D: usize> Sharp<D> {
    /// How much of the face velocities' history a step of `dt` (s) forgets, at the largest face speed (m/s).
    pub fn forget(&mut self, dt: f64, speed: f64) {
        self.courant = dt * speed / self.h;
        self.chi = (dt * speed / (FORGET * self.h)).min(1.0);
    }

    /// Face velocities (m/s) from the cells' `u`, ghosts filled, and the acceleration by the last pressure (m/s2).
    pub fn pass_faces(
        &mut self,
        grid: &Grid<D>,
        u: &VectorField<D>,
        dt: f64,
        acceleration: &VectorField<D>,
        faces: &mut VectorField<D>,
    ) {
        let (keep, memory) = (1.0 - self.chi, &mut self.memory);
        wide(
            #[inline(always)]
            || {
                for (axis, (memory, face)) in memory.iter_mut().zip(faces.iter_mut()).enumerate() {
                    for row in grid.face_rows(axis) {
                        let mean = means(&u[axis], row.clone(), grid.stride[axis]);
                        let to = memory[row.clone()].iter_mut().zip(face[row.clone()].iter_mut());
                        for (i, ((m, f), a)) in to.zip(&acceleration[axis][row]).enumerate() {
                            *m = mean(i) + keep * *m;
                            *f = *m + dt * a;
                        }
                    }
                }
            },
        );
        for axis in 0..D {
            let (memory, face, a) = (&mut self.memory[axis], &mut faces[axis], &acceleration[axis]);
            // Of what two bodies cover both have their say, each with all that the memory has.
            for (cut, opening) in self.skins.iter().flat_map(|skin| skin.faces(axis)) {
                let at = cut.face as usize;
                memory[at] += to_open_part(grid, axis, at, &opening.open, &u[axis]);
                face[at] = memory[at] + dt * a[at];
            }
            for (skin, body) in self.skins.iter().zip(&self.bodies) {
                for (cut, opening) in skin.faces(axis) {
                    let at = cut.face as usize;
                    let q = memory[at] + dt * a[at];
                    face[at] += cut.covered * (body.velocity[axis] - q) + body.spin.cross(&opening.lever)[axis];
                }
            }
        }
    }

    /// Takes the history of the face velocities: what they were after the last step, `dt` (s) long with this acceleration
    /// on faces (m/s2), beyond the cells' `u` with the wall imposed at the present place, ghosts filled. What the imposed
    /// wall changes at once is then no change of a face's velocity.
    pub fn remember_faces(
        &mut self,
        grid: &Grid<D>,
        beta: &FaceCoefficient<D>,
        u: &VectorField<D>,
        dt: f64,
        acceleration: &VectorField<D>,
    ) {
        let memory = &mut self.memory;
        wide(
            #[inline(always)]
            || {
                for (axis, memory) in memory.iter_mut().enumerate() {
                    for row in grid.face_rows(axis) {
                        let mean = means(&u[axis], row.clone(), grid.stride[axis]);
                        let a = &acceleration[axis][row.clone()];
                        for (i, (m, a)) in memory[row].iter_mut().zip(a).enumerate() {
                            *m += dt * a - mean(i);
                        }
                    }
                }
            },
        );
        for axis in 0..D {
            let memory = &mut self.memory[axis];
            for (cut, opening) in self.skins.iter().flat_map(|skin| skin.faces(axis)) {
                memory[cut.face as usize] -= to_open_part(grid, axis, cut.face as usize, &opening.open, &u[axis]);
            }
            // What has just opened has no history: a gap that was nearly closed may have carried any velocity.
            for &(face, open) in &self.covered[axis] {
                memory[face] *= (open / (beta.at(axis, face) * self.fluid_density)).min(1.0);
            }
        }
    }

    /// Takes the velocities of faces as their history.
    pub fn hold_faces(&mut self, faces: &VectorField<D>) {
        self.memory.iter_mut().zip(faces).for_each(|(m, f)| m.copy_from_slice(f));
    }

    /// Forgets the history of the face velocities.
    pub fn forget_faces(&mut self) {
        self.memory.iter_mut().for_each(|m| m.fill(0.0));
    }

    /// Finds what the acceleration on faces (m/s2) gives the cells beyond the mean of their two faces', which they have: where
    /// faces are covered the open ones count.
    pub fn find_open_gradient(&mut self, grid: &Grid<D>, beta: &FaceCoefficient<D>, acceleration: &VectorField<D>) {
        let FaceCoefficient::Field(beta) = beta else { return };
        self.excess.clear();
        let (density, excess) = (self.fluid_density, &mut self.excess);
        for o in self.skins.iter().flat_map(Skin::own_cells) {
            excess.push(std::array::from_fn(|axis| {
                let (low, high) = (o.cell, o.cell + grid.stride[axis]);
                let [open_low, open_high] = [low, high].map(|f| beta[axis][f] * density);
                let (a_low, a_high) = (acceleration[axis][low], acceleration[axis][high]);
                let open = (open_low * a_low + open_high * a_high) / (1.0 + 0.5 * (open_low + open_high));
                open - 0.5 * (a_low + a_high)
            }));
        }
    }

    /// Adds to the cells what `dt` (s) of that gives. With `book`, the momentum is booked.
    pub fn open_gradient(&mut self, grid: &Grid<D>, dt: f64, book: bool, u: &mut VectorField<D>) {
        let mass = self.fluid_density * grid.cell_volume();
        let mut excess = self.excess.iter();
        for (skin, ride) in self.skins.iter().zip(&mut self.rides) {
            for (o, excess) in skin.own_cells().zip(&mut excess) {
                for (field, excess) in u.iter_mut().zip(excess) {
                    field[o.cell] += dt * excess;
                }
                if book {
                    let added = Vector3::from_fn(|a, _| if a < D { mass * (dt * excess[a]) } else { 0.0 });
                    ride.given += added;
                    ride.spun += o.arm.cross(&added);
                }
            }
        }
    }
}

/// The means of the cells along a row of faces, of fourth order: `(-1, 9, 9, -1)/16` across each.
#[inline(always)]
fn means(q: &[f64], row: Range<usize>, stride: usize) -> impl Fn(usize) -> f64 {
    let [far_low, low, high, far_high] =
        std::array::from_fn(|k| &q[row.start + k * stride - 2 * stride..][..row.len()]);
    move |i| 0.5625 * (low[i] + high[i]) - 0.0625 * (far_low[i] + far_high[i])
}

/// What a covered face has in place of that mean: that of the two cells, moved to the centroid of its open part by the
/// derivatives.
fn to_open_part<const D: usize>(grid: &Grid<D>, axis: usize, face: usize, open: &Vector3<f64>, q: &[f64]) -> f64 {
    let s = grid.stride[axis];
    let parts = (0..D).map(|a| {
        let t = grid.stride[a];
        if a == axis {
            return open[a] * (q[face] - q[face - s]) / grid.h[a];
        }
        open[a] * (q[face + t] - q[face - t] + q[face - s + t] - q[face - s - t]) / (4.0 * grid.h[a])
    });
    0.5 * (q[face] + q[face - s]) - means(q, face..face + 1, s)(0) + parts.sum::<f64>()
}
