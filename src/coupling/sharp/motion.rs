//! How bodies go ahead to their new place, and what pressure makes of their velocity there (formulas in the parent).

use super::skin::{Before, RESISTANCE};
use super::{NUMBERS, Sharp};
use crate::Result;
use crate::coupling::refuse_meetings;
use crate::fluid::faces::FaceCoefficient;
use crate::fluid::poisson::Covered;
use crate::fluid::pressure::Rider;
use crate::geometry::{Cut, Opening};
use crate::grid::{Boundaries, Grid, VectorField};
use crate::solids::contact::{Impulse, Push};
use crate::solids::{Body, Inertia, nearest_image};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

impl<const D: usize> Sharp<D> {
    /// Whether any body changes place.
    pub fn moves(&self) -> bool {
        self.bodies.iter().any(Body::moves)
    }

    /// Whether any body is moved by forces.
    pub fn flies(&self) -> bool {
        self.bodies.iter().any(|b| b.freedom().is_some())
    }

    /// Moves the bodies on by `dt` (s), as the last step lets expect and through contacts, and opens the faces there.
    /// Returns the substeps of the contacts. Collective.
    pub fn go_ahead(
        &mut self,
        grid: &Grid<D>,
        boundaries: &Boundaries<D>,
        beta: &mut FaceCoefficient<D>,
        dt: f64,
    ) -> Result<usize> {
        for (ride, body) in self.rides.iter_mut().zip(&self.bodies) {
            ride.start = (body.velocity, body.spin);
            ride.turned = body.inertia().of(&body.spin);
        }
        for (push, ride) in self.push.iter_mut().zip(&self.rides) {
            *push = ride.push;
        }
        if !self.moves() {
            return Ok(0);
        }
        for (before, body) in self.before.iter_mut().zip(&self.bodies) {
            *before = Before { way: body.centre, turn: body.turn() };
        }
        let substeps = match &mut self.contacts {
            Some(contacts) => contacts.advance(&mut self.bodies, &self.push, dt)?,
            None => {
                for (body, push) in self.bodies.iter_mut().zip(&self.push) {
                    body.advance(dt, push, &self.periods);
                }
                0
            }
        };
        refuse_meetings(grid, &self.bodies, self.contacts.is_some(), &self.periods)?;
        for (ride, body) in self.rides.iter_mut().zip(&self.bodies) {
            ride.expected = (body.velocity, body.spin);
        }
        let periods = self.periods;
        for (before, body) in self.before.iter_mut().zip(&self.bodies) {
            before.way = nearest_image(&before.way, &body.centre, &periods);
        }
        self.rebuild(grid, boundaries, beta, false);
        Ok(substeps)
    }

    /// Lets go of the free bodies at their new place: their velocity by all forces with the last pressure `p` (Pa), whose
    /// changes follow. Ghosts of `u` and `p` filled. Collective.
    pub fn release(&mut self, grid: &Grid<D>, u: &VectorField<D>, p: &[f64], dt: f64) -> Result<()> {
        let mut buffer = std::mem::take(&mut self.buffer);
        for (k, row) in buffer.chunks_exact_mut(NUMBERS).enumerate() {
            let (shear, torque) = self.shear_force(grid, k, u);
            let pressed = self.pressure_force(grid, k, p);
            for (slot, v) in row.chunks_exact_mut(3).zip([pressed, shear, torque, self.pressure_torque(grid, k, p)]) {
                slot.copy_from_slice(v.as_slice());
            }
        }
        self.session.sum(&mut buffer)?;
        for (k, row) in buffer.chunks_exact(NUMBERS).enumerate() {
            let [pressure, shear, torque, pressure_torque] =
                [0, 3, 6, 9].map(|n| Vector3::from_column_slice(&row[n..n + 3]));
            let impulse = self.contacts.as_ref().map_or(Impulse::default(), |c| c.impulses()[k]);
            let (body, ride) = (&mut self.bodies[k], &mut self.rides[k]);
            let (before, torque_before) = ride.shear_before.replace((shear, torque)).unwrap_or((shear, torque));
            (ride.pressure, ride.pressure_torque) = (pressure, pressure_torque);
            let (drag, turn) = resistance(body, &self.shells[k], self.fluid_viscosity / self.h);
            let centred = 0.5 * inertial_share(body, &turn, dt);
            ride.shear = (0.5 * (shear + before), torque + centred.component_mul(&(torque_before - torque)));
            let Some(freedom) = body.freedom() else { continue };
            ride.inertia = body.mass() + dt * drag;
            let weight = (body.mass() - self.fluid_density * body.volume()) * self.gravity;
            let change = dt * (pressure + ride.shear.0 + ride.rest + weight + drag * (ride.expected.0 - ride.start.0))
                + impulse.linear;
            body.velocity = ride.start.0 + freedom.along(&change) / ride.inertia;
            // The same angular momentum is another spin once it has turned.
            let (inertia, kept) = (body.inertia(), ride.turned - body.inertia().of(&ride.start.1));
            let change = dt * (ride.shear.1 + pressure_torque + turn.of(&(ride.expected.1 - ride.start.1)))
                + (impulse.angular + kept);
            let resisted = inertia.plus(dt, &turn);
            body.spin = ride.start.1 + resisted.answer(&change, &freedom);
            if !body.shape().is_round() {
                ride.turns = resisted.inverse(&freedom);
            }
        }
        self.buffer = buffer;
        Ok(())
    }

