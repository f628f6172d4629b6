//! Apertures: how much of the faces of cells a particle covers, and where their open part lies.
//!
//! ```text
//!      +----|----+        covered: the particle's part of the volume from the middle of one cell to the middle of the
//!      |    |####|        next, exact. The sum over all faces along an axis is the particle's volume wherever it lies,
//!      o    | ###o        and no face opens or closes at once: the pressure on a moving particle stays calm.
//!      |    |  ##|
//!      +----|----+        lever: of the section in the face's own plane, covered part times its centroid
//! ```
//! The flux of a rotation `w` through a face is `(w x lever).n`: of a disc or sphere it displaces nothing, in every cell.
//! The section is what a chord (2D) or a disc (3D) of radius `c = sqrt(R^2 - x^2)` covers; the first moment of a disc
//! over X < x, Y < y, with `a = sqrt(c^2 - x^2)` and `t` the `y` within [-a, a], is `[ -a^2 (t + a) + (t^3 + a^3)/3 ]/2`.

use super::fraction::{rectangle_overlap, whole_or_nothing};
use super::reach::{Block, images};
use super::sphere;
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
    /// Covered part of the face's plane times the arm from the particle's centre (its nearest image) to its centroid (m).
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
    centre: &Vector3<f64>,
    radius: f64,
    cuts: &mut Vec<Cut>,
    openings: &mut Vec<Opening>,
) {
    cuts.clear();
    openings.clear();
    let mut from = grid.start;
    let mut to: [usize; D] = std::array::from_fn(|a| grid.start[a] + grid.local[a]);
    from[axis] += usize::from(grid.at_border(axis, 0));
    to[axis] += usize::from(!grid.at_border(axis, 1));
    let half = Vector3::from_fn(|a, _| if a < D { 0.5 * grid.h[a] } else { 0.0 });
    for image in images(grid, centre) {
        let place = |a: usize, x: f64| (x / grid.h[a] + if a == axis { 0.5 } else { 0.0 }).floor();
        let low = std::array::from_fn(|a| place(a, image[a] - radius));
        let high = std::array::from_fn(|a| place(a, image[a] + radius));
        for at in Block::between(low, high, from, to) {
            let middle = Vector3::from_fn(|a, _| match a {
                _ if a >= D => 0.0,
                _ if a == axis => at[a] as f64 * grid.h[a] - image[a],
                _ => (at[a] as f64 + 0.5) * grid.h[a] - image[a],
            });
            let (covered, open) = covered_part::<D>(&middle, &half, radius);
            if covered < LEAST {
                continue;
            }
            let (section, centroid) = section(grid, axis, &middle, radius);
            let face = (0..D).map(|a| (at[a] - grid.start[a] + grid.ghosts) * grid.stride[a]).sum::<usize>() as u32;
            let covered = if covered > 1.0 - LEAST { 1.0 } else { covered };
            cuts.push(Cut { covered, face, owned: grid.number_of(at).is_some() });
            openings.push(Opening { lever: section * centroid, open });
        }
    }
}

/// How much of the volume about a face is covered, and where its open part has its centroid, from the face's centre (m); `middle`
/// is that centre's place from the particle's and `half` the volume's half edges.
fn covered_part<const D: usize>(middle: &Vector3<f64>, half: &Vector3<f64>, radius: f64) -> (f64, Vector3<f64>) {
    if let Some(covered) = whole_or_nothing(middle, half, radius) {
        return (covered, Vector3::zeros());
    }
    let (low, high) = (middle - half, middle + half);
    let whole: f64 = (0..D).map(|a| 2.0 * half[a]).product();
    let (filled, moment) = if D == 3 {
        sphere::box_moments(&low, &high, radius)
    } else {
        let (x, y) = ([low.x, high.x], [low.y, high.y]);
        let moments = Vector3::new(rectangle_moment(x, y, radius), rectangle_moment(y, x, radius), 0.0);
        (rectangle_overlap(x, y, radius), moments)
    };
    let covered = (filled / whole).clamp(0.0, 1.0);
    if !(LEAST..=1.0 - LEAST).contains(&covered) {
        return (covered, Vector3::zeros());
    }
    let open = |a: usize| if a < D { (covered * middle[a] - moment[a] / whole) / (1.0 - covered) } else { 0.0 };
    (covered, Vector3::from_fn(|a, _| open(a)))
}

/// Part of the face with its centre at `middle` (m, from the particle's) that the particle covers in its plane, and the
/// centroid of that part (m, likewise).
fn section<const D: usize>(grid: &Grid<D>, axis: usize, middle: &Vector3<f64>, radius: f64) -> (f64, Vector3<f64>) {
    let c = (radius * radius - middle[axis] * middle[axis]).max(0.0).sqrt();
    let mut centroid = *middle;
    let edge = |a: usize| [middle[a] - 0.5 * grid.h[a], middle[a] + 0.5 * grid.h[a]];
    if D == 2 {
        let a = 1 - axis;
        let [low, high] = edge(a);
        let (low, high) = (low.max(-c), high.min(c));
        if high > low {
            centroid[a] = 0.5 * (low + high);
        }
        return ((high - low).max(0.0) / grid.h[a], centroid);
    }
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    let (x, y) = (edge(a), edge(b));
    let area = rectangle_overlap(x, y, c);
    let part = area / (grid.h[a] * grid.h[b]);
    if part > LEAST {
        centroid[a] = rectangle_moment(x, y, c) / area;
        centroid[b] = rectangle_moment(y, x, c) / area;
    }
    (part, centroid)
}

/// Integral of X over the disc of radius `c` at the origin inside the rectangle `x` by `y` (m3).
pub(super) fn rectangle_moment(x: [f64; 2], y: [f64; 2], c: f64) -> f64 {
    let quadrant = |i: usize, j: usize| {
        let square = c * c - x[i] * x[i];
        if square <= 0.0 {
            return 0.0;
        }
        let a = square.sqrt();
        let t = y[j].clamp(-a, a);
        0.5 * (-square * (t + a) + (t * t * t + a * a * a) / 3.0)
    };
    quadrant(1, 1) - quadrant(0, 1) - quadrant(1, 0) + quadrant(0, 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_moment_of_a_rectangle_agrees_with_counting_points() {
        let (x, y, c) = ([0.1, 0.75], [-0.2, 0.6], 0.8);
        let n = 1000;
        let at = |s: [f64; 2], k: usize| s[0] + (s[1] - s[0]) * (k as f64 + 0.5) / n as f64;
        let points = (0..n * n).map(|k| (at(x, k % n), at(y, k / n)));
        let sum: f64 = points.filter(|(x, y)| x.hypot(*y) < c).map(|(x, _)| x).sum();
        let counted = sum / (n * n) as f64 * (x[1] - x[0]) * (y[1] - y[0]);
        assert!((rectangle_moment(x, y, c) - counted).abs() < 1e-5);
    }
}
