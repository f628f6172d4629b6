//! Forces on particles: over time, and over the height of one in the three parts of (19) (Fig. 10);
//! speeds of free ones.

use super::components::{NAMES, Vector};
use super::kinds::{Course, Kind, SPREAD, Spread};
use super::paths::Track;
use super::rows::{self, Rows};
use super::section::upright;
use crate::figure::{Axes, Chart, Series, SeriesStyle};
use mics_run::Result;
use mics_run::config::{Case, WallRule};
use mics_run::words::rounded;

/// Way, in diameters, over which each point of the parts of a force is a mean: single steps jump as
/// cells change sides.
const MEAN: f64 = 0.1;
/// Part of the run whose forces are not shown: the first steps of an impulsive start would flatten
/// all that follows.
const START: f64 = 0.02;
/// Points of a spread over time at most: each is the mean of some rows.
const POINTS: usize = 500;

/// The unit of forces: in 2D they are of a metre of depth.
pub fn unit(case: &Case) -> &'static str {
    if case.dimension() == 2 { "N/m" } else { "N" }
}

/// Force of the fluid over time, a plot for each axis that matters: on one body of one run with its
/// parts, on few a line each, on many by kinds; on bodies and obstacles that are asked for, or else
/// on all. None where there are no rows.
///
/// # Errors
/// When the rows lack a column.
pub fn forces(tracks: &[Track]) -> Result<Option<Chart>> {
    let Some(Track { case, rows, asked, .. }) = tracks.first() else { return Ok(None) };
    if tracks.iter().all(|track| track.rows.is_empty()) {
        return Ok(None);
    }
    let ids = rows::loaded(case, asked);
    let start = START * case.time.end;
    let (title, plots) = match (tracks, &rows.forces, &ids[..]) {
        ([_], None, [id]) => (format!("force on {}", case.called(*id)), parts_of(case, rows, *id)?),
        _ => {
            let of = match (tracks, &rows.forces) {
                ([_], Some(_)) => format!(" on {} bodies", ids.len()),
                _ => String::new(),
            };
            (format!("force of the fluid{of}"), lines(tracks, Drawn::force)?)
        }
    };
    let cut = format!("the first {} s, of an impulsive start, left out", rounded(start));
    let spread = tracks.iter().find_map(|track| track.rows.forces.as_ref());
    let notes = spread.map(|_| SPREAD.to_owned()).into_iter().chain([cut]).collect();
    let unit = unit(case);
    Ok(Vector { what: "force", unit, title, notes, cut_peaks: true }.chart(plots))
}

/// The force on a body along each axis and its parts.
fn parts_of(case: &Case, rows: &Rows, id: usize) -> Result<Vec<Vec<Series>>> {
    let start = START * case.time.end;
    let curve = |column: &str, label: &str, style| {
        let mut series = rows.curve(id, "time", column, label)?;
        series.points.retain(|p| p.0 > start);
        Ok(Series { style, ..series })
    };
    let axes = NAMES.into_iter().take(case.dimension());
    let parts = force_parts(case);
    // All plots have the same lines, since they share the first one's legend.
    let contacts = axes.clone().map(|a| rows.column(id, &format!("contact_f{a}")));
    let touched = contacts.collect::<Result<Vec<_>>>()?.concat().iter().any(|force| *force != 0.0);
    let plot = |a: &str| {
        let mut all = vec![curve(&format!("fluid_f{a}"), "fluid, in all", SeriesStyle::Line)?];
        for Part { column, words } in &parts {
            all.push(curve(&format!("{column}_f{a}"), words, SeriesStyle::Dashed)?);
        }
        if touched {
            let contact = format!("contact_f{a}");
            all.push(curve(&contact, "contacts and lubrication", SeriesStyle::Line)?);
        }
        Ok(all)
    };
    axes.map(plot).collect()
}

/// Lines of a vector of some bodies of a run: its column without the axis, the course of their
/// kinds where they are many, and the time (s) after which it is drawn.
struct Drawn<'a> {
    ids: Vec<usize>,
    column: &'a str,
    course: Option<&'a Course>,
    start: f64,
}

