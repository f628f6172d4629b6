//! An obstacle as the program sees it: its surface in the axes of the box.

use super::{Outlines, Surface};
use crate::config::shape::outline::nested;
use mics_shapes::{Extent, Fault, Nearest, Obstacle as Solid, Shape, stl};
use nalgebra::Vector3;
use std::collections::HashMap;
use std::sync::Arc;

/// Part of the box's length within which a corner lies on a side: the resolution of an STL file's
/// single-precision numbers.
const ON_SIDE: f64 = 1e-6;

/// Geometry of an obstacle, in the axes of the box (m).
#[derive(Clone, Debug, PartialEq)]
pub(in crate::config) enum Form {
    /// Closed outlines, one way round what is solid, the other way round holes.
    Outlines(Vec<Vec<[f64; 2]>>),
    /// The corners of triangles, counterclockwise seen from outside.
    Surface {
        /// The corners.
        points: Vec<[f64; 3]>,
        /// Corners of each triangle, by their numbers in `points`.
        triangles: Vec<[usize; 3]>,
    },
}

impl Form {
    /// Replaces each coordinate of its corners by a function of axis and coordinate.
    fn map(&mut self, moved: impl Fn(usize, f64) -> f64) {
        let each = |a: usize, x: &mut f64| *x = moved(a, *x);
        match self {
            Form::Outlines(all) => {
                all.iter_mut().flatten().for_each(|p| (0..2).for_each(|a| each(a, &mut p[a])));
            }
            Form::Surface { points, .. } => {
                points.iter_mut().for_each(|p| (0..3).for_each(|a| each(a, &mut p[a])));
            }
        }
    }

    /// Moves it by `shift` (m) and gives it the form of a run's own case, so that it reads back the
    /// same: corners within rounding of a side of the box on it, surfaces closed, holes turned.
    /// Also returns notes on corrections.
    ///
    /// # Errors
    /// The errors of [`stl::closed`].
    pub fn placed(
        mut self,
        shift: &Vector3<f64>,
        room: &Extent,
    ) -> Result<(Form, Vec<String>), Fault> {
        self.map(|a, x| {
            let x = x + shift[a];
            let size = room.size[a];
            [0.0, size].into_iter().find(|side| (x - side).abs() <= ON_SIDE * size).unwrap_or(x)
        });
        let (given, triangles) = match self {
            Form::Outlines(all) => return Ok((Form::Outlines(nested(all)), Vec::new())),
            Form::Surface { points, triangles } => (points, triangles),
        };
        let corners = |t: &[usize; 3]| t.map(|k| Vector3::from(given[k]));
        let stl::ClosedSurface { triangles, notes } =
            stl::closed(triangles.iter().map(corners).collect())?;
        let mut points: Vec<[f64; 3]> = Vec::new();
        let mut known = HashMap::new();
        let mut number = |corner: Vector3<f64>| {
            *known.entry(<[f64; 3]>::from(corner).map(f64::to_bits)).or_insert_with(|| {
                points.push(corner.into());
                points.len() - 1
            })
        };
        let triangles = triangles.into_iter().map(|t| t.map(&mut number)).collect();
        Ok((Form::Surface { points, triangles }, notes))
    }

    /// Its largest extent along an axis (m).
    pub fn length(&self) -> f64 {
        let all: Vec<Vector3<f64>> = match self {
            Form::Outlines(all) => {
                all.iter().flatten().map(|[x, y]| Vector3::new(*x, *y, 0.0)).collect()
            }
            Form::Surface { points, .. } => points.iter().map(|p| Vector3::from(*p)).collect(),
        };
        let end = |end: fn(f64, f64) -> f64| all.iter().copied().reduce(|a, b| a.zip_map(&b, end));
        let [low, high] = [end(f64::min), end(f64::max)];
        low.zip(high).map_or(0.0, |(low, high)| (high - low).amax())
    }

