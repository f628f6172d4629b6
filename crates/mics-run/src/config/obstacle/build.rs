//! Builds walls in the box from typed obstacles: files are read, and numbers checked.

use super::heights::Raster;
use super::wall::Form;
use super::*;
use crate::config::fault::{AXES, Check, Fault, finite, vector};
use crate::config::particle::{motion, printable, slack};
use crate::config::shape::outline::{self, Flaw};
use crate::config::source::{Source, factor, named, one_of};
use crate::config::{Case, Motion, Particle, Prescribed};
use crate::words::{brief, rounded};
use mics_shapes::{Extent, Shape, stl};
use nalgebra::Vector3;
use std::collections::HashSet;
use std::path::Path;

/// Lengths of the box beyond which an obstacle is most likely in another unit.
const FAR: f64 = 100.0;

/// Lengths of the box beyond which the length of an obstacle is noted.
const LONG: f64 = 10.0;

/// Least cells along the part of an obstacle in the box: with fewer it is most likely in another
/// unit.
const FEWEST_CELLS: f64 = 3.0;

/// Surface patches along a body that are tested for lying in a wall.
const ALONG: f64 = 32.0;

/// Builds the walls of the obstacles of a checked case; files are looked for from `folder` on.
/// Returns notes on them, a line each.
pub(in crate::config) fn build(case: &mut Case, folder: &Path) -> Result<Vec<String>, Fault> {
    let mut notes = Vec::new();
    let mut names = HashSet::new();
    for index in 0..case.obstacle.len() {
        let key = format!("obstacle.{index}");
        let typed = &case.obstacle[index];
        if let Some(name) = typed.name.as_deref() {
            let key = format!("{key}.name");
            ensure!(!name.is_empty(), key, "is empty: give the obstacle a name, or remove the key");
            printable(&key, Some(name))?;
            ensure!(
                names.insert(name.to_owned()),
                key,
                "\"{name}\" names another obstacle already: give each its own name"
            );
        }
        ensure!(
            typed.material.as_deref() != Some(""),
            format!("{key}.material"),
            "is empty: give the material a name, or remove the key"
        );
        printable(&format!("{key}.material"), typed.material.as_deref())?;
        let wall = wall(case, typed, &key, folder, &mut notes)?;
        let moved = &case.obstacle[index].motion;
        let key = format!("{key}.motion");
        ensure!(
            *moved != Motion::Free,
            key,
            "is fixed or prescribed: what floats is a [[particle]]"
        );
        motion(moved, &key, case.dimension())?;
        if let Motion::Prescribed(prescribed) = moved {
            keeps_off_sides(case, &wall, prescribed, &key)?;
        }
        let obstacle = &mut case.obstacle[index];
        obstacle.motion.fill(case.domain.size.len());
        obstacle.become_wall(wall);
    }
    let spacing = case.widest_spacing();
    let at_rest = case.obstacle.iter_mut().filter(|o| o.motion == Motion::Fixed);
    Wall::unite(at_rest.filter_map(|o| o.wall.as_mut()), spacing)
        .map_err(|fault| Fault { key: "obstacle".to_owned(), message: fault.0 })?;
    Ok(notes)
}

/// The box that obstacles stand in.
fn room(case: &Case) -> Extent {
    let size = Vector3::from_fn(|a, _| case.domain.size.get(a).copied().unwrap_or(1.0));
    Extent { size, periodic: [0, 1, 2].map(|a| a < case.dimension() && case.periodic(a)) }
}

/// Name of the key that gives an obstacle's form; checks its position and centre.
fn kind(
    typed: &Obstacle,
    key: &str,
    room: &Extent,
    dimension: usize,
) -> Result<&'static str, Fault> {
    let Obstacle { polygon, surface, heights, position, centre, .. } = typed;
    let kinds = [
        ("polygon", polygon.is_some()),
        ("surface", surface.is_some()),
        ("heights", heights.is_some()),
    ];
    one_of(key, &kinds)?;
    ensure!(
        polygon.is_none() || dimension == 2,
        format!("{key}.polygon"),
        "is for 2D; this case is 3D: give a surface or heights"
    );
    ensure!(
        surface.is_none() || dimension == 3,
        format!("{key}.surface"),
        "is for 3D; this case is 2D: give a polygon or heights"
    );
    for (name, given) in [("position", position), ("centre", centre)] {
        given.as_ref().map_or(Ok(()), |at| vector(&format!("{key}.{name}"), at, dimension, "m"))?;
    }
    for (axis, at) in centre.iter().flatten().enumerate() {
        let key = format!("{key}.centre.{axis}");
        let size = room.size[axis];
        ensure!(
            (0.0..=size).contains(at),
            key,
            "must lie in the box, from 0 to {size:?} m, not at {at:?}"
        );
        ensure!(
            !room.periodic[axis] || typed.motion != Motion::Fixed || *at == 0.5 * size,
            key,
            "must be the middle of the box, {:?} m, along {}, which is periodic, of an obstacle \
            that rests, not {at:?}",
            0.5 * size,
            AXES[axis]
        );
    }
    Ok(kinds.iter().find(|(_, given)| *given).map_or("", |(name, _)| name))
}

