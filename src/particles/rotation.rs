//! How a body turns on by itself.
//!
//! ```text
//!   L = I w  stays in the axes of the box          I = R I_0 R^T, R the orientation
//!   dR/dt = w x R,  w = I^-1 L                    by Runge-Kutta's scheme of fourth order, in
//!              inner steps that turn by a hundredth at most
//!   a step under an angular acceleration: half the turn, the kick, the other half
//! ```
//! So the angular momentum is kept to rounding, and the energy of a body that tumbles changes by
//! some 1e-9 a turn. A round body, and one in the plane, keep their spin as they turn.

use super::{Body, Motion};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Largest angle of an inner step (rad).
const ANGLE: f64 = 0.01;

impl Body {
    /// Whether it turns like a body in space that is not round: its spin changes without a torque.
    pub fn tumbles(&self) -> bool {
        !self.is_round() && self.shape().dimension() == 3
    }

    /// Turns it on by `h` (s) under an angular acceleration that lasts (rad/s2), or as prescribed.
    pub fn turn(&mut self, h: f64, angular: &Vector3<f64>) {
        match self.motion {
            Motion::Fixed => {}
            Motion::Free(_) if self.tumbles() => {
                self.turn_freely(0.5 * h);
                self.spin += h * angular;
                self.turn_freely(0.5 * h);
            }
            _ => {
                self.rotate(&(h * (self.spin + 0.5 * h * angular)));
                self.spin += h * angular;
            }
        }
    }

    /// Turns it on by `h` (s) without a torque but what holds it about locked axes.
    pub fn turn_freely(&mut self, h: f64) {
        let Some(freedom) = self.freedom().filter(|_| self.tumbles()) else {
            self.rotate(&(h * self.spin));
            return;
        };
        let momentum = self.inertia().of(&self.spin);
        if freedom.rotation != [true; 3] {
            self.rotate(&(h * self.spin));
            let gained = momentum - self.inertia().of(&self.spin);
            self.spin += self.inertia().inverse_mass(&gained, &freedom);
            return;
        }
        let own = self.shape().inertia_of(self.mass());
        let inverse = own.try_inverse().unwrap_or_else(Matrix3::zeros);
        let steps = (self.spin.norm() * h / ANGLE).ceil().max(1.0);
        let h = h / steps;
        let spin = |q: &Quaternion<f64>| {
            let q = UnitQuaternion::new_normalize(*q);
            q * (inverse * q.inverse_transform_vector(&momentum))
        };
        for _ in 0..steps as usize {
            let start = *self.orientation;
            let rate = |q: &Quaternion<f64>| 0.5 * Quaternion::from_imag(spin(q)) * q;
            let a = rate(&start);
            let b = rate(&(start + 0.5 * h * a));
            let c = rate(&(start + 0.5 * h * b));
            let d = rate(&(start + h * c));
            let end = start + (a + 2.0 * (b + c) + d) * (h / 6.0);
            self.orientation = UnitQuaternion::new_normalize(end);
            self.angle += 0.5 * h * (self.spin.z + spin(&end).z);
            self.spin = spin(&end);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Nearest, Shape, SurfacePoint};
    use crate::particles::{Accelerations, Freedom};
    use mics_shapes::{Lattice, Part, Tile};
    use std::sync::Arc;

    /// A body of which only the inertia counts: its moments for a kilogram (m2).
    #[derive(Debug)]
    struct Inert([f64; 3]);

    impl Shape for Inert {
        fn dimension(&self) -> usize {
            3
        }
        fn radius(&self) -> f64 {
            1.0
        }
        fn volume(&self) -> f64 {
            1.0
        }
        fn inertia(&self) -> Matrix3<f64> {
            Matrix3::from_diagonal(&Vector3::from(self.0))
        }
        fn thickness(&self) -> f64 {
            2.0
        }
        fn nearest(&self, point: &Vector3<f64>) -> Nearest {
            Nearest { distance: point.norm() - 1.0, normal: point.normalize() }
        }
        fn surface(&self, _: f64) -> Vec<SurfacePoint> {
            Vec::new()
        }
        fn extent(&self, _: &Vector3<f64>) -> f64 {
            1.0
        }
        fn tile(&self, _: &Lattice, _: &mut dyn FnMut(&Tile)) {}
        fn parts(&self) -> &[Part] {
            &[]
        }
        fn triangles(&self, _: f64) -> Vec<[Vector3<f64>; 3]> {
            Vec::new()
        }
    }

    /// A racket that spins about its middle axis, very nearly, turns over again and again
    /// (Dzhanibekov), and keeps energy and angular momentum.
    #[test]
    fn free_asymmetric_body_turns_over_and_keeps_energy() {
        for dt in [1e-3, 0.02, 0.3] {
            let mut body = Body::new(Arc::new(Inert([0.3, 0.2, 0.1])), 2.0, 0.0, Vector3::zeros());
            body.motion = Motion::Free(Freedom { translation: [true; 3], rotation: [true; 3] });
            body.spin = Vector3::new(1e-4, 1.0, 1e-4);
            let momentum = body.inertia().of(&body.spin);
            let energy = |body: &Body| 0.5 * body.spin.dot(&body.inertia().of(&body.spin));
            let start = energy(&body);
            let mut over = 0;
            let turns = 60.0;
            let mut last = 1.0;
            let mut rounded = 1e-15;
            for _ in 0..(turns * std::f64::consts::TAU / dt) as usize {
                body.advance(dt, &Accelerations::default(), &[None; 3]);
                let along = (body.orientation() * Vector3::y()).y;
                over += usize::from(along * last < 0.0 && along.abs() > 0.0);
                last = along;
                let gone = (body.inertia().of(&body.spin) - momentum).norm() / momentum.norm();
                // By some roundings, always alike, in each step.
                rounded += 10.0 * f64::EPSILON;
                assert!(gone < rounded, "{gone:e}");
            }
            let changed = (energy(&body) / start - 1.0).abs() / turns;
            println!("dt {dt}: turned over {over} times, energy changed by {changed:.1e} a turn");
            assert!(over >= 4 && changed < 1e-8, "{over} {changed:e}");
        }
    }

    /// A torque-free symmetric top precesses as in closed form: its axis about the angular momentum
    /// at `|L|/I_1`.
    #[test]
    fn free_symmetric_body_precesses_at_its_rate() {
        let mut body = Body::new(Arc::new(Inert([0.2, 0.2, 0.3])), 1.0, 0.0, Vector3::zeros());
        body.motion = Motion::Free(Freedom { translation: [true; 3], rotation: [true; 3] });
        body.spin = Vector3::new(0.4, 0.0, 1.0);
        let momentum = body.inertia().of(&body.spin);
        let period = std::f64::consts::TAU * 0.2 / momentum.norm();
        let axis = body.orientation() * Vector3::z();
        for _ in 0..100 {
            body.advance(0.01 * period, &Accelerations::default(), &[None; 3]);
        }
        let end = body.orientation() * Vector3::z();
        assert!((end - axis).norm() < 1e-8, "{:e}", (end - axis).norm());
    }
}
