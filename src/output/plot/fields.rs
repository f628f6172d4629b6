//! Planes of the flow from a run's snapshots: which ones, and what of them a figure shows.

use super::rows::Rows;
use super::section;
use crate::config::{Case, Motion, Particle, Section};
use crate::output::figure::{Disc, Plane};
use crate::output::not_a_run;
use crate::output::snapshot::Snapshot;
use crate::{Error, Result};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Panels of a strip where no times are asked for.
const PANELS: usize = 6;
/// Layers of cells inside a body that take their vorticity from outside, for lines and colours that reach its surface.
const LAYERS: usize = 2;

/// The snapshots of a run.
///
/// # Errors
/// When there is none.
fn snapshots(run: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(run.join("fields")).map_err(|e| not_a_run(run, &format!("fields: {e}")))?;
    let paths = entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|x| x == "vti"));
    let mut paths: Vec<PathBuf> = paths.collect();
    // Their names are the numbers of steps.
    paths.sort();
    if paths.is_empty() { Err(not_a_run(run, "fields holds no snapshot")) } else { Ok(paths) }
}

/// The last snapshot of a run.
pub fn newest_snapshot(run: &Path) -> Result<PathBuf> {
    snapshots(run)?.pop().ok_or_else(|| not_a_run(run, "fields holds no snapshot"))
}

/// The planes of a run at the snapshots next to some times (s), or evenly from the first after the start to the last.
///
/// # Errors
/// When the run has too few snapshots.
pub fn planes(run: &Path, case: &Case, section: Option<Section>, times: &[f64]) -> Result<Vec<Plane>> {
    let taken = choose(run, times)?.iter().map(|path| Snapshot::read(path)).collect::<Result<Vec<_>>>()?;
    let times: Vec<f64> = taken.iter().map(|snapshot| snapshot.time).collect();
    let (rows, digits) = (Rows::read(run, case, &times, &[]), digits(&times));
    // One plane for all panels, where it would be at the end.
    let section = section.or_else(|| sections(case, (&rows, times.len() - 1)).first().copied());
    let section = section.unwrap_or(Section::Z(0.0));
    taken.iter().enumerate().map(|(k, snapshot)| plane(case, snapshot, run, section, (&rows, k), digits)).collect()
}

