//! Normals of a body's surface, and how far the body itself is along them.

use crate::geometry::Nearest;
use nalgebra::Vector3;

/// The line along the surface's normal through a point, which has its image points at `from + out
/// along` (m, from the body's centre).
#[derive(Clone, Copy, Debug)]
pub struct Line {
    pub from: Vector3<f64>,
    pub along: Vector3<f64>,
}

/// Distances to the body itself along a normal of its surface.
#[derive(Clone, Copy, Debug)]
pub struct Ahead {
    /// Distance to where that meets the body again (m); infinite where it does not.
    pub itself: f64,
    /// Distance of the second image point from an obstacle's own surface (m); infinite of other
    /// bodies.
    pub corner: f64,
}

impl Ahead {
    /// Nothing of the body itself.
    pub const NOTHING: Ahead = Ahead { itself: f64::INFINITY, corner: f64::INFINITY };
}

/// A normal: its line, and where it leaves the surface.
pub struct Normal {
    pub line: Line,
    /// Whether it comes from the centre as the arm of its point.
    pub central: bool,
    /// Outward, of length 1.
    pub n: Vector3<f64>,
    /// Where it leaves the surface (m, from the body's centre).
    pub foot: Vector3<f64>,
    /// Distances to the body itself along it.
    pub ahead: Ahead,
    /// At the distance d from the surface, `out = (wall + d)/length` (m).
    wall: f64,
    length: f64,
}

impl Normal {
    /// Through the point at `arm` (m), at the distance `s` (m) from the surface. That of a round
    /// body, of this radius (m), comes from its centre, so that a rigid motion is the same multiple
    /// of the arm's everywhere on it.
    #[inline]
    pub fn new(round: Option<f64>, arm: &Vector3<f64>, s: f64, n: Vector3<f64>) -> Normal {
        if let Some(radius) = round {
            let line = Line { from: Vector3::zeros(), along: *arm };
            return Normal {
                line,
                central: true,
                n,
                foot: radius * n,
                ahead: Ahead::NOTHING,
                wall: radius,
                length: arm.norm(),
            };
        }
        let foot = arm - s * n;
        Normal {
            line: Line { from: foot, along: n },
            central: false,
            n,
            foot,
            ahead: Ahead::NOTHING,
            wall: 0.0,
            length: 1.0,
        }
    }

    /// Where the point at a distance (m) from the surface is, as a factor of the line.
    #[inline]
    pub fn out(&self, distance: f64) -> f64 {
        (self.wall + distance) / self.length
    }
}

/// A point of a body's surface that a cell has its profile from.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    /// The cell's signed distance from it, and the outward normal there.
    pub near: Nearest,
    /// Distances to the body itself along that normal.
    pub ahead: Ahead,
}

impl Foot {
    /// The normal through it, and the cell at `arm` (m), of a body that is `round` with this radius
    /// (m) or not.
    pub fn normal(&self, round: Option<f64>, arm: &Vector3<f64>) -> Normal {
        let Nearest { distance, normal } = self.near;
        let mut normal = Normal::new(round, arm, distance, normal);
        normal.ahead = self.ahead;
        normal
    }
}
