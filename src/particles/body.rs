//! A body: its shape, its state and what moves it, and how it turns on by itself.
//!
//! ```text
//!   L = I w  stays in the axes of the box          I = R I_0 R^T, R the orientation
//!   dR/dt = w x R,  w = I^-1 L                    by Runge-Kutta's scheme of fourth order, in
//!              inner steps that turn by a hundredth at most
//!   a step under an angular acceleration: half the turn, the kick, the other half
//! ```
//! The angular momentum is kept to rounding by this, and the energy of a body that tumbles changes
//! by some 1e-9 a turn. A round body, and one in the plane, keep their spin as they turn.

use super::{Inertia, RigidVelocity};
use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::geometry::{Orientation, Placed, Pose, Shape};
use mics_shapes::Part;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Largest angle of an inner step of a body that turns (rad).
const ANGLE: f64 = 0.01;

/// Motion of a body: by forces, none, or prescribed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Fluid, gravity and contacts move it.
    Free(Freedom),
    /// It rests.
    Fixed,
    /// It keeps its velocity and spin, whatever the forces, or swings to and fro at this spin.
    Prescribed(Option<Oscillation>),
}

/// A path to and fro, exact at every time: `x = x0 + V t + A sin(2 pi f t)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// Centre at time 0, x0 (m).
    pub origin: Vector3<f64>,
    /// Mean velocity, V (m/s).
    pub drift: Vector3<f64>,
    /// Amplitude along each axis, A (m).
    pub amplitude: Vector3<f64>,
    /// Frequency, f (1/s).
    pub frequency: f64,
    /// Time, t (s).
    pub time: f64,
}

impl Oscillation {
    /// Centre (m), not brought back across periods.
    pub fn centre(&self) -> Vector3<f64> {
        self.origin
            + self.drift * self.time
            + self.amplitude * (TAU * self.frequency * self.time).sin()
    }

    /// Velocity of the centre (m/s).
    pub fn velocity(&self) -> Vector3<f64> {
        let rate = TAU * self.frequency;
        self.drift + self.amplitude * (rate * (rate * self.time).cos())
    }

    /// Acceleration of the centre (m/s2).
    pub fn acceleration(&self) -> Vector3<f64> {
        let rate = TAU * self.frequency;
        -self.amplitude * (rate * rate * (rate * self.time).sin())
    }

    /// A speed that its centre never exceeds (m/s).
    pub fn top_speed(&self) -> f64 {
        self.drift.norm() + TAU * self.frequency * self.amplitude.norm()
    }
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

/// A shape, with its radius and roundness at hand for searches.
#[derive(Clone, Debug)]
struct ShapeAtHand {
    shape: Arc<dyn Shape>,
    radius: f64,
    round: bool,
}

/// A rigid body of one density.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its number in the case, which lasts when others leave.
    pub id: usize,
    /// Name of an obstacle in messages.
    pub name: Option<Arc<str>>,
    shape: ShapeAtHand,
    /// Density (kg/m3).
    pub density: f64,
    /// Viscosity that its inside lends to the mixture (Pa s).
    pub viscosity: f64,
    /// Centre (m); along a periodic axis it stays within the domain.
    pub centre: Vector3<f64>,
    /// Whole periods that periodic boundaries have taken from its centre so far (m).
    pub crossed: Vector3<f64>,
    /// Velocity of the centre (m/s).
    pub velocity: Vector3<f64>,
    /// Angle about z (rad), in 2D that of its own axes, all turns counted.
    pub angle: f64,
    /// Rotation from its own axes to those of the box.
    pub orientation: UnitQuaternion<f64>,
    /// Angular velocity (rad/s).
    pub spin: Vector3<f64>,
    /// Its motion: free, fixed or prescribed.
    pub motion: Motion,
}

/// Whether none of them ever moves.
pub fn all_fixed(bodies: &[Body]) -> bool {
    bodies.iter().all(|body| body.motion == Motion::Fixed)
}

/// The places of bodies in a list, by their numbers.
pub fn by_number(bodies: &[Body]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..bodies.len()).collect();
    places.sort_unstable_by_key(|k| bodies[*k].id);
    places
}

impl Body {
    /// A body at rest that is held, with its own axes along those of the box: of this density
    /// (kg/m3), lending its viscosity (Pa s) to a mixture, with its centre there (m).
    pub fn new(shape: Arc<dyn Shape>, density: f64, viscosity: f64, centre: Vector3<f64>) -> Body {
        Body {
            id: 0,
            name: None,
            shape: ShapeAtHand { radius: shape.radius(), round: shape.is_round(), shape },
            density,
            viscosity,
            centre,
            crossed: Vector3::zeros(),
            velocity: Vector3::zeros(),
            angle: 0.0,
            orientation: UnitQuaternion::identity(),
            spin: Vector3::zeros(),
            motion: Motion::Fixed,
        }
    }