/// The snapshots that a strip shows.
fn choose(run: &Path, times: &[f64]) -> Result<Vec<PathBuf>> {
    let dated = |path: PathBuf| Ok((Snapshot::time_of(&path)?, path));
    let mut all = snapshots(run)?.into_iter().map(dated).collect::<Result<Vec<(f64, PathBuf)>>>()?;
    let few = |there: usize, wanted: usize| {
        Error::Usage(format!(
            "{}: {there} snapshots are too few for {wanted} panels; run the case again with more of them, as in \
             --set output.fields.every_time=0.05, or ask for fewer --times",
            run.display()
        ))
    };
    if times.is_empty() {
        // The state at the start is the case's, and shows nothing of the flow.
        all.retain(|(time, _)| *time > 0.0);
        let (count, last) = (PANELS.min(all.len()), all.len().saturating_sub(1));
        if count < 2 {
            return Err(few(count, 2));
        }
        let even = |k: usize| (k * last + (count - 1) / 2) / (count - 1);
        return Ok((0..count).map(|k| all[even(k)].1.clone()).collect());
    }
    let next = |time: &f64| {
        let off = |k: &usize| (all[*k].0 - time).abs();
        (0..all.len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
    };
    let chosen: BTreeSet<usize> = times.iter().map(next).collect();
    if chosen.len() < times.len() {
        return Err(few(all.len(), times.len()));
    }
    Ok(chosen.into_iter().map(|k| all[k].1.clone()).collect())
}

/// Digits after the point that tell times apart, and one more.
fn digits(times: &[f64]) -> usize {
    let least = times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let least = if least.is_finite() && least > 0.0 { least } else { times.first().copied().unwrap_or(1.0) };
    (1.0 - least.max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize
}

/// Where a case's figures cut its flow, with the particles where they were at one of the rows' times.
pub fn sections(case: &Case, rows: (&Rows, usize)) -> Vec<Section> {
    section::sections(case, |id| rows.0.centre(rows.1, id).unwrap_or_else(|| start(&case.particle[id])))
}

/// The flow in a plane, with the particles where they were at one of the rows' times: all of a 2D run. Its title is the time, with
/// these digits.
///
/// # Errors
/// When the snapshot has no velocity or vorticity.
pub fn plane(
    case: &Case,
    snapshot: &Snapshot,
    run: &Path,
    section: Section,
    rows: (&Rows, usize),
    digits: usize,
) -> Result<Plane> {
    let (axis, cell, height) = section::layer(section, snapshot);
    let axes = section::axes(axis);
    let component = |name: &str, k: usize| -> Result<Vec<f64>> {
        let array = snapshot.array(name).ok_or_else(|| not_a_run(run, &format!("its fields have no {name}")))?;
        Ok(section::component(array, snapshot.cells, (axis, cell), k))
    };
    let cells = axes.map(|a| snapshot.cells[a]);
    let size = axes.map(|a| snapshot.cells[a] as f64 * snapshot.h[a]);
    let mut vorticity = component("vorticity", axis)?;
    vorticity.iter_mut().for_each(|value| *value *= section::sense(axis));
    // A run without particles has no such array.
    if let Ok(solid) = component("solid_fraction", 0) {
        hide(&mut vorticity, &solid, cells);
    }
    let names = ["x", "y", "z"];
    Ok(Plane {
        cells,
        size,
        u: component("velocity", axes[0])?,
        v: component("velocity", axes[1])?,
        vorticity,
        corner: [0.0; 2],
        discs: discs(case, (axis, height), size, |particle| rows.0.centre(rows.1, particle)),
        labels: axes.map(|a| format!("{} (m)", names[a])),
        title: format!("t = {:.digits$} s", snapshot.time),
        place: if snapshot.cells[2] > 1 { format!(", {} = {height:.4} m", names[axis]) } else { String::new() },
    })
}

/// What the plane across `axis` at `height` (m) cuts of the particles, with their images across periodic faces that reach into it.
fn discs(
    case: &Case,
    (axis, height): (usize, f64),
    size: [f64; 2],
    place: impl Fn(usize) -> Option<[f64; 3]>,
) -> Vec<Disc> {
    let range = |value: fn(&Particle) -> f64| {
        let values = case.particle.iter().map(value);
        values.fold((f64::INFINITY, 0.0_f64), |(l, m), v| (l.min(v), m.max(v)))
    };
    let differs = |(least, most): (f64, f64)| most > least * (1.0 + 1e-9);
    // By size, or else by what they are made of.
    let shown: fn(&Particle) -> f64 =
        if differs(range(|p| p.shape.diameter())) { |p| p.shape.diameter() } else { |p| p.density };
    let (least, most) = range(shown);
    let axes = section::axes(axis);
    let mut discs = Vec::new();
    // What moves and has no place has left the box or not come in; where nobody has any, all are where they start.
    let recorded = (0..case.particle.len()).any(|id| place(id).is_some());
    for (id, p) in case.particle.iter().enumerate() {
        let rests = || p.motion == Motion::Fixed || !recorded;
        let Some(at) = place(id).or_else(|| rests().then(|| start(p))) else { continue };
        let across = if case.dimension() == 3 { at[axis] - height } else { 0.0 };
        let off = match case.domain.size.get(axis).filter(|_| case.dimension() == 3 && case.periodic(axis)) {
            Some(length) => across - length * (across / length).round(),
            None => across,
        };
        let diameter = p.shape.diameter();
        let square = 0.25 * diameter * diameter - off * off;
        if square <= 0.0 {
            continue;
        }
        let shade = if differs((least, most)) { (shown(p) - least) / (most - least) } else { 0.5 };
        let number = (case.particle.len() > 1).then_some(id);
        let images = |axis: usize| if case.periodic(axis) { -1..=1 } else { 0..=0 };
        for (ka, kb) in images(axes[0]).flat_map(|ka| images(axes[1]).map(move |kb| (ka, kb))) {
            let centre = [at[axes[0]] + f64::from(ka) * size[0], at[axes[1]] + f64::from(kb) * size[1]];
            let radius = square.sqrt();
            if (0..2).all(|a| centre[a] > -radius && centre[a] < size[a] + radius) {
                discs.push(Disc { centre, radius, shade, number });
            }
        }
    }
    discs
}

fn start(particle: &Particle) -> [f64; 3] {
    std::array::from_fn(|a| particle.position.get(a).copied().unwrap_or(0.0))
}

/// Takes away the vorticity of cells that are mostly solid, where it is none of the fluid's; the outermost of them get what
/// is beside them outside, so that lines and colours reach the surface.
fn hide(vorticity: &mut [f64], solid: &[f64], [nx, ny]: [usize; 2]) {
    let values = vorticity.iter_mut().zip(solid);
    values.filter(|(_, solid)| **solid > 0.5).for_each(|(value, _)| *value = f64::NAN);
    for _ in 0..LAYERS {
        let before = vorticity.to_vec();
        let around = |k: usize, n: usize| k.saturating_sub(1)..(k + 2).min(n);
        for cell in (0..nx * ny).filter(|cell| before[*cell].is_nan()) {
            let beside = around(cell / nx, ny).flat_map(|j| around(cell % nx, nx).map(move |i| j * nx + i));
            let (sum, count) = beside
                .map(|at| before[at])
                .filter(|value| value.is_finite())
                .fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
            vorticity[cell] = sum / count;
        }
    }
}

/// What of a plane is in the window `[x0, x1, y0, y1]` (m), in whole cells.
///
/// # Errors
/// When the window holds no cell of the plane.
pub fn cut(plane: Plane, window: [f64; 4]) -> Result<Plane> {
    let h = [0, 1].map(|k| plane.size[k] / plane.cells[k] as f64);
    let cells = [0, 1].map(|k| {
        let cell = |place: f64| (place / h[k]).clamp(0.0, plane.cells[k] as f64);
        cell(window[2 * k] + 1e-6 * h[k]) as usize..cell(window[2 * k + 1] - 1e-6 * h[k]).ceil() as usize
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
    let moved = |disc: &Disc| Disc { centre: [0, 1].map(|k| disc.centre[k] - corner[k]), ..*disc };
    let reaches = |d: &Disc| (0..2).all(|k| d.centre[k] > -d.radius && d.centre[k] < size[k] + d.radius);
    Ok(Plane {
        cells: [columns.len(), rows.len()],
        u: part(&plane.u),
        v: part(&plane.v),
        vorticity: part(&plane.vorticity),
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
    fn a_window_cuts_whole_cells_and_keeps_every_value_and_particle_in_its_place() {
        let values: Vec<f64> = (0..12).map(f64::from).collect();
        let disc = |x: f64, y: f64| Disc { centre: [x, y], radius: 0.4, shade: 0.5, number: None };
        let plane = Plane {
            cells: [4, 3],
            size: [4.0, 3.0],
            u: values.clone(),
            v: values.clone(),
            vorticity: values,
            discs: vec![disc(0.3, 0.3), disc(2.2, 1.2)],
            ..Plane::default()
        };
        let part = cut(plane.clone(), [1.0, 2.5, 1.0, 9.0]).unwrap();
        assert_eq!((part.cells, part.size, part.corner), ([2, 2], [2.0, 2.0], [1.0, 1.0]));
        assert_eq!(part.vorticity, [5.0, 6.0, 9.0, 10.0]);
        assert_eq!(part.discs.len(), 1);
        assert!((part.discs[0].centre[0] - 1.2).abs() < 1e-12 && (part.discs[0].centre[1] - 0.2).abs() < 1e-12);
        for window in [[5.0, 6.0, 0.0, 1.0], [2.0, 1.0, 0.0, 1.0], [0.0, 1.0, -2.0, -1.0]] {
            let said = cut(plane.clone(), window).unwrap_err().to_string();
            assert!(said.contains("--window") && said.contains("4 m x 3 m"), "{said}");
        }
    }

    #[test]
    fn vorticity_in_a_body_is_not_shown_but_its_skin_takes_that_of_the_fluid_beside_it() {
        let solid: Vec<f64> =
            (0..49).map(|c| if (1..6).contains(&(c % 7)) && (1..6).contains(&(c / 7)) { 1.0 } else { 0.4 }).collect();
        let mut vorticity = vec![3.0; 49];
        vorticity.iter_mut().zip(&solid).filter(|(_, s)| **s == 1.0).for_each(|(v, _)| *v = 1e9);
        hide(&mut vorticity, &solid, [7, 7]);
        assert!(vorticity[24].is_nan(), "the middle, three layers deep");
        assert_eq!(vorticity.iter().filter(|v| **v == 3.0).count(), 48);
    }

    #[test]
    fn times_are_written_with_the_digits_that_tell_them_apart() {
        assert_eq!([&[0.05, 0.1][..], &[2.0, 6.0, 10.0], &[0.0021, 0.0022], &[30.0], &[]].map(digits), [3, 1, 5, 0, 1]);
    }
}