impl<'a> Drawn<'a> {
    /// The force of the fluid.
    fn force(track: &'a Track) -> Drawn<'a> {
        Drawn {
            ids: rows::loaded(track.case, track.asked),
            column: "fluid_f",
            course: track.rows.forces.as_ref(),
            start: START * track.case.time.end,
        }
    }

    /// The velocity of free bodies.
    fn velocity(track: &'a Track) -> Drawn<'a> {
        Drawn {
            ids: rows::free(track.case, track.asked),
            column: "v",
            course: track.rows.velocities.as_ref(),
            start: f64::NEG_INFINITY,
        }
    }
}

/// Lines along each axis of the bodies of runs, with the names of the runs where there are several
/// and those of the bodies where a run has several.
fn lines<'a>(tracks: &'a [Track], drawn: fn(&'a Track) -> Drawn<'a>) -> Result<Vec<Vec<Series>>> {
    let mut plots: Vec<Vec<Series>> = Vec::new();
    for track in tracks.iter().filter(|track| !track.rows.is_empty()) {
        let Track { label, case, rows, .. } = track;
        let Drawn { ids, column, course, start } = drawn(track);
        let called = |id: usize| if ids.len() > 1 { case.called(id) } else { String::new() };
        let line = |id: usize, axis: usize| {
            let column = format!("{column}{}", NAMES[axis]);
            let mut series = rows.curve(id, "time", &column, &called(id))?;
            series.points.retain(|point| point.0 > start);
            Ok(series)
        };
        let of_run = match course {
            Some(course) => of_kinds(course, case.dimension(), start),
            None => (0..case.dimension())
                .map(|axis| ids.iter().map(|id| line(*id, axis)).collect())
                .collect::<Result<_>>()?,
        };
        plots.resize(plots.len().max(of_run.len()), Vec::new());
        for (plot, mut series) in plots.iter_mut().zip(of_run) {
            let named = series.iter_mut().filter(|one| one.style != SeriesStyle::Spread);
            for one in named.filter(|_| !track.averaged) {
                let own = std::mem::take(&mut one.label);
                let both = [*label, &own].into_iter().filter(|word| !word.is_empty());
                one.label = both.collect::<Vec<_>>().join(", ");
            }
            plot.extend(series);
        }
    }
    if tracks.iter().any(|track| track.averaged) {
        plots.iter_mut().for_each(|plot| *plot = averaged(plot));
    }
    Ok(plots)
}

/// The mean of the lines of one label, at the places of the first over which all go, with the area
/// between the least and the largest of them.
fn averaged(all: &[Series]) -> Vec<Series> {
    let mut labels: Vec<&str> = Vec::new();
    let lines = all.iter().filter(|one| one.style == SeriesStyle::Line && one.points.len() > 1);
    let lines: Vec<&Series> = lines.collect();
    for line in &lines {
        if !labels.contains(&line.label.as_str()) {
            labels.push(&line.label);
        }
    }
    let of = |label: &str| -> [Series; 2] {
        let same: Vec<&[(f64, f64)]> = lines
            .iter()
            .filter(|line| line.label == label)
            .map(|line| line.points.as_slice())
            .collect();
        let mut mean = Vec::new();
        let mut low = Vec::new();
        let mut high = Vec::new();
        for (x, _) in same.first().into_iter().copied().flatten() {
            let values: Option<Vec<f64>> = same.iter().map(|points| value_at(points, *x)).collect();
            let Some(values) = values else { continue };
            mean.push((*x, values.iter().sum::<f64>() / values.len() as f64));
            low.push((*x, values.iter().copied().fold(f64::INFINITY, f64::min)));
            high.push((*x, values.iter().copied().fold(f64::NEG_INFINITY, f64::max)));
        }
        low.reverse();
        high.extend(low);
        let of_runs = format!("mean of {} runs", same.len());
        let both = [label, &of_runs].into_iter().filter(|word| !word.is_empty());
        let label = both.collect::<Vec<_>>().join(", ");
        [
            Series { label, points: mean, style: SeriesStyle::Line },
            Series { label: String::new(), points: high, style: SeriesStyle::Spread },
        ]
    };
    labels.into_iter().flat_map(of).collect()
}

/// The value of a line at a place, linear between its points; none beyond its ends.
fn value_at(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let after = points.partition_point(|point| point.0 < x);
    let (x1, y1) = *points.get(after)?;
    if x1 == x {
        return Some(y1);
    }
    let (x0, y0) = *points.get(after.checked_sub(1)?)?;
    Some(y0 + (x - x0) / (x1 - x0) * (y1 - y0))
}

/// Lines and spreads of the kinds of many bodies along each axis, after a time (s).
fn of_kinds(course: &Course, dimension: usize, start: f64) -> Vec<Vec<Series>> {
    let plot = |axis: usize| {
        let of = |(kind, rows): (&Kind, &[Spread])| {
            let rows: Vec<_> = rows.iter().filter(|row| row.0 > start).collect();
            let mean = |some: &[&Spread], value: &dyn Fn(&Spread) -> f64| {
                some.iter().map(|row| value(row)).sum::<f64>() / some.len() as f64
            };
            let point = |some: &[&Spread]| {
                (
                    mean(some, &|row| row.0),
                    [0, 1, 2].map(|part| mean(some, &|row| row.1[axis][part])),
                )
            };
            let rows: Vec<_> = rows.chunks(rows.len().div_ceil(POINTS).max(1)).map(point).collect();
            let line = |part: usize| rows.iter().map(move |row| (row.0, row.1[part]));
            let middle = Series {
                label: kind.label.clone(),
                points: line(1).collect(),
                style: SeriesStyle::Line,
            };
            let mut back: Vec<_> = line(0).collect();
            back.reverse();
            let around = line(2).chain(back).collect();
            [middle, Series { label: String::new(), points: around, style: SeriesStyle::Spread }]
        };
        course.of_kinds().flat_map(of).collect()
    };
    (0..dimension).map(plot).collect()
}

/// The parts of the fluid's force on a body.
pub struct Part {
    /// Prefix of its columns.
    pub column: &'static str,
    /// Its name in legends.
    pub words: &'static str,
}

/// Pressure, viscous part and remainder of the fluid's force on a body.
pub fn force_parts(case: &Case) -> [Part; 3] {
    let part = |column, words| Part { column, words };
    match case.coupling.wall {
        WallRule::Sharp => [
            part("pressure", "pressure on the surface"),
            part("viscous", "shear on the surface"),
            part("defect", "force defect"),
        ],
        WallRule::Mixture => [
            part("pressure", "pressure part of (19)"),
            part("viscous", "viscous part"),
            part("convective", "convective part"),
        ],
    }
}

/// Velocity over time of the free particles that are asked for, or else of all, a plot for each
/// axis that matters: of few a line each, of many by kinds.
///
/// # Errors
/// When `particles.csv` lacks a column.
pub fn speeds(tracks: &[Track]) -> Result<Option<Chart>> {
    let plots = lines(tracks, Drawn::velocity)?;
    if plots.iter().all(Vec::is_empty) {
        return Ok(None);
    }
    let title = match tracks {
        [Track { case, rows, asked, .. }] => match (&rows.velocities, &rows::free(case, asked)[..])
        {
            (Some(_), ids) => format!("velocity of {} bodies", ids.len()),
            // One body needs no legend: the title names it.
            (None, [id]) => format!("velocity of {}", case.called(*id)),
            _ => "velocity".to_owned(),
        },
        _ => "velocity".to_owned(),
    };
    let spread = tracks.iter().find_map(|track| track.rows.velocities.as_ref());
    let notes = spread.map(|_| SPREAD.to_owned()).into_iter().collect();
    let vector = Vector { what: "velocity", unit: "m/s", title, notes, cut_peaks: false };
    Ok(vector.chart(plots))
}

/// The parts of (19) across gravity, of the first free particle, or of those that are `asked` for,
/// until it first touches something: over the height of its centre in diameters, from the start's
/// on, as parts of its submerged weight `|rho_p - rho_f| V |g|`. None where nothing is free or
/// nothing pulls at it.
///
/// # Errors
/// When `particles.csv` lacks a column.
pub fn parts(case: &Case, rows: &Rows, asked: &[usize]) -> Result<Option<(Axes, Vec<Series>)>> {
    let free = rows::free(case, asked).first().copied();
    let (Some(id), Some(up)) = (free, upright(case)) else { return Ok(None) };
    let particle = &case.particle[id];
    let diameter = case.particle[id].shape.diameter();
    let volume = particle.shape.volume();
    let pull = case.fluid.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    let weight = (particle.density() - case.fluid.density).abs() * volume * pull;
    if weight == 0.0 || rows.is_empty() {
        return Ok(None);
    }
    let Fall { heights, way, time, falls_along } = Fall::read(case, rows, id, up)?;
    let across = if up == 0 { "y" } else { "x" };
    let [pressure, viscous, remainder] = force_parts(case);
    let parts = [(remainder, "F_c"), (pressure, "F_p"), (viscous, "F_d")];
    let parts = parts.map(|(Part { column, words }, symbol)| {
        let force = rows.column(id, &format!("{column}_f{across}"))?;
        let means = running_mean(&force[..way.len()], &time, &way);
        let points = heights.iter().zip(means).skip(1);
        let points = points.map(|(height, force)| (*height, force / weight)).collect();
        let label = match case.coupling.wall {
            WallRule::Sharp => format!("{words}, {across}"),
            WallRule::Mixture => format!("{symbol}{across}, {words}"),
        };
        Ok(Series { label, points, style: SeriesStyle::Line })
    });
    let height = if falls_along { NAMES[up] } else { "height" };
    let axes = Axes {
        x_label: format!("{height}/d, d = {} m", rounded(diameter)),
        y_label: "force / submerged weight".into(),
        falling_x: heights[way.len() - 1] < heights[0],
        title: format!(
            "fluid force along {across} on {}, mean over {MEAN} d of its way",
            case.called(id)
        ),
        ..Axes::default()
    };
    Ok(Some((axes, parts.into_iter().collect::<Result<_>>()?)))
}

/// The fall of a particle until it first touches something, row by row.
struct Fall {
    /// Heights of its centre (diameters), from where gravity pulls to.
    heights: Vec<f64>,
    /// The way that it has gone (diameters).
    way: Vec<f64>,
    /// Times (s).
    time: Vec<f64>,
    /// Whether gravity points to the low end of its axis.
    falls_along: bool,
}

impl Fall {
    fn read(case: &Case, rows: &Rows, id: usize, up: usize) -> Result<Fall> {
        let diameter = case.particle[id].shape.diameter();
        let columns = |names: [&str; 3]| -> Result<Vec<Vec<f64>>> {
            names.into_iter().map(|name| Ok(rows.column(id, name)?.to_vec())).collect()
        };
        let places = columns(["x", "y", "z"])?;
        let contact = columns(["contact_fx", "contact_fy", "contact_fz"])?;
        let time = rows.column(id, "time")?.to_vec();
        let touches = (0..time.len()).position(|row| contact.iter().any(|force| force[row] != 0.0));
        // One that lies on something from the first has no fall to show: all of it, then.
        let end = touches.filter(|row| *row > 1).unwrap_or(time.len());
        let falls_along = case.fluid.gravity[up] < 0.0;
        let height = |row: usize| {
            let at = places[up][row];
            (if falls_along { at } else { case.domain.size[up] - at }) / diameter
        };
        let mut way = vec![0.0; end];
        for row in 1..end {
            let square = places.iter().map(|place| (place[row] - place[row - 1]).powi(2));
            way[row] = way[row - 1] + square.sum::<f64>().sqrt() / diameter;
        }
        Ok(Fall { heights: (0..end).map(height).collect(), way, time, falls_along })
    }
}

/// The mean over time of each row and of those within half of [`MEAN`] of the way before and behind
/// it.
fn running_mean(force: &[f64], time: &[f64], way: &[f64]) -> Vec<f64> {
    // A row's force is that of the step that ends with it.
    let step = |row: usize| if row == 0 { 0.0 } else { time[row] - time[row - 1] };
    let mut low = 0;
    let mut high = 0;
    let mut sum = 0.0;
    let mut length = 0.0;
    let mean = |row: usize| {
        while high < way.len() && way[high] <= way[row] + 0.5 * MEAN {
            sum += step(high) * force[high];
            length += step(high);
            high += 1;
        }
        while way[low] < way[row] - 0.5 * MEAN {
            sum -= step(low) * force[low];
            length -= step(low);
            low += 1;
        }
        sum / length
    };
    (0..way.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_of_runs_is_over_the_times_of_all_with_their_spread() {
        let line = |points: &[(f64, f64)]| Series {
            label: "a".into(),
            points: points.to_vec(),
            style: SeriesStyle::Line,
        };
        let runs = [
            line(&[(0.0, 0.0), (1.0, 2.0), (2.0, 4.0), (3.0, 6.0)]),
            line(&[(0.0, 4.0), (4.0, 4.0)]),
            line(&[(0.0, 8.0), (2.0, 4.0)]),
        ];
        let [mean, spread] = &averaged(&runs)[..] else { panic!() };
        assert_eq!((mean.label.as_str(), spread.style), ("a, mean of 3 runs", SeriesStyle::Spread));
        assert_eq!(mean.points, [(0.0, 4.0), (1.0, 4.0), (2.0, 4.0)]);
        let edges = [(0.0, 8.0), (1.0, 6.0), (2.0, 4.0), (2.0, 4.0), (1.0, 2.0), (0.0, 0.0)];
        assert_eq!(spread.points, edges);
    }

    /// A disc of 0.2 m and 2.5 times the fluid's density falls along -y at 1 m/s from 1.8 m, and
    /// touches the floor.
    fn fall(gravity: &str) -> (Case, Rows) {
        let case = mics_run::config::written(&format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [1.0, 2.0], cells = [8, 16] }}\n\
            fluid = {{ density = 2.0, viscosity = 0.1, gravity = {gravity} }}\n\
            boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" }}\n\
            particle = [{{ shape = {{ disc = {{ diameter = 0.2 }} }}, density = 5.0, position = \
            [0.5, 1.8] }}]\n"
        ));
        let head = "time,id,x,y,z,vx,vy,vz,contact_fx,contact_fy,contact_fz,\
            convective_fx,pressure_fx,viscous_fx,convective_fy,pressure_fy,viscous_fy\n";
        let row = |k: i32| {
            let time = 0.001 * f64::from(k);
            let noise = if k % 2 == 0 { 1.0 } else { -1.0 };
            let y = (1.8 - time).max(0.1);
            let touches = if y > 0.1 { 0.0 } else { 9.0 };
            format!(
                "{time},0,0.5,{y},0,0,-1,0,0,{touches},0,{noise},{},0.5,0,1,0\n",
                3.0 * y + noise
            )
        };
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(
            folder.path().join("particles.csv"),
            head.to_owned() + &(0..2000).map(row).collect::<String>(),
        )
        .unwrap();
        let case = case.unwrap();
        let rows = Rows::read(folder.path(), &case, &[]);
        (case, rows)
    }

