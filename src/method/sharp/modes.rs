//! Bodies that follow the pressure: what they add to its operator, and how they and the faces answer a change of it.

use super::Sharp;
use super::cut::CutBodies;
use super::motion::BodyMotion;
use crate::Result;
use crate::domain::Domain;
use crate::drive::Driving;
use crate::geometry::{Cut, Opening};
use crate::grid::{Grid, VectorField};
use crate::particles::Body;
use crate::petsc::Session;
use crate::poisson::Covered;
use crate::poisson::pressure::{Coupled, Projected};
use crate::state::State;
use nalgebra::{SymmetricEigen, Vector3};

/// The modes of the free bodies.
pub struct Modes {
    /// Bodies that are not round: pressure turns them.
    oblong: Vec<u32>,
    /// Of each mode (m3/kg).
    weights: Vec<f64>,
    /// The faces that belong to them.
    entries: Vec<Covered>,
}

impl Modes {
    /// Room for those of the bodies.
    pub fn new<const D: usize>(bodies: &[Body], cut: &CutBodies<D>) -> Modes {
        let n = bodies.len();
        let oblong: Vec<u32> = (0..n as u32).filter(|k| !bodies[*k as usize].shape().is_round()).collect();
        let room = |k: usize| cut.bodies[k].cuts[0].capacity();
        let (faces, turning): (usize, usize) = ((0..n).map(room).sum(), oblong.iter().map(|k| room(*k as usize)).sum());
        Modes {
            weights: Vec::with_capacity((n + oblong.len()) * D),
            entries: Vec::with_capacity(2 * D * faces + D * D * turning),
            oblong,
        }
    }
}

impl<const D: usize> Sharp<D> {
    /// Gives the pressure's operator what the free bodies add to it: for each direction a mode of weight `dV/M_k` (m3/kg, zero
    /// where the body is held) with the faces that it covers; and for the bodies that pressure turns a mode about each axis of
    /// their answer to torque.
    pub(super) fn set_modes(&mut self, domain: &mut Domain<D>, bodies: &[Body]) -> Result<()> {
        if bodies.iter().all(|body| body.freedom().is_none()) {
            return Ok(());
        }
        let Modes { oblong, weights, entries } = &mut self.modes;
        let (volume, n) = (domain.grid.cell_volume(), bodies.len());
        weights.clear();
        weights.resize((n + oblong.len()) * D, 0.0);
        entries.clear();
        for (k, (cut, motion)) in self.cut.bodies.iter().zip(&self.motions).enumerate() {
            let Some(freedom) = bodies[k].freedom() else { continue };
            for axis in (0..D).filter(|a| freedom.translation[*a]) {
                let mode = k * D + axis;
                weights[mode] = volume / motion.inertia;
                entries.extend(cut.cuts[axis].iter().map(|cut| covered(mode, axis, cut.face, cut.covered)));
            }
        }
        for (i, k) in oblong.iter().map(|k| *k as usize).enumerate() {
            let (cut, radius) = (&self.cut.bodies[k], bodies[k].radius());
            // Velocities per radius, so that these modes are of the size of the others.
            let answer = SymmetricEigen::new(radius * radius * self.motions[k].turns);
            let axes = (0..3).filter(|a| bodies[k].freedom().is_some() && answer.eigenvalues[*a] > 0.0);
            for (mode, about) in axes.enumerate() {
                let mode = (n + i) * D + mode;
                weights[mode] = volume * answer.eigenvalues[about];
                let spin = answer.eigenvectors.column(about) / radius;
                for axis in 0..D {
                    let face = |(cut, opening): (&Cut, &Opening<D>)| {
                        covered(mode, axis, cut.face, spin.cross(&opening.lever())[axis])
                    };
                    entries.extend(cut.faces(axis).map(face));
                }
            }
        }
        domain.projection.set_modes(weights, entries, oblong)
    }

    /// Finds the volumes on which the drive acts. One that holds a mean velocity, as a mean gradient of the pressure, acts on free bodies through the faces
    /// that the pressure acts through, or the two would not be found together: with their own volume a light body beside a heavy one did not let
    /// the iteration converge. Collective.
    pub(super) fn find_displaced(&mut self, domain: &Domain<D>, bodies: &[Body]) -> Result<()> {
        for (motion, body) in self.motions.iter_mut().zip(bodies) {
            motion.displaced = Vector3::repeat(body.volume());
        }
        if domain.drive.as_ref().and_then(|drive| drive.held()).is_none() {
            return Ok(());
        }
        let (volume, sums) = (domain.grid.cell_volume(), &mut self.work.sums[..3 * bodies.len()]);
        for (row, cut) in sums.chunks_exact_mut(3).zip(&self.cut.bodies) {
            for (sum, cuts) in row.iter_mut().zip(&cut.cuts) {
                *sum = volume * cuts.iter().filter(|cut| cut.owned).map(|cut| cut.covered).sum::<f64>();
            }
        }
        domain.session.sum(sums)?;
        let free = self.motions.iter_mut().zip(bodies).zip(sums.chunks_exact(3));
        for ((motion, _), row) in free.filter(|((_, body), _)| body.freedom().is_some()) {
            (0..D).for_each(|axis| motion.displaced[axis] = row[axis]);
        }
        Ok(())
    }

