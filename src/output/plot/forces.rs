//! Forces on particles: over time, and over the height of one in the three parts of (19) (Fig. 10); speeds of free ones.

use super::paths::upright;
use super::rows::{self, Rows};
use super::section::leading;
use crate::Result;
use crate::config::{Case, WallRule};
use crate::output::figure::{Axes, Series, SeriesStyle};
use std::f64::consts::PI;

/// Way, in diameters, over which each point of the parts of a force is a mean: single steps jump as cells change sides.
const MEAN: f64 = 0.1;

/// The axis that says most of a case: along the stream or gravity.
fn along(case: &Case) -> &'static str {
    ["x", "y", "z"][leading(case).unwrap_or(0)]
}

/// Force over time on the particles that are `asked` for or the first ones, with what the vertical axis says: on one along each axis,
/// and its three parts along the stream or gravity; on several along that alone.
///
/// # Errors
/// When `particles.csv` lacks a column.
pub fn forces(case: &Case, rows: &Rows, asked: &[usize]) -> Result<(String, Vec<Series>)> {
    let (ids, a) = (rows::loaded(case, asked), along(case));
    // The first steps of an impulsive start would flatten all that follows.
    let curve = |id: usize, column: &str, label: &str, style| {
        let mut series = rows.curve(id, "time", column, label)?;
        series.points.retain(|p| p.0 > 0.02 * case.time.end);
        Ok(Series { style, ..series })
    };
    let id = match ids[..] {
        _ if rows.is_empty() => return Ok(Default::default()),
        [id] => id,
        _ => {
            let column = format!("fluid_f{a}");
            let series = ids.iter().map(|id| curve(*id, &column, &case.called(*id), SeriesStyle::Line));
            return Ok((format!("force of the fluid along {a} (N)"), series.collect::<Result<_>>()?));
        }
    };
    let names = &["x", "y", "z"][..case.dimension()];
    let whole = names.iter().map(|a| (format!("fluid_f{a}"), format!("fluid, along {a}"), SeriesStyle::Line));
    let parts = ["pressure", "viscous", "convective"].into_iter().zip(words(case));
    let parts = parts.map(|(name, words)| (format!("{name}_f{a}"), format!("{words}, {a}"), SeriesStyle::Dashed));
    let series = whole.chain(parts).map(|(name, label, style)| curve(id, &name, &label, style));
    Ok((format!("force on {} (N)", case.called(id)), series.collect::<Result<_>>()?))
}

/// What the pressure, viscous and convective columns of a force are.
pub fn words(case: &Case) -> [&'static str; 3] {
    match case.coupling.wall {
        WallRule::Sharp => ["pressure on the surface", "shear on the surface", "the rest"],
        WallRule::Mixing => ["pressure part of (19)", "viscous part", "convective part"],
    }
}

/// Velocity over time of the free particles among those that are `asked` for or the first that move, with what the vertical axis says:
/// of one along each axis, of several along the stream or gravity.
///
/// # Errors
/// When `particles.csv` lacks a column.
pub fn speeds(case: &Case, rows: &Rows, asked: &[usize]) -> Result<(String, Vec<Series>)> {
    let mut ids = rows::moving(case, asked);
    ids.retain(|id| case.particle[*id].is_free());
    let a = along(case);
    let (label, series): (_, Result<_>) = match ids[..] {
        _ if rows.is_empty() => return Ok(Default::default()),
        [id] => {
            let axes = ["x", "y", "z"].into_iter().take(case.dimension());
            let series = axes.map(|a| rows.curve(id, "time", &format!("v{a}"), &format!("along {a}")));
            (format!("velocity of {} (m/s)", case.called(id)), series.collect())
        }
        _ => {
            let series = ids.iter().map(|id| rows.curve(*id, "time", &format!("v{a}"), &case.called(*id)));
            (format!("velocity along {a} (m/s)"), series.collect())
        }
    };
    Ok((label, series?))
}

