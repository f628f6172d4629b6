//! Contour lines by marching squares: where a quantity, taken as linear along the sides of squares
//! of cell centres, has a level.
//!
//! ```text
//!   o---+----x    o  a centre under the level
//!   |    \   |    x  a centre at or over it
//!   |     \  |    +  a crossing, linear between the two centres
//!   o------+-x
//!   A square whose sides are crossed twice holds one part of a line, one whose sides are
//!   crossed four times (a saddle) two, by the side of the level that the mean of its centres is
//!   on. A square with a centre that has no value (in a body) holds none.
//! ```
//!
//! From the outermost centres to the edge of the plane the quantity is constant, as in
//! [`sample`](super::trace::sample).

use std::collections::BTreeMap;

use super::trace::Point;
use super::{Disc, Plane};

/// The lines of a level, each from one end to the other, or closed with its last point on its
/// first; the same lines for the same plane. None passes beside a value that is not finite.
pub fn contours(plane: &Plane, values: &[f64], level: f64) -> Vec<Vec<Point>> {
    let nodes = Nodes { plane, values };
    let mut links = nodes.links(level);
    // Lines with ends first: begun elsewhere, they would fall in two.
    let ends: Vec<Side> =
        links.iter().filter(|(_, next)| next.len() == 1).map(|(side, _)| *side).collect();
    let all: Vec<Side> = links.keys().copied().collect();
    let mut lines = Vec::new();
    for start in ends.into_iter().chain(all) {
        if links.get(&start).is_some_and(|next| !next.is_empty()) {
            lines.push(
                follow(&mut links, start)
                    .into_iter()
                    .map(|side| nodes.crossing(side, level))
                    .collect(),
            );
        }
    }
    lines
}

/// The parts of a line that lie outside all discs.
pub fn outside(line: Vec<Point>, discs: &[Disc]) -> Vec<Vec<Point>> {
    discs.iter().fold(vec![line], |parts, disc| {
        parts.iter().flat_map(|part| outside_of(part, disc)).collect()
    })
}

/// A side of a square: the node it begins at, and the axis that it runs along.
type Side = (usize, usize, usize);

/// Cell centres with a frame of nodes on the edges of the plane.
struct Nodes<'a> {
    plane: &'a Plane,
    values: &'a [f64],
}

impl Nodes<'_> {
    fn value(&self, i: usize, j: usize) -> f64 {
        let [columns, rows] = self.plane.cells;
        let [i, j] = [i.clamp(1, columns) - 1, j.clamp(1, rows) - 1];
        self.values[j * columns + i]
    }

    fn place(&self, i: usize, j: usize) -> Point {
        let along = |k: usize, axis: usize| {
            let cells = self.plane.cells[axis] as f64;
            let size = self.plane.size[axis];
            ((k as f64 - 0.5) * size / cells).clamp(0.0, size)
        };
        [along(i, 0), along(j, 1)]
    }

    fn crossing(&self, side: Side, level: f64) -> Point {
        let (i, j, axis) = side;
        let next_i = i + 1 - axis;
        let next_j = j + axis;
        let a = self.value(i, j);
        let b = self.value(next_i, next_j);
        let from = self.place(i, j);
        let to = self.place(next_i, next_j);
        let part = (level - a) / (b - a);
        [0, 1].map(|k| from[k] + part * (to[k] - from[k]))
    }

    /// Every side that the level crosses, and those of its squares that a line goes on to from
    /// there.
    fn links(&self, level: f64) -> BTreeMap<Side, Vec<Side>> {
        let mut links: BTreeMap<Side, Vec<Side>> = BTreeMap::new();
        let [columns, rows] = self.plane.cells;
        for (i, j) in (0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j))) {
            let corners =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.value(i, j));
            if !corners.iter().all(|value| value.is_finite()) {
                continue;
            }
            let over = corners.map(|value| value >= level);
            // Side k is between corners k and k + 1.
            let sides = [(i, j, 0), (i + 1, j, 1), (i, j + 1, 0), (i, j, 1)];
            let crossed: Vec<Side> =
                (0..4).filter(|k| over[*k] != over[(k + 1) % 4]).map(|k| sides[k]).collect();
            let middle_over = corners.iter().sum::<f64>() / 4.0 >= level;
            let parts = match crossed[..] {
                [a, b] => vec![(a, b)],
                // Corners 0 and 2 are joined through the middle, or cut off.
                [a, b, c, d] if middle_over == over[0] => vec![(a, b), (c, d)],
                [a, b, c, d] => vec![(d, a), (b, c)],
                _ => Vec::new(),
            };
            for (a, b) in parts {
                links.entry(a).or_default().push(b);
                links.entry(b).or_default().push(a);
            }
        }
        links
    }
}