    #[test]
    fn force_parts_over_submerged_weight_until_contact() {
        let (case, rows) = fall("[0.0, -10.0]");
        let (axes, parts) = super::parts(&case, &rows, &[]).unwrap().unwrap();
        assert_eq!((axes.x_label.as_str(), axes.falling_x), ("y/d, d = 0.2 m", true));
        assert_eq!(
            parts.iter().map(|s| s.label.as_str()).collect::<Vec<_>>(),
            ["force defect, x", "pressure on the surface, x", "shear on the surface, x"]
        );
        let weight = 3.0 * std::f64::consts::PI * 0.01 * 10.0;
        let first = parts[1].points[0];
        let last = parts[1].points[parts[1].points.len() - 1];
        assert!(
            (first.0 - 9.0).abs() < 0.01 && (last.0 - 0.5).abs() < 0.01,
            "{first:?} to {last:?}"
        );
        // Away from both ends the mean of a force that is linear in the height is its value, that
        // of noise next to nothing.
        for (noise, pressure) in
            parts[0].points.iter().zip(&parts[1].points).filter(|(p, _)| (1.0..8.0).contains(&p.0))
        {
            assert!((pressure.1 * weight - 0.6 * pressure.0).abs() < 0.1, "{pressure:?}");
            assert!((noise.1 * weight).abs() < 0.1, "{noise:?}");
        }
        assert!(parts[2].points.iter().all(|p| (p.1 * weight - 0.5).abs() < 1e-12));
    }

