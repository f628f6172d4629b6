//! The pairs that could meet, and bodies that are where none may be.

use super::law::Law;
use super::pair::{Pair, crossed};
use super::response::InverseMass;
use super::{Contacts, Wall, obstacle};
use crate::error::NotFinite;
use crate::particles::Body;
use crate::{Error, Result};
use mics_shapes::Reach;
use nalgebra::Vector3;

impl Contacts {
    /// Finds the pairs that could meet within `time` (s), and keeps the springs. With `again`, the
    /// search_radius leaves room for what contacts do to speeds.
    pub(super) fn search(&mut self, bodies: &[Body], time: f64, again: bool) {
        self.find_faces(bodies);
        self.find_reach(bodies, time, again);
        // The first search of a step has the few pairs with springs only: exchanged for the other,
        // both lists would come to take the room of all.
        self.old.clear();
        self.old.extend_from_slice(&self.pairs);
        self.pairs.clear();
        let free = |i: usize| bodies[i].freedom().is_some();
        let mut rest = &self.old[..];
        for (i, body) in bodies.iter().enumerate() {
            let mine = rest.iter().take_while(|p| p.first == i).count();
            let (before, after) = rest.split_at(mine);
            rest = after;
            if self.obstacles.contains(&i) {
                continue;
            }
            let kept = |j, image, parts| {
                let same = |p: &&Pair| p.second == j && p.image == image && p.parts == parts;
                let new = Pair { parts, ..Pair::new(i, j, image) };
                Pair { clear: 0.0, ..before.iter().find(same).copied().unwrap_or(new) }
            };
            let periods = &self.periods;
            let pairs = &mut self.pairs;
            let paired = &mut self.paired;
            let begin = pairs.len();
            let search_radius = &self.search_radius;
            self.neighbours.around(i, bodies, search_radius, |j, image| {
                if (!free(i) && !free(j)) || self.obstacles.contains(&j) {
                    return;
                }
                let image = image - crossed(bodies, i, j, periods);
                let apart = || Pair::new(i, j, image).apart(bodies, periods);
                let reach = search_radius[i] + search_radius[j];
                parts_near(body, &bodies[j], apart, reach, |parts| {
                    pairs.push(kept(j, image, parts));
                    (paired[i], paired[j]) = (true, true);
                });
            });
            for (w, wall) in self.walls.iter().enumerate().filter(|_| free(i)) {
                let reach = 0.5 * self.medium.range() + self.search_radius[i];
                if wall.distance(&body.centre) > body.radius() + reach {
                    continue;
                }
                parts_at(body, wall, reach, |part| {
                    pairs.push(kept(bodies.len() + w, Vector3::zeros(), [part, 0]));
                    paired[i] = true;
                });
            }
            for &o in self.obstacles.iter().filter(|_| free(i)) {
                let all = search_radius[i] + search_radius[o];
                let reach = Reach { all, touched: all - self.medium.range() };
                let before = (before, &mut *pairs, &mut self.regions);
                if obstacle::add_pairs([i, o], bodies, periods, reach, before) {
                    (paired[i], paired[o]) = (true, true);
                }
            }
            sort(&mut pairs[begin..], body, bodies, &self.walls, periods);
        }
    }

    /// Forgets who was near whom, finds how far bodies reach within `time` (s), and sorts them by
    /// where they are.
    fn find_reach(&mut self, bodies: &[Body], time: f64, again: bool) {
        self.travelled.fill(0.0);
        self.met.clear();
        self.regions.clear();
        self.paired.fill(false);
        let mut farthest: f64 = 0.0;
        for (i, (body, inverse_mass)) in bodies.iter().zip(&self.inverse_masses).enumerate() {
            let way =
                (body.speed() + 0.5 * inverse_mass.accelerations.acceleration.norm() * time) * time;
            let way = way + self.rim_way(body, inverse_mass, time);
            self.search_radius[i] = 0.5 * self.medium.range();
            if obstacle::is_obstacle(body) {
                // Nothing drives it from its way.
                self.search_radius[i] += way;
                continue;
            }
            self.search_radius[i] +=
                if again { 2.0 * way + 0.05 * body.radius() } else { way + 1e-6 * body.radius() };
            farthest = farthest.max(body.radius() + self.search_radius[i]);
        }
        self.neighbours.sort(bodies, 2.0 * farthest);
    }

