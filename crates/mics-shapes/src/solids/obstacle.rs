//! Obstacles: walls of any shape that stand in the domain or cross its sides, concave too.
//!
//! ```text
//!     given surface    closed, moved into the periods                      [`walls`]
//!       -> contacts    its walls as faces                                  [`Mesh`]
//!       -> fluid       the union with all fixed obstacles that it touches  [`surface`], [`union`]
//! ```
//! In a periodic domain an obstacle consists of its surface and all images of it.

mod columns;
mod surface;
mod union;
mod walls;

use crate::contact::faces::Mesh;
use crate::contact::part::Core;
use crate::contact::region;
use crate::surface::{outline, patches};
use crate::{Fault, Lattice, Nearest, Part, Pose, Shape, SurfacePoint, Tile};
use columns::Columns;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;
use surface::ObstacleSurface;
use walls::Across;

/// A face: a triangle, counterclockwise seen from outside; in 2D a segment with the solid on its
/// left, whose third corner repeats the second (m).
type Face = [Vector3<f64>; 3];

/// The domain that an obstacle stands in: a box from the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
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
    room: Extent,
    /// Its own closed surface, in the axes of the domain.
    given: Arc<[Face]>,
    /// Its own walls, each with the number of the given face that it is, or is an image of.
    walls: Arc<[(Face, u32)]>,
    bounds: [Vector3<f64>; 2],
    /// Where its own origin lies in the domain (m).
    origin: Vector3<f64>,
    radius: f64,
    /// Its walls as contacts see them, from its own origin.
    faces: Mesh,
    /// Its own surface.
    own: Arc<ObstacleSurface>,
    /// The solid that the fluid meets.
    met: Met,
    /// Width of its thinnest part there (m).
    thickness: f64,
    /// Volume within the domain (m3; m2 in 2D) and its first moment about the own origin, without
    /// regard to others.
    filled: (f64, Vector3<f64>),
}

/// The solid that the fluid meets: the obstacle itself, or its union with others.
#[derive(Clone)]
struct Met {
    surface: Arc<ObstacleSurface>,
    /// The obstacle's number among those of the union.
    number: u32,
    /// The part of the volume within the domain that belongs to the obstacle (m3; m2 in 2D).
    share: f64,
    /// Distance beyond the obstacle's bounds within which places may belong to it (m).
    margin: f64,
}

impl std::fmt::Debug for Obstacle {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "Obstacle of {} walls in {} dimensions", self.walls.len(), self.dimension)
    }
}

impl PartialEq for Obstacle {
    fn eq(&self, other: &Obstacle) -> bool {
        let of = |o: &Obstacle| (o.dimension, o.room, o.origin);
        of(self) == of(other) && self.given == other.given
    }
}

impl Obstacle {
    /// From closed outlines (2D) in the axes of the domain (m): one way round what is solid, the
    /// other way round holes. Where outlines overlap or touch, it is their union.
    ///
    /// # Errors
    /// When there is no outline, one has fewer than three corners or crosses itself, or none of it
    /// is within the domain.
    pub fn outlines(outlines: &[Vec<[f64; 2]>], room: &Extent) -> Result<Obstacle, Fault> {
        let mut faces = Vec::new();
        // All the other way round where that makes more solid than holes.
        let whole: f64 = outlines.iter().map(|outline| outline::area(outline)).sum();
        for outline in outlines {
            outline::check(outline)?;
            let mut corners: Vec<_> =
                outline.iter().map(|[x, y]| Vector3::new(*x, *y, 0.0)).collect();
            if whole < 0.0 {
                corners.reverse();
            }
            let next = |k: usize| corners[(k + 1) % corners.len()];
            faces.extend((0..corners.len()).map(|k| [corners[k], next(k), next(k)]));
        }
        if outlines.len() > 1 {
            let all: Vec<_> = faces.iter().map(|face| (*face, 0)).collect();
            faces = union::union(2, &all)?.into_iter().map(|(face, _)| face).collect();
        }
        Obstacle::of(2, faces, room)
    }

    /// From a closed surface (3D) in the axes of the domain (m), corners counterclockwise seen from
    /// outside.
    ///
    /// # Errors
    /// When none of it is within the domain.
    pub fn surface(triangles: &[Face], room: &Extent) -> Result<Obstacle, Fault> {
        Obstacle::of(3, triangles.to_vec(), room)
    }