    /// Takes the acceleration of the step `dt` (s) for the next one.
    pub fn note_push(&mut self, dt: f64) {
        for (k, (ride, body)) in self.rides.iter_mut().zip(&self.bodies).enumerate() {
            let Some(freedom) = body.freedom() else { continue };
            let impulse = self.contacts.as_ref().map_or(Impulse::default(), |c| c.impulses()[k]);
            let heavier = body.mass() + self.contacts.as_ref().map_or(0.0, |c| c.carried()[k]);
            let (_, turn) = resistance(body, &self.shells[k], self.fluid_viscosity / self.h);
            let kept = inertial_share(body, &turn, dt) / dt;
            ride.push = Push {
                acceleration: (body.velocity - ride.start.0 - impulse.linear / heavier) / dt,
                angular: (body.spin - ride.start.1 - body.inertia().answer(&impulse.angular, &freedom))
                    .component_mul(&kept),
            };
        }
    }

    /// Finds what the free bodies add to the pressure's operator: for each direction a mode of weight `dV/M_k` (m3/kg, zero
    /// where the body is held) with the faces that it covers; and for the bodies that pressure turns, which it names, a mode
    /// about each axis of their answer to torque.
    pub fn modes(&mut self, grid: &Grid<D>) -> (&[f64], &[Covered], &[u32]) {
        let (volume, n) = (grid.cell_volume(), self.bodies.len());
        self.weights.clear();
        self.weights.resize((n + self.oblong.len()) * D, 0.0);
        self.entries.clear();
        for (k, (skin, ride)) in self.skins.iter().zip(&self.rides).enumerate() {
            let Some(freedom) = self.bodies[k].freedom() else { continue };
            for axis in (0..D).filter(|a| freedom.translation[*a]) {
                let mode = k * D + axis;
                self.weights[mode] = volume / ride.inertia;
                let face = |cut: &Cut| covered(mode, axis, cut.face, cut.covered);
                self.entries.extend(skin.cuts[axis].iter().map(face));
            }
        }
        for (i, k) in self.oblong.iter().map(|k| *k as usize).enumerate() {
            let (skin, radius) = (&self.skins[k], self.bodies[k].radius());
            // Velocities per radius, so that these modes are of the size of the others.
            let answer = SymmetricEigen::new(radius * radius * self.rides[k].turns);
            let axes = (0..3).filter(|a| self.bodies[k].freedom().is_some() && answer.eigenvalues[*a] > 0.0);
            for (mode, about) in axes.enumerate() {
                let mode = (n + i) * D + mode;
                self.weights[mode] = volume * answer.eigenvalues[about];
                let spin = answer.eigenvectors.column(about) / radius;
                for axis in 0..D {
                    let face = |(cut, opening): (&Cut, &Opening)| {
                        covered(mode, axis, cut.face, spin.cross(&opening.lever)[axis])
                    };
                    self.entries.extend(skin.faces(axis).map(face));
                }
            }
        }
        (&self.weights, &self.entries, &self.oblong)
    }
}