/// The parts of (19) across gravity, of the first free particle, or of those that are `asked` for, until it first touches something: over the height of its
/// centre in diameters, from the start's on, as parts of its submerged weight `|rho_p - rho_f| V |g|`. None where nothing is
/// free or nothing pulls at it.
///
/// # Errors
/// When `particles.csv` lacks a column.
pub fn parts(case: &Case, rows: &Rows, asked: &[usize]) -> Result<Option<(Axes, Vec<Series>)>> {
    let free = rows::moving(case, asked).into_iter().find(|id| case.particle[*id].is_free());
    let (Some(id), Some(up)) = (free, upright(case)) else { return Ok(None) };
    let gravity = &case.fluid.gravity;
    let (particle, diameter) = (&case.particle[id], case.particle[id].shape.diameter());
    let circle = 0.25 * PI * diameter * diameter;
    let volume = if case.dimension() == 2 { circle } else { 2.0 / 3.0 * diameter * circle };
    let pull = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    let weight = (particle.density - case.fluid.density).abs() * volume * pull;
    if weight == 0.0 || rows.is_empty() {
        return Ok(None);
    }
    let column = |name: &str| rows.column(id, name);
    let places = [column("x")?, column("y")?, column("z")?];
    let time = column("time")?;
    let contact = [column("contact_fx")?, column("contact_fy")?, column("contact_fz")?];
    let touches = (0..time.len()).position(|row| contact.iter().any(|force| force[row] != 0.0));
    // One that lies on something from the first has no fall to show: all of it, then.
    let end = touches.filter(|row| *row > 1).unwrap_or(time.len());

    let height = |row: usize| {
        let above = if gravity[up] < 0.0 { places[up][row] } else { case.domain.size[up] - places[up][row] };
        above / diameter
    };
    let mut way = vec![0.0; end];
    for row in 1..end {
        let step = places.iter().map(|place| (place[row] - place[row - 1]).powi(2)).sum::<f64>().sqrt();
        way[row] = way[row - 1] + step / diameter;
    }
    let across = if up == 0 { "y" } else { "x" };
    let [pressure, viscous, convective] = words(case);
    let parts = [("convective", "F_c", convective), ("pressure", "F_p", pressure), ("viscous", "F_d", viscous)];
    let parts = parts.map(|(part, symbol, words)| {
        let force = running_mean(&column(&format!("{part}_f{across}"))?[..end], &time, &way);
        let points = force.into_iter().enumerate().skip(1).map(|(row, force)| (height(row), force / weight)).collect();
        let label = match case.coupling.wall {
            WallRule::Sharp => format!("{words}, {across}"),
            WallRule::Mixing => format!("{symbol}{across}, {words}"),
        };
        Ok(Series { label, points, style: SeriesStyle::Line })
    });
    let axes = Axes {
        x_label: if gravity[up] < 0.0 { format!("{}/d", ["x", "y", "z"][up]) } else { "height/d".into() },
        y_label: "force / submerged weight".into(),
        falling_x: height(end - 1) < height(0),
        title: format!("fluid force along {across} on {}, mean over {MEAN} d of its way", case.called(id)),
        ..Axes::default()
    };
    Ok(Some((axes, parts.into_iter().collect::<Result<_>>()?)))
}

