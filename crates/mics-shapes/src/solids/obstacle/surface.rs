//! The surface that the fluid meets of an obstacle, or of several that touch: one solid, whose
//! walls each belong to one of them.
//!
//! ```text
//!        :  pier  :        walls are those of the union. A place that several enclose counts once
//!    ____:_    ___:____    and belongs to the first of them; a place in none, to the one with the
//!     bed  :  :     bed    nearest wall.
//! ```
//! Distances are from the nearest wall. A place is inside where the column above it leaves the
//! solid more often than it enters, which no edge or corner makes uncertain; on a wall it is
//! inside.

use super::columns::Columns;
use super::walls;
use super::{Extent, Face};
use crate::boxes::{rim, rows};
use crate::contact::faces::place;
use crate::{Fault, Nearest, Tile};
use nalgebra::Vector3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::query::{PointQueryWithLocation, Ray, RayCast};
use parry3d_f64::shape::{TriMesh, Triangle};

/// Distance (of the domain's size) below which a place is on a wall.
const ON_WALL: f64 = 1e-12;

/// Slack for the foot of a perpendicular at the edge of a face, as a part of the face.
const AT_EDGE: f64 = 1e-9;

/// Sine of the angle between two faces that are one plane.
const ALIKE: f64 = 1e-6;

/// The surface of one solid, in the axes of the domain.
pub struct ObstacleSurface {
    dimension: usize,
    /// Diameter of the domain (m).
    size: f64,
    solid: Columns,
    /// The ways to its images that the solid does not hold (m), itself among them.
    images: Vec<Vector3<f64>>,
    walls: Vec<(Face, u32)>,
    /// The walls as triangles: in 2D two for each, along z.
    mesh: TriMesh,
    /// The closed surfaces of those that it is the union of, images among them where it has them;
    /// none of a single one.
    members: Vec<Columns>,
}

impl ObstacleSurface {
    /// Surface of a closed one (m) whose faces have the numbers of the `members` that they belong
    /// to, and which holds its images along the periodic axes of `has_images`.
    ///
    /// # Errors
    /// When none of it is within the domain.
    pub fn new(
        dimension: usize,
        faces: Vec<(Face, u32)>,
        members: Vec<Columns>,
        room: &Extent,
        has_images: &[bool; 3],
    ) -> Result<ObstacleSurface, Fault> {
        let mut images = vec![Vector3::zeros()];
        for a in (0..dimension).filter(|a| room.periodic[*a] && !has_images[*a]) {
            let own = images.clone();
            for way in [-room.size[a], room.size[a]] {
                images.extend(own.iter().map(|image| image + way * Vector3::ith(a, 1.0)));
            }
        }
        let solid = Columns::new(dimension, faces.iter().map(|(face, _)| *face).collect());
        let walls = walls::of(faces, dimension, room, has_images);
        if walls.is_empty() {
            return Err(Fault("has no surface within the domain".to_owned()));
        }
        let lengths = Vector3::from_fn(|a, _| if a < dimension { room.size[a] } else { 0.0 });
        let size = lengths.norm();
        let mesh = mesh_of(dimension, walls.iter().map(|(face, _)| face), size)?;
        Ok(ObstacleSurface { dimension, size, solid, images, walls, mesh, members })
    }

    /// Its walls, each with the number of the member that it belongs to.
    pub fn walls(&self) -> &[(Face, u32)] {
        &self.walls
    }

    /// The number of a wall from that of a triangle.
    fn wall(&self, triangle: u32) -> usize {
        if self.dimension == 2 { triangle as usize / 2 } else { triangle as usize }
    }

    fn normal(&self, wall: usize) -> Vector3<f64> {
        normal(self.dimension, &self.walls[wall].0)
    }

    /// Whether a place (m) is within the solid.
    pub fn has(&self, x: &Vector3<f64>) -> bool {
        self.images.iter().any(|image| self.solid.has(&(x - image)))
    }

    /// The nearest wall to a place (m): where it is, and its number.
    fn nearest_wall(&self, x: &Vector3<f64>) -> (Vector3<f64>, usize) {
        let (found, (triangle, _)) =
            self.mesh.project_local_point_and_get_location(place(x), false);
        let foot = Vector3::new(found.point.x, found.point.y, found.point.z);
        (foot, self.wall(triangle))
    }

    /// The nearest point of a wall to a place (m).
    pub fn nearest(&self, x: &Vector3<f64>) -> Nearest {
        let (foot, wall) = self.nearest_wall(x);
        let arm = x - foot;
        let distance = arm.norm();
        if distance <= ON_WALL * self.size {
            return Nearest { distance: 0.0, normal: self.normal(wall) };
        }
        let sign = if self.has(x) { -1.0 } else { 1.0 };
        Nearest { distance: sign * distance, normal: sign / distance * arm }
    }

