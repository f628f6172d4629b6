//! Builds solids from typed shapes: files are read, and their numbers checked.

use super::solid::Solid;
use super::*;
use crate::config::fault::{Check, Fault, positive};
use crate::config::source::Source;
use crate::config::{Case, Kind, Shape, Swarm};
use std::collections::HashMap;
use std::path::Path;

/// Cells along a body below which it is most likely in another unit than the box.
const FEWEST_CELLS: f64 = 3.0;

/// Builds the solids of the particles and swarms of a case: they then stand in `shape` and
/// `solids`, and their files are not needed any more. Files are looked for from `folder` on.
/// Returns notes on them, a line each.
pub(in crate::config) fn build(case: &mut Case, folder: &Path) -> Result<Vec<String>, Fault> {
    let dimension = case.dimension();
    if !(2..=3).contains(&dimension) {
        // Other dimensions are refused elsewhere.
        return Ok(Vec::new());
    }
    let mut shapes = Shapes::new(dimension, folder);
    let mut listed: Vec<Option<Solid>> = Vec::with_capacity(case.particle.len());
    for index in 0..case.particle.len() {
        let key = format!("particle.{index}.shape");
        let shape = case.particle[index].shape.typed();
        let solid = match shape {
            Typed::Like(Like { particle, diameter }) => {
                let key = format!("{key}.like");
                let earlier = *particle < index;
                ensure!(
                    earlier,
                    format!("{key}.particle"),
                    "must be the number of an earlier particle, below {index}, not {particle}"
                );
                positive(&format!("{key}.diameter"), *diameter, "m")?;
                match &listed[*particle] {
                    Some(solid) if diameter.is_none() => Some(solid.clone()),
                    Some(solid) => Some(solid.of_diameter(*diameter)),
                    None => {
                        let round = &case.particle[*particle].shape;
                        let wanted = diameter.or(Some(round.diameter()));
                        case.particle[index].shape = round.of_diameter(wanted);
                        None
                    }
                }
            }
            shape => shapes.solid(shape, &key)?,
        };
        if let Some(solid) = &solid {
            case.particle[index].shape = solid.clone().into();
            sensible(case, 2.0 * solid.geometry().radius(), &key)?;
        }
        listed.push(solid);
    }
    for index in 0..case.swarm.len() {
        let solids = shapes_of(&case.swarm[index], index, &mut shapes)?;
        case.swarm[index].solids = solids;
    }
    Ok(shapes.reader.notes)
}

/// Builds the shapes of the swarm of this number; none where it has discs or spheres of its
/// `diameter`.
fn shapes_of(swarm: &Swarm, index: usize, shapes: &mut Shapes) -> Result<Vec<Kind>, Fault> {
    let table = format!("swarm.{index}");
    let both = swarm.shape.is_some() && swarm.shapes.is_some();
    ensure!(
        !both,
        format!("{table}.shapes"),
        "shape and shapes exclude each other: remove one of them"
    );
    let one = swarm.shape.iter().map(|shape| (format!("{table}.shape"), 1.0, Some(shape.clone())));
    let list = swarm.shapes.iter().flatten().enumerate().map(|(k, listed)| {
        (format!("{table}.shapes.{k}"), listed.share.unwrap_or(1.0), listed.shape())
    });
    let mut kinds = Vec::new();
    for (key, share, shape) in one.chain(list) {
        positive(&format!("{key}.share"), share, "a part of the shares of all")?;
        let Some(shape) = shape else {
            return Err(Fault {
                key,
                message: "needs exactly one shape, as in { ellipsoid = { axes = [0.02, 0.01, \
                    0.01] }, share = 0.5 }"
                    .to_owned(),
            });
        };
        let within = !matches!(shape, Typed::Like(_));
        ensure!(within, key, "like is for [[particle]]: give the shape itself");
        shapes.fits(&shape, &key)?;
        if let Typed::Disc(Round { diameter }) | Typed::Sphere(Round { diameter }) = shape {
            positive(&format!("{key}.{}.diameter", shape.key()), diameter, "m")?;
        }
        let solid = shapes.solid(&shape, &key)?;
        kinds.push(Kind { share, shape: solid.map_or_else(|| shape.into(), Shape::from) });
    }
    let some = swarm.shapes.is_none() || !kinds.is_empty();
    ensure!(some, format!("{table}.shapes"), "is empty: give one shape at least");
    Ok(kinds)
}

