//! Readings of the velocity beside a body's surface: the profile inside, and the slope at the
//! surface.
//!
//! ```text
//!    n ^   * second image point, 2 h
//!              the velocity relative to the surface, w, along the normal from the surface at 0:
//!      |   * first image point, h              far from others   through 0 and both image points
//!              (g > 2.75 h)
//!   ---+-------- surface                    near another      linear, through the first
//!              (1.25 h < g < 2.25 h)
//!      |   o cell inside, s < 0          closer still      straight to the other's velocity
//!              (g < 0.75 h)
//! ```
//! with g the gap along n to the next body or surface; between these the shares change smoothly.
//! [`super::profile`] has the first.
//!
//! Where no body moves, cells that are not deep have a cubic extrapolation in creeping flow. It
//! comes a step late:
//!
//! ```text
//!   w = parabola(u) + c (cubic - parabola)(u^n)   through image points at h, 2 h, 3 h
//!                 (g > 3.75 h)
//! ```
//! with c = 1 where the Reynolds number of a spacing is below 1/2, and 0 from 3/2 on. A steady flow
//! has all of it. Imposed on every stage it would not decay in long steps: some of its waves
//! oscillate, and Legendre stages bear none that do.
//!
//! The values of stencils of a velocity field are found many at a time, so that no step waits for
//! the one before it at the same point:
//!
//! ```text
//!   the cells and weights of all image points  ->  the velocities there  ->  the sums of each
//! ```

use super::gap::{GapFlow, Other, Shares, Surroundings, smooth_step};
use super::image_point::{ImagePoint, Lattice, Place, Ray};
use super::normal::{Line, Normal};
use super::profile;
use crate::grid::{Boundaries, Grid, VectorField};
use crate::numerics::{BLENDING_WIDTH, IMAGE_POINT, SLOPE_IMAGE_POINT};
use crate::particles::{RigidVelocity, Velocities};
use nalgebra::Vector3;
use pulp::Simd;

/// Readings at a time, and image points of one at most.
const MANY: usize = 16;
const MOST: usize = 4;

/// No number.
const NOTHING: u32 = u32::MAX;

/// A linear functional of the velocity relative to a body's motion, along the normal of its surface
/// through a point of its.
#[derive(Clone, Copy, Debug)]
pub struct Stencil {
    /// Its first image point, and how many it has.
    first: u32,
    count: u32,
    /// Index in a field of the cell that the body's centre is in, or an image of it.
    origin: i32,
    /// Its number among what lies across gaps, or [`NOTHING`].
    across: u32,
    /// Its number among the lines, or [`NOTHING`] of a round body: its line is the point's arm
    /// itself.
    line: u32,
}

impl Stencil {
    /// A stencil of nothing.
    pub const STILL: Stencil =
        Stencil { first: 0, count: 0, origin: 0, across: NOTHING, line: NOTHING };

    /// Whether it is of nothing.
    pub fn is_still(&self) -> bool {
        self.count == 0 && self.across == NOTHING
    }
}

/// A reading of the velocity through a point of a body or near it.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// From the body's centre (m).
    pub arm: Vector3<f64>,
    /// The stencil that is read.
    pub stencil: Stencil,
    /// Number of the ghost cell or the point that it is for.
    pub place: u32,
    /// The share of a profile in its ghost cell, or a point's part of the surface (m2; m per metre
    /// of depth).
    pub share: f64,
}

/// The cubic extrapolation to a ghost cell, in place of a part of the stencil that the cell has.
#[derive(Clone, Copy, Debug)]
pub struct Cubic {
    /// The cubic, by its part, for its ghost cell.
    pub cubic: Reading,
    /// Number of that cell's own profile, and the part of it that this is in place of.
    pub profile: u32,
    pub part: f64,
    /// Velocity that it adds to the cell's own profile, as last found (m/s).
    pub added: Vector3<f64>,
}

/// The body or boundary across a gap, as a stencil reads it.
#[derive(Clone, Copy, Debug)]
struct Across {
    /// Share of its velocity, relative to the body's at its own surface.
    share: f64,
    other: Other,
    /// The body's surface, as a factor of the line.
    wall: f64,
}

