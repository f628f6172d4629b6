//! Evenly spaced streamlines after Jobard and Lefer (1997): lines are seeded beside lines and end
//! where they come near.
//!
//! ```text
//!   ---o-----o-----o---   a line, kept as points one hop apart
//!      |  separation      candidates for seeds: beside each of its points, on both sides
//!   ---x-----x-----x---   a candidate near any line is dropped; a growing line stops at half the
//!                         separation
//! ```

use std::collections::VecDeque;

use super::Plane;

/// A point of the plane.
pub type Point = [f64; 2];

/// Hops in one separation.
pub const HOPS: usize = 6;
/// A line ends where the flow is slower than this part of its greatest speed: its direction there
/// is noise.
const STAGNANT: f64 = 1e-3;

/// The velocity at a point.
fn velocity(plane: &Plane, at: Point) -> [f64; 2] {
    plane.velocity.each_ref().map(|values| sample(plane, values, at))
}

/// The speed at a point.
pub fn speed(plane: &Plane, at: Point) -> f64 {
    let [u, v] = velocity(plane, at);
    u.hypot(v)
}

/// Bilinear value at a point of a cell-centred quantity, constant outside the outermost centres.
pub fn sample(plane: &Plane, values: &[f64], at: Point) -> f64 {
    let [(i, next_i, s), (j, next_j, t)] = [0, 1].map(|axis| {
        let last = plane.cells[axis] - 1;
        let place =
            (at[axis] / plane.size[axis] * plane.cells[axis] as f64 - 0.5).clamp(0.0, last as f64);
        let low = place as usize;
        (low, (low + 1).min(last), place - low as f64)
    });
    let value = |i: usize, j: usize| values[j * plane.cells[0] + i];
    let row = |j: usize| value(i, j) * (1.0 - s) + value(next_i, j) * s;
    row(j) * (1.0 - t) + row(next_j) * t
}

/// The greatest speed of a cell outside all discs, 0 where none has any: inside, sharp surfaces
/// keep the profile continued, which is no flow.
pub fn fastest(plane: &Plane) -> f64 {
    let [h, k] = [0, 1].map(|axis| plane.size[axis] / plane.cells[axis] as f64);
    let centre = |cell: usize| {
        [(cell % plane.cells[0]) as f64 * h + 0.5 * h, (cell / plane.cells[0]) as f64 * k + 0.5 * k]
    };
    let outside = |cell: usize| plane.discs.iter().all(|disc| !disc.covers(centre(cell)));
    let speeds =
        plane.velocity[0].iter().zip(&plane.velocity[1]).map(|(u, v)| u.hypot(*v)).enumerate();
    // Few are faster than all before them, and only those are looked up.
    speeds.fold(
        0.0,
        |top, (cell, speed)| {
            if speed > top && speed.is_finite() && outside(cell) { speed } else { top }
        },
    )
}

/// Streamlines about `separation` apart, each along the flow; the same lines for the same plane.
pub fn streamlines(plane: &Plane, separation: f64) -> Vec<Vec<Point>> {
    let mut tracer = Tracer::new(plane, separation);
    let [width, height] = plane.size;
    let bins = tracer.bins;
    let lattice = (0..bins[0] * bins[1]).map(|k| [k % bins[0], k / bins[0]]);
    let lattice =
        lattice.map(|[i, j]| [(i as f64 + 0.5) * separation, (j as f64 + 0.5) * separation]);
    let middle = [[0.5 * separation, 0.5 * height], [0.5 * width, 0.5 * separation]];
    let mut lines: Vec<Vec<Point>> = Vec::new();
    let mut seeds = VecDeque::new();
    for start in middle.into_iter().chain(lattice) {
        seeds.push_back(start);
        while let Some(seed) = seeds.pop_front() {
            let Some(line) = tracer.line(seed) else { continue };
            for &at in &line {
                if let Some([a, b]) = tracer.direction(at) {
                    seeds.extend([-separation, separation].map(|d| [at[0] - b * d, at[1] + a * d]));
                }
                let bin = tracer.bin(at);
                tracer.points[bin].push(at);
            }
            lines.push(line);
        }
    }
    lines
}

struct Tracer<'a> {
    plane: &'a Plane,
    separation: f64,
    /// Runge-Kutta steps in a hop, half a cell or less each.
    steps: usize,
    /// Slower than this is stagnant.
    slow: f64,
    /// Bins of one separation that cover the plane.
    bins: [usize; 2],
    /// Points of finished lines, by bin.
    points: Vec<Vec<Point>>,
    /// Discs that a hop from or to a bin can touch, by bin.
    discs: Vec<Vec<usize>>,
}

impl<'a> Tracer<'a> {
    fn new(plane: &'a Plane, separation: f64) -> Self {
        let bins = plane.size.map(|size| (size / separation).ceil().max(1.0) as usize);
        let cell =
            (plane.size[0] / plane.cells[0] as f64).min(plane.size[1] / plane.cells[1] as f64);
        let mut discs = vec![Vec::new(); bins[0] * bins[1]];
        for (index, disc) in plane.discs.iter().enumerate() {
            let [columns, rows] = [0, 1].map(|axis| {
                let reach = disc.radius + separation;
                let bin = |x: f64| (x / separation).clamp(0.0, bins[axis] as f64 - 1.0) as usize;
                bin(disc.centre[axis] - reach)..=bin(disc.centre[axis] + reach)
            });
            for row in rows {
                for column in columns.clone() {
                    discs[row * bins[0] + column].push(index);
                }
            }
        }
        Tracer {
            plane,
            separation,
            steps: (separation / HOPS as f64 / (0.5 * cell)).ceil().clamp(1.0, 100.0) as usize,
            slow: (STAGNANT * fastest(plane)).max(f64::MIN_POSITIVE),
            bins,
            points: vec![Vec::new(); bins[0] * bins[1]],
            discs,
        }
    }

