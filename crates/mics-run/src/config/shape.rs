//! Shapes of bodies as they are typed.

mod build;
mod geometry;
pub(in crate::config) mod outline;
pub mod solid;

pub(in crate::config) use build::build;
pub(in crate::config) use build::sensible;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The shape of a body, in its own axes. A body lies with its centre of volume at `position`. What
/// is not round may have a `diameter` (m): that of the disc or sphere of its volume, to which all
/// of it is scaled.
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

/// An ellipse.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ellipse {
    /// Its lengths along its own x and y (m), from end to end.
    pub axes: [f64; 2],
    /// Diameter of the disc of its area (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

/// An ellipsoid.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ellipsoid {
    /// Its lengths along its own x, y and z (m), from end to end.
    pub axes: [f64; 3],
    /// Diameter of the sphere of its volume (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

/// A superquadric.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Superquadric {
    /// Its lengths along its own x, y and z (m), from end to end.
    pub axes: [f64; 3],
    /// p (along z) and q (across z), from 2 to 20.
    pub exponents: [f64; 2],
    /// Diameter of the sphere of its volume (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

/// A convex polygon: exactly one of `points` and `file`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Polygon {
    /// Its corners in order (m), either way round.
    pub points: Option<Vec<[f64; 2]>>,
    /// A CSV file of them, relative to the case file, with columns x and y.
    pub file: Option<String>,
    /// What the file's lengths are multiplied by (0.001 for mm), default 1.
    pub scale: Option<f64>,
    /// Radius of its edges (m), within its faces, which stay where they are; default 0: sharp
    /// edges.
    pub rounding: Option<f64>,
    /// Diameter of the disc of its area (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

/// A convex polyhedron: exactly one of `file` and `points`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Polyhedron {
    /// An STL file, binary or ASCII, relative to the case file, of a closed surface.
    pub file: Option<String>,
    /// What the file's lengths are multiplied by (0.001 for mm), default 1.
    pub scale: Option<f64>,
    /// Its corners (m), in any order.
    pub points: Option<Vec<[f64; 3]>>,
    /// Radius of its edges (m), within its faces, which stay where they are; default 0: sharp
    /// edges.
    pub rounding: Option<f64>,
    /// Diameter of the sphere of its volume (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

/// A clump: exactly one of `discs` (2D), `spheres` (3D) and `file`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Clump {
    /// Its discs.
    pub discs: Option<Vec<Ball>>,
    /// Its spheres.
    pub spheres: Option<Vec<Ball>>,
    /// A CSV file of them, relative to the case file, with columns x, y (z in 3D) and diameter.
    pub file: Option<String>,
    /// What the file's lengths are multiplied by (0.001 for mm), default 1.
    pub scale: Option<f64>,
    /// Diameter of the disc or sphere of its volume (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

/// A disc or sphere of a clump.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ball {
    /// Its centre (m).
    pub at: Vec<f64>,
    /// Its diameter (m).
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
    /// How many of the swarm have it, as a part of the shares of all; default 1.
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
        let Listed { share: _, disc, sphere, ellipse, ellipsoid, superquadric, polygon, .. } = self;
        let all = [
            disc.clone().map(Typed::Disc),
            sphere.clone().map(Typed::Sphere),
            ellipse.clone().map(Typed::Ellipse),
            ellipsoid.clone().map(Typed::Ellipsoid),
            superquadric.clone().map(Typed::Superquadric),
            polygon.clone().map(Typed::Polygon),
            self.polyhedron.clone().map(Typed::Polyhedron),
            self.clump.clone().map(Typed::Clump),
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
            Typed::Disc(_) | Typed::Ellipse(_) | Typed::Polygon(_) => Some(2),
            Typed::Sphere(_)
            | Typed::Ellipsoid(_)
            | Typed::Superquadric(_)
            | Typed::Polyhedron(_) => Some(3),
            Typed::Clump(_) | Typed::Like(_) => None,
        }
    }

    /// The diameter (m) of what is round, or to which it is scaled.
    pub fn diameter(&self) -> Option<f64> {
        match self {
            Typed::Disc(round) | Typed::Sphere(round) => Some(round.diameter),
            Typed::Ellipse(Ellipse { diameter, .. })
            | Typed::Ellipsoid(Ellipsoid { diameter, .. })
            | Typed::Superquadric(Superquadric { diameter, .. })
            | Typed::Polygon(Polygon { diameter, .. })
            | Typed::Polyhedron(Polyhedron { diameter, .. })
            | Typed::Clump(Clump { diameter, .. })
            | Typed::Like(Like { diameter, .. }) => *diameter,
        }
    }

    /// The same with this diameter (m), or as large as it is by itself.
    pub fn of_diameter(&self, wanted: Option<f64>) -> Typed {
        let mut shape = self.clone();
        match &mut shape {
            Typed::Disc(round) | Typed::Sphere(round) => {
                round.diameter = wanted.unwrap_or(round.diameter);
            }
            Typed::Ellipse(Ellipse { diameter, .. })
            | Typed::Ellipsoid(Ellipsoid { diameter, .. })
            | Typed::Superquadric(Superquadric { diameter, .. })
            | Typed::Polygon(Polygon { diameter, .. })
            | Typed::Polyhedron(Polyhedron { diameter, .. })
            | Typed::Clump(Clump { diameter, .. })
            | Typed::Like(Like { diameter, .. }) => *diameter = wanted,
        }
        shape
    }
}

#[cfg(test)]
pub(in crate::config) mod tests;
