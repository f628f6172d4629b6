//! The bodies within a step: how they go to their new place, what forces make of their velocity
//! there, and what they have felt (formulas in the parent).

use super::body_motion::{BodyMotion, ShearUnit, inertial_share};
use super::cut::CutBodies;
use super::gap::Shares;
use super::load::{cell_momenta, load_of_filled, surface_forces};
use super::sums::{Sums, SurfaceForces};
use super::{StepNumbers, contact_correction};
use crate::Result;
use crate::clock::Stage;
use crate::contact::{Contacts, Impulse};
use crate::domain::Domain;
use crate::grid::BoundaryKind;
use crate::method::collision::refuse_collisions;
use crate::numerics::{DEFECT_DECAY, DEFECT_TIME};
use crate::particles::{Accelerations, Body, Load, gap, nearest_image};
use crate::petsc::LogStage;
use crate::state::{BodyHistory, Exchange, State, SurfaceHistory};
use nalgebra::Vector3;

/// The bodies within a step.
pub struct RigidStep {
    /// Per body, its motion.
    pub motions: Vec<BodyMotion>,
    /// The law of contacts, where there is one and a body is free.
    pub contacts: Option<Contacts>,
    /// Force of the fluid (N) in gaps that the grid does not resolve, which walls and held bodies
    /// have in place of free ones.
    pub gap_force_on_fixed: Vector3<f64>,
    /// Force (N) on obstacles by the pressure of cells that they fill, and of the sides of the box
    /// through the parts that they cover of them.
    pub force_of_filled: Vector3<f64>,
    /// Scratch: the part of each cell that bodies fill.
    filled: Vec<f64>,
    /// Whether advection conserves momentum, so that what it takes of one cell another has: else
    /// what it loses is nobody's force.
    keeps_momentum: bool,
    /// Momentum that the step gives to the cells of each body beside the flow.
    pub exchanged: Vec<Impulse>,
    /// Scratch of what ranks sum, of the correction of contacts, and of the accelerations that are
    /// frozen over the step.
    pub sums: Sums,
    pub correction: contact_correction::CorrectionScratch,
    accelerations: Vec<Accelerations>,
}

impl RigidStep {
    /// The step of these bodies.
    pub fn new(bodies: &[Body], contacts: Option<Contacts>, keeps_momentum: bool) -> RigidStep {
        let n = bodies.len();
        let motion = |body: &Body| BodyMotion {
            surface_moments: body.shape().surface_moments(),
            ..BodyMotion::default()
        };
        RigidStep {
            motions: bodies.iter().map(motion).collect(),
            contacts,
            gap_force_on_fixed: Vector3::zeros(),
            force_of_filled: Vector3::zeros(),
            filled: Vec::new(),
            keeps_momentum,
            exchanged: vec![Impulse::default(); n],
            sums: Sums::with_capacity(n),
            correction: contact_correction::CorrectionScratch::new(n),
            accelerations: vec![Accelerations::default(); n],
        }
    }

    /// Takes the motion at the start of the step, and the accelerations expected from the last
    /// step, on a grid where image points count in spacings of `h` (m).
    pub fn begin<const D: usize>(
        &mut self,
        domain: &Domain<D>,
        s: &mut State<D>,
        h: f64,
        dt: f64,
    ) -> Result<()> {
        for (motion, body) in self.motions.iter_mut().zip(&s.bodies) {
            motion.start = body.rigid_velocity();
            motion.angular_momentum = body.inertia().of(&body.spin);
        }
        self.recall_accelerations(domain, s, h, dt)
    }

    /// Takes the accelerations expected from the last step.
    fn recall_accelerations<const D: usize>(
        &mut self,
        domain: &Domain<D>,
        s: &mut State<D>,
        h: f64,
        dt: f64,
    ) -> Result<()> {
        let shear = ShearUnit::new(domain, h);
        let histories = &SurfaceHistory::of(&mut s.surfaces)?.bodies;
        for (k, (accelerations, history)) in
            self.accelerations.iter_mut().zip(histories).enumerate()
        {
            *accelerations = history.accelerations;
            // A torque that begins to turn a body turns the fluid beside it as well.
            if history.shear.is_none() {
                let surface = &self.motions[k].surface_moments;
                let turn = shear.resistance(&s.bodies[k], surface).1;
                accelerations.angular.component_mul_assign(&inertial_share(
                    &s.bodies[k],
                    &turn,
                    dt,
                ));
            }
        }
        Ok(())
    }

