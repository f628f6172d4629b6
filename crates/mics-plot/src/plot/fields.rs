//! Planes of the flow from a run's snapshots: which ones, and what of them a figure shows.

use super::discs::{Colours, discs, grey_scale, start};
use super::section;
use crate::figure::{Disc, Plane, Quantity, Style};
use mics_run::bodies::{self, Pose};
use mics_run::config::{Case, Section};
use mics_run::not_a_run;
use mics_run::snapshot::Snapshot;
use mics_run::words::rounded;
use mics_run::{Error, Result};
use std::collections::{BTreeSet, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

/// Panels of a strip where no times are asked for.
const PANELS: usize = 6;
/// Layers of cells inside a body that take their values from outside, for lines and colours that
/// reach its surface.
const LAYERS: usize = 2;

/// The snapshots of a run.
///
/// # Errors
/// When there is none.
pub fn snapshots(run: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(run.join("fields")).into_iter().flatten().flatten();
    let paths = entries.map(|e| e.path()).filter(|p| p.extension().is_some_and(|x| x == "vti"));
    let mut paths: Vec<PathBuf> = paths.collect();
    // Their names are the numbers of steps.
    paths.sort();
    if paths.is_empty() { Err(without_fields(run)) } else { Ok(paths) }
}

/// The last snapshot of a run.
pub fn newest_snapshot(run: &Path) -> Result<PathBuf> {
    snapshots(run)?.pop().ok_or_else(|| without_fields(run))
}

/// The refusal of a run that has no snapshot.
fn without_fields(run: &Path) -> Error {
    not_a_run(
        run,
        "fields/ holds no snapshot; a study keeps none: run the case.toml in there by itself, or \
        draw the figures of its runs by \"output.figures\" = true in its [set]",
    )
}

/// The planes of a run at the snapshots next to some times (s), or evenly from the first after the
/// start to the last.
///
/// # Errors
/// When the run has too few snapshots.
pub fn planes(
    run: &Path,
    case: &Case,
    section: Option<Section>,
    times: &[f64],
) -> Result<Vec<Plane>> {
    let taken = choose(run, times)?;
    let times: Vec<f64> = taken.iter().map(|(time, _)| *time).collect();
    let poses = taken
        .iter()
        .map(|(_, path)| bodies::of(path, case.particle.len()))
        .collect::<Result<Vec<_>>>()?;
    // One plane for all panels, where it would be at the end.
    let last = |id: usize| poses.last()?.get(&id).copied();
    let section = section.or_else(|| sections(case, last).first().copied());
    let section = section.unwrap_or(Section::Z(0.0));
    let look = Look { digits: digits(&times), ..Look::default() };
    let panel = |((_, path), poses): (&(f64, PathBuf), &HashMap<usize, Pose>)| {
        let place = |id: usize| poses.get(&id).copied();
        plane(case, &Snapshot::read(path)?, run, section, &place, &look)
    };
    taken.iter().zip(&poses).map(panel).collect()
}

/// The snapshots that a strip shows, with their times (s).
///
/// # Errors
/// When there are too few.
pub fn choose(run: &Path, times: &[f64]) -> Result<Vec<(f64, PathBuf)>> {
    let mut all = dated(run)?;
    let few = |there: usize, wanted: usize| {
        Error::Usage(format!(
            "{}: {there} snapshots are too few for {wanted} panels; run the case again with more \
            of them, as in --set output.fields.every_time=0.05, or ask for fewer --times",
            run.display()
        ))
    };
    if times.is_empty() {
        // The state at the start is the case's, and shows nothing of the flow.
        all.retain(|(time, _)| *time > 0.0);
        let count = PANELS.min(all.len());
        if count < 2 {
            return Err(few(count, 2));
        }
        return Ok(evenly(all.len(), count).map(|k| all[k].clone()).collect());
    }
    times.iter().try_for_each(|time| check_time(run, &all, *time))?;
    let chosen: BTreeSet<usize> = times.iter().map(|time| nearest(&all, *time)).collect();
    if chosen.len() < times.len() {
        return Err(few(all.len(), times.len()));
    }
    Ok(chosen.into_iter().map(|k| all[k].clone()).collect())
}

/// The snapshots of a run with their times (s).
///
/// # Errors
/// When there is none, or one is no snapshot.
pub fn dated(run: &Path) -> Result<Vec<(f64, PathBuf)>> {
    snapshots(run)?.into_iter().map(|path| Ok((Snapshot::time_of(&path)?, path))).collect()
}

/// Refuses a time (s) that lies before the first or after the last of a run's snapshots by more
/// than half their distance.
///
/// # Errors
/// When it does, with the times that there are.
pub fn check_time(run: &Path, all: &[(f64, PathBuf)], time: f64) -> Result<()> {
    let (Some((first, _)), Some((last, _))) = (all.first(), all.last()) else { return Ok(()) };
    let room = 0.5 * (last - first) / all.len().saturating_sub(1).max(1) as f64 + 1e-9 * last.abs();
    if (first - room..=last + room).contains(&time) {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--times {time}: the snapshots of {} are from t = {} to {} s; give times in there",
        run.display(),
        rounded(*first),
        rounded(*last)
    )))
}

