//! Boundary conditions at the sides of the box.

use super::over_time::between;
use super::{Domain, OverTime};
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

    /// That condition, to change.
    pub(super) fn side_mut(&mut self, side: usize) -> Option<&mut Side> {
        let Boundary { west, east, south, north, bottom, top } = self;
        let all = [Some(west), Some(east), Some(south), Some(north), bottom.as_mut(), top.as_mut()];
        all.into_iter().nth(side)?
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
    Inflow(Inflow),
    /// A parabola, zero at the side's edges, with this velocity (m/s) at its middle; in 2D the
    /// edges are those of the part that obstacles leave open.
    InflowParabola(Inflow),
    /// Half a parabola over the height above the bed, as in a laminar open channel: zero at the
    /// bed, this velocity U (m/s) at the top, `U (2 s - s^2)` at the part s of the height, 2/3 of U
    /// in the mean. The height is along gravity, or along the side's first tangential axis where
    /// gravity has no part in the side; it goes from the lowest to the highest place that obstacles
    /// leave open. Faces have the mean over their own height.
    InflowHalfParabola(Inflow),
    /// A logarithmic profile over the height above the bed, as in a turbulent open channel, with
    /// the height and the faces as for `inflow_half_parabola`.
    InflowLog(LogProfile),
    /// Velocity along the side's first tangential axis, linear between the points given.
    InflowProfile(Profile),
}

impl Side {
    /// The velocities (m/s) that an inflow is given by: one, or one a point of its profile; none
    /// for other sides.
    pub fn inflow(&self) -> &[Vec<f64>] {
        match self {
            Side::Inflow(inflow)
            | Side::InflowParabola(inflow)
            | Side::InflowHalfParabola(inflow) => std::slice::from_ref(inflow.velocity()),
            Side::InflowLog(profile) => std::slice::from_ref(&profile.velocity),
            Side::InflowProfile(profile) => &profile.velocity,
            _ => &[],
        }
    }

    /// The factor over time of an inflow; `None` where it is steady, and of other sides.
    pub fn over_time(&self) -> Option<&OverTime> {
        match self {
            Side::Inflow(inflow)
            | Side::InflowParabola(inflow)
            | Side::InflowHalfParabola(inflow) => inflow.over_time(),
            Side::InflowLog(profile) => profile.over_time.as_ref(),
            Side::InflowProfile(profile) => profile.over_time.as_ref(),
            _ => None,
        }
    }

    /// That factor, and the name of the kind.
    pub(super) fn over_time_mut(&mut self) -> Option<(&'static str, &mut OverTime)> {
        Some(match self {
            Side::Inflow(inflow) => ("inflow", inflow.over_time_mut()?),
            Side::InflowParabola(inflow) => ("inflow_parabola", inflow.over_time_mut()?),
            Side::InflowHalfParabola(inflow) => ("inflow_half_parabola", inflow.over_time_mut()?),
            Side::InflowLog(profile) => ("inflow_log", profile.over_time.as_mut()?),
            Side::InflowProfile(profile) => ("inflow_profile", profile.over_time.as_mut()?),
            _ => return None,
        })
    }

    /// The velocity of a wall that moves (m/s); empty of other sides.
    pub fn wall_velocity(&self) -> &[f64] {
        if let Side::MovingWall(velocity) = self { velocity } else { &[] }
    }

    /// The mean velocity between two heights (m) above the bed, over the velocity that is given, of
    /// an inflow by the height where `depth` (m) is open; `None` of other sides.
    pub fn share_between(&self, [low, high]: [f64; 2], depth: f64) -> Option<f64> {
        // The integral from the bed to a height, of a mean of 1 over the depth or a value of 1 at
        // the top.
        let below: &dyn Fn(f64) -> f64 = match self {
            Side::InflowHalfParabola(_) => &|z| z * (z / depth) * (1.0 - z / (3.0 * depth)),
            Side::InflowLog(profile) => &|z| depth * profile.below(z) / profile.below(depth),
            _ => return None,
        };
        Some(if high > low { (below(high) - below(low)) / (high - low) } else { 0.0 })
    }