    /// The line through a seed, or none where the seed is taken or the line would be a stub.
    fn line(&self, seed: Point) -> Option<Vec<Point>> {
        let edge = |axis: usize| (0.4 * self.separation).min(0.25 * self.plane.size[axis]);
        let clear =
            |axis: usize| (edge(axis)..=self.plane.size[axis] - edge(axis)).contains(&seed[axis]);
        if !(clear(0) && clear(1))
            || self.hits_disc(seed, seed)
            || self.near_line(seed, 0.999 * self.separation)
        {
            return None;
        }
        let mut line = vec![seed];
        let closed = self.extend(&mut line, 1.0);
        if !closed {
            line.reverse();
            self.extend(&mut line, -1.0);
            line.reverse();
        }
        line.iter().any(|point| distance(*point, seed) > self.separation).then_some(line)
    }

    /// Grows a line from its end, along the flow or against it. True when it came back to its
    /// start.
    fn extend(&self, line: &mut Vec<Point>, sign: f64) -> bool {
        let near = 0.5 * self.separation;
        for _ in 0..4 * HOPS * (self.bins[0] + self.bins[1]) {
            let from = line[line.len() - 1];
            let clear = |to: &Point| !self.hits_disc(from, *to) && !self.near_line(*to, near);
            let Some(to) = self.hop(from, sign).filter(clear) else { return false };
            if !self.inside(to) {
                line.push(self.leave(from, to));
                return false;
            }
            let own = &line[..line.len().saturating_sub(2 * HOPS)];
            if own.iter().any(|point| distance(*point, to) < near) {
                let [start, next] = [line[0], line[1]];
                let [gap, along] =
                    [[start, to], [next, start]].map(|[a, b]| [a[0] - b[0], a[1] - b[1]]);
                let offset = (gap[0] * along[1] - gap[1] * along[0]).abs() / distance(next, start);
                let closes = distance(start, to) < near && offset < 0.2 * near;
                line.push(to);
                line.extend(closes.then_some(start));
                return closes;
            }
            line.push(to);
        }
        false
    }

    /// The point one hop on, or none where the flow has no direction.
    fn hop(&self, from: Point, sign: f64) -> Option<Point> {
        let hop = self.separation / HOPS as f64;
        let step = sign * hop / self.steps as f64;
        let mut at = from;
        for _ in 0..self.steps {
            let ahead = |by: f64, [a, b]: Point| [at[0] + by * a, at[1] + by * b];
            let first = self.direction(at)?;
            let second = self.direction(ahead(0.5 * step, first))?;
            let third = self.direction(ahead(0.5 * step, second))?;
            let fourth = self.direction(ahead(step, third))?;
            at = ahead(
                step / 6.0,
                [0, 1].map(|k| first[k] + 2.0 * (second[k] + third[k]) + fourth[k]),
            );
        }
        (distance(from, at) > 0.5 * hop).then_some(at)
    }

    fn direction(&self, at: Point) -> Option<Point> {
        let [u, v] = velocity(self.plane, at);
        let speed = u.hypot(v);
        (speed > self.slow && speed.is_finite()).then(|| [u / speed, v / speed])
    }

    fn inside(&self, at: Point) -> bool {
        (0..2).all(|axis| (0.0..=self.plane.size[axis]).contains(&at[axis]))
    }

    /// Where a hop out of the plane crosses its edge.
    fn leave(&self, from: Point, to: Point) -> Point {
        let part = |axis: usize| {
            let beyond = to[axis] - to[axis].clamp(0.0, self.plane.size[axis]);
            if beyond == 0.0 { 1.0 } else { 1.0 - beyond / (to[axis] - from[axis]) }
        };
        let part = part(0).min(part(1));
        [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]))
    }

    fn hits_disc(&self, from: Point, to: Point) -> bool {
        let near = &self.discs[self.bin(from)];
        near.iter().any(|index| self.plane.discs[*index].meets(from, to))
    }

    fn near_line(&self, at: Point, reach: f64) -> bool {
        let bin = self.bin(at);
        let [column, row] = [bin % self.bins[0], bin / self.bins[0]];
        let around = |k: usize, bins: usize| k.saturating_sub(1)..(k + 2).min(bins);
        around(row, self.bins[1]).any(|row| {
            around(column, self.bins[0]).any(|column| {
                let points = &self.points[row * self.bins[0] + column];
                points.iter().any(|point| distance(*point, at) < reach)
            })
        })
    }

    fn bin(&self, at: Point) -> usize {
        let [column, row] =
            [0, 1].map(|axis| ((at[axis] / self.separation) as usize).min(self.bins[axis] - 1));
        row * self.bins[0] + column
    }
}

/// Distance of two points.
pub fn distance(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
