//! The solid below heights, as an outline (2D) or a closed surface (3D).
//!
//! ```text
//!      given  o----o-----o                       periodic  |o----o-----o  |
//!   ----------´           `-----------  goes on            |            `.| from the last point to
//!   :   :  | the box |  :   :                              | the period   | the first
//!   `------------------------------´  closed far below
//! ```

use super::wall::Form;
use mics_shapes::Extent;
use nalgebra::Vector3;

/// Part of a period by which heights at its two ends may differ.
const ALIKE: f64 = 1e-6;
/// Part of the range of heights within which two differences count as equal: digits of a file.
const ROUNDED: f64 = 1e-9;

/// Heights over a line (one y) or a raster (m).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Raster {
    /// Coordinates along x, increasing.
    pub x: Vec<f64>,
    /// Coordinates along y, increasing; a single one for a line.
    pub y: Vec<f64>,
    /// Heights, x fastest.
    pub heights: Vec<f64>,
}

/// A place along an axis: its coordinate (m) and the two given ones that it lies between, with the
/// share of the second.
#[derive(Clone, Copy)]
struct At {
    place: f64,
    between: [usize; 2],
    share: f64,
}

impl At {
    fn new(given: &[f64], place: f64, period: Option<f64>) -> At {
        let last = given.len() - 1;
        let next = given.partition_point(|x| *x <= place);
        let (low, high, between) = match (next, period) {
            (0, None) => (0.0, 1.0, [0, 0]),
            (n, None) if n > last => (0.0, 1.0, [last, last]),
            (0, Some(length)) => (given[last] - length, given[0], [last, 0]),
            (n, Some(length)) if n > last => (given[last], given[0] + length, [last, 0]),
            (n, _) => (given[n - 1], given[n], [n - 1, n]),
        };
        let share = if high > low { ((place - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
        At { place, between, share }
    }
}

/// The places along an axis at which the ground has a corner: the ends of the period, or half a
/// length of the box beyond its sides, and the given places between these ends.
fn places(given: &[f64], size: f64, periodic: bool) -> Vec<At> {
    let ends = if periodic { [0.0, size] } else { [-0.5 * size, 1.5 * size] };
    let near = 1e-6 * size;
    let within = given.iter().copied().filter(|x| (ends[0] + near..=ends[1] - near).contains(x));
    let all = [ends[0]].into_iter().chain(within).chain([ends[1]]);
    all.map(|place| At::new(given, place, periodic.then_some(size))).collect()
}

impl Raster {
    fn height(&self, x: &At, y: &At) -> f64 {
        let row = |j: usize| {
            let at = |i: usize| self.heights[i + self.x.len() * j];
            (1.0 - x.share) * at(x.between[0]) + x.share * at(x.between[1])
        };
        (1.0 - y.share) * row(y.between[0]) + y.share * row(y.between[1])
    }

    /// Message where the heights at both ends of a period differ.
    fn torn(&self, x: &[At], y: &[At], room: &Extent) -> Option<String> {
        let ends = |all: &[At]| [all[0], all[all.len() - 1]];
        let told = |[a, b]: [f64; 2], axis: usize| {
            (room.periodic[axis] && (a - b).abs() > ALIKE * room.size[axis]).then(|| {
                format!(
                    "goes from a height of {a} m to {b} m along a period in {}: both ends must be \
                     alike; or leave the last points out, and it goes on to the first",
                    ["x", "y"][axis]
                )
            })
        };
        let along_x = y.iter().find_map(|y| told(ends(x).map(|x| self.height(&x, y)), 0));
        along_x.or_else(|| x.iter().find_map(|x| told(ends(y).map(|y| self.height(x, &y)), 1)))
    }

    /// Message where none of the heights is over the box; they are moved by `shift` (m) already.
    fn misses(&self, shift: &Vector3<f64>, dimension: usize, room: &Extent) -> Option<String> {
        let given = [&self.x, &self.y];
        given.iter().enumerate().find_map(|(axis, own)| {
            let low = own[0];
            let high = own[own.len() - 1];
            let size = room.size[axis];
            let x = ["x", "y"][axis];
            let begin = |a: usize| shift[a] - if a < dimension - 1 { given[a][0] } else { 0.0 };
            let begin: Vec<f64> = (0..dimension).map(begin).collect();
            // A single height holds along the whole axis.
            (own.len() > 1 && (high < 0.0 || low > size)).then(|| {
                format!(
                    "goes from {low:?} to {high:?} m along {x}, and the box from 0 to {size:?} m: \
                     set position, the place in the box of the origin of its numbers ({begin:?} \
                     puts its corner into that of the box), or scale = 0.001 for mm"
                )
            })
        })
    }

    /// The solid below the heights, moved by a vector (m), in a room of so many dimensions.
    ///
    /// # Errors
    /// When none of it is over the box or it does not fit a period, in words.
    pub fn form(
        mut self,
        dimension: usize,
        shift: &Vector3<f64>,
        room: &Extent,
    ) -> Result<Form, String> {
        self.x.iter_mut().for_each(|x| *x += shift.x);
        self.y.iter_mut().for_each(|y| *y += shift.y);
        self.heights.iter_mut().for_each(|h| *h += shift[dimension - 1]);
        if let Some(why) = self.misses(shift, dimension, room) {
            return Err(why);
        }
        let x = places(&self.x, room.size.x, room.periodic[0]);
        let deep = -room.size[dimension - 1];
        if dimension == 2 {
            let only = [At { place: 0.0, between: [0, 0], share: 0.0 }];
            if let Some(why) = self.torn(&x, &only, room) {
                return Err(why);
            }
            let top = x.iter().rev().map(|x| [x.place, self.height(x, &only[0])]);
            let corners = [[x[0].place, deep], [x[x.len() - 1].place, deep]];
            return Ok(Form::Outlines(vec![corners.into_iter().chain(top).collect()]));
        }
        let y = places(&self.y, room.size.y, room.periodic[1]);
        if let Some(why) = self.torn(&x, &y, room) {
            return Err(why);
        }
        Ok(self.closed(&x, &y, deep))
    }

    /// The ground over these places, closed by walls down to a plane at `deep` (m).
    fn closed(&self, x: &[At], y: &[At], deep: f64) -> Form {
        let n = x.len();
        let m = y.len();
        let mut points: Vec<[f64; 3]> = y
            .iter()
            .flat_map(|y| x.iter().map(|x| [x.place, y.place, self.height(x, y)]))
            .collect();
        let at = |i: usize, j: usize| i + n * j;
        let heights = || points.iter().map(|p| p[2]);
        let range =
            heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min);
        let mut triangles = Vec::with_capacity(2 * (n - 1) * (m - 1) + 6 * (n + m));
        for j in 0..m - 1 {
            for i in 0..n - 1 {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                // Along the diagonal that bends less, so that ridges and furrows stay whole; of two
                // that bend alike, as rounded heights often do, always the same.
                let bend = |p: usize, q: usize| (points[p][2] - points[q][2]).abs();
                if bend(a, c) <= bend(b, d) + ROUNDED * range {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, b, d], [b, c, d]]);
                }
            }
        }
        // Counterclockwise seen from above.
        let south = (0..n).map(|i| at(i, 0));
        let east = (1..m).map(|j| at(n - 1, j));
        let north = (0..n - 1).rev().map(|i| at(i, m - 1));
        let west = (1..m - 1).rev().map(|j| at(0, j));
        let rim: Vec<usize> = south.chain(east).chain(north).chain(west).collect();
        let below = points.len();
        for k in &rim {
            let [x, y, _] = points[*k];
            points.push([x, y, deep]);
        }
        let bottom = points.len();
        let middle = points.iter().take(below).map(|p| Vector3::from(*p)).sum::<Vector3<f64>>();
        let middle = middle / below as f64;
        points.push([middle.x, middle.y, deep]);
        for k in 0..rim.len() {
            let next = (k + 1) % rim.len();
            let [a, b] = [rim[k], rim[next]];
            let [c, d] = [below + k, below + next];
            triangles.extend([[a, c, b], [b, c, d], [bottom, d, c]]);
        }
        Form::Surface { points, triangles }
    }
}
