//! Obstacles, as a plane cuts them: what is solid in the picture, bounded by rings.
//!
//! ```text
//!    +-----------+      segments with the solid on their left, cut off at the sides of the picture
//!    |  .-->-.   |      and joined to chains; one that ends on a side goes on along it, with the
//!    +-'#####'---+      solid on the left, to where the next one begins
//! ```

use mics_run::bodies::Pose;
use mics_run::config::{Case, Wall};
use nalgebra::Vector3;

type Point = [f64; 2];

/// Largest distance of two ends that meet, relative to the picture's size.
const MEETS: f64 = 1e-7;

/// The rings that bound the solid part of a wall in the plane across an axis at a height (m), in a
/// picture of this size (m): in the plane's coordinates, outer ones counterclockwise.
pub fn rings(
    case: &Case,
    wall: &Wall,
    pose: Option<Pose>,
    axes: [usize; 2],
    height: f64,
    size: Point,
) -> Vec<Vec<Point>> {
    let geometry = wall.geometry();
    let across = 3 - axes[0] - axes[1];
    let own = |a: usize| wall.centre().get(a).copied().unwrap_or(0.0);
    let centre = pose.map_or_else(|| Vector3::from_fn(|a, _| own(a)), |pose| pose.centre.into());
    let turn = pose.and_then(|pose| pose.orientation).unwrap_or_default();
    let near = MEETS * size[0].max(size[1]);
    let mut segments = Vec::new();
    for t in geometry.walls() {
        let corners = t.map(|x| centre + turn * x);
        let ends = if case.dimension() == 2 {
            Some([corners[0], corners[1]])
        } else {
            super::outline::cut(&corners, across, height)
        };
        let Some(mut ends) = ends.map(|ends| ends.map(|x| axes.map(|a| x[a]))) else { continue };
        if case.dimension() == 3 {
            let out = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            let [[x, y], [to_x, to_y]] = ends;
            if out[axes[1]] * (to_x - x) - out[axes[0]] * (to_y - y) > 0.0 {
                ends.reverse();
            }
        }
        segments.extend(clipped(ends, size).filter(|[a, b]| apart(*a, *b) > 1e-3 * near));
    }
    let (mut rings, open): (Vec<_>, Vec<_>) =
        chains(segments, near).into_iter().partition(|c| apart(c[0], c[c.len() - 1]) <= near);
    if open.is_empty() {
        // All around the picture there is the same: a little inside the middle of its low side.
        let mut place = [0.0; 3];
        place[axes[0]] = 0.5 * size[0];
        place[axes[1]] = near;
        place[across] = height;
        if wall.nearest(&place[..case.dimension()]).distance < 0.0 {
            rings.insert(0, vec![[0.0, 0.0], [size[0], 0.0], size, [0.0, size[1]]]);
        }
    }
    rings.extend(closed(open, size, near));
    rings
}