    /// As [`Obstacle::surface`], where it overlaps with itself: what it encloses counts once.
    ///
    /// # Errors
    /// As [`Obstacle::surface`].
    pub fn simplified(triangles: &[Face], room: &Extent) -> Result<Obstacle, Fault> {
        if !union::crosses_itself(triangles) {
            return Obstacle::surface(triangles, room);
        }
        let all: Vec<_> = triangles.iter().map(|face| (*face, 0)).collect();
        let faces = union::union(3, &all)?.into_iter().map(|(face, _)| face).collect();
        Obstacle::of(3, faces, room)
    }

    fn of(dimension: usize, mut faces: Vec<Face>, room: &Extent) -> Result<Obstacle, Fault> {
        walls::bring_into_period(&mut faces, room);
        let (surface, solid) = merged(dimension, &[&faces], room)?;
        let numbered = faces.iter().copied().zip(0..).collect();
        // Its own walls: of those that lie on each other across a period, the union's.
        let walls: Vec<_> = match solid {
            true => surface.walls().iter().map(|(face, _)| *face).zip(0..).collect(),
            false => walls::of(numbered, dimension, room, &[false; 3]),
        };
        let bounds = walls::bounds(&walls, &walls::ends(faces.iter()), dimension, room)?;
        let surface = Arc::new(surface);
        let mut obstacle = Obstacle {
            dimension,
            room: *room,
            given: faces.into(),
            bounds,
            origin: Vector3::zeros(),
            radius: 0.0,
            faces: Mesh::new(dimension, std::iter::empty(), room.size.amax()),
            walls: walls.into(),
            thickness: surface.thickness(0),
            own: surface.clone(),
            met: Met { surface, number: 0, share: 0.0, margin: 0.0 },
            filled: (0.0, Vector3::zeros()),
        };
        let half = |a: usize| if a < dimension { 0.5 * room.size[a] } else { 0.0 };
        obstacle.place(&Vector3::from_fn(|a, _| half(a)));
        Ok(obstacle)
    }

    /// Puts the own origin at a place of the domain (m).
    fn place(&mut self, origin: &Vector3<f64>) {
        self.origin = *origin;
        self.radius = walls::reach(&self.walls, origin, self.dimension, &self.room);
        let moved = self.walls.iter().map(|(face, number)| (face.map(|x| x - origin), *number));
        self.faces = Mesh::new(self.dimension, moved, self.room.size.amax());
        let (volume, first) = within(&self.own, self.dimension, &self.room);
        self.filled = (volume, first - volume * origin);
        self.met.share = volume;
    }

    /// The obstacle with its own origin at another place of the domain (m); along periodic axes
    /// that has to be the middle.
    ///
    /// # Errors
    /// As [`Obstacle::surface`].
    pub fn about(&self, place: &Vector3<f64>) -> Result<Obstacle, Fault> {
        let mut obstacle = self.clone();
        obstacle.place(place);
        Ok(obstacle)
    }