    /// Lets the pressure's equation know of a drive that holds a mean velocity; returns its mean answer (m3/kg). Collective.
    fn hold(&self, domain: &mut Domain<D>, bodies: &[Body]) -> Result<f64> {
        let Some(axis) = domain.drive.as_ref().and_then(|drive| drive.held()) else { return Ok(0.0) };
        let goes = |(body, motion): (&Body, &BodyMotion)| {
            body.freedom().filter(|freedom| freedom.translation[axis]).map(|_| motion.displaced[axis] / motion.inertia)
        };
        let of_body = bodies.iter().zip(&self.motions).map(goes).zip(&self.cut.bodies);
        let carried = of_body.filter_map(|(answer, cut)| Some((answer?, &cut.cuts[axis])));
        let faces = carried.flat_map(|(answer, cuts)| {
            cuts.iter().map(move |cut| (cut.face as usize, answer * cut.covered, cut.owned))
        });
        domain.hold(&self.cut.beta, faces)
    }

    /// (13-15), the bodies with it; `roughly` as in [`Projection::project`](crate::poisson::pressure::Projection::project). Collective.
    pub(super) fn project_with_bodies(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
        roughly: Option<f64>,
    ) -> Result<Projected> {
        let answer = self.hold(domain, &s.bodies)?;
        let Domain { session, grid, boundaries, projection, drive, fluid, .. } = domain;
        let (density, beta) = (fluid.density, &self.cut.beta);
        let drive = drive.as_ref().zip(s.drive.as_mut());
        let mut following = Following {
            session,
            cut: &self.cut,
            driving: drive.map(|(drive, force)| Driving { drive, force, beta, answer, density, session }),
            oblong: &self.modes.oblong,
            bodies: &mut s.bodies,
            motions: &mut self.motions,
            sums: &mut self.work.sums,
        };
        projection.project(grid, boundaries, &self.cut.beta, dt, &mut s.p, &mut s.faces, Some(&mut following), roughly)
    }
}

fn covered(mode: usize, axis: usize, face: u32, part: f64) -> Covered {
    Covered { mode: mode as u32, axis: axis as u8, face, part }
}

/// The bodies while the pressure is found.
struct Following<'a, const D: usize> {
    session: &'a Session,
    cut: &'a CutBodies<D>,
    driving: Option<Driving<'a, D>>,
    oblong: &'a [u32],
    bodies: &'a mut [Body],
    motions: &'a mut [BodyMotion],
    sums: &'a mut [f64],
}

impl<const D: usize> Coupled<D> for Following<'_, D> {
    fn begin(&mut self, grid: &Grid<D>, dt: f64, faces: &mut VectorField<D>) -> Result<()> {
        let Some(driving) = &mut self.driving else { return Ok(()) };
        let change = driving.follow(grid, self.bodies, dt, faces)?;
        if change == Vector3::zeros() {
            return Ok(());
        }
        for (k, (body, motion)) in self.bodies.iter_mut().zip(self.motions.iter_mut()).enumerate() {
            let force = driving.drive.on_body(&change, 1.0).component_mul(&motion.displaced);
            motion.pressure += force;
            let Some(freedom) = body.freedom() else { continue };
            let change = freedom.along(&force) * (dt / motion.inertia);
            body.velocity += change;
            self.cut.bodies[k].carry_faces(&change, faces);
        }
        Ok(())
    }

    fn follow(&mut self, grid: &Grid<D>, dt: f64, phi: &[f64], faces: &mut VectorField<D>) -> Result<()> {
        let sums = &mut self.sums[..3 * self.bodies.len()];
        for (k, row) in sums.chunks_exact_mut(3).enumerate() {
            row.copy_from_slice(self.cut.pressure_force(grid, k, phi).as_slice());
        }
        self.session.sum(sums)?;
        for (k, row) in sums.chunks_exact(3).enumerate() {
            let force = Vector3::from_column_slice(row);
            let (body, motion) = (&mut self.bodies[k], &mut self.motions[k]);
            motion.pressure += force;
            let Some(freedom) = body.freedom() else { continue };
            let change = freedom.along(&force) * (dt / motion.inertia);
            body.velocity += change;
            self.cut.bodies[k].carry_faces(&change, faces);
        }
        if !self.oblong.is_empty() {
            self.follow_turning(grid, dt, phi, faces)?;
        }
        self.begin(grid, dt, faces)
    }
}

impl<const D: usize> Following<'_, D> {
    /// Likewise for the spin of the bodies that pressure turns.
    fn follow_turning(&mut self, grid: &Grid<D>, dt: f64, phi: &[f64], faces: &mut VectorField<D>) -> Result<()> {
        let sums = &mut self.sums[..3 * self.oblong.len()];
        for (k, row) in self.oblong.iter().map(|k| *k as usize).zip(sums.chunks_exact_mut(3)) {
            row.copy_from_slice(self.cut.pressure_torque(grid, &self.bodies[k], k, phi).as_slice());
        }
        self.session.sum(sums)?;
        for (k, row) in self.oblong.iter().map(|k| *k as usize).zip(sums.chunks_exact(3)) {
            let torque = Vector3::from_column_slice(row);
            let (body, motion) = (&mut self.bodies[k], &mut self.motions[k]);
            motion.pressure_torque += torque;
            if body.freedom().is_none() {
                continue;
            }
            let change = motion.turns * (dt * torque);
            body.spin += change;
            for axis in 0..D {
                for (cut, opening) in self.cut.bodies[k].faces(axis) {
                    faces[axis][cut.face as usize] += change.cross(&opening.lever())[axis];
                }
            }
        }
        Ok(())
    }
}
