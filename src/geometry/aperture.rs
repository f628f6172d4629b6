//! Apertures: how much of the faces of cells a particle covers, and where their open part lies.
//!
//! ```text
//!      +----|----+        covered: the particle's part of the volume from the middle of one cell
//!                         to the middle of the
//!      |    |####|        next, exact. The sum over all faces along an axis is the particle's
//!                         volume wherever it lies,
//!      o    | ###o        and no face opens or closes at once: the pressure on a moving particle
//!                         stays calm.
//!      |    |  ##|
//!      +----|----+        lever: covered part times its centroid
//! ```
//! The flux of a rotation `w` through a face is `(w x lever).n`. The lever is that of the same
//! volume, so that a body that moves in any way is consistent with itself, and a rigid rotation of
//! fluid and body has no divergence; of round bodies it is that of the section in the face's own
//! plane, with which turning displaces nothing, in every cell.

use super::Placed;
use super::block::{Block, images};
use crate::grid::Grid;
use mics_shapes::Tile;
use nalgebra::Vector3;

/// A face that a particle covers, in part or whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Solid fraction: the part that is covered, within (0, 1].
    pub solid_fraction: f64,
    /// The face's index in a field: the low face of that cell.
    pub face: u32,
    /// Whether the cell above it is this rank's.
    pub owned: bool,
    /// Whether its body is the first, or the only one, of those that cover parts of the face, so
    /// far as is known.
    pub first: bool,
}

/// Centroids of the covered and the open part of a cut face, by the axes in use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceCentroids<const D: usize> {
    /// The solid fraction of the particle alone, before it gives way to others on the face.
    pub alone: f64,
    lever: [f64; D],
    /// From the face's centre to the centroid of the open part of that volume (m); zero where
    /// nothing is open.
    pub open: [f64; D],
}

impl<const D: usize> FaceCentroids<D> {
    /// Covered part times the arm from the particle's centre (its nearest image) to its centroid
    /// (m).
    #[inline(always)]
    pub fn lever(&self) -> Vector3<f64> {
        Vector3::from_fn(|a, _| if a < D { self.lever[a] } else { 0.0 })
    }
}

/// The faces along an axis that a particle covers. The part that most readers ask for is stored
/// apart from the rest: the pressure reads a quarter of the bytes.
#[derive(Clone, Debug)]
pub struct Cuts<const D: usize> {
    cuts: Vec<Cut>,
    centroids: Vec<FaceCentroids<D>>,
}

impl<const D: usize> Cuts<D> {
    /// No faces yet, with room for `n`.
    pub fn with_capacity(n: usize) -> Cuts<D> {
        Cuts { cuts: Vec::with_capacity(n), centroids: Vec::with_capacity(n) }
    }

    /// Number of faces that there is room for.
    pub fn capacity(&self) -> usize {
        self.cuts.capacity()
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.cuts.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.cuts.is_empty()
    }

    /// The faces.
    pub fn iter(&self) -> std::slice::Iter<'_, Cut> {
        self.cuts.iter()
    }

    /// The faces, so many at a time.
    pub fn chunks(&self, n: usize) -> std::slice::Chunks<'_, Cut> {
        self.cuts.chunks(n)
    }

    /// The faces, to change how far they are covered, with the centroids of their parts.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (&mut Cut, &FaceCentroids<D>)> {
        self.cuts.iter_mut().zip(&self.centroids)
    }

    /// The faces, with the centroids of their parts.
    #[inline]
    pub fn with_centroids(&self) -> impl Iterator<Item = (&Cut, &FaceCentroids<D>)> {
        self.cuts.iter().zip(&self.centroids)
    }

    fn clear(&mut self) {
        self.cuts.clear();
        self.centroids.clear();
    }

    fn push(&mut self, cut: Cut, centroids: FaceCentroids<D>) {
        self.cuts.push(cut);
        self.centroids.push(centroids);
    }
}