    /// Lets the fluid meet the union of those obstacles that overlap or touch, all at rest in one
    /// domain, on a grid of this spacing (m).
    ///
    /// # Errors
    /// When a surface is not closed.
    pub fn unite(all: &mut [&mut Obstacle], spacing: f64) -> Result<(), Fault> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for k in 0..all.len() {
            let touches = |group: &Vec<usize>| group.iter().any(|j| all[*j].may_touch(all[k]));
            let (joined, mut others): (Vec<_>, Vec<_>) = groups.into_iter().partition(touches);
            let mut group: Vec<usize> = joined.into_iter().flatten().collect();
            group.push(k);
            group.sort_unstable();
            others.push(group);
            groups = others;
        }
        for group in groups.iter().filter(|group| group.len() > 1) {
            let dimension = all[group[0]].dimension;
            let room = all[group[0]].room;
            let mut below = 0.0;
            for number in 0..group.len() {
                let given: Vec<_> =
                    group[..=number].iter().map(|k| all[*k].given.clone()).collect();
                let given: Vec<&[Face]> = given.iter().map(|faces| &**faces).collect();
                let surface = Arc::new(merged(dimension, &given, &room)?.0);
                let volume = within(&surface, dimension, &room).0;
                // The first of several has all that they enclose together.
                all[group[number]].met.share = volume - below;
                below = volume;
                for k in &group[..=number] {
                    all[*k].met.surface = surface.clone();
                }
            }
            for (number, k) in (0..).zip(group) {
                let obstacle = &mut *all[*k];
                obstacle.met.number = number;
                obstacle.thickness = obstacle.met.surface.thickness(number);
                obstacle.met.margin = spacing;
            }
        }
        Ok(())
    }

    /// Whether boxes about the two, or images of them, overlap or touch.
    fn may_touch(&self, other: &Obstacle) -> bool {
        let [one, two] = [self, other].map(|o| walls::ends(o.given.iter()));
        (0..self.dimension).all(|a| {
            let period = if self.room.periodic[a] { self.room.size[a] } else { 0.0 };
            let near = walls::ON_SIDE * self.room.size[a];
            [0.0, period, -period].iter().any(|way| {
                one[0][a] + way <= two[1][a] + near && two[0][a] <= one[1][a] + way + near
            })
        })
    }

    /// Where its own origin lies in the domain (m).
    pub fn centre(&self) -> Vector3<f64> {
        self.origin
    }

    /// Centre of the volume that it has in the domain (m).
    pub fn centre_of_volume(&self) -> Vector3<f64> {
        let (volume, first) = self.filled;
        self.centre() + first / volume
    }

    /// The ends of its surface within the domain along each axis (m).
    pub fn bounds(&self) -> [Vector3<f64>; 2] {
        self.bounds
    }

    /// Its walls as contacts see them.
    pub fn faces(&self) -> &Mesh {
        &self.faces
    }

    /// Its walls, from its own origin: triangles with corners counterclockwise seen from outside;
    /// in 2D segments with the solid on their left, the second corner twice (m).
    pub fn walls(&self) -> impl Iterator<Item = [Vector3<f64>; 3]> {
        self.walls.iter().map(|(face, _)| face.map(|x| x - self.origin))
    }

    /// Its closed surface, from its own origin, beyond the domain too: corners as those of
    /// [`Obstacle::walls`].
    pub fn closed(&self) -> impl Iterator<Item = [Vector3<f64>; 3]> {
        self.given.iter().map(|face| face.map(|x| x - self.origin))
    }

    /// The gap between a part of a body in this pose, in the axes of the obstacle, and its walls
    /// (m), negative where they overlap, and the direction from the part to there.
    pub fn gap(&self, part: &Part, pose: &Pose) -> (Vector3<f64>, f64) {
        let place = pose.place + pose.orientation * part.place;
        let nearest = self.own.nearest(&(place + self.origin));
        let round = (-nearest.normal, nearest.distance - part.rounding);
        if part.core == Core::Point || nearest.distance <= 0.0 {
            return round;
        }
        if let Core::Polytope(polytope) = &part.core
            && nearest.distance < part.radius
        {
            let at = |corner: &Vector3<f64>| place + pose.orientation * corner + self.origin;
            let corners = polytope.corners.iter().map(|corner| self.own.nearest(&at(corner)));
            let deepest = corners.min_by(|a, b| a.distance.total_cmp(&b.distance));
            if let Some(within) = deepest.filter(|corner| corner.distance < 0.0) {
                return (-within.normal, within.distance - part.rounding);
            }
        }
        region::gap(&self.faces, part, pose, nearest.distance).unwrap_or(round)
    }

    /// Whether the fluid meets it and another one as one solid.
    pub fn is_one_with(&self, other: &Obstacle) -> bool {
        Arc::ptr_eq(&self.met.surface, &other.met.surface)
    }

    /// Its number among those that are one solid with it.
    pub fn number(&self) -> u32 {
        self.met.number
    }

    /// The number of that one of them which a point from its own origin (m) belongs to.
    pub fn owner(&self, point: &Vector3<f64>) -> u32 {
        self.met.surface.owner(&(point + self.origin))
    }

    /// Whether there are others that are one solid with it.
    pub fn is_joined(&self) -> bool {
        self.met.margin > 0.0
    }
}

/// Volume of a surface within the domain (m3; m2 in 2D), and the integral of the place over that.
fn within(surface: &ObstacleSurface, dimension: usize, room: &Extent) -> (f64, Vector3<f64>) {
    let ends = |a: usize| vec![0.0, if a < dimension { room.size[a] } else { 0.0 }];
    let whole = (0..dimension).map(|a| room.size[a]).product::<f64>();
    let mut sum = (0.0, Vector3::zeros());
    surface.tile(|x| *x, &[0, 1, 2].map(ends), &mut |tile| {
        sum = (whole * tile.part, whole * tile.moment);
    });
    sum
}

