//! Shapes of bodies as they are typed.

mod build;
mod clump;
mod ellipse;
mod ellipsoid;
pub(in crate::config) mod outline;
mod polygon;
mod polyhedron;
pub mod solid;
mod superquadric;

use crate::config::fault::{Check, Fault, positive};
pub(in crate::config) use build::build;
pub(in crate::config) use build::sensible;
pub use clump::{Ball, Clump};
pub use ellipse::Ellipse;
pub use ellipsoid::Ellipsoid;
use mics_shapes::Shape as Geometry;
pub use polygon::Polygon;
pub use polyhedron::Polyhedron;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;
pub use superquadric::Superquadric;

/// Typed description of a shape that is not round. A shape is a file that implements this, and its
/// names in [`Typed`], [`Listed`] and `each!`.
pub(in crate::config) trait Described: Sized {
    /// The dimension of the cases that it is for; `None` where it is for both.
    fn dimension(&self) -> Option<usize>;

    /// The file that its numbers are in.
    fn file(&self) -> Option<&str> {
        None
    }

    /// The shape of the key `key`, its numbers checked and those of its file in it.
    fn read(self, reader: &mut Reader, key: &str) -> Result<Self, Fault>;

    /// The solid that it is in its own axes, as large as it is by itself, once it is read.
    fn solid(&self) -> Result<Arc<dyn Geometry>, mics_shapes::Fault>;

    /// Number of its corners or balls, in words; empty where a few numbers describe it in a case.
    fn detail(&self) -> String {
        String::new()
    }
}

/// Reader of the shapes of a case.
pub(in crate::config) struct Reader {
    /// Dimension of the case.
    pub dimension: usize,
    /// Folder from which files are looked for.
    pub folder: PathBuf,
    /// Notes on files.
    pub notes: Vec<String>,
}

/// Refuses axes (m) that are no lengths.
fn axes(key: &str, axes: &[f64]) -> Check {
    let all = axes.iter().enumerate();
    all.into_iter().try_for_each(|(k, x)| positive(&format!("{key}.axes.{k}"), *x, "m"))
}

/// Evaluates `$then` for a shape of any kind that is not round, with `$make` the variant of
/// [`Typed`] that it is, and `$else` for others.
macro_rules! each {
    ($typed:expr, $make:pat, $shape:pat => $then:expr, $other:pat => $else:expr) => {
        match $typed {
            Typed::Ellipse($shape) => each!(@ Typed::Ellipse, $make, $then),
            Typed::Ellipsoid($shape) => each!(@ Typed::Ellipsoid, $make, $then),
            Typed::Superquadric($shape) => each!(@ Typed::Superquadric, $make, $then),
            Typed::Polygon($shape) => each!(@ Typed::Polygon, $make, $then),
            Typed::Polyhedron($shape) => each!(@ Typed::Polyhedron, $make, $then),
            Typed::Clump($shape) => each!(@ Typed::Clump, $make, $then),
            $other => $else,
        }
    };
    (@ $kind:expr, $make:pat, $then:expr) => {{
        let $make = $kind;
        $then
    }};
}

/// The shape of a body, in its own axes. A body lies with its centre of volume at `position`.
/// Shapes that are not round may have a `diameter` (m): that of the disc or sphere of their volume,
/// to which they are scaled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(rename = "Shape")]
pub enum Typed {
    /// A disc (2D), of unit depth.
    Disc(Round),
    /// A sphere (3D).
    Sphere(Round),
    /// An ellipse (2D), of unit depth.
    Ellipse(Ellipse),
    /// An ellipsoid (3D).
    Ellipsoid(Ellipsoid),
    /// A superquadric (3D), `(|2x/a|^q + |2y/b|^q)^(p/q) + |2z/c|^p <= 1` of the axes a, b, c and
    /// exponents p, q: with 2 and 2 an ellipsoid, with 8 and 8 a box with round edges.
    Superquadric(Superquadric),
    /// A convex polygon (2D), of unit depth.
    Polygon(Polygon),
    /// A convex polyhedron (3D): the convex hull of a closed surface, or of points.
    Polyhedron(Polyhedron),
    /// Discs (2D) or spheres (3D) that overlap, as one body, which may be concave; what several
    /// cover counts once.
    Clump(Clump),
    /// The shape of an earlier particle.
    Like(Like),
}

/// The size of a disc or sphere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Round {
    /// Diameter (m).
    pub diameter: f64,
}

