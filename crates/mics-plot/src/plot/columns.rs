//! Columns of a run's tables by name with their units: `wx,wy` are two panels,
//! `fluid_fx+contact_fx` are two lines of one.

use super::Run;
use super::bodies::{self, PARTICLES, groups};
use super::series::{Group, Panel, Plot, averaged};
use super::table::{Rows, Table};
use crate::figure::{Chart, SeriesStyle};
use mics_run::folder::{OBSTACLES, PROFILE, SOLVES};
use mics_run::{Error, Result};

/// The tables whose columns can be asked for: that of the first that has all is drawn.
const TABLES: [&str; 5] = ["steps.csv", PARTICLES, OBSTACLES, PROFILE, SOLVES];

/// Columns of runs over another one, by default the time or the first column of their table: of
/// particles and obstacles a line each, of many by kinds.
///
/// # Errors
/// When no table of a run has all of them.
pub fn columns(
    runs: &[Run],
    asked: &[String],
    over: Option<&str>,
    mean: bool,
) -> Result<Option<Chart>> {
    let panels: Vec<Vec<&str>> = asked.iter().map(|panel| panel.split('+').collect()).collect();
    let wanted = panels.concat();
    let mut all = Vec::new();
    let mut over_of_all = String::new();
    for run in runs {
        let Home { file, first } = home(run, &[&wanted[..], over.as_slice()].concat())?;
        let over = over.unwrap_or(&first);
        let columns = [&[over], &wanted[..]].concat();
        let of_run = match file {
            PARTICLES | OBSTACLES => groups(run, &bodies::loaded(&run.case, &run.asked), &columns)?,
            _ => {
                let table = Table::read(&run.folder, file, &columns)?;
                table.map(|table| Group::new("", table)).into_iter().collect()
            }
        };
        all.extend(run.name(of_run, mean));
        over_of_all = over.to_owned();
    }
    let Some(run) = runs.first() else { return Ok(None) };
    let over = over_of_all;
    let unit = |name: &str| unit(name, run.case.dimension());
    let over_label = match unit(&over) {
        "" => over.clone(),
        unit => format!("{over} ({unit})"),
    };
    let panel = |names: &Vec<&str>| {
        let [first, rest @ ..] = &names[..] else { return Panel::default() };
        let quantity = if rest.is_empty() { first } else { "" };
        let mut panel = Panel::of(first, quantity, unit(first), &over, &over_label);
        for name in rest {
            panel.lines[0].label = (*first).to_owned();
            panel = panel.with(name, name, SeriesStyle::Line);
        }
        panel
    };
    let panels = panels.iter().map(panel).collect();
    let all = if mean { averaged(&all, &over) } else { all };
    Ok(Plot { groups: all, panels, cut_peaks: true, ..Plot::default() }.chart())
}

/// The table that has some columns, and what it is over.
struct Home {
    file: &'static str,
    first: String,
}

/// The first table of a run that has some columns.
fn home(run: &Run, wanted: &[&str]) -> Result<Home> {
    let mut known = String::new();
    for file in TABLES {
        let Some(rows) = Rows::open(&run.folder, file, &[])? else { continue };
        let names: Vec<&str> = rows.names().collect();
        if wanted.iter().all(|name| names.contains(name)) {
            let first = if names.contains(&"time") { "time" } else { names[0] };
            return Ok(Home { file, first: first.to_owned() });
        }
        known += &format!("\n  {file}: {}", names.join(", "));
    }
    Err(Error::Usage(format!(
        "--columns: no table of {} has {}; there are{known}",
        run.folder.display(),
        wanted.join(" and "),
    )))
}

/// The unit of a column of a table (docs/output.md); in 2D loads, momenta and energies are of a
/// metre of depth.
pub fn unit(name: &str, dimension: usize) -> &'static str {
    let flat = dimension == 2;
    let stem = name.strip_suffix(['x', 'y', 'z']).unwrap_or(name);
    match stem {
        "time" | "dt" | "wall" => "s",
        "" | "path_" => "m",
        "angle" => "rad",
        "v" | "u" | "solid_u" | "solid_v" | "solid_w" => "m/s",
        "w" if name == "w" => "m/s",
        "w" => "rad/s",
        "pressure" => "Pa",
        "divergence_max" | "divergence_before" | "divergence_after" => "1/s",
        "drive_f" => "N/m3",
        _ if stem.ends_with("_f") => {
            if flat {
                "N/m"
            } else {
                "N"
            }
        }
        _ if stem.ends_with("_t") => {
            if flat {
                "N m/m"
            } else {
                "N m"
            }
        }
        "momentum_" | "momentum_error" => {
            if flat {
                "kg/s"
            } else {
                "kg m/s"
            }
        }
        "boundary_impulse_" => {
            if flat {
                "N s/m"
            } else {
                "N s"
            }
        }
        _ if ["energy", "work", "loss"].iter().any(|end| name.ends_with(end)) => {
            if flat {
                "J/m"
            } else {
                "J"
            }
        }
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::unit;

    #[test]
    fn columns_have_the_units_of_their_tables() {
        for (name, of_plane, of_space) in [
            ("fluid_fx", "N/m", "N"),
            ("fluid_tz", "N m/m", "N m"),
            ("vy", "m/s", "m/s"),
            ("w", "m/s", "m/s"),
            ("wz", "rad/s", "rad/s"),
            ("y", "m", "m"),
            ("qz", "", ""),
            ("spring_energy", "J/m", "J"),
            ("drive_fx", "N/m3", "N/m3"),
            ("krylov_iterations", "", ""),
        ] {
            assert_eq!((unit(name, 2), unit(name, 3)), (of_plane, of_space), "{name}");
        }
    }
}