/// The wall that an obstacle is.
fn wall(
    case: &Case,
    typed: &Obstacle,
    key: &str,
    folder: &Path,
    notes: &mut Vec<String>,
) -> Result<Wall, Fault> {
    let dimension = case.dimension();
    let room = room(case);
    let Obstacle { polygon, surface, heights, position, centre, .. } = typed;
    let key = &format!("{key}.{}", kind(typed, key, &room, dimension)?);
    let shift =
        Vector3::from_fn(|a, _| position.as_ref().map_or(0.0, |at| at[a.min(dimension - 1)]));
    let files = [
        polygon.as_ref().and_then(|p| p.file.as_ref()),
        surface.as_ref().and_then(|s| s.file.as_ref()),
        heights.as_ref().and_then(|h| h.file.as_ref()),
    ];
    let file = files.into_iter().flatten().next();
    let path = file.map(|file| Ok(folder.join(named(file, key)?))).transpose()?;
    let of_file = format!("{key}.file");
    let source = path.as_ref().map(|path| Source { path, key: &of_file });
    let refuse = |what: &str| match &source {
        Some(source) => source.refuse(what),
        None => Fault { key: key.clone(), message: what.to_owned() },
    };
    let source = source.as_ref();
    let form = match (polygon, surface, heights) {
        (Some(outlines), ..) => of_outlines(outlines, key, source)?,
        (_, Some(surface), _) => of_surface(surface, key, source)?,
        (.., Some(heights)) => {
            let raster = of_heights(heights, key, source, dimension)?;
            raster.form(dimension, &shift, &room).map_err(|what| refuse(&what))?
        }
        _ => return Err(refuse("is missing")),
    };
    let note = |what: &str| {
        let Fault { key, message } = refuse(what);
        format!("note         {key}: {message}")
    };
    // Forms of heights stand in their place already.
    let shift = if heights.is_some() { Vector3::zeros() } else { shift };
    let (form, said) = form.placed(&shift, &room).map_err(|fault| refuse(&fault.0))?;
    notes.extend(said.iter().map(|what| note(what)));
    let cure = if file.is_some() { "set scale = 0.001" } else { "give them in m" };
    let cure = format!("if its lengths are in mm, {cure}; else look at position and domain.size");
    let boxes = form.length() / room.size.iter().take(dimension).copied().fold(0.0, f64::max);
    if heights.is_none() && boxes > LONG {
        let what = format!("is {} times as long as the box: {cure}", rounded(boxes));
        if boxes > FAR {
            return Err(refuse(&what));
        }
        notes.push(note(&what));
    }
    let moves = typed.motion != Motion::Fixed;
    let wall = Wall::new(form, &room, centre.clone(), moves)
        .map_err(|fault| refuse(&format!("{}: {cure}", fault.0)))?;
    stands(case, &wall).map_err(|what| refuse(&format!("{what}: {cure}")))?;
    Ok(wall)
}

/// Refuses, in words, a wall without volume in the box or far too small for its cells.
fn stands(case: &Case, wall: &Wall) -> Result<(), String> {
    let within = |(x, size): (&f64, &f64)| (0.0..=*size).contains(x);
    if !wall.centre().iter().zip(&case.domain.size).all(within) {
        return Err("has no volume within the domain".to_owned());
    }
    let [low, high] = wall.bounds();
    let cells = (high - low).amax() / case.widest_spacing();
    if cells < FEWEST_CELLS {
        let cells = brief(cells);
        return Err(format!("is {cells} cells long in the box, and {FEWEST_CELLS} are the least"));
    }
    Ok(())
}

fn of_outlines(given: &Outlines, key: &str, source: Option<&Source>) -> Result<Form, Fault> {
    let Outlines { points, outlines, file, scale } = given;
    let given =
        [("points", points.is_some()), ("outlines", outlines.is_some()), ("file", file.is_some())];
    one_of(key, &given)?;
    let factor = factor(key, *scale, file.is_some())?;
    let listed = points.clone().map(|points| vec![points]).or_else(|| outlines.clone());
    let (all, lines): (Vec<_>, Vec<_>) = match source {
        Some(source) => table::outlines(source, factor)?.into_iter().unzip(),
        None => listed.unwrap_or_default().into_iter().map(|points| (points, Vec::new())).unzip(),
    };
    for (k, points) in all.iter().enumerate() {
        let own = if outlines.is_some() {
            format!("{key}.outlines.{k}")
        } else {
            format!("{key}.points")
        };
        for (i, point) in points.iter().enumerate() {
            finite(&format!("{own}.{i}"), point, "m")?;
        }
        outline::simple(points).map_err(|Flaw { corner, what }| match source {
            Some(source) => source.refuse_line(lines[k].get(corner).copied().unwrap_or(1), &what),
            None => Fault { key: format!("{own}.{corner}"), message: what },
        })?;
    }
    ensure!(!all.is_empty(), key, "has no outline: give one at least");
    Ok(Form::Outlines(all))
}

