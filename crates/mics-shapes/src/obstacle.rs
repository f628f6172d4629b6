//! Obstacles: walls of any shape that stand in the domain or cross its sides, concave too.
//!
//! ```text
//!      ____________________     the solid is closed: a bed's outline goes on below the domain.
//!     |          __        |    Of its surface only what lies within the domain is a wall: parts
//!     |_______ ,'  `.______|    on a side of the domain, or beyond one, are none, so that no
//!     :///////'//////`/////:    distance is measured to them. Across a periodic side the walls go
//!     :////////////////////:    on with their images.
//! ```
//! Distances are from the nearest triangle, with the sign by the pseudo-normals of its corners and
//! edges (Baerentzen and Aanaes 2005, doi 10.1109/TVCG.2005.49); fractions are exact
//! ([`super::solid`], [`super::section`]). An outline (2D) is a wall of triangles along z.

mod walls;

use super::mesh::{Mesh, place};
use super::section::Section;
use super::solid::BoxSection;
use super::{Fault, Geometry, Nearest, Part, Patch, Pose, outline, patches};
use crate::part::Core;
use nalgebra::{Matrix3, Vector2, Vector3};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::query::{PointQuery, PointQueryWithLocation, Ray, RayCast};
use parry3d_f64::shape::{TriMesh, TriMeshFlags};
use std::cell::RefCell;
use walls::{ON_SIDE, Walls, segment};

/// The domain that an obstacle stands in: a box from the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// Lengths (m); in 2D the third is not used.
    pub size: Vector3<f64>,
    /// Which axes are periodic.
    pub periodic: [bool; 3],
}

/// A wall of any shape, in the axes of the domain; its own origin is the middle of the domain, or
/// where [`Obstacle::about`] puts it.
#[derive(Clone)]
pub struct Obstacle {
    dimension: usize,
    surface: Walls,
    /// All of its closed surface, and the walls among it.
    whole: TriMesh,
    mesh: TriMesh,
    /// The walls as contacts see them.
    faces: Mesh,
    room: Room,
    radius: f64,
    thickness: f64,
    /// Volume within the domain (m3; m2 in 2D) and its first moment about the own origin.
    filled: (f64, Vector3<f64>),
}

impl std::fmt::Debug for Obstacle {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "Obstacle of {} walls in {} dimensions", self.surface.walls.len(), self.dimension)
    }
}

impl PartialEq for Obstacle {
    fn eq(&self, other: &Obstacle) -> bool {
        let of = |o: &Obstacle| (o.dimension, o.room, o.surface.middle);
        of(self) == of(other) && self.surface.solid == other.surface.solid
    }
}

thread_local! {
    static FLAT: RefCell<Section> = RefCell::default();
    static BOX: RefCell<BoxSection> = RefCell::default();
}