    #[test]
    fn force_parts_across_gravity_need_gravity() {
        let (case, rows) = fall("[10.0, 0.0]");
        let (axes, parts) = super::parts(&case, &rows, &[]).unwrap().unwrap();
        assert_eq!(
            (axes.x_label.as_str(), parts[1].label.as_str()),
            ("height/d, d = 0.2 m", "pressure on the surface, y")
        );
        assert!(
            parts[1].points.iter().all(|p| (p.0 - 2.5).abs() < 1e-12),
            "from the wall that it is pulled to"
        );
        let (mut case, rows) = fall("[0.0, -10.0]");
        case.coupling.wall = WallRule::Mixture;
        let (_, parts) = super::parts(&case, &rows, &[]).unwrap().unwrap();
        let labels: Vec<_> = parts.iter().map(|s| s.label.as_str()).collect();
        assert_eq!(
            labels,
            ["F_cx, convective part", "F_px, pressure part of (19)", "F_dx, viscous part"]
        );
        let (mut case, rows) = fall("[0.0, 0.0]");
        assert!(super::parts(&case, &rows, &[]).unwrap().is_none());
        case.fluid.gravity = vec![0.0, -10.0];
        case.particle[0].density = Some(case.fluid.density);
        assert!(super::parts(&case, &rows, &[]).unwrap().is_none(), "as heavy as the fluid");
    }
}