    /// A component of an inflow's velocity (m/s), other than by the height, at a `place` on its
    /// side, whose coordinates (m) run from 0 to `sizes` (m); 0 of other sides.
    pub fn inflow_at(&self, place: &[f64], sizes: &[f64], component: usize) -> f64 {
        match self {
            Side::Inflow(inflow) => inflow.velocity()[component],
            Side::InflowParabola(peak) => {
                let shape = |(x, size): (&f64, &f64)| 4.0 * x / size * (1.0 - x / size);
                peak.velocity()[component] * place.iter().zip(sizes).map(shape).product::<f64>()
            }
            Side::InflowProfile(profile) => profile.velocity_at(place[0])[component],
            _ => 0.0,
        }
    }

    /// Flow rate of an inflow into the box through the side of this number at a factor over time of
    /// 1, from its velocity at the middle of the cells, or by the height exactly (m2/s in 2D, m3/s
    /// in 3D); 0 of other sides.
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
        let Some(given) = self.inflow().first() else { return 0.0 };
        let inwards = if side.is_multiple_of(2) { 1.0 } else { -1.0 };
        if let Some(share) = self.share_between([0.0, sizes[0]], sizes[0]) {
            return inwards * given[axis] * share * sizes.iter().product::<f64>();
        }
        let cells = along.iter().map(|&a| domain.cells[a]).product::<usize>();
        let sum: f64 = (0..cells).map(|n| self.inflow_at(&at(n), &sizes, axis)).sum();
        inwards * sum * spacings.iter().product::<f64>()
    }
}

/// Velocity of an inflow, and how it varies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "an inflow is a velocity (m/s), a number for each axis as in [1.0, 0.0], or one \
                 that varies, { velocity = [1.0, 0.0], over_time = { time = [...], factor = \
                 [...] } }"
)]
pub enum Inflow {
    /// The same at all times (m/s).
    Steady(Vec<f64>),
    /// One that varies.
    Varying(VaryingInflow),
}

/// Velocity of an inflow that varies: `velocity` times a factor over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VaryingInflow {
    /// The velocity (m/s) at a factor of 1.
    pub velocity: Vec<f64>,
    /// Its factor over time.
    pub over_time: OverTime,
}

impl Inflow {
    /// The velocity at a factor of 1 (m/s).
    pub fn velocity(&self) -> &Vec<f64> {
        match self {
            Inflow::Steady(velocity) => velocity,
            Inflow::Varying(varying) => &varying.velocity,
        }
    }

    fn over_time(&self) -> Option<&OverTime> {
        if let Inflow::Varying(varying) = self { Some(&varying.over_time) } else { None }
    }

    fn over_time_mut(&mut self) -> Option<&mut OverTime> {
        if let Inflow::Varying(varying) = self { Some(&mut varying.over_time) } else { None }
    }
}

/// The flow over a rough bed: `u/u* = ln(1 + z/z0)/kappa` at the height z above the bed, the law of
/// the wall of Nezu & Nakagawa (Turbulence in open-channel flows, 1993) with its zero moved from z0
/// to the bed. The friction velocity u* is such that the mean over the open height H is `velocity`,
/// whatever kappa is: `u = velocity ln(1 + z/z0)/((1 + z0/H) ln(1 + H/z0) - 1)`, and with kappa =
/// 0.41 `u* = 0.41 velocity/((1 + z0/H) ln(1 + H/z0) - 1)`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LogProfile {
    /// Mean velocity over the open height (m/s).
    pub velocity: Vec<f64>,
    /// Roughness length z0 of the bed (m), positive: 1/30 of the sand roughness of a rough bed
    /// (Nikuradse 1933), `0.11 nu/u*` of a smooth one.
    pub roughness: f64,
    /// Factor of the velocity over time; default 1 at all times.
    pub over_time: Option<OverTime>,
}

