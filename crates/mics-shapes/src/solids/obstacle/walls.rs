//! The walls of a closed surface: its part within the domain, with the images across periodic
//! sides.
//!
//! ```text
//!      ____________________     the solid is closed: a bed's outline goes on below the domain.
//!     |          __        |    Of its surface only what lies within the domain is a wall: parts
//!     |_______ ,'  `.______|    on a side of the domain, or beyond one, are none, so that no
//!     :///////'//////`/////:    distance is measured to them. Across a periodic side the walls go
//!     :////////////////////:    on with their images.
//! ```

use super::{Extent, Face};
use crate::{Fault, Lattice, Orientation, Tile};
use nalgebra::Vector3;
use std::cell::RefCell;

/// Distance from a side (of the domain's size) within which a part of the surface lies on it.
pub const ON_SIDE: f64 = 1e-9;

/// Distance beyond periodic sides up to which images are kept (of the period).
const BESIDE: f64 = 0.25;

/// The ends of faces along each axis (m).
pub fn ends<'a>(faces: impl Iterator<Item = &'a Face>) -> [Vector3<f64>; 2] {
    let none = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
    faces.flatten().fold(none, |[low, high], x| [low.inf(x), high.sup(x)])
}

fn moved(face: &Face, axis: usize, way: f64) -> Face {
    face.map(|mut x| {
        x[axis] += way;
        x
    })
}

/// Moves a closed surface (m) by whole periods so that its middle lies in the domain.
pub fn bring_into_period(faces: &mut [Face], room: &Extent) {
    let [low, high] = ends(faces.iter());
    for a in (0..3).filter(|a| room.periodic[*a]) {
        let periods = (0.5 * (low[a] + high[a]) / room.size[a]).floor();
        if periods != 0.0 {
            faces.iter_mut().for_each(|face| *face = moved(face, a, -periods * room.size[a]));
        }
    }
}

/// Relation of a surface, moved into its period, to its own images along a periodic axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Across {
    /// It ends within the domain.
    Apart,
    /// It goes from one side of the domain to the other, with the same section at both.
    Through,
    /// It passes a side, or its sections at both differ.
    Beyond,
}

/// Relation of a surface (m) to its images along a periodic axis.
pub fn across(faces: &[Face], axis: usize, room: &Extent) -> Across {
    let [low, high] = ends(faces.iter());
    let period = room.size[axis];
    let on = ON_SIDE * room.size[axis];
    if low[axis] > on && high[axis] < period - on {
        return Across::Apart;
    }
    if low[axis] < -on || high[axis] > period + on {
        return Across::Beyond;
    }
    // Area and first moment of what lies on each side, whose normals are opposite.
    let on_side = |side: f64| {
        let flush = faces.iter().filter(|face| face.iter().all(|x| (x[axis] - side).abs() <= on));
        flush.fold(Vector3::zeros(), |sum: Vector3<f64>, [a, b, c]| {
            let area = if b == c { (b - a).norm() } else { 0.5 * (b - a).cross(&(c - a)).norm() };
            let middle = if b == c { 0.5 * (a + b) } else { (a + b + c) / 3.0 };
            let mut moment = area / period * middle;
            moment[axis] = area;
            sum + moment
        })
    };
    let [one, other] = [on_side(0.0), on_side(period)];
    let alike = (one - other).amax() <= 1e-9 * one.amax().max(other.amax());
    if alike { Across::Through } else { Across::Beyond }
}

/// Adds the images of a closed surface along an axis that reach as far as images are kept.
pub fn add_images(faces: &mut Vec<(Face, u32)>, axis: usize, room: &Extent) {
    let own = faces.clone();
    let [low, high] = ends(own.iter().map(|(face, _)| face));
    let size = room.size[axis];
    let beside = (1.0 + BESIDE) * room.size[axis];
    let first = ((-BESIDE * size - high[axis]) / size).ceil() as i32;
    let last = ((beside - low[axis]) / size).floor() as i32;
    for periods in (first..=last).filter(|periods| *periods != 0) {
        let way = f64::from(periods) * size;
        faces.extend(own.iter().map(|(face, number)| (moved(face, axis, way), *number)));
    }
}

/// The walls among the faces of a closed surface (m), with a number each, and their images along
/// those periodic axes along which the faces have none yet.
pub fn of(
    mut faces: Vec<(Face, u32)>,
    dimension: usize,
    room: &Extent,
    has_images: &[bool; 3],
) -> Vec<(Face, u32)> {
    for a in (0..dimension).filter(|a| room.periodic[*a]) {
        if !has_images[a] {
            // There the solid goes on.
            faces.retain(|(face, _)| !is_flush(face, a, room));
            add_images(&mut faces, a, room);
        }
        let [low, high] = [-BESIDE * room.size[a], (1.0 + BESIDE) * room.size[a]];
        faces.retain(|(face, _)| {
            face.iter().any(|x| x[a] < high) && face.iter().any(|x| x[a] > low)
        });
    }
    faces.retain(|(face, _)| is_wall(face, dimension, room));
    faces
}

