//! The motion of free particles: what pushes them, where that takes them, and the motion that they
//! and the mixture settle on at the new place (see the parent's formulas).

use super::rigid::Moments;
use super::{Driver, Mics2003};
use crate::Result;
use crate::contact::Impulse;
use crate::domain::Domain;
use crate::geometry::Overlap;
use crate::method::collision::refuse_collisions;
use crate::method::vector;
use crate::particles::{Accelerations, Body, Freedom, nearest_image};
use crate::state::{Exchange, State};
use crate::sums::Summed;
use nalgebra::Vector3;

/// What a particle's step starts from.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Departure {
    centre: Vector3<f64>,
    pub(super) velocity: Vector3<f64>,
    spin: Vector3<f64>,
    /// Angular momentum (kg m2/s).
    turned: Vector3<f64>,
    /// `sum alpha (u_f - V) dV` and `sum alpha r x (u_f - V) dV` there, relative to the velocity V
    /// that it came with: a uniform stream turns nothing, however coarse the sums are.
    flow: Vector3<f64>,
    swirl: Vector3<f64>,
    /// What the fields carry of the particle's excess mass, the `b` of the balance, linear and
    /// angular.
    pub(super) excess_momentum: (Vector3<f64>, Vector3<f64>),
    /// Volume within the box (m3): a contact lets a body a little way into a wall.
    pub(super) volume: f64,
    /// Momentum of the excess mass that went beyond the walls over the step (kg m/s).
    pub(super) beyond: Vector3<f64>,
    /// Displacement over the step (m).
    shift: Vector3<f64>,
    /// What its turning takes along locked directions of the forces on its cells, whose centroid is
    /// not the body's: this rank's part (N).
    locked: Vector3<f64>,
    /// What contacts were expected to give in the step: force (N) and torque (N m).
    expected: (Vector3<f64>, Vector3<f64>),
}

/// What ranks sum of the cells that a particle touches.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CellSums {
    /// By the mixture's density.
    moments: Moments,
    /// `sum alpha (u_f - V) dV` and its moment, as in [`Departure`].
    flow: Vector3<f64>,
    swirl: Vector3<f64>,
    /// A force and its torque, or what they stand for.
    also: [Vector3<f64>; 2],
    /// Volume within the box (m3).
    volume: f64,
}

impl Summed for CellSums {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        let CellSums { moments, flow, swirl, also: [force, torque], volume } = self;
        moments.each(take);
        [flow, swirl, force, torque].into_iter().for_each(|v| v.each(take));
        take(std::slice::from_mut(volume));
    }
}

/// Whether fields carry momentum that particles own: free ones, or held ones of another density.
fn trade(bodies: &[Body], fluid_density: f64) -> bool {
    bodies.iter().any(|b| b.freedom().is_some() || b.density != fluid_density)
}

impl<const D: usize> Mics2003<D> {
    /// Sums each particle's cells and, for both vectors that `also` gives, over the ranks; then
    /// hands them to `take`.
    fn gather(
        &mut self,
        domain: &Domain<D>,
        s: &State<D>,
        also: impl Fn(&Exchange) -> [Vector3<f64>; 2],
        mut take: impl FnMut(usize, &Body, &mut Departure, CellSums),
    ) -> Result<()> {
        let (volume, density) = (domain.grid.cell_volume(), &self.flow.mixture.density);
        let (overlaps, departures) = (&self.overlaps, &self.departures);
        let own = |k: usize| {
            let departure = &departures[k];
            let mut sums = CellSums { also: also(&s.exchange[k]), ..CellSums::default() };
            for o in &overlaps[k] {
                let (u, share) = (vector(&s.u, o.cell), o.fraction * volume);
                let relative = u - departure.velocity;
                sums.moments.add(density.at(o.cell) * share, &o.arm, &u);
                sums.volume += share;
                sums.flow += share * relative;
                sums.swirl += share * o.arm.cross(&relative);
            }
            sums
        };
        let messages = &mut self.messages;
        let sums = self.cells.sum_for_all(&domain.session, &self.reach, messages, own)?;
        let bodies = s.bodies.iter().zip(&mut self.departures);
        for (k, ((body, departure), sums)) in bodies.zip(sums).enumerate() {
            take(k, body, departure, *sums);
        }
        Ok(())
    }

