//! Bodies that follow the pressure: what they add to its operator, and how they and the faces
//! respond to a change of it.

use super::body_motion::BodyMotion;
use super::cut::CutBodies;
use crate::Result;
use crate::domain::Domain;
use crate::geometry::{Cut, FaceCentroids};
use crate::particles::Body;
use crate::poisson::ModeFace;
use nalgebra::SymmetricEigen;

/// The modes of the free bodies.
pub struct Modes {
    /// Bodies that are not round: pressure turns them.
    oblong: Vec<u32>,
    /// Weight of each mode (m3/kg).
    weights: Vec<f64>,
    /// The faces that belong to them.
    entries: Vec<ModeFace>,
}

impl Modes {
    /// Those of the bodies.
    pub fn new(bodies: &[Body]) -> Modes {
        let oblong =
            (0..bodies.len() as u32).filter(|k| !bodies[*k as usize].shape().is_round()).collect();
        Modes { weights: Vec::new(), entries: Vec::new(), oblong }
    }

    /// Makes room for what steps find of the cut bodies.
    pub fn make_room<const D: usize>(&mut self, cut: &CutBodies<D>) {
        let n = cut.bodies.count();
        let room = |k: usize| cut.bodies[k].faces.cuts[0].capacity();
        let faces: usize = (0..n).map(room).sum();
        let turning: usize = self.oblong.iter().map(|k| room(*k as usize)).sum();
        self.weights.reserve((n + self.oblong.len()) * D);
        self.entries.reserve(2 * D * faces + D * D * turning);
    }

    /// Bodies that are not round.
    pub fn oblong(&self) -> &[u32] {
        &self.oblong
    }

    /// Gives the pressure's operator what the free bodies add to it: for each direction a mode of
    /// weight `dV/M_k` (m3/kg, zero where the body is held) with the faces that it covers; and for
    /// the bodies that pressure turns a mode about each axis of their response to torque.
    pub fn set<const D: usize>(
        &mut self,
        domain: &mut Domain<D>,
        cut: &CutBodies<D>,
        bodies: &[Body],
        motions: &[BodyMotion],
    ) -> Result<()> {
        if bodies.iter().all(|body| body.freedom().is_none()) {
            return Ok(());
        }
        let Modes { oblong, weights, entries } = self;
        let volume = domain.grid.cell_volume();
        let n = bodies.len();
        weights.clear();
        weights.resize((n + oblong.len()) * D, 0.0);
        entries.clear();
        for (k, motion) in motions.iter().enumerate() {
            let (cut, Some(freedom)) = (&cut.bodies[k], bodies[k].freedom()) else { continue };
            for axis in (0..D).filter(|a| freedom.translation[*a]) {
                let mode = k * D + axis;
                weights[mode] = volume / motion.effective_mass;
                entries.extend(
                    cut.faces.cuts[axis]
                        .iter()
                        .map(|cut| mode_face(mode, axis, cut.face, cut.solid_fraction)),
                );
            }
        }
        for (i, k) in oblong.iter().map(|k| *k as usize).enumerate() {
            let cut = &cut.bodies[k];
            let radius = bodies[k].radius();
            // Velocities per radius, so that these modes are of the size of the others.
            let inverse_inertia = SymmetricEigen::new(radius * radius * motions[k].inverse_inertia);
            let axes = (0..3)
                .filter(|a| bodies[k].freedom().is_some() && inverse_inertia.eigenvalues[*a] > 0.0);
            for (mode, about) in axes.enumerate() {
                let mode = (n + i) * D + mode;
                weights[mode] = volume * inverse_inertia.eigenvalues[about];
                let spin = inverse_inertia.eigenvectors.column(about) / radius;
                for axis in 0..D {
                    let face = |(cut, centroids): (&Cut, &FaceCentroids<D>)| {
                        mode_face(mode, axis, cut.face, spin.cross(&centroids.lever())[axis])
                    };
                    entries.extend(cut.covered(axis).map(face));
                }
            }
        }
        let largest = bodies.iter().map(|body| body.radius()).fold(0.0, f64::max);
        domain.projection.set_extent(2.0 * largest)?;
        domain.projection.set_modes(weights, entries, oblong, cut.reach.sharing())
    }
}

/// Gives the pressure's operator a drive that holds a mean velocity; returns its mean response
/// (m3/kg). Collective.
pub fn hold<const D: usize>(
    domain: &mut Domain<D>,
    cut: &CutBodies<D>,
    bodies: &[Body],
    motions: &[BodyMotion],
) -> Result<f64> {
    let Some(axis) = domain.drive.as_ref().and_then(|drive| drive.held()) else {
        return Ok(0.0);
    };
    let goes = |k: usize| {
        bodies[k]
            .freedom()
            .filter(|freedom| freedom.translation[axis])
            .map(|_| motions[k].displaced_volume[axis] / motions[k].effective_mass)
    };
    let of_body = cut.bodies.each().map(|(k, cut)| (goes(k), cut));
    let followed = of_body
        .filter_map(|(inverse_density, cut)| Some((inverse_density?, &cut.faces.cuts[axis])));
    let faces = followed.flat_map(|(inverse_density, cuts)| {
        cuts.iter()
            .map(move |cut| (cut.face as usize, inverse_density * cut.solid_fraction, cut.owned))
    });
    domain.hold(&cut.beta, faces)
}

fn mode_face(mode: usize, axis: usize, face: u32, part: f64) -> ModeFace {
    ModeFace { mode: mode as u32, axis: axis as u8, face, part }
}
