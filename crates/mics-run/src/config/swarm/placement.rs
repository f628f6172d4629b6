//! Random sequential addition: one body after the other, the largest first, at the first random
//! place that is free. Where one finds no such place, it and those after it are put down at random
//! all the same, and bodies that overlap are moved apart ([`part`]): so packings of 60 % of the
//! volume in 3D and 80 % of the area in 2D can be had.
//!
//! A grid of cells a largest diameter wide lists, for each cell, the bodies that a new one with its
//! centre there could touch: a try looks at one cell. Sums, products and square roots alone decide,
//! so that a seed gives the same places on every platform.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use std::f64::consts::PI;

use super::{Made, Scatter};
use crate::config::fault::Fault;
use crate::config::obstacle::Wall;
use crate::config::particle::distance;
use crate::config::{Case, Region};

mod part;

/// Tries for one body before it is put where it overlaps.
const TRIES: usize = 20_000;

/// Cells of the grid at most, along all axes together.
const MOST_CELLS: f64 = 1e6;

/// Range of the centre of a body with this diameter (m) along an axis: start and length (m); `None`
/// without room. Where the region spans a periodic axis, anywhere.
pub(super) fn room(
    case: &Case,
    region: &Region,
    gap: f64,
    axis: usize,
    diameter: f64,
) -> Option<(f64, f64)> {
    let size = case.domain.size[axis];
    let radius = 0.5 * diameter;
    let mut low = region.min[axis];
    let mut high = region.max[axis];
    if case.periodic(axis) {
        if diameter >= size || diameter + gap > size {
            return None;
        }
        if low == 0.0 && high == size {
            return Some((0.0, size));
        }
    } else {
        low = low.max(gap);
        high = high.min(size - gap);
    }
    let length = (high - radius) - (low + radius);
    // A region that is just as wide as a body has room for it, whatever the last digits say.
    (length >= -1e-12 * size).then_some((low + radius, length.max(0.0)))
}

/// The places that are taken.
struct Taken {
    periods: Vec<Option<f64>>,
    /// Cells along each axis, and their width (m).
    cells: Vec<(usize, f64)>,
    /// Bodies in reach of each cell.
    near: Vec<Vec<u32>>,
    bodies: Vec<(f64, Vec<f64>)>,
    /// Largest distance of a new body's centre from a surface at which the two may be too near (m).
    reach: f64,
    gap: f64,
    /// The obstacles.
    walls: Vec<Wall>,
}

impl Taken {
    fn new(case: &Case, largest: f64, gap: f64) -> Taken {
        let sizes = &case.domain.size;
        let mut wanted: Vec<f64> =
            sizes.iter().map(|size| (size / (largest + gap)).clamp(1.0, MOST_CELLS)).collect();
        // The longest axis gives way, so that a long and narrow box has no more cells than any
        // other.
        while wanted.iter().product::<f64>() > MOST_CELLS {
            let longest = wanted.iter_mut().max_by(|a, b| a.total_cmp(b));
            longest.into_iter().for_each(|n| *n *= 0.5);
        }
        let cells: Vec<_> =
            wanted.iter().zip(sizes).map(|(n, size)| (*n as usize, size / n.floor())).collect();
        let near = vec![Vec::new(); cells.iter().map(|(count, _)| count).product()];
        Taken {
            periods: case.periods(),
            cells,
            near,
            bodies: Vec::new(),
            reach: 0.5 * largest + gap,
            gap,
            walls: case.obstacle.iter().filter_map(|o| o.wall.clone()).collect(),
        }
    }

    fn add(&mut self, diameter: f64, place: Vec<f64>) {
        self.list(self.bodies.len() as u32, diameter, &place);
        self.bodies.push((diameter, place));
    }

    /// Lists a body with the cells that it is in reach of.
    fn list(&mut self, body: u32, diameter: f64, place: &[f64]) {
        let reach = 0.5 * diameter + self.reach;
        // From which cell on, and how many, along each axis.
        let span = |axis: usize| {
            let (count, width) = self.cells[axis];
            let last = self.cells[axis].0 as i64 - 1;
            let [low, high] = [-reach, reach].map(|d| ((place[axis] + d) / width).floor() as i64);
            match self.periods[axis] {
                Some(_) => (low, (high - low + 1).min(count as i64)),
                None => (low.clamp(0, last), high.clamp(0, last) - low.clamp(0, last) + 1),
            }
        };
        let spans: Vec<_> = (0..place.len()).map(span).collect();
        for mut k in 0..spans.iter().map(|(_, count)| count).product() {
            let mut cell = 0;
            for (&(first, count), &(cells, _)) in spans.iter().zip(&self.cells) {
                cell = cell * cells + (first + k % count).rem_euclid(cells as i64) as usize;
                k /= count;
            }
            self.near[cell].push(body);
        }
    }