    /// Finds what the turning of bodies takes along locked directions of the forces on their cells.
    fn find_locked(&mut self, domain: &Domain<D>, s: &State<D>) {
        let volume = domain.grid.cell_volume();
        let all = self.departures.iter_mut().zip(&s.bodies).zip(&self.overlaps).zip(&self.pulled);
        for (((departure, body), overlaps), (v, w)) in all {
            departure.velocity = body.velocity;
            departure.locked = body
                .freedom()
                .filter(|f| !f.translation.iter().all(|free| *free))
                .map_or_else(Vector3::zeros, |freedom| {
                    let pull =
                        |o: &Overlap| (body.density * o.fraction * volume) * (v + w.cross(&o.arm));
                    let pull: Vector3<f64> = overlaps.iter().map(pull).sum();
                    pull - freedom.along(&pull)
                });
        }
    }

    /// Finds the acceleration of each free particle by fluid and gravity, at the old place with the
    /// new flow, to be kept over the step `dt` (s). Collective.
    pub(super) fn depart(&mut self, domain: &Domain<D>, s: &State<D>, dt: f64) -> Result<()> {
        self.find_locked(domain, s);
        let (choices, fluid_density) = (self.choices, domain.fluid.density);
        if !trade(&s.bodies, fluid_density) {
            return Ok(());
        }
        let mut accelerations = std::mem::take(&mut self.accelerations);
        self.gather(
            domain,
            s,
            |e| [e.literal(), e.literal_torque],
            |k, body, departure, sums| {
                let CellSums { moments, flow, swirl, also: [force, torque], volume } = sums;
                let (centre, velocity, spin) = (body.centre, body.velocity, body.spin);
                let turned = body.inertia().of(&spin);
                let expected = s
                    .supports
                    .as_ref()
                    .map_or_else(Default::default, |all| (all[k].force, all[k].torque));
                let locked = departure.locked;
                let moved = Departure {
                    centre,
                    velocity,
                    spin,
                    turned,
                    locked,
                    expected,
                    ..Departure::default()
                };
                *departure = Departure { flow, swirl, volume, ..moved };
                let Some(freedom) = body.freedom() else { return };
                let (mut acceleration, angular, gravity) = match choices.driver {
                    Driver::Momentum => {
                        let (v, w) = moments.rigid_motion(&freedom, (velocity, spin));
                        // In the momentum of the mixture, the gravity of the fields is there
                        // already; so are the contacts that were expected, and substeps add those
                        // that there are.
                        let acceleration = (v - velocity) / dt - expected.0 / body.mass();
                        let angular =
                            (w - spin) / dt - body.inertia().inverse_mass(&expected.1, &freedom);
                        (acceleration, angular, choices.own_gravity)
                    }
                    Driver::Literal => {
                        let angular = body.inertia().inverse_mass(&torque, &freedom);
                        (force / body.mass(), angular, choices.own_gravity + choices.field_gravity)
                    }
                };
                acceleration += gravity * (1.0 - fluid_density / body.density);
                accelerations[k] = Accelerations { acceleration, angular }.along(&freedom);
            },
        )?;
        self.accelerations = accelerations;
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
        let (mut substeps, periods) = (0, domain.periods());
        match &mut self.contacts {
            Some(contacts) => {
                substeps = contacts.advance(
                    &mut s.bodies,
                    &mut s.touching,
                    &self.accelerations,
                    |_, body| body.inertia(),
                    dt,
                )?
            }
            None => {
                let bodies = s.bodies.iter_mut().zip(&self.accelerations);
                bodies.for_each(|(body, accelerations)| body.advance(dt, accelerations, &periods));
            }
        }
        for (body, departure) in s.bodies.iter().zip(&mut self.departures) {
            departure.shift = nearest_image(&departure.centre, &body.centre, &periods);
        }
        self.find_overlaps(domain, s, Body::moves);
        refuse_collisions(domain, &s.bodies, self.contacts.is_some())?;
        Ok(substeps)
    }

