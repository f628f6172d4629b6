//! Bodies that follow the pressure: what they add to its operator, and how they and the faces
//! respond to a change of it.

use super::Sharp;
use super::coupled::CoupledFaces;
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
use crate::sums::Sums;
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
        let oblong: Vec<u32> =
            (0..n as u32).filter(|k| !bodies[*k as usize].shape().is_round()).collect();
        let room = |k: usize| cut.bodies[k].cuts[0].capacity();
        let (faces, turning): (usize, usize) =
            ((0..n).map(room).sum(), oblong.iter().map(|k| room(*k as usize)).sum());
        Modes {
            weights: Vec::with_capacity((n + oblong.len()) * D),
            entries: Vec::with_capacity(2 * D * faces + D * D * turning),
            oblong,
        }
    }
}

/// Scratch of what ranks sum per body while the pressure is found.
#[derive(Debug, Default)]
pub struct PressureSums {
    values: Vec<Vector3<f64>>,
    sums: Sums,
}

impl<const D: usize> Sharp<D> {
    /// Gives the pressure's operator what the free bodies add to it: for each direction a mode of
    /// weight `dV/M_k` (m3/kg, zero where the body is held) with the faces that it covers; and for
    /// the bodies that pressure turns a mode about each axis of their response to torque.
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
                entries.extend(
                    cut.cuts[axis].iter().map(|cut| covered(mode, axis, cut.face, cut.covered)),
                );
            }
        }
        for (i, k) in oblong.iter().map(|k| *k as usize).enumerate() {
            let (cut, radius) = (&self.cut.bodies[k], bodies[k].radius());
            // Velocities per radius, so that these modes are of the size of the others.
            let inverse_mass = SymmetricEigen::new(radius * radius * self.motions[k].turns);
            let axes = (0..3)
                .filter(|a| bodies[k].freedom().is_some() && inverse_mass.eigenvalues[*a] > 0.0);
            for (mode, about) in axes.enumerate() {
                let mode = (n + i) * D + mode;
                weights[mode] = volume * inverse_mass.eigenvalues[about];
                let spin = inverse_mass.eigenvectors.column(about) / radius;
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

    /// Finds the volumes on which the drive acts. One that holds a mean velocity, as a mean
    /// gradient of the pressure, acts on free bodies through the faces that the pressure acts
    /// through, or the two would not be found together: with their own volume a light body beside a
    /// heavy one did not let the iteration converge. Collective.
    pub(super) fn find_displaced(&mut self, domain: &Domain<D>, bodies: &[Body]) -> Result<()> {
        for (motion, body) in self.motions.iter_mut().zip(bodies) {
            motion.displaced = Vector3::repeat(body.volume());
        }
        if domain.drive.as_ref().and_then(|drive| drive.held()).is_none() {
            return Ok(());
        }
        let (volume, all) = (domain.grid.cell_volume(), &mut self.pressure_sums);
        all.values.clear();
        all.values.extend(self.cut.bodies.iter().map(|cut| {
            let covered = |axis: usize| {
                let cuts = cut.cuts[axis].iter().filter(|cut| cut.owned);
                volume * cuts.map(|cut| cut.covered).sum::<f64>()
            };
            Vector3::from_fn(|axis, _| if axis < D { covered(axis) } else { 0.0 })
        }));
        all.sums.over_ranks(&domain.session, &mut all.values)?;
        let free = self.motions.iter_mut().zip(bodies).zip(&all.values);
        for ((motion, _), displaced) in free.filter(|((_, body), _)| body.freedom().is_some()) {
            (0..D).for_each(|axis| motion.displaced[axis] = displaced[axis]);
        }
        Ok(())
    }

    /// Lets the pressure's equation know of a drive that holds a mean velocity; returns its mean
    /// response (m3/kg). Collective.
    fn hold(&self, domain: &mut Domain<D>, bodies: &[Body]) -> Result<f64> {
        let Some(axis) = domain.drive.as_ref().and_then(|drive| drive.held()) else {
            return Ok(0.0);
        };
        let goes = |(body, motion): (&Body, &BodyMotion)| {
            body.freedom()
                .filter(|freedom| freedom.translation[axis])
                .map(|_| motion.displaced[axis] / motion.inertia)
        };
        let of_body = bodies.iter().zip(&self.motions).map(goes).zip(&self.cut.bodies);
        let carried =
            of_body.filter_map(|(inverse_mass, cut)| Some((inverse_mass?, &cut.cuts[axis])));
        let faces = carried.flat_map(|(inverse_mass, cuts)| {
            cuts.iter().map(move |cut| (cut.face as usize, inverse_mass * cut.covered, cut.owned))
        });
        domain.hold(&self.cut.beta, faces)
    }

    /// (13-15), the bodies with it; `roughly` as in
    /// [`Projection::project`](crate::poisson::pressure::Projection::project). Collective.
    pub(super) fn project_with_bodies(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
        roughly: Option<f64>,
    ) -> Result<Projected> {
        let inverse_mass = self.hold(domain, &s.bodies)?;
        let Domain { session, grid, boundaries, projection, drive, fluid, .. } = domain;
        let (density, beta) = (fluid.density, &self.cut.beta);
        let drive = drive.as_ref().zip(s.drive.as_mut());
        let mut following = Following {
            session,
            coupled: CoupledFaces::new(&self.cut, &mut s.faces, &mut s.bodies),
            driving: drive.map(|(drive, force)| Driving {
                drive,
                force,
                beta,
                inverse_mass,
                density,
                session,
            }),
            oblong: &self.modes.oblong,
            motions: &mut self.motions,
            sums: &mut self.pressure_sums,
        };
        projection.project(grid, boundaries, &self.cut.beta, dt, &mut s.p, &mut following, roughly)
    }
}

fn covered(mode: usize, axis: usize, face: u32, part: f64) -> Covered {
    Covered { mode: mode as u32, axis: axis as u8, face, part }
}

/// The bodies while the pressure is found.
struct Following<'a, const D: usize> {
    session: &'a Session,
    coupled: CoupledFaces<'a, D>,
    driving: Option<Driving<'a, D>>,
    oblong: &'a [u32],
    motions: &'a mut [BodyMotion],
    sums: &'a mut PressureSums,
}