    /// (17, 18, 20-26): moves the bodies on by `dt` (s), through contacts where there are any.
    ///
    /// # Errors
    /// When contacts fail, or bodies run into each other that no law of contact stops.
    pub fn advance<const D: usize>(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        h: f64,
        dt: f64,
    ) -> Result<()> {
        let periods = domain.periods();
        let shear = ShearUnit::new(domain, h);
        let histories = &mut SurfaceHistory::of(&mut s.surfaces)?.bodies;
        for (body, history) in
            s.bodies.iter_mut().zip(histories).filter(|(body, _)| body.freedom().is_some())
        {
            body.displace(&std::mem::take(&mut history.displacement), &periods);
        }
        match &mut self.contacts {
            Some(contacts) => {
                let motions = &self.motions;
                let turning =
                    |k: usize, body: &Body| shear.turning(body, &motions[k].surface_moments, dt);
                let accelerations = &self.accelerations;
                let outcome =
                    contacts.advance(&mut s.bodies, &mut s.touching, accelerations, turning, dt)?;
                s.substeps = outcome.substeps;
            }
            None => {
                let bodies = s.bodies.iter_mut().zip(&self.accelerations);
                bodies.for_each(|(body, accelerations)| body.advance(dt, accelerations, &periods));
            }
        }
        domain.clock.lap(Stage::Contacts);
        refuse_collisions(domain, &s.bodies, self.contacts.is_some())?;
        for (motion, body) in self.motions.iter_mut().zip(&s.bodies) {
            motion.expected = body.rigid_velocity();
        }
        Ok(())
    }

