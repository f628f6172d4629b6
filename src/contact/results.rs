//! Results of a step of the contacts, and properties of contacts before one.

use super::meeting::Meeting;
use super::pair::Pair;
use super::response::InverseMass;
use super::{Contacts, Impulse, Springs, Touching};
use crate::particles::{Accelerations, Body};
use crate::{Error, Result};
use nalgebra::Vector3;

impl Contacts {
    /// Part of a change of a body's spin, which the substeps did not expect, that contacts leave
    /// over the step `dt` (s): all without any, nothing of a body that touches. `inertia` is the
    /// moment of inertia about an axis (kg m2), the fluid's included.
    pub fn contact_damping(&self, body: usize, inertia: f64, dt: f64) -> f64 {
        1.0 / (1.0 + dt * self.damping[body] / inertia)
    }

    /// What an impulse (N m s) of contacts changes of a body's spin, with what turns with it
    /// (rad/s).
    pub(crate) fn turned_by(&self, body: usize, turn: &Vector3<f64>) -> Vector3<f64> {
        self.inverse_masses[body].inertia.of(turn)
    }

    /// Takes note of what contacts gave beyond what [`advance`](Contacts::advance) found (N m s).
    pub(crate) fn add_turn(&mut self, body: usize, turn: &Vector3<f64>) {
        self.impulses[body].angular += turn;
    }

    /// Impulses that contacts gave to each body over the last [`advance`](Contacts::advance).
    pub fn impulses(&self) -> &[Impulse] {
        &self.impulses
    }

    /// Momentum that bodies gave to walls over the last [`advance`](Contacts::advance) (N s).
    pub fn wall_impulse(&self) -> Vector3<f64> {
        self.wall_impulse
    }

    /// Work of moving walls on bodies over the last [`advance`](Contacts::advance) (J).
    pub fn wall_work(&self) -> f64 {
        self.wall_work
    }

    /// Energy that friction took over the last [`advance`](Contacts::advance) (J): the work of
    /// tangential forces and of the resistance to rolling, less what their springs hold.
    pub fn slid(&self) -> f64 {
        self.slid
    }

    /// Finds the pairs of bodies as they lie, before any [`advance`](Contacts::advance).
    pub fn meet(&mut self, bodies: &[Body]) {
        for (i, body) in bodies.iter().enumerate() {
            self.inverse_masses[i] = InverseMass::of(
                body,
                &Accelerations::default(),
                self.mass_in_contact(body),
                &body.inertia(),
            );
        }
        self.search(bodies, 0.0, false);
    }

    /// Whether a body is in reach of another or of a wall after a [`meet`](Contacts::meet).
    pub fn is_paired(&self, body: usize) -> bool {
        self.paired[body]
    }

    /// Energy in the normal springs of the pairs of the last [`advance`](Contacts::advance) or
    /// [`meet`](Contacts::meet), where the bodies lie now and are to be displaced (m) yet (J).
    pub fn stored(&self, bodies: &[Body], displaced: impl Fn(usize) -> Vector3<f64>) -> f64 {
        let of = |k: usize| if k < bodies.len() { displaced(k) } else { Vector3::zeros() };
        let overlap = |pair: &Pair| {
            let Meeting { normal, overlap, .. } = self.closest(pair, bodies, 0.0);
            overlap + normal.dot(&(of(pair.first) - of(pair.second)))
        };
        self.pairs.iter().fold(0.0, |sum, pair| sum + self.law(pair).stored(overlap(pair)))
    }

    /// Per body, whether it touched another or a wall over the last [`advance`](Contacts::advance),
    /// or came as near as their asperities are high.
    pub fn touched(&self) -> &[bool] {
        &self.touched
    }

    /// Deepest overlap of two bodies, or of one and a wall, over the last
    /// [`advance`](Contacts::advance) (m).
    pub fn deepest(&self) -> f64 {
        self.deepest
    }

    /// Shortest duration (s) of a contact that could happen, undamped and at an impact of `speed`
    /// (m/s), which counts where the exponent is not 1; infinite where none could.
    pub fn contact_time(&self, bodies: &[Body], speed: f64) -> f64 {
        // Per material, the lightest free body and the number of bodies.
        let mut lightest = vec![(f64::INFINITY, 0); self.laws.materials()];
        for (body, &material) in bodies.iter().zip(&self.materials) {
            let (mass, count) = &mut lightest[material];
            let own = self.mass_at_rim(body);
            *mass = mass.min(if body.freedom().is_some() { own } else { f64::INFINITY });
            *count += 1;
        }
        let mut shortest = f64::INFINITY;
        let mut meet = |a: usize, b: usize, inverse: f64| {
            if inverse > 0.0 {
                shortest = self.laws.of(a, b).contact_time(1.0 / inverse, speed).min(shortest);
            }
        };
        for (a, &(mass, count)) in lightest.iter().enumerate() {
            for (b, &(other, others)) in lightest.iter().enumerate().skip(a) {
                if others > 0 && count > usize::from(a == b) {
                    meet(a, b, 1.0 / mass + 1.0 / other);
                }
            }
            self.walls.iter().for_each(|wall| meet(a, wall.material, 1.0 / mass));
        }
        shortest
    }

    /// Least mass of a body that a contact may stop (kg), at its rim where it is not round.
    fn mass_at_rim(&self, body: &Body) -> f64 {
        let whole = self.mass_in_contact(body);
        let Some(freedom) = body.freedom().filter(|_| !body.is_round()) else { return whole };
        let turns = body.inertia().inverse(&freedom).diagonal().max() * body.radius().powi(2);
        1.0 / (1.0 / whole + turns)
    }

    /// Refuses what no run of this case has left.
    ///
    /// # Errors
    /// When a number belongs to no body or wall, or an image to no period.
    pub fn check(&self, touching: &Touching) -> Result<()> {
        let bodies = self.inverse_masses.len();
        for &(first, second, Springs { image, .. }) in &touching.springs {
            let imaged =
                (0..3).any(|a| image[a] != 0.0 && (second >= bodies || self.periods[a].is_none()));
            let misplaced = second <= first && !self.obstacles.contains(&second);
            if first >= bodies || misplaced || second >= bodies + self.walls.len() || imaged {
                return Err(Error::Run(format!(
                    "the saved contact of particle {first} with {second} does not belong to this \
                    case: restart with \
                     the particles and walls of the run that saved it"
                )));
            }
        }
        Ok(())
    }
}
