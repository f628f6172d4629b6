//! Walls of any shape that stand in the box or cross its sides.
//!
//! ```text
//!   polygon (2D)      surface (3D)       heights: a line over x (2D), a raster over x, y (3D)
//!     ____               /\                     __
//!    /    \             /__\              _____/  \________    solid below; beyond its ends the
//!   /______\           /    \             //////////////////   line goes on as it ends, across
//!                                                              periodic sides from its beginning
//! ```
//! All of them become outlines or closed surfaces in the axes of the box.

mod build;
mod heights;
mod table;
mod wall;

use super::Motion;
pub(in crate::config) use build::{build, off_walls};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
pub use wall::Wall;

/// A wall of any shape: exactly one of `polygon` (2D), `surface` (3D) and `heights`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Obstacle {
    /// Name in measures; each its own.
    pub name: Option<String>,
    /// Solid within closed outlines (2D), concave too.
    pub polygon: Option<Outlines>,
    /// Solid within a closed surface of triangles (3D), concave too.
    pub surface: Option<Surface>,
    /// Solid below heights: y over x in 2D, z over x and y in 3D.
    pub heights: Option<Heights>,
    /// Place in the box of the origin of its numbers (m), default the box's.
    pub position: Option<Vec<f64>>,
    /// Reference point of its torque and centre of a given spin (m); default the centre of its
    /// volume in the box, of one that rests along periodic axes the middle of the box.
    pub centre: Option<Vec<f64>>,
    /// Its motion; default it rests. A moving one must not reach the sides of the box.
    pub motion: Motion,
    /// Its name in `[[contact.pair]]`, default that of the sides of the box, `wall`.
    pub material: Option<String>,
    /// Its wall, once it has been built.
    #[serde(skip)]
    pub wall: Option<Wall>,
}

impl Default for Obstacle {
    fn default() -> Self {
        Obstacle {
            name: None,
            polygon: None,
            surface: None,
            heights: None,
            position: None,
            centre: None,
            motion: Motion::Fixed,
            material: None,
            wall: None,
        }
    }
}

impl Obstacle {
    /// Its wall, in a case that has been read.
    pub fn wall(&self) -> &Wall {
        self.wall.as_ref().expect("the obstacles of a case that has been read are built")
    }

    /// Replaces the typed keys by those of the built wall, with nothing in other files.
    fn become_wall(&mut self, wall: Wall) {
        let Obstacle { polygon, surface, centre, .. } = wall.typed();
        self.polygon = polygon;
        self.surface = surface;
        self.heights = None;
        self.position = None;
        self.centre = centre;
        self.material.get_or_insert_with(|| super::WALL.to_owned());
        self.wall = Some(wall);
    }

    /// The name of its material.
    pub fn material(&self) -> &str {
        self.material.as_deref().unwrap_or(super::WALL)
    }
}

/// Closed outlines: exactly one of `points`, `outlines` and `file`. An outline within another one
/// is a hole in it.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Outlines {
    /// The corners of one outline (m), in order.
    pub points: Option<Vec<[f64; 2]>>,
    /// The corners of several (m).
    pub outlines: Option<Vec<Vec<[f64; 2]>>>,
    /// A CSV file with columns x, y, relative to the case file; with `outline` before them,
    /// a number that changes from one outline to the next.
    pub file: Option<String>,
    /// Factor on the file's lengths (0.001 for mm), default 1.
    pub scale: Option<f64>,
}

/// A closed surface: `file`, or `points` with `triangles`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Surface {
    /// An STL file, binary or ASCII, relative to the case file.
    pub file: Option<String>,
    /// Factor on the file's lengths (0.001 for mm), default 1.
    pub scale: Option<f64>,
    /// Its corners (m).
    pub points: Option<Vec<[f64; 3]>>,
    /// The corners of each triangle by their numbers from 0, counterclockwise seen from outside.
    pub triangles: Option<Vec<[usize; 3]>>,
}

/// Heights: exactly one of `file` and `points`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Heights {
    /// A file, relative to the case file: CSV with columns x, y (2D) or x, y, z of a raster, or
    /// an ESRI ASCII grid (`.asc`, 3D).
    pub file: Option<String>,
    /// Factor on the file's lengths (0.001 for mm), default 1.
    pub scale: Option<f64>,
    /// The corners of the line (m), x increasing; 2D.
    pub points: Option<Vec<[f64; 2]>>,
}

#[cfg(test)]
mod tests;