    /// Predicts the velocities of the free bodies at their new place, by all forces with the last
    /// pressure, whose changes follow. Collective.
    pub fn predict_velocities<const D: usize>(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        cut: &CutBodies<D>,
        dt: f64,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Bodies)?;
        self.find_displaced(domain, &s.bodies, cut)?;
        let forces = surface_forces(domain, cut, s, &mut self.sums)?;
        let fluid = &domain.fluid;
        let unit = ShearUnit::new(domain, cut.h);
        let histories = &mut SurfaceHistory::of(&mut s.surfaces)?.bodies;
        for (k, forces) in forces.iter().enumerate() {
            let SurfaceForces { pressure, shear } = *forces;
            let impulse =
                self.contacts.as_ref().map(|c| c.outcome().impulse(k)).unwrap_or_default();
            let body = &mut s.bodies[k];
            let motion = &mut self.motions[k];
            let history = &mut histories[k];
            let before = history.shear.replace(shear).unwrap_or(shear);
            motion.pressure = pressure;
            motion.pressure.force +=
                domain.felt(&s.drive, 1.0).component_mul(&motion.displaced_volume);
            let (drag, turn) = unit.resistance(body, &motion.surface_moments);
            let drag = drag.max(unit.least_drag(body, drag, fluid.density, dt));
            let share = inertial_share(body, &turn, dt);
            let centred = 0.5 * share;
            motion.shear = Load {
                force: 0.5 * (shear.force + before.force),
                torque: shear.torque + centred.component_mul(&(before.torque - shear.torque)),
            };
            let Some(freedom) = body.freedom() else { continue };
            motion.effective_mass = body.mass() + dt * drag;
            let weight = (body.mass() - fluid.density * body.volume()) * fluid.gravity;
            let resisted = drag * (motion.expected.velocity - motion.start.velocity);
            let change = dt
                * (motion.pressure.force
                    + motion.shear.force
                    + history.filtered_defect
                    + weight
                    + resisted)
                + impulse.linear;
            body.velocity = motion.start.velocity + freedom.along(&change) / motion.effective_mass;
            // A body that has turned has another spin at the same angular momentum.
            let kept = motion.angular_momentum - body.inertia().of(&motion.start.spin);
            let resisted = turn.of(&(motion.expected.spin - motion.start.spin));
            let change = dt * (motion.shear.torque + motion.pressure.torque + resisted)
                + (impulse.angular + kept);
            let inertia = body.inertia().plus(dt, &turn);
            body.spin = motion.start.spin + inertia.spin_change(&change, &freedom);
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
                motion.inverse_inertia = inertia.inverse(&freedom);
            }
        }
        domain.clock.lap(Stage::Mixing);
        Ok(())
    }

    /// Takes the acceleration of the step `dt` (s) for the next one: by all but contacts, with the
    /// fluid's response to these beyond what the substeps expect.
    fn take_accelerations(
        &self,
        shear: &ShearUnit,
        bodies: &[Body],
        histories: &mut [BodyHistory],
        dt: f64,
    ) {
        for (k, (motion, body)) in self.motions.iter().zip(bodies).enumerate() {
            let Some(freedom) = body.freedom() else { continue };
            let inertia = shear.turning(body, &motion.surface_moments, dt);
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
                    - inertia.spin_change(&(impulse.angular + kept), &freedom))
                    / dt,
            };
        }
    }

    /// Finds the volumes on which the drive acts. One that holds a mean velocity, as a mean
    /// gradient of the pressure, acts on free bodies through the faces that the pressure acts
    /// through, or the two would not be found together: with their own volume a light body beside a
    /// heavy one did not let the iteration converge. Collective.
    pub fn find_displaced<const D: usize>(
        &mut self,
        domain: &Domain<D>,
        bodies: &[Body],
        cut: &CutBodies<D>,
    ) -> Result<()> {
        for (motion, body) in self.motions.iter_mut().zip(bodies) {
            motion.displaced_volume = Vector3::repeat(body.volume());
        }
        if domain.drive.as_ref().and_then(|drive| drive.held()).is_none() {
            return Ok(());
        }
        let volume = domain.grid.cell_volume();
        let own = |k: usize| {
            let covered = |axis: usize| {
                let cuts = cut.bodies[k].faces.cuts[axis].iter().filter(|cut| cut.owned);
                volume * cuts.map(|cut| cut.solid_fraction).sum::<f64>()
            };
            Vector3::from_fn(|axis, _| if axis < D { covered(axis) } else { 0.0 })
        };
        let Sums { vectors, messages, .. } = &mut self.sums;
        let all = vectors.sum_for_all(&domain.session, &cut.reach, messages, own)?;
        let free = self.motions.iter_mut().zip(bodies).zip(all);
        for ((motion, _), displaced) in free.filter(|((_, body), _)| body.freedom().is_some()) {
            (0..D).for_each(|axis| motion.displaced_volume[axis] = displaced[axis]);
        }
        Ok(())
    }

    /// Takes the momentum inside the bodies of these numbers as what was there before. Collective.
    pub fn take_inside<const D: usize>(
        &mut self,
        domain: &Domain<D>,
        s: &mut State<D>,
        cut: &CutBodies<D>,
        of: impl Fn(usize) -> bool,
    ) -> Result<()> {
        self.exchanged.fill(Impulse::default());
        let momenta = cell_momenta(domain, cut, &self.exchanged, s, &mut self.sums)?;
        let all =
            SurfaceHistory::of(&mut s.surfaces)?.bodies.iter_mut().zip(&s.bodies).zip(momenta);
        for ((history, body), momentum) in all.filter(|((_, body), _)| of(body.id)) {
            history.inside = momentum.whole(domain.fluid.density, body);
        }
        Ok(())
    }

    /// (19): finds the exchange of each body with the fluid over the step `dt` (s), its filtered
    /// force defect, and its acceleration without contacts for the next step. Collective.
    pub fn find_loads<const D: usize>(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        cut: &CutBodies<D>,
        numbers: StepNumbers,
        dt: f64,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Bodies)?;
        let momenta = cell_momenta(domain, cut, &self.exchanged, s, &mut self.sums)?;
        let histories = &mut SurfaceHistory::of(&mut s.surfaces)?.bodies;
        for (k, momentum) in momenta.iter().enumerate() {
            let Impulse { linear: given, angular: spun } = momentum.exchanged;
            let body = &s.bodies[k];
            let motion = &mut self.motions[k];
            let (inside, swirl) = momentum.whole(domain.fluid.density, body);
            let before = std::mem::replace(&mut histories[k].inside, (inside, swirl));
            // Momentum that advection loses by itself is nobody's force.
            let lost = if self.keeps_momentum {
                (inside - before.0 - given) / dt - domain.unfelt(&s.drive, body.volume())
            } else {
                motion.pressure.force + motion.shear.force
            };
            motion.angular_momentum_lost = swirl - before.1 - spun;
            let struck = self.contacts.as_ref().map(|c| c.outcome().impulse(k)).unwrap_or_default();
            let felt = motion.pressure.force + motion.shear.force + histories[k].filtered_defect;
            // Force that moved it beyond that, the resistance to changes within the step included.
            let moved = body.freedom().map(|freedom| {
                let weight =
                    (body.mass() - domain.fluid.density * body.volume()) * domain.fluid.gravity;
                let force = (body.mass() * (body.velocity - motion.start.velocity) - struck.linear)
                    / dt
                    - weight;
                freedom.along(&(force - felt))
            });
            let used = felt + moved.unwrap_or_default();
            motion.force_defect = lost - motion.pressure.force - motion.shear.force;
            motion.force = used;
            s.exchange[k] = Exchange { contact: struck.linear / dt, ..motion.exchange() };
        }
        self.share_defect_of_joined(&cut.joined);
        self.share_force_defect(domain, &s.bodies, cut);
        let take_in = (numbers.courant / DEFECT_TIME + DEFECT_DECAY * numbers.diffusion).min(1.0);
        for (motion, BodyHistory { filtered_defect, undelivered, .. }) in
            self.motions.iter().zip(histories.iter_mut())
        {
            *undelivered += dt
                * (motion.force_defect + motion.pressure.force + motion.shear.force - motion.force);
            *filtered_defect += take_in * (motion.force_defect - *filtered_defect);
        }
        self.take_accelerations(&ShearUnit::new(domain, cut.h), &s.bodies, histories, dt);
        self.take_displacements(s)?;
        self.leave_out_filled(domain, s, cut)?;
        domain.clock.lap(Stage::Force);
        Ok(())
    }

    /// Leaves what filled cells and covered sides of the box do to obstacles at rest out of the
    /// loads on these, which are then those of the fluid on their walls. Collective.
    fn leave_out_filled<const D: usize>(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        cut: &CutBodies<D>,
    ) -> Result<()> {
        self.force_of_filled = Vector3::zeros();
        // What moves ends within the box, and the fluid in it has its inertia.
        let rests = |body: &Body| body.is_obstacle() && !body.moves();
        if !s.bodies.iter().any(rests) {
            return Ok(());
        }
        let filled = &mut self.filled;
        filled.resize(s.p.len(), 0.0);
        filled.fill(0.0);
        let solid = cut.bodies.iter().flat_map(|body| &body.solid);
        solid.for_each(|solid| filled[solid.cell] += solid.fraction);
        domain.boundaries.exchange(1, filled)?;
        let Sums { filled: loads, messages, .. } = &mut self.sums;
        let own = |k: usize| match rests(&s.bodies[k]) {
            true => load_of_filled(cut, &domain.grid, k, &s.p, filled),
            false => Load::default(),
        };
        let loads = loads.sum_for_all(&domain.session, &cut.reach, messages, own)?;
        for (exchange, Load { force, torque }) in s.exchange.iter_mut().zip(loads) {
            exchange.momentum -= *force;
            exchange.pressure -= *force;
            exchange.momentum_torque -= *torque;
            exchange.literal_torque -= *torque;
            self.force_of_filled += *force;
        }
        Ok(())
    }

    /// Shares the force defect of obstacles that are one solid among them by the areas of their
    /// surfaces: where one ends within the solid, the cells cannot tell.
    fn share_defect_of_joined(&mut self, all: &[Vec<(usize, Vector3<f64>)>]) {
        for (k, joined) in all.iter().enumerate() {
            // Once for all of them, by the first.
            if joined.first().is_none_or(|(first, _)| *first != k) {
                continue;
            }
            let mut area = 0.0;
            let mut whole = Vector3::zeros();
            for motion in joined.iter().map(|(j, _)| &self.motions[*j]) {
                area += motion.surface_moments.0;
                whole += motion.force_defect;
            }
            for (j, _) in joined {
                let motion = &mut self.motions[*j];
                motion.force_defect = motion.surface_moments.0 / area * whole;
            }
        }
    }

    /// Removes from the force defects of two bodies whose gap the grid does not resolve the equal
    /// and opposite part along the line between their nearest points, likewise of a body at a wall:
    /// the cells cannot tell whose part of what the fluid lost there it is, and taken in with a
    /// delay it would be spurious work. The sum of a pair's stays.
    fn share_force_defect<const D: usize>(
        &mut self,
        domain: &Domain<D>,
        bodies: &[Body],
        cut: &CutBodies<D>,
    ) {
        let motions = &mut self.motions;
        let periods = domain.periods();
        self.gap_force_on_fixed = Vector3::zeros();
        for [i, j] in cut.near.pairs() {
            let apart = nearest_image(&bodies[i].centre, &bodies[j].centre, &periods);
            let (n, gap) = gap(&bodies[i], &bodies[j], &apart);
            let share = Shares::of(gap / cut.h).across;
            let free = [i, j].map(|k| bodies[k].freedom().is_some());
            let along = share * (motions[i].force_defect - motions[j].force_defect).dot(&n);
            let (of_i, of_j) = match free {
                [true, true] => (0.5 * along, -0.5 * along),
                _ => (
                    share * motions[i].force_defect.dot(&n),
                    share * motions[j].force_defect.dot(&n),
                ),
            };
            motions[i].force_defect -= of_i * n;
            motions[j].force_defect -= of_j * n;
            // Nothing of a free pair; else it is left to what holds the other.
            self.gap_force_on_fixed += (of_i + of_j) * n;
        }
        for (body, motion) in bodies.iter().zip(motions) {
            let reach = body.reach();
            for (a, side) in (0..D).flat_map(|a| [(a, 0), (a, 1)]) {
                let spans = match domain.boundaries.kinds[a][side] {
                    Some(BoundaryKind::Velocity(_)) => 1.0,
                    // To the body's own image.
                    Some(BoundaryKind::Slip) => 2.0,
                    _ => continue,
                };
                let centre = body.centre[a];
                let distance = if side == 0 { centre } else { domain.grid.size[a] - centre };
                let share = Shares::of(spans * (distance - reach[a]) / cut.h).across
                    * motion.force_defect[a];
                motion.force_defect[a] -= share;
                self.gap_force_on_fixed[a] += share;
            }
        }
    }

    /// Takes the corrections of the positions of bodies in contact for the next step.
    fn take_displacements<const D: usize>(&mut self, s: &mut State<D>) -> Result<()> {
        let Some(contacts) = &self.contacts else { return Ok(()) };
        let followed = &mut self.correction.followed;
        contacts.find_followed(&s.bodies, followed);
        let histories = SurfaceHistory::of(&mut s.surfaces)?.bodies.iter_mut();
        for (((history, body), motion), time) in
            histories.zip(&s.bodies).zip(&self.motions).zip(followed)
        {
            history.displacement = 0.5 * *time * (body.velocity - motion.expected.velocity);
        }
        Ok(())
    }

    /// Initialises the history of `new` bodies: the acceleration with which they begin in a fluid
    /// at rest, the one with which the fluid's wall shear begins to turn them, and the momentum
    /// inside as it is; ghosts of the velocity filled. Collective.
    pub fn initialise_history<const D: usize>(
        &mut self,
        domain: &Domain<D>,
        s: &mut State<D>,
        cut: &CutBodies<D>,
        new: impl Fn(usize) -> bool,
    ) -> Result<()> {
        let forces = surface_forces(domain, cut, s, &mut self.sums)?;
        let fluid = &domain.fluid;
        if let Some(contacts) = &mut self.contacts {
            contacts.meet(&s.bodies);
        }
        // The first motion of a lone body; beside others, what contacts may have to hold
        // at its effective mass.
        let begins = |k: usize, body: &Body| {
            let added = body.added_mass(fluid.density);
            let displaced = fluid.density * body.volume();
            let driven = s.drive.map_or_else(Vector3::zeros, |force| added / fluid.density * force);
            let pull = (body.mass() - displaced) * fluid.gravity
                + domain.felt(&s.drive, body.volume())
                + driven;
            let beside = self.contacts.as_ref().filter(|contacts| contacts.is_paired(k));
            let mass = beside
                .map_or(body.mass() + added, |contacts| contacts.setup().mass_in_contact(body));
            body.freedom().map_or_else(Vector3::zeros, |freedom| freedom.along(&pull) / mass)
        };
        let all = SurfaceHistory::of(&mut s.surfaces)?.bodies.iter_mut().zip(&s.bodies).zip(forces);
        for (k, ((history, body), forces)) in
            all.enumerate().filter(|(_, ((_, body), _))| new(body.id))
        {
            let Some(freedom) = body.freedom() else { continue };
            history.accelerations.acceleration = begins(k, body);
            history.accelerations.angular =
                body.inertia().spin_change(&forces.shear.torque, &freedom);
        }
        self.take_inside(domain, s, cut, new)
    }

    /// Adds to the undelivered impulses what the fluid lost by an impulse beyond what that gave to
    /// the free bodies, as steps do. Collective.
    pub fn defer<const D: usize>(
        &mut self,
        domain: &Domain<D>,
        s: &mut State<D>,
        cut: &CutBodies<D>,
    ) -> Result<()> {
        let momenta = cell_momenta(domain, cut, &self.exchanged, s, &mut self.sums)?;
        let histories = SurfaceHistory::of(&mut s.surfaces)?.bodies.iter_mut().zip(momenta);
        for (((history, momentum), body), motion) in histories
            .zip(&s.bodies)
            .zip(&self.motions)
            .filter(|((_, body), _)| body.freedom().is_some())
        {
            let (inside, _) = momentum.whole(domain.fluid.density, body);
            let lost = inside
                - history.inside.0
                - momentum.exchanged.linear
                - domain.unfelt(&s.drive, body.volume());
            history.undelivered += lost - motion.pressure.force;
        }
        Ok(())
    }
}