    /// Settles the motion of the free particles at the new place, with the new density and before
    /// the mixing, and counts what they exchanged with the fluid over `dt` (s). Collective.
    pub(super) fn settle(&mut self, domain: &Domain<D>, s: &mut State<D>, dt: f64) -> Result<()> {
        let (driver, fluid_density) = (self.choices.driver, domain.fluid.density);
        if !trade(&s.bodies, fluid_density) {
            return Ok(());
        }
        let mut settled = std::mem::take(&mut self.settled);
        let accelerations = std::mem::take(&mut self.accelerations);
        self.gather(
            domain,
            s,
            |e| [e.excess_momentum, e.excess_torque],
            |k, body, departure, sums| {
                let CellSums {
                    mut moments,
                    flow,
                    swirl,
                    also: [excess_momentum, excess_torque],
                    volume,
                } = sums;
                let Departure { velocity, spin, shift, .. } = *departure;
                let excess = body.density - fluid_density;
                let linear = excess * (flow - departure.flow) + dt * excess_momentum;
                let angular = excess * (swirl - departure.swirl + shift.cross(&departure.flow))
                    + dt * (excess_torque - shift.cross(&excess_momentum));
                departure.excess_momentum = (linear, angular);
                departure.beyond = excess * (departure.volume - volume) * velocity;
                let Some(freedom) = body.freedom() else { return };
                settled[k] = match driver {
                    Driver::Momentum => {
                        moments.momentum -= linear;
                        moments.spin -= angular;
                        moments.rigid_motion(&freedom, (velocity, spin))
                    }
                    Driver::Literal => {
                        // The same angular momentum is another spin once it has turned.
                        let kept = departure.turned - body.inertia().of(&spin);
                        let turned = body.inertia().inverse_mass(&kept, &freedom);
                        let Accelerations { acceleration, angular } = accelerations[k];
                        (velocity + dt * acceleration, spin + dt * angular + turned)
                    }
                };
            },
        )?;
        (self.settled, self.accelerations) = (settled, accelerations);
        self.release(domain, s, dt);
        self.find_contact_kicks(domain, &s.bodies, dt)
    }

    /// Gives the particles the motion that they settled on, with the impulses of their contacts,
    /// and counts what they exchanged over `dt` (s).
    fn release(&mut self, domain: &Domain<D>, s: &mut State<D>, dt: f64) {
        let (driver, fluid_density) = (self.choices.driver, domain.fluid.density);
        let lead = domain.session.rank() == 0;
        for (k, body) in s.bodies.iter_mut().enumerate() {
            let (departure, exchange, unexpected) =
                (&self.departures[k], &mut s.exchange[k], self.unexpected(k, dt));
            let (force, torque) = departure.expected;
            exchange.contact = unexpected.linear / dt + force;
            let Some(freedom) = body.freedom() else {
                if lead {
                    exchange.momentum -= departure.excess_momentum.0 / dt;
                    exchange.momentum_torque -= departure.excess_momentum.1 / dt;
                }
                continue;
            };
            let (mut v, w) = self.settled[k];
            if driver == Driver::Momentum {
                let (m, excess) = (body.mass(), body.mass() - fluid_density * body.volume());
                if lead {
                    let (held, held_turn) = departure.excess_momentum;
                    exchange.momentum = m * (v - departure.velocity) / dt
                        - freedom.along(&(excess * self.choices.field_gravity + force))
                        - (held - freedom.along(&held)) / dt;
                    // The same angular momentum is another spin once it has turned.
                    let gained = body.inertia().of(&(w - departure.spin));
                    let turned = body.inertia().of(&departure.spin) - departure.turned;
                    exchange.momentum_torque = (gained + turned) / dt
                        - freedom.about(&torque)
                        - (held_turn - freedom.about(&held_turn)) / dt;
                }
                v += freedom
                    .along(&(dt * (1.0 - fluid_density / body.density) * self.choices.own_gravity));
                self.settled[k].0 = v;
            }
            exchange.momentum -= departure.locked;
            (body.velocity, body.spin) = (v, w);
            body.velocity += freedom.along(&unexpected.linear) / body.mass();
            body.spin += body.inertia().inverse_mass(&unexpected.angular, &freedom);
        }
    }

