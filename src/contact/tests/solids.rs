//! Bodies of convex parts for tests: only what contacts need of a shape.

use super::*;
use crate::geometry::{Nearest, Shape, SurfacePoint};
use mics_shapes::{Core, Face, Lattice, Part, Polytope, Tile};
use nalgebra::Matrix3;

/// A body of parts, with the moments of inertia of a kilogram.
#[derive(Clone, Debug)]
pub struct Parts {
    pub dimension: usize,
    pub parts: Vec<Part>,
    pub volume: f64,
    pub inertia: Vector3<f64>,
}

impl Shape for Parts {
    fn dimension(&self) -> usize {
        self.dimension
    }
    fn radius(&self) -> f64 {
        self.parts.iter().map(|part| part.place.norm() + part.radius).fold(0.0, f64::max)
    }
    fn volume(&self) -> f64 {
        self.volume
    }
    fn inertia(&self) -> Matrix3<f64> {
        self.inertia_of(self.volume)
    }
    fn inertia_of(&self, mass: f64) -> Matrix3<f64> {
        mass * Matrix3::from_diagonal(&self.inertia)
    }
    fn thickness(&self) -> f64 {
        2.0 * self.radius()
    }
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        Nearest { distance: point.norm() - self.radius(), normal: point.normalize() }
    }
    fn surface(&self, _: f64) -> Vec<SurfacePoint> {
        Vec::new()
    }
    fn parts(&self) -> &[Part] {
        &self.parts
    }
    fn extent(&self, n: &Vector3<f64>) -> f64 {
        let along = |part: &Part| (part.place + part.core.support(n)).dot(n) + part.rounding;
        self.parts.iter().map(along).fold(0.0, f64::max)
    }
    fn tile(&self, _: &Lattice, _: &mut dyn FnMut(&Tile)) {}
    fn triangles(&self, _: f64) -> Vec<[Vector3<f64>; 3]> {
        Vec::new()
    }
}

/// Half the moments of a body that fills a part of a box with these half edges.
fn moments(half: [f64; 3], share: f64) -> Vector3<f64> {
    let [a, b, c] = half.map(|h| h * h);
    share * Vector3::new(b + c, a + c, a + b)
}

fn single(core: Core, rounding: f64, radius: f64) -> Vec<Part> {
    vec![Part { place: Vector3::zeros(), core, rounding, radius }]
}

/// A convex polygon with this many corners on an ellipse of these half axes, turned by an angle.
fn polygon(corners: usize, half: [f64; 2], turn: f64, rounding: f64) -> Core {
    let at = |k: usize| {
        let angle = turn + 2.0 * PI * k as f64 / corners as f64;
        vector![half[0] * angle.cos(), half[1] * angle.sin(), 0.0]
    };
    // Edges moved in by the skin: corners where they then meet.
    let normal = |k: usize| {
        let edge = at(k + 1) - at(k);
        vector![edge.y, -edge.x, 0.0].normalize()
    };
    let inner = |k: usize| {
        let n = normal(k + corners - 1);
        let m = normal(k);
        at(k) - rounding * (n + m) / (1.0 + n.dot(&m))
    };
    let face =
        |k: usize| Face { normal: normal(k), corners: vec![k as u32, ((k + 1) % corners) as u32] };
    let faces = (0..corners).map(face).collect();
    Core::Polytope(Polytope::new((0..corners).map(inner).collect(), faces))
}

/// A rectangle with these half edges.
pub fn rectangle(half: [f64; 2], rounding: f64) -> Parts {
    let root = f64::sqrt(2.0);
    // On a circle its corners are at odd multiples of 45 degrees.
    let core = match polygon(4, [root, root], PI / 4.0, 0.0) {
        Core::Polytope(mut polytope) => {
            for corner in &mut polytope.corners {
                *corner = vector![
                    (half[0] - rounding).copysign(corner.x),
                    (half[1] - rounding).copysign(corner.y),
                    0.0
                ];
            }
            Core::Polytope(polytope)
        }
        other => other,
    };
    Parts {
        dimension: 2,
        parts: single(core, rounding, half[0].hypot(half[1])),
        volume: 4.0 * half[0] * half[1],
        inertia: moments([half[0], half[1], 0.0], 1.0 / 3.0),
    }
}

pub fn ellipse(half: [f64; 2], inset: f64) -> Parts {
    let [a, b] = half;
    let core = Core::Ellipsoid { half: vector![a, b, 0.0], inset };
    Parts {
        dimension: 2,
        parts: single(core, inset, a.max(b)),
        volume: PI * a * b,
        inertia: moments([a, b, 0.0], 0.25),
    }
}

pub fn pentagon(radius: f64) -> Parts {
    let rounding = 0.05 * radius;
    let core = polygon(5, [radius, 0.8 * radius], 0.3, rounding);
    Parts {
        dimension: 2,
        parts: single(core, rounding, radius),
        volume: 1.9 * radius * radius,
        inertia: moments([radius, 0.8 * radius, 0.0], 0.22),
    }
}