    fn solid(&self, room: &Extent) -> Result<Solid, Fault> {
        match self {
            Form::Outlines(outlines) => Solid::outlines(outlines, room),
            Form::Surface { points, triangles } => {
                let corners = |t: &[usize; 3]| t.map(|k| Vector3::from(points[k]));
                Solid::simplified(&triangles.iter().map(corners).collect::<Vec<_>>(), room)
            }
        }
    }
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
    /// A wall of this form in a room, with this centre (m); default the centre of its volume, of
    /// one that rests along periodic axes the middle of the room.
    ///
    /// # Errors
    /// When the form is no solid, in words.
    pub(super) fn new(
        form: Form,
        room: &Extent,
        centre: Option<Vec<f64>>,
        moves: bool,
    ) -> Result<Wall, Fault> {
        let mut solid = form.solid(room)?;
        let middle = solid.centre();
        let of_volume = solid.centre_of_volume();
        let usual = |a: usize| if room.periodic[a] && !moves { middle[a] } else { of_volume[a] };
        let given = |a: usize| centre.as_ref().and_then(|centre| centre.get(a)).copied();
        let at = Vector3::from_fn(|a, _| given(a).unwrap_or_else(|| usual(a)));
        // Seen from the middle of a period, which may begin anywhere, images are as far away on
        // both sides.
        let own = Vector3::from_fn(|a, _| if room.periodic[a] { middle[a] } else { at[a] });
        if (0..3).any(|a| room.periodic[a] && at[a] != middle[a]) {
            let mut moved = form.clone();
            moved.map(|a, x| if room.periodic[a] { x + (middle[a] - at[a]) } else { x });
            solid = moved.solid(room)?;
        }
        let solid = if own == middle { solid } else { solid.about(&own)? };
        let centre = at.iter().take(solid.dimension()).copied().collect();
        Ok(Wall { form: Arc::new(form), geometry: Arc::new(solid), centre })
    }

    /// Unites walls that overlap or touch, all at rest, into one solid for the fluid, on a grid of
    /// this spacing (m).
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

    /// Its geometry, with the origin at its centre.
    pub fn geometry(&self) -> &Arc<Solid> {
        &self.geometry
    }

    /// Reference point of its torque and centre of its rotation (m), a number for each axis.
    pub fn centre(&self) -> &[f64] {
        &self.centre
    }

    /// The ends of its surface in the box along each axis (m).
    pub fn bounds(&self) -> [Vector3<f64>; 2] {
        let centre = self.geometry.centre();
        let moved = Vector3::from_fn(|a, _| self.centre.get(a).map_or(0.0, |at| at - centre[a]));
        self.geometry.bounds().map(|end| end + moved)
    }

    /// Width of its thinnest part (m); infinite where there is none.
    pub fn thickness(&self) -> f64 {
        self.geometry.thickness()
    }

    /// Distance of a place in the box (m) from its surface at time 0, and the normal there.
    pub fn nearest(&self, place: &[f64]) -> Nearest {
        let arm = |a: usize| Some(place.get(a)? - self.centre.get(a)?);
        self.geometry.nearest(&Vector3::from_fn(|a, _| arm(a).unwrap_or(0.0)))
    }

    /// Its keys in a case, with nothing in other files.
    pub(in crate::config) fn typed(&self) -> super::Obstacle {
        let mut typed = super::Obstacle::default();
        match &*self.form {
            Form::Outlines(outlines) => {
                let outlines = Some(outlines.clone());
                typed.polygon = Some(Outlines { outlines, ..Outlines::default() });
            }
            Form::Surface { points, triangles } => {
                let points = Some(points.clone());
                let triangles = Some(triangles.clone());
                typed.surface = Some(Surface { points, triangles, ..Surface::default() });
            }
        }
        typed.centre = Some(self.centre.clone());
        typed
    }

    /// Number of its outlines, corners or triangles, in words.
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
