//! The pairs that could meet, and their springs from step to step.

use super::body::{ContactBody, Form};
use super::meeting::Layout;
use super::pair::{Pair, crossed};
use super::setup::Setup;
use super::{Touching, Wall, obstacle};
use crate::particles::{Body, Colours, Neighbours, nearest_image};
use mics_shapes::{Obstacle, Reach, Region, Regions};
use nalgebra::Vector3;

/// The pairs that could meet.
#[derive(Clone, Debug)]
pub(super) struct Pairs {
    /// The pairs in the order of their first body, ascending.
    pub(super) list: Vec<Pair>,
    /// The order in which they act one after the other.
    pub(super) colours: Colours,
    /// The pairs of the search before.
    pub(super) old: Vec<Pair>,
    /// Per body, its way since the search.
    pub(super) travels: Vec<Travel>,
    /// Per body, the way that it may go until pairs are searched for anew (m).
    pub(super) search_radius: Vec<f64>,
    pub(super) neighbours: Neighbours,
    /// The regions of obstacles in reach of parts of bodies.
    pub(super) regions: Regions,
}

/// The way of a body since the search.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Travel {
    /// Distance that it has gone (m).
    pub(super) gone: f64,
    /// Distance that it will have gone when the next substep is done (m).
    pub(super) next: f64,
    /// Whether it has a pair.
    pub(super) paired: bool,
}

impl Pairs {
    pub(super) fn new(bodies: &[Body], size: [f64; 3], periods: [Option<f64>; 3]) -> Pairs {
        let parts = bodies.iter().map(|body| body.parts().len().max(1)).sum::<usize>();
        Pairs {
            list: Vec::with_capacity(8 * parts),
            colours: Colours::new(size, periods, 8 * parts),
            old: Vec::with_capacity(8 * parts),
            travels: vec![Travel::default(); bodies.len()],
            search_radius: vec![0.0; bodies.len()],
            neighbours: Neighbours::new(bodies, size, periods),
            regions: Regions::default(),
        }
    }

    /// Room in the lists that could grow.
    #[cfg(test)]
    pub(super) fn capacity(&self) -> usize {
        self.list.capacity() + self.old.capacity() + self.neighbours.capacity()
    }

    /// Takes the springs of sustained contacts from the step before.
    pub(super) fn recall(
        &mut self,
        setup: &Setup,
        states: &[ContactBody],
        bodies: &[Body],
        touching: &Touching,
    ) {
        self.list.clear();
        self.list.extend(touching.springs.iter().map(|&(i, j, springs)| {
            let image = springs.image - crossed(bodies, i, j, &setup.periods);
            let mut pair = Pair { parts: springs.parts, ..setup.pair(i, j, image, states) };
            pair.springs.tangential = Some(springs.tangential);
            pair.springs.rolling = springs.rolling;
            pair
        }));
    }

    /// Leaves the springs of sustained contacts for the next step.
    pub(super) fn keep(&self, setup: &Setup, bodies: &[Body], touching: &mut Touching) {
        touching.springs.clear();
        touching.springs.extend(self.list.iter().filter_map(|pair| {
            let crossed = crossed(bodies, pair.first, pair.second, &setup.periods);
            Some((pair.first, pair.second, pair.sustained(&crossed)?))
        }));
    }

    /// Finds the pairs that could meet within `time` (s), and keeps the springs. With `again`, the
    /// search radius leaves room for what contacts do to speeds.
    pub(super) fn search(
        &mut self,
        setup: &Setup,
        states: &[ContactBody],
        bodies: &[Body],
        time: f64,
        again: bool,
    ) {
        self.find_faces(setup, states, bodies);
        self.find_reach(setup, states, bodies, time, again);
        // The first search of a step starts from the few pairs with springs: if the lists were
        // swapped, both would come to take the room of all pairs.
        self.old.clear();
        self.old.extend_from_slice(&self.list);
        self.list.clear();
        self.regions.clear();
        let mut rest = &self.old[..];
        for (i, body) in bodies.iter().enumerate() {
            let mine = rest.iter().take_while(|p| p.first == i).count();
            let (before, after) = rest.split_at(mine);
            rest = after;
            if states[i].form == Form::Obstacle {
                continue;
            }
            let begin = self.list.len();
            let list = &mut self.list;
            let travels = &mut self.travels;
            let mut found = Found { setup, states, bodies, first: i, before, list, travels };
            found.add_bodies(&mut self.neighbours, &self.search_radius);
            if body.freedom().is_some() {
                found.add_walls(self.search_radius[i]);
                found.add_obstacles(&self.search_radius, &mut self.regions);
            }
            sort(&mut self.list[begin..], body, bodies, &setup.walls, &setup.periods);
        }
        self.colours.sort(self.list.iter().map(|pair| pair.span(bodies, &setup.periods)));
    }