/// Refuses a solid of this length (m) that is far too large for the box, or far too small for its
/// cells.
pub(in crate::config) fn sensible(case: &Case, length: f64, key: &str) -> Check {
    let box_length = case.domain.size.iter().copied().fold(0.0, f64::max);
    let spacings = case.domain.size.iter().zip(&case.domain.cells).map(|(l, n)| l / *n as f64);
    let widest = spacings.fold(0.0, f64::max);
    let cure = "if its file is in mm, set scale = 0.001; else look at its size and domain.size";
    ensure!(
        length <= 2.0 * box_length || !box_length.is_finite(),
        key,
        "is {} m long, and the box {box_length:?} m: {cure}",
        crate::words::rounded(length)
    );
    let cells = length / widest;
    ensure!(
        cells >= FEWEST_CELLS || !widest.is_finite() || widest <= 0.0,
        key,
        "is {} m long, which is {} cells, and {FEWEST_CELLS} are the least at which anything of \
        its shape is left, 8 the least that is right within some per cent: look at the units of \
        its size and domain.size, or give domain.cells more",
        crate::words::rounded(length),
        crate::words::brief(cells)
    );
    Ok(())
}

/// The solids of a case that have been built, each shape once.
pub(in crate::config) struct Shapes {
    reader: Reader,
    built: Vec<Solid>,
    /// Shapes read from files, by their typed description.
    of_files: HashMap<String, Typed>,
}

impl Shapes {
    /// No solids yet, of a case of this dimension; files are looked for from `folder` on.
    pub fn new(dimension: usize, folder: &Path) -> Shapes {
        Shapes {
            reader: Reader { dimension, folder: folder.to_owned(), notes: Vec::new() },
            built: Vec::new(),
            of_files: HashMap::new(),
        }
    }

    /// The solid that a shape of the key `key` is; `None` of one that is round.
    pub fn solid(&mut self, shape: &Typed, key: &str) -> Result<Option<Solid>, Fault> {
        if matches!(shape, Typed::Disc(_) | Typed::Sphere(_)) {
            return Ok(None);
        }
        self.fits(shape, key)?;
        let key = format!("{key}.{}", shape.key());
        positive(&format!("{key}.diameter"), shape.diameter(), "m")?;
        let typed = self.self_contained(shape.of_diameter(None), &key)?;
        let base = match self.built.iter().find(|solid| solid.typed() == typed) {
            Some(solid) => solid.clone(),
            None => {
                let fault = |message: String| match shape.file() {
                    Some(file) => {
                        Source { path: &self.reader.folder.join(file), key: &key }.refuse(&message)
                    }
                    None => Fault { key: key.clone(), message },
                };
                let solid = Solid::new(typed).map_err(fault)?;
                self.built.push(solid.clone());
                solid
            }
        };
        Ok(Some(base.of_diameter(shape.diameter())))
    }

    /// Refuses a shape of another dimension.
    pub fn fits(&self, shape: &Typed, key: &str) -> Check {
        let is = self.reader.dimension;
        let others = match is {
            2 => "an ellipse, a polygon or a clump of discs",
            _ => "an ellipsoid, a superquadric, a polyhedron or a clump of spheres",
        };
        ensure!(
            shape.dimension().is_none_or(|wanted| wanted == is),
            key,
            "a disc is for 2D, a sphere for 3D; this case is {is}D: choose that or {others}"
        );
        Ok(())
    }

    /// The shape with its numbers checked and those of its file in it.
    fn self_contained(&mut self, shape: Typed, key: &str) -> Result<Typed, Fault> {
        let name = shape.file().map(|_| format!("{shape:?}"));
        if let Some(known) = name.as_ref().and_then(|name| self.of_files.get(name)) {
            return Ok(known.clone());
        }
        let read = shape.read(&mut self.reader, key)?;
        if let Some(name) = name {
            self.of_files.insert(name, read.clone());
        }
        Ok(read)
    }
}