fn of_surface(given: &Surface, key: &str, source: Option<&Source>) -> Result<Form, Fault> {
    let Surface { file, scale, points, triangles } = given;
    one_of(key, &[("file", file.is_some()), ("points", points.is_some())])?;
    ensure!(
        points.is_some() == triangles.is_some(),
        format!("{key}.triangles"),
        "stands beside points, each triangle by the numbers of its corners"
    );
    let factor = factor(key, *scale, file.is_some())?;
    if let Some(source) = source {
        source.exists()?;
        let mesh = stl::read(source.path, factor).map_err(|fault| source.refuse(&fault.0))?;
        let triangles = (0..mesh.len()).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let points = mesh.into_iter().flatten().map(Into::into).collect();
        return Ok(Form::Surface { points, triangles });
    }
    let points = points.clone().unwrap_or_default();
    let triangles = triangles.clone().unwrap_or_default();
    let beyond = triangles.iter().position(|corners| corners.iter().any(|k| *k >= points.len()));
    ensure!(
        beyond.is_none(),
        format!("{key}.triangles.{}", beyond.unwrap_or(0)),
        "names a corner beyond the {} of points, from 0",
        points.len()
    );
    Ok(Form::Surface { points, triangles })
}

fn of_heights(
    given: &Heights,
    key: &str,
    source: Option<&Source>,
    dimension: usize,
) -> Result<Raster, Fault> {
    let Heights { file, scale, points } = given;
    one_of(key, &[("points", points.is_some()), ("file", file.is_some())])?;
    let factor = factor(key, *scale, file.is_some())?;
    if let Some(source) = source {
        return table::heights(source, dimension, factor);
    }
    let points = points.as_deref().unwrap_or_default();
    let key = format!("{key}.points");
    ensure!(dimension == 2, key, "are a line in 2D; in 3D give a file of x, y and z");
    ensure!(!points.is_empty(), key, "is empty: give a point at least");
    for (i, point) in points.iter().enumerate() {
        let key = format!("{key}.{i}");
        finite(&key, point, "m")?;
        let follows = i == 0 || point[0] > points[i - 1][0];
        ensure!(follows, key, "x must increase from point to point");
    }
    let of = |a: usize| points.iter().map(|point| point[a]).collect();
    Ok(Raster { x: of(0), y: vec![0.0], heights: of(1) })
}

/// Refuses a motion that would bring an obstacle to a side of the box: its surface is known only as
/// far as it lies in the box at time 0.
fn keeps_off_sides(case: &Case, wall: &Wall, moved: &Prescribed, key: &str) -> Check {
    let [low, high] = wall.bounds();
    let centre = wall.centre();
    let turns = moved.turns();
    let reach = wall.geometry().radius();
    for axis in 0..case.dimension() {
        let size = case.domain.size[axis];
        let drift = moved.velocity.get(axis).unwrap_or(&0.0) * case.time.end;
        let swing = moved.oscillation.as_ref().map_or(0.0, |o| o.amplitude[axis].abs());
        let (from, to) = if turns {
            (centre[axis] - reach, centre[axis] + reach)
        } else {
            (low[axis], high[axis])
        };
        let from = from + drift.min(0.0) - swing;
        let to = to + drift.max(0.0) + swing;
        ensure!(
            from > 0.0 && to < size,
            key,
            "brings the obstacle from {} to {} m along {}, and what moves must stay in the box, \
             from 0 to {size:?} m: its surface is known only there",
            rounded(from),
            rounded(to),
            AXES[axis]
        );
    }
    Ok(())
}

/// Refuses particles that overlap an obstacle at time 0 by more than pressed grains do; swarms have
/// been turned into particles.
pub(in crate::config) fn off_walls(case: &Case) -> Check {
    let walls = case.obstacle.iter().enumerate().filter_map(|(k, o)| Some((k, o.wall.as_ref()?)));
    for (k, wall) in walls {
        let there = case.particle.iter().enumerate().filter(|(_, p)| p.enter.is_none());
        for (id, particle) in there {
            let depth = depth(particle, wall);
            let slack = slack(case, [particle; 2]);
            ensure!(
                depth <= slack,
                format!("obstacle.{k}"),
                "particle {id} reaches {} m into it, and may {} m: move one of them",
                rounded(depth),
                rounded(slack)
            );
        }
    }
    Ok(())
}

/// Depth of a particle in a wall (m); negative where it is clear of it.
fn depth(particle: &Particle, wall: &Wall) -> f64 {
    let reach = 0.5 * particle.shape.bounding_diameter();
    let clear = wall.nearest(&particle.position).distance - reach;
    let Some(solid) = particle.shape.solid().filter(|_| clear < 0.0) else { return -clear };
    let turn = particle.turn();
    let patches = solid.geometry().surface(2.0 * reach / ALONG);
    let into = patches.iter().map(|patch| {
        let arm = turn * patch.place;
        let place: Vec<f64> =
            particle.position.iter().zip(arm.iter()).map(|(x, d)| x + d).collect();
        -wall.nearest(&place).distance
    });
    into.fold(f64::NEG_INFINITY, f64::max)
}
