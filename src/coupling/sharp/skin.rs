//! The skin of a body on the grid: the faces that it covers, the cells inside whose velocity it sets, the points of its
//! surface where its traction is taken. Rebuilt when the body moves.
//!
//! ```text
//!    n ^   * second probe, 2 h         the velocity relative to the wall, w, along the normal from the wall at 0:
//!      |   * first probe, h              far from others   through 0 and both probes         (g > 2.75 h)
//!   ---+-------- wall                    near another      linear, through the first          (1.25 h < g < 2.25 h)
//!      |   o cell inside, s < 0          closer still      straight to the other's velocity   (g < 0.75 h)
//! ```
//! with g the gap along n to the next body or wall; between these the shares change smoothly.

use super::probe::Probe;
use crate::grid::{Border, Boundaries, Grid, VectorField};
use crate::solids::reach::{Block, images};
use crate::solids::{Body, Cut, Overlap, aperture, fraction, nearest_image};
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Depth to which the profile is continued into a body, in spacings, as deep as the advection of cells beside the wall
/// reaches; deeper, the body's own motion stands.
pub(super) const DEPTH: f64 = 2.5;
/// Probes of the imposed profile, in spacings from the wall.
pub(super) const PROFILE: [f64; 2] = [1.0, 2.0];
/// Gap, in spacings, below which the grid resolves no profile in it.
const UNRESOLVED: f64 = 1.25;
/// What the continued profile may reach, of the velocity at the first probe, where the layer is just resolved.
const MOST: f64 = 5.0;
/// Spacings between the probes of the wall's slope.
const SLOPE: f64 = 0.7;
/// What that slope takes of the wall's own velocity, over a spacing.
pub(super) const RESISTANCE: f64 = (3.0 - 1.5 + 1.0 / 3.0) / SLOPE;
/// Gap, in spacings, beyond which nothing is felt of what lies there.
pub(super) const NEAR: f64 = 2.75;

/// A linear functional of the velocity relative to a body's motion, along a normal of its wall.
#[derive(Clone, Debug)]
pub struct Trace {
    probes: Range<usize>,
    /// Share of the velocity of what lies across the gap, relative to the body's at its own wall, and what lies there.
    across: f64,
    other: Other,
    /// From the body's centre to its wall (m).
    foot: Vector3<f64>,
}

/// What lies across a gap.
#[derive(Clone, Copy, Debug)]
enum Other {
    Nothing,
    /// A body, and the arm from its centre (m).
    Body(usize, Vector3<f64>),
    /// A border with this velocity (m/s).
    Border(Vector3<f64>),
}

/// A cell whose velocity a body sets.
#[derive(Clone, Debug)]
pub struct Inside {
    /// Its index in a field.
    pub cell: usize,
    /// From the body's centre (m).
    pub arm: Vector3<f64>,
    /// The profile there; `None` deep inside.
    pub trace: Option<Trace>,
    /// How much of what it has gives way to the profile: less than all outside, in gaps that the grid does not resolve.
    pub weight: f64,
    /// Whether it lies outside by now, and was inside before the body moved.
    pub fresh: bool,
}

/// A point of a body's surface.
#[derive(Clone, Debug)]
pub struct Point {
    /// From the body's centre (m).
    pub arm: Vector3<f64>,
    /// Its part of the surface (m2; m per metre of depth).
    pub area: f64,
    /// The slope of the velocity along the outward normal (1/s).
    pub slope: Trace,
}

/// A body on the grid.
#[derive(Clone, Debug)]
pub struct Skin<const D: usize> {
    /// Faces that it covers, by axis.
    pub cuts: [Vec<Cut>; D],
    /// Cells that it touches, with its fraction of them.
    pub solid: Vec<Overlap>,
    /// Cells of `solid` in which it speaks for the wall: no other body is nearer.
    pub owns: Vec<bool>,
    /// Cells inside it.
    pub inside: Vec<Inside>,
    /// Points on its surface, of this rank.
    pub points: Vec<Point>,
    probes: Vec<Probe<D>>,
}

