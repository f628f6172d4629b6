//! The points of corners, edges and faces that are nearest to a point, a ball or each other.
//!
//! ```text
//!        o point            corner, edge or face, by which of their regions the point lies in
//!        |
//!   -----x------ face       two edges: where the way between them is normal to both, or their ends
//! ```

use nalgebra::Vector3;

/// Sine of the angle between two edges at which their crossing counts half: the nearest points of
/// parallel ones may be anywhere along them.
const PARALLEL: f64 = 1e-2;
/// The point of a face, an edge or a corner that is nearest to a part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    /// From there to the part's surface (m), negative where they overlap.
    pub gap: f64,
    /// From there to the part, of length 1.
    pub up: Vector3<f64>,
    /// The point (m).
    pub place: Vector3<f64>,
}

/// The foot on the simplex with these corners (m) of a face with this normal, for a ball about a
/// place (m).
#[inline]
pub(crate) fn foot_of_ball(
    middle: &Vector3<f64>,
    radius: f64,
    simplex: &[Vector3<f64>],
    normal: &Vector3<f64>,
) -> Foot {
    let place = nearest(simplex, middle);
    let way = middle - place;
    let distance = way.norm();
    let height = way.dot(normal);
    // Straight below a face its outward normal says which way out is.
    if height <= -(1.0 - 1e-9) * distance {
        return Foot { gap: -distance - radius, up: *normal, place };
    }
    Foot { gap: distance - radius, up: way / distance, place }
}

/// The point of a corner, a segment or a triangle that is nearest to another one (m).
#[inline]
pub(crate) fn nearest(simplex: &[Vector3<f64>], point: &Vector3<f64>) -> Vector3<f64> {
    match simplex {
        [a, b] => nearest_of_segment(a, b, point),
        [a, b, c] => nearest_of_triangle([a, b, c], point),
        _ => simplex[0],
    }
}

pub(crate) fn nearest_of_segment(
    a: &Vector3<f64>,
    b: &Vector3<f64>,
    point: &Vector3<f64>,
) -> Vector3<f64> {
    let edge = b - a;
    let part = (point - a).dot(&edge) / edge.norm_squared();
    if part <= 0.0 {
        *a
    } else if part >= 1.0 {
        *b
    } else {
        a + part * edge
    }
}

/// By the regions of the plane in which the corners, the edges or the face are nearest (Ericson,
/// Real-Time Collision Detection, 5.1.5).
fn nearest_of_triangle([a, b, c]: [&Vector3<f64>; 3], point: &Vector3<f64>) -> Vector3<f64> {
    let e = b - a;
    let f = c - a;
    let of = |corner: &Vector3<f64>| {
        let way = point - corner;
        (e.dot(&way), f.dot(&way))
    };
    let (ae, af) = of(a);
    let (be, bf) = of(b);
    let (ce, cf) = of(c);
    let u = be * cf - ce * bf;
    let v = ce * af - ae * cf;
    let w = ae * bf - be * af;
    if u > 0.0 && v > 0.0 && w > 0.0 {
        let normal = e.cross(&f);
        return point - (point - a).dot(&normal) / normal.norm_squared() * normal;
    }
    let mut best = (f64::INFINITY, *a);
    for (beyond, [p, q]) in [(u, [b, c]), (v, [c, a]), (w, [a, b])] {
        if beyond <= 0.0 {
            let at = nearest_of_segment(p, q, point);
            let square = (point - at).norm_squared();
            if square < best.0 {
                best = (square, at);
            }
        }
    }
    best.1
}

/// The middle of some corners (m), and how far they are from it at most, or a little further (m).
pub(crate) fn around(corners: &[Vector3<f64>]) -> (Vector3<f64>, f64) {
    let middle = corners.iter().sum::<Vector3<f64>>() / corners.len() as f64;
    let square = |corner: &Vector3<f64>| (corner - middle).norm_squared();
    let reach = corners.iter().map(square).fold(0.0, f64::max).sqrt();
    (middle, reach * (1.0 + 1e-9))
}

/// The nearest points of two edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// On both (m).
    pub points: [Vector3<f64>; 2],
    /// Weight with which they count in a patch.
    pub counts: f64,
}

/// The nearest points of two edges by their ends (m), if they may be within a distance (m); `None`
/// of parallel ones, of which the corners count.
#[inline]
pub(crate) fn crossing(
    one: &[Vector3<f64>; 2],
    other: &[Vector3<f64>; 2],
    within: f64,
) -> Option<Crossing> {
    let e = one[1] - one[0];
    let f = other[1] - other[0];
    let ee = e.norm_squared();
    let ff = f.norm_squared();
    let ef = e.dot(&f);
    let reach = 2.0 * within + ee.sqrt() + ff.sqrt();
    if (one[0] + one[1] - other[0] - other[1]).norm_squared() > reach * reach {
        return None;
    }
    // Squared sine of the angle between them, times ee ff.
    let square = ee * ff - ef * ef;
    let counts = square / (square + PARALLEL * PARALLEL * ee * ff);
    if counts <= 0.01 {
        return None;
    }
    let way = one[0] - other[0];
    let ew = e.dot(&way);
    let fw = f.dot(&way);
    let s = ((ef * fw - ew * ff) / square).clamp(0.0, 1.0);
    let t = ((ef * s + fw) / ff).clamp(0.0, 1.0);
    let s = ((ef * t - ew) / ee).clamp(0.0, 1.0);
    Some(Crossing { points: [one[0] + s * e, other[0] + t * f], counts })
}