/// All that a body reads.
#[derive(Clone, Debug)]
pub struct Stencils<const D: usize> {
    image_points: Vec<ImagePoint>,
    across: Vec<Across>,
    /// Lines of the stencils of a body that is not round.
    lines: Vec<Line>,
    /// Where the body's centre lies, from the middle of the cell below it (spacings). Images of it
    /// lie alike: a period is a whole number of cells.
    centre: [f64; D],
    lattice: Lattice<D>,
}

/// The flow that a body reads.
#[derive(Clone, Copy)]
pub struct Flow<'a, V: Velocities, const D: usize> {
    /// The grid, and the velocity of its cells (m/s), ghosts filled.
    pub grid: &'a Grid<D>,
    pub u: &'a VectorField<D>,
    /// The boundaries, which may be across a gap.
    pub boundaries: &'a Boundaries<D>,
    /// The velocities of all bodies, and which it is.
    pub velocities: V,
    pub k: usize,
}

/// A centre of a body or an image of it.
#[derive(Clone, Copy, Debug)]
pub struct Image {
    /// Where it is (m).
    pub centre: Vector3<f64>,
    /// Index in a field of the cell below it, which may lie beyond the stored ones.
    origin: i32,
}

impl<const D: usize> Stencils<D> {
    /// None, with room for so many profiles inside and slopes on the surface.
    pub fn new(grid: &Grid<D>, inside: usize, points: usize, round: bool) -> Stencils<D> {
        Stencils {
            image_points: Vec::with_capacity(2 * inside + 4 * points),
            across: Vec::with_capacity(inside + points),
            lines: Vec::with_capacity(if round { 0 } else { inside + points }),
            centre: [0.0; D],
            lattice: Lattice::new(grid),
        }
    }

    /// Forgets all, of a body that now has this centre (m).
    pub fn begin(&mut self, grid: &Grid<D>, centre: &Vector3<f64>) {
        self.image_points.clear();
        self.across.clear();
        self.lines.clear();
        self.centre = std::array::from_fn(|a| {
            let place = place(grid, centre, a);
            place - place.floor()
        });
    }

    /// An image of the body's centre (m).
    pub fn image(&self, grid: &Grid<D>, centre: Vector3<f64>) -> Image {
        let cell = |a: usize| (place(grid, &centre, a) - self.centre[a]).round() as i32;
        let origin = (0..D).map(|a| cell(a) * grid.stride[a] as i32).sum();
        Image { centre, origin }
    }

    /// The profile at the signed distance `s` (m) along a normal.
    pub fn profile(
        &mut self,
        around: &Surroundings<D>,
        image: &Image,
        normal: &Normal,
        s: f64,
    ) -> Stencil {
        let h = around.profiles.h;
        let gap = around.gap(&image.centre, normal);
        let clear = around.clear_of_corners(normal, gap.width);
        let share = Shares::of(gap.width / h).beside_corner(clear);
        let [d1, d2] = [IMAGE_POINT * h, 2.0 * IMAGE_POINT * h];
        let near = h.min(0.5 * gap.width);
        // In a gap no further than the mirror image: more would feed back through the faces between
        // the two.
        let mirrored = |width: f64| (s / width).max(-1.0);
        let linear = if share.linear > 0.0 { share.linear * mirrored(near) } else { 0.0 };
        let [first, second] =
            around.profiles.parabola.factors(s / h).map(|factor| share.full * factor);
        let at = if share.full > 0.0 { d1 } else { near };
        let image_points = [(at, first + linear), (d2, second)];
        let across = share.across * mirrored(gap.width.max(0.5 * h));
        self.stencil(image, normal, image_points, across, gap.other)
    }

    /// The cubic extrapolation at the signed distance `s` (m) along a normal, for the cell inside
    /// that has this profile; none where it is too deep or the gap too narrow.
    pub fn cubic(
        &mut self,
        around: &Surroundings<D>,
        image: &Image,
        normal: &Normal,
        s: f64,
        profile: usize,
        own: &Reading,
    ) -> Option<Cubic> {
        let gap = around.gap(&image.centre, normal);
        let clear = around.clear_of_corners(normal, gap.width);
        let s = s / around.profiles.h;
        let gap = gap.width / around.profiles.h;
        // As deep as the first image point is far, it needs no more ghosts than the parabola.
        let shallow = 1.0 - smooth_step(-s, IMAGE_POINT, IMAGE_POINT + BLENDING_WIDTH);
        // Its third image point keeps off what lies across.
        let from = 3.0 * IMAGE_POINT + 0.5 * BLENDING_WIDTH;
        let part = clear * shallow * smooth_step(gap, from, from + BLENDING_WIDTH);
        if part == 0.0 {
            return None;
        }
        let places = [1.0, 2.0, 3.0].map(|n| n * IMAGE_POINT);
        let factors = profile::cubic(s, places)?;
        let image_points: [_; 3] =
            std::array::from_fn(|n| (places[n] * around.profiles.h, part * factors[n]));
        let stencil = self.stencil(image, normal, image_points, 0.0, Other::Nothing);
        let cubic = Reading { stencil, ..*own };
        let added = Vector3::zeros();
        Some(Cubic { cubic, profile: profile as u32, part, added })
    }