    /// Forgets who was near whom, finds how far bodies reach within `time` (s), and sorts them by
    /// where they are.
    fn find_reach(
        &mut self,
        setup: &Setup,
        states: &[ContactBody],
        bodies: &[Body],
        time: f64,
        again: bool,
    ) {
        self.travels.fill(Travel::default());
        let mut farthest: f64 = 0.0;
        for (i, (body, state)) in bodies.iter().zip(states).enumerate() {
            let way = state.way(body, time);
            self.search_radius[i] = 0.5 * setup.medium.range();
            if state.form == Form::Obstacle {
                // No contact changes the motion of an obstacle.
                self.search_radius[i] += way;
                continue;
            }
            self.search_radius[i] +=
                if again { 2.0 * way + 0.05 * body.radius() } else { way + 1e-6 * body.radius() };
            farthest = farthest.max(body.radius() + self.search_radius[i]);
        }
        self.neighbours.sort(bodies, 2.0 * farthest);
    }

    /// Finds the energy in the springs of the pairs as the bodies lie.
    pub(super) fn find_stored(&mut self, setup: &Setup, states: &[ContactBody], bodies: &[Body]) {
        let layout = Layout { setup, regions: &self.regions, states, bodies };
        self.list.iter_mut().for_each(|pair| pair.springs.stored = layout.stored(pair));
    }

    /// Finds the faces of obstacles that hold the sustained contacts with them now.
    pub(super) fn find_faces(&mut self, setup: &Setup, states: &[ContactBody], bodies: &[Body]) {
        if setup.obstacles.is_empty() {
            return;
        }
        let layout = Layout { setup, regions: &self.regions, states, bodies };
        for pair in &mut self.list {
            let lasts = pair.springs.tangential.is_some() && pair.region != Pair::NO_REGION;
            let Some(faces) = layout.faces(pair).filter(|_| lasts) else { continue };
            let place = layout.closest(pair, 0.0).arms.to[1];
            let own = bodies[pair.second].orientation().inverse_transform_vector(&place);
            pair.parts[1] = self.regions.get(pair.region).face_at(faces, &own);
        }
    }
}

/// Sum over the two of a pair of a way since the search (m), which `of` takes of each.
#[inline]
pub(super) fn together(pair: &Pair, travels: &[Travel], of: impl Fn(&Travel) -> f64) -> f64 {
    of(&travels[pair.first]) + travels.get(pair.second).map_or(0.0, of)
}

/// The pairs of a body while they are found, and those of the search `before`, which they continue.
struct Found<'a> {
    setup: &'a Setup,
    states: &'a [ContactBody],
    bodies: &'a [Body],
    first: usize,
    before: &'a [Pair],
    list: &'a mut Vec<Pair>,
    travels: &'a mut [Travel],
}

