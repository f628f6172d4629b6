//! Faces and bodies have one owner while the pressure is found: no body changes its velocity
//! without the faces that it covers.
//!
//! ```text
//!   U = H q + m V.n + (omega x lever).n        so that    V += dV, omega += d_omega    =>
//!              U += m dV.n + (d_omega x lever).n
//! ```

use super::cut::CutBodies;
use crate::grid::VectorField;
use crate::particles::{Body, RigidVelocity};
use nalgebra::Vector3;

/// The velocities through faces, and the bodies that cover them.
pub struct CoupledFaces<'a, const D: usize> {
    cut: &'a CutBodies<D>,
    faces: &'a mut VectorField<D>,
    bodies: &'a mut [Body],
}

impl<'a, const D: usize> CoupledFaces<'a, D> {
    /// The faces (m/s), which agree with the velocities of the bodies.
    pub fn new(
        cut: &'a CutBodies<D>,
        faces: &'a mut VectorField<D>,
        bodies: &'a mut [Body],
    ) -> CoupledFaces<'a, D> {
        CoupledFaces { cut, faces, bodies }
    }

    /// The bodies.
    pub fn bodies(&self) -> &[Body] {
        self.bodies
    }

    /// The cut bodies.
    pub fn cut(&self) -> &'a CutBodies<D> {
        self.cut
    }

    /// The velocities through faces (m/s), for changes of the fluid's own.
    pub fn faces(&mut self) -> &mut VectorField<D> {
        self.faces
    }

    /// Sets the velocity (m/s) and the spin (rad/s) of a body to what they are on its rank, whose
    /// faces have them already.
    pub fn set(&mut self, k: usize, motion: &RigidVelocity) {
        let body = &mut self.bodies[k];
        body.velocity = motion.velocity;
        body.spin = motion.spin;
    }

    /// Changes the velocity (m/s) and the spin (rad/s) of a body, and its faces.
    pub fn change(&mut self, k: usize, velocity: &Vector3<f64>, spin: &Vector3<f64>) {
        if *velocity == Vector3::zeros() && *spin == Vector3::zeros() {
            return;
        }
        let body = &mut self.bodies[k];
        body.velocity += velocity;
        body.spin += spin;
        let turns = !body.shape().is_round() && *spin != Vector3::zeros();
        for (axis, faces) in self.faces.iter_mut().enumerate() {
            for cut in &self.cut.bodies[k].faces.cuts[axis] {
                faces[cut.face as usize] += cut.solid_fraction * velocity[axis];
            }
            if turns {
                for (cut, centroids) in self.cut.bodies[k].covered(axis) {
                    faces[cut.face as usize] += spin.cross(&centroids.lever())[axis];
                }
            }
        }
    }
}