/// Balls (discs in 2D) in a row along x, their centres this far apart.
pub fn clump(dimension: usize, radius: f64, count: usize, apart: f64) -> Parts {
    let at = |k: usize| (k as f64 - 0.5 * (count as f64 - 1.0)) * apart;
    let parts: Vec<Part> =
        (0..count).map(|k| Part::ball(vector![at(k), 0.0, 0.0], radius)).collect();
    let far = (0..count).map(|k| at(k) * at(k)).sum::<f64>() / count as f64;
    let own = if dimension == 2 { 0.5 } else { 0.4 } * radius * radius;
    let one = if dimension == 2 { PI * radius * radius } else { 4.0 / 3.0 * PI * radius.powi(3) };
    let inertia = vector![own, own + far, own + far];
    Parts { dimension, parts, volume: count as f64 * one, inertia }
}

pub fn cuboid(half: [f64; 3], rounding: f64) -> Parts {
    let inner = Vector3::from(half).map(|h| h - rounding);
    let sign = |bit: usize| if bit == 1 { 1.0 } else { -1.0 };
    let corners = (0..8)
        .map(|k| inner.component_mul(&vector![sign(k & 1), sign(k >> 1 & 1), sign(k >> 2 & 1)]));
    let faces = [
        (-Vector3::x(), [0, 4, 6, 2]),
        (Vector3::x(), [1, 3, 7, 5]),
        (-Vector3::y(), [0, 1, 5, 4]),
        (Vector3::y(), [2, 6, 7, 3]),
        (-Vector3::z(), [0, 2, 3, 1]),
        (Vector3::z(), [4, 5, 7, 6]),
    ];
    let faces = faces.map(|(normal, corners)| Face { normal, corners: corners.to_vec() });
    let core = Core::Polytope(Polytope::new(corners.collect(), faces.to_vec()));
    Parts {
        dimension: 3,
        parts: single(core, rounding, Vector3::from(half).norm()),
        volume: 8.0 * half[0] * half[1] * half[2],
        inertia: moments(half, 1.0 / 3.0),
    }
}

pub fn ellipsoid(half: [f64; 3], inset: f64) -> Parts {
    let core = Core::Ellipsoid { half: Vector3::from(half), inset };
    Parts {
        dimension: 3,
        parts: single(core, inset, half.into_iter().fold(0.0, f64::max)),
        volume: 4.0 / 3.0 * PI * half[0] * half[1] * half[2],
        inertia: moments(half, 0.2),
    }
}

pub fn superquadric(half: [f64; 3], exponents: [f64; 2], inset: f64) -> Parts {
    let core = Core::Superquadric { half: Vector3::from(half), exponents, inset };
    Parts {
        dimension: 3,
        parts: single(core, inset, Vector3::from(half).norm()),
        volume: 6.5 * half[0] * half[1] * half[2],
        inertia: moments(half, 0.29),
    }
}

/// The shapes that tests throw at each other, about 1 cm in radius.
pub fn all(dimension: usize) -> Vec<(&'static str, Parts)> {
    let r = 0.01;
    if dimension == 2 {
        return vec![
            ("rectangle", rectangle([r, 0.6 * r], 0.04 * r)),
            ("ellipse", ellipse([r, 0.6 * r], 0.05 * r)),
            ("clump", clump(2, 0.5 * r, 3, 0.6 * r)),
            ("polygon", pentagon(r)),
        ];
    }
    vec![
        ("box", cuboid([r, 0.8 * r, 0.6 * r], 0.04 * r)),
        ("ellipsoid", ellipsoid([r, 0.8 * r, 0.6 * r], 0.05 * r)),
        ("superquadric", superquadric([r, 0.8 * r, 0.6 * r], [4.0, 6.0], 0.03 * r)),
        ("clump", clump(3, 0.5 * r, 3, 0.6 * r)),
    ]
}

/// A free body of this shape, turned by a vector (rad).
pub fn free(shape: &Parts, centre: Vector3<f64>, turn: Vector3<f64>) -> Body {
    let mut body = Body::new(Arc::new(shape.clone()), 2500.0, 1.0, centre);
    body.motion = Motion::Free(if shape.dimension == 2 { PLANE } else { FREE });
    body.orientation = nalgebra::UnitQuaternion::from_scaled_axis(turn);
    body
}

/// Kinetic energy (J).
pub fn kinetic(bodies: &[Body]) -> f64 {
    let of = |b: &Body| {
        0.5 * (b.mass() * b.velocity.norm_squared() + b.spin.dot(&b.inertia().of(&b.spin)))
    };
    bodies.iter().map(of).sum()
}

/// Momentum and angular momentum (N s, N m s).
pub fn momenta(bodies: &[Body]) -> [Vector3<f64>; 2] {
    let linear = |b: &Body| b.mass() * b.velocity;
    let angular = |b: &Body| b.centre.cross(&linear(b)) + b.inertia().of(&b.spin);
    [bodies.iter().map(linear).sum(), bodies.iter().map(angular).sum()]
}
