//! Outlines of polygons: whether they are simple and convex.

/// Fault of an outline, and the corner at which it is.
pub(in crate::config) struct Flaw {
    /// The corner, from 0.
    pub corner: usize,
    /// The fault, in words.
    pub what: String,
}

/// Checks that points (m), in order and either way round, are the corners of a convex polygon.
pub(super) fn convex(points: &[[f64; 2]]) -> Result<(), Flaw> {
    simple(points)?;
    let count = points.len();
    let span = span(points);
    let sense = area(points).signum();
    let bent =
        |k: &usize| sense * cross(edge(points, *k), edge(points, *k + 1)) < -1e-9 * span * span;
    match (0..count).find(bent) {
        Some(k) => Err(Flaw {
            corner: (k + 1) % count,
            what: "the outline is not convex here: leave the corner out, or make a clump of discs"
                .to_owned(),
        }),
        None => Ok(()),
    }
}

/// Largest width along an axis (m).
fn span(points: &[[f64; 2]]) -> f64 {
    let width = |a: usize| {
        let along = points.iter().map(|p| p[a]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    width(0).max(width(1))
}

fn edge(points: &[[f64; 2]], k: usize) -> [f64; 2] {
    let a = points[k % points.len()];
    let b = points[(k + 1) % points.len()];
    [b[0] - a[0], b[1] - a[1]]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Area within an outline (m2), negative where it runs clockwise.
fn area(points: &[[f64; 2]]) -> f64 {
    // About the first corner, so that a place far away leaves no rounding.
    let arm = |p: [f64; 2]| [p[0] - points[0][0], p[1] - points[0][1]];
    let count = points.len();
    (0..count).map(|k| 0.5 * cross(arm(points[k]), arm(points[(k + 1) % count]))).sum()
}

/// Outlines (m), those within an odd number of others turned into holes: clockwise, all others
/// counterclockwise.
pub(in crate::config) fn nested(mut outlines: Vec<Vec<[f64; 2]>>) -> Vec<Vec<[f64; 2]>> {
    let within = |outline: &[[f64; 2]], [x, y]: [f64; 2]| {
        let crosses = |k: &usize| {
            let a = outline[*k];
            let [dx, dy] = edge(outline, *k);
            (a[1] > y) != (a[1] + dy > y) && x < a[0] + (y - a[1]) / dy * dx
        };
        (0..outline.len()).filter(crosses).count() % 2 == 1
    };
    let holes: Vec<bool> = (0..outlines.len())
        .map(|k| {
            let first = outlines[k][0];
            let others = outlines.iter().enumerate().filter(|(j, _)| *j != k);
            others.filter(|(_, other)| within(other, first)).count() % 2 == 1
        })
        .collect();
    for (outline, hole) in outlines.iter_mut().zip(holes) {
        if (area(outline) < 0.0) != hole {
            outline.reverse();
        }
    }
    outlines
}

/// Checks that points (m), in order and either way round, are the corners of an outline that does
/// not cross itself.
pub(in crate::config) fn simple(points: &[[f64; 2]]) -> Result<(), Flaw> {
    let count = points.len();
    let flaw = |corner: usize, what: String| Err(Flaw { corner, what });
    if count < 3 {
        return flaw(
            count.saturating_sub(1),
            format!("{count} points make no polygon: give 3 or more"),
        );
    }
    let span = span(points);
    if let Some(k) = (0..count).find(|k| edge(points, *k).iter().all(|d| d.abs() <= 1e-9 * span)) {
        let what = "lies on the one before: an outline closes by itself, leave it out".to_owned();
        return flaw((k + 1) % count, what);
    }
    if let Some((_, later)) = crossing(points) {
        return flaw(
            later,
            "the outline crosses itself here: give its corners in order".to_owned(),
        );
    }
    if area(points).abs() <= 1e-9 * span * span {
        return flaw(0, "all points lie on a line, which has no area".to_owned());
    }
    Ok(())
}

/// Two edges of a closed outline that cross each other.
fn crossing(points: &[[f64; 2]]) -> Option<(usize, usize)> {
    let count = points.len();
    let side = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let apart = |i: usize, j: usize| {
        let [a, b] = [points[i], points[(i + 1) % count]];
        let [c, d] = [points[j], points[(j + 1) % count]];
        side(a, b, c) * side(a, b, d) >= 0.0 || side(c, d, a) * side(c, d, b) >= 0.0
    };
    let pairs = (0..count).flat_map(|i| (i + 2..count).map(move |j| (i, j)));
    pairs.filter(|(i, j)| (j + 1) % count != *i).find(|(i, j)| !apart(*i, *j))
}