fn mesh_of(triangles: &[[Vector3<f64>; 3]]) -> Result<TriMesh, Fault> {
    let corners = triangles.iter().flatten().map(place).collect();
    let numbers = (0..triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    // Corners that are one have the normals of all their triangles.
    let flags = TriMeshFlags::MERGE_DUPLICATE_VERTICES | TriMeshFlags::ORIENTED;
    TriMesh::with_flags(corners, numbers, flags)
        .map_err(|e| Fault(format!("the surface cannot be used: {e}")))
}

impl Obstacle {
    /// From closed outlines (2D) in the axes of the domain (m): one way round what is solid, the
    /// other way round holes.
    ///
    /// # Errors
    /// When there is no outline, one has fewer than three corners or crosses itself, or none of it
    /// is within the domain.
    pub fn outlines(outlines: &[Vec<[f64; 2]>], room: &Room) -> Result<Obstacle, Fault> {
        let deep = 10.0 * room.size.xy().amax();
        let mut triangles = Vec::new();
        // All the other way round where that makes more solid than holes.
        let whole: f64 = outlines.iter().map(|outline| outline::area(outline)).sum();
        for outline in outlines {
            outline::check(outline)?;
            for k in 0..outline.len() {
                let [p, q] = [k, (k + 1) % outline.len()].map(|k| outline[k]);
                let [p, q] = if whole < 0.0 { [q, p] } else { [p, q] };
                let [a, b] = [p, q].map(|[x, y]| Vector3::new(x, y, -deep));
                let up = 2.0 * deep * Vector3::z();
                triangles.extend([[a, b, b + up], [a, b + up, a + up]]);
            }
        }
        Obstacle::of(2, triangles, room)
    }

    /// From a closed surface (3D) in the axes of the domain (m), corners counterclockwise seen from
    /// outside.
    ///
    /// # Errors
    /// When none of it is within the domain.
    pub fn surface(triangles: &[[Vector3<f64>; 3]], room: &Room) -> Result<Obstacle, Fault> {
        Obstacle::of(3, triangles.to_vec(), room)
    }

    fn of(dimension: usize, given: Vec<[Vector3<f64>; 3]>, room: &Room) -> Result<Obstacle, Fault> {
        Obstacle::made(Walls::of(dimension, given, room)?, dimension, room)
    }

    fn made(surface: Walls, dimension: usize, room: &Room) -> Result<Obstacle, Fault> {
        let mut obstacle = Obstacle {
            dimension,
            whole: mesh_of(&surface.solid)?,
            mesh: mesh_of(&surface.walls)?,
            faces: surface.faces(dimension, room),
            radius: surface.reach(),
            surface,
            room: *room,
            thickness: 0.0,
            filled: (0.0, Vector3::zeros()),
        };
        obstacle.thickness = obstacle.find_thickness();
        obstacle.filled = obstacle.within_domain();
        Ok(obstacle)
    }

    /// The same with its own origin at another place of the domain (m); along periodic axes that
    /// has to be the middle.
    ///
    /// # Errors
    /// As [`Obstacle::surface`].
    pub fn about(&self, place: &Vector3<f64>) -> Result<Obstacle, Fault> {
        let surface = self.surface.moved(&(self.centre() - place));
        Obstacle::made(surface, self.dimension, &self.room)
    }

    /// Where its own origin lies in the domain (m).
    pub fn centre(&self) -> Vector3<f64> {
        let half = 0.5 * self.room.size;
        let middle = &self.surface.middle;
        Vector3::from_fn(|a, _| if a < self.dimension { half[a] - middle[a] } else { 0.0 })
    }

    /// Centre of the volume that it has in the domain (m).
    pub fn centre_of_volume(&self) -> Vector3<f64> {
        let (volume, first) = self.filled;
        self.centre() + first / volume
    }

    /// The ends of its surface within the domain along each axis (m).
    pub fn bounds(&self) -> [Vector3<f64>; 2] {
        [self.surface.low, self.surface.high].map(|end| end + self.centre())
    }

    /// Volume within the domain (m3, m2 in 2D) and its first moment about the own origin.
    fn within_domain(&self) -> (f64, Vector3<f64>) {
        let half = 0.5 * self.room.size;
        let edges = [0, 1, 2].map(|a| {
            let mut edge = Vector3::zeros();
            if a < self.dimension {
                edge[a] = half[a];
            }
            edge
        });
        self.filled(&self.surface.middle, &edges)
    }

    /// How far it is from the middles of its walls straight through the solid to another wall, at
    /// least (m).
    fn find_thickness(&self) -> f64 {
        let size = self.room.size.amax();
        let off = 1e-6 * size;
        let through = |t: &[Vector3<f64>; 3]| {
            let mut middle = (t[0] + t[1] + t[2]) / 3.0;
            if self.dimension == 2 {
                middle.z = 0.0;
            }
            let inwards = (t[2] - t[0]).cross(&(t[1] - t[0])).try_normalize(0.0)?;
            let from = middle + off * inwards;
            let ray = Ray::new(place(&from), place(&inwards));
            self.mesh.cast_local_ray(&ray, 2.0 * size, false).map(|way| way + off)
        };
        self.surface.walls.iter().filter_map(through).fold(f64::INFINITY, f64::min)
    }

    /// Its walls as contacts see them.
    pub fn faces(&self) -> &Mesh {
        &self.faces
    }

    /// The gap between a part of a body in this pose, in the axes of the obstacle, and its walls
    /// (m), negative where they overlap, and the direction from the part to there.
    pub fn gap(&self, part: &Part, pose: &Pose) -> (Vector3<f64>, f64) {
        let nearest = self.nearest(&(pose.place + pose.orientation * part.place));
        let round = (-nearest.normal, nearest.distance - part.rounding);
        if part.core == Core::Point || nearest.distance <= 0.0 {
            return round;
        }
        self.faces.gap(part, pose, nearest.distance).unwrap_or(round)
    }

    /// Its walls, corners counterclockwise seen from outside (m).
    pub fn walls(&self) -> &[[Vector3<f64>; 3]] {
        &self.surface.walls
    }

    /// The segment that one of its walls stands on in 2D, with the solid on its left; of two
    /// triangles on one segment the first has it (m).
    pub fn segment(&self, wall: &[Vector3<f64>; 3]) -> Option<[Vector3<f64>; 2]> {
        segment(wall).map(|ends| ends.map(|end| end.push(0.0)))
    }

    /// Whether a point is within the solid.
    fn has(&self, point: &Vector3<f64>) -> bool {
        self.mesh.project_local_point(place(point), false).is_inside
    }

    /// Calls `take` with the triangles of the solid that may pass a box with these ends (m).
    fn near(
        &self,
        low: &Vector3<f64>,
        high: &Vector3<f64>,
        mut take: impl FnMut(&[Vector3<f64>; 3]),
    ) {
        let wider = Vector3::repeat(1e-9 * (high - low).amax());
        let bounds = Aabb::new(place(&(low - wider)), place(&(high + wider)));
        self.whole
            .bvh()
            .intersect_aabb(&bounds)
            .for_each(|k| take(&self.surface.solid[k as usize]));
    }
}

impl Geometry for Obstacle {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn radius(&self) -> f64 {
        self.radius
    }

    /// Of what lies within the domain.
    fn volume(&self) -> f64 {
        self.filled.0
    }

    /// An obstacle does not respond to forces: as of a ball that holds it.
    fn inertia(&self) -> Matrix3<f64> {
        Matrix3::from_diagonal_element(0.5 * self.volume() * self.radius * self.radius)
    }

    fn thickness(&self) -> f64 {
        self.thickness
    }

    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let (found, (triangle, _)) =
            self.mesh.project_local_point_and_get_location(place(point), false);
        let foot = Vector3::new(found.point.x, found.point.y, found.point.z);
        let (arm, sign) = (point - foot, if found.is_inside { -1.0 } else { 1.0 });
        let distance = arm.norm();
        let normal = if distance > 1e-12 * self.radius {
            sign / distance * arm
        } else {
            let [a, b, c] = self.surface.walls[triangle as usize];
            (b - a).cross(&(c - a)).normalize()
        };
        Nearest { distance: sign * distance, normal }
    }

    fn surface(&self, spacing: f64) -> Vec<Patch> {
        let mut all = Vec::new();
        let half = 0.5 * self.room.size;
        let within = |x: &Vector3<f64>| {
            (0..self.dimension)
                .all(|a| (x[a] - self.surface.middle[a]).abs() <= half[a] * (1.0 + ON_SIDE))
        };
        for [a, b, c] in &self.surface.walls {
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { continue };
            if self.dimension == 3 {
                patches::of_triangle(&[*a, *b, *c], &normal, spacing, &mut all);
            } else if let Some([from, to]) = segment(&[*a, *b, *c]) {
                let way = to - from;
                let n = (way.norm() / spacing).ceil().max(1.0);
                all.extend((0..n as usize).map(|k| {
                    let at = from + (k as f64 + 0.5) / n * way;
                    Patch { place: at.push(0.0), normal, area: way.norm() / n }
                }));
            }
        }
        all.retain(|patch| within(&patch.place));
        all
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        n.zip_zip_map(&self.surface.low, &self.surface.high, |n, low, high| (n * low).max(n * high))
            .sum()
    }

    fn filled(&self, middle: &Vector3<f64>, half: &[Vector3<f64>; 3]) -> (f64, Vector3<f64>) {
        let lengths = half.map(|edge| edge.norm());
        let reach = half.iter().map(|edge| edge.abs()).sum::<Vector3<f64>>();
        // Into the axes of the box and back.
        let axes = [0, 1].map(|k| half[k] / lengths[k]);
        let axes = [axes[0], axes[1], axes[0].cross(&axes[1])];
        let turned = |x: &Vector3<f64>| Vector3::from_fn(|a, _| axes[a].dot(&(x - middle)));
        let back = |x: &Vector3<f64>| middle + (0..3).map(|a| x[a] * axes[a]).sum::<Vector3<f64>>();
        if self.dimension == 2 {
            return FLAT.with_borrow_mut(|section| {
                let half = Vector2::new(lengths[0], lengths[1]);
                section.begin(&half);
                self.near(&(middle - reach), &(middle + reach), |t| {
                    if let Some(ends) = segment(t) {
                        let [p, q] = ends.map(|x| turned(&x.push(middle.z)).xy());
                        section.add(&p, &q);
                    }
                });
                let (area, first) = section.end(|at| self.has(&back(&at.push(0.0)).xy().push(0.0)));
                let first = back(&first.push(0.0)) - middle;
                (area, area * middle + first)
            });
        }
        BOX.with_borrow_mut(|room| {
            room.begin(&Vector3::from(lengths));
            self.near(&(middle - reach), &(middle + reach), |t| {
                room.add(&t.each_ref().map(turned))
            });
            let (volume, first) = room.end(|x| self.has(&back(x)));
            (volume, volume * middle + back(&first) - middle)
        })
    }

    fn meets_itself(&self, foot: &Vector3<f64>, normal: &Vector3<f64>) -> Option<f64> {
        // From a little above, so that it does not meet the wall that it stands on.
        let above = 1e-9 * self.radius;
        let ray = Ray::new(place(&(foot + above * normal)), place(normal));
        self.mesh.cast_local_ray(&ray, 2.0 * self.radius, false).map(|way| way + above)
    }

    fn obstacle(&self) -> Option<&Obstacle> {
        Some(self)
    }

    fn parts(&self) -> &[Part] {
        &[]
    }

    fn triangles(&self, _spacing: f64) -> Vec<[Vector3<f64>; 3]> {
        if self.dimension == 3 {
            return self.surface.walls.clone();
        }
        let segments = self.surface.walls.iter().filter_map(segment);
        segments.map(|[a, b]| [a, b, b].map(|x| x.push(0.0))).collect()
    }
}

#[cfg(test)]
mod tests;
