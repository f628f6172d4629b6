//! The motion of a body within a step, and the resistance of the wall shear to its changes.

use super::profile;
use crate::domain::Domain;
use crate::numerics::SLOPE_IMAGE_POINT;
use crate::particles::{Body, Inertia, Load, RigidVelocity};
use crate::state::Exchange;
use nalgebra::{Matrix3, Vector3};

/// The motion of a body within a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct BodyMotion {
    /// Its velocity at the start of the step, and that expected at its end.
    pub start: RigidVelocity,
    pub expected: RigidVelocity,
    /// Angular momentum at the start of the step (kg m2/s).
    pub angular_momentum: Vector3<f64>,
    /// Effective mass of a free body (kg): its own, and the wall shear's resistance over a step. It
    /// acts along free directions only.
    pub effective_mass: f64,
    /// Inverse effective moments of inertia of a body that is not round (1/(kg m2)), with that
    /// resistance likewise.
    pub inverse_inertia: Matrix3<f64>,
    /// The volume that faces normal to each axis show of it (m3): where bodies touch, less than its
    /// own.
    pub displaced_volume: Vector3<f64>,
    /// Load by pressure of the step so far; its torque on a body that is not round.
    pub pressure: Load,
    /// Load by wall shear.
    pub shear: Load,
    /// Force defect: what the fluid lost over the step less pressure and wall shear; and the force
    /// that the body has felt (N).
    pub force_defect: Vector3<f64>,
    pub force: Vector3<f64>,
    /// Angular momentum that the fluid lost to the body in the step (kg m2/s).
    pub angular_momentum_lost: Vector3<f64>,
    /// Its surface: area (m2; m in 2D), and moments of inertia in its own axes as a shell of a
    /// kilogram per area.
    pub surface_moments: (f64, Matrix3<f64>),
}

impl BodyMotion {
    /// Torque on it by the fluid over the step (N m).
    pub fn torque(&self) -> Vector3<f64> {
        self.shear.torque + self.pressure.torque
    }

    /// Exchange of the body with the fluid in the step, once what it has felt is known.
    pub fn exchange(&self) -> Exchange {
        Exchange {
            momentum: self.force,
            momentum_torque: self.torque(),
            remainder: self.force - self.pressure.force - self.shear.force,
            pressure: self.pressure.force,
            viscous: self.shear.force,
            literal_torque: self.torque(),
            ..Exchange::default()
        }
    }
}

/// Resistance of the wall shear of a fluid to changes of a body's motion within a step.
pub struct ShearUnit {
    /// Viscosity over the spacing (Pa s/m), and that spacing (m).
    unit: f64,
    h: f64,
    /// Sum of the weights of the slope at the surface: that of a velocity which is 1 at all image
    /// points (over a spacing).
    weights: f64,
}

impl ShearUnit {
    /// Resistance of the fluid of a domain, where image points count in spacings of `h` (m).
    pub fn new<const D: usize>(domain: &Domain<D>, h: f64) -> ShearUnit {
        let weights = profile::slope(SLOPE_IMAGE_POINT).iter().sum();
        ShearUnit { unit: domain.fluid.viscosity / h, h, weights }
    }

    /// Resistance to a change of a body's velocity (N s/m) and spin (N m s), by its surface's area
    /// and moments: to the velocity by the profile's first image point, to the spin by the slope of
    /// the wall shear itself.
    pub fn resistance(&self, body: &Body, surface_moments: &(f64, Matrix3<f64>)) -> (f64, Inertia) {
        let (area, moments) = surface_moments;
        let slope = self.unit * self.weights;
        let drag = self.unit * area;
        if body.is_round() {
            return (drag, Inertia::Same(slope * moments[(2, 2)]));
        }
        let turn = body.orientation();
        (drag, Inertia::Tensor(slope * (turn * moments * turn.transpose())))
    }

    /// Least resistance of a free body (N s/m) where the first image point gives `drag`, so that
    /// its velocity does not swing from step to step: the flow responds to a change of it within
    /// the step by about
    ///
    /// ```text
    ///   c = k drag (sum of the slope's weights + h/R)
    ///              k = 1.5 for a sphere, 2 for a disc: with the pressure that viscosity makes
    /// ```
    /// of which the body expects `drag`; the rest is felt a step late, and may be what its mass and
    /// the fluid's resist at most. It is more than `drag` for bodies of few cells across, in steps
    /// of several stages alone, and for light ones.
    pub fn least_drag(&self, body: &Body, drag: f64, density: f64, dt: f64) -> f64 {
        let with_pressure = if body.shape().dimension() == 2 { 2.0 } else { 1.5 };
        let response = with_pressure * drag * (self.weights + self.h / body.radius());
        0.5 * (response - (body.mass() + body.added_mass(density)) / dt)
    }

    /// Moment of inertia that turns with a body over a step `dt` (s): its own, and that of the
    /// fluid beside it by that resistance (kg m2).
    pub fn turning(&self, body: &Body, surface_moments: &(f64, Matrix3<f64>), dt: f64) -> Inertia {
        body.inertia().plus(dt, &self.resistance(body, surface_moments).1)
    }
}

/// The part of a free body's response to torque over the step `dt` (s) that is inertia, and not the
/// wall shear's resistance `turn` (N m s), by axis. The torque is centred in time, and the spin
/// carried on, as far as this goes: of a body of no inertia the spin is that of the flow around it,
/// and what it was before only feeds an oscillation (nothing but added mass resists pressure, but
/// nothing adds inertia to a disc's spin).
pub fn inertial_share(body: &Body, turn: &Inertia, dt: f64) -> Vector3<f64> {
    let own = body.inertia();
    let resisted = body.inertia().plus(dt, turn);
    Vector3::from_fn(|a, _| body.freedom().map_or(1.0, |_| own.about(a) / resisted.about(a)))
}