    /// How far the rim of a body that is not round may turn in `time` (m).
    fn rim_way(&self, body: &Body, inverse_mass: &InverseMass, time: f64) -> f64 {
        if body.is_round() {
            return 0.0;
        }
        let spin = body.spin.norm() + 0.5 * inverse_mass.accelerations.angular.norm() * time;
        (spin * time).min(std::f64::consts::TAU) * body.radius()
    }

    pub(super) fn law(&self, pair: &Pair) -> &Law {
        let wall = |w: usize| self.walls[w].material;
        let bodies = self.materials.len();
        let second =
            self.materials.get(pair.second).copied().unwrap_or_else(|| wall(pair.second - bodies));
        self.laws.of(self.materials[pair.first], second)
    }

    pub(super) fn name(&self, pair: &Pair) -> String {
        let second = match pair.second.checked_sub(self.materials.len()) {
            None => &self.names[pair.second],
            Some(w) => &self.walls[w].name(),
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
}

/// The spheres that hold the parts of a body: numbers, and centres from its own (m) with radii (m);
/// of a round body itself.
fn balls(body: &Body) -> impl Iterator<Item = (usize, (Vector3<f64>, f64))> {
    let own = body.parts().is_empty().then(|| (0, (Vector3::zeros(), body.radius())));
    let turn = body.orientation();
    let parts = body.parts().iter().map(move |part| (turn * part.place, part.radius));
    own.into_iter().chain(parts.enumerate())
}

/// Calls `take` with the parts of two bodies in reach of each other, whose centres are `apart` (m)
/// and whose spheres are in reach.
fn parts_near(
    body: &Body,
    other: &Body,
    apart: impl Fn() -> Vector3<f64>,
    reach: f64,
    mut take: impl FnMut([usize; 2]),
) {
    if body.is_round() && other.is_round() {
        take([0; 2]);
        return;
    }
    let apart = apart();
    for (k, (place, radius)) in balls(body) {
        for (l, (its_place, its_radius)) in balls(other) {
            let way = apart + its_place - place;
            if way.norm() <= radius + its_radius + reach {
                take([k, l]);
            }
        }
    }
}

/// Calls `take` with the parts of a body in reach of a wall, of which its sphere is.
fn parts_at(body: &Body, wall: &Wall, reach: f64, mut take: impl FnMut(usize)) {
    if body.is_round() {
        take(0);
        return;
    }
    for (k, (place, radius)) in balls(body) {
        if wall.distance(&(body.centre + place)) <= radius + reach {
            take(k);
        }
    }
}

/// Sorts the pairs of a `body`, which act one after the other: bodies by number, their images and
/// walls by distance, in an order that no mirror changes.
fn sort(
    pairs: &mut [Pair],
    body: &Body,
    bodies: &[Body],
    walls: &[Wall],
    periods: &[Option<f64>; 3],
) {
    let away = |pair: &Pair| {
        pair.second.checked_sub(bodies.len()).map(|wall| walls[wall].distance(&body.centre))
    };
    let ordered = |one: &Pair, other: &Pair| match (away(one), away(other)) {
        (Some(near), Some(far)) => near.total_cmp(&far).then(one.parts.cmp(&other.parts)),
        (None, None) if one.second == other.second => {
            let [near, far] = [one, other].map(|pair| pair.apart(bodies, periods).norm_squared());
            near.total_cmp(&far).then(one.parts.cmp(&other.parts))
        }
        _ => one.second.cmp(&other.second),
    };
    pairs.sort_unstable_by(ordered);
}
