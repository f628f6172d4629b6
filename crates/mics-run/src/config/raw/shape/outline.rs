//! Outlines of polygons: whether they are simple and convex.

/// What is wrong with an outline that ought to be convex, and at which of its corners.
pub(super) struct Flaw {
    /// The corner, from 0.
    pub corner: usize,
    /// What is wrong there, in words.
    pub what: String,
}

/// Checks that points (m), in order and either way round, are the corners of a convex polygon.
pub(super) fn convex(points: &[[f64; 2]]) -> Result<(), Flaw> {
    let count = points.len();
    let flaw = |corner: usize, what: String| Err(Flaw { corner, what });
    if count < 3 {
        return flaw(
            count.saturating_sub(1),
            format!("{count} points make no polygon: give 3 or more"),
        );
    }
    let span = (0..2).map(|a| {
        let along = points.iter().map(|p| p[a]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    });
    let span = span.fold(0.0, f64::max);
    let edge = |k: usize| {
        let (a, b) = (points[k % count], points[(k + 1) % count]);
        [b[0] - a[0], b[1] - a[1]]
    };
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    if let Some(k) = (0..count).find(|k| edge(*k).iter().all(|d| d.abs() <= 1e-9 * span)) {
        let what = "lies on the one before: an outline closes by itself, leave it out".to_owned();
        return flaw((k + 1) % count, what);
    }
    if let Some((_, later)) = crossing(points) {
        return flaw(
            later,
            "the outline crosses itself here: give its corners in order".to_owned(),
        );
    }
    let area: f64 = (0..count).map(|k| cross(points[k], points[(k + 1) % count])).sum();
    let sense = if area < 0.0 { -1.0 } else { 1.0 };
    let bent = |k: &usize| sense * cross(edge(*k), edge(*k + 1)) < -1e-9 * span * span;
    match (0..count).find(bent) {
        Some(k) => flaw(
            (k + 1) % count,
            "the outline is not convex here: leave the corner out, or make a clump of discs"
                .to_owned(),
        ),
        None if area.abs() <= 1e-9 * span * span => {
            flaw(0, "all points lie on a line, which has no area".to_owned())
        }
        None => Ok(()),
    }
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