    /// Its name in messages: that of a particle is its number.
    pub fn called(&self) -> String {
        let number = || format!("particle {}", self.id);
        self.name.as_deref().map_or_else(number, str::to_owned)
    }

    /// Its shape.
    pub fn shape(&self) -> &dyn Shape {
        &*self.shape.shape
    }

    /// Its velocity and its spin.
    pub fn rigid_velocity(&self) -> RigidVelocity {
        RigidVelocity { velocity: self.velocity, spin: self.spin }
    }

    /// Radius of the sphere about its centre that holds all of it (m).
    pub fn radius(&self) -> f64 {
        self.shape.radius
    }

    /// Whether it is round: its orientation makes no difference.
    #[inline]
    pub fn is_round(&self) -> bool {
        self.shape.round
    }

    /// Its reach from its centre along the axes of the box (m).
    pub fn reach(&self) -> Vector3<f64> {
        self.shape().turned(&self.orientation()).bounds()
    }

    /// Rotation from its own axes to those of the box; none for a round body, which does not show
    /// it.
    pub fn orientation(&self) -> Orientation {
        if self.shape.round {
            return Orientation::identity();
        }
        // The length drifts from 1 by many small rotations.
        UnitQuaternion::new_normalize(*self.orientation).to_rotation_matrix()
    }

    /// The signed distance (m) of the point at `arm` (m) from its surface.
    pub fn distance(&self, arm: &Vector3<f64>) -> f64 {
        self.shape().turned(&self.orientation()).distance(arm)
    }

    /// Its centre (m) and its orientation.
    pub fn pose(&self) -> Pose {
        Pose { place: self.centre, orientation: self.orientation() }
    }