/// Takes a line out of the links, from a side on.
fn follow(links: &mut BTreeMap<Side, Vec<Side>>, start: Side) -> Vec<Side> {
    let mut line = vec![start];
    let mut at = start;
    while let Some(next) = links.get_mut(&at).and_then(Vec::pop) {
        if let Some(back) = links.get_mut(&next) {
            back.retain(|side| *side != at);
        }
        line.push(next);
        at = next;
    }
    line
}

/// The parts of a line that lie outside a disc.
fn outside_of(line: &[Point], disc: &Disc) -> Vec<Vec<Point>> {
    let mut parts = vec![Vec::new()];
    for pair in line.windows(2).filter(|pair| pair[0] != pair[1]) {
        let at = |part: f64| [0, 1].map(|k| pair[0][k] + part * (pair[1][k] - pair[0][k]));
        let (enters, leaves) = disc.covered(pair[0], pair[1]).unwrap_or((1.0, 1.0));
        let mut add = |from: f64, to: f64| {
            let Some(part) = parts.last_mut().filter(|_| to > from) else { return };
            if part.is_empty() {
                part.push(at(from));
            }
            part.push(at(to));
        };
        add(0.0, enters);
        if leaves > enters {
            parts.push(Vec::new());
            let Some(part) = parts.last_mut().filter(|_| leaves < 1.0) else { continue };
            part.extend([at(leaves), at(1.0)]);
        }
    }
    parts.retain(|part| part.len() > 1);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::trace::distance;
    use std::f64::consts::TAU;

    /// A plane of 2 x 2 around its middle, with a value of each cell's centre.
    fn plane(cells: usize, value: impl Fn(f64, f64) -> f64) -> Plane {
        let centre = |k: usize| (k as f64 + 0.5) * 2.0 / cells as f64 - 1.0;
        let values = (0..cells * cells).map(|k| value(centre(k % cells), centre(k / cells)));
        Plane { cells: [cells; 2], size: [2.0; 2], values: values.collect(), ..Plane::default() }
    }

    fn lines(plane: &Plane, level: f64) -> Vec<Vec<Point>> {
        contours(plane, &plane.values, level)
    }

    fn length(line: &[Point]) -> f64 {
        line.windows(2).map(|pair| distance(pair[0], pair[1])).sum()
    }

    fn radius(at: Point) -> f64 {
        distance(at, [1.0, 1.0])
    }

    #[test]
    fn contour_of_radius_is_closed_circle() {
        for (cells, error) in [(20, 2e-2), (80, 1.5e-3)] {
            let all = lines(&plane(cells, |x: f64, y: f64| x.hypot(y)), 0.5);
            assert_eq!(all.len(), 1);
            let circle = &all[0];
            assert_eq!(circle.first(), circle.last());
            assert!((length(circle) / (0.5 * TAU) - 1.0).abs() < error, "{}", length(circle));
            assert!(circle.iter().all(|at| (radius(*at) - 0.5).abs() < error));
        }
    }

    #[test]
    fn contour_from_edge_to_edge_and_level_out_of_range() {
        let slope = plane(10, |x, y| x + 0.3 * y);
        let all = lines(&slope, 0.123);
        assert_eq!(all.len(), 1);
        let mut ends = [all[0][0][1], all[0][all[0].len() - 1][1]];
        ends.sort_by(f64::total_cmp);
        assert_eq!(ends, [0.0, 2.0]);
        let inner = all[0].iter().filter(|at| (0.1..=1.9).contains(&at[1]));
        assert!(inner.clone().count() > 10);
        inner.for_each(|at| {
            assert!((at[0] - 1.0 + 0.3 * (at[1] - 1.0) - 0.123).abs() < 1e-12, "{at:?}")
        });
        assert!(lines(&slope, 9.0).is_empty());
    }

    #[test]
    fn contours_of_many_hills_never_branch() {
        let hills = plane(40, |x, y| (9.0 * x).sin() * (11.0 * y).cos() + 0.02 * (x - y));
        for level in [-0.5, 0.0, 0.02, 0.5] {
            let all = lines(&hills, level);
            let crossings = Nodes { plane: &hills, values: &hills.values }.links(level).len();
            let closed = all.iter().filter(|line| line.first() == line.last()).count();
            assert_eq!(
                all.iter().map(Vec::len).sum::<usize>() - closed,
                crossings,
                "level {level}"
            );
            let edge = |at: &Point| at.iter().any(|x| *x == 0.0 || *x == 2.0);
            assert!(all.iter().all(|line| line.first() == line.last()
                || (edge(&line[0]) && edge(&line[line.len() - 1]))));
        }
    }

    #[test]
    fn contour_at_saddle_by_centre_value() {
        let saddle = |middle: f64| Plane {
            cells: [2, 2],
            size: [2.0, 2.0],
            values: vec![1.0 + middle, -1.0 + middle, -1.0 + middle, 1.0 + middle],
            ..Plane::default()
        };
        for (middle, joined) in [(0.1, true), (-0.1, false)] {
            // Whether the high corners, at (0.5, 0.5) and (1.5, 1.5), are on one side of both
            // lines.
            let all = lines(&saddle(middle), 0.0);
            assert_eq!(all.len(), 2);
            let low_corner_cut_off = all
                .iter()
                .all(|line| line.iter().all(|[x, y]| x > y) || line.iter().all(|[x, y]| x < y));
            assert_eq!(low_corner_cut_off, joined, "{all:?}");
        }
    }

    #[test]
    fn contour_avoids_cells_without_value() {
        let hole = |x: f64, y: f64| x.hypot(y - 0.5) < 0.3;
        let ring = plane(40, |x: f64, y: f64| if hole(x, y) { f64::NAN } else { x.hypot(y) });
        let all = lines(&ring, 0.5);
        assert!(
            !all.is_empty() && all.iter().all(|line| line.first() != line.last()),
            "the circle is open"
        );
        assert!(all.iter().flatten().all(|[x, y]| !hole(x - 1.0, y - 1.0)));
        // Half of it and more is still there.
        assert!(all.iter().map(|line| length(line)).sum::<f64>() > 0.6 * 0.5 * TAU);
    }

    #[test]
    fn contour_is_cut_by_disc() {
        let disc = |x: f64, radius: f64| Disc { centre: [x, 0.0], radius, ..Disc::default() };
        let line = vec![[-2.0, 0.0], [-0.2, 0.0], [0.1, 0.0], [0.1, 0.0], [2.0, 0.0], [3.0, 0.0]];
        let parts = outside(line.clone(), &[disc(0.0, 0.5)]);
        assert_eq!(parts.len(), 2);
        let near = |a: &[Point], b: &[Point]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| distance(*a, *b) < 1e-12)
        };
        assert!(
            near(&parts[0], &[[-2.0, 0.0], [-0.5, 0.0]])
                && near(&parts[1], &[[0.5, 0.0], [2.0, 0.0], [3.0, 0.0]])
        );
        assert_eq!(outside(line.clone(), &[disc(9.0, 0.5)]).concat().len(), 5, "{line:?}");
        assert!(outside(line.clone(), &[disc(0.0, 4.0)]).is_empty());
        // From within one disc through the next.
        let parts = outside(line, &[disc(-2.0, 0.5), disc(1.0, 0.25), disc(3.0, 0.5)]);
        assert!(near(&parts[0][..1], &[[-1.5, 0.0]]) && parts.len() == 2);
        assert!((parts.iter().map(|part| length(part)).sum::<f64>() - 3.5).abs() < 1e-12);
    }
}
