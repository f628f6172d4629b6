//! Setup of the contacts, which never changes in a run: the walls, the laws and the materials, the
//! fluid in the gaps, and the names of the bodies in messages.

use super::body::{ContactBody, Form};
use super::law::{Law, Laws};
use super::lubrication::Medium;
use super::pair::{Pair, Partner};
use super::{Springs, Substeps, Touching, Wall, WallSide};
use crate::error::NotFinite;
use crate::numerics::{ADDED_MASS_SHARE, ADDED_MASS_SLOPE, LARGEST_ADDED_MASS_SHARE};
use crate::particles::Body;
use crate::{Error, Result};
use nalgebra::Vector3;

/// The setup of the contacts of a run.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Names of the bodies in messages.
    pub(super) names: Vec<String>,
    /// The materials of the bodies.
    pub(super) materials: Vec<usize>,
    /// The bodies that are obstacles.
    pub(super) obstacles: Vec<usize>,
    pub(super) walls: Vec<Wall>,
    pub(super) laws: Laws,
    /// Size of the box (m), and the lengths of its axes that are periodic (m).
    pub(super) size: [f64; 3],
    pub(super) periods: [Option<f64>; 3],
    pub(super) substeps: Substeps,
    /// The fluid that fills the gaps.
    pub(super) medium: Medium,
}

impl Setup {
    /// Effective mass of a body in contact (kg): its own, and a part of its added mass that grows
    /// with its density.
    pub fn mass_in_contact(&self, body: &Body) -> f64 {
        let added = body.added_mass(self.medium.density);
        let displaced = self.medium.density * body.volume();
        let ratio = if displaced > 0.0 { body.mass() / displaced } else { f64::INFINITY };
        let part = ADDED_MASS_SHARE + ratio * ADDED_MASS_SLOPE;
        body.mass() + part.min(LARGEST_ADDED_MASS_SHARE) * added
    }

    /// A pair of a body with an image of another one, or with a wall after all bodies.
    pub(super) fn pair(
        &self,
        first: usize,
        second: usize,
        image: Vector3<f64>,
        states: &[ContactBody],
    ) -> Pair {
        let partner = match states.get(second).map(|its| its.form) {
            None => Partner::Wall,
            Some(Form::Obstacle) => Partner::Obstacle,
            Some(Form::Round | Form::Parts) => Partner::Body,
        };
        let material = match partner {
            Partner::Wall => self.walls[second - states.len()].material,
            _ => self.materials[second],
        };
        let second_is_round = partner != Partner::Body || states[second].form == Form::Round;
        let round = states[first].form == Form::Round && second_is_round;
        let law = self.laws.place(self.materials[first], material);
        Pair { partner, round, law, ..Pair::new(first, second, image) }
    }

    /// The law of a pair.
    pub(super) fn law(&self, pair: &Pair) -> &Law {
        self.laws.at(pair.law)
    }

    /// The wall of a pair, where its second is one.
    pub(super) fn wall(&self, pair: &Pair) -> Option<&Wall> {
        pair.second.checked_sub(self.materials.len()).map(|wall| &self.walls[wall])
    }

    /// Behaviour of the fluid at the wall of a pair; `None` where the second is a body.
    pub(super) fn side(&self, pair: &Pair) -> Option<WallSide> {
        self.wall(pair).map(|wall| wall.side)
    }

    /// Name of a pair in messages.
    pub(super) fn name(&self, pair: &Pair) -> String {
        let second = match self.wall(pair) {
            None => &self.names[pair.second],
            Some(wall) => &wall.name(),
        };
        format!("{} and {second}", self.names[pair.first])
    }

    /// Refuses bodies of which the state is not finite, or that are outside the box or beyond a
    /// wall.
    pub(super) fn refuse_strays(&self, bodies: &[Body]) -> Result<()> {
        for body in bodies {
            if !body.is_finite() {
                return Err(Error::NotFinite(NotFinite::Particle(body.id)));
            }
            if let Some(wall) = self.walls.iter().find(|wall| wall.distance(&body.centre) < 0.0) {
                return Err(Error::Run(format!(
                    "the centre of {} is beyond {}: shorten the step or make the contact stiffer",
                    body.called(),
                    wall.name()
                )));
            }
            for a in (0..body.shape().dimension()).filter(|&a| self.periods[a].is_none()) {
                if !(0.0..=self.size[a]).contains(&body.centre[a]) {
                    return Err(Error::Run(format!(
                        "the centre of {} has left the box: it is at {} = {:.6} m, and no wall \
                        ends the box there; make that boundary a wall or the axis periodic, or end \
                        the run before",
                        body.called(),
                        ["x", "y", "z"][a],
                        body.centre[a]
                    )));
                }
            }
        }
        Ok(())
    }

    /// Refuses saved contacts that no run of this case has left.
    ///
    /// # Errors
    /// When a number belongs to no body or wall, or an image to no period.
    pub fn check(&self, touching: &Touching) -> Result<()> {
        let bodies = self.materials.len();
        for &(first, second, Springs { image, .. }) in &touching.springs {
            let imaged =
                (0..3).any(|a| image[a] != 0.0 && (second >= bodies || self.periods[a].is_none()));
            let misplaced = second <= first && !self.obstacles.contains(&second);
            if first >= bodies || misplaced || second >= bodies + self.walls.len() || imaged {
                return Err(Error::Run(
                    "a saved contact does not belong to this case: restart with the particles and \
                    walls of the run that saved it"
                        .into(),
                ));
            }
        }
        Ok(())
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
        let turns_away = Form::of(body) != Form::Round;
        let Some(freedom) = body.freedom().filter(|_| turns_away) else { return whole };
        let turns = body.inertia().inverse(&freedom).diagonal().max() * body.radius().powi(2);
        1.0 / (1.0 / whole + turns)
    }
}
