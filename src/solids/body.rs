//! A body: its shape, its state and what moves it.

use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::PI;

/// The shape of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A disc (2D), of unit depth: its mass and inertia are those of a metre of cylinder.
    Disc,
    /// A sphere (3D).
    Sphere,
}

/// What moves a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Fluid, gravity and contacts move it.
    Free(Freedom),
    /// It rests.
    Fixed,
    /// It keeps its velocity and spin, whatever the forces.
    Prescribed,
}

/// The directions in which a free body can move; it keeps its velocity along the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Freedom {
    /// Along x, y, z.
    pub translation: [bool; 3],
    /// About x, y, z.
    pub rotation: [bool; 3],
}

impl Freedom {
    /// The part of a vector along the free directions.
    pub fn along(&self, v: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|a, _| if self.translation[a] { v[a] } else { 0.0 })
    }

    /// The part of an axial vector about the free directions.
    pub fn about(&self, v: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|a, _| if self.rotation[a] { v[a] } else { 0.0 })
    }
}

/// A disc or sphere.
#[derive(Clone, Debug)]
pub struct Body {
    /// Disc or sphere.
    pub shape: Shape,
    /// Radius (m).
    pub radius: f64,
    /// Density (kg/m3).
    pub density: f64,
    /// Viscosity that its inside lends to the mixture (Pa s).
    pub viscosity: f64,
    /// Centre (m); along a periodic axis it stays within the domain.
    pub centre: Vector3<f64>,
    /// Velocity of the centre (m/s).
    pub velocity: Vector3<f64>,
    /// Angle turned about z since time 0 (rad).
    pub angle: f64,
    /// Orientation, from the state at time 0.
    pub orientation: UnitQuaternion<f64>,
    /// Angular velocity (rad/s).
    pub spin: Vector3<f64>,
    /// What moves it.
    pub motion: Motion,
}

impl Body {
    /// Volume (m3; m2 of a disc, per metre of depth).
    pub fn volume(&self) -> f64 {
        match self.shape {
            Shape::Disc => PI * self.radius.powi(2),
            Shape::Sphere => 4.0 / 3.0 * PI * self.radius.powi(3),
        }
    }

    /// Mass (kg; per metre of depth in 2D).
    pub fn mass(&self) -> f64 {
        self.density * self.volume()
    }

    /// Moment of inertia about the centre (kg m2), the same about every axis that the body turns about.
    pub fn inertia(&self) -> f64 {
        let factor = if self.shape == Shape::Disc { 0.5 } else { 0.4 };
        factor * self.mass() * self.radius.powi(2)
    }

    /// Velocity of the body's point at `arm` from its centre (m/s): the rigid motion of eq. (27).
    pub fn velocity_at(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.spin.cross(arm)
    }

    /// The directions in which forces move it, where they do.
    pub fn freedom(&self) -> Option<Freedom> {
        if let Motion::Free(freedom) = self.motion { Some(freedom) } else { None }
    }

    /// Whether it changes place, or can.
    pub fn moves(&self) -> bool {
        self.freedom().is_some() || (self.motion == Motion::Prescribed && self.velocity != Vector3::zeros())
    }

    /// Moves the body on by `dt` (s) at its velocity and spin; `periods` are the lengths of the periodic axes (m).
    pub fn advance(&mut self, dt: f64, periods: &[Option<f64>; 3]) {
        self.centre += self.velocity * dt;
        self.angle += self.spin.z * dt;
        self.orientation = UnitQuaternion::from_scaled_axis(self.spin * dt) * self.orientation;
        for (x, period) in self.centre.iter_mut().zip(periods) {
            if let Some(length) = period {
                *x = x.rem_euclid(*length);
            }
        }
    }

    /// Fastest point of the body (m/s).
    pub fn top_speed(&self) -> f64 {
        self.velocity.norm() + self.spin.norm() * self.radius
    }
}

/// From one place to another (m) by the shortest way across the periods.
pub fn nearest_image(from: &Vector3<f64>, to: &Vector3<f64>, periods: &[Option<f64>; 3]) -> Vector3<f64> {
    let mut apart = to - from;
    for (d, period) in apart.iter_mut().zip(periods) {
        *d -= period.map_or(0.0, |l| l * (*d / l).round());
    }
    apart
}
