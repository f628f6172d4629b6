//! A body: its size, its state and what moves it.

use nalgebra::Vector3;

/// What moves a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// It rests.
    Fixed,
    /// It keeps its velocity and spin, whatever the forces.
    Prescribed,
}

/// A disc or sphere.
#[derive(Clone, Debug)]
pub struct Body {
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
    /// Angular velocity (rad/s).
    pub spin: Vector3<f64>,
    /// What moves it.
    pub motion: Motion,
}

impl Body {
    /// Velocity of the body's point at `arm` from its centre (m/s): the rigid motion of eq. (27).
    pub fn velocity_at(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.spin.cross(arm)
    }

    /// Whether it changes place.
    pub fn moves(&self) -> bool {
        self.motion != Motion::Fixed && self.velocity != Vector3::zeros()
    }

    /// Moves the body on by `dt` (s); `periods` are the lengths of the periodic axes (m).
    pub fn advance(&mut self, dt: f64, periods: &[Option<f64>]) {
        self.centre += self.velocity * dt;
        self.angle += self.spin.z * dt;
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
