//! Gaps: the width along a normal of a body's surface to the next body or wall, and the profile of
//! the flow beside the surface there ([`super::stencil`] has the sketch).
//!
//! ```text
//!      ( body k )                 a gap of the width g(x) = s_k + s_j at any point x, by the
//!                                 distances from both surfaces. Below 1.25 h
//!    ---.-------.---  g
//!              cells in it take the straight profile, as far as friction makes it in the time:
//!      (  other )                   tau = 1 - exp(-6 nu dt/g^2)              twice a step
//!                                 what flows through it is in the faces' correction,
//!                 and stays but for that friction:
//!                                   keep = exp(-12 nu dt/g^2)
//!              12 nu/g^2: of a parabola between two walls
//! ```
//! Without that such a gap would take the momentum of what flows through it in every step, and half
//! of an impact's energy with it.

use super::neighbour::Neighbour;
use super::normal::{Ahead, Foot, Normal};
use super::profile::{self, Parabola};
use crate::geometry::{Nearest, Orientation, Shape, Turned};
use crate::grid::{Boundaries, BoundaryKind, Grid};
use crate::numerics::{BLENDING_WIDTH, IMAGE_POINT, SLOPE_IMAGE_POINT};
use crate::particles::{Body, Velocities};
use nalgebra::Vector3;

/// Rate at which friction slows the flow through a gap that the grid does not resolve (nu over the
/// width squared): that of Poiseuille's parabola between two walls.
pub const POISEUILLE: f64 = 12.0;

/// Distances that differ by less (spacings) are alike: the two sides of a period, and two ranks,
/// round them differently.
const SAME: f64 = 1e-9;

/// The body or boundary across a gap.
#[derive(Clone, Copy, Debug)]
pub enum Other {
    /// Nothing that is near.
    Nothing,
    /// A body, and the arm from its centre (m); its image in a plane of symmetry normal to that
    /// axis, where there is one.
    Body(usize, Vector3<f64>, Option<usize>),
    /// A boundary across this axis, at its low (0) or high (1) side, at this stored position.
    Boundary(usize, usize, usize),
}

impl Other {
    /// The velocity there (m/s); `None` where nothing is near.
    #[inline]
    pub fn velocity<const D: usize>(
        &self,
        velocities: impl Velocities,
        boundaries: &Boundaries<D>,
    ) -> Option<Vector3<f64>> {
        match *self {
            Other::Nothing => None,
            Other::Body(j, arm, None) => Some(velocities(j).at(&arm)),
            Other::Body(j, mut arm, Some(axis)) => {
                arm[axis] = -arm[axis];
                let mut velocity = velocities(j).at(&arm);
                velocity[axis] = -velocity[axis];
                Some(velocity)
            }
            Other::Boundary(axis, side, at) => {
                let Some(BoundaryKind::Velocity(given)) = &boundaries.kinds[axis][side] else {
                    return None;
                };
                Some(Vector3::from_fn(|a, _| if a < D { given[a][at] } else { 0.0 }))
            }
        }
    }
}

/// Surroundings of a cut body as it is built.
pub struct Surroundings<'a, const D: usize> {
    /// The grid.
    pub grid: &'a Grid<D>,
    /// The conditions at the boundaries.
    pub boundaries: &'a Boundaries<D>,
    /// All bodies.
    pub bodies: &'a [Body],
    /// Number of the one that is built, and how it is turned.
    pub body: usize,
    pub orientation: Orientation,
    /// Its radius (m) where it is round.
    pub round: Option<f64>,
    /// The bodies near this one.
    pub near: &'a [Neighbour],
    /// Which sides of the box are as near to the body that is built.
    pub walls: [[bool; 2]; D],
    /// The profiles.
    pub profiles: &'a Profiles,
}

/// The profiles of the flow beside the surfaces of all bodies in a step.
#[derive(Clone, Copy, Debug)]
pub struct Profiles {
    /// The spacing that depths and image points count in (m).
    pub h: f64,
    /// Whether there is friction in gaps.
    pub viscous: bool,
    /// Whether cells near the surface take the cubic extrapolation: where no body moves.
    pub cubic: bool,
    /// Gap beyond which nothing is felt of what lies there (m).
    pub reach: f64,
    /// The profile far from other surfaces.
    pub parabola: Parabola,
    /// The factors of its slope.
    pub slope: [f64; 3],
}

