//! Response of bodies to forces and torques in a substep.

use super::Impulse;
use crate::geometry::Orientation;
use crate::particles::{Accelerations, Body, Inertia};
use nalgebra::{Matrix3, Vector3};

/// Response of a body to forces: zero along the axes in which it is not free.
#[derive(Clone, Copy, Debug)]
pub(super) struct InverseMass {
    /// Inverse mass of a free body, whatever its axes (1/kg).
    pub(super) whole: f64,
    /// Inverse mass along each axis (1/kg).
    pub(super) mass: Vector3<f64>,
    /// Inverse moments of inertia (1/(kg m2)).
    pub(super) inertia: InverseInertia,
    pub(super) accelerations: Accelerations,
}

/// Inverse moments of inertia of a body (1/(kg m2)), by which its spin responds to an angular
/// impulse: a symmetric tensor in the axes of the box.
#[derive(Clone, Copy, Debug)]
pub(super) struct InverseInertia {
    diagonal: Vector3<f64>,
    /// Its entries yz, zx and xy: zero of a body that does not tumble.
    beside: Vector3<f64>,
}

impl InverseInertia {
    /// Zero: nothing turns the body.
    const NONE: InverseInertia = InverseInertia {
        diagonal: Vector3::new(0.0, 0.0, 0.0),
        beside: Vector3::new(0.0, 0.0, 0.0),
    };

    /// The inverse moments of inertia from a symmetric tensor of them (1/(kg m2)).
    fn new(tensor: &Matrix3<f64>) -> InverseInertia {
        let beside = Vector3::new(tensor[(1, 2)], tensor[(2, 0)], tensor[(0, 1)]);
        InverseInertia { diagonal: tensor.diagonal(), beside }
    }

    /// Change of the spin (rad/s) by an angular impulse (N m s).
    #[inline]
    pub(super) fn of(&self, impulse: &Vector3<f64>) -> Vector3<f64> {
        let j = impulse;
        let [yz, zx, xy] = <[f64; 3]>::from(self.beside);
        let beside = Vector3::new(xy * j.y + zx * j.z, xy * j.x + yz * j.z, zx * j.x + yz * j.y);
        self.diagonal.component_mul(j) + beside
    }

    /// The largest about an axis of the box (1/(kg m2)).
    #[inline]
    pub(super) fn max(&self) -> f64 {
        self.diagonal.max()
    }
}

pub(super) const RIGID: InverseMass = InverseMass {
    whole: 0.0,
    mass: Vector3::new(0.0, 0.0, 0.0),
    inertia: InverseInertia::NONE,
    accelerations: Accelerations {
        acceleration: Vector3::new(0.0, 0.0, 0.0),
        angular: Vector3::new(0.0, 0.0, 0.0),
    },
};

impl InverseMass {
    #[inline]
    pub(super) fn of(
        body: &Body,
        accelerations: &Accelerations,
        mass: f64,
        inertia: &Inertia,
    ) -> InverseMass {
        let Some(freedom) = body.freedom() else { return RIGID };
        let ones = |free: [bool; 3]| Vector3::from(free.map(|f| if f { 1.0 } else { 0.0 }));
        let along = ones(freedom.translation);
        let about = ones(freedom.rotation);
        let inverse = match inertia {
            Inertia::Tensor(_) if body.tumbles() => InverseInertia::new(&inertia.inverse(&freedom)),
            Inertia::Tensor(_) => InverseInertia {
                diagonal: inertia.inverse(&freedom).diagonal(),
                ..InverseInertia::NONE
            },
            Inertia::Same(_) => InverseInertia {
                diagonal: inertia.spin_change(&Vector3::repeat(1.0), &freedom),
                ..InverseInertia::NONE
            },
        };
        InverseMass {
            whole: 1.0 / mass,
            mass: along / mass,
            inertia: inverse,
            accelerations: Accelerations {
                acceleration: accelerations.acceleration.component_mul(&along),
                angular: accelerations.angular.component_mul(&about),
            },
        }
    }

    /// Turns the inverse moments of inertia of a body that tumbles to its orientation, from the
    /// moments in its own axes (kg m2).
    pub(super) fn turn(&mut self, body: &Body, own: &Matrix3<f64>, orientation: &Orientation) {
        if let (true, Some(freedom)) = (body.tumbles(), body.freedom()) {
            let tensor = orientation.matrix() * own * orientation.matrix().transpose();
            self.inertia = InverseInertia::new(&Inertia::Tensor(tensor).inverse(&freedom));
        }
    }

    /// Accelerations by fluid and gravity, and by a force and a torque (N, N m).
    pub(super) fn accelerations_under(&self, load: &Impulse) -> Accelerations {
        let Accelerations { acceleration, angular } = self.accelerations;
        Accelerations {
            acceleration: acceleration + self.mass.component_mul(&load.linear),
            angular: angular + self.inertia.of(&load.angular),
        }
    }

    /// `J.M^-1 J` of an impulse (J).
    pub(super) fn energy(&self, impulse: &Impulse) -> f64 {
        let Impulse { linear, angular } = impulse;
        self.mass.dot(&linear.component_mul(linear)) + angular.dot(&self.inertia.of(angular))
    }

    /// Multiplies the inverse mass by a factor.
    pub(super) fn scale(&mut self, factor: f64) {
        self.whole *= factor;
        self.mass *= factor;
    }
}
