//! Order of pairs in loops in which each pair sees what those before it have done: by the colours
//! of a fixed lattice of the whole box.
//!
//! ```text
//!   | 0 | 1 | 0 | 1 | 0 |    a pair is in the cell of the middle between its two centres
//!   | 2 | 3 | 2 | 3 | 2 |    edge >= distance of the centres of any pair
//!   | 0 | 1 | 0 | 1 | 0 |    colours: whether a cell's number along each axis is odd
//! ```
//! The pairs of a body are within an edge of each other, hence in neighbouring cells, of which no
//! two have one colour: the cells of a colour can be visited in any order, with the same result.
//! The number of cells is odd along an axis with ends; along a period it is even, and the lattice
//! is shifted by half a cell. Colours come in the order of the first pair in each. A mirrored
//! scene, or one with exchanged axes, hence has the same order.

use nalgebra::Vector3;

/// Where a pair is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    /// Centre of the first body (m).
    pub(crate) from: Vector3<f64>,
    /// From there to the centre of the second (m); zero where that is no body that the pair moves.
    pub(crate) way: Vector3<f64>,
}

/// The lattice along an axis.
#[derive(Clone, Copy, Debug)]
struct Lattice {
    /// Length of the box (m), and whether that is a period.
    length: f64,
    periodic: bool,
    /// Number of cells.
    count: usize,
}

/// The order of the pairs of a list by their colours.
#[derive(Clone, Debug)]
pub(crate) struct Colours {
    axes: [Lattice; 3],
    /// Per pair, its cell.
    cells: Vec<[usize; 3]>,
    /// The places of the pairs in the list.
    order: Vec<usize>,
    /// Whether the cells of each colour are visited from the last one to the first.
    #[cfg(test)]
    pub(crate) backwards: bool,
}

impl Colours {
    /// No pairs yet, with room for so many, in a box of `size` (m) with the given `periods` (m).
    pub(crate) fn new(size: [f64; 3], periods: [Option<f64>; 3], room: usize) -> Colours {
        let axis = |a: usize| Lattice { length: size[a], periodic: periods[a].is_some(), count: 1 };
        Colours {
            axes: [0, 1, 2].map(axis),
            cells: Vec::with_capacity(room),
            order: Vec::with_capacity(room),
            #[cfg(test)]
            backwards: false,
        }
    }

    /// Sorts the pairs of a list by their colours; those of a colour stay in the order of the list.
    pub(crate) fn sort(&mut self, pairs: impl Iterator<Item = Span> + Clone) {
        let farthest = pairs.clone().fold(0.0, |most: f64, pair| most.max(pair.way.norm()));
        let Colours { axes, cells, order, .. } = self;
        axes.iter_mut().for_each(|axis| axis.divide(farthest));
        cells.clear();
        cells.extend(pairs.map(|pair| {
            let middle = pair.from + 0.5 * pair.way;
            [0, 1, 2].map(|a| axes[a].cell(middle[a]))
        }));
        order.clear();
        let mut done = [false; 8];
        for first in 0..cells.len() {
            let next = colour(&cells[first]);
            if std::mem::replace(&mut done[next], true) {
                continue;
            }
            #[cfg(test)]
            let begin = order.len();
            order.extend((first..cells.len()).filter(|pair| colour(&cells[*pair]) == next));
            #[cfg(test)]
            if self.backwards {
                order[begin..].sort_by_key(|pair| std::cmp::Reverse(cells[*pair]));
            }
        }
    }

    /// The places of the pairs in the list, in their order.
    pub(crate) fn order(&self) -> &[usize] {
        &self.order
    }
}

impl Lattice {
    /// Divides the axis into cells at least as long as the centres of a pair are apart (m).
    fn divide(&mut self, farthest: f64) {
        // No rounding makes a cell narrower than that.
        let most = (self.length / (farthest * (1.0 + 1e-9))) as usize;
        self.count =
            if self.periodic { (most / 2 * 2).max(1) } else { (most.max(1) - 1) / 2 * 2 + 1 };
    }

    /// Number of the cell that holds a coordinate (m).
    fn cell(&self, at: f64) -> usize {
        let cells = at / self.length * self.count as f64;
        if self.periodic {
            (cells.rem_euclid(self.count as f64) + 0.5) as usize % self.count
        } else {
            (cells as usize).min(self.count - 1)
        }
    }
}

/// Colour of a cell: whether its number along each axis is odd.
fn colour(cell: &[usize; 3]) -> usize {
    cell.iter().fold(0, |colour, number| 2 * colour + number % 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;

    #[test]
    fn no_body_has_pairs_in_two_cells_of_a_colour() {
        // Bodies all over a box that is periodic along x, each with partners at all angles.
        for farthest in [0.05, 0.11, 0.3, 0.6] {
            let mut colours = Colours::new([1.0, 0.7, 0.0], [Some(1.0), None, None], 0);
            let place = |k: usize| vector![0.017 * k as f64 % 1.0, 0.029 * k as f64 % 0.7, 0.0];
            let way = |j: usize| farthest * vector![(j as f64).cos(), (j as f64).sin(), 0.0];
            let span = |n: usize| Span { from: place(n / 20), way: way(n % 20) };
            colours.sort((0..4000).map(span));
            for own in colours.cells.chunks(20) {
                let two = |a: &[usize; 3], b: &[usize; 3]| a != b && colour(a) == colour(b);
                assert!(!own.iter().any(|a| own.iter().any(|b| two(a, b))), "{farthest}: {own:?}");
            }
            let mut order = colours.order().to_vec();
            order.sort_unstable();
            assert!(order.into_iter().eq(0..4000));
        }
    }

    #[test]
    fn mirrored_pairs_have_the_same_order() {
        let periods = [Some(1.0), None, None];
        let mut colours = Colours::new([1.0, 0.7, 0.0], periods, 0);
        let from = |k: usize| vector![0.0171 * k as f64 % 1.0, 0.0293 * k as f64 % 0.7, 0.0];
        let way = |k: usize| 0.09 * vector![(k as f64).cos(), (k as f64).sin(), 0.0];
        let mut orders = [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0]].map(|[x, y]| {
            let mirrored = |k: usize| {
                let way = vector![x * way(k).x, y * way(k).y, 0.0];
                let end = vector![f64::from(x < 0.0), if y < 0.0 { 0.7 } else { 0.0 }, 0.0];
                Span { from: end + vector![x * from(k).x, y * from(k).y, 0.0], way }
            };
            colours.sort((0..500).map(mirrored));
            colours.order().to_vec()
        });
        let [plain, others @ ..] = &mut orders;
        assert!(others.iter().all(|order| order == plain));
    }
}
