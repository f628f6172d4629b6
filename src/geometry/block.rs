//! Cells, faces or points that a particle reaches, its periodic images included.

use super::Shape;
use crate::grid::Grid;
use nalgebra::Vector3;

/// The centres (m) of a particle at `centre` and of its images one period away along the periodic
/// axes; an obstacle has its images in itself.
pub fn images<const D: usize>(
    grid: &Grid<D>,
    shape: &dyn Shape,
    centre: &Vector3<f64>,
) -> impl Iterator<Item = Vector3<f64>> {
    let own = shape.is_obstacle();
    let shifts = std::array::from_fn::<_, 3, _>(|a| {
        let length = if a < D && grid.periodic[a] && !own { grid.size[a] } else { 0.0 };
        let shifts = [0.0, -length, length];
        (shifts, if length > 0.0 { 3 } else { 1 })
    });
    let centre = *centre;
    let [(x, nx), (y, ny), (z, nz)] = shifts;
    (0..nx * ny * nz).map(move |k| centre + Vector3::new(x[k % nx], y[k / nx % ny], z[k / nx / ny]))
}

/// The boxes of a lattice from `first` to `last`, both included, the first axis fastest.
#[derive(Clone, Copy, Debug)]
pub struct Block<const D: usize> {
    first: [usize; D],
    last: [usize; D],
    next: Option<[usize; D]>,
}

impl<const D: usize> Block<D> {
    /// The lattice boxes between `low` and `high` (in boxes, ends included) that lie in `from` to
    /// `to` (end excluded).
    pub fn between(low: [f64; D], high: [f64; D], from: [usize; D], to: [usize; D]) -> Block<D> {
        let mut first = [0; D];
        let mut last = [0; D];
        for a in 0..D {
            if high[a] < from[a] as f64 || low[a] >= to[a] as f64 {
                return Block { first, last, next: None };
            }
            first[a] = low[a].max(from[a] as f64) as usize;
            last[a] = (high[a] as usize).min(to[a] - 1);
        }
        Block { first, last, next: Some(first) }
    }

    /// The first and the last of its boxes, if there is any.
    pub fn ends(&self) -> Option<([usize; D], [usize; D])> {
        self.next.map(|_| (self.first, self.last))
    }

    /// Sets the planes of the lattice whose boxes these are, of which number n along an axis lies
    /// between the places n and n + 1 (m). Returns the first box, if there is any.
    pub fn set_planes(
        &self,
        planes: &mut [Vec<f64>; 3],
        place: impl Fn(usize, usize) -> f64,
    ) -> Option<[usize; D]> {
        let (first, last) = self.ends()?;
        for (a, planes) in planes.iter_mut().enumerate() {
            planes.clear();
            if a < D {
                let count = last[a] - first[a] + 2;
                if count > planes.capacity() {
                    // Only a part of the planes of a body across a side of the box is here.
                    planes.reserve(2 * count);
                }
                planes.extend((first[a]..=last[a] + 1).map(|n| place(a, n)));
            } else {
                planes.extend([0.0; 2]);
            }
        }
        Some(first)
    }

    /// Whether the box of the half edges `bounds` (m) about a centre (m) is this rank's beyond
    /// doubt, without images.
    pub fn is_inside(grid: &Grid<D>, centre: &Vector3<f64>, bounds: &Vector3<f64>) -> bool {
        (0..D).all(|a| {
            let low = grid.start[a] as f64;
            let high = (grid.start[a] + grid.local[a]) as f64;
            let place = centre[a] / grid.h[a];
            let extent = bounds[a] / grid.h[a] + 1e-6;
            (!grid.periodic[a] && grid.local[a] == grid.cells[a])
                || (place - extent > low && place + extent < high)
        })
    }

    /// The owned cells within `bounds` (m) of a centre (m) along each axis.
    pub fn owned(grid: &Grid<D>, centre: &Vector3<f64>, bounds: &Vector3<f64>) -> Block<D> {
        let to = std::array::from_fn(|a| grid.start[a] + grid.local[a]);
        Block::within(grid, centre, bounds, grid.start, to)
    }

    /// The cells of all ranks within `bounds` (m) of a centre (m) along each axis.
    pub fn of_all(grid: &Grid<D>, centre: &Vector3<f64>, bounds: &Vector3<f64>) -> Block<D> {
        Block::within(grid, centre, bounds, [0; D], grid.cells)
    }

    fn within(
        grid: &Grid<D>,
        centre: &Vector3<f64>,
        bounds: &Vector3<f64>,
        from: [usize; D],
        to: [usize; D],
    ) -> Block<D> {
        let cell = |a: usize, x: f64| (x / grid.h[a]).floor();
        let low = std::array::from_fn(|a| cell(a, centre[a] - bounds[a]));
        let high = std::array::from_fn(|a| cell(a, centre[a] + bounds[a]));
        Block::between(low, high, from, to)
    }
}

impl<const D: usize> Iterator for Block<D> {
    type Item = [usize; D];

    fn next(&mut self) -> Option<[usize; D]> {
        let here = self.next?;
        self.next = (0..D).find(|&a| here[a] < self.last[a]).map(|a| {
            let mut next = here;
            next[a] += 1;
            next[..a].copy_from_slice(&self.first[..a]);
            next
        });
        Some(here)
    }
}