impl<'a, const D: usize> IntoIterator for &'a Cuts<D> {
    type Item = &'a Cut;
    type IntoIter = std::slice::Iter<'a, Cut>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// Below this a face counts as untouched, and above one less this as covered.
const LEAST: f64 = 1e-9;

/// Fills `cuts`, and the `arms` from the particle's centre (its nearest image) to the faces'
/// centres (m), in the same order, with the faces along `axis` of this rank's cells that a particle
/// (or an image of it) covers; faces at boundaries of the box are not among them, since the
/// boundary gives the flow through those; `planes` is scratch.
///
/// The first and the last faces of a period are the same ones. Both are found from the first one's
/// place, to the last digit: what flows out at one side comes in at the other.
pub fn cuts<const D: usize>(
    grid: &Grid<D>,
    axis: usize,
    body: &Placed,
    planes: &mut [Vec<f64>; 3],
    cuts: &mut Cuts<D>,
    arms: &mut Vec<Vector3<f64>>,
) {
    cuts.clear();
    arms.clear();
    let mut from = grid.start;
    let mut to: [usize; D] = std::array::from_fn(|a| grid.start[a] + grid.local[a]);
    from[axis] += usize::from(grid.at_boundary(axis, 0));
    let closes = grid.periodic[axis] && to[axis] == grid.cells[axis];
    to[axis] += usize::from(!grid.at_boundary(axis, 1) && !closes);
    find(grid, &Faces { axis, from, to, on: 0 }, body, planes, cuts, arms);
    if closes {
        from[axis] = 0;
        to[axis] = 1;
        find(grid, &Faces { axis, from, to, on: grid.cells[axis] }, body, planes, cuts, arms);
    }
}

/// Finds the cuts of this rank's faces at the sides of the box that are not periodic; the arms are
/// left as they come.
pub fn cuts_at_sides<const D: usize>(
    grid: &Grid<D>,
    axis: usize,
    body: &Placed,
    planes: &mut [Vec<f64>; 3],
    cuts: &mut Cuts<D>,
    arms: &mut Vec<Vector3<f64>>,
) {
    cuts.clear();
    arms.clear();
    for side in (0..2).filter(|side| grid.at_boundary(axis, *side)) {
        let mut from = grid.start;
        let mut to: [usize; D] = std::array::from_fn(|a| grid.start[a] + grid.local[a]);
        from[axis] = side * grid.cells[axis];
        to[axis] = from[axis] + 1;
        find(grid, &Faces { axis, from, to, on: 0 }, body, planes, cuts, arms);
    }
}

/// Faces along an axis.
struct Faces<const D: usize> {
    axis: usize,
    /// The first one, and the one after the last.
    from: [usize; D],
    to: [usize; D],
    /// Offset along the axis, in faces, of their places in the fields: a period, or none.
    on: usize,
}

/// Adds the faces that the body covers.
fn find<const D: usize>(
    grid: &Grid<D>,
    faces: &Faces<D>,
    body: &Placed,
    planes: &mut [Vec<f64>; 3],
    cuts: &mut Cuts<D>,
    arms: &mut Vec<Vector3<f64>>,
) {
    let Faces { axis, from, to, on } = *faces;
    let Placed { shape, pose } = body;
    let bounds = body.turned().bounds();
    for image in images(grid, *shape, &pose.place) {
        let place = |a: usize, x: f64| (x / grid.h[a] + if a == axis { 0.5 } else { 0.0 }).floor();
        let low = std::array::from_fn(|a| place(a, image[a] - bounds[a]));
        let high = std::array::from_fn(|a| place(a, image[a] + bounds[a]));
        let place = |a: usize, n: usize| {
            (n as f64 - if a == axis { 0.5 } else { 0.0 }) * grid.h[a] - image[a]
        };
        let block = Block::between(low, high, from, to);
        let Some(first) = block.set_planes(planes, place) else { continue };
        // The first one's index, and how many follow along the axis whose cells are this rank's.
        let further = |a: usize| if a == axis { on } else { 0 };
        let index = |a: usize| first[a] + further(a) + grid.ghosts - grid.start[a];
        let begin = (0..D).map(|a| index(a) * grid.stride[a]).sum::<usize>();
        let owned = (grid.start[axis] + grid.local[axis]).saturating_sub(first[axis] + on);
        body.turned().tile(planes, Some(axis), &mut |filled| {
            let (covered, open) = covered_part::<D>(filled);
            if covered < LEAST {
                return;
            }
            let face = begin + (0..D).map(|a| filled.at[a] * grid.stride[a]).sum::<usize>();
            let face = face as u32;
            let owned = filled.at[axis] < owned;
            let covered = if covered > 1.0 - LEAST { 1.0 } else { covered };
            let cut = Cut { solid_fraction: covered, face, owned, first: true };
            let lever = std::array::from_fn(|a| filled.lever[a]);
            cuts.push(cut, FaceCentroids { alone: covered, lever, open });
            arms.push(filled.middle);
        });
    }
}

/// Covered part of the volume about a face, and the centroid of its open part, from the face's
/// centre (m).
fn covered_part<const D: usize>(filled: &Tile) -> (f64, [f64; D]) {
    let covered = filled.part.clamp(0.0, 1.0);
    let middle = filled.middle;
    if !(LEAST..=1.0 - LEAST).contains(&covered) {
        return (covered, [0.0; D]);
    }
    (covered, std::array::from_fn(|a| (covered * middle[a] - filled.moment[a]) / (1.0 - covered)))
}
