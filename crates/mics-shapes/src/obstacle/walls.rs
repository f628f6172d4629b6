//! The surface of an obstacle within its domain, with the images across periodic sides, and what of
//! it are walls.

use super::Room;
use crate::Fault;
use crate::mesh::Mesh;
use nalgebra::{Vector2, Vector3};

/// Distance from a side (of the domain's size) within which a part of the surface lies on it.
pub const ON_SIDE: f64 = 1e-9;

/// How far images across periodic sides are kept (of the period).
const BESIDE: f64 = 0.25;

type Triangle = [Vector3<f64>; 3];

/// A surface, seen from the obstacle's own origin (m).
#[derive(Clone)]
pub struct Walls {
    /// All of the closed surface, and its periodic images.
    pub solid: Vec<Triangle>,
    /// The walls among it.
    pub walls: Vec<Triangle>,
    /// The number of the given triangle that each of them is, or is an image of.
    origins: Vec<u32>,
    /// The middle of the domain.
    pub middle: Vector3<f64>,
    /// The ends of the solid within the domain.
    pub low: Vector3<f64>,
    pub high: Vector3<f64>,
    /// The ends of all of them, with the images beyond periodic sides.
    far: [Vector3<f64>; 2],
}

impl Walls {
    /// Of triangles in the axes of the domain (m), seen from its middle.
    ///
    /// # Errors
    /// When none is a wall.
    pub fn of(dimension: usize, given: Vec<Triangle>, room: &Room) -> Result<Walls, Fault> {
        let half = 0.5 * Vector3::from_fn(|a, _| if a < dimension { room.size[a] } else { 0.0 });
        let all = ends(given.iter()).map(|end| end - half);
        // With the number of the one that each is an image of.
        let mut solid: Vec<_> = given.iter().map(|t| t.map(|x| x - half)).zip(0u32..).collect();
        for a in (0..dimension).filter(|a| room.periodic[*a]) {
            let reach = (0.5 + BESIDE) * room.size[a];
            // There the solid goes on.
            solid.retain(|(t, _)| !is_flush(t, &half, a, room));
            let own = solid.clone();
            for way in [-room.size[a], room.size[a]] {
                let moved = own.iter().map(|(t, origin)| {
                    let t = t.map(|mut x| {
                        x[a] += way;
                        x
                    });
                    (t, *origin)
                });
                let near = |(t, _): &(Triangle, u32)| {
                    t.iter().any(|x| x[a] < reach) && t.iter().any(|x| x[a] > -reach)
                };
                solid.extend(moved.filter(near));
            }
        }
        let (solid, origins): (Vec<_>, Vec<_>) = solid.into_iter().unzip();
        let is_wall = |(t, _): &(&Triangle, &u32)| is_wall(t, &half, dimension, room);
        let (walls, origins): (Vec<_>, Vec<_>) = solid.iter().zip(&origins).filter(is_wall).unzip();
        // Of images beyond a periodic side nothing is within.
        let beyond = |t: &&Triangle| {
            (0..dimension)
                .any(|a| [-1.0, 1.0].iter().any(|s| t.iter().all(|x| s * x[a] >= half[a])))
        };
        let within = ends(walls.iter().filter(|t| !beyond(t)));
        if walls.is_empty() || (0..dimension).any(|a| within[0][a] > within[1][a]) {
            return Err(Fault("has no surface within the domain".to_owned()));
        }
        // What crosses a periodic side comes in at the other one.
        let crosses = |a: usize| room.periodic[a] && (all[0][a] < -half[a] || all[1][a] > half[a]);
        let end = |side: usize, sign: f64| {
            let clamped = |a: usize| all[side][a].clamp(-half[a], half[a]);
            Vector3::from_fn(|a, _| if crosses(a) { sign * half[a] } else { clamped(a) })
        };
        let (low, high) = (end(0, -1.0), end(1, 1.0));
        let wide = Vector3::from_fn(|a, _| {
            half[a] * if room.periodic[a] { 1.0 + 2.0 * BESIDE } else { 1.0 }
        });
        let [far_low, far_high] = ends(walls.iter());
        let far = [far_low.sup(&-wide), far_high.inf(&wide)];
        Ok(Walls { solid, walls, origins, middle: Vector3::zeros(), low, high, far })
    }

    /// All of it moved by a vector (m).
    pub fn moved(&self, by: &Vector3<f64>) -> Walls {
        let moved = |all: &[Triangle]| all.iter().map(|t| t.map(|x| x + by)).collect();
        Walls {
            solid: moved(&self.solid),
            walls: moved(&self.walls),
            origins: self.origins.clone(),
            middle: self.middle + by,
            low: self.low + by,
            high: self.high + by,
            far: self.far.map(|end| end + by),
        }
    }

    /// Radius of the ball about the own origin that holds all of them (m).
    pub fn reach(&self) -> f64 {
        self.far[0].abs().sup(&self.far[1].abs()).norm()
    }

    /// The walls as contacts see them: in 2D the segments that they stand on.
    pub fn faces(&self, dimension: usize, room: &Room) -> Mesh {
        let face = |(t, origin): (&Triangle, &u32)| {
            if dimension == 3 {
                return Some((*t, *origin));
            }
            let [a, b] = segment(t)?.map(|x| x.push(0.0));
            Some(([a, b, b], *origin))
        };
        let faces = self.walls.iter().zip(&self.origins).filter_map(face);
        Mesh::new(dimension, faces, room.size.amax())
    }
}

/// The ends of triangles along each axis (m).
fn ends<'a>(triangles: impl Iterator<Item = &'a Triangle>) -> [Vector3<f64>; 2] {
    let none = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
    triangles.flatten().fold(none, |[low, high], x| [low.inf(x), high.sup(x)])
}

/// Whether a triangle lies on a side of the domain across an axis.
fn is_flush(t: &Triangle, half: &Vector3<f64>, axis: usize, room: &Room) -> bool {
    let on = ON_SIDE * room.size[axis];
    [-1.0, 1.0].into_iter().any(|side| t.iter().all(|x| (side * x[axis] - half[axis]).abs() <= on))
}

/// Whether a triangle is a wall: not on a side of the domain, nor beyond one.
fn is_wall(t: &Triangle, half: &Vector3<f64>, dimension: usize, room: &Room) -> bool {
    !(0..dimension).any(|a| {
        let on = ON_SIDE * room.size[a];
        let beyond = |side: f64| t.iter().all(|x| side * x[a] - half[a] >= -on);
        is_flush(t, half, a, room) || (!room.periodic[a] && (beyond(-1.0) || beyond(1.0)))
    })
}

/// The segment that a wall along z stands on, once for its two triangles (m).
pub fn segment([a, b, _]: &Triangle) -> Option<[Vector2<f64>; 2]> {
    (a.z == b.z).then(|| [a.xy(), b.xy()])
}
