//! Records of probes (`probes.csv`): velocity and pressure at points over time, and their means
//! along lines.

use super::components::SHOWN;
use super::rows::table;
use crate::figure::{Axes, COLOURS, Chart, Series, SeriesStyle};
use mics_run::Result;
use mics_run::not_a_run;
use mics_run::words::rounded;
use std::path::Path;

/// The columns that are drawn, with their labels.
const COLUMNS: [(&str, &str); 4] = [
    ("vx", "velocity along x (m/s)"),
    ("vy", "velocity along y (m/s)"),
    ("vz", "velocity along z (m/s)"),
    ("pressure", "pressure (Pa)"),
];

/// A row of a point of a probe: its time (s) and the values of [`COLUMNS`].
type Sample = (f64, [f64; 4]);

/// The points of a probe's line in the plot of one of [`COLUMNS`].
type Curve<'a> = &'a dyn Fn(&&Probe, usize) -> Vec<(f64, f64)>;

/// A probe: the places of its points (m), and what each recorded.
struct Probe {
    name: String,
    points: Vec<([f64; 3], Vec<Sample>)>,
}

/// The figures of a run's probes: those of single points over time, and those of several points
/// along their lines. Either is absent where there is none of the kind; both without `probes.csv`.
///
/// # Errors
/// When the file is not one of a run.
pub fn probes(run: &Path) -> Result<[Option<Chart>; 2]> {
    let probes = read(run)?;
    let (points, lines): (Vec<&Probe>, Vec<&Probe>) =
        probes.iter().partition(|probe| probe.points.len() == 1);
    let over_time = |probe: &&Probe, k: usize| {
        let samples = &probe.points[0].1;
        samples.iter().map(|(time, values)| (*time, values[k])).collect()
    };
    let along = |probe: &&Probe, k: usize| {
        let from = probe.points[0].0;
        let way = |at: &[f64; 3]| (0..3).map(|a| (at[a] - from[a]).powi(2)).sum::<f64>().sqrt();
        let mean = |samples: &[Sample]| {
            samples.iter().map(|(_, v)| v[k]).sum::<f64>() / samples.len() as f64
        };
        probe.points.iter().map(|(at, samples)| (way(at), mean(samples))).collect()
    };
    let last = probes
        .iter()
        .flat_map(|p| &p.points)
        .filter_map(|(_, samples)| Some(samples.last()?.0))
        .fold(0.0, f64::max);
    let means = format!("means over all rows of probes.csv, to t = {} s", rounded(last));
    Ok([
        draw(&points, "time (s)", "velocity and pressure at probes", String::new(), &over_time),
        draw(
            &lines,
            "distance from the first point (m)",
            "velocity and pressure along lines of probes",
            means,
            &along,
        ),
    ])
}

/// A plot for each component of the velocity that matters and for the pressure, a line for each
/// probe, of as many as there are colours.
fn draw(probes: &[&Probe], x_label: &str, title: &str, note: String, of: Curve) -> Option<Chart> {
    let shown: Vec<&Probe> =
        super::evenly(probes.len(), probes.len().min(COLOURS.len())).map(|k| probes[k]).collect();
    let title = if shown.len() < probes.len() {
        format!("{title}, {} of {}", shown.len(), probes.len())
    } else {
        title.into()
    };
    let plots: Vec<Vec<Series>> = (0..COLUMNS.len())
        .map(|k| {
            let line = |probe: &&Probe| Series {
                label: probe.name.clone(),
                points: of(probe, k),
                style: SeriesStyle::Line,
            };
            shown.iter().map(line).collect()
        })
        .collect();
    let largest = |series: &[Series]| {
        series.iter().flat_map(|one| &one.points).map(|p| p.1.abs()).fold(0.0, f64::max)
    };
    let most = plots[..3].iter().map(|series| largest(series)).fold(0.0, f64::max);
    let matters = |k: usize, series: &[Series]| {
        let size = largest(series);
        size > 0.0 && (k == 3 || size > SHOWN * most)
    };
    let mut panels = Vec::new();
    for (k, mut series) in plots.into_iter().enumerate().filter(|(k, series)| matters(*k, series)) {
        // One legend for all.
        if !panels.is_empty() {
            series.iter_mut().for_each(|one| one.label.clear());
        }
        panels.push((
            Axes { x_label: x_label.into(), y_label: COLUMNS[k].1.into(), ..Axes::default() },
            series,
        ));
    }
    if let Some((first, _)) = panels.first_mut() {
        first.title = title;
        first.note = note;
    }
    Some(Chart { panels, beside: false }).filter(Chart::shows)
}

fn read(run: &Path) -> Result<Vec<Probe>> {
    let Some(mut reader) = table(&run.join("probes.csv")) else { return Ok(Vec::new()) };
    let strange = || not_a_run(run, "probes.csv is not one that mics wrote");
    let head = reader.headers().map_err(|_| strange())?.clone();
    let column = |name: &str| head.iter().position(|other| other == name).ok_or_else(strange);
    let probe = column("probe")?;
    let point = column("point")?;
    let time = column("time")?;
    let places = [column("x")?, column("y")?, column("z")?];
    let shown = COLUMNS.map(|(name, _)| column(name));
    let [a, b, c, d] = shown;
    let shown = [a?, b?, c?, d?];
    let mut all: Vec<Probe> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|_| strange())?;
        let number =
            |k: usize| record.get(k).and_then(|text| text.parse::<f64>().ok()).unwrap_or(f64::NAN);
        let name = record.get(probe).unwrap_or_default();
        let at = match all.iter().position(|known| known.name == name) {
            Some(at) => at,
            None => {
                all.push(Probe { name: name.to_owned(), points: Vec::new() });
                all.len() - 1
            }
        };
        let points = &mut all[at].points;
        let k = number(point) as usize;
        if k == points.len() {
            points.push((places.map(number), Vec::new()));
        }
        points.get_mut(k).ok_or_else(strange)?.1.push((number(time), shown.map(number)));
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probe_points_over_time_and_lines_over_distance() {
        let folder = tempfile::tempdir().unwrap();
        let mut text = "step,time,probe,point,x,y,z,vx,vy,vz,pressure,body\n".to_owned();
        for k in 0..5 {
            text += &format!("{k},{k}.0,one,0,1.0,0.0,0.0,{k}.5,1e-9,0.0,{k}.0,\n");
            for point in 0..3 {
                text +=
                    &format!("{k},{k}.0,row,{point},1.0,{point}.0,0.0,{point}.0,{k}.0,0.0,0.0,\n");
            }
        }
        // A line that is being written.
        std::fs::write(folder.path().join("probes.csv"), text + "5,5.0,one,0,1.0").unwrap();
        let [points, lines] = probes(folder.path()).unwrap().map(Option::unwrap);
        let labels = |chart: &Chart| {
            chart.panels.iter().map(|(axes, _)| axes.y_label.clone()).collect::<Vec<_>>()
        };
        assert_eq!(labels(&points), ["velocity along x (m/s)", "pressure (Pa)"]);
        assert_eq!(
            points.panels[0].1[0].points,
            [(0.0, 0.5), (1.0, 1.5), (2.0, 2.5), (3.0, 3.5), (4.0, 4.5)]
        );
        assert_eq!(labels(&lines), ["velocity along x (m/s)", "velocity along y (m/s)"]);
        assert_eq!(lines.panels[1].1[0].points, [(0.0, 2.0), (1.0, 2.0), (2.0, 2.0)]);
    }
}