impl Found<'_> {
    /// Adds the pairs with bodies after this one.
    fn add_bodies(&mut self, neighbours: &mut Neighbours, search_radius: &[f64]) {
        let Found { setup, states, bodies, first: i, .. } = *self;
        let free = |k: usize| bodies[k].freedom().is_some();
        let periods = &setup.periods;
        neighbours.around(i, bodies, search_radius, |j, image| {
            if (!free(i) && !free(j)) || states[j].form == Form::Obstacle {
                return;
            }
            let image = image - crossed(bodies, i, j, periods);
            if states[i].form == Form::Round && states[j].form == Form::Round {
                self.add(j, image, [0; 2]);
                return;
            }
            let apart = Pair::new(i, j, image).apart(bodies, periods);
            let reach = search_radius[i] + search_radius[j];
            parts_near(&bodies[i], &bodies[j], &apart, reach, |parts| self.add(j, image, parts));
        });
    }

    /// Adds the pairs with walls of the box.
    fn add_walls(&mut self, search_radius: f64) {
        let Found { setup, states, bodies, first: i, .. } = *self;
        let body = &bodies[i];
        let reach = 0.5 * setup.medium.range() + search_radius;
        for (w, wall) in setup.walls.iter().enumerate() {
            if wall.distance(&body.centre) > body.radius() + reach {
                continue;
            }
            let round = states[i].form == Form::Round;
            for (k, (place, radius)) in balls(body) {
                if round || wall.distance(&(body.centre + place)) <= radius + reach {
                    self.add(bodies.len() + w, Vector3::zeros(), [k, 0]);
                }
            }
        }
    }

    /// Adds the pairs with obstacles.
    fn add_obstacles(&mut self, search_radius: &[f64], regions: &mut Regions) {
        for &o in &self.setup.obstacles {
            let all = search_radius[self.first] + search_radius[o];
            let reach = Reach { all, touched: all - self.setup.medium.range() };
            self.add_obstacle(o, reach, regions);
        }
    }

    /// Adds the pairs of the parts of a body with the regions of an obstacle within reach. The
    /// image of the obstacle is the nearest one, as it has its images in itself.
    fn add_obstacle(&mut self, o: usize, reach: Reach, regions: &mut Regions) {
        let Found { setup, states, bodies, first: i, .. } = *self;
        let body = &bodies[i];
        let wall = &bodies[o];
        let periods = &setup.periods;
        let Some(faces) = wall.shape().obstacle().map(Obstacle::faces) else { return };
        let apart = nearest_image(&body.centre, &wall.centre, periods);
        let further = apart - (wall.centre - body.centre);
        let image = Vector3::from_fn(|a, _| periods[a].map_or(0.0, |l| (further[a] / l).round()));
        let image = image - crossed(bodies, i, o, periods);
        let orientation = body.orientation();
        let turns = states[i].form != Form::Round;
        let own = obstacle::seen(&apart, turns.then_some(&orientation), &wall.orientation());
        for k in 0..body.parts().len().max(1) {
            obstacle::with_part(body, k, |part| {
                for region in regions.find(faces, part, &own, reach) {
                    self.add_region(o, image, k, region, regions.get(region));
                }
            });
        }
    }

    /// Adds the pair of these parts.
    fn add(&mut self, second: usize, image: Vector3<f64>, parts: [usize; 2]) {
        let same = |p: &&Pair| p.second == second && p.image == image && p.parts == parts;
        let before = self.before.iter().find(same).copied();
        self.push(before.unwrap_or_else(|| Pair { parts, ..self.pair(second, image) }));
    }

    /// Adds the pair of a part of the body with a region of an obstacle.
    fn add_region(
        &mut self,
        second: usize,
        image: Vector3<f64>,
        part: usize,
        region: usize,
        found: &Region,
    ) {
        let same = |p: &&Pair| p.second == second && p.parts[0] == part && found.has(p.parts[1]);
        let new = || Pair { parts: [part, found.nearest()], ..self.pair(second, image) };
        let before = self.before.iter().find(same).copied();
        self.push(Pair { region, image, ..before.unwrap_or_else(new) });
    }

    /// A new pair.
    fn pair(&self, second: usize, image: Vector3<f64>) -> Pair {
        self.setup.pair(self.first, second, image, self.states)
    }

    /// Adds a pair, which was not looked at since the search.
    fn push(&mut self, mut pair: Pair) {
        pair.seen.clear = 0.0;
        pair.seen.met = None;
        self.list.push(pair);
        self.travels[pair.first].paired = true;
        if let Some(way) = self.travels.get_mut(pair.second) {
            way.paired = true;
        }
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
    apart: &Vector3<f64>,
    reach: f64,
    mut take: impl FnMut([usize; 2]),
) {
    for (k, (place, radius)) in balls(body) {
        for (l, (its_place, its_radius)) in balls(other) {
            let way = apart + its_place - place;
            if way.norm() <= radius + its_radius + reach {
                take([k, l]);
            }
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
