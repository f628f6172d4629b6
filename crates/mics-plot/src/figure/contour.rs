//! Contour lines of a quantity, by marching squares of the crate `contour`.
//!
//! ```text
//!   o---+----x    o  a centre under the level      the crate closes lines along the edges of the
//!   |    \   |    x  a centre at or over it        plane: these parts are taken out again, and
//!   |     \  |    +  a crossing, linear            those beside a centre that has no value (in a
//!   o------+-x                                     body)
//! ```
//! From the outermost centres to the edge of the plane lines go on across it.

use super::trace::Point;
use super::{Disc, Plane};
use contour::ContourBuilder;

/// The lines of a level, each from one end to the other, or closed with its last point on its
/// first. None passes beside a value that is not finite.
pub fn contours(plane: &Plane, values: &[f64], level: f64) -> Vec<Vec<Point>> {
    let [columns, rows] = plane.cells;
    // It refuses only values that do not fill the cells.
    let Ok(lines) = ContourBuilder::new(columns, rows, true).lines(values, &[level]) else {
        return Vec::new();
    };
    let rings = lines.iter().flat_map(|line| line.geometry());
    rings.flat_map(|ring| parts(plane, ring.coords().map(|at| [at.x, at.y]).collect())).collect()
}

/// The parts of a ring, in cells, that run within the plane and have places, in its coordinates.
fn parts(plane: &Plane, mut ring: Vec<Point>) -> Vec<Vec<Point>> {
    let cells = plane.cells.map(|count| count as f64);
    let edge = |at: &Point| (0..2).any(|k| at[k] == 0.0 || at[k] == cells[k]);
    let is_within = |at: &Point| at.iter().all(|x| x.is_finite()) && !edge(at);
    if let Some(end) = ring.iter().position(|at| !is_within(at)) {
        // From a point that is taken out, so that no part is cut where the ring begins.
        ring.pop();
        ring.rotate_left(end);
        ring.push(ring[0]);
    }
    let runs = ring.chunk_by(|a, b| is_within(a) == is_within(b));
    let mut begin = 0_usize;
    let mut all = Vec::new();
    for run in runs {
        let around = [begin.checked_sub(1), Some(begin + run.len())];
        begin += run.len();
        if !is_within(&run[0]) {
            continue;
        }
        // On to the edge, where the ring went on along it.
        let [before, after] = around.map(|k| {
            let next = ring.get(k?).filter(|at| edge(at))?;
            let last = if k? < begin { run[0] } else { run[run.len() - 1] };
            let onto = |k: usize| {
                if next[k] == 0.0 || next[k] == cells[k] { next[k] } else { last[k] }
            };
            Some([onto(0), onto(1)])
        });
        let line = before.into_iter().chain(run.iter().copied()).chain(after);
        let place = |at: Point| [0, 1].map(|k| at[k] * plane.size[k] / cells[k]);
        all.push(line.map(place).collect::<Vec<_>>());
    }
    all.retain(|line| line.len() > 1);
    all
}

/// The parts of a line that lie outside all discs.
pub fn outside(line: Vec<Point>, discs: &[Disc]) -> Vec<Vec<Point>> {
    discs.iter().fold(vec![line], |parts, disc| {
        parts.iter().flat_map(|part| outside_of(part, disc)).collect()
    })
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
