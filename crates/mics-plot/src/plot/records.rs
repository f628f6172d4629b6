//! Records of places: velocity and pressure at probes (`probes.csv`), and means over layers of
//! cells (`profile.csv`).

use super::Run;
use super::series::{Group, Panel, Plot};
use super::table::{Rows, Table};
use crate::figure::{COLOURS, Chart, SeriesStyle};
use mics_run::folder::PROFILE;
use mics_run::words::rounded;
use mics_run::{Result, not_a_run};

/// The file of what probes recorded.
const PROBES: &str = "probes.csv";
/// What probes record, the components of the velocity first.
const RECORDED: [&str; 4] = ["vx", "vy", "vz", "pressure"];

/// What is drawn of probes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Probes {
    /// Those of one point, over time.
    OverTime,
    /// Means of those of several points, along their lines.
    AlongLines,
}

/// What the probes of runs recorded, of one point or of several; none where there is none of the
/// kind.
///
/// # Errors
/// When a file is not one of a run.
pub fn probes(runs: &[Run], kind: Probes) -> Result<Option<Chart>> {
    let mut groups = Vec::new();
    let mut last = 0.0f64;
    for run in runs {
        let probes = read(run)?;
        let times = probes.iter().flat_map(|probe| &probe.points);
        last = times.filter_map(|point| point.column("time").last()).copied().fold(last, f64::max);
        let of_kind = probes.into_iter().filter(|probe| match kind {
            Probes::OverTime => probe.points.len() == 1,
            Probes::AlongLines => probe.points.len() > 1,
        });
        let shown = of_kind.map(|mut probe| match kind {
            Probes::OverTime => Group::new(probe.name, probe.points.swap_remove(0)),
            Probes::AlongLines => Group::new(probe.name.clone(), probe.means()),
        });
        groups.extend(run.name(shown.collect(), false));
    }
    let of = match kind {
        Probes::OverTime => "at probes",
        Probes::AlongLines => "along lines of probes",
    };
    let mut title = format!("velocity and pressure {of}");
    let count = groups.len();
    if count > COLOURS.len() {
        title += &format!(", {} of {count}", COLOURS.len());
        groups = super::evenly(count, COLOURS.len()).map(|k| groups[k].clone()).collect();
    }
    let means = format!("means over all rows of {PROBES}, to t = {} s", rounded(last));
    let panel = |name: &str| {
        let quantity = match name.strip_prefix('v') {
            Some(axis) => format!("velocity along {axis}"),
            None => name.to_owned(),
        };
        let unit = if name == "pressure" { "Pa" } else { "m/s" };
        let panel = match kind {
            Probes::OverTime => Panel::of(name, &quantity, unit, "time", "time (s)"),
            Probes::AlongLines => {
                Panel::of(name, &quantity, unit, "distance", "distance from the first point (m)")
            }
        };
        panel.in_family(unit)
    };
    let notes = (kind == Probes::AlongLines).then_some(means).into_iter().collect();
    let dimension = runs.first().map_or(3, |run| run.case.dimension());
    // In a plane nothing goes across it.
    let shown = RECORDED.into_iter().filter(|name| *name != "vz" || dimension == 3);
    let panels = shown.map(panel).collect();
    Ok(Plot { groups, panels, title, notes, ..Plot::default() }.chart())
}

/// A probe: what each of its points recorded over time.
struct Probe {
    name: String,
    points: Vec<Table>,
}

impl Probe {
    /// Means over time over the distance from the first point.
    fn means(&self) -> Table {
        let columns = [&["distance"][..], &RECORDED].concat();
        let mut table = Table::new(&columns);
        let place = |point: &Table| ["x", "y", "z"].map(|axis| point.column(axis)[0]);
        let first = self.points.first().map_or([0.0; 3], place);
        for point in &self.points {
            let square = place(point).into_iter().zip(first).map(|(x, from)| (x - from).powi(2));
            let mean = |name: &str| {
                let column = point.column(name);
                column.iter().sum::<f64>() / column.len() as f64
            };
            let [vx, vy, vz, pressure] = RECORDED.map(mean);
            table.push(&[square.sum::<f64>().sqrt(), vx, vy, vz, pressure]);
        }
        table
    }
}