fn apart(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The part of a segment that lies in the picture.
fn clipped([a, b]: [Point; 2], size: Point) -> Option<[Point; 2]> {
    let mut from = 0.0_f64;
    let mut to = 1.0_f64;
    for k in 0..2 {
        let way = b[k] - a[k];
        for (side, sign) in [(0.0, 1.0), (size[k], -1.0)] {
            let inwards = sign * way;
            let off = sign * (a[k] - side);
            if inwards == 0.0 {
                if off < 0.0 {
                    return None;
                }
            } else if inwards > 0.0 {
                from = from.max(-off / inwards);
            } else {
                to = to.min(-off / inwards);
            }
        }
    }
    let at = |part: f64| [0, 1].map(|k| (a[k] + part * (b[k] - a[k])).clamp(0.0, size[k]));
    (from < to).then(|| [at(from), at(to)])
}

/// Joins segments, each to the one that begins where it ends.
fn chains(mut segments: Vec<[Point; 2]>, near: f64) -> Vec<Vec<Point>> {
    let mut chains = Vec::new();
    while let Some([first, second]) = segments.pop() {
        let mut chain = std::collections::VecDeque::from([first, second]);
        loop {
            let begin = chain[0];
            let end = chain[chain.len() - 1];
            if let Some(k) = segments.iter().position(|[a, _]| apart(*a, end) <= near) {
                chain.push_back(segments.swap_remove(k)[1]);
            } else if let Some(k) = segments.iter().position(|[_, b]| apart(*b, begin) <= near) {
                chain.push_front(segments.swap_remove(k)[0]);
            } else {
                break;
            }
        }
        chains.push(chain.into());
    }
    chains
}

/// Closes chains that begin and end on the sides of the picture, along these.
fn closed(mut open: Vec<Vec<Point>>, size: Point, near: f64) -> Vec<Vec<Point>> {
    let around = 2.0 * (size[0] + size[1]);
    // Distance counterclockwise along the sides from the low corner.
    let along = |[x, y]: Point| {
        let [right, above] = [size[0] - x, size[1] - y];
        let ways =
            [(y, x), (right, size[0] + y), (above, size[0] + size[1] + right), (x, around - y)];
        ways.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |way| way.1)
    };
    let corners = [
        (0.0, [0.0, 0.0]),
        (size[0], [size[0], 0.0]),
        (size[0] + size[1], size),
        (around - size[1], [0.0, size[1]]),
    ];
    let mut rings = Vec::new();
    while let Some(mut ring) = open.pop() {
        loop {
            let from = along(ring[ring.len() - 1]);
            let ahead = |to: f64| {
                let way = (to - from).rem_euclid(around);
                if way > around - near { 0.0 } else { way }
            };
            let own = ahead(along(ring[0]));
            let next = open.iter().enumerate().map(|(k, chain)| (ahead(along(chain[0])), k));
            let next = next.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(way, _)| *way < own);
            let way = next.map_or(own, |(way, _)| way);
            let mut passed: Vec<_> = corners
                .iter()
                .map(|(at, corner)| (ahead(*at), *corner))
                .filter(|(to, _)| *to > 0.0 && *to < way)
                .collect();
            passed.sort_by(|a, b| a.0.total_cmp(&b.0));
            ring.extend(passed.into_iter().map(|(_, corner)| corner));
            match next {
                Some((_, k)) => ring.extend(open.swap_remove(k)),
                None => break,
            }
        }
        rings.push(ring);
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(dimension: usize, obstacle: &str) -> Case {
        let (size, more) = match dimension {
            2 => ("[2.0, 1.0]", ""),
            _ => ("[2.0, 1.0, 1.0]", "bottom = \"wall\"\ntop = \"wall\"\n"),
        };
        let cells = size.replace(".0", "0");
        mics_run::config::written(&format!(
            "name = \"t\"\ntime.end = 1.0\ndomain = {{ size = {size}, cells = {cells} }}\n\
            fluid = {{ density = 1.0, viscosity = 0.1 }}\n[boundary]\nwest = \"periodic\"\n\
            east = \"periodic\"\nsouth = \"wall\"\nnorth = \"wall\"\n{more}[[obstacle]]\n\
            {obstacle}\n"
        ))
        .unwrap()
    }

    fn area(ring: &[Point]) -> f64 {
        let next = ring.iter().cycle().skip(1);
        0.5 * ring.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
    }

    fn solid(case: &Case, axes: [usize; 2], height: f64) -> (usize, f64) {
        let size = axes.map(|a| case.domain.size[a]);
        let all = rings(case, case.obstacle[0].wall(), None, axes, height, size);
        (all.len(), all.iter().map(|ring| area(ring)).sum())
    }

    #[test]
    fn solid_of_picture_is_that_of_outlines_and_surfaces() {
        let line = "heights = { points = [[0.5, 0.2], [1.5, 0.6]] }";
        let (count, area) = solid(&case(2, line), [0, 1], 0.0);
        assert!(count == 1 && (area - 0.8).abs() < 1e-9, "{area}");
        let hole = "polygon = { outlines = [[[0, 0], [2, 0], [2, 1], [0, 1]], \
            [[0.5, 0.25], [1.5, 0.25], [1.5, 0.75], [0.5, 0.75]]] }";
        let (count, area) = solid(&case(2, hole), [0, 1], 0.0);
        assert!(count == 2 && (area - 1.5).abs() < 1e-9, "{area}");
        let step = "polygon = { points = [[0.5, -1], [1.5, -1], [1.5, 2], [1.2, 2], [1.2, 0.5], \
            [0.5, 0.5]] }";
        let (count, area) = solid(&case(2, step), [0, 1], 0.0);
        assert!(count == 1 && (area - 0.65).abs() < 1e-9, "{area}");
        let wedge = "surface = { points = [[0, -1, 0], [2, -1, 0], [2, 2, 0], [0, 2, 0], \
            [0, -1, 0.5], [0, 2, 0.5], [2, -1, 0.5], [2, 2, 0.5]], \
            triangles = [[0, 2, 1], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 1, 6], [0, 6, 4], \
            [3, 7, 2], [3, 5, 7], [0, 4, 5], [0, 5, 3], [1, 2, 7], [1, 7, 6]] }";
        let slab = case(3, wedge);
        for (axes, height, exact) in [([0, 2], 0.5, 1.0), ([1, 2], 0.7, 0.5), ([0, 1], 0.3, 2.0)] {
            let (_, area) = solid(&slab, axes, height);
            assert!((area - exact).abs() < 1e-9, "{axes:?} {area}");
        }
        assert_eq!(solid(&slab, [0, 1], 0.7).0, 0);
    }
}