impl Profiles {
    /// On a grid of this spacing (m), with friction in gaps and the cubic extrapolation or not.
    pub fn new(h: f64, viscous: bool, cubic: bool) -> Profiles {
        let distance = SLOPE_IMAGE_POINT;
        Profiles {
            h,
            viscous,
            cubic,
            reach: reach(cubic) * h,
            parabola: Parabola::new(IMAGE_POINT),
            slope: if cubic { profile::slope_of_means(distance) } else { profile::slope(distance) },
        }
    }
}

/// Gap (spacings) beyond which nothing is felt of what lies there; with the cubic extrapolation
/// that is what its third image point keeps off.
pub fn reach(cubic: bool) -> f64 {
    let points = if cubic { 3.0 } else { 2.0 };
    points * IMAGE_POINT + 1.5 * BLENDING_WIDTH
}

/// Gap (spacings) below which the grid resolves no profile in it: the first image point would be as
/// near to what lies across.
pub const UNRESOLVED: f64 = IMAGE_POINT + 0.5 * BLENDING_WIDTH;

/// 0 below `from`, 1 above `to`, and smooth between.
pub fn smooth_step(x: f64, from: f64, to: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Shares of the forms of the profile at a gap; they sum to one.
pub struct Shares {
    /// The parabola.
    pub full: f64,
    /// The straight line through the first image point.
    pub linear: f64,
    /// The straight line to what lies across.
    pub across: f64,
}

impl Shares {
    /// For a gap in spacings.
    pub fn of(gap: f64) -> Shares {
        let near = reach(false);
        if gap >= near {
            return Shares { full: 1.0, linear: 0.0, across: 0.0 };
        }
        let full = smooth_step(gap, near - BLENDING_WIDTH, near);
        let open = smooth_step(gap, UNRESOLVED - BLENDING_WIDTH, UNRESOLVED);
        Shares { full, linear: open - full, across: 1.0 - open }
    }

    /// Shares beside a corner, where this part of the parabola is left, the rest a straight line.
    pub fn beside_corner(self, clear: f64) -> Shares {
        let full = clear * self.full;
        Shares { full, linear: self.linear + self.full - full, ..self }
    }
}

/// The flow in a gap that the grid does not resolve.
#[derive(Clone, Copy, Debug)]
pub struct GapFlow {
    /// Share of the gap that is not resolved.
    pub share: f64,
    /// Its width (spacings).
    width: f64,
}

impl GapFlow {
    /// Share of it that is left after half a step of this friction: that of a gap of one spacing,
    /// whose walls reduce the flow by `exp(-friction)`.
    pub fn kept(&self, friction: f64) -> f64 {
        (-friction / (self.width * self.width)).exp()
    }
}

/// A gap along a normal.
pub struct Gap {
    /// Its width (m).
    pub width: f64,
    /// The body or boundary across it.
    pub other: Other,
}

impl<const D: usize> Surroundings<'_, D> {
    /// The shape of the body that is built.
    pub fn shape(&self) -> &dyn Shape {
        self.bodies[self.body].shape()
    }

    /// The signed distance (m) of the point at `arm` (m) from the surface of the body that is
    /// built, turned like this.
    #[inline]
    pub fn distance(&self, orientation: &Orientation, arm: &Vector3<f64>) -> f64 {
        self.round.map_or_else(
            || self.shape().turned(orientation).distance(arm),
            |radius| arm.norm() - radius,
        )
    }

    /// That distance, and the outward normal there of a body that is not round.
    #[inline]
    pub fn nearest(&self, arm: &Vector3<f64>) -> (f64, Option<Vector3<f64>>) {
        if let Some(radius) = self.round {
            return (arm.norm() - radius, None);
        }
        let Nearest { distance, normal } = self.turned().nearest(arm);
        (distance, Some(normal))
    }

    /// The shape of the body that is built as it is turned.
    pub fn turned(&self) -> Turned<'_> {
        self.shape().turned(&self.orientation)
    }

    /// The second image point along a normal, and how far out that is (m).
    fn second_point(&self, normal: &Normal) -> (Vector3<f64>, f64) {
        let out = 2.0 * IMAGE_POINT * self.profiles.h;
        (normal.foot + out * normal.n, out)
    }

    /// Distances along a normal to the body that is built; to a corner only with `corners`.
    pub fn ahead(&self, normal: &Normal, corners: bool) -> Ahead {
        if self.round.is_some() {
            return Ahead::NOTHING;
        }
        // Across a concave seam lies the body itself.
        let itself = self.turned().meets_itself(&normal.foot, &normal.n);
        let mut corner = f64::INFINITY;
        if corners && self.shape().is_obstacle() {
            corner = self.turned().distance(&self.second_point(normal).0);
        }
        Ahead { itself: itself.unwrap_or(f64::INFINITY), corner }
    }

    /// Share of a profile of second or third order at a surface along a normal of the body that is
    /// built, with the gap of this width (m) along that: all of it far from corners, nothing where
    /// the second image point is half as far from another wall beside the normal. A cell close to
    /// two walls of a corner between obstacles would have twice the imaginary part of an eigenvalue
    /// that one wall gives it, which Legendre stages do not bear.
    pub fn clear_of_corners(&self, normal: &Normal, width: f64) -> f64 {
        let own = self.shape();
        let (point, out) = self.second_point(normal);
        let mut least = out.min(normal.ahead.corner);
        for near in self.near.iter().filter(|near| !near.is_beyond(&point, out)) {
            if own.is_obstacle() || self.bodies[near.body].shape().is_obstacle() {
                least = least.min(near.distance(self.bodies, &point));
            }
        }
        // The cosine of the angle of the corner; 1 between parallel walls, which are a gap.
        let facing = (least / (width - out).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        facing + (1.0 - facing) * smooth_step(least / out, 0.5, 1.0)
    }

    /// The flow in a gap of this width (m), as far as the grid does not resolve it.
    pub fn flow(&self, width: f64) -> Option<GapFlow> {
        let width = (width / self.profiles.h).max(1e-6);
        let share = Shares::of(width).across;
        (share > 0.0).then_some(GapFlow { share, width })
    }

    /// Width (m) of the gap that has the point at `arm` (m) from the centre of body `k`, `own` (m)
    /// from its surface, where the grid does not resolve it; else at least so wide that it does.
    pub fn width_at(&self, k: usize, arm: &Vector3<f64>, own: f64) -> f64 {
        let mut other = f64::INFINITY;
        // Beyond that there is no gap that the grid does not resolve.
        let most = UNRESOLVED * self.profiles.h - own;
        for near in self.near.iter().filter(|near| !near.is_beyond(arm, most)) {
            other = other.min(near.distance(self.bodies, arm));
        }
        for (axis, side) in (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            if !self.walls[axis][side] {
                continue;
            }
            if let Some(BoundaryKind::Velocity(_)) = self.boundaries.kinds[axis][side] {
                let place = self.bodies[k].centre[axis] + arm[axis];
                other = other.min(if side == 0 { place } else { self.grid.size[axis] - place });
            }
        }
        own + other
    }

    /// Whether the body `k` is the nearest to the point at `arm` (m) from its centre, `own` (m)
    /// from its surface, or the first of those that are.
    pub fn is_nearest(&self, k: usize, arm: &Vector3<f64>, own: f64) -> bool {
        self.near.iter().all(|near| {
            let alike = SAME * self.profiles.h;
            if near.is_beyond(arm, own + alike) {
                return true;
            }
            let apart = near.distance(self.bodies, arm) - own;
            // The image in a plane of symmetry has none.
            apart > alike || (apart >= -alike && (near.mirror.is_some() || near.is_after(k)))
        })
    }

    /// Distance (m) by which other faces of a body may be further from a cell inside, whose nearest
    /// face is at the signed distance `s` (m), to have a share in it: the blending width, or as
    /// much as the cell is deep.
    pub fn beside_nearest(&self, s: f64) -> f64 {
        (BLENDING_WIDTH * self.profiles.h).min(-s)
    }

    /// The share, before all are brought to a sum of one, of one of the faces' feet in such a cell:
    /// 1 of the nearest, 0 where the foot would leave its face for one of the others,
    /// `d_i = (n_i.n) d`. Along the middle between two faces it is the same for both, so that
    /// nothing jumps as the body moves, and no symmetry is left to rounding.
    pub fn share_of(&self, s: f64, own: usize, feet: &[Foot]) -> f64 {
        let foot = feet[own].near;
        let near = 1.0 - (s - foot.distance) / self.beside_nearest(s);
        let on_face = |other: &Nearest| {
            let cosine = other.normal.dot(&foot.normal);
            (other.distance - cosine * foot.distance) / ((1.0 - cosine) * foot.distance)
        };
        // For the foot itself that would be the ratio of two roundings.
        let others = feet.iter().enumerate().filter(|(i, _)| *i != own);
        let on_face = others.map(|(_, other)| on_face(&other.near)).fold(1.0, f64::min);
        smooth_step(near, 0.0, 1.0) * smooth_step(on_face, 0.0, 1.0)
    }

    /// The ownership weight of a body to the point at `arm` (m) from its centre, `own` (m) from its
    /// surface: 1 where no other is as near, 0 where one is much nearer, and one half where another
    /// one is at the same distance.
    pub fn ownership(&self, arm: &Vector3<f64>, own: f64) -> f64 {
        let band = BLENDING_WIDTH * self.profiles.h;
        let mut owned = 1.0;
        for near in self.near {
            if near.mirror.is_some() || near.is_beyond(arm, own + band) {
                continue;
            }
            let t = 0.5 + 0.5 * (near.distance(self.bodies, arm) - own) / band;
            if t <= 0.0 {
                return 0.0;
            }
            owned *= smooth_step(t, 0.0, 1.0);
        }
        owned
    }

    /// Whether another body or a wall is so near that the grid does not resolve the gap.
    pub fn has_neighbours(&self, k: usize) -> bool {
        let body = &self.bodies[k];
        let bounds = body.reach();
        let within = |a: usize, side: usize| {
            let from = body.centre[a] - if side == 0 { 0.0 } else { self.grid.size[a] };
            matches!(self.boundaries.kinds[a][side], Some(BoundaryKind::Velocity(_)))
                && from.abs() < bounds[a] + UNRESOLVED * self.profiles.h
        };
        !self.near.is_empty() || (0..2 * D).any(|f| within(f / 2, f % 2))
    }

    /// The gap (m) along a normal of a body's surface, its centre at `image` (m), to the next body
    /// or wall.
    pub fn gap(&self, image: &Vector3<f64>, normal: &Normal) -> Gap {
        let Normal { n, foot, ahead, .. } = normal;
        let mut gap = Gap { width: f64::INFINITY, other: Other::Nothing };
        if ahead.itself.is_finite() {
            let width = ahead.itself;
            gap = Gap { width, other: Other::Body(self.body, foot + width * n, None) };
        }
        for near in self.near.iter().filter(|near| near.apart.dot(n) > near.grazes) {
            let Some(width) = near.meets(self.bodies, foot, n, self.profiles.reach) else {
                continue;
            };
            if width < gap.width {
                gap = Gap {
                    width,
                    other: Other::Body(near.body, width * n - (near.apart - foot), near.mirror),
                };
            }
        }
        for axis in 0..D {
            let side = usize::from(n[axis] > 0.0);
            if !self.walls[axis][side] {
                continue;
            }
            let boundary = match &self.boundaries.kinds[axis][side] {
                Some(boundary @ (BoundaryKind::Velocity(_) | BoundaryKind::Outflow)) => boundary,
                _ => continue,
            };
            let from = image[axis] + foot[axis];
            let distance = if side == 1 { self.grid.size[axis] - from } else { from };
            if n[axis].abs() * self.profiles.reach < distance {
                continue;
            }
            let width = (distance / n[axis].abs()).max(0.0);
            if width < gap.width {
                gap.width = width;
                gap.other = if let BoundaryKind::Velocity(_) = boundary {
                    let at = self.grid.position_on_boundary(axis, &(image + foot + width * n));
                    Other::Boundary(axis, side, at)
                } else {
                    Other::Nothing
                };
            }
        }
        gap
    }
}
