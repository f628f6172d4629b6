//! Contacts and fluid at one: what the pressure makes of the contact impulses is compared with what the substeps expected, corrected
//! once, and bounded ([`crate::contact`] has the formulas).
//!
//! ```text
//!   J_1      substeps                       v_1 = v_0 + R J_1   a rough solve
//!   J_2      J_1 corrected by v_1 - v*      v_2 = v_0 + R J_2   to the end
//!   a J_2    where its work is too much     v_0 a rough solve, v_0 + a R J_2 to the end
//! ```

use super::Sharp;
use super::coupled::CoupledFaces;
use crate::Result;
use crate::contact::Impulse;
use crate::domain::Domain;
use crate::grid::VectorField;
use crate::params;
use crate::particles::Body;
use crate::poisson::pressure::Projected;
use crate::state::State;
use nalgebra::Vector3;

/// Scratch, per body, and what a step had before the impulses of touch were taken out of it.
pub struct Work<const D: usize> {
    residuals: Vec<Vector3<f64>>,
    corrections: Vec<Impulse>,
    kept: Kept<D>,
}

/// The pressure, and what follows it.
struct Kept<const D: usize> {
    p: Vec<f64>,
    faces: VectorField<D>,
    drive: Option<Vector3<f64>>,
    /// Velocity, spin, pressure force and torque of each body.
    bodies: Vec<[Vector3<f64>; 4]>,
}

impl<const D: usize> Work<D> {
    /// That of so many bodies.
    pub fn new(n: usize) -> Work<D> {
        let faces = std::array::from_fn(|_| Vec::new());
        Work {
            residuals: vec![Vector3::zeros(); n],
            corrections: vec![Impulse::default(); n],
            kept: Kept { p: Vec::new(), faces, drive: None, bodies: Vec::with_capacity(n) },
        }
    }
}

impl<const D: usize> Sharp<D> {
    /// (13-15) where contacts gave impulses in the step `dt` (s): these are corrected, and their work is bounded. Collective.
    pub(super) fn project_with_contacts(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        dt: f64,
    ) -> Result<Projected> {
        let digits = Some(params::response_digits());
        let mut done = self.project_with_bodies(domain, s, dt, digits)?;
        self.correct_contacts(s, dt);
        done.add(self.project_with_bodies(domain, s, dt, None)?);
        if self.contacts.as_mut().is_some_and(|contacts| contacts.find_clusters(&s.bodies)) {
            self.keep(s);
            self.take_out_touch(s);
            done.add(self.project_with_bodies(domain, s, dt, digits)?);
            let taken = self.contacts.as_mut().map_or(0.0, |contacts| contacts.bound_work(&s.bodies));
            self.bring_back(s);
            if taken > 0.0 {
                s.energy.bounded += taken;
                self.reduce_contacts(s);
                done.add(self.project_with_bodies(domain, s, dt, None)?);
            }
        }
        Ok(done)
    }

    /// Corrects the impulses of contacts by what the pressure has made of them.
    fn correct_contacts(&mut self, s: &mut State<D>, dt: f64) {
        let Some(contacts) = &mut self.contacts else { return };
        let (Work { residuals, corrections, .. }, motions) = (&mut self.work.contacts, &self.motions);
        for ((residual, body), motion) in residuals.iter_mut().zip(&s.bodies).zip(motions) {
            let free = body.freedom().is_some();
            *residual = if free { body.velocity - motion.expected.0 } else { Vector3::zeros() };
        }
        let tolerance = params::residual_tolerance() * contacts.contact_speed(&s.bodies)
            + params::residual_floor() * self.cut.h / dt;
        if contacts.correct(&s.bodies, residuals, corrections, tolerance, dt) {
            self.apply_corrections(s);
        }
    }

    /// Takes back what the bound leaves of the impulses of touch.
    fn reduce_contacts(&mut self, s: &mut State<D>) {
        if let Some(contacts) = &mut self.contacts {
            contacts.reduce(&s.bodies, &mut self.work.contacts.corrections);
        }
        self.apply_corrections(s);
    }

    /// Takes the impulses of touch out of the clusters whose work has to be looked at.
    fn take_out_touch(&mut self, s: &mut State<D>) {
        let Some(contacts) = &self.contacts else { return };
        for (k, correction) in self.work.contacts.corrections.iter_mut().enumerate() {
            let Impulse { linear, angular } = contacts.impulse_of_touch(k);
            *correction = Impulse { linear: -linear, angular: -angular };
        }
        self.apply_corrections(s);
    }

    /// Gives all bodies, and their faces, the correction impulses.
    fn apply_corrections(&mut self, s: &mut State<D>) {
        let Some(contacts) = &self.contacts else { return };
        let mut coupled = CoupledFaces::new(&self.cut, &mut s.faces, &mut s.bodies);
        for (k, correction) in self.work.contacts.corrections.iter().enumerate() {
            let Some(freedom) = coupled.bodies()[k].freedom() else { continue };
            let change = freedom.along(&correction.linear) / self.motions[k].inertia;
            coupled.change(k, &change, &contacts.turned_by(k, &correction.angular));
        }
    }

    /// Keeps what a projection changes.
    fn keep(&mut self, s: &State<D>) {
        let Kept { p, faces, drive, bodies } = &mut self.work.contacts.kept;
        p.clone_from(&s.p);
        faces.clone_from(&s.faces);
        *drive = s.drive;
        bodies.clear();
        let of = |(body, motion): (&Body, &super::BodyMotion)| {
            [body.velocity, body.spin, motion.pressure, motion.pressure_torque]
        };
        bodies.extend(s.bodies.iter().zip(&self.motions).map(of));
    }

    /// Brings back what was kept.
    fn bring_back(&mut self, s: &mut State<D>) {
        let Kept { p, faces, drive, bodies } = &self.work.contacts.kept;
        s.p.clone_from(p);
        s.drive = *drive;
        let mut coupled = CoupledFaces::new(&self.cut, &mut s.faces, &mut s.bodies);
        coupled.bring_back(faces, bodies.iter().map(|[velocity, spin, ..]| [*velocity, *spin]));
        for (motion, [_, _, pressure, torque]) in self.motions.iter_mut().zip(bodies) {
            (motion.pressure, motion.pressure_torque) = (*pressure, *torque);
        }
    }
}