/// The mean over time of each row and of those within half of [`MEAN`] of the way before and behind it.
fn running_mean(force: &[f64], time: &[f64], way: &[f64]) -> Vec<f64> {
    // A row's force is that of the step that ends with it.
    let step = |row: usize| if row == 0 { 0.0 } else { time[row] - time[row - 1] };
    let (mut low, mut high, mut sum, mut length) = (0, 0, 0.0, 0.0);
    let mean = |row: usize| {
        while high < way.len() && way[high] <= way[row] + 0.5 * MEAN {
            (sum, length, high) = (sum + step(high) * force[high], length + step(high), high + 1);
        }
        while way[low] < way[row] - 0.5 * MEAN {
            (sum, length, low) = (sum - step(low) * force[low], length - step(low), low + 1);
        }
        sum / length
    };
    (0..way.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disc of 0.2 m and 2.5 times the fluid's density falls along -y at 1 m/s from 1.8 m, and touches the floor.
    fn fall(gravity: &str) -> (Case, Rows) {
        let case = crate::config::written(&format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [1.0, 2.0], cells = [8, 16] }}\n\
             fluid = {{ density = 2.0, viscosity = 0.1, gravity = {gravity} }}\n\
             boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" }}\n\
             particle = [{{ shape = {{ disc = {{ diameter = 0.2 }} }}, density = 5.0, position = [0.5, 1.8] }}]\n"
        ));
        let head = "time,id,x,y,z,vx,vy,vz,contact_fx,contact_fy,contact_fz,\
                    convective_fx,pressure_fx,viscous_fx,convective_fy,pressure_fy,viscous_fy\n";
        let row = |k: i32| {
            let (time, noise) = (0.001 * f64::from(k), if k % 2 == 0 { 1.0 } else { -1.0 });
            let y = (1.8 - time).max(0.1);
            let touches = if y > 0.1 { 0.0 } else { 9.0 };
            format!("{time},0,0.5,{y},0,0,-1,0,0,{touches},0,{noise},{},0.5,0,1,0\n", 3.0 * y + noise)
        };
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("particles.csv"), head.to_owned() + &(0..2000).map(row).collect::<String>())
            .unwrap();
        let case = case.unwrap();
        let rows = Rows::read(folder.path(), &case, &[], &[]);
        (case, rows)
    }

    #[test]
    fn parts_of_the_force_are_means_over_the_submerged_weight_from_the_start_to_the_first_contact() {
        let (case, rows) = fall("[0.0, -10.0]");
        let (axes, parts) = super::parts(&case, &rows, &[]).unwrap().unwrap();
        assert_eq!((axes.x_label.as_str(), axes.falling_x), ("y/d", true));
        assert_eq!(
            parts.iter().map(|s| s.label.as_str()).collect::<Vec<_>>(),
            ["the rest, x", "pressure on the surface, x", "shear on the surface, x"]
        );
        let weight = 3.0 * PI * 0.01 * 10.0;
        let (first, last) = (parts[1].points[0], parts[1].points[parts[1].points.len() - 1]);
        assert!((first.0 - 9.0).abs() < 0.01 && (last.0 - 0.5).abs() < 0.01, "{first:?} to {last:?}");
        // Away from both ends the mean of a force that is linear in the height is its value, that of noise next to nothing.
        for (noise, pressure) in parts[0].points.iter().zip(&parts[1].points).filter(|(p, _)| (1.0..8.0).contains(&p.0))
        {
            assert!((pressure.1 * weight - 0.6 * pressure.0).abs() < 0.1, "{pressure:?}");
            assert!((noise.1 * weight).abs() < 0.1, "{noise:?}");
        }
        assert!(parts[2].points.iter().all(|p| (p.1 * weight - 0.5).abs() < 1e-12));
    }

    #[test]
    fn parts_are_across_gravity_and_need_something_that_pulls() {
        let (case, rows) = fall("[10.0, 0.0]");
        let (axes, parts) = super::parts(&case, &rows, &[]).unwrap().unwrap();
        assert_eq!((axes.x_label.as_str(), parts[1].label.as_str()), ("height/d", "pressure on the surface, y"));
        assert!(parts[1].points.iter().all(|p| (p.0 - 2.5).abs() < 1e-12), "from the wall that it is pulled to");
        let (mut case, rows) = fall("[0.0, -10.0]");
        case.coupling.wall = WallRule::Mixing;
        let (_, parts) = super::parts(&case, &rows, &[]).unwrap().unwrap();
        let labels: Vec<_> = parts.iter().map(|s| s.label.as_str()).collect();
        assert_eq!(labels, ["F_cx, convective part", "F_px, pressure part of (19)", "F_dx, viscous part"]);
        let (mut case, rows) = fall("[0.0, 0.0]");
        assert!(super::parts(&case, &rows, &[]).unwrap().is_none());
        case.fluid.gravity = vec![0.0, -10.0];
        case.particle[0].density = case.fluid.density;
        assert!(super::parts(&case, &rows, &[]).unwrap().is_none(), "as heavy as the fluid");
    }
}
