//! Paths of particles (Fig. 9): to scale in their box, of one run or of several in one picture, in
//! diameters where all particles drawn of a run have the same one, beside the reference band of a
//! measure of their place.

use super::Run;
use super::bodies;
use super::kinds::{LINES, representatives};
use super::section::upright;
use super::series::Group;
use super::slice::Section;
use crate::figure::{Axes, Chart, Series, SeriesStyle, in_plane};
use mics_run::Result;
use mics_run::config::{Case, Measure, MeasureKind, Reference};
use mics_run::words::rounded;

/// Height of a band on the floor, as a part of the box.
const BAND: f64 = 0.018;
/// Letters of a band's label at most.
const LABEL: usize = 48;

/// The paths of the particles that are asked for in each run, or of all that move, of many of some
/// that stand for them; each with a gap where it crosses a periodic face; and the bands. None where
/// nothing moves.
///
/// # Errors
/// When `particles.csv` lacks a column.
pub fn paths(runs: &[Run]) -> Result<Option<Chart>> {
    let Some(first) = runs.first() else { return Ok(None) };
    let shown = |run: &Run| {
        let mut ids = representatives(&run.case, &moving(run));
        // Many runs have fewer each, so that every path has a colour of its own.
        ids.truncate((3 * LINES / runs.len()).max(1));
        ids
    };
    let scaled = runs.iter().all(|run| diameter(run).is_some());
    let axes = view(&first.case);
    let names = axes.map(|axis| ["x", "y", "z"][axis]);
    let mut series = Vec::new();
    let mut bands = Vec::<Series>::new();
    let mut frame = [0.0f64; 2];
    for run in runs {
        let case = &run.case;
        let scale = diameter(run).filter(|_| scaled).unwrap_or(1.0);
        for Group { label, table, .. } in run.name(bodies::each(run, &shown(run), &names)?, false) {
            let places = table.column(names[0]).iter().zip(table.column(names[1]));
            let places = places.map(|(x, y)| (*x, *y)).collect();
            let points = cut(case, axes, scale, places);
            series.push(Series { label, points, style: SeriesStyle::Line });
        }
        for band in case.measure.iter().filter_map(|measure| band(case, measure, axes, scale)) {
            if bands.iter().all(|other| other.points != band.points) {
                bands.push(band);
            }
        }
        frame = [0, 1].map(|k| frame[k].max(case.domain.size[axes[k]] / scale));
    }
    if series.iter().all(|path| path.points.len() < 2) {
        return Ok(None);
    }
    // Last, so that paths have the colours of their order.
    series.extend(bands);
    series.extend(obstacles(first, axes, scaled));
    let [x_label, y_label] = labels(runs, names, scaled);
    let (drawn, all) =
        runs.iter().fold((0, 0), |(a, b), run| (a + shown(run).len(), b + moving(run).len()));
    let title = match (runs, &shown(first)[..]) {
        ([one], [id]) => format!("path of {}", one.case.called(*id)),
        _ if drawn < all => format!("paths of {drawn} of {all} bodies"),
        _ => "paths".into(),
    };
    let axes = Axes { x_label, y_label, title, frame: Some(frame), ..Axes::default() };
    Ok(Some(Chart { panels: vec![(axes, series)], beside: false }))
}

/// The bodies of a run that have paths.
fn moving(run: &Run) -> Vec<usize> {
    bodies::moving(&run.case, &run.asked)
}

/// Labels of the axes of these names, with the diameters that they are over.
fn labels(runs: &[Run], names: [&str; 2], scaled: bool) -> [String; 2] {
    let [x_label, y_label] =
        names.map(|name| if scaled { format!("{name}/d") } else { format!("{name} (m)") });
    let lengths: Vec<f64> = runs.iter().filter_map(diameter).collect();
    let (least, most) =
        lengths.iter().fold((f64::INFINITY, 0.0f64), |(low, high), d| (low.min(*d), high.max(*d)));
    let x_label = match scaled {
        true if most <= least * (1.0 + 1e-9) => format!("{x_label}, d = {} m", rounded(most)),
        true => format!("{x_label}, d of each run, {} to {} m", rounded(least), rounded(most)),
        false => x_label,
    };
    [x_label, y_label]
}

/// The outlines of the obstacles of a run at the start, in a plane through the middle of the box.
fn obstacles(run: &Run, axes: [usize; 2], scaled: bool) -> Vec<Series> {
    let case = &run.case;
    let scale = diameter(run).filter(|_| scaled).unwrap_or(1.0);
    let size = axes.map(|axis| case.domain.size[axis]);
    let across = 3 - axes[0] - axes[1];
    let middle = 0.5 * case.domain.size.get(across).copied().unwrap_or(0.0);
    let section = Section { axes, height: middle, dimension: case.dimension() };
    let rings = case.obstacle.iter().flat_map(|o| section.obstacle(case, o.wall(), None));
    let rings = rings.map(|ring| in_plane(ring, size)).filter(|ring| ring.len() > 2);
    let line = |ring: Vec<[f64; 2]>| {
        let closed = ring.iter().chain(ring.first());
        let points = closed.map(|[x, y]| (x / scale, y / scale)).collect();
        Series { label: String::new(), points, style: SeriesStyle::Wall }
    };
    rings.map(line).collect()
}