fn read(run: &Run) -> Result<Vec<Probe>> {
    let columns = [&["time", "x", "y", "z"][..], &RECORDED].concat();
    let wanted = [&["probe", "point"][..], &columns].concat();
    let mut all: Vec<Probe> = Vec::new();
    let Some(mut rows) = Rows::open(&run.folder, PROBES, &wanted)? else { return Ok(all) };
    while let Some(row) = rows.advance()?.map(<[f64]>::to_vec) {
        let name = rows.text(0);
        let at = match all.iter().position(|known| known.name == name) {
            Some(at) => at,
            None => {
                all.push(Probe { name: name.to_owned(), points: Vec::new() });
                all.len() - 1
            }
        };
        let points = &mut all[at].points;
        let point = row[1] as usize;
        if point == points.len() {
            points.push(Table::new(&columns));
        }
        let strange = || not_a_run(&run.folder, &format!("{PROBES} lacks a point of {name}"));
        points.get_mut(point).ok_or_else(strange)?.push(&row[2..]);
    }
    Ok(all)
}

/// The mean velocity of fluid and bodies along each axis that matters, and beside it the solid
/// fraction; none where no run has a profile.
///
/// # Errors
/// When a file is not one of a run.
pub fn profile(runs: &[Run]) -> Result<Option<Chart>> {
    let dimension = runs.first().map_or(3, |run| run.case.dimension());
    let components = ["u", "v", "w"];
    let solid = components.map(|name| format!("solid_{name}"));
    let mut groups = Vec::new();
    let mut axis = String::new();
    let mut filled = false;
    for run in runs {
        let Some(rows) = Rows::open(&run.folder, PROFILE, &[])? else { continue };
        let names: Vec<&str> = rows.names().collect();
        let Some(table) = Table::read(&run.folder, PROFILE, &names)? else { continue };
        axis = names[0].to_owned();
        // Where there are no particles they have no velocity.
        let fraction = table.column("solid_fraction");
        filled |= fraction.iter().any(|part| *part > 0.0);
        let masked = |name: &String| -> Vec<f64> {
            let pairs = table.column(name).iter().zip(fraction);
            pairs.map(|(value, part)| if *part > 0.0 { *value } else { f64::NAN }).collect()
        };
        let solids = solid.each_ref().map(masked);
        let mut shown = Table::default().with("height", table.column(names[0]).to_vec());
        for name in components.iter().chain(&["solid_fraction"]) {
            shown = shown.with(name, table.column(name).to_vec());
        }
        for (name, column) in solid.iter().zip(solids) {
            shown = shown.with(name, column);
        }
        groups.extend(run.name(vec![Group::new("", shown)], false));
    }
    let height = format!("{axis} (m)");
    let panel = |(name, solid): (&str, &String)| {
        let direction = match name {
            "u" => "x",
            "v" => "y",
            _ => "z",
        };
        let quantity = format!("mean velocity along {direction}");
        let panel = Panel::of(name, &quantity, "m/s", "height", &height).in_family("mean velocity");
        if !filled {
            return panel;
        }
        let mut panel = panel.with(solid, "particles", SeriesStyle::Dashed);
        panel.lines[0].label = "fluid".into();
        panel
    };
    let components = components.into_iter().zip(&solid).take(dimension);
    let mut panels: Vec<Panel> = components.map(panel).collect();
    if filled {
        panels.push(Panel::of("solid_fraction", "solid fraction", "", "height", &height));
    }
    let from = runs.iter().filter_map(|run| Some(run.case.statistics.as_ref()?.from));
    let from = from.fold(0.0, f64::max);
    let note =
        format!("means over each layer of cells and over the time from {} s on", rounded(from));
    let plot = Plot {
        groups,
        panels,
        title: format!("profile over {axis}"),
        notes: vec![note],
        beside: true,
        upright: true,
        ..Plot::default()
    };
    Ok(plot.chart())
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
        let run = Run::of_text(
            folder.path(),
            "name = \"t\"\ntime.end = 9.0\ndomain = { size = [1.0, 2.0], cells = [8, 16] }\n\
            fluid = { density = 2.0, viscosity = 0.1 }\n\
            boundary = { west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" }\n",
        );
        let runs = [run];
        let drawn = |kind| probes(&runs, kind).unwrap().unwrap();
        let labels = |chart: &Chart| {
            chart.panels.iter().map(|(axes, _)| axes.y_label.clone()).collect::<Vec<_>>()
        };
        let points = drawn(Probes::OverTime);
        assert_eq!(labels(&points), ["velocity along x (m/s)", "pressure (Pa)"]);
        assert_eq!(
            points.panels[0].1[0].points,
            [(0.0, 0.5), (1.0, 1.5), (2.0, 2.5), (3.0, 3.5), (4.0, 4.5)]
        );
        let lines = drawn(Probes::AlongLines);
        assert_eq!(labels(&lines)[..2], ["velocity along x (m/s)", "velocity along y (m/s)"]);
        assert_eq!(lines.panels[1].1[0].points, [(0.0, 2.0), (1.0, 2.0), (2.0, 2.0)]);
    }
}
