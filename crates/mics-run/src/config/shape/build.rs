//! From what is typed of a shape to a solid: files are read, and their numbers checked.

use super::outline::{self, Flaw};
use super::solid::Solid;
use super::*;
use crate::config::fault::{Check, Fault, finite, not_negative, positive};
use crate::config::source::{Source, factor, named, one_of};
use crate::config::{Case, Kind, Shape, Swarm};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Cells along a body below which it is most likely in another unit than the box.
const FEWEST_CELLS: f64 = 3.0;

/// Builds the solids of the particles and swarms of a case: what they are of then stands in
/// `solid` and `solids`, and their files are not needed any more. Files are looked for from
/// `folder` on. Returns what is to be said of them, a line each.
pub(in crate::config) fn build(case: &mut Case, folder: &Path) -> Result<Vec<String>, Fault> {
    let dimension = case.dimension();
    if !(2..=3).contains(&dimension) {
        // That is refused elsewhere.
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
    Ok(shapes.notes)
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
    dimension: usize,
    folder: PathBuf,
    built: Vec<Solid>,
    /// Those of files, by what is typed of them.
    of_files: HashMap<String, Typed>,
    /// What is to be said of files.
    notes: Vec<String>,
}

impl Shapes {
    /// None yet, of a case of this dimension; files are looked for from `folder` on.
    pub fn new(dimension: usize, folder: &Path) -> Shapes {
        Shapes {
            dimension,
            folder: folder.to_owned(),
            built: Vec::new(),
            of_files: HashMap::new(),
            notes: Vec::new(),
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
                let fault = |message: String| match file_of(shape) {
                    Some(file) => {
                        Source { path: &self.folder.join(file), key: &key }.refuse(&message)
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
        let is = self.dimension;
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
        let name = file_of(&shape).map(|_| format!("{shape:?}"));
        if let Some(known) = name.as_ref().and_then(|name| self.of_files.get(name)) {
            return Ok(known.clone());
        }
        let read = self.read(shape, key)?;
        if let Some(name) = name {
            self.of_files.insert(name, read.clone());
        }
        Ok(read)
    }

    fn read(&mut self, shape: Typed, key: &str) -> Result<Typed, Fault> {
        Ok(match shape {
            Typed::Polygon(polygon) => Typed::Polygon(self.polygon(polygon, key)?),
            Typed::Polyhedron(polyhedron) => Typed::Polyhedron(self.polyhedron(polyhedron, key)?),
            Typed::Clump(clump) => Typed::Clump(self.clump(clump, key)?),
            shape => {
                let axes: &[f64] = match &shape {
                    Typed::Ellipse(ellipse) => &ellipse.axes,
                    Typed::Ellipsoid(ellipsoid) => &ellipsoid.axes,
                    Typed::Superquadric(superquadric) => &superquadric.axes,
                    _ => &[],
                };
                for (k, length) in axes.iter().enumerate() {
                    positive(&format!("{key}.axes.{k}"), *length, "m")?;
                }
                if let Typed::Superquadric(superquadric) = &shape {
                    for (k, exponent) in superquadric.exponents.iter().enumerate() {
                        ensure!(
                            (2.0..=20.0).contains(exponent),
                            format!("{key}.exponents.{k}"),
                            "must be from 2 (round) to 20 (nearly a box), not {exponent:?}"
                        );
                    }
                }
                shape
            }
        })
    }

    fn polygon(&self, given: Polygon, key: &str) -> Result<Polygon, Fault> {
        let Polygon { points, file, scale, rounding, .. } = given;
        one_of(key, &[("points", points.is_some()), ("file", file.is_some())])?;
        let factor = factor(key, scale, file.is_some())?;
        not_negative(&format!("{key}.rounding"), rounding, "m")?;
        let points = match file {
            None => {
                let points = points.unwrap_or_default();
                for (k, point) in points.iter().enumerate() {
                    finite(&format!("{key}.points.{k}"), point, "m")?;
                }
                outline::convex(&points).map_err(|Flaw { corner, what }| Fault {
                    key: format!("{key}.points.{corner}"),
                    message: what,
                })?;
                points
            }
            Some(file) => {
                let path = self.folder.join(named(&file, key)?);
                let key = format!("{key}.file");
                let source = Source { path: &path, key: &key };
                let rows = source.rows(&["x", "y"], "corners")?;
                let points: Vec<[f64; 2]> =
                    rows.iter().map(|(_, row)| [factor * row[0], factor * row[1]]).collect();
                outline::convex(&points)
                    .map_err(|Flaw { corner, what }| source.refuse_line(rows[corner].0, &what))?;
                points
            }
        };
        Ok(Polygon { points: Some(points), rounding, ..Polygon::default() })
    }

    fn polyhedron(&mut self, given: Polyhedron, key: &str) -> Result<Polyhedron, Fault> {
        let Polyhedron { file, scale, points, rounding, .. } = given;
        one_of(key, &[("file", file.is_some()), ("points", points.is_some())])?;
        let factor = factor(key, scale, file.is_some())?;
        not_negative(&format!("{key}.rounding"), rounding, "m")?;
        let points = match file {
            None => {
                let points = points.unwrap_or_default();
                for (k, point) in points.iter().enumerate() {
                    finite(&format!("{key}.points.{k}"), point, "m")?;
                }
                points
            }
            Some(file) => {
                let path = self.folder.join(named(&file, key)?);
                let key = format!("{key}.file");
                let source = Source { path: &path, key: &key };
                source.exists()?;
                let (corners, notes) =
                    super::geometry::hull(&path, factor).map_err(|what| source.refuse(&what))?;
                let said = notes
                    .into_iter()
                    .map(|note| format!("note         {key}: {}: {note}", path.display()));
                self.notes.extend(said);
                corners
            }
        };
        Ok(Polyhedron { points: Some(points), rounding, ..Polyhedron::default() })
    }

    fn clump(&self, given: Clump, key: &str) -> Result<Clump, Fault> {
        let Clump { discs, spheres, file, scale, .. } = given;
        let (own, other) =
            if self.dimension == 2 { ("discs", "spheres") } else { ("spheres", "discs") };
        let [(own_balls, other_balls)] =
            [if self.dimension == 2 { (discs, spheres) } else { (spheres, discs) }];
        ensure!(
            other_balls.is_none(),
            format!("{key}.{other}"),
            "discs are for 2D, spheres for 3D; this case is {}D: give {own}",
            self.dimension
        );
        one_of(key, &[(own, own_balls.is_some()), ("file", file.is_some())])?;
        let factor = factor(key, scale, file.is_some())?;
        let balls = match file {
            None => own_balls.unwrap_or_default(),
            Some(file) => {
                let path = self.folder.join(named(&file, key)?);
                let key = format!("{key}.file");
                let source = Source { path: &path, key: &key };
                let columns: &[&str] = match self.dimension {
                    2 => &["x", "y", "diameter"],
                    _ => &["x", "y", "z", "diameter"],
                };
                let rows = source.rows(columns, own)?;
                let ball = |(line, row): (u64, Vec<f64>)| {
                    let (at, diameter) = row.split_at(self.dimension);
                    let diameter = factor * diameter[0];
                    if diameter > 0.0 {
                        return Ok(Ball { at: at.iter().map(|x| factor * x).collect(), diameter });
                    }
                    let what = format!("column `diameter` must be positive (m), not {diameter:?}");
                    Err(source.refuse_line(line, &what))
                };
                rows.into_iter().map(ball).collect::<Result<_, _>>()?
            }
        };
        let holds = !balls.is_empty();
        ensure!(holds, format!("{key}.{own}"), "is empty: give one at least");
        for (k, Ball { at, diameter }) in balls.iter().enumerate() {
            let key = format!("{key}.{own}.{k}");
            crate::config::fault::vector(&format!("{key}.at"), at, self.dimension, "m")?;
            positive(&format!("{key}.diameter"), *diameter, "m")?;
        }
        let balls = Some(balls);
        Ok(match self.dimension {
            2 => Clump { discs: balls, ..Clump::default() },
            _ => Clump { spheres: balls, ..Clump::default() },
        })
    }
}

/// The file that is typed of a shape.
fn file_of(shape: &Typed) -> Option<&str> {
    match shape {
        Typed::Polygon(Polygon { file, .. })
        | Typed::Polyhedron(Polyhedron { file, .. })
        | Typed::Clump(Clump { file, .. }) => file.as_deref(),
        _ => None,
    }
}
