//! A disc: the round section of a cylinder along z, of unit depth.

use crate::boxes::circle::{self, Line};
use crate::boxes::round;
use crate::{Lattice, Nearest, Part, Shape, SurfacePoint, Tile};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{PI, TAU};

/// A disc (2D): its volume, mass and inertia are those of a metre of cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Radius (m).
    pub radius: f64,
}

impl Disc {
    /// Area (m2) that it fills of the rectangle with its centre at `middle` (m) and the `half`
    /// edges (m).
    pub fn area_in(&self, middle: &Vector3<f64>, half: &Vector3<f64>) -> f64 {
        let line = |at: f64| Line::new(at, self.radius);
        let [x, y] = [0, 1].map(|a| [line(middle[a] - half[a]), line(middle[a] + half[a])]);
        circle::rectangle(&x, &y, self.radius).area
    }

    /// Area (m2) of the polygon in its place, after Ushijima et al. 2003: that through the corners
    /// of the rectangle inside and the crossings of circle and edges.
    pub fn polygon_in(&self, middle: &Vector3<f64>, half: &Vector3<f64>) -> f64 {
        let r = self.radius;
        let corner = |k: usize| {
            let (sx, sy) = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)][k % 4];
            [middle.x + sx * half.x, middle.y + sy * half.y]
        };
        // Walking round the cell meets the vertices in order; an edge crosses the circle twice at
        // most.
        let mut vertices = [[0.0f64; 2]; 12];
        let mut n = 0;
        let mut add = |v: [f64; 2]| {
            vertices[n] = v;
            n += 1;
        };
        for k in 0..4 {
            let from = corner(k);
            let to = corner(k + 1);
            if from[0].hypot(from[1]) < r {
                add(from);
            }
            let d = [to[0] - from[0], to[1] - from[1]];
            let a = d[0] * d[0] + d[1] * d[1];
            let b = from[0] * d[0] + from[1] * d[1];
            let c = from[0] * from[0] + from[1] * from[1] - r * r;
            let under = b * b - a * c;
            if under > 0.0 {
                for t in [(-b - under.sqrt()) / a, (-b + under.sqrt()) / a] {
                    if (0.0..1.0).contains(&t) {
                        add([from[0] + t * d[0], from[1] + t * d[1]]);
                    }
                }
            }
        }
        let v = &vertices[..n];
        let twice: f64 =
            (0..n).map(|k| v[k][0] * v[(k + 1) % n][1] - v[(k + 1) % n][0] * v[k][1]).sum();
        0.5 * twice.max(0.0)
    }
}

impl Shape for Disc {
    fn dimension(&self) -> usize {
        2
    }

    fn is_round(&self) -> bool {
        true
    }

    fn radius(&self) -> f64 {
        self.radius
    }

    fn volume(&self) -> f64 {
        PI * self.radius.powi(2)
    }

    fn inertia(&self) -> Matrix3<f64> {
        self.inertia_of(self.volume())
    }

    fn inertia_of(&self, mass: f64) -> Matrix3<f64> {
        Matrix3::from_diagonal_element(0.5 * mass * self.radius.powi(2))
    }

    fn diameter(&self) -> f64 {
        2.0 * self.radius
    }

    fn thickness(&self) -> f64 {
        2.0 * self.radius
    }

    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        Nearest { distance: self.distance(point), normal: point.normalize() }
    }

    fn distance(&self, point: &Vector3<f64>) -> f64 {
        point.norm() - self.radius
    }

    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let length = TAU * self.radius;
        // Divisible by four: as symmetric as the grid.
        let count = 4 * (0.5 * length / spacing).ceil() as usize;
        let point = |i: usize| {
            let (y, x) = (TAU * ((i as f64 + 0.5) / count as f64)).sin_cos();
            let place = self.radius * Vector3::new(x, y, 0.0);
            SurfacePoint { place, normal: place / self.radius, area: length / count as f64 }
        };
        (0..count).map(point).collect()
    }

    fn surface_moments(&self) -> (f64, Matrix3<f64>) {
        (TAU * self.radius, Matrix3::from_diagonal_element(TAU * self.radius.powi(3)))
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        self.radius * n.xy().norm()
    }

    fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        round::tile_disc(self.radius, lattice, found);
    }

    /// None: contacts see it as it is.
    fn parts(&self) -> &[Part] {
        &[]
    }

    fn triangles(&self, spacing: f64) -> Vec<[Vector3<f64>; 3]> {
        let count = (TAU * self.radius / spacing).ceil().max(3.0) as usize;
        let at = |i: usize| {
            let (sin, cos) = (TAU * (i % count) as f64 / count as f64).sin_cos();
            self.radius * Vector3::new(cos, sin, 0.0)
        };
        (0..count).map(|i| [at(i), at(i + 1), at(i + 1)]).collect()
    }
}