/// Whether a face lies on a side of the domain across an axis.
fn is_flush(face: &Face, axis: usize, room: &Extent) -> bool {
    let on = ON_SIDE * room.size[axis];
    [0.0, room.size[axis]].iter().any(|side| face.iter().all(|x| (x[axis] - side).abs() <= on))
}

/// Whether a face is a wall: not on a side of the domain that is not periodic, nor beyond one.
fn is_wall(face: &Face, dimension: usize, room: &Extent) -> bool {
    !(0..dimension).filter(|a| !room.periodic[*a]).any(|a| {
        let size = room.size[a];
        let on = ON_SIDE * room.size[a];
        is_flush(face, a, room)
            || face.iter().all(|x| x[a] <= on)
            || face.iter().all(|x| x[a] >= size - on)
    })
}

/// The ends of a surface within the domain along each axis (m): what passes a periodic side comes
/// in at the other one.
///
/// # Errors
/// When none of its walls is within.
pub fn bounds(
    walls: &[(Face, u32)],
    solid: &[Vector3<f64>; 2],
    dimension: usize,
    room: &Extent,
) -> Result<[Vector3<f64>; 2], Fault> {
    // No part of an image beyond a periodic side is within.
    let beyond = |face: &Face| {
        (0..dimension)
            .any(|a| face.iter().all(|x| x[a] >= room.size[a]) || face.iter().all(|x| x[a] <= 0.0))
    };
    let [low, high] = ends(walls.iter().map(|(face, _)| face).filter(|face| !beyond(face)));
    if (0..dimension).any(|a| low[a] > high[a]) {
        return Err(Fault("has no surface within the domain".to_owned()));
    }
    let crosses = |a: usize| room.periodic[a] && (solid[0][a] < 0.0 || solid[1][a] > room.size[a]);
    let end = |side: usize| {
        Vector3::from_fn(|a, _| match () {
            _ if a >= dimension => 0.0,
            _ if crosses(a) => [0.0, room.size[a]][side],
            _ => solid[side][a].clamp(0.0, room.size[a]),
        })
    };
    Ok([end(0), end(1)])
}

/// Radius of the ball about a place (m) that holds all walls, images beyond periodic sides as far
/// as they are kept.
pub fn reach(walls: &[(Face, u32)], place: &Vector3<f64>, dimension: usize, room: &Extent) -> f64 {
    let [low, high] = ends(walls.iter().map(|(face, _)| face));
    let wide = |a: usize| if room.periodic[a] { BESIDE * room.size[a] } else { 0.0 };
    let farthest = Vector3::from_fn(|a, _| {
        if a >= dimension {
            return 0.0;
        }
        let from = low[a].max(-wide(a));
        let to = high[a].min(room.size[a] + wide(a));
        (place[a] - from).abs().max((to - place[a]).abs())
    });
    farthest.norm()
}

thread_local! {
    static PLANES: RefCell<[Vec<f64>; 3]> = RefCell::default();
}

/// Calls with the planes of a lattice about an origin (m), where boxes that a closed side of the
/// domain divides end at the side: beyond it an obstacle goes on as it is there.
pub fn within(
    lattice: &Lattice,
    room: &Extent,
    origin: &Vector3<f64>,
    take: impl FnOnce(&[Vec<f64>; 3]),
) {
    if lattice.factor != 1.0 || lattice.orientation != Orientation::identity() {
        return take(lattice.planes);
    }
    PLANES.with_borrow_mut(|all| {
        for (axis, planes) in all.iter_mut().enumerate() {
            planes.clone_from(&lattice.planes[axis]);
            if room.periodic[axis] || planes[0] == planes[planes.len() - 1] {
                continue;
            }
            let [low, high] = [0.0, room.size[axis]].map(|side| side - origin[axis]);
            for k in 1..planes.len() {
                if planes[k - 1] < low && planes[k] > low {
                    planes[k - 1] = low;
                }
                if planes[k - 1] < high && planes[k] > high {
                    planes[k] = high;
                }
            }
        }
        take(all);
    });
}

/// The filled part of the whole of a box of which a part has been `found`, by the `planes` of both
/// (m).
pub fn beyond(found: &Tile, planes: &[Vec<f64>; 3], parts: &[Vec<f64>; 3]) -> Tile {
    let mut moment = found.moment;
    for axis in 0..3 {
        let ends = |planes: &[Vec<f64>; 3]| [0, 1].map(|n| planes[axis][found.at[axis] + n]);
        let [low, high] = ends(planes);
        if ends(parts) != [low, high] {
            moment[axis] = found.part * 0.5 * (low + high);
        }
    }
    Tile::new(planes, found.at, found.part, moment)
}