impl<const D: usize> Coupled<D> for Following<'_, D> {
    fn faces(&mut self) -> &mut VectorField<D> {
        self.coupled.split().0
    }

    fn begin(&mut self, grid: &Grid<D>, dt: f64) -> Result<()> {
        let Some(driving) = &mut self.driving else { return Ok(()) };
        let (faces, bodies) = self.coupled.split();
        let change = driving.follow(grid, bodies, dt, faces)?;
        if change == Vector3::zeros() {
            return Ok(());
        }
        let drive = driving.drive;
        for k in 0..self.motions.len() {
            let force = drive.on_body(&change, 1.0).component_mul(&self.motions[k].displaced);
            self.apply_force(k, &force, dt);
        }
        Ok(())
    }

    fn follow(&mut self, grid: &Grid<D>, dt: f64, phi: &[f64]) -> Result<()> {
        let (cut, bodies) = (self.coupled.cut(), self.motions.len());
        self.sums.values.clear();
        self.sums.values.extend((0..bodies).map(|k| cut.pressure_force(grid, k, phi)));
        self.sums.sums.over_ranks(self.session, &mut self.sums.values)?;
        for k in 0..bodies {
            let force = self.sums.values[k];
            self.apply_force(k, &force, dt);
        }
        if !self.oblong.is_empty() {
            self.follow_turning(grid, dt, phi)?;
        }
        self.begin(grid, dt)
    }
}

impl<const D: usize> Following<'_, D> {
    /// Gives a body another force by pressure (N) over the step `dt` (s).
    fn apply_force(&mut self, k: usize, force: &Vector3<f64>, dt: f64) {
        let motion = &mut self.motions[k];
        motion.pressure += force;
        if let Some(freedom) = self.coupled.bodies()[k].freedom() {
            self.coupled.change(
                k,
                &(freedom.along(force) * (dt / motion.inertia)),
                &Vector3::zeros(),
            );
        }
    }

    /// Likewise for the spin of the bodies that pressure turns.
    fn follow_turning(&mut self, grid: &Grid<D>, dt: f64, phi: &[f64]) -> Result<()> {
        let (cut, bodies) = (self.coupled.cut(), self.coupled.bodies());
        let oblong = self.oblong.iter().map(|k| *k as usize);
        self.sums.values.clear();
        self.sums
            .values
            .extend(oblong.clone().map(|k| cut.pressure_torque(grid, &bodies[k], k, phi)));
        self.sums.sums.over_ranks(self.session, &mut self.sums.values)?;
        for (k, &torque) in oblong.zip(&self.sums.values) {
            let motion = &mut self.motions[k];
            motion.pressure_torque += torque;
            if self.coupled.bodies()[k].freedom().is_some() {
                self.coupled.change(k, &Vector3::zeros(), &(motion.turns * (dt * torque)));
            }
        }
        Ok(())
    }
}