/// The shape of an earlier particle.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Like {
    /// Its number among the `[[particle]]` of this file, from 0.
    pub particle: usize,
    /// Diameter of the disc or sphere of its volume (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

/// A shape in a list of them, by one of its keys, with its share.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Listed {
    /// Its share of the swarm's bodies, as a part of the shares of all; default 1.
    pub share: Option<f64>,
    /// A disc (2D), of unit depth.
    pub disc: Option<Round>,
    /// A sphere (3D).
    pub sphere: Option<Round>,
    /// An ellipse (2D), of unit depth.
    pub ellipse: Option<Ellipse>,
    /// An ellipsoid (3D).
    pub ellipsoid: Option<Ellipsoid>,
    /// A superquadric (3D).
    pub superquadric: Option<Superquadric>,
    /// A convex polygon (2D), of unit depth.
    pub polygon: Option<Polygon>,
    /// A convex polyhedron (3D).
    pub polyhedron: Option<Polyhedron>,
    /// Discs (2D) or spheres (3D) that overlap, as one body.
    pub clump: Option<Clump>,
}

impl Listed {
    /// The shape, where exactly one is given.
    pub fn shape(&self) -> Option<Typed> {
        // Every field by name, so that none can be left out.
        let Listed {
            share: _,
            disc,
            sphere,
            ellipse,
            ellipsoid,
            superquadric,
            polygon,
            polyhedron,
            clump,
        } = self.clone();
        let all = [
            disc.map(Typed::Disc),
            sphere.map(Typed::Sphere),
            ellipse.map(Typed::Ellipse),
            ellipsoid.map(Typed::Ellipsoid),
            superquadric.map(Typed::Superquadric),
            polygon.map(Typed::Polygon),
            polyhedron.map(Typed::Polyhedron),
            clump.map(Typed::Clump),
        ];
        let mut given = all.into_iter().flatten();
        given.next().filter(|_| given.next().is_none())
    }
}

impl Typed {
    /// The name of its key.
    pub fn key(&self) -> &'static str {
        match self {
            Typed::Disc(_) => "disc",
            Typed::Sphere(_) => "sphere",
            Typed::Ellipse(_) => "ellipse",
            Typed::Ellipsoid(_) => "ellipsoid",
            Typed::Superquadric(_) => "superquadric",
            Typed::Polygon(_) => "polygon",
            Typed::Polyhedron(_) => "polyhedron",
            Typed::Clump(_) => "clump",
            Typed::Like(_) => "like",
        }
    }

    /// The dimension of the cases that it is for; `None` where it is for both.
    pub fn dimension(&self) -> Option<usize> {
        match self {
            Typed::Disc(_) => Some(2),
            Typed::Sphere(_) => Some(3),
            other => each!(other, _, shape => shape.dimension(), _ => None),
        }
    }

    /// Diameter (m) of a disc or sphere, or to which another shape is scaled.
    pub fn diameter(&self) -> Option<f64> {
        match self {
            Typed::Disc(round) | Typed::Sphere(round) => Some(round.diameter),
            Typed::Like(like) => like.diameter,
            other => each!(other, _, shape => shape.diameter, _ => None),
        }
    }

    /// The shape with this diameter (m), or in its own size.
    pub fn of_diameter(&self, wanted: Option<f64>) -> Typed {
        let mut shape = self.clone();
        match &mut shape {
            Typed::Disc(round) | Typed::Sphere(round) => {
                round.diameter = wanted.unwrap_or(round.diameter);
            }
            Typed::Like(like) => like.diameter = wanted,
            other => each!(other, _, shape => shape.diameter = wanted, _ => {}),
        }
        shape
    }

    /// The file that its numbers are in.
    fn file(&self) -> Option<&str> {
        each!(self, _, shape => shape.file(), _ => None)
    }

    /// As [`Described::read`].
    fn read(self, reader: &mut Reader, key: &str) -> Result<Typed, Fault> {
        Ok(each!(self, make, shape => make(shape.read(reader, key)?), round => round))
    }

    /// As [`Described::solid`].
    ///
    /// # Errors
    /// When it is no solid, in words.
    fn solid(&self) -> Result<Arc<dyn Geometry>, String> {
        let none = || Err(format!("a {} is no solid", self.key()));
        each!(self, _, shape => shape.solid().map_err(|fault| fault.0), _ => none())
    }

    /// As [`Described::detail`].
    fn detail(&self) -> String {
        each!(self, _, shape => shape.detail(), _ => String::new())
    }
}

#[cfg(test)]
pub(in crate::config) mod tests;