    /// The feet of the perpendiculars from a place inside (m) on walls up to `within` (m) away,
    /// those of one plane once.
    pub fn feet(&self, x: &Vector3<f64>, within: f64, feet: &mut Vec<Nearest>) {
        feet.clear();
        let reach = Vector3::repeat(within);
        let bounds = Aabb::new(place(&(x - reach)), place(&(x + reach)));
        for triangle in self.mesh.bvh().intersect_aabb(&bounds) {
            let wall = self.wall(triangle);
            let face = &self.walls[wall].0;
            let normal = self.normal(wall);
            let depth = (face[0] - x).dot(&normal);
            let foot = x + depth * normal;
            let is_other = |known: &Nearest| {
                known.normal.cross(&normal).norm() > ALIKE
                    || (known.distance + depth).abs() > ALIKE * within
            };
            if depth > 0.0
                && depth <= within
                && holds(self.dimension, face, &normal, &foot)
                && feet.iter().all(is_other)
            {
                feet.push(Nearest { distance: -depth, normal });
            }
        }
    }

    /// Calls with the boxes between `planes` (m) that it reaches, where `at` puts its places (m).
    pub fn tile(
        &self,
        at: impl Fn(&Vector3<f64>) -> Vector3<f64>,
        planes: &[Vec<f64>; 3],
        found: &mut dyn FnMut(&Tile),
    ) {
        let placed = |image: &Vector3<f64>, face: &Face| face.map(|x| at(&(x + image)));
        let faces = self
            .images
            .iter()
            .flat_map(|image| self.solid.faces().iter().map(move |face| placed(image, face)));
        if self.dimension == 2 {
            rim::tile(planes, found, |rim, planes| {
                faces.for_each(|[from, to, _]| rim.add_side(planes, &from.xy(), &to.xy()));
            });
        } else {
            rows::tile(planes, found, |rows| faces.for_each(|face| rows.add_face(planes, face)));
        }
    }

    /// The member that a place (m) belongs to.
    pub fn owner(&self, x: &Vector3<f64>) -> u32 {
        if self.members.is_empty() {
            return 0;
        }
        let has = |member: &Columns| self.images.iter().any(|image| member.has(&(x - image)));
        let first = self.members.iter().position(has);
        first.map_or_else(|| self.walls[self.nearest_wall(x).1].1, |member| member as u32)
    }

    /// Distance (m) from a place (m) along a direction of length 1 to a wall; none beyond `within`.
    /// The faces count as a little wider than they are: a ray through an edge meets one of them.
    pub fn meets(&self, from: &Vector3<f64>, along: &Vector3<f64>, within: f64) -> Option<f64> {
        let ray = Ray::new(place(from), place(along));
        let meets = |triangle: u32, within: f64| {
            let face = self.mesh.triangle(triangle);
            let middle = face.center();
            let wider = |corner| corner + AT_EDGE * (corner - middle);
            Triangle::new(wider(face.a), wider(face.b), wider(face.c))
                .cast_local_ray(&ray, within, false)
        };
        Some(self.mesh.bvh().cast_ray(&ray, within, meets)?.1)
    }

    /// Least distance (m) from the middles of the walls of a member straight through the solid to
    /// another wall; infinite where there is none.
    pub fn thickness(&self, number: u32) -> f64 {
        let off = 1e-6 * self.size;
        let through = |(wall, (face, _)): (usize, &(Face, u32))| {
            let inwards = -self.normal(wall);
            let middle = match self.dimension {
                2 => 0.5 * (face[0] + face[1]),
                _ => (face[0] + face[1] + face[2]) / 3.0,
            };
            let way = self.meets(&(middle + off * inwards), &inwards, self.size)?;
            Some(way + off)
        };
        let own = self.walls.iter().enumerate().filter(|(_, (_, of))| *of == number);
        own.filter_map(through).fold(f64::INFINITY, f64::min)
    }
}

/// The outward normal of a face, of length 1; zero of one without extent.
pub fn normal(dimension: usize, [a, b, c]: &Face) -> Vector3<f64> {
    let normal =
        if dimension == 2 { (b - a).cross(&Vector3::z()) } else { (b - a).cross(&(c - a)) };
    normal.try_normalize(0.0).unwrap_or_default()
}

/// Whether a point of a face's plane lies on the face.
fn holds(dimension: usize, face: &Face, normal: &Vector3<f64>, x: &Vector3<f64>) -> bool {
    let edges = if dimension == 2 { 1 } else { 3 };
    (0..edges).all(|k| {
        let way = face[(k + 1) % 3] - face[k];
        let arm = x - face[k];
        if dimension == 2 {
            let t = arm.dot(&way) / way.norm_squared();
            return (-AT_EDGE..=1.0 + AT_EDGE).contains(&t);
        }
        way.cross(&arm).dot(normal) >= -AT_EDGE * way.norm_squared()
    })
}

/// The triangles of faces; in 2D two along z for each. The diagonal between them passes z = 0 at no
/// simple part of the segment, where rays along the grid would meet neither.
fn mesh_of<'a>(
    dimension: usize,
    faces: impl Iterator<Item = &'a Face>,
    size: f64,
) -> Result<TriMesh, Fault> {
    let below = -10.0 * size * Vector3::z();
    let above = 17.3 * size * Vector3::z();
    let triangles = |[a, b, c]: &Face| match dimension {
        2 => vec![a + below, b + below, b + above, a + below, b + above, a + above],
        _ => vec![*a, *b, *c],
    };
    let corners: Vec<_> = faces.flat_map(triangles).map(|x| place(&x)).collect();
    let numbers = (0..corners.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    TriMesh::new(corners, numbers).map_err(|e| Fault(format!("the surface cannot be used: {e}")))
}
