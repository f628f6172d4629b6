//! The motion of a body within a step, and what the wall shear takes back of its changes.

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
    /// What a force changes (kg): the mass with the wall shear's resistance over a step; infinite
    /// along held directions.
    pub inertia: f64,
    /// What a torque's impulse changes of the spin of a body that is not round (1/(kg m2)), with
    /// that resistance likewise.
    pub turns: Matrix3<f64>,
    /// The volume that faces normal to each axis show of it (m3): where bodies touch, less than its
    /// own.
    pub displaced: Vector3<f64>,
    /// Load by pressure of the step so far; its torque on a body that is not round.
    pub pressure: Load,
    /// Load by wall shear.
    pub shear: Load,
    /// What pressure and wall shear miss of what the fluid lost in the step, and what the body has
    /// felt (N).
    pub force_defect: Vector3<f64>,
    pub used: Vector3<f64>,
    /// Angular momentum that the fluid lost to the body in the step (kg m2/s).
    pub spin_lost: Vector3<f64>,
    /// Its surface: area (m2; m in 2D), and moments of inertia in its own axes as a shell of a
    /// kilogram per area.
    pub surface_moments: (f64, Matrix3<f64>),
}

impl BodyMotion {
    /// Torque on it by the fluid over the step (N m).
    pub fn torque(&self) -> Vector3<f64> {
        self.shear.torque + self.pressure.torque
    }

    /// What it and the fluid exchanged in the step, once what it has felt is known.
    pub fn exchange(&self) -> Exchange {
        Exchange {
            momentum: self.used,
            momentum_torque: self.torque(),
            convective: self.used - self.pressure.force - self.shear.force,
            pressure: self.pressure.force,
            viscous: self.shear.force,
            literal_torque: self.torque(),
            ..Exchange::default()
        }
    }
}

/// What the wall shear of a fluid takes back of the changes of a body's motion within a step.
pub struct ShearUnit {
    /// Viscosity over the spacing (Pa s/m), and that spacing (m).
    unit: f64,
    h: f64,
    /// Sum of the weights of the slope at the surface: that of a velocity which is 1 at all image
    /// points (over a spacing).
    weights: f64,
}

impl ShearUnit {
    /// That of the fluid of a domain, where image points count in spacings of `h` (m).
    pub fn new<const D: usize>(domain: &Domain<D>, h: f64) -> ShearUnit {
        let weights = profile::slope(SLOPE_IMAGE_POINT).iter().sum();
        ShearUnit { unit: domain.fluid.viscosity / h, h, weights }
    }

    /// What it takes back of a change of a body's velocity (N s/m) and spin (N m s), by its
    /// surface's area and moments: of the velocity by the profile's first image point, of the spin
    /// by the slope of the wall shear itself.
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

    /// What a free body has to resist at least (N s/m) where the first image point gives `drag`,
    /// that its velocity does not swing from step to step: the flow responds to a change of it
    /// within the step by about
    ///
    /// ```text
    ///   c = k drag (sum of the slope's weights + h/R)
    ///              k = 1.5 for a sphere, 2 for a disc: with the pressure that viscosity makes
    /// ```
    /// of which the body expects `drag`; the rest is felt a step late, and may be what its mass and
    /// the fluid's resist at most. So it is of few cells across in steps of several stages alone,
    /// and of light ones.
    pub fn least_drag(&self, body: &Body, drag: f64, density: f64, dt: f64) -> f64 {
        let with_pressure = if body.shape().dimension() == 2 { 2.0 } else { 1.5 };
        let inverse_mass = with_pressure * drag * (self.weights + self.h / body.radius());
        0.5 * (inverse_mass - (body.mass() + body.added_mass(density)) / dt)
    }

    /// What turns with a body over a step `dt` (s): itself, and the fluid beside it by that
    /// resistance (kg m2).
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