/// The diameter (m) of all particles whose paths are drawn, where it is one.
fn diameter(run: &Run) -> Option<f64> {
    let mut all = moving(run).into_iter().map(|id| run.case.particle[id].shape.diameter());
    let first = all.next()?;
    all.all(|other| (other - first).abs() < 1e-9 * first).then_some(first)
}

/// The two axes that paths are drawn over: x and y, or z where that is upright.
fn view(case: &Case) -> [usize; 2] {
    if upright(case) == Some(2) { [0, 2] } else { [0, 1] }
}

/// Places over `scale`, with a gap where the path goes out on one side of the box and comes in on
/// the other.
fn cut(case: &Case, axes: [usize; 2], scale: f64, points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let half = axes.map(|axis| 0.5 * case.domain.size[axis]);
    let far =
        |a: &(f64, f64), b: &(f64, f64)| (a.0 - b.0).abs() > half[0] || (a.1 - b.1).abs() > half[1];
    let mut all = Vec::with_capacity(points.len());
    for part in points.chunk_by(|a, b| !far(a, b)) {
        if !all.is_empty() {
            all.push((f64::NAN, f64::NAN));
        }
        all.extend(part.iter().map(|(x, y)| (x / scale, y / scale)));
    }
    all
}

/// The band of a measure that is a particle's place: on the side of the box that gravity pulls to,
/// or right through the box where it pulls to neither.
fn band(case: &Case, measure: &Measure, axes: [usize; 2], scale: f64) -> Option<Series> {
    let axis = match measure.kind {
        MeasureKind::PositionX => 0,
        MeasureKind::PositionY => 1,
        MeasureKind::PositionZ => 2,
        _ => return None,
    };
    let along = axes.iter().position(|drawn| *drawn == axis)?;
    let Reference::Band(range) = measure.reference? else { return None };
    let other = axes[1 - along];
    let size = case.domain.size[other];
    let pull = case.fluid.gravity[other];
    let across = match pull {
        0.0 => [0.0, size],
        ..0.0 => [0.0, BAND * size],
        _ => [(1.0 - BAND) * size, size],
    };
    let corner = |k: usize| {
        let [a, b] = [range[k] / scale, across[k] / scale];
        if along == 0 { (a, b) } else { (b, a) }
    };
    let label = measure
        .source
        .as_ref()
        .map_or_else(|| format!("reference of {}", measure.name), |text| brief(text));
    Some(Series { label, points: vec![corner(0), corner(1)], style: SeriesStyle::Band })
}

/// As many words of a text as a legend has room for.
pub fn brief(text: &str) -> String {
    let mut short = String::new();
    for word in text.split_whitespace() {
        if short.chars().count() + word.chars().count() > LABEL {
            return short + " ...";
        }
        short += if short.is_empty() { "" } else { " " };
        short += word;
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(gravity: &str, more: &str) -> Case {
        let text = format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [1.0, 2.0], cells = [8, 16] }}\n\
            fluid = {{ density = 2.0, viscosity = 0.1, gravity = {gravity} }}\n\
            boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" }}\n\
            particle = [{{ shape = {{ disc = {{ diameter = 0.2 }} }}, position = [0.5, 1.8] }}]\n\
            {more}"
        );
        mics_run::config::written(&text).unwrap()
    }

    #[test]
    fn position_band_on_gravity_side() {
        let landing =
            "[[measure]]\nname = \"landing\"\nkind = \"position_x\"\nreference = [0.4, 0.7]\n";
        for (gravity, low, high) in [
            ("[0.0, -9.81]", 0.0, 10.0 * BAND),
            ("[1.0, 9.81]", 10.0 - 10.0 * BAND, 10.0),
            ("[1.0, 0.0]", 0.0, 10.0),
        ] {
            let case = case(gravity, landing);
            let band = band(&case, &case.measure[0], [0, 1], 0.2).unwrap();
            let corners = [band.points[0].0, band.points[0].1, band.points[1].0, band.points[1].1];
            let expected = [2.0, low, 3.5, high];
            assert!(
                corners.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12),
                "{gravity}: {corners:?}"
            );
            assert_eq!(
                (band.label.as_str(), band.style),
                ("reference of landing", SeriesStyle::Band)
            );
        }
        let case = case("[0.0, -9.81]", &landing.replace("[0.4, 0.7]", "0.4\ntolerance = 0.1"));
        assert!(band(&case, &case.measure[0], [0, 1], 0.2).is_none(), "one number is no band");
    }

    #[test]
    fn path_figure_gap_at_periodic_side() {
        let case = case("[0.0, -9.81]", "");
        let path = cut(&case, [0, 1], 0.2, vec![(0.5, 0.2), (0.5, 0.1), (0.5, 1.9), (0.5, 1.8)]);
        assert_eq!(path.len(), 5);
        assert!(
            path[2].0.is_nan()
                && (path[1].1 - 0.5).abs() < 1e-12
                && (path[3].1 - 9.5).abs() < 1e-12,
            "{path:?}"
        );
    }

    #[test]
    fn long_source_truncated_at_word() {
        assert_eq!(brief("experiment of section 4"), "experiment of section 4");
        let long = brief(
            "Ushijima, Takemura, Yamada and Nezu 2003, section 4, experiments with a video camera",
        );
        assert!(long.ends_with(" ...") && long.chars().count() <= LABEL + 6, "{long}");
    }
}
