//! Pairs of bodies that could meet, from cell lists filled by a counting sort.
//!
//! ```text
//!   edge >= 2 (largest radius + largest search_radius)
//!              two that could meet lie in the same or in adjacent cells
//!   gap = |x_i - x_j| - r_i - r_j <= reach_i + reach_j
//! ```
//! A periodic axis may be one or two cells wide: a cell then is its own neighbour, or has one, and
//! is visited once. Across a short period two bodies are neighbours on both sides, and a body is a
//! neighbour of its own images. An image is counted in whole periods n along each axis: it is at
//! `x_j + n L`. Images next to the nearest one are looked at, and of the two images of a body at
//! opposite sides the one whose first non-zero component of n is positive.

use crate::particles::Body;
use nalgebra::Vector3;

/// Cell lists over a box. They allocate when built only.
#[derive(Clone, Debug)]
pub(crate) struct Neighbours {
    size: [f64; 3],
    periods: [Option<f64>; 3],
    /// Number of axes along which bodies can lie apart.
    axes: usize,
    cells: [usize; 3],
    /// Per cell, where its bodies begin in `order`.
    start: Vec<usize>,
    order: Vec<usize>,
    place: Vec<[usize; 3]>,
    /// Distances looked at since the last sort.
    pub(crate) checks: usize,
}

impl Neighbours {
    /// Lists for these bodies in a box of `size` (m) with the given `periods` (m).
    pub(crate) fn new(bodies: &[Body], size: [f64; 3], periods: [Option<f64>; 3]) -> Neighbours {
        Neighbours {
            size,
            periods,
            axes: bodies.iter().map(|b| b.shape().dimension()).max().unwrap_or(2),
            cells: [1; 3],
            start: Vec::with_capacity(most_cells(bodies.len()) + 1),
            order: vec![0; bodies.len()],
            place: vec![[0; 3]; bodies.len()],
            checks: 0,
        }
    }

    /// Puts the bodies into cells of at least `edge` (m).
    pub(crate) fn sort(&mut self, bodies: &[Body], edge: f64) {
        self.checks = 0;
        let most = most_cells(bodies.len());
        self.cells = [1; 3];
        for a in 0..self.axes {
            self.cells[a] = ((self.size[a] / edge) as usize).clamp(1, most);
        }
        while self.cells.iter().map(|&n| n as f64).product::<f64>() > most as f64 {
            self.cells = self.cells.map(|n| n.div_ceil(2));
        }
        self.start.clear();
        self.start.resize(self.cells.iter().product::<usize>() + 1, 0);
        for (place, body) in self.place.iter_mut().zip(bodies) {
            for a in 0..3 {
                let cell = body.centre[a] / self.size[a] * self.cells[a] as f64;
                place[a] = (cell as usize).min(self.cells[a] - 1);
            }
            self.start[index(&self.cells, place)] += 1;
        }
        let mut total = 0;
        for count in &mut self.start {
            total += *count;
            *count = total;
        }
        for (i, place) in self.place.iter().enumerate().rev() {
            let cell = &mut self.start[index(&self.cells, place)];
            *cell -= 1;
            self.order[*cell] = i;
        }
    }

    /// Calls `take` with every image of a body `j > i`, and of `i` itself, within reach of `i`:
    /// once per pair of images.
    pub(crate) fn around(
        &mut self,
        i: usize,
        bodies: &[Body],
        search_radius: &[f64],
        mut take: impl FnMut(usize, Vector3<f64>),
    ) {
        let reach = |j: usize| {
            bodies[i].radius() + bodies[j].radius() + search_radius[i] + search_radius[j]
        };
        images(&Vector3::zeros(), reach(i), &self.periods, |image| {
            if image.iter().find(|n| **n != 0.0).is_some_and(|n| *n > 0.0) {
                take(i, image);
            }
        });
        let at = self.place[i];
        let cells = self.cells;
        let ranges: [_; 3] = std::array::from_fn(|a| self.range(a, at[a]));
        for z in ranges[2].clone() {
            for y in ranges[1].clone() {
                for x in ranges[0].clone() {
                    let cell = index(&cells, &[x % cells[0], y % cells[1], z % cells[2]]);
                    for &j in &self.order[self.start[cell]..self.start[cell + 1]] {
                        if j > i {
                            self.checks += 1;
                            let apart = bodies[j].centre - bodies[i].centre;
                            images(&apart, reach(j), &self.periods, |image| take(j, image));
                        }
                    }
                }
            }
        }
    }

    /// Room in the lists that could grow.
    #[cfg(test)]
    pub(crate) fn capacity(&self) -> usize {
        self.start.capacity()
    }

    /// The places along an axis of the cells about one at `at`, to be taken modulo their number.
    fn range(&self, axis: usize, at: usize) -> std::ops::Range<usize> {
        let n = self.cells[axis];
        match self.periods[axis] {
            Some(_) if n < 3 => 0..n,
            Some(_) => at + n - 1..at + n + 2,
            None => at.saturating_sub(1)..(at + 2).min(n),
        }
    }
}

/// Calls `take` with the images, in periods, that are within a distance (m) where the body itself
/// is at `apart` (m).
fn images(
    apart: &Vector3<f64>,
    within: f64,
    periods: &[Option<f64>; 3],
    mut take: impl FnMut(Vector3<f64>),
) {
    let mut nearest = Vector3::zeros();
    let mut way = *apart;
    for (a, length) in periods.iter().enumerate().filter_map(|(a, length)| Some((a, (*length)?))) {
        nearest[a] = -(way[a] / length).round();
        way[a] += length * nearest[a];
    }
    if way.norm_squared() > within * within {
        return;
    }
    // By axis, the steps to the next images that may be within reach.
    let steps = |a: usize| {
        [0.0, -1.0, 1.0].into_iter().filter(move |&step| {
            step == 0.0 || periods[a].is_some_and(|length| (way[a] + step * length).abs() <= within)
        })
    };
    for z in steps(2) {
        for y in steps(1) {
            for x in steps(0) {
                let step = Vector3::new(x, y, z);
                let there = Vector3::from_fn(|a, _| way[a] + step[a] * periods[a].unwrap_or(0.0));
                if there.norm_squared() <= within * within {
                    take(nearest + step);
                }
            }
        }
    }
}

fn most_cells(bodies: usize) -> usize {
    4 * bodies + 64
}

fn index(cells: &[usize; 3], place: &[usize; 3]) -> usize {
    (place[2] * cells[1] + place[1]) * cells[0] + place[0]
}