    /// The cell that a place is in.
    fn cell(&self, place: &[f64]) -> usize {
        let axes = place.iter().zip(&self.cells);
        axes.fold(0, |cell, (x, &(count, width))| {
            cell * count + ((x / width) as usize).min(count - 1)
        })
    }

    fn is_free(&self, diameter: f64, place: &[f64]) -> bool {
        let off = |wall: &Wall| wall.nearest(place).distance >= 0.5 * diameter + self.gap;
        self.walls.iter().all(off)
            && self.near[self.cell(place)].iter().all(|&body| {
                let (other, at) = &self.bodies[body as usize];
                distance(place, at, &self.periods) >= 0.5 * (diameter + other) + self.gap
            })
    }
}

/// A uniform random number from 0 to below 1, of 53 bits.
fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// Bodies of a swarm with their places (m), clear of the case's particles and of each other;
/// refused at `key` where they do not fit.
pub(super) fn scatter(
    case: &Case,
    swarm: &Scatter,
    mut bodies: Vec<Made>,
    mut random: ChaCha8Rng,
    key: &str,
) -> Result<Vec<(Made, Vec<f64>)>, Fault> {
    let &Scatter { count, region, gap, widest, .. } = swarm;
    let mut uniform = || uniform(&mut random);
    bodies.sort_by(|a, b| b.shape.bounding_diameter().total_cmp(&a.shape.bounding_diameter()));
    let diameters: Vec<f64> = bodies.iter().map(|made| made.shape.bounding_diameter()).collect();
    // Nothing is tried far beyond the densest packing.
    let densest = if case.dimension() == 2 { 0.86 } else { 0.70 };
    if count > 1 && covered(region, &diameters, gap) > densest {
        return Err(Fault { key: key.to_owned(), message: shortage(swarm, &bodies, &diameters) });
    }
    let mut taken = Taken::new(case, widest, gap);
    for particle in &case.particle {
        taken.add(particle.shape.bounding_diameter(), particle.position.clone());
    }
    let listed = taken.bodies.len();
    let mut rooms = Vec::with_capacity(count);
    let mut overlapping = false;
    for &diameter in &diameters {
        let Some(room) = region.room(case, gap, diameter) else {
            return Err(Fault {
                key: key.to_owned(),
                message: shortage(swarm, &bodies, &diameters),
            });
        };
        let mut place = vec![0.0; case.dimension()];
        let mut attempt = || {
            for (axis, (low, length)) in room.iter().enumerate() {
                let x = low + uniform() * length;
                // Rounding may reach the far side of a period, which is its near side.
                place[axis] =
                    if case.periodic(axis) && x >= case.domain.size[axis] { 0.0 } else { x };
            }
            taken.is_free(diameter, &place)
        };
        // Once one finds no place, the smaller ones need not look for long.
        let tries = if overlapping { 1 } else { TRIES };
        overlapping |= !(0..tries).any(|_| attempt());
        taken.add(diameter, place);
        rooms.push(room);
    }
    if overlapping && !part::part(&mut taken, listed, &rooms) {
        return Err(Fault { key: key.to_owned(), message: shortage(swarm, &bodies, &diameters) });
    }
    let places = taken.bodies.split_off(listed).into_iter().map(|(_, place)| place);
    Ok(bodies.into_iter().zip(places).collect())
}

/// The part of a region that bodies would cover, half of the gap (m) around each.
fn covered(region: &Region, diameters: &[f64], gap: f64) -> f64 {
    let planar = region.min.len() == 2;
    let volume =
        |d: &f64| if planar { 0.25 * PI * (d + gap).powi(2) } else { PI / 6.0 * (d + gap).powi(3) };
    let whole: f64 = region.min.iter().zip(&region.max).map(|(low, high)| high - low).product();
    diameters.iter().map(volume).sum::<f64>() / whole
}

/// Message for a swarm that does not fit, with the cure.
fn shortage(swarm: &Scatter, bodies: &[Made], diameters: &[f64]) -> String {
    let Scatter { count, region, gap, .. } = swarm;
    let most = if region.min.len() == 2 { "80 % in 2D" } else { "60 % in 3D" };
    let they = match bodies.iter().any(|made| !made.shape.is_round()) {
        true => "the discs or spheres about them",
        false => "they",
    };
    format!(
        "{count} do not fit: with their gaps {they} would cover {:.1} % of the region, and random \
        packings reach about {most}, less in narrow regions and where other bodies are in it: ask \
        for fewer or smaller ones, a smaller gap or a larger region",
        100.0 * covered(region, diameters, *gap)
    )
}