/// What a skin is built among.
pub struct Surroundings<'a, const D: usize> {
    /// The grid.
    pub grid: &'a Grid<D>,
    /// The conditions at the borders.
    pub boundaries: &'a Boundaries<D>,
    /// All bodies.
    pub bodies: &'a [Body],
    /// Numbers of the bodies near this one.
    pub near: &'a [usize],
    /// Lengths of the periodic axes (m).
    pub periods: &'a [Option<f64>; 3],
    /// The spacing that depths and probes count in (m).
    pub h: f64,
}

impl<const D: usize> Skin<D> {
    /// A skin with room for all that a body of `radius` (m) can touch, its probes counting in spacings of `h` (m).
    pub fn new(grid: &Grid<D>, radius: f64, h: f64) -> Skin<D> {
        let cells = |beyond: f64| fraction::most_cells(grid, radius + beyond * h);
        let (inside, points) = (cells(UNRESOLVED), surface_points::<D>(radius, h).0);
        Skin {
            cuts: std::array::from_fn(|_| Vec::with_capacity(cells(1.0))),
            solid: Vec::with_capacity(cells(0.0)),
            owns: Vec::with_capacity(cells(0.0)),
            inside: Vec::with_capacity(inside),
            points: Vec::with_capacity(points),
            probes: Vec::with_capacity(2 * inside + 4 * points),
        }
    }

    /// Cells in which it speaks for the wall.
    pub fn own_cells(&self) -> impl Iterator<Item = &Overlap> {
        self.solid.iter().zip(&self.owns).filter_map(|(cell, owns)| owns.then_some(cell))
    }

    /// Finds the faces and cells of the body `k`; `shift` is how far it has moved since the last time (m).
    pub fn rebuild(&mut self, around: &Surroundings<D>, k: usize, shift: &Vector3<f64>) {
        let (grid, body) = (around.grid, &around.bodies[k]);
        for (axis, cuts) in self.cuts.iter_mut().enumerate() {
            aperture::cuts(grid, axis, &body.centre, body.radius, cuts);
        }
        fraction::overlaps(grid, &body.centre, body.radius, fraction::Rule::Exact, &mut self.solid);
        self.owns.clear();
        self.owns.extend(self.solid.iter().map(|o| around.nearest(k, &o.arm)));
        self.probes.clear();
        self.inside.clear();
        let moved = shift.norm();
        let tight = if around.has_neighbours(k) { UNRESOLVED * around.h } else { 0.0 };
        for image in images(grid, &body.centre) {
            for at in Block::owned(grid, &image, body.radius + moved.max(tight)) {
                let arm =
                    Vector3::from_fn(|a, _| if a < D { (at[a] as f64 + 0.5) * grid.h[a] - image[a] } else { 0.0 });
                let s = arm.norm() - body.radius;
                let fresh = s > 0.0 && (arm + shift).norm() <= body.radius;
                if (s > tight && !fresh) || !around.nearest(k, &arm) {
                    continue;
                }
                let Some(cell) = grid.owned_index(at) else { continue };
                let (mut trace, mut weight) = (None, 1.0);
                if s > 0.0 && !fresh {
                    (trace, weight) = self.profile_across(around, k, &image, &arm, s);
                    if weight == 0.0 {
                        continue;
                    }
                } else if s > -body.radius.min(DEPTH * around.h) {
                    trace = Some(self.profile(around, k, &image, &arm, s));
                }
                self.inside.push(Inside { cell, arm, trace, weight, fresh });
            }
        }
        self.spread_points(around, k);
    }

    /// The profile at the signed distance `s` (m) along the normal through `arm`.
    fn profile(
        &mut self,
        around: &Surroundings<D>,
        k: usize,
        image: &Vector3<f64>,
        arm: &Vector3<f64>,
        s: f64,
    ) -> Trace {
        let (h, radius) = (around.h, around.bodies[k].radius);
        let n = arm.normalize();
        let gap = around.gap(k, image, &n);
        let share = Shares::of(gap.width / h);
        let [d1, d2] = PROFILE.map(|d| d * h);
        let near = h.min(0.5 * gap.width);
        // In a gap no further than the mirror image: more would feed back through the faces between the two.
        let mirrored = |width: f64| (s / width).max(-1.0);
        let linear = if share.linear > 0.0 { share.linear * mirrored(near) } else { 0.0 };
        let first = share.full * s * (d2 - s) / (d1 * (d2 - d1)) + linear;
        let second = share.full * s * (s - d1) / (d2 * (d2 - d1));
        let at = if share.full > 0.0 { d1 } else { near };
        let probes = [(at, first), (d2, second)];
        let across = share.across * mirrored(gap.width.max(0.5 * h));
        self.trace(around.grid, image, n, radius, &probes, across, gap.other)
    }

