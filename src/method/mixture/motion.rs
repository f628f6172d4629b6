//! The motion of free particles as printed, (17, 18): the force of (19) and gravity less buoyancy
//! accelerate a particle over the whole step, contacts push it in substeps, and its angular
//! momentum is kept where it turns.
//!
//! ```text
//!   V^(n+1) = V^n + dt [ F/m + (1 - rho_f/rho_k) g ] + J/m
//!   omega^(n+1) = I^-1 [ I^n omega^n + dt T + J_T ]           J, J_T: impulses of the contacts
//! ```

use super::{MixtureMethod, Sums};
use crate::Result;
use crate::domain::Domain;
use crate::method::collision::refuse_collisions;
use crate::particles::{Accelerations, Body};
use crate::state::State;
use crate::sums::Summed;
use nalgebra::Vector3;

/// The force (N) and the torque (N m) of (19) on a particle, which ranks sum.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Push {
    force: Vector3<f64>,
    torque: Vector3<f64>,
}

impl Summed for Push {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        self.force.each(take);
        self.torque.each(take);
    }
}

/// The motion that a particle's step starts from.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Departure {
    pub(super) velocity: Vector3<f64>,
    spin: Vector3<f64>,
    /// Angular momentum (kg m2/s).
    turned: Vector3<f64>,
}

impl<const D: usize> MixtureMethod<D> {
    /// Finds the acceleration of each free particle by fluid and gravity, at the old place with the
    /// new flow, to be kept over the step. Collective.
    pub(super) fn depart(&mut self, domain: &Domain<D>, s: &State<D>) -> Result<()> {
        for (departure, body) in self.departures.iter_mut().zip(&s.bodies) {
            *departure = Departure {
                velocity: body.velocity,
                spin: body.spin,
                turned: body.inertia().of(&body.spin),
            };
        }
        if !s.bodies.iter().any(|body| body.freedom().is_some()) {
            return Ok(());
        }
        let own = |k: usize| Push {
            force: s.exchange[k].literal(),
            torque: s.exchange[k].literal_torque,
        };
        let Sums { pushes, messages, .. } = &mut self.sums;
        let pushes = pushes.sum_for_all(&domain.session, &self.reach, messages, own)?;
        let bodies = s.bodies.iter().zip(&mut self.accelerations);
        for ((body, accelerations), push) in bodies.zip(pushes) {
            let Some(freedom) = body.freedom() else { continue };
            let buoyant = 1.0 - domain.fluid.density / body.density;
            let acceleration = push.force / body.mass() + domain.fluid.gravity * buoyant;
            *accelerations = Accelerations {
                acceleration: freedom.along(&acceleration),
                angular: freedom.about(&body.inertia().spin_change(&push.torque, &freedom)),
            };
        }
        Ok(())
    }

    /// Moves the bodies on by `dt` (s), through contacts where there are any, and finds what they
    /// touch there. Returns the substeps of the contacts.
    ///
    /// # Errors
    /// When a body meets another, a wall or the boundary and nothing says how, or a contact fails.
    pub(super) fn advance(
        &mut self,
        domain: &Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<usize> {
        let mut substeps = 0;
        let periods = domain.periods();
        match &mut self.contacts {
            Some(contacts) => {
                let outcome = contacts.advance(
                    &mut s.bodies,
                    &mut s.touching,
                    &self.accelerations,
                    |_, body| body.inertia(),
                    dt,
                )?;
                substeps = outcome.substeps;
            }
            None => {
                let bodies = s.bodies.iter_mut().zip(&self.accelerations);
                bodies.for_each(|(body, accelerations)| body.advance(dt, accelerations, &periods));
            }
        }
        self.find_overlaps(domain, s, Body::moves);
        refuse_collisions(domain, &s.bodies, self.contacts.is_some())?;
        Ok(substeps)
    }

    /// Gives the free particles the motion at the end of the step `dt` (s), with the impulses of
    /// their contacts, and counts what these gave.
    pub(super) fn settle(&self, s: &mut State<D>, dt: f64) {
        for (k, body) in s.bodies.iter_mut().enumerate() {
            let impulse = self.contacts.as_ref().map(|contacts| contacts.outcome().impulse(k));
            let impulse = impulse.unwrap_or_default();
            s.exchange[k].contact = impulse.linear / dt;
            let Some(freedom) = body.freedom() else { continue };
            let departure = &self.departures[k];
            let Accelerations { acceleration, angular } = self.accelerations[k];
            // A body that has turned has another spin at the same angular momentum.
            let kept = departure.turned - body.inertia().of(&departure.spin);
            let turned = body.inertia().spin_change(&kept, &freedom);
            body.velocity = departure.velocity
                + dt * acceleration
                + freedom.along(&impulse.linear) / body.mass();
            body.spin = departure.spin
                + dt * angular
                + turned
                + body.inertia().spin_change(&impulse.angular, &freedom);
        }
    }
}
