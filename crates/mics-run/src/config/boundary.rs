//! Boundary conditions at the sides of the box.

use super::Domain;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One condition per side: west/east close x, south/north close y, bottom/top close z (3D only).
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// Low x.
    pub west: Side,
    /// High x.
    pub east: Side,
    /// Low y.
    pub south: Side,
    /// High y.
    pub north: Side,
    /// Low z, 3D only.
    pub bottom: Option<Side>,
    /// High z, 3D only.
    pub top: Option<Side>,
}

impl Boundary {
    /// The condition at the side of this number, of [`super::SIDES`]; bottom and top have none in
    /// 2D.
    pub fn side(&self, side: usize) -> Option<&Side> {
        let all = [&self.west, &self.east, &self.south, &self.north];
        let along_z = [&self.bottom, &self.top];
        all.get(side).copied().or_else(|| along_z.get(side.checked_sub(4)?)?.as_ref())
    }

    /// The conditions at the low and at the high end of an axis.
    pub fn ends(&self, axis: usize) -> impl Iterator<Item = &Side> {
        [0, 1].into_iter().filter_map(move |end| self.side(2 * axis + end))
    }
}

/// Boundary condition at one side of the box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Side {
    /// Joined to the opposite side.
    Periodic,
    /// Zero-gradient velocity at zero pressure.
    Outflow,
    /// No slip, at rest.
    Wall,
    /// No flow through, no shear.
    Slip,
    /// No slip, moving in its own plane with this velocity (m/s).
    MovingWall(Vec<f64>),
    /// This velocity (m/s), uniform over the side. With `[contact]` free particles rest on it as on
    /// a grate, without lubrication.
    Inflow(Vec<f64>),
    /// A parabola, zero at the side's edges, with this velocity (m/s) at its middle; in 2D the
    /// edges are those of the part that obstacles leave open.
    InflowParabola(Vec<f64>),
    /// Velocity along the side's first tangential axis, linear between the points given.
    InflowProfile(Profile),
}

impl Side {
    /// The velocities (m/s) that an inflow is given by: one, or one a point of its profile; none
    /// for other sides.
    pub fn inflow(&self) -> &[Vec<f64>] {
        match self {
            Side::Inflow(v) | Side::InflowParabola(v) => std::slice::from_ref(v),
            Side::InflowProfile(profile) => &profile.velocity,
            _ => &[],
        }
    }

    /// The velocity of a wall that moves (m/s); empty of other sides.
    pub fn wall_velocity(&self) -> &[f64] {
        if let Side::MovingWall(velocity) = self { velocity } else { &[] }
    }

    /// A component of an inflow's velocity (m/s) at a `place` on its side, whose coordinates (m)
    /// run from 0 to `sizes` (m); 0 of other sides.
    pub fn inflow_at(&self, place: &[f64], sizes: &[f64], component: usize) -> f64 {
        match self {
            Side::Inflow(velocity) => velocity[component],
            Side::InflowParabola(peak) => {
                let shape = |(x, size): (&f64, &f64)| 4.0 * x / size * (1.0 - x / size);
                peak[component] * place.iter().zip(sizes).map(shape).product::<f64>()
            }
            Side::InflowProfile(profile) => profile.velocity_at(place[0])[component],
            _ => 0.0,
        }
    }

    /// Flow rate of an inflow into the box through the side of this number, from its velocity at
    /// the middle of the cells (m2/s in 2D, m3/s in 3D); 0 of other sides.
    pub fn flux(&self, side: usize, domain: &Domain) -> f64 {
        let axis = side / 2;
        let along: Vec<usize> = (0..domain.size.len()).filter(|&a| a != axis).collect();
        let sizes: Vec<f64> = along.iter().map(|&a| domain.size[a]).collect();
        let spacings: Vec<f64> =
            along.iter().map(|&a| domain.size[a] / domain.cells[a] as f64).collect();
        let at = |mut n: usize| -> Vec<f64> {
            let mut place = Vec::with_capacity(along.len());
            for (&a, h) in along.iter().zip(&spacings) {
                place.push(((n % domain.cells[a]) as f64 + 0.5) * h);
                n /= domain.cells[a];
            }
            place
        };
        if self.inflow().is_empty() {
            return 0.0;
        }
        let cells = along.iter().map(|&a| domain.cells[a]).product::<usize>();
        let sum: f64 = (0..cells).map(|n| self.inflow_at(&at(n), &sizes, axis)).sum();
        let inwards = if side.is_multiple_of(2) { 1.0 } else { -1.0 };
        inwards * sum * spacings.iter().product::<f64>()
    }
}

/// A velocity profile: linear between points, constant beyond the first and last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Coordinates along the side's first tangential axis (m), increasing.
    pub at: Vec<f64>,
    /// One velocity (m/s) for each coordinate.
    pub velocity: Vec<Vec<f64>>,
}

impl Profile {
    /// The velocity (m/s) at coordinate `s` (m) along the side's first tangential axis.
    pub fn velocity_at(&self, s: f64) -> Vec<f64> {
        let next = self.at.partition_point(|at| *at <= s).clamp(1, self.at.len() - 1);
        let s0 = self.at[next - 1];
        let s1 = self.at[next];
        let weight = ((s - s0) / (s1 - s0)).clamp(0.0, 1.0);
        let low = &self.velocity[next - 1];
        let high = &self.velocity[next];
        low.iter().zip(high).map(|(a, b)| a + weight * (b - a)).collect()
    }
}
