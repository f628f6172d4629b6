//! Which bodies are near each other: as far as the image points of one may meet another.

use crate::grid::Grid;
use crate::particles::{Body, Colours, Neighbours, Span, nearest_image};
use nalgebra::Vector3;

/// The bodies near each.
pub struct NearBodies {
    /// Per body, the others, in the order of the bodies.
    pub near: Vec<Vec<usize>>,
    /// Whether any of those near it now, or before the last search, had moved then.
    pub restless: Vec<bool>,
    /// Pairs of these bodies, the lower number first, and their order.
    pairs: Vec<[usize; 2]>,
    colours: Colours,
    periods: [Option<f64>; 3],
    neighbours: Box<Neighbours>,
    /// The obstacles among them, which are looked at one by one.
    obstacles: Vec<usize>,
    /// Largest radius (m), and half the distance at which bodies are near each other, for every one
    /// (m).
    largest: f64,
    search_radius: Vec<f64>,
}

impl NearBodies {
    /// Bodies in a box of the given size (m) and periods, near each other in gaps up to `reach`
    /// (m); about each is room for so many.
    pub fn new(
        bodies: &[Body],
        size: [f64; 3],
        periods: [Option<f64>; 3],
        reach: f64,
        room: usize,
    ) -> NearBodies {
        let n = bodies.len();
        NearBodies {
            near: (0..n).map(|_| Vec::with_capacity(room)).collect(),
            restless: vec![false; n],
            pairs: Vec::with_capacity(n * room),
            colours: Colours::new(size, periods, n * room),
            periods,
            neighbours: Box::new(Neighbours::new(bodies, size, periods)),
            obstacles: (0..n).filter(|k| bodies[*k].shape().is_obstacle()).collect(),
            largest: bodies
                .iter()
                .filter(|b| !b.shape().is_obstacle())
                .fold(0.0, |most, b| most.max(b.radius())),
            search_radius: vec![0.5 * reach; n],
        }
    }

    /// Finds them anew; some of the bodies have `moved`.
    pub fn find(&mut self, bodies: &[Body], moved: &[bool]) {
        let moves = |near: &Vec<usize>| near.iter().any(|j| moved[*j]);
        for (restless, near) in self.restless.iter_mut().zip(&mut self.near) {
            *restless = moves(near);
            near.clear();
        }
        let NearBodies { near, search_radius: radius, obstacles, .. } = self;
        let Some(first) = radius.first() else { return };
        self.neighbours.sort(bodies, 2.0 * self.largest + first);
        for i in 0..bodies.len() {
            self.neighbours.around(i, bodies, radius, |j, _| {
                // The images of a body come one after the other.
                let obstacle = obstacles.contains(&i) || obstacles.contains(&j);
                if j > i && near[i].last() != Some(&j) && !obstacle {
                    near[i].push(j);
                    near[j].push(i);
                }
            });
        }
        for &obstacle in obstacles.iter() {
            let wall = &bodies[obstacle];
            let orientation = bodies[obstacle].orientation();
            for (i, body) in bodies.iter().enumerate().filter(|(i, _)| *i != obstacle) {
                if are_one(wall, body) {
                    continue;
                }
                // The first of two obstacles looks for the other.
                let both = body.shape().is_obstacle();
                let arm = body.centre - wall.centre;
                let close = || {
                    wall.shape().turned(&orientation).distance(&arm)
                        < body.radius() + 2.0 * radius[i]
                };
                if (both && obstacle < i) || (!both && close()) {
                    near[i].push(obstacle);
                    near[obstacle].push(i);
                }
            }
        }
        // In the order of the bodies, so that sums do not depend on how they were found.
        near.iter_mut().for_each(|near| near.sort_unstable());
        let all = self.restless.iter_mut().zip(&*near);
        all.for_each(|(restless, near)| *restless |= moves(near));
        self.sort_pairs(bodies);
    }

    /// Finds the pairs anew, in their order: walls are where the body is that is beside them.
    fn sort_pairs(&mut self, bodies: &[Body]) {
        let NearBodies { near, pairs, colours, periods, .. } = self;
        pairs.clear();
        for (i, near) in near.iter().enumerate() {
            pairs.extend(near.iter().filter(|j| **j > i).map(|j| [i, *j]));
        }
        let wall = |k: usize| bodies[k].is_obstacle();
        colours.sort(pairs.iter().map(|&[i, j]| {
            let from = bodies[if wall(i) { j } else { i }].centre;
            let way = nearest_image(&from, &bodies[j].centre, periods);
            Span { from, way: if wall(i) || wall(j) { Vector3::zeros() } else { way } }
        }));
    }

    /// Pairs of bodies near each other, the lower number first, in the order in which they act one
    /// after the other.
    pub fn pairs(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.colours.order().iter().map(|place| self.pairs[*place])
    }
}

/// Whether two bodies are obstacles that the fluid meets as one solid.
pub fn are_one(one: &Body, other: &Body) -> bool {
    let both = one.shape().obstacle().zip(other.shape().obstacle());
    both.is_some_and(|(one, other)| one.is_one_with(other))
}

/// By axis and side, whether a side of the box is as near to a body that reaches so far along the
/// axes from its centre (m).
pub fn walls_within<const D: usize>(
    grid: &Grid<D>,
    centre: &Vector3<f64>,
    reached: &Vector3<f64>,
) -> [[bool; 2]; D] {
    std::array::from_fn(|a| [centre[a] <= reached[a], grid.size[a] - centre[a] <= reached[a]])
}