    /// The straight profile across a gap, outside at the distance `s` (m) from the wall, and its weight.
    fn profile_across(
        &mut self,
        around: &Surroundings<D>,
        k: usize,
        image: &Vector3<f64>,
        arm: &Vector3<f64>,
        s: f64,
    ) -> (Option<Trace>, f64) {
        let (n, radius) = (arm.normalize(), around.bodies[k].radius);
        let gap = around.gap(k, image, &n);
        let across = s / gap.width.max(0.5 * around.h).max(s);
        let trace = self.trace(around.grid, image, n, radius, &[], across, gap.other);
        (Some(trace), Shares::of(gap.width / around.h).across)
    }

    #[allow(clippy::too_many_arguments)]
    fn trace(
        &mut self,
        grid: &Grid<D>,
        image: &Vector3<f64>,
        n: Vector3<f64>,
        radius: f64,
        probes: &[(f64, f64)],
        across: f64,
        other: Other,
    ) -> Trace {
        let start = self.probes.len();
        for &(d, share) in probes.iter().filter(|(_, share)| *share != 0.0) {
            self.probes.push(Probe::new(grid, image, (radius + d) * n, share));
        }
        Trace { probes: start..self.probes.len(), across, other, foot: radius * n }
    }

    /// Points on the surface, about four a spacing in 2D and two in 3D; each belongs to the rank of its cell.
    fn spread_points(&mut self, around: &Surroundings<D>, k: usize) {
        self.points.clear();
        let (grid, body, h) = (around.grid, &around.bodies[k], around.h);
        let r = body.radius;
        let (count, area) = surface_points::<D>(r, h);
        // On a sphere, a spiral of equal areas.
        let golden = PI * (3.0 - 5.0f64.sqrt());
        for i in 0..count {
            let t = (i as f64 + 0.5) / count as f64;
            let n = if D == 2 {
                let (y, x) = (TAU * t).sin_cos();
                Vector3::new(x, y, 0.0)
            } else {
                let z = 1.0 - 2.0 * t;
                let (y, x) = (golden * i as f64).sin_cos();
                let c = (1.0 - z * z).max(0.0).sqrt();
                Vector3::new(c * x, c * y, z)
            };
            let Some(image) = images(grid, &body.centre).find(|image| grid.owns(&(image + r * n))) else { continue };
            let gap = around.gap(k, &image, &n);
            let share = Shares::of(gap.width / h);
            let (e, near) = (SLOPE * h, h.min(0.5 * gap.width));
            let full = share.full / e;
            let linear = if share.linear > 0.0 { share.linear / near } else { 0.0 };
            let probes = [(e, 3.0 * full), (2.0 * e, -1.5 * full), (3.0 * e, full / 3.0), (near, linear)];
            let across = share.across / gap.width.max(0.5 * h);
            let slope = self.trace(grid, &image, n, r, &probes, across, gap.other);
            self.points.push(Point { arm: r * n, area, slope });
        }
    }

    /// The value of a trace (m/s, or 1/s of a slope) for a body and a velocity field with its ghosts filled.
    #[inline(always)]
    pub fn value(
        &self,
        trace: &Trace,
        grid: &Grid<D>,
        u: &VectorField<D>,
        bodies: &[Body],
        k: usize,
        limit: Option<f64>,
    ) -> Vector3<f64> {
        let body = &bodies[k];
        let (mut sum, mut first) = (Vector3::zeros(), None);
        for probe in &self.probes[trace.probes.clone()] {
            let relative = probe.velocity(grid, u) - body.velocity_at(&probe.arm);
            first.get_or_insert_with(|| relative.norm());
            sum += probe.share * relative;
        }
        if let (Some(limit), Some(first)) = (limit, first) {
            // first <= limit: the layer is resolved.
            let most = first * (MOST * limit / first.max(limit)).max(1.0);
            let size = sum.norm();
            if size > most {
                sum *= most / size;
            }
        }
        let other = match trace.other {
            Other::Nothing => return sum,
            Other::Body(j, arm) => bodies[j].velocity_at(&arm),
            Other::Border(velocity) => velocity,
        };
        sum + trace.across * (other - body.velocity_at(&trace.foot))
    }
}

