//! Apertures: how much of the faces of cells a particle covers, and where their open part lies.
//!
//! ```text
//!      +----|----+        covered: the particle's part of the volume from the middle of one cell to the middle of the
//!      |    |####|        next, exact. The sum over all faces along an axis is the particle's volume wherever it lies,
//!      o    | ###o        and no face opens or closes at once: the pressure on a moving particle stays calm.
//!      |    |  ##|
//!      +----|----+        lever: covered part times its centroid
//! ```
//! The flux of a rotation `w` through a face is `(w x lever).n`. The lever is that of the same volume, so that a body that moves
//! in any way is consistent with itself, and a rigid rotation of fluid and body has no divergence; of round bodies it is that
//! of the section in the face's own plane, with which turning displaces nothing, in every cell.

use super::block::{Block, images};
use super::{Placed, Shape, Turn};
use crate::grid::Grid;
use nalgebra::Vector3;

/// A face that a particle covers, in part or whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Covered part, within (0, 1].
    pub covered: f64,
    /// The face's index in a field: the low face of that cell.
    pub face: u32,
    /// Whether the cell above it is this rank's.
    pub owned: bool,
}

/// Where the covered and the open part of such a face lie: apart, since few ask for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Covered part times the arm from the particle's centre (its nearest image) to its centroid (m).
    pub lever: Vector3<f64>,
    /// From the face's centre to the centroid of the open part of that volume (m); zero where nothing is open.
    pub open: Vector3<f64>,
}

/// Below this a face counts as untouched, and above one less this as covered.
const LEAST: f64 = 1e-9;

/// Fills `cuts` and `openings`, in the same order, with the faces along `axis` of this rank's cells that a particle (or an
/// image of it) covers; faces at borders of the box are not among them: what flows through those, the border says.
pub fn cuts<const D: usize>(
    grid: &Grid<D>,
    axis: usize,
    body: &Placed,
    cuts: &mut Vec<Cut>,
    openings: &mut Vec<Opening>,
) {
    cuts.clear();
    openings.clear();
    let mut from = grid.start;
    let mut to: [usize; D] = std::array::from_fn(|a| grid.start[a] + grid.local[a]);
    from[axis] += usize::from(grid.at_border(axis, 0));
    to[axis] += usize::from(!grid.at_border(axis, 1));
    let Placed { shape, centre, turn } = body;
    let bounds = shape.bounds(turn);
    let half = Vector3::from_fn(|a, _| if a < D { 0.5 * grid.h[a] } else { 0.0 });
    for image in images(grid, centre) {
        let place = |a: usize, x: f64| (x / grid.h[a] + if a == axis { 0.5 } else { 0.0 }).floor();
        let low = std::array::from_fn(|a| place(a, image[a] - bounds[a]));
        let high = std::array::from_fn(|a| place(a, image[a] + bounds[a]));
        for at in Block::between(low, high, from, to) {
            let middle = Vector3::from_fn(|a, _| match a {
                _ if a >= D => 0.0,
                _ if a == axis => at[a] as f64 * grid.h[a] - image[a],
                _ => (at[a] as f64 + 0.5) * grid.h[a] - image[a],
            });
            let (covered, open, moment) = covered_part::<D>(*shape, turn, &middle, &half);
            if covered < LEAST {
                continue;
            }
            let lever = shape.lever(turn, axis, &middle, &half, &moment);
            let face = (0..D).map(|a| (at[a] - grid.start[a] + grid.ghosts) * grid.stride[a]).sum::<usize>() as u32;
            let covered = if covered > 1.0 - LEAST { 1.0 } else { covered };
            cuts.push(Cut { covered, face, owned: grid.number_of(at).is_some() });
            openings.push(Opening { lever, open });
        }
    }
}

/// How much of the volume about a face is covered, where its open part has its centroid, from the face's centre (m), and the
/// first moment of the covered part per volume (m); `middle` is that centre's place from the particle's and `half` the volume's
/// half edges.
fn covered_part<const D: usize>(
    shape: &dyn Shape,
    turn: &Turn,
    middle: &Vector3<f64>,
    half: &Vector3<f64>,
) -> (f64, Vector3<f64>, Vector3<f64>) {
    if let Some(covered) = shape.whole_or_nothing(turn, middle, half) {
        return (covered, Vector3::zeros(), covered * middle);
    }
    let whole: f64 = (0..D).map(|a| 2.0 * half[a]).product();
    let (filled, moment) = shape.moments(turn, middle, half);
    let covered = (filled / whole).clamp(0.0, 1.0);
    if !(LEAST..=1.0 - LEAST).contains(&covered) {
        return (covered, Vector3::zeros(), covered * middle);
    }
    let open = |a: usize| if a < D { (covered * middle[a] - moment[a] / whole) / (1.0 - covered) } else { 0.0 };
    (covered, Vector3::from_fn(|a, _| open(a)), moment / whole)
}