impl LogProfile {
    /// The integral of `ln(1 + z/z0)` from the bed to a height (m).
    fn below(&self, height: f64) -> f64 {
        (height + self.roughness) * (height / self.roughness).ln_1p() - height
    }
}

/// A velocity profile: linear between points, constant beyond the first and last.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Coordinates along the side's first tangential axis (m), increasing.
    pub at: Vec<f64>,
    /// One velocity (m/s) for each coordinate.
    pub velocity: Vec<Vec<f64>>,
    /// Factor of the velocities over time; default 1 at all times.
    pub over_time: Option<OverTime>,
}

impl Profile {
    /// The velocity (m/s) at coordinate `s` (m) along the side's first tangential axis.
    pub fn velocity_at(&self, s: f64) -> Vec<f64> {
        let (next, weight) = between(&self.at, s);
        let low = &self.velocity[next - 1];
        let high = &self.velocity[next];
        low.iter().zip(high).map(|(a, b)| a + weight * (b - a)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Inflow, LogProfile, Side};

    /// Largest difference of the means over 16 faces from those of a formula at 10000 places each.
    fn apart(side: &Side, depth: f64, formula: impl Fn(f64) -> f64) -> f64 {
        let width = depth / 16.0;
        let mean = |low: f64| {
            let places = (0..10_000).map(|k| low + (f64::from(k) + 0.5) * width / 10_000.0);
            places.map(&formula).sum::<f64>() / 10_000.0
        };
        let face = |k: u32| f64::from(k) * width;
        let share = |k| side.share_between([face(k), face(k) + width], depth).unwrap();
        (0..16).map(|k| (share(k) - mean(face(k))).abs()).fold(0.0, f64::max)
    }

    /// The mean of all faces, over the velocity that is given.
    fn flow(side: &Side, depth: f64) -> f64 {
        let edges = |k: u32| [k, k + 1].map(|k| depth * f64::from(k) / 16.0);
        (0..16).map(|k| side.share_between(edges(k), depth).unwrap()).sum::<f64>() / 16.0
    }

    #[test]
    fn inflow_half_parabola_has_its_formula_and_two_thirds_of_its_top() {
        let side = Side::InflowHalfParabola(Inflow::Steady(vec![1.0, 0.0]));
        let depth = 0.3;
        let error = apart(&side, depth, |z| 2.0 * z / depth - (z / depth).powi(2));
        let flow = flow(&side, depth);
        println!("half-parabola: off by {error:.1e}, mean {flow:?}");
        assert!(error < 1e-9 && (flow - 2.0 / 3.0).abs() < 1e-15, "{error}, {flow}");
        // The value at a place, of a thin layer about it.
        let at = side.share_between([0.15 - 1e-6, 0.15 + 1e-6], depth).unwrap();
        assert!((at - 0.75).abs() < 1e-9, "{at}");
    }

    #[test]
    fn inflow_log_has_its_formula_and_the_mean_that_is_given() {
        let depth = 0.3;
        let kappa = 0.41;
        for roughness in [1e-5, 1e-3, 0.1] {
            let velocity = vec![1.0, 0.0];
            let side = Side::InflowLog(LogProfile { velocity, roughness, over_time: None });
            // By the friction velocity of a mean of 1.
            let ln = (1.0 + depth / roughness).ln();
            let friction = kappa / ((1.0 + roughness / depth) * ln - 1.0);
            let error = apart(&side, depth, |z| friction / kappa * (1.0 + z / roughness).ln());
            let flow = flow(&side, depth);
            println!("z0 = {roughness} m: off by {error:.1e}, mean {flow:?}, u* = {friction:.4}");
            assert!(error < 1e-4 && (flow - 1.0).abs() < 1e-14, "{error}, {flow}");
        }
    }
}