/// The surface of closed surfaces in their periods (m) that the fluid meets; whether it is a union.
fn merged(
    dimension: usize,
    given: &[&[Face]],
    room: &Extent,
) -> Result<(ObstacleSurface, bool), Fault> {
    let axes = |a: usize| a < dimension && room.periodic[a];
    let beyond = |a: usize| {
        axes(a) && given.iter().any(|faces| walls::across(faces, a, room) == Across::Beyond)
    };
    let has_images = [0, 1, 2].map(beyond);
    let mut all = Vec::new();
    for (faces, number) in given.iter().zip(0..) {
        let mut faces: Vec<(Face, u32)> = faces.iter().map(|face| (*face, number)).collect();
        (0..3).filter(|a| has_images[*a]).for_each(|a| walls::add_images(&mut faces, a, room));
        all.extend(faces);
    }
    let is_union = given.len() > 1 || has_images.contains(&true);
    let members = |all: &[(Face, u32)]| {
        let of = |one: &[(Face, u32)]| one.iter().map(|(face, _)| *face).collect();
        let all = all.chunk_by(|one, other| one.1 == other.1);
        all.map(|one| Columns::new(dimension, of(one))).collect()
    };
    let members = if given.len() > 1 { members(&all) } else { Vec::new() };
    if is_union {
        all = union::union(dimension, &all)?;
    }
    Ok((ObstacleSurface::new(dimension, all, members, room, &has_images)?, is_union))
}

impl Shape for Obstacle {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn radius(&self) -> f64 {
        self.radius
    }

    /// Volume within the domain that belongs to it (m3; m2 in 2D).
    fn volume(&self) -> f64 {
        self.met.share
    }

    /// Moments of a ball that holds the obstacle, which does not respond to forces.
    fn inertia(&self) -> Matrix3<f64> {
        Matrix3::from_diagonal_element(0.5 * self.volume() * self.radius * self.radius)
    }

    fn thickness(&self) -> f64 {
        self.thickness
    }

    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        self.met.surface.nearest(&(point + self.origin))
    }

    fn feet(&self, point: &Vector3<f64>, within: f64, feet: &mut Vec<Nearest>) {
        self.met.surface.feet(&(point + self.origin), within, feet);
    }

    fn owns(&self, point: &Vector3<f64>) -> bool {
        self.owner(point) == self.met.number
    }

    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let mut all = Vec::new();
        let own = self.met.surface.walls().iter().filter(|(_, number)| *number == self.met.number);
        for (face, _) in own {
            let normal = surface::normal(self.dimension, face);
            let [from, to, _] = face;
            if self.dimension == 3 {
                patches::of_triangle(face, &normal, spacing, &mut all);
            } else {
                let way = to - from;
                let n = (way.norm() / spacing).ceil().max(1.0);
                all.extend((0..n as usize).map(|k| {
                    let place = from + (k as f64 + 0.5) / n * way;
                    SurfacePoint { place, normal, area: way.norm() / n }
                }));
            }
        }
        let Extent { size, periodic } = &self.room;
        // The two sides of a period are one.
        let within = |a: usize, x: f64| {
            let on = walls::ON_SIDE * size[a];
            -on <= x && if periodic[a] { x < size[a] - on } else { x <= size[a] + on }
        };
        all.retain(|patch| (0..self.dimension).all(|a| within(a, patch.place[a])));
        all.iter_mut().for_each(|patch| patch.place -= self.origin);
        all
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        let [low, high] = self.bounds.map(|end| end - self.origin);
        let reach = n.zip_zip_map(&low, &high, |n, low, high| (n * low).max(n * high)).sum();
        reach + self.met.margin
    }

    fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        let at = |x: &Vector3<f64>| lattice.place(&(x - self.origin));
        walls::within(lattice, &self.room, &self.origin, |planes| {
            self.met.surface.tile(at, planes, &mut |tile| {
                if !self.is_joined() || self.owns(&lattice.own_box(tile.at).0) {
                    found(&walls::beyond(tile, lattice.planes, planes));
                }
            });
        });
    }

    fn meets(&self, point: &Vector3<f64>, along: &Vector3<f64>, within: f64) -> Option<f64> {
        let from = point + self.origin;
        let is_inside = self.met.surface.has(&from);
        if is_inside { Some(0.0) } else { self.met.surface.meets(&from, along, within) }
    }

    fn meets_itself(&self, foot: &Vector3<f64>, normal: &Vector3<f64>) -> Option<f64> {
        // From a little above, so that it does not meet the wall that it stands on.
        let above = 1e-9 * self.radius;
        let from = foot + self.origin + above * normal;
        self.met.surface.meets(&from, normal, 2.0 * self.radius).map(|way| way + above)
    }

    fn obstacle(&self) -> Option<&Obstacle> {
        Some(self)
    }

    fn parts(&self) -> &[Part] {
        &[]
    }

    fn triangles(&self, _spacing: f64) -> Vec<[Vector3<f64>; 3]> {
        self.walls().collect()
    }
}

#[cfg(test)]
mod tests;