    /// The straight profile across a gap, outside at the distance `s` (m) from the surface, and the
    /// flow there that gives way to it; of nothing where none does.
    pub fn profile_across(
        &mut self,
        around: &Surroundings<D>,
        image: &Image,
        normal: &Normal,
        s: f64,
    ) -> Option<(Stencil, GapFlow)> {
        let gap = around.gap(&image.centre, normal);
        let flow = around.flow(gap.width).filter(|_| around.profiles.viscous)?;
        let across = s / gap.width.max(0.5 * around.profiles.h).max(s);
        Some((self.stencil(image, normal, [], across, gap.other), flow))
    }

    /// The slope of the velocity along the outward normal through a point of the surface (1/s).
    pub fn slope(&mut self, around: &Surroundings<D>, image: &Image, normal: &Normal) -> Stencil {
        let h = around.profiles.h;
        let gap = around.gap(&image.centre, normal);
        let share = Shares::of(gap.width / h);
        let e = SLOPE_IMAGE_POINT * h;
        let near = h.min(0.5 * gap.width);
        let [one, two, three] = around.profiles.slope.map(|factor| share.full * factor / h);
        let linear = if share.linear > 0.0 { share.linear / near } else { 0.0 };
        let image_points = [(e, one), (2.0 * e, two), (3.0 * e, three), (near, linear)];
        let across = share.across / gap.width.max(0.5 * h);
        self.stencil(image, normal, image_points, across, gap.other)
    }

    /// A stencil along a normal: the distances of its image points from the surface (m) with their
    /// shares, and the share of what lies across the gap.
    #[inline]
    fn stencil<const N: usize>(
        &mut self,
        image: &Image,
        normal: &Normal,
        image_points: [(f64, f64); N],
        across: f64,
        other: Other,
    ) -> Stencil {
        let first = self.image_points.len() as u32;
        for (d, share) in image_points.into_iter().filter(|(_, share)| *share != 0.0) {
            self.image_points.push(ImagePoint { share, out: normal.out(d) });
        }
        let count = self.image_points.len() as u32 - first;
        let mut stencil = Stencil { first, count, origin: image.origin, ..Stencil::STILL };
        if across != 0.0 && !matches!(other, Other::Nothing) {
            stencil.across = self.across.len() as u32;
            self.across.push(Across { share: across, other, wall: normal.out(0.0) });
        }
        if !normal.central {
            stencil.line = self.lines.len() as u32;
            self.lines.push(normal.line);
        }
        stencil
    }

    /// Hands `take` each of the readings with its value (m/s, or 1/s of a slope). With `limit`, the
    /// speed (m/s) up to which the layer is resolved, and the largest profile there, of the
    /// velocity at the first image point.
    #[inline(always)]
    pub fn values<S: Simd>(
        &self,
        simd: S,
        readings: &[Reading],
        flow: &Flow<impl Velocities, D>,
        limit: Option<(f64, f64)>,
        mut take: impl FnMut(&Reading, Vector3<f64>),
    ) {
        for readings in readings.chunks(MANY) {
            let mut places = [Place::<D>::NONE; MOST * MANY];
            let mut count = 0;
            for Reading { arm, stencil, .. } in readings {
                let ray = self.ray(stencil, arm);
                for image_point in self.image_points_of(stencil) {
                    places[count] = ray.place(image_point.out);
                    count += 1;
                }
            }
            let mut seen = [[0.0; D]; MOST * MANY];
            for (seen, place) in seen.iter_mut().zip(&places[..count]) {
                *seen = place.velocity(simd, flow.grid, flow.u);
            }
            let mut rest = &seen[..count];
            for reading in readings {
                let (own, others) = rest.split_at(reading.stencil.count as usize);
                rest = others;
                take(reading, self.combine(reading, own, flow, limit));
            }
        }
    }

