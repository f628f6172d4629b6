//! An obstacle as the program sees it: its surface in the axes of the box.

use super::{Outlines, Surface};
use mics_shapes::{Fault, Geometry, Nearest, Obstacle as Solid, Room};
use nalgebra::Vector3;
use std::sync::Arc;

/// What an obstacle is made of, in the axes of the box (m).
#[derive(Clone, Debug, PartialEq)]
pub(in crate::config) enum Form {
    /// Closed outlines, one way round what is solid, the other way round holes.
    Outlines(Vec<Vec<[f64; 2]>>),
    /// The corners of triangles, counterclockwise seen from outside.
    Surface {
        /// The corners.
        points: Vec<[f64; 3]>,
        /// Those of each triangle, by number.
        triangles: Vec<[usize; 3]>,
    },
}

/// A wall of any shape.
#[derive(Clone, Debug)]
pub struct Wall {
    form: Arc<Form>,
    geometry: Arc<Solid>,
    centre: Vec<f64>,
}

impl PartialEq for Wall {
    fn eq(&self, other: &Wall) -> bool {
        self.centre == other.centre && self.geometry == other.geometry
    }
}

impl Wall {
    /// A wall of this form in a room, with this centre (m), or that of its volume.
    ///
    /// # Errors
    /// When it is none, in words.
    pub(super) fn new(form: Form, room: &Room, centre: Option<Vec<f64>>) -> Result<Wall, Fault> {
        let solid = match &form {
            Form::Outlines(outlines) => Solid::outlines(outlines, room)?,
            Form::Surface { points, triangles } => {
                let corners = |t: &[usize; 3]| t.map(|k| Vector3::from(points[k]));
                Solid::simplified(&triangles.iter().map(corners).collect::<Vec<_>>(), room)?
            }
        };
        let middle = solid.centre();
        let at = match centre {
            Some(given) => Vector3::from_fn(|a, _| given.get(a).copied().unwrap_or(middle[a])),
            None => {
                let of_volume = solid.centre_of_volume();
                Vector3::from_fn(|a, _| if room.periodic[a] { middle[a] } else { of_volume[a] })
            }
        };
        let dimension = solid.dimension();
        let solid = if at == middle { solid } else { solid.about(&at)? };
        let centre = at.iter().take(dimension).copied().collect();
        Ok(Wall { form: Arc::new(form), geometry: Arc::new(solid), centre })
    }

    /// Lets the fluid meet those walls as one solid that overlap or touch, all at rest, on a grid
    /// of this spacing (m).
    ///
    /// # Errors
    /// When a surface is not closed, in words.
    pub(super) fn unite<'a>(
        walls: impl Iterator<Item = &'a mut Wall>,
        spacing: f64,
    ) -> Result<(), Fault> {
        let mut all: Vec<_> = walls.map(|wall| Arc::make_mut(&mut wall.geometry)).collect();
        Solid::unite(&mut all, spacing)
    }

    /// What it is, its own origin at its centre.
    pub fn geometry(&self) -> &Arc<Solid> {
        &self.geometry
    }

    /// What its torque is about and what it turns about (m), a number for each axis.
    pub fn centre(&self) -> &[f64] {
        &self.centre
    }

    /// The ends of its surface in the box along each axis (m).
    pub fn bounds(&self) -> [Vector3<f64>; 2] {
        self.geometry.bounds()
    }

    /// Width of its thinnest part (m); infinite where there is none.
    pub fn thickness(&self) -> f64 {
        self.geometry.thickness()
    }

    /// What is nearest of its surface at time 0 to a place in the box (m).
    pub fn nearest(&self, place: &[f64]) -> Nearest {
        let arm = |a: usize| Some(place.get(a)? - self.centre.get(a)?);
        self.geometry.nearest(&Vector3::from_fn(|a, _| arm(a).unwrap_or(0.0)))
    }

    /// What a case says of it, with nothing in other files.
    pub(in crate::config) fn typed(&self) -> super::Obstacle {
        let mut typed = super::Obstacle::default();
        match &*self.form {
            Form::Outlines(outlines) => {
                let outlines = Some(outlines.clone());
                typed.polygon = Some(Outlines { outlines, ..Outlines::default() });
            }
            Form::Surface { points, triangles } => {
                let (points, triangles) = (Some(points.clone()), Some(triangles.clone()));
                typed.surface = Some(Surface { points, triangles, ..Surface::default() });
            }
        }
        typed.centre = Some(self.centre.clone());
        typed
    }

    /// How much it is made of, in words.
    pub fn detail(&self) -> String {
        match &*self.form {
            Form::Outlines(outlines) => {
                let corners: usize = outlines.iter().map(Vec::len).sum();
                match outlines.len() {
                    1 => format!("outline of {corners} corners"),
                    several => format!("{several} outlines of {corners} corners"),
                }
            }
            Form::Surface { triangles, .. } => format!("surface of {} triangles", triangles.len()),
        }
    }
}
