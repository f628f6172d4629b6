//! How bodies go to their new place, and what forces make of their velocity there (formulas in the
//! parent).

use super::load::surface_forces;
use super::profile;
use super::sums::SurfaceForces;
use super::{Sharp, history};
use crate::Result;
use crate::clock::Stage;
use crate::contact::Impulse;
use crate::domain::Domain;
use crate::method::collision::refuse_collisions;
use crate::numerics::SLOPE_IMAGE_POINT;
use crate::particles::{Accelerations, Body, Inertia, Load, RigidVelocity};
use crate::petsc::LogStage;
use crate::state::{BodyHistory, Exchange, State};
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

impl<const D: usize> Sharp<D> {
    /// Moves the bodies on by `dt` (s), as the last step lets expect and through contacts, and
    /// opens the faces there. Collective.
    pub(super) fn predict_positions(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Bodies)?;
        for (motion, body) in self.motions.iter_mut().zip(&s.bodies) {
            motion.start = body.rigid_velocity();
            motion.angular_momentum = body.inertia().of(&body.spin);
        }
        self.recall_accelerations(domain, s, dt)?;
        s.substeps = 0;
        if s.bodies.iter().any(Body::moves) {
            self.cut.depart(&s.bodies);
            self.advance_bodies(domain, s, dt)?;
            domain.clock.lap(Stage::Contacts);
            refuse_collisions(domain, &s.bodies, self.contacts.is_some())?;
            for (motion, body) in self.motions.iter_mut().zip(&s.bodies) {
                motion.expected = body.rigid_velocity();
            }
            self.cut.arrive(domain, &s.bodies, dt);
            self.cut.cover_boundaries(domain);
        }
        if self.set_ghost_layers(domain, &s.bodies) {
            domain.boundaries.fill_velocity(&mut s.u)?;
        }
        domain.clock.lap(Stage::Particles);
        Ok(())
    }

    /// Takes the accelerations that the last step lets expect.
    fn recall_accelerations(
        &mut self,
        domain: &Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<()> {
        let unit = (domain.fluid.viscosity / self.cut.h, slope_weights());
        let histories = &history(&mut s.surfaces)?.bodies;
        for (k, (accelerations, history)) in
            self.work.accelerations.iter_mut().zip(histories).enumerate()
        {
            *accelerations = history.accelerations;
            // A torque that begins to turn a body turns the fluid beside it as well.
            if history.shear.is_none() {
                let (_, turn) = resistance(&s.bodies[k], &self.motions[k].surface_moments, unit);
                accelerations.angular.component_mul_assign(&inertial_share(
                    &s.bodies[k],
                    &turn,
                    dt,
                ));
            }
        }
        Ok(())
    }

    /// Moves the bodies on by `dt` (s), through contacts where there are any.
    fn advance_bodies(&mut self, domain: &Domain<D>, s: &mut State<D>, dt: f64) -> Result<()> {
        let periods = domain.periods();
        let unit = (domain.fluid.viscosity / self.cut.h, slope_weights());
        let histories = &mut history(&mut s.surfaces)?.bodies;
        for (body, history) in
            s.bodies.iter_mut().zip(histories).filter(|(body, _)| body.freedom().is_some())
        {
            body.displace(&std::mem::take(&mut history.displacement), &periods);
        }
        match &mut self.contacts {
            Some(contacts) => {
                let motions = &self.motions;
                let turning =
                    |k: usize, body: &Body| turning(body, &motions[k].surface_moments, unit, dt);
                let accelerations = &self.work.accelerations;
                let outcome =
                    contacts.advance(&mut s.bodies, &mut s.touching, accelerations, turning, dt)?;
                s.substeps = outcome.substeps;
            }
            None => {
                let bodies = s.bodies.iter_mut().zip(&self.work.accelerations);
                bodies.for_each(|(body, accelerations)| body.advance(dt, accelerations, &periods));
            }
        }
        Ok(())
    }

    /// Predicts the velocities of the free bodies at their new place, by all forces with the last
    /// pressure, whose changes follow. Collective.
    pub(super) fn predict_velocities(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Bodies)?;
        self.find_displaced(domain, &s.bodies)?;
        let forces = surface_forces(domain, &self.cut, s, &mut self.work.sums)?;
        let fluid = &domain.fluid;
        let h = self.cut.h;
        let unit = (fluid.viscosity / h, slope_weights());
        let histories = &mut history(&mut s.surfaces)?.bodies;
        for (k, forces) in forces.iter().enumerate() {
            let SurfaceForces { pressure, shear } = *forces;
            let impulse =
                self.contacts.as_ref().map(|c| c.outcome().impulse(k)).unwrap_or_default();
            let body = &mut s.bodies[k];
            let motion = &mut self.motions[k];
            let history = &mut histories[k];
            let before = history.shear.replace(shear).unwrap_or(shear);
            motion.pressure = pressure;
            motion.pressure.force += domain.felt(&s.drive, 1.0).component_mul(&motion.displaced);
            let (drag, turn) = resistance(body, &motion.surface_moments, unit);
            let drag = drag.max(least_drag(body, drag, fluid.density, h, unit.1, dt));
            let share = inertial_share(body, &turn, dt);
            let centred = 0.5 * share;
            motion.shear = Load {
                force: 0.5 * (shear.force + before.force),
                torque: shear.torque + centred.component_mul(&(before.torque - shear.torque)),
            };
            let Some(freedom) = body.freedom() else { continue };
            motion.inertia = body.mass() + dt * drag;
            let weight = (body.mass() - fluid.density * body.volume()) * fluid.gravity;
            let resisted = drag * (motion.expected.velocity - motion.start.velocity);
            let change = dt
                * (motion.pressure.force
                    + motion.shear.force
                    + history.filtered_defect
                    + weight
                    + resisted)
                + impulse.linear;
            body.velocity = motion.start.velocity + freedom.along(&change) / motion.inertia;
            // The same angular momentum is another spin once it has turned.
            let kept = motion.angular_momentum - body.inertia().of(&motion.start.spin);
            let resisted = turn.of(&(motion.expected.spin - motion.start.spin));
            let change = dt * (motion.shear.torque + motion.pressure.torque + resisted)
                + (impulse.angular + kept);
            let inertia = body.inertia().plus(dt, &turn);
            body.spin = motion.start.spin + inertia.inverse_mass(&change, &freedom);
            if let Some(contacts) = &mut self.contacts {
                // Contacts have had no part in what they did not expect, and would take it back
                // with the next step only.
                let unexpected = body.spin - motion.expected.spin;
                let outcome = contacts.outcome();
                let held = Vector3::from_fn(|a, _| {
                    (1.0 - outcome.contact_damping(k, inertia.about(a), dt)) * unexpected[a]
                });
                body.spin -= held;
                contacts.add_turn(k, &-inertia.of(&held));
            }
            if !body.shape().is_round() {
                motion.turns = inertia.inverse(&freedom);
            }
        }
        domain.clock.lap(Stage::Mixing);
        Ok(())
    }

    /// Takes the acceleration of the step `dt` (s) for the next one: by all but contacts, with the
    /// fluid's response to these beyond what the substeps expect.
    pub(super) fn take_accelerations(
        &self,
        domain: &Domain<D>,
        bodies: &[Body],
        histories: &mut [BodyHistory],
        dt: f64,
    ) {
        for (k, (motion, body)) in self.motions.iter().zip(bodies).enumerate() {
            let Some(freedom) = body.freedom() else { continue };
            let unit = (domain.fluid.viscosity / self.cut.h, slope_weights());
            let inertia = turning(body, &motion.surface_moments, unit, dt);
            let contacts = self.contacts.as_ref();
            let impulse = contacts.map_or_else(Impulse::default, |c| c.outcome().impulse(k));
            // An impact ends with the step, and the fluid's response to it does not last.
            let without = contacts.and_then(|contacts| contacts.velocity_without(k));
            let without = without.unwrap_or_else(|| {
                let mass =
                    contacts.map_or(body.mass(), |contacts| contacts.setup().mass_in_contact(body));
                body.velocity - impulse.linear / mass
            });
            // Nor does what the spin changes by as the angular momentum turns along: bodies do that
            // by themselves as they move.
            let kept = motion.angular_momentum - body.inertia().of(&motion.start.spin);
            histories[k].accelerations = Accelerations {
                acceleration: (without - motion.start.velocity) / dt,
                angular: (body.spin
                    - motion.start.spin
                    - inertia.inverse_mass(&(impulse.angular + kept), &freedom))
                    / dt,
            };
        }
    }
}