    /// Value of one reading.
    pub fn value(&self, reading: &Reading, flow: &Flow<impl Velocities, D>) -> Vector3<f64> {
        let one = std::slice::from_ref(reading);
        let mut value = Vector3::zeros();
        self.values(pulp::Scalar::new(), one, flow, None, |_, found| value = found);
        value
    }

    /// Value of a reading whose image points have `seen` these velocities (m/s).
    #[inline(always)]
    fn combine(
        &self,
        Reading { arm, stencil, .. }: &Reading,
        seen: &[[f64; D]],
        Flow { boundaries, velocities, k, .. }: &Flow<impl Velocities, D>,
        limit: Option<(f64, f64)>,
    ) -> Vector3<f64> {
        let (rest, turning) = self.rigid(stencil, arm, &velocities(*k));
        let mut sum = Vector3::zeros();
        let mut first = None;
        for (image_point, seen) in self.image_points_of(stencil).iter().zip(seen) {
            let relative = vector(seen) - (rest + image_point.out * turning);
            first.get_or_insert(relative);
            sum += image_point.share * relative;
        }
        if let (Some((limit, largest)), Some(first)) = (limit, first) {
            // first <= limit: the layer is resolved. By squares, as hardly any is limited.
            let first = first.norm_squared();
            let size = sum.norm_squared();
            let factor = if first <= limit * limit { first } else { limit * limit };
            let most = first.max(largest * largest * factor);
            if size > most {
                sum *= (most / size).sqrt();
            }
        }
        let Some(across) = self.across.get(stencil.across as usize) else { return sum };
        let there = across.other.velocity(*velocities, boundaries);
        there.map_or(sum, |there| sum + across.share * (there - (rest + across.wall * turning)))
    }

    /// The largest speed at the image points of a reading, relative to the body (m/s).
    pub fn fastest(
        &self,
        Reading { arm, stencil, .. }: &Reading,
        flow: &Flow<impl Velocities, D>,
    ) -> f64 {
        let (rest, turning) = self.rigid(stencil, arm, &(flow.velocities)(flow.k));
        let ray = self.ray(stencil, arm);
        let speed = |image_point: &ImagePoint| {
            let place = ray.place(image_point.out);
            let there = vector(&place.velocity(pulp::Scalar::new(), flow.grid, flow.u));
            (there - (rest + image_point.out * turning)).norm()
        };
        self.image_points_of(stencil).iter().map(speed).fold(0.0, f64::max)
    }

    #[inline(always)]
    fn image_points_of(&self, stencil: &Stencil) -> &[ImagePoint] {
        &self.image_points[stencil.first as usize..][..stencil.count as usize]
    }

    /// The line of a stencil through the cells.
    #[inline(always)]
    fn ray(&self, stencil: &Stencil, arm: &Vector3<f64>) -> Ray<'_, D> {
        let mut start = self.centre;
        let mut along = [0.0; D];
        let inverse_h = &self.lattice.inverse_h;
        let line = self.lines.get(stencil.line as usize);
        for a in 0..D {
            along[a] = inverse_h[a] * line.map_or(arm[a], |line| line.along[a]);
            start[a] += line.map_or(0.0, |line| inverse_h[a] * line.from[a]);
        }
        Ray { lattice: &self.lattice, origin: stencil.origin, start, along }
    }

    /// The rigid motion of a body along the line of a stencil, as `rest + out turning` (m/s).
    #[inline(always)]
    fn rigid(
        &self,
        stencil: &Stencil,
        arm: &Vector3<f64>,
        body: &RigidVelocity,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let RigidVelocity { velocity, spin } = body;
        match self.lines.get(stencil.line as usize) {
            None => (*velocity, spin.cross(arm)),
            Some(line) => (velocity + spin.cross(&line.from), spin.cross(&line.along)),
        }
    }
}

/// Where a point (m) lies along an axis among the middles of the stored cells (spacings).
fn place<const D: usize>(grid: &Grid<D>, point: &Vector3<f64>, a: usize) -> f64 {
    point[a] / grid.h[a] - 0.5 - grid.start[a] as f64 + grid.ghosts as f64
}

#[inline(always)]
fn vector<const D: usize>(numbers: &[f64; D]) -> Vector3<f64> {
    Vector3::from_fn(|a, _| if a < D { numbers[a] } else { 0.0 })
}