    /// Its shape at its place.
    pub fn placed(&self) -> Placed<'_> {
        Placed { shape: self.shape(), pose: self.pose() }
    }

    /// Added mass of a round body far from everything (kg) in a fluid of a density (kg/m3): the
    /// fluid of its own volume in 2D, of half of it in 3D (potential flow).
    pub fn added_mass(&self, density: f64) -> f64 {
        let part = if self.shape().dimension() == 2 { 1.0 } else { 0.5 };
        part * density * self.volume()
    }

    /// Volume (m3; m2 in 2D, per metre of depth).
    pub fn volume(&self) -> f64 {
        self.shape().volume()
    }

    /// Mass (kg; per metre of depth in 2D).
    pub fn mass(&self) -> f64 {
        self.density * self.volume()
    }

    /// Moments of inertia about the centre (kg m2).
    pub fn inertia(&self) -> Inertia {
        let own = self.shape().inertia_of(self.mass());
        if self.shape.round {
            return Inertia::Same(own[(2, 2)]);
        }
        let orientation = self.orientation();
        Inertia::Tensor(orientation * own * orientation.transpose())
    }

    /// Velocity of the body's point at `arm` from its centre (m/s): the rigid motion of eq. (27).
    pub fn velocity_at(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.rigid_velocity().at(arm)
    }

    /// Whether its place, velocity and spin are finite numbers.
    pub fn is_finite(&self) -> bool {
        self.centre.iter().chain(&self.velocity).chain(&self.spin).all(|x| x.is_finite())
    }

    /// Whether it is a wall of any shape, which knows the domain that it stands in.
    pub fn is_obstacle(&self) -> bool {
        self.shape().is_obstacle()
    }

    /// The directions in which forces move it, where they do.
    pub fn freedom(&self) -> Option<Freedom> {
        if let Motion::Free(freedom) = self.motion { Some(freedom) } else { None }
    }

    /// Whether what it fills can change: by its place or, unless round, by how it is turned.
    pub fn moves(&self) -> bool {
        let turns = || self.spin != Vector3::zeros() && !self.shape.round;
        match self.motion {
            Motion::Free(_) | Motion::Prescribed(Some(_)) => true,
            Motion::Prescribed(None) => self.velocity != Vector3::zeros() || turns(),
            Motion::Fixed => false,
        }
    }

    /// Moves the body by `dt` (s) under lasting accelerations, or as prescribed; `periods` (m).
    pub fn advance(&mut self, dt: f64, accelerations: &Accelerations, periods: &[Option<f64>; 3]) {
        self.translate(dt, accelerations, periods);
        self.turn(dt, &accelerations.angular);
    }

    /// As [`Body::advance`], but does not turn a round body: returns its rotation (rad) for
    /// [`Body::rotate`], at once or summed up, and zero for other bodies.
    #[inline]
    pub fn shift(
        &mut self,
        dt: f64,
        accelerations: &Accelerations,
        periods: &[Option<f64>; 3],
    ) -> Vector3<f64> {
        if self.motion == Motion::Fixed {
            return Vector3::zeros();
        }
        self.translate(dt, accelerations, periods);
        if !self.shape.round {
            self.turn(dt, &accelerations.angular);
            return Vector3::zeros();
        }
        let turned = (self.spin + 0.5 * dt * accelerations.angular) * dt;
        self.spin += dt * accelerations.angular;
        turned
    }

    /// Moves its centre on by `dt` (s), and changes its velocity.
    #[inline]
    fn translate(&mut self, dt: f64, accelerations: &Accelerations, periods: &[Option<f64>; 3]) {
        match &mut self.motion {
            Motion::Fixed => return,
            Motion::Prescribed(Some(path)) => {
                path.time += dt;
                self.crossed = Vector3::zeros();
                self.centre = path.centre();
                self.velocity = path.velocity();
            }
            Motion::Free(_) | Motion::Prescribed(None) => {
                self.centre += (self.velocity + 0.5 * dt * accelerations.acceleration) * dt;
                self.velocity += dt * accelerations.acceleration;
            }
        }
        self.displace(&Vector3::zeros(), periods);
    }

    /// Displaces it by a way (m), back into the box along the axes that are periodic.
    pub fn displace(&mut self, way: &Vector3<f64>, periods: &[Option<f64>; 3]) {
        self.centre += way;
        for ((x, crossed), period) in self.centre.iter_mut().zip(&mut self.crossed).zip(periods) {
            if let Some(length) = period.filter(|length| !(0.0..*length).contains(x)) {
                *crossed += (*x / length).floor() * length;
                *x = x.rem_euclid(length);
            }
        }
    }

    /// Turns it by a vector (rad).
    pub fn rotate(&mut self, turned: &Vector3<f64>) {
        self.angle += turned.z;
        self.orientation = UnitQuaternion::from_scaled_axis(*turned) * self.orientation;
    }

    /// Its centre (m) where it would be had it not been brought back across periodic boundaries.
    pub fn path(&self) -> Vector3<f64> {
        self.centre + self.crossed
    }

    /// Speed of the centre (m/s), the largest of a body that swings.
    pub fn speed(&self) -> f64 {
        if let Motion::Prescribed(Some(path)) = &self.motion {
            path.top_speed()
        } else {
            self.velocity.norm()
        }
    }

    /// Its convex parts, which contacts see; none of a round body.
    pub fn parts(&self) -> &[Part] {
        self.shape().parts()
    }

    /// Fastest point of the body (m/s).
    pub fn top_speed(&self) -> f64 {
        self.speed() + self.spin.norm() * self.shape.radius
    }

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
            self.spin += self.inertia().spin_change(&gained, &freedom);
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

/// Accelerations of a body by fluid and gravity, frozen over a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Accelerations {
    /// Acceleration (m/s2).
    pub acceleration: Vector3<f64>,
    /// Angular acceleration (rad/s2).
    pub angular: Vector3<f64>,
}

impl Checkpointed for Accelerations {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Accelerations { acceleration, angular } = self;
        archive.serialize([acceleration, angular])
    }
}

impl Checkpointed for Body {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Body {
            id: _,
            name: _,
            centre,
            crossed,
            velocity,
            angle,
            orientation,
            spin,
            motion,
            shape: _,
            density: _,
            viscosity: _,
        } = self;
        archive.serialize([centre, crossed, velocity, angle, orientation, spin])?;
        match motion {
            Motion::Prescribed(Some(path)) => path.time.serialize(archive),
            Motion::Free(_) | Motion::Fixed | Motion::Prescribed(None) => Ok(()),
        }
    }
}

/// From one place to another (m) by the shortest way across the periods.
pub fn nearest_image(
    from: &Vector3<f64>,
    to: &Vector3<f64>,
    periods: &[Option<f64>; 3],
) -> Vector3<f64> {
    let mut apart = to - from;
    for (d, period) in apart.iter_mut().zip(periods) {
        *d -= period.map_or(0.0, |l| l * (*d / l).round());
    }
    apart
}

#[cfg(test)]
mod tests;