fn covered(mode: usize, axis: usize, face: u32, part: f64) -> Covered {
    Covered { mode: mode as u32, axis: axis as u8, face, part }
}

/// What the wall shear takes back of a change of a body's velocity (N s/m) and spin (N m s) within a step, for a viscosity over
/// spacing (Pa s/m) and its surface's area and moments: of the velocity by the profile's first probe, of the spin by the slope
/// of the wall shear itself.
fn resistance(body: &Body, (area, shell): &(f64, Matrix3<f64>), unit: f64) -> (f64, Inertia) {
    let slope = unit * RESISTANCE;
    if body.shape().is_round() {
        return (unit * area, Inertia::Same(slope * shell[(2, 2)]));
    }
    let turn = body.turn();
    (unit * area, Inertia::Tensor(slope * (turn * shell * turn.transpose())))
}

/// The part of a free body's answer to torque over the step `dt` (s) that is inertia, and not the wall shear's resistance `turn`
/// (N m s), by axis. The torque is centred in time, and the spin carried on, as far as this goes: of a body of no inertia the
/// spin is that of the flow around it, and what it was before only feeds an oscillation (nothing but added mass resists
/// pressure, but nothing adds inertia to a disc's spin).
fn inertial_share(body: &Body, turn: &Inertia, dt: f64) -> Vector3<f64> {
    let (own, resisted) = (body.inertia(), body.inertia().plus(dt, turn));
    Vector3::from_fn(|a, _| body.freedom().map_or(1.0, |_| own.about(a) / resisted.about(a)))
}

impl<const D: usize> Sharp<D> {
    /// Likewise for the spin of the bodies that pressure turns; three numbers of each in `sums`.
    fn follow_turning(
        &mut self,
        grid: &Grid<D>,
        dt: f64,
        phi: &[f64],
        faces: &mut VectorField<D>,
        sums: &mut [f64],
    ) -> Result<()> {
        for (k, row) in self.oblong.iter().zip(sums.chunks_exact_mut(3)) {
            row.copy_from_slice(self.pressure_torque(grid, *k as usize, phi).as_slice());
        }
        self.session.sum(sums)?;
        for (k, row) in self.oblong.iter().map(|k| *k as usize).zip(sums.chunks_exact(3)) {
            let torque = Vector3::from_column_slice(row);
            let (body, ride) = (&mut self.bodies[k], &mut self.rides[k]);
            ride.pressure_torque += torque;
            if body.freedom().is_none() {
                continue;
            }
            let change = ride.turns * (dt * torque);
            body.spin += change;
            for axis in 0..D {
                for (cut, opening) in self.skins[k].faces(axis) {
                    faces[axis][cut.face as usize] += change.cross(&opening.lever)[axis];
                }
            }
        }
        Ok(())
    }
}

impl<const D: usize> Rider<D> for Sharp<D> {
    fn follow(&mut self, grid: &Grid<D>, dt: f64, phi: &[f64], faces: &mut VectorField<D>) -> Result<()> {
        let mut buffer = std::mem::take(&mut self.buffer);
        let (sums, rest) = buffer.split_at_mut(3 * self.bodies.len());
        for (k, row) in sums.chunks_exact_mut(3).enumerate() {
            row.copy_from_slice(self.pressure_force(grid, k, phi).as_slice());
        }
        self.session.sum(sums)?;
        for (k, row) in sums.chunks_exact(3).enumerate() {
            let force = Vector3::from_column_slice(row);
            let (body, ride) = (&mut self.bodies[k], &mut self.rides[k]);
            ride.pressure += force;
            let Some(freedom) = body.freedom() else { continue };
            let change = freedom.along(&force) * (dt / ride.inertia);
            body.velocity += change;
            for (axis, cuts) in self.skins[k].cuts.iter().enumerate() {
                cuts.iter().for_each(|cut| faces[axis][cut.face as usize] += cut.covered * change[axis]);
            }
        }
        if !self.oblong.is_empty() {
            self.follow_turning(grid, dt, phi, faces, &mut rest[..3 * self.oblong.len()])?;
        }
        self.buffer = buffer;
        Ok(())
    }
}
