//! Which bodies could meet: cell lists filled by a counting sort.
//!
//! ```text
//!   edge >= 2 (largest radius + largest search_radius)        two that could meet lie in the same or in adjacent cells
//!   gap = |x_i - x_j| - r_i - r_j <= reach_i + reach_j
//! ```
//! A periodic axis may be one or two cells wide: a cell then is its own neighbour, or has one, and is visited once.
//! Of two bodies only the nearest images meet: a periodic axis has to be two of their diameters long at least.

use crate::particles::{Body, nearest_image};

/// Cell lists over a box. They allocate when built only.
#[derive(Clone, Debug)]
pub(crate) struct Neighbours {
    size: [f64; 3],
    periods: [Option<f64>; 3],
    /// Axes along which bodies can lie apart.
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

    /// Calls `take` with every `j > i` within reach of `i`, once each.
    pub(crate) fn around(&mut self, i: usize, bodies: &[Body], search_radius: &[f64], mut take: impl FnMut(usize)) {
        let (at, cells) = (self.place[i], self.cells);
        let ranges: [_; 3] = std::array::from_fn(|a| self.range(a, at[a]));
        for z in ranges[2].clone() {
            for y in ranges[1].clone() {
                for x in ranges[0].clone() {
                    let cell = index(&cells, &[x % cells[0], y % cells[1], z % cells[2]]);
                    for &j in &self.order[self.start[cell]..self.start[cell + 1]] {
                        if j > i {
                            self.checks += 1;
                            let within = bodies[i].radius() + bodies[j].radius() + search_radius[i] + search_radius[j];
                            let apart = nearest_image(&bodies[i].centre, &bodies[j].centre, &self.periods);
                            if apart.norm_squared() <= within * within {
                                take(j);
                            }
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

fn most_cells(bodies: usize) -> usize {
    4 * bodies + 64
}

fn index(cells: &[usize; 3], place: &[usize; 3]) -> usize {
    (place[2] * cells[1] + place[1]) * cells[0] + place[0]
}