    /// The rigid motions whose shares of mass carry to the cells what contacts gave over `dt` (s)
    /// beyond what was expected of them; none with the force of (19), whose particles are mixed in
    /// as they move after their contacts. Collective where there is any.
    fn find_contact_kicks(&mut self, domain: &Domain<D>, bodies: &[Body], dt: f64) -> Result<()> {
        let mut struck = std::mem::take(&mut self.struck);
        struck.fill(Default::default());
        if self.contacts.is_some() && self.choices.driver == Driver::Momentum {
            (0..bodies.len()).for_each(|k| {
                let Impulse { linear, angular } = self.unexpected(k, dt);
                struck[k] = (linear, angular);
            });
            self.share_by_mass(domain, bodies, &mut struck, &Vector3::zeros())?;
        }
        self.struck = struck;
        Ok(())
    }

    /// What contacts gave a body over `dt` (s) beyond what was expected of them.
    pub(super) fn unexpected(&self, k: usize, dt: f64) -> Impulse {
        let (mut impulse, (force, torque)) = (Impulse::default(), self.departures[k].expected);
        if let Some(contacts) = &self.contacts {
            impulse = contacts.impulses()[k];
            impulse.linear -= dt * force;
            impulse.angular -= dt * torque;
        }
        impulse
    }

    /// Finds what contacts are expected to give in the next step, from what they gave over `dt`
    /// (s).
    pub(super) fn expect_contacts(&mut self, s: &mut State<D>, dt: f64) {
        let (Some(supports), Some(contacts)) = (&mut s.supports, &self.contacts) else { return };
        for ((support, body), impulse) in
            supports.iter_mut().zip(&s.bodies).zip(contacts.impulses())
        {
            let Some(freedom) = body.freedom() else { continue };
            let force = freedom.along(&impulse.linear) / dt;
            let sustained = support.mean_contact_force.press(&force);
            (support.force, support.torque) =
                (sustained * force, sustained / dt * freedom.about(&impulse.angular));
        }
    }

    /// Finds the rigid accelerations whose shares of mass carry the weight of free bodies and what
    /// contacts are expected to give them: the pull on their cells alone would turn them, whose
    /// centroid is not the body's. Collective.
    pub(super) fn spread_forces(&mut self, domain: &Domain<D>, s: &State<D>) -> Result<()> {
        if self.flow.force.is_none() {
            return Ok(());
        }
        let (mut pulled, g) = (std::mem::take(&mut self.pulled), self.choices.field_gravity);
        for (k, pulled) in pulled.iter_mut().enumerate() {
            *pulled = s
                .supports
                .as_ref()
                .map_or_else(Default::default, |all| (all[k].force, all[k].torque));
        }
        self.share_by_mass(domain, &s.bodies, &mut pulled, &g)?;
        self.pulled = pulled;
        Ok(())
    }

    /// Makes of each body's impulse and its moment (N s, N m s), or force and torque, the rigid
    /// motion whose shares of mass carry them, with what gravity `g` (m/s2) gives its cells beyond
    /// what they displace. Collective where there is any.
    fn share_by_mass(
        &mut self,
        domain: &Domain<D>,
        bodies: &[Body],
        given: &mut [(Vector3<f64>, Vector3<f64>)],
        g: &Vector3<f64>,
    ) -> Result<()> {
        let none = (Vector3::zeros(), Vector3::zeros());
        if *g == none.0 && given.iter().all(|given| *given == none) {
            return Ok(());
        }
        let volume = domain.grid.cell_volume();
        let overlaps = &self.overlaps;
        let own = |k: usize| {
            let mut moments = Moments::default();
            for o in &overlaps[k] {
                moments.add(bodies[k].density * o.fraction * volume, &o.arm, &none.0);
            }
            moments
        };
        let messages = &mut self.messages;
        let masses = self.masses.sum_for_all(&domain.session, &self.reach, messages, own)?;
        for ((moments, body), given) in masses.iter_mut().zip(bodies).zip(given) {
            let Some(freedom) = body.freedom() else {
                *given = none;
                continue;
            };
            let weight = (1.0 - domain.fluid.density / body.density) * moments.mass * g;
            (moments.momentum, moments.spin) =
                (freedom.along(&(given.0 + weight)), freedom.about(&given.1));
            *given = moments.rigid_motion(&freedom, none);
        }
        Ok(())
    }
}

impl Accelerations {
    fn along(self, freedom: &Freedom) -> Accelerations {
        Accelerations {
            acceleration: freedom.along(&self.acceleration),
            angular: freedom.about(&self.angular),
        }
    }
}