/// Sum of the weights of the slope at the surface: that of a velocity which is 1 at all image
/// points (over a spacing).
fn slope_weights() -> f64 {
    profile::slope(SLOPE_IMAGE_POINT).iter().sum()
}

/// What the wall shear takes back of a change of a body's velocity (N s/m) and spin (N m s) within
/// a step, for a viscosity over spacing (Pa s/m) with the sum of the slope's weights, and its
/// surface's area and moments: of the velocity by the profile's first image point, of the spin by
/// the slope of the wall shear itself.
pub(super) fn resistance(
    body: &Body,
    (area, surface_moments): &(f64, Matrix3<f64>),
    (unit, weights): (f64, f64),
) -> (f64, Inertia) {
    let slope = unit * weights;
    if body.shape().is_round() {
        return (unit * area, Inertia::Same(slope * surface_moments[(2, 2)]));
    }
    let turn = body.orientation();
    (unit * area, Inertia::Tensor(slope * (turn * surface_moments * turn.transpose())))
}

/// What a free body has to resist at least (N s/m) where the first image point gives `drag`, that
/// its velocity does not swing from step to step: the flow responds to a change of it within the
/// step by about
///
/// ```text
///   c = k drag (sum of the slope's weights + h/R)
///              k = 1.5 for a sphere, 2 for a disc: with the pressure that viscosity makes
/// ```
/// of which the body expects `drag`; the rest is felt a step late, and may be what its mass and the
/// fluid's resist at most. So it is of few cells across in steps of several stages alone, and of
/// light ones.
fn least_drag(body: &Body, drag: f64, density: f64, h: f64, weights: f64, dt: f64) -> f64 {
    let with_pressure = if body.shape().dimension() == 2 { 2.0 } else { 1.5 };
    let inverse_mass = with_pressure * drag * (weights + h / body.radius());
    0.5 * (inverse_mass - (body.mass() + body.added_mass(density)) / dt)
}

/// What turns with a body over a step `dt` (s): itself, and the fluid beside it by that resistance
/// (kg m2).
fn turning(
    body: &Body,
    surface_moments: &(f64, Matrix3<f64>),
    unit: (f64, f64),
    dt: f64,
) -> Inertia {
    body.inertia().plus(dt, &resistance(body, surface_moments, unit).1)
}

/// The part of a free body's response to torque over the step `dt` (s) that is inertia, and not the
/// wall shear's resistance `turn` (N m s), by axis. The torque is centred in time, and the spin
/// carried on, as far as this goes: of a body of no inertia the spin is that of the flow around it,
/// and what it was before only feeds an oscillation (nothing but added mass resists pressure, but
/// nothing adds inertia to a disc's spin).
fn inertial_share(body: &Body, turn: &Inertia, dt: f64) -> Vector3<f64> {
    let own = body.inertia();
    let resisted = body.inertia().plus(dt, turn);
    Vector3::from_fn(|a, _| body.freedom().map_or(1.0, |_| own.about(a) / resisted.about(a)))
}