/// Points on the surface of a disc or sphere of `radius` (m) for spacings of `h` (m), and the area of each (m2; m per metre
/// of depth).
fn surface_points<const D: usize>(radius: f64, h: f64) -> (usize, f64) {
    let area = if D == 2 { TAU * radius } else { 4.0 * PI * radius * radius };
    let count = 4 * (area / h.powi(D as i32 - 1)).ceil() as usize;
    (count, area / count as f64)
}

/// How much of each form of the profile holds at a gap; they sum to one.
struct Shares {
    full: f64,
    linear: f64,
    across: f64,
}

impl Shares {
    /// For a gap in spacings.
    fn of(gap: f64) -> Shares {
        let step = |from: f64, to: f64| {
            let t = ((gap - from) / (to - from)).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        let (full, open) = (step(2.25, NEAR), step(0.75, UNRESOLVED));
        Shares { full, linear: open - full, across: 1.0 - open }
    }
}

/// A gap along a normal.
struct Gap {
    width: f64,
    other: Other,
}

impl<const D: usize> Surroundings<'_, D> {
    /// Whether no other body is nearer to the point at `arm` (m) from the centre of body `k`.
    fn nearest(&self, k: usize, arm: &Vector3<f64>) -> bool {
        let own = arm.norm() - self.bodies[k].radius;
        self.near.iter().all(|&j| {
            let apart = nearest_image(&self.bodies[k].centre, &self.bodies[j].centre, self.periods);
            let other = (arm - apart).norm() - self.bodies[j].radius;
            own < other || (own == other && k < j)
        })
    }

    /// Whether another body or a wall is so near that the grid does not resolve the gap.
    fn has_neighbours(&self, k: usize) -> bool {
        let body = &self.bodies[k];
        let within = |a: usize, side: usize| {
            let from = body.centre[a] - if side == 0 { 0.0 } else { self.grid.size[a] };
            matches!(self.boundaries.borders[a][side], Some(Border::Velocity(_)))
                && from.abs() < body.radius + UNRESOLVED * self.h
        };
        !self.near.is_empty() || (0..2 * D).any(|f| within(f / 2, f % 2))
    }

    /// The gap (m) from the wall of body `k`, its centre at `image`, along `n` to the next body or wall.
    fn gap(&self, k: usize, image: &Vector3<f64>, n: &Vector3<f64>) -> Gap {
        let radius = self.bodies[k].radius;
        let mut gap = Gap { width: f64::INFINITY, other: Other::Nothing };
        for &j in self.near {
            let other = &self.bodies[j];
            let apart = nearest_image(&self.bodies[k].centre, &other.centre, self.periods) - radius * n;
            let along = apart.dot(n);
            let under = along * along - apart.norm_squared() + other.radius * other.radius;
            if along > 0.0 && under > 0.0 {
                let width = (along - under.sqrt()).max(0.0);
                if width < gap.width {
                    gap = Gap { width, other: Other::Body(j, width * n - apart) };
                }
            }
        }
        for axis in 0..D {
            let side = usize::from(n[axis] > 0.0);
            let Some(Border::Velocity(velocity)) = &self.boundaries.borders[axis][side] else { continue };
            let foot = image[axis] + radius * n[axis];
            let distance = if side == 1 { self.grid.size[axis] - foot } else { foot };
            if n[axis].abs() * NEAR * self.h < distance {
                continue;
            }
            let width = (distance / n[axis].abs()).max(0.0);
            if width < gap.width {
                let at = self.grid.position_on_border(axis, &(image + (radius + width) * n));
                let velocity = Vector3::from_fn(|a, _| if a < D { velocity[a][at] } else { 0.0 });
                gap = Gap { width, other: Other::Border(velocity) };
            }
        }
        gap
    }
}
