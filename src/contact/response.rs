//! How bodies respond to forces and torques in a substep.

use super::Impulse;
use crate::geometry::Orientation;
use crate::particles::{Accelerations, Body, Inertia};
use nalgebra::{Matrix3, Vector3};

/// How a body responds to forces: zero along the axes where it does not.
#[derive(Clone, Copy, Debug)]
pub(super) struct InverseMass {
    /// Inverse mass of a free body, whatever its axes (1/kg).
    pub(super) whole: f64,
    /// 1/kg.
    pub(super) mass: Vector3<f64>,
    /// 1/(kg m2).
    pub(super) inertia: InverseInertia,
    pub(super) accelerations: Accelerations,
}

/// How a body's spin responds to an angular impulse (1/(kg m2)): a symmetric tensor in the axes of
/// the box.
#[derive(Clone, Copy, Debug)]
pub(super) struct InverseInertia {
    diagonal: Vector3<f64>,
    /// Its entries yz, zx and xy: zero of a body that does not tumble.
    beside: Vector3<f64>,
}

impl InverseInertia {
    /// None: nothing turns it.
    const NONE: InverseInertia = InverseInertia {
        diagonal: Vector3::new(0.0, 0.0, 0.0),
        beside: Vector3::new(0.0, 0.0, 0.0),
    };

    /// That of a symmetric tensor.
    fn new(tensor: &Matrix3<f64>) -> InverseInertia {
        let beside = Vector3::new(tensor[(1, 2)], tensor[(2, 0)], tensor[(0, 1)]);
        InverseInertia { diagonal: tensor.diagonal(), beside }
    }

    /// What an angular impulse (N m s) changes of the spin (rad/s).
    #[inline]
    pub(super) fn of(&self, impulse: &Vector3<f64>) -> Vector3<f64> {
        let j = impulse;
        let [yz, zx, xy] = <[f64; 3]>::from(self.beside);
        let beside = Vector3::new(xy * j.y + zx * j.z, xy * j.x + yz * j.z, zx * j.x + yz * j.y);
        self.diagonal.component_mul(j) + beside
    }

    /// The largest about an axis.
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
                diagonal: inertia.inverse_mass(&Vector3::repeat(1.0), &freedom),
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

    /// Takes how a body that tumbles is turned now, by its moments of inertia in its own axes (kg
    /// m2).
    pub(super) fn turn(&mut self, body: &Body, own: &Matrix3<f64>, orientation: &Orientation) {
        if let (true, Some(freedom)) = (body.tumbles(), body.freedom()) {
            let tensor = orientation.matrix() * own * orientation.matrix().transpose();
            self.inertia = InverseInertia::new(&Inertia::Tensor(tensor).inverse(&freedom));
        }
    }

    /// The accelerations that last, and by a force and a torque (N, N m).
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