/// The number of the snapshot next to a time (s).
pub fn nearest(all: &[(f64, PathBuf)], time: f64) -> usize {
    let off = |k: &usize| (all[*k].0 - time).abs();
    (0..all.len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
}

/// Numbers below `of`, `count` at even distances, the first and the last among them.
pub fn evenly(of: usize, count: usize) -> impl Iterator<Item = usize> {
    let gaps = count.saturating_sub(1).max(1);
    (0..count).map(move |k| (k * of.saturating_sub(1) + gaps / 2) / gaps)
}

/// Digits after the point that tell times apart, and one more.
pub fn digits(times: &[f64]) -> usize {
    let least = times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let least = if least.is_finite() && least > 0.0 {
        least
    } else {
        times.first().copied().unwrap_or(1.0)
    };
    (1.0 - least.max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize
}

/// Where a case's figures cut its flow, with the particles where they are at a moment.
pub fn sections(case: &Case, place: impl Fn(usize) -> Option<Pose>) -> Vec<Section> {
    section::sections(case, |id| {
        place(id).map_or_else(|| start(&case.particle[id]), |pose| pose.centre)
    })
}

/// Contents of a picture of a plane.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Quantity that the colours of the flow show.
    pub quantity: Quantity,
    /// Meaning of the particles' colours; where it is absent they are grey, with their names or
    /// numbers.
    pub colours: Option<Colours>,
    /// Digits of the time in the title.
    pub digits: usize,
}

impl Look {
    /// Vorticity with grey bodies, for the state at a time (s).
    pub fn at(time: f64) -> Look {
        Look { digits: digits(&[time]) + 2, ..Look::default() }
    }
}

impl Default for Look {
    fn default() -> Look {
        Look { quantity: Quantity::Vorticity, colours: None, digits: 4 }
    }
}

/// The flow in a plane, with the particles in their places: all of a 2D run. Its title is the time.
///
/// # Errors
/// When the snapshot lacks what is shown.
pub fn plane(
    case: &Case,
    snapshot: &Snapshot,
    run: &Path,
    section: Section,
    place: &dyn Fn(usize) -> Option<Pose>,
    look: &Look,
) -> Result<Plane> {
    let (axis, cell, height) = section::layer(section, snapshot);
    let axes = section::axes(axis);
    let component = |name: &str, k: usize| -> Result<Vec<f64>> {
        let array = snapshot
            .array(name)
            .ok_or_else(|| not_a_run(run, &format!("its fields have no {name}")))?;
        Ok(section::component(array, snapshot.cells, axis, cell, k))
    };
    let cells = axes.map(|a| snapshot.cells[a]);
    let size = axes.map(|a| snapshot.cells[a] as f64 * snapshot.h[a]);
    let mut values = match look.quantity {
        Quantity::Vorticity => component("vorticity", axis)?,
        Quantity::Pressure => component("pressure", 0)?,
        Quantity::Speed => {
            let parts = [0, 1, 2].map(|k| component("velocity", k));
            let [x, y, z] = parts;
            let squares = x?.into_iter().zip(y?).zip(z?).map(|((x, y), z)| x * x + y * y + z * z);
            squares.map(f64::sqrt).collect()
        }
    };
    if look.quantity == Quantity::Vorticity {
        values.iter_mut().for_each(|value| *value *= section::sense(axis));
    }
    // A run without particles has no such array.
    if let Ok(solid) = component("solid_fraction", 0) {
        hide(&mut values, &solid, cells);
    }
    let names = ["x", "y", "z"];
    let digits = look.digits;
    Ok(Plane {
        cells,
        size,
        velocity: [component("velocity", axes[0])?, component("velocity", axes[1])?],
        values,
        quantity: look.quantity,
        corner: [0.0; 2],
        discs: discs(case, axis, height, size, place, look.colours.as_ref()),
        scale: look.colours.map_or_else(|| grey_scale(case), |colours| Some(colours.scale(case))),
        labels: axes.map(|a| format!("{} (m)", names[a])),
        title: format!("t = {:.digits$} s", snapshot.time),
        place: if snapshot.cells[2] > 1 {
            format!(", {} = {} m", names[axis], rounded(height))
        } else {
            String::new()
        },
        style: Style::default(),
    })
}

/// Takes away the values of cells that are mostly solid, where they are none of the fluid's; the
/// outermost of them get what is beside them outside, so that lines and colours reach the surface.
fn hide(values: &mut [f64], solid: &[f64], [nx, ny]: [usize; 2]) {
    let cells = values.iter_mut().zip(solid);
    cells.filter(|(_, solid)| **solid > 0.5).for_each(|(value, _)| *value = f64::NAN);
    for _ in 0..LAYERS {
        let before = values.to_vec();
        let around = |k: usize, n: usize| k.saturating_sub(1)..(k + 2).min(n);
        for cell in (0..nx * ny).filter(|cell| before[*cell].is_nan()) {
            let beside =
                around(cell / nx, ny).flat_map(|j| around(cell % nx, nx).map(move |i| j * nx + i));
            let (sum, count) = beside
                .map(|at| before[at])
                .filter(|value| value.is_finite())
                .fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
            values[cell] = sum / count;
        }
    }
}

/// The part of a plane in the window `[x0, x1, y0, y1]` (m), in whole cells.
///
/// # Errors
/// When the window holds no cell of the plane.
pub fn cut(plane: Plane, window: [f64; 4]) -> Result<Plane> {
    let h = [0, 1].map(|k| plane.size[k] / plane.cells[k] as f64);
    let cells = [0, 1].map(|k| {
        let cell = |place: f64| (place / h[k]).clamp(0.0, plane.cells[k] as f64);
        cell(window[2 * k] + 1e-6 * h[k]) as usize
            ..cell(window[2 * k + 1] - 1e-6 * h[k]).ceil() as usize
    });
    let [columns, rows] = cells;
    if columns.is_empty() || rows.is_empty() {
        return Err(Error::Usage(format!(
            "--window {window:?}: none of the {} m x {} m of the run; give X0,X1,Y0,Y1 in m",
            plane.size[0], plane.size[1]
        )));
    }
    let part = |values: &[f64]| {
        let row = |j: usize| &values[j * plane.cells[0]..][columns.clone()];
        rows.clone().flat_map(row).copied().collect()
    };
    let corner = [columns.start as f64 * h[0], rows.start as f64 * h[1]];
    let size = [columns.len() as f64 * h[0], rows.len() as f64 * h[1]];
    let moved =
        |disc: &Disc| Disc { centre: [0, 1].map(|k| disc.centre[k] - corner[k]), ..disc.clone() };
    let reaches =
        |d: &Disc| (0..2).all(|k| d.centre[k] > -d.radius && d.centre[k] < size[k] + d.radius);
    Ok(Plane {
        cells: [columns.len(), rows.len()],
        velocity: plane.velocity.each_ref().map(|own| part(own)),
        values: part(&plane.values),
        discs: plane.discs.iter().map(moved).filter(reaches).collect(),
        size,
        corner,
        ..plane
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn window_cuts_whole_cells() {
        let values: Vec<f64> = (0..12).map(f64::from).collect();
        let disc = |x: f64, y: f64| Disc { centre: [x, y], radius: 0.4, ..Disc::default() };
        let plane = Plane {
            cells: [4, 3],
            size: [4.0, 3.0],
            velocity: [values.clone(), values.clone()],
            values,
            discs: vec![disc(0.3, 0.3), disc(2.2, 1.2)],
            ..Plane::default()
        };
        let part = cut(plane.clone(), [1.0, 2.5, 1.0, 9.0]).unwrap();
        assert_eq!((part.cells, part.size, part.corner), ([2, 2], [2.0, 2.0], [1.0, 1.0]));
        assert_eq!(part.values, [5.0, 6.0, 9.0, 10.0]);
        assert_eq!(part.discs.len(), 1);
        assert!(
            (part.discs[0].centre[0] - 1.2).abs() < 1e-12
                && (part.discs[0].centre[1] - 0.2).abs() < 1e-12
        );
        for window in [[5.0, 6.0, 0.0, 1.0], [2.0, 1.0, 0.0, 1.0], [0.0, 1.0, -2.0, -1.0]] {
            let said = cut(plane.clone(), window).unwrap_err().to_string();
            assert!(said.contains("--window") && said.contains("4 m x 3 m"), "{said}");
        }
    }

    #[test]
    fn vorticity_hidden_in_body_and_extended_at_surface() {
        let solid: Vec<f64> = (0..49)
            .map(|c| if (1..6).contains(&(c % 7)) && (1..6).contains(&(c / 7)) { 1.0 } else { 0.4 })
            .collect();
        let mut vorticity = vec![3.0; 49];
        vorticity.iter_mut().zip(&solid).filter(|(_, s)| **s == 1.0).for_each(|(v, _)| *v = 1e9);
        hide(&mut vorticity, &solid, [7, 7]);
        assert!(vorticity[24].is_nan(), "the middle, three layers deep");
        assert_eq!(vorticity.iter().filter(|v| **v == 3.0).count(), 48);
    }

    #[test]
    fn time_labels_have_distinguishing_digits() {
        assert_eq!(
            [&[0.05, 0.1][..], &[2.0, 6.0, 10.0], &[0.0021, 0.0022], &[30.0], &[]].map(digits),
            [3, 1, 5, 0, 1]
        );
    }
}
